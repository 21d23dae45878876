#pragma once
// Feet that stand still, and a root that follows the physical trajectory of the centre of mass. Internal to correction.

#include <functional>
#include <optional>

#include "ugoki/motion/motion.h"
#include "ugoki/motion_edit/foot_contacts.h"

namespace ugoki::correction {

/// Pins the feet in contact, finds the displacement of the centre of mass (centre_path.h), and moves root and limbs accordingly.
/// @param progress called with the fraction of the work that is done, 0 to 1; returns false to cancel
/// @param contacts in and out: contacts that a limb does not reach are removed
/// @return nothing if the work was cancelled
[[nodiscard]] std::optional<Motion> place_body(const Mechanism& mechanism, const Motion& motion, double gravity,
                                               const std::function<bool(double)>& progress, motion_edit::FootContacts& contacts);

}  // namespace ugoki::correction
