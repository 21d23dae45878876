#pragma once
// Inverse kinematics of a chain of links with strict joint limits and two task priorities: position (or direction), then orientation.

#include <span>
#include <vector>

#include "ugoki/mechanism/mechanism.h"

namespace ugoki::retarget {

/// Goal for the last link of a chain.
struct ChainGoal {
  enum class First { position, direction };
  First first = First::position;
  Vec3 point;                 ///< m or unit vector in the last link's frame: point or direction that shall reach `target`
  Vec3 target;                ///< m or unit vector in the world: goal of `point`
  bool turn = true;           ///< second priority: also reach the orientation R with the remaining DOFs
  Mat3 R = Mat3::identity();  ///< wanted orientation of the last link in the world
  double length = 1;          ///< m, size of the chain, by which position errors are divided
  int iterations = 12;
};

/// Solves for the goal's position (or direction) by damped least squares, then for its orientation in the null space of the first task.
/// Joint limits are kept at every step: a DOF that would pass its limit is set to the limit, and the step is re-solved for the other DOFs.
/// The coordinates of a spherical joint are the components of its rotation vector; joint limits apply to these components.
/// Source: Siciliano and Slotine 1991 (task priority); Buss 2009 (damping).
class ChainSolver {
 public:
  explicit ChainSolver(const Mechanism& mechanism);

  /// [nv] rad | m, limits of every DOF: initially those of the mechanism; the user of the solver can narrow them.
  std::vector<double> lower, upper;

  /// @param chain links, each the child of the previous one
  /// @param q [nq, in and out]
  /// @param X_WB [links, in and out] poses; updated for the chain. The pose of the first link's parent must be valid.
  /// @return remaining error of the position [m] or direction [rad]
  double solve(std::span<const int> chain, const ChainGoal& goal, double* q, std::span<Pose> X_WB);

  /// Returns a symmetric matrix (world axes) that maps a desired displacement of a point on the last link to the part that the chain cannot
  /// follow. Its eigenvalues are near 0 in directions in which the point moves freely, near 1 where the chain is stretched out or at its
  /// limits.
  /// @param point m, in the world
  /// @param wish m, desired displacement; decides which limits would be passed @param length m, size of the chain
  [[nodiscard]] Mat3 resistance(std::span<const int> chain, const Vec3& point, const Vec3& wish, double length, const double* q,
                                std::span<const Pose> X_WB);

  /// Clamps the joint's coordinates to its limits. @return true if they were outside
  bool clamp(int link, double* q) const;
  /// Sets the joint so that the link's orientation is as close to R_WB as this joint and its limits allow. The parent's pose must be valid.
  /// @return true if the orientation is reached, false if limits or missing DOFs prevent it
  bool orient(int link, const Mat3& R_WB, double* q, std::span<Pose> X_WB) const;
  /// Updates the pose of the link from its parent's pose and the joint's coordinates.
  void place(int link, const double* q, std::span<Pose> X_WB) const;

 private:
  /// One DOF of the chain: its Jacobian column and its step.
  struct Column {
    int link = 0, dof = 0;
    Vec3 w, v;               // per unit rate of the coordinate, world axes: angular velocity of the link, velocity of its origin
    Vec3 J1, J2;             // Jacobian columns of the first task (position or direction) and of the orientation
    double x = 0, step = 0;  // rad | m
    bool at_limit = false;
  };
  /// Fills columns_ for the chain at q.
  void gather(std::span<const int> chain, const double* q, std::span<const Pose> X_WB);
  /// Sets Column::step of all columns such that no limit is passed.
  /// @param first, turn_error errors of the first task and of the orientation @param along direction excluded from the first task
  void find_step(const Vec3& first, const Vec3& turn_error, const Vec3& along, double damping, bool turn);
  /// Adds `share` times the step of every column to q, clamps, and updates the poses.
  void apply(std::span<const int> chain, double share, double* q, std::span<Pose> X_WB);
  void save(std::span<const int> chain, const double* q);
  void restore(std::span<const int> chain, double* q, std::span<Pose> X_WB) const;
  /// Errors of a goal, dimensionless (position over the chain's size) or rad (direction, orientation).
  struct Miss {
    Vec3 first, turn, point;
    double cost = 0;
  };
  [[nodiscard]] static Miss miss_of(const ChainGoal& goal, const Pose& X);

  const Mechanism& m_;
  std::vector<Column> columns_;
  std::vector<double> saved_;
};

}  // namespace ugoki::retarget
