#include "ugoki/intake/choice.h"

#include <algorithm>

#include "ugoki/body/recognise.h"
#include "ugoki/intake/arrange.h"
#include "ugoki/intake/conversion_report.h"

namespace ugoki::intake {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

/// Index of the name that equals `wanted`, or of the number from 1 that `wanted` is; -1: none. Names come first.
int find_choice(const std::vector<std::string>& names, const std::string& wanted) {
  const auto named = std::ranges::find(names, wanted);
  if (named != names.end()) return static_cast<int>(named - names.begin());
  for (std::size_t k = 0; k < names.size(); ++k)
    if (wanted == std::to_string(k + 1)) return static_cast<int>(k);
  return -1;
}

}  // namespace

std::vector<int> character_roots(const MeasuredMotion& motion) {
  constexpr int min_joints = 5;
  const std::vector<char> free = body::recognise_character(motion).free;
  std::vector<int> root, count(free.size()), out;
  for (std::size_t j = 0; j < free.size(); ++j) {
    const int parent = motion.skeleton.joints[j].parent;
    root.push_back(parent < 0 || free[j] != 0 ? static_cast<int>(j) : root[at(parent)]);
    ++count[at(root.back())];
  }
  for (std::size_t j = 0; j < count.size(); ++j)
    if (count[j] >= min_joints) out.push_back(static_cast<int>(j));
  return out;
}

Result<void> choose_character(std::span<MeasuredMotion> motions, std::span<const int> roots, const std::string& wanted,
                              const std::string& location) {
  const Skeleton& s = motions[0].skeleton;
  std::vector<std::string> names;
  for (const int r : roots) names.push_back(s.joints[at(r)].name);
  const int chosen = find_choice(names, wanted);
  if (chosen < 0)
    return fail(ErrorCode::unknown, location, "The file has no character '" + wanted + "'.",
                names.empty() ? "It has no character with 5 or more joints."
                              : "Its characters are 1 to " + std::to_string(names.size()) + ": " + list_of(names) + ".");
  std::vector<char> keep(s.joints.size(), 0);
  for (std::size_t j = 0; j < keep.size(); ++j) {
    const int i = static_cast<int>(j), parent = s.joints[j].parent;
    const bool other = std::ranges::find(roots, i) != roots.end();
    keep[j] = i == roots[at(chosen)] || (!other && parent >= 0 && keep[at(parent)] != 0) ? 1 : 0;
  }
  for (MeasuredMotion& m : motions) keep_joints(m, keep);
  return {};
}

Result<std::size_t> find_take(std::span<const MeasuredMotion> motions, const std::string& wanted, const std::string& location) {
  std::vector<std::string> names;
  for (const MeasuredMotion& m : motions) names.push_back(m.name);
  const int chosen = find_choice(names, wanted);
  if (chosen < 0)
    return fail(ErrorCode::unknown, location, "The file has no motion '" + wanted + "'.",
                "Its motions are 1 to " + std::to_string(names.size()) + ": " + list_of(names) + ".");
  return at(chosen);
}

bool is_default_name(std::string_view name) {
  std::string letters;  // of the whole name in lower case; digits, dots and separators vary
  for (const char c : name)
    if (c >= 'A' && c <= 'Z')
      letters += static_cast<char>(c - 'A' + 'a');
    else if (c >= 'a' && c <= 'z')
      letters += c;
    else if ((c & 0x80) != 0)
      return false;
  for (std::string_view word : {"armature", "rig", "skeleton", "layer", "stack", "base"})
    for (std::size_t at = letters.find(word); at != std::string::npos; at = letters.find(word)) letters.erase(at, word.size());
  constexpr std::string_view defaults[] = {"",       "take",    "anim",    "animation", "action", "mixamocom",
                                           "motion", "default", "unnamed", "untitled",  "scene"};
  return std::ranges::find(defaults, letters) != std::end(defaults);
}

}  // namespace ugoki::intake
