#pragma once
// Twins: two children of a node whose subtrees are built alike (legs, arms) run side by side in two lanes for one instance.
// What is left is the trunk. Internal to dynamics/.

#include <cstddef>
#include <utility>
#include <vector>

#include "ugoki/dynamics/kernels.h"

namespace ugoki::dynamics {

struct LinkTwins {
  using Both = LaneArray<double, 2>;

  template <class Constant>
  struct Part {
    std::vector<NodeOrder> order;
    std::vector<NodeConstants<Constant>> constants;
    std::vector<int> angle_q;
    std::vector<double> angle_sign;  ///< of pairs two for each angle
    std::vector<int> node;           ///< of the whole program; of pairs two for each
    std::vector<int> force_freedom;  ///< the mechanism's; of pairs two for each
    int nq = 0, nv = 0, slots = 0;
    int entries = 0;      ///< of the inertia matrix
    int angle_begin = 0;  ///< among those of all parts
  };
  struct Pair : Part<Both> {
    std::vector<int> q_of, v_of;  ///< [nq * 2], [nv * 2] the mechanism's coordinates and freedoms
    int base = 0, place = 0;      ///< node of the trunk; its NodeOrder::twins
    int force_begin = 0;          ///< of the trunk's forces, where those of the pair begin
    bool first = true;            ///< of this base
    std::size_t scratch = 0;      ///< where its scratch begins
  };

  explicit LinkTwins(const LinkProgram& program);

  /// Freedoms of the entries of the inertia matrix in the order in which kernel_inertia.h has them: the one above, the other below.
  [[nodiscard]] std::vector<std::pair<int, int>> entry_freedoms() const;

  Part<double> trunk;  ///< q, v: those of the mechanism
  std::vector<Pair> pairs;
  std::vector<int> angle_q;        ///< [angles] of all parts, coordinates of the mechanism; a multiple of 16
  std::vector<double> angle_sign;  ///< [angles]
  int places = 0;                  ///< nodes of the trunk that carry twins
  std::size_t sines = 0;           ///< where their sines and cosines stand in the scratch
  std::size_t scratch = 0;         ///< bytes

  /// Trunk and pairs of a call on the whole program. `whole.scratch` has `scratch` bytes.
  [[nodiscard]] TwinArguments arguments(const KernelArguments<double>& whole) const;
};

}  // namespace ugoki::dynamics
