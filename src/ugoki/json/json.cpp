#include "ugoki/json/json.h"

#include <algorithm>

namespace ugoki::json {
namespace {

std::string_view name_of(ErrorCode code) {
  switch (code) {
    case ErrorCode::syntax: return "syntax";
    case ErrorCode::truncated: return "truncated";
    case ErrorCode::range: return "range";
    case ErrorCode::unknown: return "unknown";
    case ErrorCode::duplicate: return "duplicate";
    case ErrorCode::structure: return "structure";
    case ErrorCode::unsupported: return "unsupported";
    case ErrorCode::io: return "io";
    case ErrorCode::conflict: return "conflict";
    case ErrorCode::cancelled: return "cancelled";
  }
  return "unknown";
}

/// A limit that a text exceeds; `message` is empty if the text exceeds none.
struct ExceededLimit {
  std::size_t offset = 0;  ///< bytes: position in the text at which the limit is exceeded
  std::string message;
};

/// Checks the limits max_depth and max_fields before parsing, because the JSON library recurses per level and searches fields linearly.
ExceededLimit exceeded_limit(std::string_view text) {
  int depth = 0;
  int commas[max_depth + 1] = {};  // [levels] commas so far in the open object of each level; lists have no limit
  bool in_object[max_depth + 1] = {}, in_text = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (in_text) {
      if (c == '\\') ++i;
      if (c == '"') in_text = false;
    } else if (c == '"') {
      in_text = true;
    } else if (c == '{' || c == '[') {
      if (++depth > max_depth) return {i, "The brackets are nested deeper than " + std::to_string(max_depth) + " levels."};
      in_object[depth] = c == '{';
      commas[depth] = 0;
    } else if (c == '}' || c == ']') {
      if (depth > 0) --depth;
    } else if (c == ',' && in_object[depth] && ++commas[depth] >= max_fields) {
      return {i, "An object has more than " + std::to_string(max_fields) + " fields."};
    }
  }
  return {};
}

/// Finds a field name that occurs twice in one object. The JSON library would silently drop one of the two fields.
/// @param text valid JSON
/// @return the second occurrence of the name, a view into `text`; its data() is null if there is none
std::string_view repeated_field(std::string_view text) {
  std::vector<std::string_view> names;  // field names of all open objects
  std::vector<std::size_t> first;       // [open objects] index of the object's first field in `names`
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] == '{') {
      first.push_back(names.size());
    } else if (text[i] == '}') {
      const auto begin = names.begin() + static_cast<std::ptrdiff_t>(first.back());
      std::sort(begin, names.end(), [](std::string_view a, std::string_view b) { return a < b || (a == b && a.data() < b.data()); });
      if (const auto same = std::adjacent_find(begin, names.end()); same != names.end()) return *(same + 1);
      names.erase(begin, names.end());
      first.pop_back();
    } else if (text[i] == '"') {
      const std::size_t from = ++i;
      for (; text[i] != '"'; ++i)
        if (text[i] == '\\') ++i;
      const std::size_t next = text.find_first_not_of(" \t\r\n", i + 1);
      if (next != std::string_view::npos && text[next] == ':') names.push_back(text.substr(from, i - from));
    }
  }
  return {};
}

/// SAX handler that records the position of the first syntax error and builds no value. Without exceptions, the JSON library reports the
/// position only to a SAX handler.
class FaultFinder : public nlohmann::json_sax<Json> {
 public:
  std::size_t read = 0;     ///< bytes read up to and including the error; text size + 1 if the text ends too early
  std::string token;        ///< the last token as read; control characters in it are escaped
  bool unexpected = false;  ///< the token is valid, but not allowed here
  bool overflow = false;    ///< the token is a number too large for a double
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
  bool parse_error(std::size_t at, const std::string& last_token, const nlohmann::detail::exception& error) override {
    constexpr int number_overflow = 406;  // id of the JSON library's error "number overflow"
    read = at;
    token = last_token;
    unexpected = std::string_view(error.what()).contains(" - unexpected ");
    overflow = error.id == number_overflow;
    return false;
  }
};

