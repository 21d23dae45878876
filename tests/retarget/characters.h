#pragma once
// Characters and clips for the tests of retargeting.

#include <string>
#include <utility>
#include <vector>

#include "ugoki/mechanism/mechanism.h"
#include "ugoki/motion/motion.h"

namespace ugoki::retarget_test {

/// A motion with its mechanism.
struct Clip {
  std::string name;
  MechanismPtr mechanism;
  Motion motion;
};

/// The sample person of the given height [m]: all joints movable, knees and elbows are hinges.
[[nodiscard]] MechanismPtr make_person(double height);
[[nodiscard]] Clip human_walk();
[[nodiscard]] Clip dog_trot();
/// A humanoid robot with hinges only and box feet: three hinges at each hip and shoulder, two at each ankle and at the waist.
[[nodiscard]] MechanismPtr make_hinged_robot();
/// Loads a motion file of the shared data; false if it is absent or unreadable. @param path relative to shared/data
[[nodiscard]] bool load_clip(const std::string& path, Clip& clip);
/// Loads a robot file of the shared data with a floating base; null if it is absent or unreadable.
[[nodiscard]] MechanismPtr load_robot(const std::string& path);

/// Largest excess over a joint limit in any frame, rad | m; at most 0 if all limits are kept.
[[nodiscard]] double worst_excess(const Mechanism& mechanism, const Motion& motion);

/// Longest horizontal path [m] of a foot's lowest point in one labelled stance (points of all its shapes, or its origin if it has none).
/// An implementation independent of the module's own measurements.
[[nodiscard]] double worst_skate(const Mechanism& mechanism, const Motion& motion);

}  // namespace ugoki::retarget_test
