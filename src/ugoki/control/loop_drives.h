#pragma once
// Drive torques of a mechanism with closed loops.
//
// Inverse dynamics of the cut tree gives a torque for each joint, also for joints without a drive: the crank of a bicycle, the elbows of a
// five-bar robot. Loop forces lambda transmit these torques to the drives without changing the motion:
//
//   tau = tau_tree + J^T lambda,   tau_k = 0 for each joint k without a drive
//
// This is tau_G = S^T tau_driven of Nagashima (1999), eq. (4), because J v = 0 for all velocities that open no loop. If many torques
// satisfy it (two legs turn one crank), the solution with the minimum sum of (tau_k / strength_k)^2 is used.

#include <span>
#include <vector>

#include "ugoki/dynamics/loop_rows.h"

namespace ugoki::control {

/// Moves torques from the joints without a drive to the drives. Owns its scratch memory; use one per thread.
class LoopDrives {
 public:
  /// Uses the loops of `m` that are closed at the start and lie within a tree: both ends are links, or the tree is fixed to the world.
  /// @param strength [nv] N | N m: scale of each drive's torque; 0: no drive. The DOFs of a floating root are not used
  LoopDrives(const Mechanism& m, std::span<const double> strength);

  [[nodiscard]] bool empty() const { return loops_.empty(); }
  /// True if a loop connects this DOF: its motion follows from that of other joints.
  [[nodiscard]] bool contains(int dof) const { return !in_loop_.empty() && in_loop_[static_cast<std::size_t>(dof)] != 0; }
  /// Sets the torques of the joints without a drive to zero and changes the drives' torques so that the motion stays the same. Torques that
  /// the drives cannot replace (at a dead point) remain. O(nv rows^2). Allocates nothing.
  /// @param ws results of update_kinematics() for q and v @param tau [nv, in and out] N | N m
  void distribute(const Mechanism& m, const dynamics::Workspace& ws, std::span<const double> q, std::span<const double> v,
                  std::span<double> tau);

 private:
  std::vector<Loop> loops_;
  dynamics::LoopRows rows_;
  std::vector<double> weight_;  // [nv] 1 / strength^2 of a drive; joints without one: undriven_weight times the maximum; roots: 0
  std::vector<char> in_loop_;   // [nv] 1: a row of a loop contains the DOF
  std::vector<double> J_;       // [rows * nv]
  std::vector<double> A_, x_;   // [rows * rows], [rows] normal equations
};

}  // namespace ugoki::control
