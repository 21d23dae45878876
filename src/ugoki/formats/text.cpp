#include "ugoki/formats/text.h"

#include <cmath>
#include <cstdint>

#include "ugoki/base/number.h"

namespace ugoki::formats {
namespace {

bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\f' || c == '\v'; }
bool is_line_end(char c) { return c == '\n' || c == '\r'; }
bool is_space(char c) { return is_blank(c) || is_line_end(c); }
char lower(char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; }

// 10^22 is the largest power of ten that is exactly a double.
constexpr double powers_of_ten[] = {1e0,  1e1,  1e2,  1e3,  1e4,  1e5,  1e6,  1e7,  1e8,  1e9,  1e10, 1e11,
                                    1e12, 1e13, 1e14, 1e15, 1e16, 1e17, 1e18, 1e19, 1e20, 1e21, 1e22};

}  // namespace

void Problems::add(ErrorCode code, int line, std::string message, std::string remedy) {
  if (!full()) error_.add(code, file_ + ":" + std::to_string(line), std::move(message), std::move(remedy));
}

std::optional<std::string_view> plain_text(std::string_view text, std::string_view format, Problems& problems) {
  const std::string kind(format);
  if (text.starts_with("\xFF\xFE") || text.starts_with("\xFE\xFF")) {
    problems.add(ErrorCode::unsupported, 1, "The text is encoded in UTF-16.", "Save it as UTF-8 or ASCII and import it again.");
    return std::nullopt;
  }
  if (text.starts_with("\xEF\xBB\xBF")) text.remove_prefix(3);
  while (text.ends_with('\x1A') || text.ends_with('\0')) text.remove_suffix(1);  // padding that some old systems append (Ctrl-Z, NUL)
  int line = 1;
  bool seen = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (c == '\n' || (c == '\r' && (i + 1 == text.size() || text[i + 1] != '\n'))) ++line;
    if ((static_cast<unsigned char>(c) < 0x20 && !is_space(c)) || c == 0x7F) {
      problems.add(ErrorCode::syntax, line, "The file contains bytes that are not text.",
                   "Check that it is a " + kind + " text file and that it is not compressed or damaged.");
      return std::nullopt;
    }
    seen = seen || !is_space(c);
  }
  if (!seen) {
    problems.add(ErrorCode::truncated, 1, "The file is empty.", "Export the " + kind + " file again.");
    return std::nullopt;
  }
  return text;
}

std::string in_quotes(std::string_view token) {
  std::string out = "'";
  for (const char c : token.substr(0, 40)) out += static_cast<unsigned char>(c) < 0x20 || static_cast<unsigned char>(c) >= 0x7F ? '?' : c;
  if (token.size() > 40) out += "...";
  return out + "'";
}

std::string path_in_quotes(std::string_view path) {
  constexpr std::size_t max_bytes = 400;
  std::string out = path.size() > max_bytes ? "'..." : "'";
  for (const char c : path.substr(path.size() > max_bytes ? path.size() - max_bytes : 0))
    out += static_cast<unsigned char>(c) < 0x20 || c == 0x7F ? '?' : c;
  return out + "'";
}

std::string stem_of(std::string_view file_name) {
  if (const std::size_t slash = file_name.find_last_of("/\\"); slash != std::string_view::npos) file_name.remove_prefix(slash + 1);
  if (const std::size_t dot = file_name.rfind('.'); dot != std::string_view::npos && dot > 0) file_name = file_name.substr(0, dot);
  return std::string(file_name);
}

std::string utf8(std::string_view name) {
  // Checks for valid UTF-8 (RFC 3629): no overlong forms, no surrogates, nothing above U+10FFFF.
  const auto byte = [&](std::size_t i) { return i < name.size() ? static_cast<unsigned char>(name[i]) : 0u; };
  const auto tail = [&](std::size_t i, unsigned low = 0x80, unsigned high = 0xBF) { return byte(i) >= low && byte(i) <= high; };
  bool valid = true;
  for (std::size_t i = 0; valid && i < name.size();) {
    const unsigned c = byte(i);
    std::size_t length = 0;
    if (c < 0x80)
      length = 1;
    else if (c >= 0xC2 && c <= 0xDF && tail(i + 1))
      length = 2;
    else if (c >= 0xE0 && c <= 0xEF && tail(i + 1, c == 0xE0 ? 0xA0 : 0x80, c == 0xED ? 0x9F : 0xBF) && tail(i + 2))
      length = 3;
    else if (c >= 0xF0 && c <= 0xF4 && tail(i + 1, c == 0xF0 ? 0x90 : 0x80, c == 0xF4 ? 0x8F : 0xBF) && tail(i + 2) && tail(i + 3))
      length = 4;
    valid = length > 0;
    i += length;
  }
  if (valid) return std::string(name);
  std::string out;
  for (const char ch : name) {
    const auto c = static_cast<unsigned char>(ch);
    if (c < 0x80) {
      out += ch;
    } else {
      out += static_cast<char>(0xC0 | (c >> 6));
      out += static_cast<char>(0x80 | (c & 0x3F));
    }
  }
  return out;
}

