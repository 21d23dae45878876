#pragma once
// Inverse kinematics of a whole body: finds positions that meet goals for points, orientations and directions.
//
// One iteration minimizes the weighted squares of the linearized goal errors plus a small weight on the distance from a preferred posture
// (damped least squares, Levenberg 1944). Coordinates outside the limits of their joints are moved to the limits afterwards.

#include <span>
#include <vector>

#include "ugoki/dynamics/workspace.h"

namespace ugoki::control {

class PoseFinder {
 public:
  explicit PoseFinder(MechanismPtr mechanism);

  /// Starts an iteration at the positions q [nq]; then add goals and call step().
  void begin(std::span<const double> q);
  /// Goal for a point of a link. @param p m, in the frame of the link @param target m, world @param weights m^-2, of world x, y, z
  void add_point(int link, const Vec3& p, const Vec3& target, const Vec3& weights);
  /// Goal for the orientation of a link. @param weight rad^-2
  void add_turn(int link, const Mat3& R_target, double weight);
  /// Goal for a direction of a link. @param axis unit, in the frame of the link @param target unit, world @param weight rad^-2
  void add_axis(int link, const Vec3& axis, const Vec3& target, double weight);
  /// Goal for the centre of mass. @param target m, world @param weights m^-2, of world x, y, z
  void add_centre(const Vec3& target, const Vec3& weights);
  /// Executes the iteration. @param preferred [nq] preferred posture of the joints; its root is not used @param weight rad^-2, weight of
  /// the posture @param max_turn rad or m: maximum change of a coordinate @param q [nq, out] new positions
  void step(std::span<const double> preferred, double weight, double max_turn, std::span<double> q);

 private:
  void add_row(double error, double weight);  // adds row_ to the normal equations, and clears it
  void solve();                               // solves the normal equations for step_
  MechanismPtr mechanism_;
  dynamics::Workspace ws_;
  std::size_t n_ = 0;
  std::vector<double> q_, zero_, row_, H_, L_, g_, step_, displacement_;
  std::vector<Vec6> A_G_;             // [nv] centroidal momentum matrix
  std::vector<unsigned char> fixed_;  // [nv] 1: the coordinate stays at its limit
};

/// Moves each limited joint coordinate that is outside its limits to the limit. @param q [nq, in and out]
void clamp_to_limits(const Mechanism& mechanism, std::span<double> q);

}  // namespace ugoki::control
