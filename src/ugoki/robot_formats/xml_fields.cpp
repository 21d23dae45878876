#include "ugoki/robot_formats/xml_fields.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "ugoki/base/number.h"

namespace ugoki::robot_formats {
namespace {

constexpr std::string_view blanks = " \t\r\n";
constexpr std::size_t lines_in_a_note = 4;  // maximum number of line numbers in a note

std::string_view trimmed(std::string_view text) {
  const std::size_t begin = text.find_first_not_of(blanks);
  if (begin == std::string_view::npos) return {};
  return text.substr(begin, text.find_last_not_of(blanks) - begin + 1);
}

/// Removes the first token from `rest` and returns it; empty at the end.
std::string_view next_token(std::string_view& rest) {
  rest = trimmed(rest);
  const std::string_view token = rest.substr(0, rest.find_first_of(blanks));
  rest.remove_prefix(token.size());
  return token;
}

std::string remedy_of(pugi::xml_parse_status status) {
  switch (status) {
    case pugi::status_end_element_mismatch: return "Close every element in the order in which they were opened.";
    case pugi::status_bad_attribute: return "Write attributes as name=\"value\".";
    default: return "Check that the file is complete and is XML.";
  }
}

}  // namespace

XmlFields::XmlFields(std::string_view file_name, std::string_view format) : file_(file_name), format_(format), problems_(file_name) {}

bool XmlFields::parse(std::string_view text) {
  if (text.size() > max_text) {
    problem(1, ErrorCode::range, "The file has more than " + std::to_string(max_text >> 20) + " MB of text.", "Give a smaller file.");
    return false;
  }
  const std::optional<std::string_view> plain = formats::plain_text(text, format_, problems_);
  if (!plain) return false;
  buffer_ = *plain;
  line_starts_ = {0};
  for (std::size_t i = 0; i < buffer_.size(); ++i)
    if (buffer_[i] == '\n' || (buffer_[i] == '\r' && (i + 1 == buffer_.size() || buffer_[i + 1] != '\n'))) line_starts_.push_back(i + 1);

  constexpr unsigned flags = pugi::parse_escapes | pugi::parse_eol | pugi::parse_wconv_attribute | pugi::parse_cdata | pugi::parse_doctype;
  const pugi::xml_parse_result result = document_.load_buffer_inplace(buffer_.data(), buffer_.size(), flags, pugi::encoding_utf8);
  if (!result) {
    if (result.status == pugi::status_no_document_element)
      problem(1, ErrorCode::syntax, "The file has no XML element.", "Check that the file is " + format_ + " and is complete.");
    else
      problem(line_at(buffer_.data() + std::min(static_cast<std::size_t>(result.offset), buffer_.size())), ErrorCode::syntax,
              "The text is not valid XML (" + std::string(result.description()) + ").", remedy_of(result.status));
    return false;
  }
  return check_tree();
}

/// Reports valid XML that this module refuses: several outermost elements, user-defined entities, duplicate attributes, deep nesting.
bool XmlFields::check_tree() {
  int outermost = 0;
  for (const pugi::xml_node node : document_.children()) {
    if (node.type() == pugi::node_doctype && std::string_view(node.value()).find("<!ENTITY") != std::string_view::npos)
      problem(1, ErrorCode::unsupported, "The file defines its own XML entities.", "Replace each entity by its text.");
    if (node.type() == pugi::node_element && ++outermost == 2)
      problem(node, ErrorCode::syntax, "There is a second outermost element.", "Put all elements into one.");
  }
  std::array<std::string_view, max_attributes> names;
  int level = 1;
  for (pugi::xml_node node = root(); node && !full();) {
    std::size_t count = 0;
    for (const pugi::xml_attribute a : node.attributes()) {
      if (count == names.size()) {
        problem(node, ErrorCode::range, "An element has more than " + std::to_string(max_attributes) + " attributes.",
                "Remove some of them.");
        return false;
      }
      const std::string_view name = a.name();
      if (std::find(names.begin(), names.begin() + static_cast<std::ptrdiff_t>(count), name) !=
          names.begin() + static_cast<std::ptrdiff_t>(count))
        problem(line(a), ErrorCode::duplicate, "The attribute " + formats::in_quotes(name) + " appears twice in one element.",
                "Remove one of them.");
      names[count++] = name;
    }
    if (node.first_child()) {
      if (++level > max_levels) {
        problem(node, ErrorCode::range, "Elements are nested deeper than " + std::to_string(max_levels) + " levels.", "Use fewer levels.");
        return false;
      }
      node = node.first_child();
      continue;
    }
    while (node != root() && !node.next_sibling()) {
      node = node.parent();
      --level;
    }
    if (node == root()) break;
    node = node.next_sibling();
  }
  return !failed();
}

int XmlFields::line_at(const char* in_buffer) const {
  const auto at = reinterpret_cast<std::uintptr_t>(in_buffer), begin = reinterpret_cast<std::uintptr_t>(buffer_.data());
  if (at < begin || at > begin + buffer_.size()) return 1;  // an empty name does not point into the buffer, so its line is unknown
  const auto after = std::upper_bound(line_starts_.begin(), line_starts_.end(), static_cast<std::size_t>(at - begin));
  return static_cast<int>(after - line_starts_.begin());
}

int XmlFields::line(pugi::xml_node node) const { return line_at(node.type() == pugi::node_element ? node.name() : node.value()); }
int XmlFields::line(pugi::xml_attribute attribute) const { return line_at(attribute.name()); }

std::string XmlFields::location(pugi::xml_node node) const { return file_ + ":" + std::to_string(line(node)); }

std::string XmlFields::title(pugi::xml_node node) const {
  std::string out = "<" + std::string(std::string_view(node.name()).substr(0, 40)) + ">";
  if (const pugi::xml_attribute name = node.attribute("name")) out += " " + formats::in_quotes(name.value());
  return out;
}

void XmlFields::problem(int line, ErrorCode code, std::string message, std::string remedy) {
  problems_.add(code, line, std::move(message), std::move(remedy));
}
void XmlFields::problem(pugi::xml_node node, ErrorCode code, std::string message, std::string remedy) {
  problem(line(node), code, std::move(message), std::move(remedy));
}

void XmlFields::problem(const XmlField& field, ErrorCode code, const std::string& message, std::string remedy) {
  problem(line(field), code, describe(field) + message, std::move(remedy));
}

void XmlFields::note(pugi::xml_node node, std::string sentence) {
  const auto [it, is_new] = note_index_.emplace(std::move(sentence), notes_.size());
  if (is_new) notes_.push_back({it->first, {}, 0});
  Note& n = notes_[it->second];
  ++n.count;
  if (node && n.lines.size() < lines_in_a_note) n.lines.push_back(line(node));
}
void XmlFields::note(std::string sentence) { note(pugi::xml_node(), std::move(sentence)); }

std::vector<std::string> XmlFields::take_notes() {
  const std::string short_name = file_.substr(file_.find_last_of("/\\") + 1);
  std::vector<std::string> out;
  for (Note& n : notes_) {
    std::string text = std::move(n.sentence);
    for (std::size_t i = 0; i < n.lines.size(); ++i) text += (i == 0 ? " (" + short_name + ":" : ", ") + std::to_string(n.lines[i]);
    if (n.count > n.lines.size() && !n.lines.empty()) text += " and " + std::to_string(n.count - n.lines.size()) + " more";
    out.push_back(n.lines.empty() ? text : text + ")");
  }
  notes_.clear();
  note_index_.clear();
  return out;
}

void XmlFields::note_unread(pugi::xml_node node, std::initializer_list<std::string_view> known) {
  for (const pugi::xml_node child : node.children())
    if (child.type() == pugi::node_element && std::find(known.begin(), known.end(), child.name()) == known.end())
      note(child, "<" + std::string(std::string_view(child.name()).substr(0, 40)) + "> in <" +
                      std::string(std::string_view(node.name()).substr(0, 40)) + "> is not read.");
}

XmlField XmlFields::attribute(pugi::xml_node node, const char* name) const {
  const pugi::xml_attribute a = node.attribute(name);
  return {trimmed(a.value()), static_cast<bool>(a), node, a, name};
}

XmlField XmlFields::element(pugi::xml_node node, const char* name) const {
  const pugi::xml_node child = node.child(name);
  return {trimmed(child.child_value()), static_cast<bool>(child), node, {}, name};
}

XmlField XmlFields::content(pugi::xml_node node) const { return {trimmed(node.child_value()), static_cast<bool>(node), node, {}, ""}; }

int XmlFields::line(const XmlField& field) const {
  if (field.attribute) return line(field.attribute);
  const pugi::xml_node child = *field.name ? field.node.child(field.name) : field.node;
  return line(child ? child : field.node);
}

std::string XmlFields::describe(const XmlField& field) const {
  if (!*field.name) return title(field.node);
  const bool is_attribute = field.attribute || !field.node.child(field.name);
  return (is_attribute ? "'" + std::string(field.name) + "'" : "<" + std::string(field.name) + ">") + " of " + title(field.node);
}

std::string XmlFields::text(const XmlField& field) const { return formats::utf8(field.text); }

std::string XmlFields::required_text(const XmlField& field) {
  if (field.text.empty()) problem(field, ErrorCode::syntax, field.present ? " is empty." : " is missing.", "Add a value.");
  return text(field);
}

std::optional<double> XmlFields::one_number(const XmlField& field, std::string_view token, Bounds bounds) {
  const std::optional<double> value = formats::measured_number(token);
  if (!value) {
    formats::NumberFault fault = formats::number_fault(token);
    problem(field, fault.code, ": " + fault.message, std::move(fault.remedy));
    return std::nullopt;
  }
  if (!(*value >= bounds.low && *value <= bounds.high)) {
    problem(field, ErrorCode::range, ": " + formats::in_quotes(token) + " is out of range.",
            "Give a number between " + to_text(bounds.low) + " and " + to_text(bounds.high) + ".");
    return std::nullopt;
  }
  return value;
}

double XmlFields::number(const XmlField& field, double fallback, Bounds bounds) {
  return field.present ? one_number(field, field.text, bounds).value_or(fallback) : fallback;
}

double XmlFields::limit(const XmlField& field, double fallback) {
  constexpr double none = std::numeric_limits<double>::infinity();
  if (!field.present) return fallback;
  for (const std::string_view word : {"inf", "+inf", "infinity", "+infinity"})
    if (formats::equal_ignoring_case(field.text, word)) return none;
  for (const std::string_view word : {"-inf", "-infinity"})
    if (formats::equal_ignoring_case(field.text, word)) return -none;
  if (const std::optional<double> value = parse_double(field.text); value && std::fabs(*value) >= formats::max_magnitude)
    return *value > 0 ? none : -none;
  return one_number(field, field.text, {}).value_or(fallback);
}

int XmlFields::integer(const XmlField& field, int fallback, int low, int high) {
  if (!field.present) return fallback;
  const std::optional<long> value = parse_long(field.text);
  if (value && *value >= low && *value <= high) return static_cast<int>(*value);
  problem(field, value ? ErrorCode::range : ErrorCode::syntax,
          ": " + formats::in_quotes(field.text) + (value ? " is out of range." : " is not an integer."),
          "Give an integer between " + std::to_string(low) + " and " + std::to_string(high) + ".");
  return fallback;
}

bool XmlFields::flag(const XmlField& field, bool fallback) {
  if (!field.present) return fallback;
  if (field.text == "1" || formats::equal_ignoring_case(field.text, "true")) return true;
  if (field.text == "0" || formats::equal_ignoring_case(field.text, "false")) return false;
  problem(field, ErrorCode::syntax, ": " + formats::in_quotes(field.text) + " is neither true nor false.", "Write true or false.");
  return fallback;
}

std::vector<double> XmlFields::list(const XmlField& field, std::size_t minimum, std::size_t maximum, Bounds bounds) {
  std::vector<double> out;
  if (!field.present) return out;
  std::string_view rest = field.text;
  std::size_t count = 0;
  for (std::string_view token = next_token(rest); !token.empty() && count <= maximum; token = next_token(rest), ++count) {
    if (count == maximum) continue;
    const std::optional<double> value = one_number(field, token, bounds);
    if (!value) return {};
    out.push_back(*value);
  }
  if (count >= minimum && count <= maximum) return out;
  const std::string wanted = minimum == maximum ? std::to_string(minimum) : std::to_string(minimum) + " to " + std::to_string(maximum);
  problem(field, ErrorCode::syntax, std::string(count > maximum ? " has more than " : " has fewer than ") + wanted + " numbers.",
          "Give " + wanted + " numbers, separated by spaces.");
  return {};
}

bool XmlFields::numbers(const XmlField& field, std::span<double> out, Bounds bounds) {
  const std::vector<double> values = list(field, out.size(), out.size(), bounds);
  if (values.size() != out.size()) return false;
  std::copy(values.begin(), values.end(), out.begin());
  return true;
}

Vec3 XmlFields::vec3(const XmlField& field, const Vec3& fallback, Bounds bounds) {
  double v[3];
  return numbers(field, v, bounds) ? Vec3{v[0], v[1], v[2]} : fallback;
}

Vec3 XmlFields::direction(const XmlField& field, const Vec3& fallback) {
  const Vec3 v = vec3(field, fallback);
  const double length = norm(v);
  if (length >= 1e-9) return v / length;
  problem(field, ErrorCode::structure, " has zero length.", "Give a vector that is not zero.");
  return fallback;
}

}  // namespace ugoki::robot_formats
