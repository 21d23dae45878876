#include "ugoki/store/words.h"

#include <utf8proc.h>

#include <algorithm>

#include "ugoki/base/sha256.h"

namespace ugoki::store {
namespace {

// Private-use characters, which words_of() never returns.
constexpr std::string_view field_separator = "\xee\x80\x80";  // U+E000: between two fields in SearchText::other
constexpr std::string_view mark_prefix = "\xee\x80\x81";      // U+E001: first character of every mark

using Codepoint = utf8proc_int32_t;

/// The code point of `text` at byte `at`; advances `at` to the next one. Returns -1 and advances one byte if the bytes are not UTF-8.
Codepoint next_codepoint(std::string_view text, std::size_t& at) {
  Codepoint c = -1;
  const auto* p = reinterpret_cast<const utf8proc_uint8_t*>(text.data() + at);
  const utf8proc_ssize_t n = utf8proc_iterate(p, static_cast<utf8proc_ssize_t>(text.size() - at), &c);
  at += n > 0 ? static_cast<std::size_t>(n) : 1;
  return n > 0 ? c : -1;
}

void append(std::string& out, Codepoint c) {
  utf8proc_uint8_t bytes[4];
  const utf8proc_ssize_t n = utf8proc_encode_char(c, bytes);
  out.append(reinterpret_cast<const char*>(bytes), static_cast<std::size_t>(n));
}

/// True for letters, digits and combining marks.
bool is_word(Codepoint c) {
  switch (utf8proc_category(c)) {
    case UTF8PROC_CATEGORY_LU:
    case UTF8PROC_CATEGORY_LL:
    case UTF8PROC_CATEGORY_LT:
    case UTF8PROC_CATEGORY_LM:
    case UTF8PROC_CATEGORY_LO:
    case UTF8PROC_CATEGORY_MN:
    case UTF8PROC_CATEGORY_MC:
    case UTF8PROC_CATEGORY_ME:
    case UTF8PROC_CATEGORY_ND:
    case UTF8PROC_CATEGORY_NL:
    case UTF8PROC_CATEGORY_NO: return true;
    default: return false;
  }
}

/// True for Chinese characters and Japanese kana: text without blanks between words, so each character is a word.
bool is_character_word(Codepoint c) {
  return (c >= 0x3005 && c <= 0x3007) || (c >= 0x3041 && c <= 0x30ff) || (c >= 0x31f0 && c <= 0x31ff) || (c >= 0x3400 && c <= 0x4dbf) ||
         (c >= 0x4e00 && c <= 0x9fff) || (c >= 0xf900 && c <= 0xfaff) || (c >= 0x20000 && c <= 0x3ffff);
}

/// The folded text. Combining accents (U+0300 ... U+036F) are removed; other marks, such as the voicing marks of kana, are kept.
std::vector<Codepoint> folded(std::string_view text) {
  const std::string clean = clean_text(text);
  const auto* bytes = reinterpret_cast<const utf8proc_uint8_t*>(clean.data());
  const auto size = static_cast<utf8proc_ssize_t>(clean.size());
  constexpr auto form = static_cast<utf8proc_option_t>(UTF8PROC_DECOMPOSE | UTF8PROC_COMPAT | UTF8PROC_CASEFOLD);
  const utf8proc_ssize_t count = utf8proc_decompose(bytes, size, nullptr, 0, form);
  if (count <= 0) return {};
  std::vector<Codepoint> out(static_cast<std::size_t>(count));
  utf8proc_decompose(bytes, size, out.data(), count, form);
  std::erase_if(out, [](Codepoint c) { return c >= 0x300 && c <= 0x36f; });
  constexpr auto compose = static_cast<utf8proc_option_t>(UTF8PROC_COMPOSE | UTF8PROC_STABLE);
  const utf8proc_ssize_t composed = utf8proc_normalize_utf32(out.data(), static_cast<utf8proc_ssize_t>(out.size()), compose);
  out.resize(composed > 0 ? static_cast<std::size_t>(composed) : 0);
  return out;
}

/// The words, each with the text `before` in front of it.
std::string joined(const std::vector<std::string>& words, std::string_view before) {
  std::string out;
  for (const std::string& word : words) out.append(before).append(word);
  return out;
}

/// The word as a quoted lexeme of PostgreSQL's text search.
std::string lexeme(std::string_view word) {
  std::string out = "'";
  for (const char c : word) {
    if (c == '\'' || c == '\\') out += c;
    out += c;
  }
  return out + "'";
}

}  // namespace

std::string clean_text(std::string_view text) {
  std::string out;
  out.reserve(text.size());
  for (std::size_t at = 0; at < text.size();) {
    const auto byte = static_cast<unsigned char>(text[at]);
    if (byte < 0x80) {
      if ((byte >= 0x20 && byte != 0x7f) || byte == '\n' || byte == '\t') out += text[at];
      ++at;
      continue;
    }
    const Codepoint c = next_codepoint(text, at);
    append(out, c < 0 ? 0xfffd : c);
  }
  return out;
}

std::vector<std::string> words_of(std::string_view text) {
  std::vector<std::string> words;
  std::string word;
  const auto end_word = [&] {
    if (!word.empty() && words.size() < max_words) words.push_back(word);
    word.clear();
  };
  for (const Codepoint c : folded(text)) {
    const bool alone = is_character_word(c);
    if (alone || !is_word(c)) end_word();
    if (!is_word(c)) continue;
    if (word.size() + 4 <= max_word_size) append(word, c);
    if (alone) end_word();
  }
  end_word();
  return words;
}

std::string name_key(std::string_view name) {
  const std::string key = joined(words_of(name), " ");
  return key.empty() ? key : key.substr(1);
}

void SearchText::add_other(std::string_view text) {
  const std::vector<std::string> words = words_of(text);
  if (words.empty() || other.size() >= max_words) return;
  if (!other.empty()) other.emplace_back(field_separator);
  other.insert(other.end(), words.begin(), words.begin() + static_cast<std::ptrdiff_t>(std::min(words.size(), max_words - other.size())));
}

std::string SearchText::all() const { return joined(name, " ") + " " + std::string(field_separator) + joined(other, " "); }
std::string SearchText::name_words() const { return joined(name, " "); }
std::string SearchText::other_words() const { return joined(other, " "); }

std::string SearchText::mark_words() const { return joined(marks, " "); }

std::string kind_mark(std::string_view kind) { return std::string(mark_prefix) + "k" + std::string(kind); }
std::string tag_mark(std::string_view tag) { return std::string(mark_prefix) + "t" + sha256(tag).substr(0, 24); }

std::string name_mark(std::string_view word) { return std::string(mark_prefix) + "n" + std::string(word); }

std::string pair_mark(bool of_name, std::string_view first, std::string_view second) {
  return std::string(mark_prefix) + (of_name ? "q" : "p") + std::string(first) + " " + std::string(second);
}

std::string SearchText::tsvector() const {
  std::string out;
  std::size_t position = 0;
  const auto add = [&](const std::vector<std::string>& words) {
    for (const std::string& word : words) out += lexeme(word) + ":" + std::to_string(++position) + " ";
    ++position;  // a gap in the positions, so that no phrase matches across two lists
  };
  add(name);
  add(other);
  add(marks);
  const auto add_pairs = [&](const std::vector<std::string>& words, bool of_name) {
    for (std::size_t i = 1; i < words.size(); ++i)
      if (words[i - 1] != field_separator && words[i] != field_separator) out += lexeme(pair_mark(of_name, words[i - 1], words[i])) + " ";
  };
  add_pairs(name, false);
  add_pairs(other, false);
  add_pairs(name, true);
  return out;
}

std::string SearchPhrases::in_words(std::size_t phrase) const { return joined(phrases[phrase], " "); }

std::string SearchPhrases::fts5(bool in_name, const std::vector<std::string>& tags, const std::vector<std::string>& kinds) const {
  std::string all;
  for (const std::vector<std::string>& phrase : phrases) {
    all += all.empty() ? "\"" : " AND \"";
    for (const std::string& word : phrase) all += (in_name ? name_mark(word) : word) + " ";
    all.back() = '"';
    all += " *";
  }
  for (const std::string& tag : tags) all += (all.empty() ? "\"" : " AND \"") + tag_mark(tag) + "\"";
  std::string any;
  for (const std::string& kind : kinds) any += (any.empty() ? "(\"" : " OR \"") + kind_mark(kind) + "\"";
  if (!any.empty()) all += (all.empty() ? "" : " AND ") + any + ")";
  return all;
}

std::string SearchPhrases::tsquery(bool in_name, const std::vector<std::string>& tags, const std::vector<std::string>& kinds,
                                   bool exact_phrases) const {
  std::string all;
  for (const std::vector<std::string>& phrase : phrases) {
    all += all.empty() ? "(" : " & (";
    const bool by_pairs = !exact_phrases && phrase.size() > 1;
    for (std::size_t i = by_pairs ? 1 : 0; i < phrase.size(); ++i) {
      const std::string mark = by_pairs ? pair_mark(in_name, phrase[i - 1], phrase[i]) : in_name ? name_mark(phrase[i]) : phrase[i];
      all += lexeme(mark) + (i + 1 == phrase.size() ? ":*)" : exact_phrases ? " <-> " : " & ");
    }
  }
  for (const std::string& tag : tags) all += (all.empty() ? "" : " & ") + lexeme(tag_mark(tag));
  std::string any;
  for (const std::string& kind : kinds) any += (any.empty() ? "(" : " | ") + lexeme(kind_mark(kind));
  if (!any.empty()) all += (all.empty() ? "" : " & ") + any + ")";
  return all;
}

bool SearchPhrases::any_longer_than_pairs() const {
  return std::ranges::any_of(phrases, [](const std::vector<std::string>& phrase) { return phrase.size() > 2; });
}

SearchPhrases search_phrases(std::string_view text) {
  SearchPhrases out;
  constexpr std::size_t max_phrases = 16;
  bool any = false;
  for (std::size_t at = 0; at < text.size() && out.phrases.size() < max_phrases;) {
    const std::size_t begin = text.find_first_not_of(" \t\r\n", at);
    if (begin == std::string_view::npos) break;
    any = true;
    const bool quote = text[begin] == '"';
    const std::size_t from = quote ? begin + 1 : begin;
    const std::size_t end = std::min(text.find_first_of(quote ? "\"" : " \t\r\n", from), text.size());
    at = quote ? end + 1 : end;
    std::vector<std::string> words = words_of(text.substr(from, end - from));
    if (words.empty()) continue;
    out.key += (out.key.empty() ? "" : " ") + name_key(text.substr(from, end - from));
    out.phrases.push_back(std::move(words));
  }
  out.nothing = any && out.phrases.empty();
  return out;
}

}  // namespace ugoki::store
