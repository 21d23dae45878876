#pragma once
// Inverse kinematics of a chain of links with strict joint limits and two priorities.

#include <span>
#include <vector>

#include "ugoki/mechanism/mechanism.h"

namespace ugoki::retarget {

/// What the last link of a chain shall do.
struct ChainGoal {
  enum class First { place, direction };
  First first = First::place;
  Vec3 point;                 ///< place: m, in the last link's frame; direction: unit, in the last link's frame
  Vec3 target;                ///< place: m, in the world; direction: unit, in the world
  bool turn = true;           ///< with what is left of the freedoms: the orientation
  Mat3 R = Mat3::identity();  ///< wanted orientation of the last link
  double length = 1;          ///< m, size of the chain, for damping
  int iterations = 12;
};

/// Joint limits are kept at every step: a freedom that would go beyond its limit goes to it, and the others do the rest. First the goal's
/// place (or direction) by damped least squares, then in the null space of that the orientation. Spherical joints move in the components of
/// their rotation vector, on which their limits act. Source: Siciliano and Slotine 1991 (task priority); Buss 2009 (damping).
class ChainSolver {
 public:
  explicit ChainSolver(const Mechanism& mechanism);

  /// Limits of every freedom as they are kept here [nv]: those of the mechanism, or narrower ones.
  std::vector<double> lower, upper;

  /// @param chain links, each the child of the one before
  /// @param q [nq, in and out] @param X_WB [links, in and out] kept up to date for the chain; its base's parent must be right
  /// @return what misses of the place [m] or the direction [rad]
  double solve(std::span<const int> chain, const ChainGoal& goal, double* q, std::span<Pose> X_WB);

  /// How much of a wish to move the place on the last link stays undone where the chain is now: 0 in directions in which it moves freely, 1
  /// in those in which it is stretched out or at its limits. Symmetric.
  /// @param place m, in the world @param wish m, for its direction: limits count that would be passed
  [[nodiscard]] Mat3 resistance(std::span<const int> chain, const Vec3& place, const Vec3& wish, double length, const double* q,
                                std::span<const Pose> X_WB);

  /// Brings the joint's coordinates inside its limits. @return true if they were outside
  bool clamp(int link, double* q) const;
  /// Sets the joint so that the link turns to R_WB as nearly as one joint can, within its limits. The parent's pose must be right.
  /// @return true if it is there, false if limits or missing freedoms keep it away
  bool orient(int link, const Mat3& R_WB, double* q, std::span<Pose> X_WB) const;
  /// Pose of the link from its parent's and its coordinates.
  void place(int link, const double* q, std::span<Pose> X_WB) const;

 private:
  struct Column {
    int link = 0, freedom = 0;
    Vec3 w, v;  // of the link per unit of the coordinate, about the joint, world axes
    Vec3 J1, J2;
    double x = 0, step = 0;
    bool held = false;
  };
  void gather(std::span<const int> chain, const double* q, std::span<const Pose> X_WB);
  void find_step(const Vec3& first, const Vec3& turn_error, const Vec3& along, double damping, bool turn);
  void apply(std::span<const int> chain, double share, double* q, std::span<Pose> X_WB);
  void save(std::span<const int> chain, const double* q);
  void restore(std::span<const int> chain, double* q, std::span<Pose> X_WB) const;
  /// What misses of a goal: place over the chain's size, or direction, then the turn. [rad]
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
