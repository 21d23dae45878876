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

/// What no document of ours has, and what the library would recurse or search too long over: a sentence, or empty.
std::string excess_of(std::string_view text) {
  int depth = 0;
  int commas[max_depth + 1] = {};  // in the open object of each level; lists have as many entries as they like
  bool in_object[max_depth + 1] = {}, in_text = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (in_text) {
      if (c == '\\') ++i;
      if (c == '"') in_text = false;
    } else if (c == '"') {
      in_text = true;
    } else if (c == '{' || c == '[') {
      if (++depth > max_depth) return "Its brackets are nested deeper than " + std::to_string(max_depth) + " levels.";
      in_object[depth] = c == '{';
      commas[depth] = 0;
    } else if (c == '}' || c == ']') {
      if (depth > 0) --depth;
    } else if (c == ',' && in_object[depth] && ++commas[depth] >= max_fields) {
      return "It has an object with more than " + std::to_string(max_fields) + " fields.";
    }
  }
  return {};
}

/// The second of two fields of one name in one object, of which the library would drop one without a word. @param text valid JSON
/// @return the name as it stands there; null: none
std::string_view repeated_field(std::string_view text) {
  std::vector<std::string_view> names;  // of the open objects
  std::vector<std::size_t> first;       // [open objects] in names
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

/// Remembers where the text stops making sense; builds nothing. Without exceptions the library tells it only so.
class FaultFinder : public nlohmann::json_sax<Json> {
 public:
  std::size_t read = 0;  ///< characters up to and with the fault; one more than there are where the text ends too early
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
    read = at;
    return false;
  }
};

/// "name:line"; a name may end with the colon.
std::string place_of(std::string_view name, std::string_view text, std::size_t offset) {
  return std::string(name) + (name.ends_with(':') ? "" : ":") +
         std::to_string(1 + std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(offset), '\n'));
}

std::unexpected<Error> fault(std::string_view text, std::string_view name) {
  FaultFinder finder;
  (void)Json::sax_parse(text.begin(), text.end(), &finder);
  const std::size_t before = std::min(finder.read > 0 ? finder.read - 1 : 0, text.size());
  const std::string place = place_of(name, text, before);
  if (text.empty()) return fail(ErrorCode::truncated, place, "The text is empty, not JSON.", "Give a JSON document.");
  if (finder.read > text.size())
    return fail(ErrorCode::truncated, place, "The JSON text ends too early.", "Close what is open: a quote or a bracket.");
  return fail(ErrorCode::syntax, place, "The text is not valid JSON here.",
              "Look for a missing comma, quote or bracket at this line or the one before.");
}

}  // namespace

Result<Json> parse_json(std::string_view text, std::string_view name, std::size_t max_size) {
  if (text.size() > max_size)
    return fail(ErrorCode::range, std::string(name),
                "The text has " + std::to_string(text.size()) + " bytes, more than the " + std::to_string(max_size) + " allowed.",
                "Make it smaller.");
  if (const std::string excess = excess_of(text); !excess.empty())
    return fail(ErrorCode::range, std::string(name), excess, "No valid document is like that; write it anew.");
  if (const std::size_t zero = text.find('\0'); zero != std::string_view::npos)  // at which the library would stop, content
    return fail(ErrorCode::syntax, place_of(name, text, zero), "A zero byte stands here, as in no JSON text.", "Save it as UTF-8 again.");
  Json json = Json::parse(text.begin(), text.end(), nullptr, false);
  if (json.is_discarded()) return fault(text, name);
  if (const std::string_view field = repeated_field(text); field.data())
    return fail(ErrorCode::duplicate, place_of(name, text, static_cast<std::size_t>(field.data() - text.data())),
                "The field '" + std::string(field.substr(0, 100)) + "' stands in its object twice.", "Remove one of the two.");
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
    problems.push_back({{"code", name_of(p.code)}, {"place", p.place}, {"message", p.message}, {"remedy", p.remedy}});
  return {{"problems", std::move(problems)}};
}

}  // namespace ugoki::json
