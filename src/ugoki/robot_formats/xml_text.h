#pragma once
// XML as text; internal to robot_formats.

#include <string>
#include <string_view>
#include <vector>

#include "ugoki/spatial/spatial.h"

namespace ugoki::robot_formats {

/// An XML text that grows element by element.
class XmlText {
 public:
  /// <name a="..." ...> ; attributes as text with a leading blank (see attribute()). Closed by end().
  void begin(std::string_view name, const std::string& attributes = {});
  void end();
  /// <name .../>
  void element(std::string_view name, const std::string& attributes = {});
  [[nodiscard]] std::string take() { return std::move(text_); }

 private:
  void indent() { text_.append(2 * open_.size(), ' '); }
  std::string text_ = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n";
  std::vector<std::string> open_;
};

/// ` name="value"`, escaped.
[[nodiscard]] std::string attribute(std::string_view name, std::string_view value);
[[nodiscard]] std::string attribute(std::string_view name, double value);
[[nodiscard]] std::string attribute(std::string_view name, const Vec3& value);
[[nodiscard]] std::string attribute(std::string_view name, const Quat& value);

/// The shortest texts that give back the same bits, separated by blanks.
[[nodiscard]] std::string numbers(const Vec3& v);

}  // namespace ugoki::robot_formats
