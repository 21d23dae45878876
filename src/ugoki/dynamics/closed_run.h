#pragma once
// Memory of the closed kernel for one set of closed loops. Internal to dynamics/.

#include "ugoki/dynamics/closed_kernels.h"
#include "ugoki/dynamics/closed_links.h"
#include "ugoki/dynamics/link_twins.h"

namespace ugoki::dynamics {

struct ClosedKernelState {
  ClosedKernelState(const Mechanism& m, const ClosedLinks& links, std::span<const char> closed, std::span<const char> rows);

  MechanismPtr shared;  ///< the mechanism with the virtual links' shares of inertia; null: as it is
  LinkProgram program;
  ClosedStructure over_nodes;
  bool by_paths = false;  ///< loops are eliminated at the world
  LoopPaths paths;
  LinkTwins twins;                 ///< used by paths
  std::vector<int> end_links;      ///< of closed loops
  bool world_bound = false;        ///< all loops hold a link to the world: see WorldBound
  std::vector<NodeWanted> moves;   ///< [nodes] on the way to an end link
  std::vector<NodeMotion> motion;  ///< [nodes]
  std::vector<double> turning;     ///< [nodes] see ClosedArguments
  double length2 = 1;
  std::vector<Pose> X_WB;  ///< [links] of end links
  std::vector<Vec6> V;     ///< [links] of end links, about p0

  std::vector<LoopColumns> P;
  std::vector<LoopLanes> g, s, t, reduced, lambda;
  std::vector<LoopBlock> Lambda, Y;
  std::vector<LoopFactor> factor;
  std::vector<double> moved;
  std::vector<CacheLine> scratch, twin_scratch;
};

}  // namespace ugoki::dynamics
