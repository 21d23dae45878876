#pragma once
// Twins: two children of a node whose subtrees are built alike (legs, arms) run side by side in two lanes for one instance.
// What is left is the trunk. Internal to dynamics/.

#include <cstddef>
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
    int nq = 0, nv = 0, slots = 0;
  };
  struct Pair : Part<Both> {
    std::vector<int> q_of, v_of;  ///< [nq * 2], [nv * 2] the mechanism's coordinates and freedoms
    int base = 0, place = 0;      ///< node of the trunk; its NodeOrder::twins
    bool first = true;            ///< of this base
    std::size_t scratch = 0;      ///< where its scratch begins
  };

  explicit LinkTwins(const LinkProgram& program);

  Part<double> trunk;  ///< q, v: those of the mechanism
  std::vector<Pair> pairs;
  int places = 0;           ///< nodes of the trunk that carry twins
  std::size_t scratch = 0;  ///< bytes

  /// Trunk and pairs of a call on the whole program. `whole.scratch` has `scratch` bytes.
  [[nodiscard]] TwinArguments arguments(const KernelArguments<double>& whole) const;
};

}  // namespace ugoki::dynamics
