#include "ugoki/json/fields.h"

#include <algorithm>
#include <cmath>

namespace ugoki::json {

Fields::Fields(const Json& object, std::string path, Error& problems) : object_(object), path_(std::move(path)), problems_(problems) {
  if (!object_.is_object()) wrong(path_.ends_with(':') ? path_ + "/" : path_, object_, "an object { ... }");
}

bool Fields::has(std::string_view key) const { return object_.is_object() && object_.contains(key); }

std::string_view Fields::renamed(std::string_view key, std::string_view former) const { return !has(key) && has(former) ? former : key; }

const Json* Fields::find(std::string_view key) {
  if (std::ranges::find(known_, key) == known_.end()) known_.emplace_back(key);
  if (!object_.is_object()) return nullptr;
  const auto it = object_.find(key);
  return it == object_.end() ? nullptr : &*it;
}

std::string Fields::path(std::string_view key) const {
  return path_ + (path_.empty() || path_.ends_with(':') ? "" : "/") + std::string(key);
}

void Fields::report(ErrorCode code, std::string path, std::string message, std::string remedy) {
  if (problems_.problems.size() < max_problems) problems_.add(code, std::move(path), std::move(message), std::move(remedy));
}

void Fields::wrong(const std::string& path, const Json& value, std::string_view wanted) {
  report(ErrorCode::syntax, path, "The value must be " + std::string(wanted) + ", but is " + std::string(type_of(value)) + ".",
         "Give " + std::string(wanted) + ".");
}

void Fields::number(std::string_view key, double& value) {
  const Json* field = find(key);
  if (!field) return;
  if (!field->is_number()) return wrong(path(key), *field, "a number");
  value = field->get<double>();  // finite: the parser rejects numbers too large for a double
}

void Fields::integer(std::string_view key, int& value) {
  double x = value;
  number(key, x);
  if (x != std::floor(x) || std::fabs(x) > 1e9) {
    report(ErrorCode::range, path(key), "The value must be a whole number of at most 1e9 in magnitude.", "Give a whole number.");
    return;
  }
  value = static_cast<int>(x);
}

void Fields::boolean(std::string_view key, bool& value) {
  const Json* field = find(key);
  if (!field) return;
  if (!field->is_boolean()) return wrong(path(key), *field, "true or false");
  value = field->get<bool>();
}

void Fields::text(std::string_view key, std::string& value) {
  const Json* field = find(key);
  if (!field) return;
  if (!field->is_string()) return wrong(path(key), *field, "a text in quotes");
  value = field->get_ref<const std::string&>();
}

bool Fields::numbers(std::string_view key, std::span<double> values) {
  const Json* field = find(key);
  return field && numbers(*field, path(key), values);
}

bool Fields::numbers(const Json& value, const std::string& path, std::span<double> values) {
  if (!value.is_array() || value.size() != values.size() || !std::ranges::all_of(value, [](const Json& x) { return x.is_number(); })) {
    report(ErrorCode::syntax, path, "The value must be a list of " + std::to_string(values.size()) + " numbers.",
           "Write " + std::to_string(values.size()) + " numbers between [ and ].");
    return false;
  }
  for (std::size_t i = 0; i < values.size(); ++i) values[i] = value[i].get<double>();
  return true;
}

const Json* Fields::list(std::string_view key, std::size_t max_entries, std::string_view entries) {
  const Json* field = find(key);
  if (!field) return nullptr;
  if (!field->is_array()) {
    wrong(path(key), *field, "a list [ ... ]");
    return nullptr;
  }
  if (field->size() <= max_entries) return field;
  report(ErrorCode::range, path(key),
         "The list has " + std::to_string(field->size()) + " " + std::string(entries) + "; at most " + std::to_string(max_entries) +
             " are allowed.",
         "Remove some of them.");
  return nullptr;
}

void Fields::require(std::string_view key, std::string_view meaning) {
  if (object_.is_object() && !object_.contains(key))
    report(ErrorCode::structure, path(key), "The field is missing.", "Give " + std::string(meaning) + ".");
}

void Fields::refuse_others() {
  if (!object_.is_object()) return;
  std::string known;
  for (const std::string& key : known_) known += (known.empty() ? "" : ", ") + key;
  for (const auto& [key, value] : object_.items())
    if (std::ranges::find(known_, key) == known_.end())
      report(ErrorCode::unknown, path(std::string_view(key).substr(0, 64)), "The field is unknown.",
             "Correct its name or remove it; the known fields are " + known + ".");
}

}  // namespace ugoki::json
