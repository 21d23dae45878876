#pragma once
// Writes XML as text. Internal to robot_formats.

#include <string>
#include <string_view>
#include <vector>

#include "ugoki/spatial/spatial.h"

namespace ugoki::robot_formats {

/// An XML document that is written element by element.
class XmlText {
 public:
  /// Opens an element: <name a="..." ...>. `attributes` is empty or begins with a space; see attribute(). Close the element by end().
  void begin(std::string_view name, const std::string& attributes = {});
  void end();
  /// Writes an element without content: <name .../>
  void element(std::string_view name, const std::string& attributes = {});
  [[nodiscard]] std::string take() { return std::move(text_); }

 private:
  void indent() { text_.append(2 * open_.size(), ' '); }
  std::string text_ = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n";
  std::vector<std::string> open_;
};

/// Returns an attribute with a leading space: ` name="value"`. The value is escaped; a number is read back as the same double.
[[nodiscard]] std::string attribute(std::string_view name, std::string_view value);
[[nodiscard]] std::string attribute(std::string_view name, double value);
[[nodiscard]] std::string attribute(std::string_view name, const Vec3& value);
[[nodiscard]] std::string attribute(std::string_view name, const Quat& value);

/// Returns the components, separated by spaces, each as the shortest text that is read back as the same double.
[[nodiscard]] std::string numbers(const Vec3& v);

}  // namespace ugoki::robot_formats
