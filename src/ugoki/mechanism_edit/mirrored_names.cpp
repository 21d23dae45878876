#include "ugoki/mechanism_edit/mirrored_names.h"

#include <array>
#include <optional>
#include <set>
#include <utility>

namespace ugoki {
namespace {

constexpr std::array<std::pair<std::string_view, std::string_view>, 3> words = {{{"left", "right"}, {"Left", "Right"}, {"LEFT", "RIGHT"}}};
/// Abbreviations that count only as separate words: left and right, also after the initial of fore, rear, hind or back.
constexpr std::array<std::pair<std::string_view, std::string_view>, 10> short_words = {{{"l", "r"},
                                                                                        {"L", "R"},
                                                                                        {"fl", "fr"},
                                                                                        {"FL", "FR"},
                                                                                        {"rl", "rr"},
                                                                                        {"RL", "RR"},
                                                                                        {"hl", "hr"},
                                                                                        {"HL", "HR"},
                                                                                        {"bl", "br"},
                                                                                        {"BL", "BR"}}};

bool is_lower(char c) { return c >= 'a' && c <= 'z'; }
bool is_upper(char c) { return c >= 'A' && c <= 'Z'; }
bool is_letter(char c) { return is_lower(c) || is_upper(c); }

/// The word for a side that begins at position `at`, and its opposite; nullopt if there is none.
std::optional<std::pair<std::string_view, std::string_view>> side_word(std::string_view name, std::size_t at) {
  const auto letter_before = [&] { return at > 0 && is_letter(name[at - 1]); };
  for (const auto& [left, right] : words)
    for (const auto& [word, other] : {std::pair(left, right), std::pair(right, left)}) {
      if (name.substr(at, word.size()) != word) continue;
      const char after = at + word.size() < name.size() ? name[at + word.size()] : ' ';
      // "left" within "cleft" or "leftover" is not a side; "Left" in "LeftArm" and "armLeft" is.
      const bool begins = is_lower(word[0]) ? !letter_before() : is_lower(word[1]) || !letter_before();
      const bool ends = is_upper(word[1]) ? !is_letter(after) : !is_lower(after);
      if (begins && ends) return std::pair(word, other);
    }
  const auto joins = [](char c) { return is_letter(c) || (c >= '0' && c <= '9'); };
  if (at > 0 && joins(name[at - 1])) return std::nullopt;
  for (const auto& [left, right] : short_words)
    for (const auto& [word, other] : {std::pair(left, right), std::pair(right, left)})
      if (name.substr(at, word.size()) == word && (at + word.size() >= name.size() || !joins(name[at + word.size()])))
        return std::pair(word, other);
  return std::nullopt;
}

/// The name with l and r exchanged in its first letter: "lhand" -> "rhand".
std::string other_letter(std::string_view name) {
  std::string out(name);
  if (out.empty()) return out;
  switch (out[0]) {
    case 'l': out[0] = 'r'; break;
    case 'r': out[0] = 'l'; break;
    case 'L': out[0] = 'R'; break;
    case 'R': out[0] = 'L'; break;
    default: break;
  }
  return out;
}

}  // namespace

std::string mirrored_word(std::string_view name) {
  std::string out;
  for (std::size_t at = 0; at < name.size();) {
    if (const auto found = side_word(name, at)) {
      out += found->second;
      at += found->first.size();
    } else {
      out += name[at++];
    }
  }
  return out;
}

std::vector<std::string> mirrored_names(std::span<const std::string> names) {
  const std::set<std::string, std::less<>> all(names.begin(), names.end());
  std::vector<std::string> out;
  out.reserve(names.size());
  for (const std::string& name : names) {
    std::string mirrored = mirrored_word(name);
    if (mirrored == name)
      if (std::string other = other_letter(name); all.contains(other) && mirrored_word(other) == other) mirrored = std::move(other);
    out.push_back(std::move(mirrored));
  }
  return out;
}

}  // namespace ugoki
