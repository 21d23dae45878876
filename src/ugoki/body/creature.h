#pragma once
// Bodies of characters that are not human: masses, shapes, labels and strength of their links. Internal to body.

#include <string>
#include <vector>

#include "ugoki/body/body.h"
#include "ugoki/body/recognise.h"

namespace ugoki::body {

/// One link of a creature.
struct CreatureLink {
  std::string label;  ///< Link::label; empty if the part is unknown
  Inertia inertia;
  std::vector<Shape> shapes;
  bool follows = false;  ///< the link has no mass of its own and is fixed to its parent
  double strength = 0;   ///< N m, maximum drive torque of the joint
  double damping = 0;    ///< N m s/rad
  double armature = 0;   ///< kg m^2
};

/// A creature, link by link.
struct Creature {
  double height = 0;                ///< m, from the lowest to the highest point in the rest pose
  double mass = 0;                  ///< kg
  std::vector<CreatureLink> links;  ///< [joints]
  std::vector<std::string> notes;   ///< sentences for the report
};

/// Frames in which a four-legged animal stands: its root is at least at three quarters of its usual height above its lowest point. Crouching
/// dogs reach 0.8, sitting dogs 0.3. Lying and sitting animals are left out of estimates of the floor, because belly, elbows and metatarsi
/// then are below the level of the paws: bones have no flesh. If the animal stands in less than a tenth of the frames, all frames count.
/// @param heights [frames] m, not empty
[[nodiscard]] std::vector<char> usually_stands(const std::vector<double>& heights);

/// Makes the links of a character that is not human. @param motion in the character's canonical rest pose
[[nodiscard]] Creature make_creature(const Character& character, const MeasuredMotion& motion, const BodyOptions& options);

}  // namespace ugoki::body
