#pragma once
// The fields that scenario documents had, so that a test sees which parts of a document random commands have not reached.

#include <set>
#include <string>

#include "ugoki/content/json_fields.h"

namespace ugoki::content::testing {

class FieldNames {
 public:
  /// Notes all fields of a document.
  void add(const Json& document) { add_value("", document); }

  /// True if a document had the field. It is named by its JSON path with '*' for indices, and with the types of the objects that have one:
  /// "events/*/push/force/*".
  [[nodiscard]] bool has(const std::string& path) const { return paths_.contains("/" + path); }

 private:
  void add_value(const std::string& path, const Json& value) {
    if (value.is_array()) {
      for (const Json& item : value) add_value(path + "/*", item);
    } else if (value.is_object()) {
      const bool names_are_data = path.ends_with("/link_colors");  // the user chooses the names
      const bool typed = value.contains("type") && value["type"].is_string() && !path.starts_with("/circuit");
      const std::string own = typed ? path + "/" + value["type"].get<std::string>() : path;
      for (const auto& [name, item] : value.items())
        if (!typed || name != "type") add_value(own + "/" + (names_are_data ? "*" : name), item);
    } else {
      paths_.insert(path);
    }
  }

  std::set<std::string> paths_;
};

}  // namespace ugoki::content::testing
