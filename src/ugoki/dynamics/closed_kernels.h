#pragma once
// The fast kernels of closed link systems: kernel_forward.h extended by the loops' multipliers (method: closed_links.h). Internal to
// dynamics/. The constraint rows of one loop, at most six, are stored in one vector of eight lanes.

#include "ugoki/dynamics/closed_structure.h"
#include "ugoki/dynamics/kernels.h"
#include "ugoki/dynamics/loop_paths.h"

namespace ugoki::dynamics {

inline constexpr int loop_lanes = 8;
/// The columns P of one loop at one node: the wrench on the node per unit of each of the loop's multipliers. There are six components
/// (moment, force), each with one lane per row of the loop.
struct alignas(64) LoopColumns {
  double c[6][loop_lanes];
};
/// One value for each constraint row of a loop, in SIMD lanes.
struct alignas(64) LoopLanes {
  double x[loop_lanes];
};
/// Block of the condensed matrix Lambda for two loops. Its rows belong to the loop that comes first in ClosedStructure::entries, its lanes
/// to the other loop.
struct alignas(64) LoopBlock {
  double x[6][loop_lanes];
};
/// Result of eliminating one loop's multipliers; needed to recover them later.
struct alignas(64) LoopFactor {
  double C[6][6];           ///< Cholesky factor of the loop's diagonal block, rows in pivot order; the diagonal stores 1 / C_kk
  double Z[6][loop_lanes];  ///< C^-1 P^T, P as in LoopColumns: one row per pivot, six components
  double z[6];              ///< C^-1 g, g: residuals of the rows
  int order[6];             ///< for each pivot, the index of its row in the loop
  int rank;                 ///< number of independent rows
  double min_pivot_ratio;   ///< smallest pivot divided by the largest diagonal entry of the same kind (position or rotation rows)
};
/// Pose and velocity of a node, in world axes.
struct NodeMotion {
  double R[9], p[3];  ///< R: rotation from node axes to world axes, row-major; p: origin of the node, m
  double w[3], v[3];  ///< w: angular velocity, rad/s; v: velocity of the origin, m/s
  double spin[3];     ///< angular velocity in the node's axes, rad/s; set instead of p, w and v if only the rotation is needed
};
/// Which motion of a node the loops need. `passage`: the loops do not need this node's motion, but that of one of its descendants.
enum class NodeWanted : char { nothing, passage, rotation, motion };

/// Inputs, scratch and outputs of one call of a closed kernel. The arrays from `entries` to `gears` are those of ClosedStructure.
struct ClosedArguments {
  double dependent;  ///< pivot threshold, see dependent_row
  double immobile;   ///< threshold, see immobile_row
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
  const double* slope;    ///< [loops] gears: derivative c'(x_b) of Loop::polynomial
  const double* turning;  ///< [nodes] 1 if the node's DOFs rotate, 1 / length2 if they slide
  const LoopPaths* paths;
  const TwinArguments* twins;  ///< used by forward_by_paths; null: none

  const NodeWanted* needed;  ///< [nodes] what closed_motion() computes for each node
  bool world_bound;          ///< true: the loops need only rotations of nodes, see is_world_bound() in closed_run.cpp
  NodeMotion* motion;        ///< [nodes, out] result of closed_motion(), filled as `needed` requests

  // Inputs. At the two end nodes of a loop, P contains the unit wrenches of its rows: negative for link b, positive for link a. g contains
  // the residuals of the rows.
  LoopColumns* P;  ///< [present] columns P, in the axes of the node and about its origin
  LoopLanes* g;    ///< [entries] residuals of the rows
  // Scratch and results. S: joint axis of a DOF; D: pivot of a DOF (kernel_forward.h)
  LoopLanes* s;        ///< S . P of each DOF; [s_slots], in forward_by_paths() [DOFs of all paths]
  LoopLanes* t;        ///< [DOFs of all paths] s / D, D: pivot of the DOF
  LoopLanes* reduced;  ///< [entries] amount that earlier eliminations subtracted from the diagonal of Lambda
  double* mobility;    ///< 1/(kg m^2) [entries] sum over the DOFs on the loop's path: 1 / D if rotating, 1 / (D length2) if sliding
  LoopBlock* Lambda;   ///< [blocks] blocks of the condensed matrix
  LoopBlock* Y;        ///< [neighbours] C^-1 Lambda(eliminated loop, neighbour)
  LoopFactor* factor;  ///< [entries] results of the eliminations
  LoopLanes* lambda;   ///< [entries, out] multipliers
};

/// The closed kernels of one SIMD width.
struct ClosedKernels {
  /// Computes sines, cosines and angular velocities of all nodes, and ClosedArguments::motion. The scratch memory keeps the results that
  /// forward() and forward_by_paths() use; call one of them next with the same arguments.
  void (*motion)(const KernelArguments<double>&, const ClosedArguments&);
  /// Computes accelerations and multipliers; each loop is eliminated where its branches meet. @return false: singular inertia
  bool (*forward)(const KernelArguments<double>&, const ClosedArguments&);
  /// Computes the same as forward(), but eliminates all loops at the world (loop_paths.h).
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