bool equal_ignoring_case(std::string_view a, std::string_view b) {
  if (a.size() != b.size()) return false;
  for (std::size_t i = 0; i < a.size(); ++i)
    if (lower(a[i]) != lower(b[i])) return false;
  return true;
}

std::optional<double> measured_number(std::string_view token) {
  // Fast path: a mantissa below 2^53 and a power of ten up to 10^22 are exact doubles. Their quotient is rounded only once, so it is the
  // correctly rounded value (Clinger, How to read floating point numbers accurately, 1990). At most 18 digits are read, so that the
  // mantissa does not overflow.
  std::size_t i = !token.empty() && (token[0] == '-' || token[0] == '+') ? 1 : 0;
  std::uint64_t mantissa = 0;
  std::size_t digits = 0, fraction = 0;
  bool point = false;
  for (; i < token.size(); ++i) {
    const char c = token[i];
    if (c >= '0' && c <= '9') {
      if (++digits > 18) break;
      mantissa = mantissa * 10 + static_cast<std::uint64_t>(c - '0');
      fraction += point ? 1 : 0;
    } else if (c == '.' && !point) {
      point = true;
    } else {
      break;
    }
  }
  std::optional<double> value;
  if (i == token.size() && digits > 0 && mantissa < (1ULL << 53)) {
    const double magnitude = static_cast<double>(mantissa) / powers_of_ten[fraction];
    value = token[0] == '-' ? -magnitude : magnitude;
  } else {
    value = parse_double(token);
  }
  if (value && !(std::fabs(*value) <= max_magnitude)) return std::nullopt;
  return value;
}

NumberFault number_fault(std::string_view token) {
  if (token.empty()) return {ErrorCode::truncated, "A number is missing.", "Add it, or export the file again."};
  if (parse_double(token))
    return {ErrorCode::range, in_quotes(token) + " is too large to be a measurement; the maximum magnitude is 1e9.",
            "Correct the number, or the units of the export."};
  std::string_view bare = token;
  if (bare.starts_with('-') || bare.starts_with('+')) bare.remove_prefix(1);
  bool numeric = !bare.empty();
  bool comma = false;
  for (const char c : bare) {
    comma = comma || c == ',';
    numeric = numeric && ((c >= '0' && c <= '9') || c == '.' || c == ',' || c == 'e' || c == 'E' || c == '-' || c == '+');
  }
  if (numeric && comma)
    return {ErrorCode::syntax, in_quotes(token) + " has a comma instead of a decimal point.",
            "Export the file again with decimal points (English locale)."};
  if (bare.size() >= 3 &&
      (equal_ignoring_case(bare.substr(0, 3), "nan") || equal_ignoring_case(bare.substr(0, 3), "inf") || bare.starts_with("1.#")))
    return {ErrorCode::range, in_quotes(token) + " is not a finite number.", "Replace it by a measured value, or remove the frame."};
  if (numeric) return {ErrorCode::range, in_quotes(token) + " is not a valid number.", "Correct the number."};
  return {ErrorCode::syntax, in_quotes(token) + " is not a number.", "Write a number here, or export the file again."};
}

bool Scanner::skip_space() {
  while (at_ < text_.size() && is_space(text_[at_])) {
    const char c = text_[at_++];
    if (c == '\n' || (c == '\r' && (at_ == text_.size() || text_[at_] != '\n'))) ++line_;
  }
  return at_ < text_.size();
}

void Scanner::skip_blanks() {
  while (at_ < text_.size() && is_blank(text_[at_])) ++at_;
}

std::string_view Scanner::word() {
  skip_space();
  return word_on_line();
}

std::string_view Scanner::peek() {
  skip_space();
  const Scanner saved = *this;
  const std::string_view w = word_on_line();
  *this = saved;
  return w;
}

std::string_view Scanner::word_on_line() {
  skip_blanks();
  const std::size_t begin = at_;
  while (at_ < text_.size() && !is_space(text_[at_])) ++at_;
  return text_.substr(begin, at_ - begin);
}

std::string_view Scanner::rest_of_line(char stop) {
  skip_blanks();
  const std::size_t begin = at_;
  while (at_ < text_.size() && !is_line_end(text_[at_]) && !(stop != '\0' && text_[at_] == stop)) ++at_;
  std::string_view rest = text_.substr(begin, at_ - begin);
  while (!rest.empty() && is_blank(rest.back())) rest.remove_suffix(1);
  return rest;
}

bool Scanner::accept(std::string_view keyword) {
  skip_space();
  if (!equal_ignoring_case(text_.substr(at_, keyword.size()), keyword)) return false;
  at_ += keyword.size();
  return true;
}

bool Scanner::accept_on_line(char c) {
  skip_blanks();
  if (at_ >= text_.size() || text_[at_] != c) return false;
  ++at_;
  return true;
}

}  // namespace ugoki::formats
