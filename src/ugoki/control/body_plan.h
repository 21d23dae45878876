#pragma once
// The parts of a body with which it can catch a fall: trunk, head, and two arms and two legs.

#include <array>
#include <optional>

#include "ugoki/mechanism/mechanism.h"

namespace ugoki::control {

/// A point of a link that can touch the ground.
struct Effector {
  int link = -1;
  Vec3 point;         ///< m, in the frame of the link: contact point, or centre of the sphere that touches the ground
  double radius = 0;  ///< m: height of `point` above the ground while it touches
};

enum class Place : int { foot, knee, hand };
inline constexpr std::size_t place_count = 3;

/// Dimensions and parts of a body with two legs and two arms. Directions are those of the neutral position: x forward, y left, z up.
struct BodyPlan {
  std::array<std::array<Effector, place_count>, 2> places;  ///< [left, right][Place]
  int chest = -1, head = -1;
  std::array<int, 2> thigh{-1, -1}, upper_arm{-1, -1};  ///< links; their origins are the hips and the shoulders
  Vec3 head_up;                                         ///< unit, in the frame of the head: up in the neutral position
  Mat3 rest;                                            ///< orientation of the root link in the neutral position
  double hip_height = 0;                                ///< m: height of the hips above the soles in the neutral position
  double thigh_length = 0, arm_length = 0;              ///< m
  [[nodiscard]] const Effector& place(int side, Place p) const {
    return places[static_cast<std::size_t>(side)][static_cast<std::size_t>(p)];
  }
};

/// Finds the parts by the labels of the links ("foot left", "hand right"). Nothing if the root does not float or a part is missing.
[[nodiscard]] std::optional<BodyPlan> body_plan_of(const Mechanism& mechanism);

}  // namespace ugoki::control
