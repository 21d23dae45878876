#pragma once
// Figures and clips for the tests of retargeting.

#include <string>
#include <utility>
#include <vector>

#include "ugoki/mechanism/mechanism.h"
#include "ugoki/motion/motion.h"

namespace ugoki::retarget_test {

struct Clip {
  std::string name;
  MechanismPtr mechanism;
  Motion motion;
};

/// The project's own human of any height, with all joints free to move, knees and elbows as hinges.
[[nodiscard]] MechanismPtr make_person(double height);
[[nodiscard]] Clip human_walk();
[[nodiscard]] Clip dog_trot();
/// A robot of hinges alone, T-shaped, with box feet: three hinges at hips and shoulders, two at ankles and waist.
[[nodiscard]] MechanismPtr make_hinged_robot();
/// A file of the shared data; false where it is absent. @param path below shared/data
[[nodiscard]] bool load_clip(const std::string& path, Clip& clip);
[[nodiscard]] MechanismPtr load_robot(const std::string& path);

/// Largest excess over a joint limit in any frame (rad | m); at most 0 where all are kept.
[[nodiscard]] double worst_excess(const Mechanism& mechanism, const Motion& motion);

/// Longest horizontal way [m] of a standing foot in one stance as the motion labels it: the lowest of its places (all shapes, or its origin
/// where it has none) from frame to frame. Written without any of the module's own measures.
[[nodiscard]] double worst_skate(const Mechanism& mechanism, const Motion& motion);

}  // namespace ugoki::retarget_test
