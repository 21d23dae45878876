#include "ugoki/content/json_fields.h"

#include <algorithm>
#include <cmath>

#include "ugoki/base/check.h"

namespace ugoki::content {
namespace {

constexpr int max_depth = 64;

/// Line of the byte at which the parser stopped; 0 where it did not say.
std::size_t line_of(std::string_view text, std::size_t byte) {
  return 1 +
         static_cast<std::size_t>(std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(std::min(byte, text.size())), '\n'));
}

/// True if brackets nest deeper than the reader and the writer of JSON should recurse.
bool too_deep(std::string_view text) {
  int depth = 0;
  bool in_text = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (in_text) {
      if (c == '\\') ++i;
      if (c == '"') in_text = false;
    } else if (c == '"') {
      in_text = true;
    } else if (c == '{' || c == '[') {
      if (++depth > max_depth) return true;
    } else if (c == '}' || c == ']') {
      --depth;
    }
  }
  return false;
}

/// Remembers where the text stopped making sense; builds nothing.
class ErrorFinder : public nlohmann::json_sax<Json> {
 public:
  std::size_t position = 0;
  bool null() override { return true; }
  bool boolean(bool) override { return true; }
  bool number_integer(number_integer_t) override { return true; }
  bool number_unsigned(number_unsigned_t) override { return true; }
  bool number_float(number_float_t, const string_t&) override { return true; }
  bool string(string_t&) override { return true; }
  bool binary(binary_t&) override { return true; }
  bool start_object(std::size_t) override { return true; }
  bool key(string_t&) override { return true; }
  bool end_object() override { return true; }
  bool start_array(std::size_t) override { return true; }
  bool end_array() override { return true; }
  bool parse_error(std::size_t at, const std::string&, const nlohmann::detail::exception&) override {
    position = at;
    return false;
  }
};

}  // namespace

Result<Json> parse_json(std::string_view text, std::string_view name, std::size_t max_size) {
  const std::string place(name);
  if (text.size() > max_size)
    return fail(ErrorCode::range, place,
                "The text has " + std::to_string(text.size()) + " bytes, more than the " + std::to_string(max_size) + " allowed.",
                "Make it smaller.");
  if (too_deep(text))
    return fail(ErrorCode::range, place, "Its brackets nest deeper than 64 levels.", "No valid document does; write it anew.");
  Json json = Json::parse(text.begin(), text.end(), nullptr, false);
  if (!json.is_discarded()) return json;
  ErrorFinder finder;
  Json::sax_parse(text.begin(), text.end(), &finder);
  const std::size_t line = line_of(text, finder.position > 0 ? finder.position - 1 : 0);
  return fail(ErrorCode::syntax, place + ":" + std::to_string(line),
              text.empty() ? "The text is empty, not JSON." : "The text is not valid JSON here.",
              "Look for a missing comma, quote or bracket at this line or the one before.");
}

Fields::Fields(const Json& object, std::string path, Error& problems) : object_(object), path_(std::move(path)), problems_(problems) {
  if (!object_.is_object())
    problems_.add(ErrorCode::syntax, path_, "It must be an object, but it is " + std::string(type_of(object_)) + ".",
                  "Write it as { ... }.");
}

bool Fields::has(std::string_view key) const { return object_.is_object() && object_.contains(key); }

const Json* Fields::find(std::string_view key) {
  known_.emplace_back(key);
  if (!object_.is_object()) return nullptr;
  const auto it = object_.find(key);
  return it == object_.end() ? nullptr : &*it;
}

void Fields::wrong(std::string_view key, std::string_view wanted) {
  problems_.add(ErrorCode::syntax, path(key),
                "It must be " + std::string(wanted) + ", but it is " + std::string(type_of(object_.find(key).value())) + ".",
                "Give " + std::string(wanted) + ".");
}

void Fields::number(std::string_view key, double& value) {
  const Json* field = find(key);
  if (!field) return;
  if (!field->is_number()) return wrong(key, "a number");
  const double x = field->get<double>();
  if (!std::isfinite(x)) {
    problems_.add(ErrorCode::range, path(key), "The number is too large.", "Give a finite number.");
    return;
  }
  value = x == 0 ? 0 : x;  // no negative zero: equal documents shall have equal text
}

void Fields::integer(std::string_view key, int& value) {
  double x = value;
  number(key, x);
  if (x != std::floor(x) || std::fabs(x) > 1e9) {
    problems_.add(ErrorCode::range, path(key), "It must be a whole number.", "Give a whole number.");
    return;
  }
  value = static_cast<int>(x);
}

void Fields::boolean(std::string_view key, bool& value) {
  const Json* field = find(key);
  if (!field) return;
  if (!field->is_boolean()) return wrong(key, "true or false");
  value = field->get<bool>();
}

void Fields::text(std::string_view key, std::string& value) {
  const Json* field = find(key);
  if (!field) return;
  if (!field->is_string()) return wrong(key, "a text in quotes");
  value = field->get_ref<const std::string&>();
}

void Fields::vec3(std::string_view key, Vec3& value) {
  const Json* field = find(key);
  if (!field) return;
  if (!field->is_array() || field->size() != 3) return wrong(key, "a list of three numbers");
  Vec3 out;
  for (int i = 0; i < 3; ++i) {
    const Json& x = (*field)[static_cast<std::size_t>(i)];
    if (!x.is_number() || !std::isfinite(x.get<double>())) return wrong(key, "a list of three numbers");
    const double component = x.get<double>();
    out[i] = component == 0 ? 0 : component;
  }
  value = out;
}

void Fields::require(std::string_view key, std::string_view meaning) {
  if (object_.is_object() && !object_.contains(key))
    problems_.add(ErrorCode::structure, path(key), "The field is missing.", "Give " + std::string(meaning) + ".");
}

void Fields::refuse_others() {
  if (!object_.is_object()) return;
  for (const auto& [key, value] : object_.items())
    if (std::find(known_.begin(), known_.end(), key) == known_.end())
      problems_.add(ErrorCode::unknown, path(key), "Nothing has this field here.", "Correct its name or take it out.");
}

std::string_view type_of(const Json& value) {
  switch (value.type()) {
    case Json::value_t::null: return "null";
    case Json::value_t::object: return "an object";
    case Json::value_t::array: return "a list";
    case Json::value_t::string: return "a text";
    case Json::value_t::boolean: return "true or false";
    case Json::value_t::number_integer:
    case Json::value_t::number_unsigned:
    case Json::value_t::number_float: return "a number";
    default: return "not valid JSON";
  }
}

Json to_json(const Vec3& v) { return Json::array({v.x, v.y, v.z}); }

}  // namespace ugoki::content
