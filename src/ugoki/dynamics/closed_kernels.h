#pragma once
// The fast kernel of closed link systems: kernel_forward.h with the loops' multipliers (closed_links.h tells the method). Internal to
// dynamics/. A loop's rows, at most six, lie in one vector of eight lanes.

#include "ugoki/dynamics/closed_structure.h"
#include "ugoki/dynamics/kernels.h"
#include "ugoki/dynamics/loop_paths.h"

namespace ugoki::dynamics {

inline constexpr int loop_lanes = 8;
/// The rows of one loop at one place: six components of eight lanes.
struct alignas(64) LoopColumns {
  double c[6][loop_lanes];
};
struct alignas(64) LoopLanes {
  double x[loop_lanes];
};
/// Two loops' block of the condensed matrix; rows of the smaller entry.
struct alignas(64) LoopBlock {
  double x[6][loop_lanes];
};
/// What elimination of a loop leaves.
struct alignas(64) LoopFactor {
  double C[6][6];           ///< Cholesky factor of the own block, rows in the order of the pivots; 1 / pivot on the diagonal
  double Z[6][loop_lanes];  ///< C^-1 P^T, six components
  double z[6];
  int order[6];
  int rank;
  double weakest;  ///< least pivot, as part of the greatest of its kind
};
/// Where a node stands and how it moves, in world axes.
struct NodeMotion {
  double R[9], p[3];  ///< node's axes into the world's; m
  double w[3], v[3];  ///< rad/s; m/s of its origin
  double spin[3];     ///< rad/s: w in the node's axes, where only the rotation is wanted
};
/// Of an end's node its rotation alone or its motion, and those on the way there.
enum class NodeWanted : char { nothing, passage, rotation, motion };

struct ClosedArguments {
  double dependent;  ///< dependent_row
  double immobile;   ///< immobile_row
  double length2;    ///< m^2: the mechanism's length, squared
  const ClosedStructure::Entry* entries;
  const ClosedStructure::Node* nodes;
  const ClosedStructure::Present* present;
  const ClosedStructure::Pair* pairs;
  const ClosedStructure::Elimination* eliminations;
  const ClosedStructure::Neighbour* neighbours;
  const ClosedStructure::Update* updates;
  const ClosedStructure::Gear* gears;
  int entry_count, block_count;
  const double* slope;    ///< [loops] of gears
  const double* turning;  ///< [nodes] 1 where freedoms turn, 1 / length2 where they slide
  const LoopPaths* paths;
  const TwinArguments* twins;  ///< of calls by paths; null: none

  const NodeWanted* moves;
  bool world_bound;    ///< only rotations are wanted
  NodeMotion* motion;  ///< [nodes, out of closed_motion] as far as wanted

  // In: P holds the loops' wrenches on their own nodes (minus those at link b, plus those at link a), g their residuals.
  LoopColumns* P;  ///< [present], in the node's axes about its origin
  LoopLanes* g;    ///< [entries]
  // Scratch and results
  LoopLanes* s;        ///< [s_slots], or [places] of paths
  LoopLanes* t;        ///< [places] s / D
  LoopLanes* reduced;  ///< [entries]
  double* moved;       ///< 1/(kg m^2) [entries] sum of 1 / D over the freedoms on the loop's way, sliding ones at the mechanism's length
  LoopBlock* Lambda;   ///< [blocks]
  LoopBlock* Y;        ///< [neighbours]
  LoopFactor* factor;  ///< [entries]
  LoopLanes* lambda;   ///< [entries, out]
};

struct ClosedKernels {
  /// Sines, cosines, velocities; motions of the nodes that are wanted. The scratch holds what forward() goes on with.
  void (*motion)(const KernelArguments<double>&, const ClosedArguments&);
  /// Accelerations and multipliers. @return false: singular
  bool (*forward)(const KernelArguments<double>&, const ClosedArguments&);
  bool (*forward_by_paths)(const KernelArguments<double>&, const ClosedArguments&);
};

/// Those of the width in use (kernels.h).
[[nodiscard]] const ClosedKernels& closed_kernels();

namespace plain {
extern const ClosedKernels closed_table;
}
#ifdef UGOKI_X86_WIDTHS
namespace avx2 {
extern const ClosedKernels closed_table;
}
namespace avx512 {
extern const ClosedKernels closed_table;
}
#endif

}  // namespace ugoki::dynamics
