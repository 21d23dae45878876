#pragma once
// Spring chains: joints without drives whose springs and dampers are tuned by frequency and damping ratio, for tails, hair, antennae,
// bellies and loads on springs (secondary motion).
//
// A chain consists of the joint of one link and of all joints of its descendants. Let M be the inertia matrix of these joints with the rest
// of the mechanism held, G the derivative of the gravity torques, and D the diagonal of M, all in the rest pose. The springs have the
// stiffness s D and the dampers the coefficients c D. s is chosen so that the lowest natural frequency of s D + G relative to M is the
// wanted one, c so that this lowest mode has the wanted damping ratio. The springs are preloaded so that gravity does not bend the chain.

#include <string>

#include "ugoki/mechanism/mechanism.h"

namespace ugoki::dynamics {

struct SpringChain {
  int link = 0;           ///< first link of the chain
  double frequency = 2;   ///< Hz: lowest natural frequency while the parent of the chain is held
  double damping = 0.15;  ///< damping ratio of the lowest mode; 1: critical damping
};

/// Returns the mechanism with the springs, dampers and zero drive efforts of the chains. Fails if a chain begins at a root, has no DOF, has
/// links in common with another chain, belongs to a closed loop, or swings faster under gravity alone than at the wanted frequency.
/// Allocates.
/// @param q [nq] the rest pose
/// @param gravity m/s^2, world
/// @param step s: time step of the simulation. A spring of stiffness k that is integrated implicitly damps like an additional
///   damper of k step; the dampers are reduced by this amount
[[nodiscard]] Result<MechanismPtr> with_spring_chains(const Mechanism& m, std::span<const SpringChain> chains, std::span<const double> q,
                                                      const Vec3& gravity, double step);

}  // namespace ugoki::dynamics
