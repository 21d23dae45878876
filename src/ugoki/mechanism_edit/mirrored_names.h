#pragma once
// Left and right in names.

#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace ugoki {

/// The name with left and right exchanged in every word that says so: "left", "Left", "LEFT" within a word ("LeftArm", "arm_left");
/// "l" or "L" as a word of its own ("hand_l", "L Arm", "arm.L"), also after f, r, h, b for fore, rear, hind, back ("FL_hip"). Itself if no
/// word does.
[[nodiscard]] std::string mirrored_word(std::string_view name);

/// For each name its mirrored one, all different if they are: mirrored_word; and where that is the name itself, but the name begins with l
/// or r and the same name with the other letter is in the list, that one ("lhand" and "rhand", "LFLeg" and "RFLeg"). Applied twice, it
/// gives the names again.
[[nodiscard]] std::vector<std::string> mirrored_names(std::span<const std::string> names);

}  // namespace ugoki
