#pragma once
// Contacts of feet and hands in a motion whose feet hover and slide. Internal to correction.

#include "ugoki/motion_edit/foot_contacts.h"

namespace ugoki::correction {

/// m, for a leg of 0.9 m: a body that stays lower than this does not fly. Its feet slide.
inline constexpr double min_clearance = 0.02;

/// m, for a leg of 0.9 m: other links than feet and hands carry load where they are lower than this.
inline constexpr double other_height = 0.025;

/// Support points of the links that are not part of a foot or another limb with contacts. The end of a shank at the ankle is as low as the
/// foot and is left out.
[[nodiscard]] std::vector<LinkPoint> other_points(const Mechanism& mechanism, const motion_edit::FootContacts& contacts);

/// Contacts of the feet, and of hands that rest on the floor. Heights and speeds are tolerant. While the body does not leave the floor, its
/// lowest foot or hand is in contact, at any speed, unless other links lie on the floor. O(frames * points)
[[nodiscard]] motion_edit::FootContacts find_bearing_limbs(const Mechanism& mechanism, const Motion& motion);

}  // namespace ugoki::correction
