#include "ugoki/dynamics/workspace.h"

namespace ugoki::dynamics {

Workspace::Workspace(const Mechanism& m) {
  const auto n = static_cast<std::size_t>(m.nv());
  const auto links = static_cast<std::size_t>(m.link_count());
  depth.resize(n);
  row_start.resize(n + 1);
  freedoms.resize(n);
  for (std::size_t i = 0; i < n; ++i) {
    const int parent = m.freedom_parents()[i];
    depth[i] = parent < 0 ? 0 : depth[static_cast<std::size_t>(parent)] + 1;
    row_start[i] = static_cast<int>(chain.size());
    if (parent >= 0) {
      const auto p = static_cast<std::size_t>(parent);
      for (int k = 0; k <= depth[p]; ++k) {
        const int freedom = chain[static_cast<std::size_t>(row_start[p] + k)];
        chain.push_back(freedom);
      }
    }
    chain.push_back(static_cast<int>(i));
    freedoms[i] = m.freedom(static_cast<int>(i));
  }
  row_start[n] = static_cast<int>(chain.size());
  link_chain.resize(links);
  for (std::size_t i = 0; i < links; ++i) {
    const Link& l = m.links()[i];
    link_chain[i] = l.joint.nv() > 0 ? l.v_index + l.joint.nv() - 1 : l.parent < 0 ? -1 : link_chain[static_cast<std::size_t>(l.parent)];
  }
  X_WB.resize(links);
  S.resize(n);
  V.resize(links);
  C.resize(links);
  I.resize(links);
  A.resize(links);
  F.resize(links);
  Ic.resize(links);
  IA.resize(links);
  pA.resize(links);
  U.resize(n);
  d.resize(n);
  u.resize(n);
  q1.resize(static_cast<std::size_t>(m.nq()));
  for (std::vector<double>* x : {&v1, &vdot, &bias, &k_q, &k_v, &sum_q, &sum_v}) x->resize(n);
  M.resize(chain.size());
  L.resize(chain.size());
  D_inverse.resize(n);
}

}  // namespace ugoki::dynamics
