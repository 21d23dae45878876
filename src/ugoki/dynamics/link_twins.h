#pragma once
// Twins: two sibling nodes whose subtrees have the same structure (two legs, two arms). The kernels run both subtrees of such a
// pair in the two lanes of one register for one instance. The trunk consists of all nodes outside the pairs; the base of a pair is
// the trunk node that carries the twins. Internal to dynamics/.

#include <cstddef>
#include <utility>
#include <vector>

#include "ugoki/dynamics/kernels.h"

namespace ugoki::dynamics {

/// A LinkProgram split into its trunk and pairs of twins.
struct LinkTwins {
  using Both = LaneArray<double, 2>;  ///< values of the first and second twin

  /// Program of the trunk (Constant = double) or of one pair (Constant = Both). In a pair, arrays marked "2 per ..." interleave
  /// the values of the first and second twin.
  template <class Constant>
  struct Part {
    std::vector<NodeOrder> order;                    ///< [nodes] node, coordinate and DOF indices are those of this part
    std::vector<NodeConstants<Constant>> constants;  ///< [nodes]
    std::vector<int> angle_q;                        ///< [angles] index in this part's q of each angle
    std::vector<double> angle_sign;                  ///< [angles]; pairs: 2 per angle
    std::vector<int> node;                           ///< [nodes] index in the LinkProgram; pairs: 2 per node
    std::vector<int> force_dof;  ///< the mechanism's DOFs in the order of LinkProgram::force_dof; pairs: 2 per DOF of a twin
    int nq = 0, nv = 0, slots = 0;
    int entries = 0;      ///< pairs: number of inertia matrix entries that the pair computes
    int angle_begin = 0;  ///< index of this part's first angle in LinkTwins::angle_q
  };
  struct Pair : Part<Both> {
    std::vector<int> q_of, v_of;  ///< [nq * 2], [nv * 2] indices in the mechanism's q and v, interleaved
    int base = 0, twin_slot = 0;  ///< base: node index in the trunk; twin_slot: NodeOrder::twin_slot of the base
    int force_begin = 0;          ///< index in the trunk's force_dof of the pair's first DOF
    bool first = true;            ///< true: the first of the pairs attached to this base
    std::size_t scratch = 0;      ///< byte offset of the pair's memory in the scratch memory
  };

  explicit LinkTwins(const LinkProgram& program);

  /// Pair of DOFs (ancestor or self, descendant) of each inertia matrix entry, in the order in which kernel_inertia.h computes them.
  [[nodiscard]] std::vector<std::pair<int, int>> entry_dofs() const;

  Part<double> trunk;  ///< its coordinate and DOF indices are those of the mechanism
  std::vector<Pair> pairs;
  std::vector<int> angle_q;        ///< [angles] index in the mechanism's q, all parts one after another; padded to a multiple of 16
  std::vector<double> angle_sign;  ///< [angles] 0 for padding
  int twin_slots = 0;              ///< number of base nodes in the trunk
  std::size_t sines = 0;           ///< byte offset of the sines in the scratch memory; the cosines follow
  std::size_t scratch = 0;         ///< size of the scratch memory, bytes

  /// Makes the arguments of the trunk and the pairs from those of the whole program. `whole.scratch` must have `scratch` bytes.
  [[nodiscard]] TwinArguments arguments(const KernelArguments<double>& whole) const;
};

}  // namespace ugoki::dynamics
