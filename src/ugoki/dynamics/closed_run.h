#pragma once
// State and scratch memory of the closed kernels (closed_kernels.h) for one set of closed loops. Internal to dynamics/.

#include "ugoki/dynamics/closed_kernels.h"
#include "ugoki/dynamics/closed_links.h"
#include "ugoki/dynamics/link_twins.h"

namespace ugoki::dynamics {

struct ClosedKernelState {
  ClosedKernelState(const Mechanism& m, const ClosedLinks& links, std::span<const char> closed, std::span<const char> rows);

  MechanismPtr shared;  ///< the mechanism after division of inertias (InertiaShare); null: no inertia is divided
  LinkProgram program;
  ClosedStructure over_nodes;
  /// True: the kernel eliminates the multipliers of all loops together at the world (loop_paths.h). False: it eliminates each loop at the
  /// node where the loop's two branches meet (closed_links.h).
  bool by_paths = false;
  LoopPaths paths;                 ///< used if by_paths
  LinkTwins twins;                 ///< used if by_paths
  std::vector<int> end_links;      ///< indices of the links that closed loops connect, ascending
  bool world_bound = false;        ///< every loop is a weld or ball joint between the world and a link: see is_world_bound()
  std::vector<NodeWanted> needed;  ///< [nodes] see ClosedArguments
  std::vector<NodeMotion> motion;  ///< [nodes] poses and velocities of the nodes
  std::vector<double> turning;     ///< [nodes] see ClosedArguments
  double length2 = 1;              ///< m^2
  std::vector<Pose> X_WB;          ///< [links] poses in the world, valid for end_links
  std::vector<Vec6> V;             ///< [links] velocities about ClosedRun::p0_, world axes, valid for end_links

  std::vector<LoopColumns> P;
  std::vector<LoopLanes> g, s, t, reduced, lambda;
  std::vector<LoopBlock> Lambda, Y;
  std::vector<LoopFactor> factor;
  std::vector<double> mobility;
  std::vector<CacheLine> scratch, twin_scratch;
};

}  // namespace ugoki::dynamics
