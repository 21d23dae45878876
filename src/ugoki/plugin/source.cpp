#include "ugoki/plugin/source.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <optional>

#include "ugoki/base/number.h"
#include "ugoki/plugin/comment.h"

namespace ugoki::plugin {
namespace {

enum class Kind { word, number, text, sign, comment };  // text: a literal in quotes
struct Token {
  Kind kind = Kind::sign;
  std::string text;
  int line = 0;       ///< line on which the token begins, from 1
  int last_line = 0;  ///< differs from `line` for comments of several lines
};

bool is_word(char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_'; }

/// Splits the text into tokens. Preprocessor lines are skipped.
std::vector<Token> tokens_of(std::string_view text) {
  std::vector<Token> out;
  int line = 1;
  bool line_begins = true;
  std::size_t i = 0;
  const auto at = [&](std::size_t k) { return k < text.size() ? text[k] : '\0'; };
  while (i < text.size()) {
    const char c = text[i];
    if (c == '\n') {
      ++line;
      line_begins = true;
      ++i;
    } else if (std::isspace(static_cast<unsigned char>(c)) != 0) {
      ++i;
    } else if (c == '#' && line_begins) {
      while (i < text.size() && text[i] != '\n') {
        if (text[i] == '\\' && at(i + 1) == '\n') {
          ++line;
          ++i;
        }
        ++i;
      }
    } else if (c == '/' && (at(i + 1) == '/' || at(i + 1) == '*')) {
      const bool block = at(i + 1) == '*';
      const std::size_t end = block ? text.find("*/", i + 2) : text.find('\n', i);
      const std::size_t stop = end == std::string_view::npos ? text.size() : end;
      Token t{Kind::comment, std::string(text.substr(i, stop - i)), line, line};
      line += static_cast<int>(std::count(t.text.begin(), t.text.end(), '\n'));
      t.last_line = line;
      out.push_back(std::move(t));
      i = block && stop < text.size() ? stop + 2 : stop;
    } else if (c == '"' || c == '\'') {
      std::size_t k = i + 1;
      while (k < text.size() && text[k] != c && text[k] != '\n') k += text[k] == '\\' ? 2 : 1;
      k = std::min(k + 1, text.size());
      out.push_back({Kind::text, std::string(text.substr(i, k - i)), line, line});
      i = k;
      line_begins = false;
    } else if (is_word(c)) {
      std::size_t k = i;
      while (k < text.size() && (is_word(text[k]) || (std::isdigit(static_cast<unsigned char>(c)) != 0 && text[k] == '.'))) ++k;
      out.push_back(
          {std::isdigit(static_cast<unsigned char>(c)) != 0 ? Kind::number : Kind::word, std::string(text.substr(i, k - i)), line, line});
      i = k;
      line_begins = false;
    } else {
      const bool two = (c == ':' && at(i + 1) == ':');
      out.push_back({Kind::sign, std::string(text.substr(i, two ? 2 : 1)), line, line});
      i += two ? 2 : 1;
      line_begins = false;
    }
  }
  return out;
}

/// Appends the lines of one comment as (line number, text), without the slashes and stars in front.
void add_lines(const Token& comment, std::vector<std::pair<int, std::string>>& lines) {
  int number = comment.line;
  std::string_view left = comment.text;
  while (!left.empty()) {
    const auto end = left.find('\n');
    std::string_view line = left.substr(0, end);
    left.remove_prefix(end == std::string_view::npos ? left.size() : end + 1);
    const auto first = line.find_first_not_of(" \t");
    line.remove_prefix(first == std::string_view::npos ? line.size() : first);
    while (!line.empty() && (line[0] == '/' || line[0] == '*' || line[0] == '!' || line[0] == '<')) line.remove_prefix(1);
    lines.emplace_back(number++, std::string(line));
  }
}

/// Words of which the names of the arithmetic types of C consist.
constexpr std::array<std::string_view, 23> number_words = {"double",   "float",     "int",      "long",      "short",    "char",
                                                           "signed",   "unsigned",  "bool",     "_Bool",     "size_t",   "int8_t",
                                                           "int16_t",  "int32_t",   "int64_t",  "uint8_t",   "uint16_t", "uint32_t",
                                                           "uint64_t", "ptrdiff_t", "intptr_t", "uintptr_t", "real"};

/// Finds functions with bodies and structs, also inside of namespaces and extern "C" blocks.
class Parser {
 public:
  Parser(std::vector<Token> tokens, bool cpp) : tokens_(std::move(tokens)), cpp_(cpp) {}

  CSource read() {
    for (const Token& t : tokens_) {
      if (t.kind != Kind::word) continue;
      source_.declares_library = source_.declares_library || t.text == "UGOKI_LIBRARY" || t.text == "ugoki_lsi_library";
      source_.declares_lsis = source_.declares_lsis || t.text == "UGOKI_LSI";
    }
    read_file_comment();
    scope({});
    return std::move(source_);
  }

 private:
  [[nodiscard]] bool more() const { return at_ < tokens_.size(); }
  [[nodiscard]] bool is(std::size_t i, std::string_view text) const { return i < tokens_.size() && tokens_[i].text == text; }

  /// The comment at the start of the file, up to the first empty line.
  void read_file_comment() {
    std::vector<std::pair<int, std::string>> lines;
    for (const Token& t : tokens_) {
      if (t.kind != Kind::comment || (!lines.empty() && t.line > lines.back().first + 1)) break;
      add_lines(t, lines);
    }
    source_.file = read_comment(lines);
  }

  /// Reads declarations up to the bracket that closes the scope. @param prefix namespaces in front of all names: "signals::"
  void scope(const std::string& prefix) {
    std::vector<std::pair<int, std::string>> comment;
    int comment_end = -1;
    while (more()) {
      const Token& t = tokens_[at_];
      if (t.kind == Kind::comment) {
        if (t.line > comment_end + 1) comment.clear();
        add_lines(t, comment);
        comment_end = t.last_line;
        ++at_;
        continue;
      }
      if (t.text == "}") {
        ++at_;
        return;
      }
      if (t.text == ";") {
        ++at_;
        comment.clear();
        continue;
      }
      if (t.line > comment_end + 2) comment.clear();  // after more than one empty line, the comment does not belong to this declaration
      declaration(prefix, comment);
      comment.clear();
    }
  }

  /// Index of the token after the bracket that closes the bracket at index i; the number of tokens if there is none.
  [[nodiscard]] std::size_t behind(std::size_t i) const {
    int depth = 0;
    for (; i < tokens_.size(); ++i) {
      const std::string& s = tokens_[i].text;
      if (tokens_[i].kind != Kind::sign) continue;
      if (s == "(" || s == "{" || s == "[") ++depth;
      if (s == ")" || s == "}" || s == "]") --depth;
      if (depth == 0) return i + 1;
    }
    return tokens_.size();
  }

  /// Reads one declaration and advances to the token after it.
  void declaration(const std::string& prefix, const std::vector<std::pair<int, std::string>>& comment) {
    const std::size_t begin = at_;
    if (tokens_[at_].text == "namespace" ||
        (tokens_[at_].text == "extern" && at_ + 1 < tokens_.size() && tokens_[at_ + 1].kind == Kind::text)) {
      std::string name;
      for (++at_; more() && tokens_[at_].text != "{" && tokens_[at_].text != ";"; ++at_)
        if (tokens_[at_].kind == Kind::word || tokens_[at_].text == "::") name += tokens_[at_].text;
      if (tokens_[begin].text == "extern" && (!more() || tokens_[at_].text != "{")) return;
      ++at_;
      const bool named = tokens_[begin].text == "namespace" && !name.empty();
      scope(named ? prefix + name + "::" : prefix);
      return;
    }
    // Find the end of the declaration: its first body in braces, or the semicolon.
    std::size_t end = begin;
    std::size_t parameters = 0, body = 0;
    while (end < tokens_.size()) {
      const Token& t = tokens_[end];
      if (t.kind == Kind::sign && t.text == "(") {
        if (parameters == 0) parameters = end;
        end = behind(end);
        continue;
      }
      if (t.kind == Kind::sign && t.text == "[") {
        end = behind(end);
        continue;
      }
      if (t.kind == Kind::sign && t.text == "{") {
        body = end;
        end = behind(end);
        break;
      }
      if (t.kind == Kind::sign && t.text == ";") break;
      ++end;
    }
    const bool is_type = is_struct(begin);
    if (body && is_type && (parameters == 0 || parameters > body)) {
      read_struct(begin, body, end, prefix);
      while (end < tokens_.size() && tokens_[end].text != ";") ++end;
    } else if (body && parameters && parameters < body) {
      read_function(begin, parameters, prefix, comment);
    }
    at_ = std::max(end, begin + 1);
  }

  [[nodiscard]] bool is_struct(std::size_t i) const {
    return is(i, "struct") || (is(i, "typedef") && is(i + 1, "struct")) || (cpp_ && is(i, "class"));
  }

  /// Reads a struct. The parameters are indices of tokens: `begin` the first word, `body` the '{', `end` the token behind '}'.
  void read_struct(std::size_t begin, std::size_t body, std::size_t end, const std::string& prefix) {
    CStruct s;
    s.line = tokens_[begin].line;
    std::string tag;
    for (std::size_t i = begin; i < body; ++i)
      if (tokens_[i].kind == Kind::word && tokens_[i].text != "struct" && tokens_[i].text != "typedef" && tokens_[i].text != "class" &&
          tag.empty())
        tag = tokens_[i].text;
    const bool is_typedef = is(begin, "typedef");
    std::string alias;
    if (is_typedef && end < tokens_.size() && tokens_[end].kind == Kind::word) alias = tokens_[end].text;
    if (!tag.empty()) {
      s.name = "struct " + tag;
      s.alias = !alias.empty() ? alias : cpp_ ? tag : "";
    } else {
      s.name = alias;
    }
    s.full = !cpp_ ? s.name : prefix + (tag.empty() ? alias : tag);
    std::size_t i = body + 1;
    while (i + 1 < end) {
      if (tokens_[i].kind == Kind::comment) {
        if (!s.fields.empty() && tokens_[i].line == s.fields.back().line) {
          std::vector<std::pair<int, std::string>> lines;
          add_lines(tokens_[i], lines);
          if (!lines.empty()) s.fields.back().comment = lines[0].second;
        }
        ++i;
        continue;
      }
      std::size_t stop = i;
      bool method = false;
      while (stop + 1 < end && tokens_[stop].text != ";") {
        const std::string& t = tokens_[stop].text;
        if (t == "(") method = true;
        if (t == "(" || t == "[") {
          stop = behind(stop);
          continue;
        }
        if (t == "{") {
          stop = behind(stop);
          if (method) break;
          continue;
        }
        if (t == ":" && stop == i + 1) break;  // "public:"
        ++stop;
      }
      if (is(stop, ":")) {
        i = stop + 1;
        continue;
      }
      if (!method) add_fields(s, i, stop);
      i = std::max(stop + (is(stop, ";") ? 1 : 0), i + 1);
    }
    if (!s.name.empty()) source_.structs.push_back(std::move(s));
  }

  /// Adds the fields of one declaration: "double x = 1, y[3];".
  void add_fields(CStruct& s, std::size_t begin, std::size_t end) {
    if (is(begin, "static") || is(begin, "using") || is(begin, "friend") || is(begin, "enum")) return;
    std::optional<CType> base;
    std::size_t first = begin;
    for (std::size_t i = begin; i <= end; ++i) {
      if (i < end && !is(i, ",")) {
        if (is(i, "[") || is(i, "(") || is(i, "{")) i = behind(i) - 1;
        continue;
      }
      CVariable v = variable(first, i);
      if (!base) {
        base = v.type;
        base->elements = 0;
      } else {
        const int elements = v.type.elements;
        v.type = *base;
        v.type.elements = elements;
      }
      if (!v.type.numeric() || v.type.pointers > 0 || v.name.empty()) s.understood = false;
      s.fields.push_back(std::move(v));
      first = i + 1;
    }
  }

  /// Type, name and initial value of the variable that tokens [begin, end) declare.
  [[nodiscard]] CVariable variable(std::size_t begin, std::size_t end) const {
    CVariable v;
    v.line = begin < tokens_.size() ? tokens_[begin].line : 0;
    std::vector<std::string> words;
    std::size_t i = begin;
    bool is_unknown = false;  // the type contains tokens that this parser does not know
    for (; i < end; ++i) {
      const Token& t = tokens_[i];
      if (t.kind == Kind::comment) continue;
      if (t.text == "=" || t.text == "{") break;
      if (t.kind == Kind::word || t.text == "::") {
        if (t.text == "const" || t.text == "constexpr") {
          v.type.is_const = true;
        } else if (t.text == "::" && !words.empty()) {
          words.back() += "::";
        } else if (!words.empty() && words.back().ends_with("::")) {
          words.back() += t.text;
        } else if (t.text != "restrict" && t.text != "__restrict" && t.text != "volatile" && t.text != "static" && t.text != "inline" &&
                   t.text != "extern") {
          words.push_back(t.text);
        }
      } else if (t.text == "*") {
        ++v.type.pointers;
      } else if (t.text == "&") {
        ++v.type.pointers;
        v.type.reference = true;
      } else if (t.text == "[") {
        const auto n = i + 1 < end ? parse_long(tokens_[i + 1].text) : std::nullopt;
        if (n && *n > 0 && *n < 1000000 && is(i + 2, "]"))
          v.type.elements = v.type.elements ? -1 : static_cast<int>(*n);
        else if (is(i + 1, "]"))
          ++v.type.pointers;
        else
          is_unknown = true;
        i = behind(i) - 1;
      } else {
        is_unknown = true;
      }
    }
    if (v.type.elements < 0) is_unknown = true;
    if (i < end && (is(i, "=") || is(i, "{"))) {
      for (std::size_t k = i + 1; k < end; ++k)
        if (!is(k, "}")) v.initial += tokens_[k].text;
    }
    if (words.size() > 1 && !is_number_word(words.back())) {
      v.name = words.back();
      words.pop_back();
    }
    for (std::size_t k = begin; k < std::min(i, end); ++k)
      if (tokens_[k].kind != Kind::comment && tokens_[k].text != v.name) v.type.text += (v.type.text.empty() ? "" : " ") + tokens_[k].text;
    if (!is_unknown)
      for (const std::string& w : words) v.type.base += (v.type.base.empty() ? "" : " ") + (w.starts_with("std::") ? w.substr(5) : w);
    return v;
  }

  static bool is_number_word(std::string_view word) {
    return std::find(number_words.begin(), number_words.end(), word) != number_words.end();
  }

  /// Reads a function. @param begin index of its first token @param open index of the '(' before its parameters
  void read_function(std::size_t begin, std::size_t open, const std::string& prefix,
                     const std::vector<std::pair<int, std::string>>& comment) {
    if (open == begin || tokens_[open - 1].kind != Kind::word) return;
    CFunction f;
    f.line = tokens_[begin].line;
    for (std::size_t i = begin; i < open; ++i) {
      const std::string& t = tokens_[i].text;
      if (t == "template" || t == "operator" || t == "typedef" || t == "=" || t == "~") return;
      if (t == "static") f.is_static = true;
    }
    const std::string name = tokens_[open - 1].text;
    if (is(open - 2, "::") || name == "main" || name == "UGOKI_LSI" || name == "UGOKI_LIBRARY") return;
    f.name = prefix + name;
    f.result = variable(begin, open).type;
    // Read the tokens in front of '(' as a variable: its type is the result type, its name is the function's name.
    const std::size_t close = behind(open) - 1;
    std::size_t first = open + 1;
    for (std::size_t i = first; i <= close; ++i) {
      if (i < close && !is(i, ",")) {
        if (is(i, "(") || is(i, "[") || is(i, "{")) i = behind(i) - 1;
        continue;
      }
      const bool is_empty = first == close || (first + 1 == close && is(first, "void"));
      if (!is_empty) f.parameters.push_back(variable(first, i));
      first = i + 1;
    }
    f.comment = read_comment(comment);
    source_.functions.push_back(std::move(f));
  }

  std::vector<Token> tokens_;
  bool cpp_;
  std::size_t at_ = 0;
  CSource source_;
};

}  // namespace

bool CType::numeric() const {
  if (base.empty()) return false;
  std::string_view left = base;
  while (!left.empty()) {
    const auto end = left.find(' ');
    if (std::find(number_words.begin(), number_words.end(), left.substr(0, end)) == number_words.end()) return false;
    left.remove_prefix(end == std::string_view::npos ? left.size() : end + 1);
  }
  return true;
}

const CStruct* CSource::find_struct(std::string_view name) const {
  for (const CStruct& s : structs)
    if (!name.empty() && (s.name == name || s.alias == name)) return &s;
  return nullptr;
}

const CFunction* CSource::find_function(std::string_view name) const {
  for (const CFunction& f : functions)
    if (f.name == name) return &f;
  return nullptr;
}

CSource read_source(std::string_view text, bool cpp) { return Parser(tokens_of(text), cpp).read(); }

}  // namespace ugoki::plugin
