#pragma once
// The fast kernels of closed link systems: kernel_forward.h extended by the loops' multipliers (method: closed_links.h). Internal to
// dynamics/. The rows of one loop, at most six, are stored in one vector of eight lanes.

#include "ugoki/dynamics/closed_structure.h"
#include "ugoki/dynamics/kernels.h"
#include "ugoki/dynamics/loop_paths.h"

namespace ugoki::dynamics {

inline constexpr int loop_lanes = 8;
/// The columns P of one loop's multipliers at one node: six wrench components (moment, force), each with one lane per row of the loop.
struct alignas(64) LoopColumns {
  double c[6][loop_lanes];
};
/// One value per row of a loop.
struct alignas(64) LoopLanes {
  double x[loop_lanes];
};
/// Block of the condensed matrix Lambda for two loops: rows for the loop with the smaller entry index, lanes for the other loop.
struct alignas(64) LoopBlock {
  double x[6][loop_lanes];
};
/// Result of eliminating one loop's multipliers; needed to recover them later.
struct alignas(64) LoopFactor {
  double C[6][6];           ///< Cholesky factor of the loop's diagonal block, rows in pivot order; the diagonal holds 1 / C_kk
  double Z[6][loop_lanes];  ///< C^-1 P^T: one row per pivot, six components
  double z[6];              ///< C^-1 g
  int order[6];             ///< row of the loop for each pivot
  int rank;                 ///< number of independent rows
  double min_pivot_ratio;   ///< smallest pivot as a fraction of the largest diagonal entry of the same kind (position or rotation rows)
};
/// Pose and velocity of a node, in world axes.
struct NodeMotion {
  double R[9], p[3];  ///< rotation from node axes to world axes, row by row; origin, m
  double w[3], v[3];  ///< rad/s; m/s of the origin
  double spin[3];     ///< rad/s: w in the node's axes; set instead of p, w and v if only the rotation is needed
};
/// Which motion of a node the loops need. `passage`: none of its own, but the node is on the chain to a node that is needed.
enum class NodeWanted : char { nothing, passage, rotation, motion };

/// Inputs, scratch and outputs of one call of a closed kernel. The arrays of ClosedStructure are described there.
struct ClosedArguments {
  double dependent;  ///< dependent_row
  double immobile;   ///< immobile_row
  double length2;    ///< m^2: square of the mechanism's characteristic length
  const ClosedStructure::Entry* entries;
  const ClosedStructure::Node* nodes;
  const ClosedStructure::Present* present;
  const ClosedStructure::Pair* pairs;
  const ClosedStructure::Elimination* eliminations;
  const ClosedStructure::Neighbour* neighbours;
  const ClosedStructure::Update* updates;
  const ClosedStructure::Gear* gears;
  int entry_count, block_count;
  const double* slope;    ///< [loops] c'(x_b) of gears
  const double* turning;  ///< [nodes] 1 if the node's DOFs rotate, 1 / length2 if they slide
  const LoopPaths* paths;
  const TwinArguments* twins;  ///< used by forward_by_paths; null: none

  const NodeWanted* needed;  ///< [nodes] what closed_motion() computes for each node
  bool world_bound;          ///< only rotations are needed: see begin_world_bound() in closed_run.cpp
  NodeMotion* motion;        ///< [nodes, out of closed_motion] filled as `needed` requests

  // On input P holds the loops' unit wrenches on their own nodes (negative at link b, positive at link a), and g the rows' residuals.
  LoopColumns* P;  ///< [present] in the node's axes about its origin
  LoopLanes* g;    ///< [entries]
  // Scratch and results
  LoopLanes* s;        ///< [s_slots], or with paths [DOFs of all paths]: S . P of each DOF
  LoopLanes* t;        ///< [DOFs of all paths] s / D
  LoopLanes* reduced;  ///< [entries] amount that earlier eliminations subtracted from the diagonal of Lambda
  double* mobility;    ///< 1/(kg m^2) [entries] sum of 1 / D over the DOFs on the loop's path; sliding DOFs count divided by length2
  LoopBlock* Lambda;   ///< [blocks]
  LoopBlock* Y;        ///< [neighbours] C^-1 Lambda(eliminated loop, neighbour)
  LoopFactor* factor;  ///< [entries]
  LoopLanes* lambda;   ///< [entries, out]
};

/// The closed kernels of one SIMD width.
struct ClosedKernels {
  /// Computes sines, cosines and angular velocities of all nodes, and ClosedArguments::motion. The scratch memory keeps the results that
  /// forward() and forward_by_paths() use; call one of them next with the same arguments.
  void (*motion)(const KernelArguments<double>&, const ClosedArguments&);
  /// Computes accelerations and multipliers; each loop is eliminated where its branches meet. @return false: singular inertia
  bool (*forward)(const KernelArguments<double>&, const ClosedArguments&);
  /// As forward(), with all loops eliminated at the world (loop_paths.h).
  bool (*forward_by_paths)(const KernelArguments<double>&, const ClosedArguments&);
};

/// The closed kernels of the SIMD width in use (kernels.h).
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