/// The location "name:line:column" of a byte offset in `text`. Columns count characters from 1. `name` may already end with the colon.
std::string location_of(std::string_view name, std::string_view text, std::size_t offset) {
  const std::string_view before = text.substr(0, offset);
  std::size_t begin = before.rfind('\n') + 1;  // npos + 1 = 0: the first line
  if (begin == 0 && text.starts_with("\xEF\xBB\xBF")) begin = std::min<std::size_t>(3, offset);
  const auto starts_character = [](char c) { return (static_cast<unsigned char>(c) & 0xC0) != 0x80; };
  return std::string(name) + (name.ends_with(':') ? "" : ":") + std::to_string(1 + std::ranges::count(before, '\n')) + ":" +
         std::to_string(1 + std::ranges::count_if(before.substr(begin), starts_character));
}

/// The syntax error of `text` as an error result. @param text not valid JSON
std::unexpected<Error> syntax_error(std::string_view text, std::string_view name) {
  FaultFinder finder;
  (void)Json::sax_parse(text.begin(), text.end(), &finder);
  std::size_t offset = std::min(finder.read > 0 ? finder.read - 1 : 0, text.size());
  if (finder.read > text.size()) {
    const std::string location = location_of(name, text, offset);
    if (text.empty()) return fail(ErrorCode::truncated, location, "The text is empty, not JSON.", "Give a JSON document.");
    return fail(ErrorCode::truncated, location, "The JSON text ends too early.", "Close the open quote or bracket.");
  }
  // Point at the first character of a valid token, and at the last character of an invalid one.
  // After a bracket, comma or colon the library's token still holds the value before it.
  const std::size_t length = finder.token.size();
  const bool is_value = offset < text.size() && std::string_view("{}[],:").find(text[offset]) == std::string_view::npos;
  if ((finder.unexpected || finder.overflow) && is_value && length <= finder.read &&
      text.substr(finder.read - length, length) == finder.token)
    offset = finder.read - length;
  const std::string location = location_of(name, text, offset);
  if (finder.overflow)
    return fail(ErrorCode::range, location, "The number " + finder.token.substr(0, 40) + " is too large; numbers go up to 1.797e308.",
                "Give a smaller number.");
  return fail(ErrorCode::syntax, location, "The text is not valid JSON here.",
              "Look for a missing comma, quote or bracket at this position or before it.");
}

}  // namespace

Result<Json> parse_json(std::string_view text, std::string_view name, std::size_t max_size) {
  if (text.size() > max_size)
    return fail(ErrorCode::range, std::string(name),
                "The text has " + std::to_string(text.size()) + " bytes; at most " + std::to_string(max_size) + " are allowed.",
                "Make it smaller.");
  if (ExceededLimit exceeded = exceeded_limit(text); !exceeded.message.empty())
    return fail(ErrorCode::range, location_of(name, text, exceeded.offset), std::move(exceeded.message),
                "Simplify the document, or check the program that wrote it.");
  // The JSON library would treat a zero byte as the end of the text and ignore the rest.
  if (const std::size_t zero = text.find('\0'); zero != std::string_view::npos)
    return fail(ErrorCode::syntax, location_of(name, text, zero), "The text contains a zero byte, which JSON does not allow.",
                "Save it again as UTF-8.");
  Json json = Json::parse(text.begin(), text.end(), nullptr, false);
  if (json.is_discarded()) return syntax_error(text, name);
  if (const std::string_view field = repeated_field(text); field.data())
    return fail(ErrorCode::duplicate, location_of(name, text, static_cast<std::size_t>(field.data() - text.data())),
                "The field '" + std::string(field.substr(0, 100)) + "' occurs twice in its object.", "Remove one of the two.");
  return json;
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

std::string to_text(const Json& json, int indent) { return json.dump(indent, ' ', false, Json::error_handler_t::replace); }

Json error_json(const Error& error) {
  Json problems = Json::array();
  for (const Problem& p : error.problems)
    problems.push_back({{"code", name_of(p.code)}, {"location", p.location}, {"message", p.message}, {"remedy", p.remedy}});
  return {{"problems", std::move(problems)}};
}

}  // namespace ugoki::json
