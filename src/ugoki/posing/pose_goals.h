#pragma once
// Equations of the pose solver: goals of links and closed loops, as residuals with their Jacobian. Internal to posing.

#include <span>
#include <vector>

#include "ugoki/mechanism/mechanism.h"
#include "ugoki/posing/pose_solver.h"

namespace ugoki::posing {

/// Rotation error [rad] times this length counts as a position error, m. It is about the distance of a human's hand from the elbow.
inline constexpr double lever = 0.3;

/// One DOF that the solver may move.
struct Variable {
  int link = 0, dof = 0;  ///< index of the link, and of the DOF within its joint
  Vec6 S;                 ///< motion of the link for unit rate of the DOF, about the world origin, world axes
};

/// Linear system J step = -residual; residuals in m.
struct Equations {
  int count = 0;
  std::vector<double> residual;  ///< [count]
  std::vector<double> J;         ///< [count * variables], row by row
};

/// The link and all its ancestors as a set. @param on [links, out]
void mark_ancestors(const Mechanism& mechanism, int link, std::vector<std::uint8_t>& on);

/// Writes the equations of all goals and closed loops.
/// @param X_WB [links] poses at q
void write_equations(const Mechanism& mechanism, std::span<const PoseGoal> goals, std::span<const Variable> variables,
                     std::span<const double> q, std::span<const Pose> X_WB, Equations& out);

}  // namespace ugoki::posing
