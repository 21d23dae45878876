#pragma once
// Poses and motions made by hand as keys, for the person of samples::make_person(). The keys ignore dynamics.

#include <span>
#include <vector>

#include "ugoki/mechanism/mechanism.h"
#include "ugoki/motion/motion.h"

namespace ugoki::correction {

/// One side of the body. Angles: rad.
struct Side {
  Vec3 arm{0.1, 0.25, -1};              ///< direction of the arm in the frame of the chest; y is outwards
  double elbow = 0.2;                   ///< flexed
  double hip = 0, knee = 0, ankle = 0;  ///< hip and knee flexed; ankle: toes down
  double out = 0;                       ///< thigh outwards
};

struct Key {
  double time = 0;             ///< s
  Vec3 place;                  ///< m: of the hips
  Vec3 turn;                   ///< rad: rotation vector of the hips
  double spine = 0, neck = 0;  ///< rad, bent forwards, of each of three and two joints
  Side left, right;
};

/// Sets a joint to a rotation vector; a hinge to the sum of its x and y.
void set_joint(const Mechanism& m, const std::string& name, const Vec3& turn, std::vector<double>& q);
/// Rotation vector that turns a stretched arm (y of its side) into a direction.
[[nodiscard]] Vec3 arm_turn(double side, const Vec3& direction);
/// Joint positions of a key.
[[nodiscard]] std::vector<double> pose(const Mechanism& m, const Key& key);
/// m: height of the lowest support point of all links above the floor.
[[nodiscard]] double lowest_point(const Mechanism& m, std::span<const double> q);
/// Motion through the keys at `rate` frames per second: straight lines between the poses, softened by `rounds` averages of neighbours.
[[nodiscard]] Motion through_keys(const Mechanism& m, std::span<const Key> keys, double rate, int rounds);
/// Moves the root so that the lowest material point of the body rests on the floor from frame to frame.
void roll_over_ground(const Mechanism& m, Motion& motion);

/// A walk of one stride of 1 s, cyclic: four poses a step. @param travel m in one stride; 0: in place
[[nodiscard]] Motion keyed_walk(const Mechanism& person, double travel);
/// A jump with bent knees in the air.
[[nodiscard]] Motion keyed_tuck_jump(const Mechanism& person, double rate);
/// A cartwheel to the left and a get-up from hands and feet.
[[nodiscard]] Motion keyed_cartwheel(const Mechanism& person);
[[nodiscard]] Motion keyed_get_up(const Mechanism& person);

}  // namespace ugoki::correction
