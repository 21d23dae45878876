#include "ugoki/dynamics/articulated_factor.h"

#include <algorithm>
#include <cmath>

#include "ugoki/base/check.h"

namespace ugoki::dynamics {
namespace {

/// Scalar product of two vectors of six elements: two independent sums of three products, so that the order of additions is fixed.
inline double product(const Eight& e, const double* b) {
  const double* const a = e.x;
  return (a[0] * b[0] + a[1] * b[1] + a[2] * b[2]) + (a[3] * b[3] + a[4] * b[4] + a[5] * b[5]);
}

}  // namespace

ArticulatedFactor::ArticulatedFactor(const Mechanism& m) {
  const auto n = static_cast<std::size_t>(m.nv());
  if (FreeBodyFactor::applies_to(m)) body_.emplace(m);
  dofs_.resize(n);
  std::vector<int> moved_by(static_cast<std::size_t>(m.link_count()), -1);
  std::vector<int> count(n + 1, 0);
  for (int i = 0; i < m.link_count(); ++i) {
    const Link& link = m.link(i);
    const int base = link.parent < 0 ? -1 : moved_by[static_cast<std::size_t>(link.parent)];
    const int last = link.joint.nv() > 0 ? link.v_index + link.joint.nv() - 1 : base;
    moved_by[static_cast<std::size_t>(i)] = last;
    if (last >= 0) ++count[static_cast<std::size_t>(last) + 1];
  }
  for (std::size_t k = 0; k < n; ++k) {
    count[k + 1] += count[k];
    const int parent = m.dof_parents()[k];
    dofs_[k].parent = parent;
    dofs_[k].depth = parent < 0 ? 0 : dofs_[static_cast<std::size_t>(parent)].depth + 1;
  }
  std::vector<int> children(n, 0);
  for (const FactorDof& dof : dofs_)
    if (dof.parent >= 0) ++children[static_cast<std::size_t>(dof.parent)];
  for (FactorDof& dof : dofs_) {
    dof.inertia = -1;
    dof.leaf = true;
  }
  for (std::size_t k = n; k-- > 0;) {
    if (dofs_[k].inertia < 0) {
      dofs_[k].inertia = static_cast<int>(inertia_dof_.size());
      inertia_dof_.push_back(static_cast<int>(k));
    }
    if (dofs_[k].parent < 0) continue;
    const auto parent = static_cast<std::size_t>(dofs_[k].parent);
    dofs_[k].last_child = dofs_[parent].leaf;
    dofs_[parent].leaf = false;
    if (children[parent] == 1 && count[parent] == count[parent + 1]) dofs_[parent].inertia = dofs_[k].inertia;
  }
  first_link_ = count;
  links_.resize(static_cast<std::size_t>(count[n]));
  for (int i = 0; i < m.link_count(); ++i)
    if (const int last = moved_by[static_cast<std::size_t>(i)]; last >= 0)
      links_[static_cast<std::size_t>(count[static_cast<std::size_t>(last)]++)] = i;
  make_room(own_);
}

void ArticulatedFactor::make_room(FactorScratch& scratch) const {
  scratch.inertias.resize(std::max(scratch.inertias.size(), 6 * inertia_dof_.size()));
  scratch.sweep.resize(std::max(scratch.sweep.size(), dofs_.size()));
}

void ArticulatedFactor::use(FactorScratch& scratch) {
  if (shared_ == nullptr) own_ = {};
  shared_ = &scratch;
}

int ArticulatedFactor::factor(const Workspace& ws, std::span<const double> extra) {
  const std::size_t n = dofs_.size();
  UGOKI_CHECK(ws.S.size() == n && (extra.empty() || extra.size() == n));
  closed_form_ = body_ && std::ranges::all_of(extra, [](double x) { return x == 0; });
  if (closed_form_) return body_->factor(ws);
  Eight* const inertias = scratch().inertias.data();
  for (std::size_t i = 0; i < inertia_dof_.size(); ++i) {
    const auto k = static_cast<std::size_t>(inertia_dof_[i]);
    Eight* const A = inertias + 6 * i;
    std::fill_n(A, 6, Eight{});
    for (int l = first_link_[k]; l < first_link_[k + 1]; ++l) {
      const Inertia& I = ws.I[static_cast<std::size_t>(links_[static_cast<std::size_t>(l)])];
      A[0].x[0] += I.I.xx;
      A[0].x[1] += I.I.xy;
      A[0].x[2] += I.I.xz;
      A[1].x[1] += I.I.yy;
      A[1].x[2] += I.I.yz;
      A[2].x[2] += I.I.zz;
      A[0].x[4] -= I.h.z;
      A[0].x[5] += I.h.y;
      A[1].x[5] -= I.h.x;
      A[3].x[3] += I.mass;
    }
    A[1].x[0] = A[0].x[1];
    A[2].x[0] = A[0].x[2];
    A[2].x[1] = A[1].x[2];
    A[1].x[3] = -A[0].x[4];
    A[2].x[3] = -A[0].x[5];
    A[2].x[4] = -A[1].x[5];
    // The lower left block is the transpose of the upper right one.
    for (int r = 0; r < 3; ++r)
      for (int c = 0; c < 3; ++c) A[3 + r].x[c] = A[c].x[3 + r];
    A[4].x[4] = A[5].x[5] = A[3].x[3];
  }
  return factor_kernels().eliminate(dofs_.data(), n, ws.S.data(), ws.armature.data(), extra.empty() ? nullptr : extra.data(), inertias);
}

void ArticulatedFactor::solve(std::span<double> x) const {
  if (closed_form_) return body_->solve(x);
  UGOKI_CHECK(x.size() == dofs_.size());
  factor_kernels().solve(dofs_.data(), dofs_.size(), scratch().sweep.data(), x.data());
}

void ArticulatedFactor::whiten_wrenches(int last, const Vec6* f, double* y) const {
  if (closed_form_) return body_->whiten_wrenches(last, f, y);
  factor_kernels().whiten_wrenches(dofs_.data(), last, f, y);
}

void ArticulatedFactor::whiten_row(int last, std::span<const double> tail, double* y) const {
  if (closed_form_) return body_->whiten_row(last, tail, y);
  double f[6] = {};
  std::size_t left = tail.size();
  for (int k = last; k >= 0;) {
    const FactorDof& dof = dofs_[static_cast<std::size_t>(k)];
    double s = product(dof.S, f);
    if (left > 0) s += tail[--left];
    const double t = s * dof.inverse;
    double* const out = y + 4 * dof.depth;
    out[0] = s * dof.root;
    out[1] = out[2] = out[3] = 0;
    for (int j = 0; j < 6; ++j) f[j] -= dof.U.x[j] * t;
    k = dof.parent;
  }
}

void ArticulatedFactor::add_whitened(std::span<const double> w, std::span<double> v) const {
  if (closed_form_) return body_->add_whitened(w, v);
  UGOKI_CHECK(w.size() == dofs_.size() && v.size() == dofs_.size());
  factor_kernels().add_whitened(dofs_.data(), dofs_.size(), scratch().sweep.data(), w.data(), v.data());
}

void ArticulatedFactor::whiten_velocity(std::span<const double> v, std::span<double> w) const {
  if (closed_form_) return body_->whiten_velocity(v, w);
  const std::size_t n = dofs_.size();
  UGOKI_CHECK(w.size() == n && v.size() == n);
  Eight* const at = scratch().sweep.data();
  for (std::size_t k = 0; k < n; ++k) {
    const FactorDof& dof = dofs_[k];
    double* const a = at[k].x;
    double carried = 0;
    if (dof.parent < 0) {
      for (int j = 0; j < 6; ++j) a[j] = dof.S.x[j] * v[k];
    } else {
      const double* const up = at[static_cast<std::size_t>(dof.parent)].x;
      carried = product(dof.U, up);
      for (int j = 0; j < 6; ++j) a[j] = up[j] + dof.S.x[j] * v[k];
    }
    w[k] = (dof.pivot * v[k] + carried) * dof.root;
  }
}

}  // namespace ugoki::dynamics
