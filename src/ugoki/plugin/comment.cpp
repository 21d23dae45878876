// Parser of the annotations in comments.

#include <algorithm>
#include <cctype>

#include "ugoki/base/number.h"
#include "ugoki/plugin/comment.h"

namespace ugoki::plugin {
namespace {

/// A line of text that is read from left to right.
class Line {
 public:
  explicit Line(std::string_view text) : text_(text) {}
  void blanks() {
    while (!text_.empty() && std::isspace(static_cast<unsigned char>(text_[0]))) text_.remove_prefix(1);
  }
  /// Skips blanks and then `expected`; false if the text does not continue with it.
  bool take(std::string_view expected) {
    blanks();
    if (!text_.starts_with(expected)) return false;
    text_.remove_prefix(expected.size());
    return true;
  }
  std::string word() {
    blanks();
    std::size_t n = 0;
    while (n < text_.size() && (std::isalnum(static_cast<unsigned char>(text_[n])) || text_[n] == '_' || text_[n] == '-')) ++n;
    std::string out(text_.substr(0, n));
    text_.remove_prefix(n);
    return out;
  }
  bool number(double& value) {
    blanks();
    std::size_t n = 0;
    while (n < text_.size() && !text_.substr(n).starts_with("..") &&
           (std::isdigit(static_cast<unsigned char>(text_[n])) || std::string_view("+-.eE").find(text_[n]) != std::string_view::npos))
      ++n;
    // A full stop after the number ends the sentence: "3." is the number 3.
    while (n > 0 && text_[n - 1] == '.') --n;
    const auto parsed = parse_double(text_.substr(0, n));
    if (!parsed) return false;
    value = *parsed;
    text_.remove_prefix(n);
    return true;
  }
  std::string until(char end) {
    const auto at = text_.find(end);
    std::string out(text_.substr(0, at));
    text_.remove_prefix(at == std::string_view::npos ? text_.size() : at + 1);
    return out;
  }
  std::string rest() {
    blanks();
    std::string out(text_);
    while (!out.empty() && std::isspace(static_cast<unsigned char>(out.back()))) out.pop_back();
    return out;
  }
  [[nodiscard]] std::string_view left() const { return text_; }
  void reset(std::string_view text) { text_ = text; }

 private:
  std::string_view text_;
};

/// True for annotations whose next word is a name.
bool has_name(std::string_view word) {
  return word == "in" || word == "out" || word == "return" || word == "param" || word == "parameter" || word == "state" || word == "dt" ||
         word == "time";
}

std::string trimmed(std::string text) {
  const auto blank = [](char c) { return std::isspace(static_cast<unsigned char>(c)) != 0; };
  text.erase(text.begin(), std::find_if_not(text.begin(), text.end(), blank));
  text.erase(std::find_if_not(text.rbegin(), text.rend(), blank).base(), text.end());
  return text;
}

/// Reads ": type [unit] = value, {choices} low..high" of an annotation; each part may be missing.
void read_details(Line& line, Annotation& a) {
  if (line.take(":")) {
    const std::string_view before = line.left();
    a.type = line.word();
    if (a.type == "joint" && line.take("values")) a.type = "joint values";
    if (a.type.empty()) line.reset(before);
  }
  if (line.take("[")) a.unit = trimmed(line.until(']'));
  if (line.take("=")) {
    if (line.number(a.value))
      a.has_value = true;
    else
      a.word_value = line.word();
    line.take(",");
  }
  if (line.take("{"))
    for (std::string words = line.until('}') + ","; !words.empty();) {
      const auto comma = words.find(',');
      const std::string word = trimmed(words.substr(0, comma));
      if (!word.empty()) a.choices.push_back(word);
      words.erase(0, comma + 1);
    }
  const std::string_view before = line.left();
  double low = 0, high = 0;
  if (line.number(low) && line.take("..") && line.number(high)) {
    a.minimum = low;
    a.maximum = high;
    a.has_range = true;
    line.take(",");
  } else {
    line.reset(before);
  }
  if (line.take("-")) line.blanks();  // skips the '-' before the description, as in "@in x - How far."
}

}  // namespace

Annotation read_annotation(std::string_view text) {
  Annotation a;
  Line line(text);
  a.word = line.word();
  if (has_name(a.word)) {
    // Doxygen writes "@param[in] x".
    if (a.word == "param" && line.take("[")) line.until(']');
    line.blanks();
    const bool unnamed_return = a.word == "return" && !line.left().empty() &&
                                (line.left()[0] == '[' || std::isupper(static_cast<unsigned char>(line.left()[0])) != 0);
    if (!unnamed_return) a.name = line.word();
    read_details(line, a);
  }
  a.doc = line.rest();
  return a;
}

Comment read_comment(const std::vector<std::pair<int, std::string>>& lines) {
  Comment out;
  Annotation* open = nullptr;  // the annotation to which the next line of the comment belongs
  for (const auto& [number, raw] : lines) {
    std::string line = trimmed(raw);
    if (line.size() > 1 && (line[0] == '@' || line[0] == '\\') && std::isalpha(static_cast<unsigned char>(line[1]))) {
      Annotation a = read_annotation(std::string_view(line).substr(1));
      a.line = number;
      if (a.word == "brief") {
        out.doc += (out.doc.empty() ? "" : " ") + a.doc;
        continue;
      }
      const bool may_continue = has_name(a.word);
      out.annotations.push_back(std::move(a));
      open = may_continue ? &out.annotations.back() : nullptr;
    } else if (line.empty()) {
      open = nullptr;
    } else if (open) {
      open->doc += (open->doc.empty() ? "" : " ") + line;
    } else {
      out.doc += (out.doc.empty() ? "" : " ") + line;
    }
  }
  return out;
}

const Annotation* Comment::find(std::string_view word, std::string_view name) const {
  for (const Annotation& a : annotations)
    if (a.word == word && (name.empty() || a.name == name)) return &a;
  return nullptr;
}

}  // namespace ugoki::plugin
