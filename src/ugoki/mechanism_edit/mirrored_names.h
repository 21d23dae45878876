#pragma once
// Exchange of left and right in names.

#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace ugoki {

/// Returns the name with left and right exchanged. Recognised are "left", "Left", "LEFT" as parts of a name ("LeftArm", "arm_left"), and
/// "l" or "L" as a separate word ("hand_l", "L Arm", "arm.L"), also after f, r, h, b for fore, rear, hind, back ("FL_hip"). A name without
/// a side is returned unchanged.
[[nodiscard]] std::string mirrored_word(std::string_view name);

/// Returns the mirrored name of each name, by mirrored_word(). A name that mirrored_word() does not change, and that begins with l or r,
/// gets the other letter if the list contains that name ("lhand" and "rhand", "LFLeg" and "RFLeg"). Different names stay different.
/// Applying the function twice gives the original names.
[[nodiscard]] std::vector<std::string> mirrored_names(std::span<const std::string> names);

}  // namespace ugoki
