#include "ugoki/dynamics/workspace.h"

#include <algorithm>
#include <limits>

#include "ugoki/base/check.h"
#include "ugoki/dynamics/kernels.h"
#include "ugoki/dynamics/link_kernels.h"

namespace ugoki::dynamics {
namespace {
constexpr std::size_t entry_limit = std::numeric_limits<int>::max();  // entries are indexed by int
constexpr std::size_t max_initial_entries = 1'000'000;                // M and L then have 8 MB each; larger ones: allocated on first use
}  // namespace

Kinematics::Kinematics(const Mechanism& m)
    : X_WB(static_cast<std::size_t>(m.link_count())), S(static_cast<std::size_t>(m.nv())), V(X_WB.size()), C(X_WB.size()), I(X_WB.size()) {}

Workspace::Workspace(const Mechanism& m) : Kinematics(m), program(m), twins(program) {
  const auto n = static_cast<std::size_t>(m.nv());
  const auto links = static_cast<std::size_t>(m.link_count());
  depth.resize(n);
  row_start.resize(n + 1);
  dofs.resize(n);
  armature.resize(n);
  std::size_t entries = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const int parent = m.dof_parents()[i];
    depth[i] = parent < 0 ? 0 : depth[static_cast<std::size_t>(parent)] + 1;
    row_start[i] = static_cast<int>(std::min(entries, entry_limit));
    entries += static_cast<std::size_t>(depth[i]) + 1;
    dofs[i] = m.dof(static_cast<int>(i));
    armature[i] = dofs[i].armature;
  }
  row_start[n] = static_cast<int>(std::min(entries, entry_limit));
  if (entries <= max_initial_entries) make_rows(m);
  const std::size_t bytes = std::max({scratch_size(program, sizeof(double), 1), twins.scratch, links * link_scratch * sizeof(double)});
  scratch.resize((bytes + sizeof(CacheLine) - 1) / sizeof(CacheLine));
  link_chain.resize(links);
  for (std::size_t i = 0; i < links; ++i) {
    const Link& l = m.links()[i];
    link_chain[i] = l.joint.nv() > 0 ? l.v_index + l.joint.nv() - 1 : l.parent < 0 ? -1 : link_chain[static_cast<std::size_t>(l.parent)];
  }
  A.resize(links);
  F.resize(links);
  Ic.resize(links);
  IA.resize(links);
  pA.resize(links);
  U.resize(n);
  d.resize(n);
  u.resize(n);
  D_inverse.resize(n);
}

int Workspace::entry_of(int i, int j) const {
  const auto last = static_cast<std::size_t>(std::max(i, j)), first = static_cast<std::size_t>(std::min(i, j));
  return row_start[last] + depth[first];
}

void Workspace::make_rows(const Mechanism& m) {
  const auto entries = static_cast<std::size_t>(row_start.back());
  UGOKI_CHECK(entries < entry_limit);
  chain.resize(entries);
  for (std::size_t i = 0; i < depth.size(); ++i) {
    int* const row = chain.data() + row_start[i];
    if (const int parent = m.dof_parents()[i]; parent >= 0)
      std::copy_n(chain.data() + row_start[static_cast<std::size_t>(parent)], depth[i], row);
    row[depth[i]] = static_cast<int>(i);
  }
  entry_index.reserve(entries);
  for (const auto& [above, below] : twins.entry_dofs()) entry_index.push_back(entry_of(above, below));
  M.resize(entries);
  L.resize(entries);
}

}  // namespace ugoki::dynamics
