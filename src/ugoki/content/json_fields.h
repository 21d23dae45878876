#pragma once
// Reading JSON objects field by field with all problems reported by JSON path. Internal to content.

#include <initializer_list>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>

#include "ugoki/base/result.h"
#include "ugoki/spatial/vec3.h"

namespace ugoki::content {

/// Keeps the order of fields, so that what is written is canonical.
using Json = nlohmann::ordered_json;

/// Parses text from outside: at most `max_size` bytes, at most 64 levels deep, valid UTF-8, never throws.
[[nodiscard]] Result<Json> parse_json(std::string_view text, std::string_view name, std::size_t max_size = 64u << 20);

/// One object; absent fields leave their variable alone, wrong ones become problems.
class Fields {
 public:
  /// @param path of the object, for messages
  Fields(const Json& object, std::string path, Error& problems);

  [[nodiscard]] bool has(std::string_view key) const;
  /// The field, or null.
  [[nodiscard]] const Json* find(std::string_view key);
  [[nodiscard]] std::string path(std::string_view key) const { return path_.empty() ? std::string(key) : path_ + "/" + std::string(key); }
  [[nodiscard]] const std::string& path() const { return path_; }
  [[nodiscard]] Error& problems() { return problems_; }

  void number(std::string_view key, double& value);
  void integer(std::string_view key, int& value);
  void boolean(std::string_view key, bool& value);
  void text(std::string_view key, std::string& value);
  void vec3(std::string_view key, Vec3& value);
  /// The field must be there.
  void require(std::string_view key, std::string_view meaning);
  /// Reports every field that was not asked for.
  void refuse_others();

 private:
  void wrong(std::string_view key, std::string_view wanted);

  const Json& object_;
  std::string path_;
  Error& problems_;
  std::vector<std::string> known_;
};

[[nodiscard]] std::string_view type_of(const Json& value);
[[nodiscard]] Json to_json(const Vec3& v);

}  // namespace ugoki::content
