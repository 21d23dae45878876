#pragma once
// Chooses one of several characters or motions of a file.

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "ugoki/base/result.h"
#include "ugoki/motion/skeleton.h"

namespace ugoki::intake {

/// Root joints of the characters in a motion: trees of at least 5 joints that no bone connects. Smaller trees are held objects.
[[nodiscard]] std::vector<int> character_roots(const MeasuredMotion& motion);

/// Keeps the joints of one character. @param motions all on the same skeleton @param roots result of character_roots
/// @param wanted number from 1, or name of a root joint @param location of the error
/// Errors: there is no such character.
Result<void> choose_character(std::span<MeasuredMotion> motions, std::span<const int> roots, const std::string& wanted,
                              const std::string& location);

/// Index of one motion. @param wanted number from 1, or name. Errors: there is no such motion.
[[nodiscard]] Result<std::size_t> find_take(std::span<const MeasuredMotion> motions, const std::string& wanted,
                                            const std::string& location);

/// True for names that a program gives a motion by itself: "Take 001", "Anim_0", "mixamo.com", "Armature|Action". They do not describe it.
[[nodiscard]] bool is_default_name(std::string_view name);

}  // namespace ugoki::intake
