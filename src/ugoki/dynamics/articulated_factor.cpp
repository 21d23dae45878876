#include "ugoki/dynamics/articulated_factor.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "ugoki/base/check.h"

namespace ugoki::dynamics {
namespace {

/// Three constraint rows in SIMD lanes; lane 3 is unused. Lanes do not affect each other, so any register width gives the same bits.
typedef double Four __attribute__((vector_size(32)));

/// Scalar product of two vectors of six elements: two independent sums of three products, so that the order of additions is fixed.
inline double product(const double* a, const double* b) {
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
  for (const Dof& dof : dofs_)
    if (dof.parent >= 0) ++children[static_cast<std::size_t>(dof.parent)];
  inertia_of_.assign(n, -1);
  for (std::size_t k = n; k-- > 0;) {
    if (inertia_of_[k] < 0) {
      inertia_of_[k] = static_cast<int>(inertia_dof_.size());
      inertia_dof_.push_back(static_cast<int>(k));
    }
    if (dofs_[k].parent < 0) continue;
    const auto parent = static_cast<std::size_t>(dofs_[k].parent);
    if (children[parent] == 1 && count[parent] == count[parent + 1]) inertia_of_[parent] = inertia_of_[k];
  }
  first_link_ = count;
  links_.resize(static_cast<std::size_t>(count[n]));
  for (int i = 0; i < m.link_count(); ++i)
    if (const int last = moved_by[static_cast<std::size_t>(i)]; last >= 0)
      links_[static_cast<std::size_t>(count[static_cast<std::size_t>(last)]++)] = i;
  make_room(own_);
}

void ArticulatedFactor::make_room(FactorScratch& scratch) const {
  scratch.inertias.resize(std::max(scratch.inertias.size(), 36 * inertia_dof_.size()));
  scratch.sweep.resize(std::max(scratch.sweep.size(), 6 * dofs_.size()));
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
  double* const inertias = scratch().inertias.data();
  const auto inertia_of = [&](std::size_t dof) { return inertias + 36 * static_cast<std::size_t>(inertia_of_[dof]); };
  for (const int dof : inertia_dof_) {
    const auto k = static_cast<std::size_t>(dof);
    double* const A = inertia_of(k);
    std::fill_n(A, 36, 0.0);
    for (int l = first_link_[k]; l < first_link_[k + 1]; ++l) {
      const Inertia& I = ws.I[static_cast<std::size_t>(links_[static_cast<std::size_t>(l)])];
      A[0] += I.I.xx;
      A[1] += I.I.xy;
      A[2] += I.I.xz;
      A[7] += I.I.yy;
      A[8] += I.I.yz;
      A[14] += I.I.zz;
      A[4] -= I.h.z;
      A[5] += I.h.y;
      A[11] -= I.h.x;
      A[21] += I.mass;
    }
    A[6] = A[1];
    A[12] = A[2];
    A[13] = A[8];
    A[9] = -A[4];
    A[15] = -A[5];
    A[16] = -A[11];
    // The lower left block is the transpose of the upper right one.
    for (int r = 0; r < 3; ++r)
      for (int c = 0; c < 3; ++c) A[6 * (3 + r) + c] = A[6 * c + 3 + r];
    A[28] = A[35] = A[21];
  }
  for (std::size_t k = n; k-- > 0;) {
    Dof& dof = dofs_[k];
    double* const A = inertia_of(k);
    const Vec6& S = ws.S[k];
    const double s[6] = {S.w.x, S.w.y, S.w.z, S.v.x, S.v.y, S.v.z};
    double u[6];
    for (int j = 0; j < 6; ++j) u[j] = A[j] * s[0];
    for (int i = 1; i < 6; ++i)
      for (int j = 0; j < 6; ++j) u[j] += A[6 * i + j] * s[i];
    const double pivot = product(s, u) + ws.armature[k] + (extra.empty() ? 0.0 : extra[k]);
    if (!(pivot > 0) || !std::isfinite(pivot)) return static_cast<int>(k);
    dof.pivot = pivot;
    dof.inverse = 1 / pivot;
    dof.root = std::sqrt(dof.inverse);
    std::memcpy(dof.S, s, sizeof s);
    std::memcpy(dof.U, u, sizeof u);
    if (dof.parent < 0) continue;
    double* const up = inertia_of(static_cast<std::size_t>(dof.parent));
    if (up == A) {
      for (int i = 0; i < 6; ++i) {
        const double t = u[i] * dof.inverse;
        for (int j = 0; j < 6; ++j) A[6 * i + j] -= t * u[j];
      }
      continue;
    }
    for (int i = 0; i < 6; ++i) {
      const double t = u[i] * dof.inverse;
      for (int j = 0; j < 6; ++j) up[6 * i + j] += A[6 * i + j] - t * u[j];
    }
  }
  return -1;
}

void ArticulatedFactor::solve(std::span<double> x) const {
  if (closed_form_) return body_->solve(x);
  const std::size_t n = dofs_.size();
  UGOKI_CHECK(x.size() == n);
  double* const at = scratch().sweep.data();
  std::memset(at, 0, 6 * n * sizeof(double));
  for (std::size_t k = n; k-- > 0;) {
    const Dof& dof = dofs_[k];
    double* const f = at + 6 * k;
    x[k] = dof.inverse * (x[k] - product(dof.S, f));
    if (dof.parent < 0) continue;
    double* const up = at + 6 * static_cast<std::size_t>(dof.parent);
    for (int j = 0; j < 6; ++j) up[j] += f[j] + dof.U[j] * x[k];
  }
  for (std::size_t k = 0; k < n; ++k) {
    const Dof& dof = dofs_[k];
    double* const a = at + 6 * k;
    if (dof.parent < 0) {
      for (int j = 0; j < 6; ++j) a[j] = dof.S[j] * x[k];
      continue;
    }
    const double* const up = at + 6 * static_cast<std::size_t>(dof.parent);
    x[k] -= dof.inverse * product(dof.U, up);
    for (int j = 0; j < 6; ++j) a[j] = up[j] + dof.S[j] * x[k];
  }
}

void ArticulatedFactor::whiten_wrenches(int last, const Vec6* f, double* y) const {
  if (closed_form_) return body_->whiten_wrenches(last, f, y);
  Four w[6] = {{f[0].w.x, f[1].w.x, f[2].w.x, 0}, {f[0].w.y, f[1].w.y, f[2].w.y, 0}, {f[0].w.z, f[1].w.z, f[2].w.z, 0},
               {f[0].v.x, f[1].v.x, f[2].v.x, 0}, {f[0].v.y, f[1].v.y, f[2].v.y, 0}, {f[0].v.z, f[1].v.z, f[2].v.z, 0}};
  for (int k = last; k >= 0;) {
    const Dof& dof = dofs_[static_cast<std::size_t>(k)];
    const Four s = (dof.S[0] * w[0] + dof.S[1] * w[1] + dof.S[2] * w[2]) + (dof.S[3] * w[3] + dof.S[4] * w[4] + dof.S[5] * w[5]);
    const Four out = s * dof.root, t = s * dof.inverse;
    std::memcpy(y + 4 * dof.depth, &out, sizeof out);
    for (int j = 0; j < 6; ++j) w[j] -= dof.U[j] * t;
    k = dof.parent;
  }
}

void ArticulatedFactor::whiten_row(int last, std::span<const double> tail, double* y) const {
  if (closed_form_) return body_->whiten_row(last, tail, y);
  double f[6] = {};
  std::size_t left = tail.size();
  for (int k = last; k >= 0;) {
    const Dof& dof = dofs_[static_cast<std::size_t>(k)];
    double s = product(dof.S, f);
    if (left > 0) s += tail[--left];
    const double t = s * dof.inverse;
    const Four out = {s * dof.root, 0, 0, 0};
    std::memcpy(y + 4 * dof.depth, &out, sizeof out);
    for (int j = 0; j < 6; ++j) f[j] -= dof.U[j] * t;
    k = dof.parent;
  }
}

void ArticulatedFactor::add_whitened(std::span<const double> w, std::span<double> v) const {
  if (closed_form_) return body_->add_whitened(w, v);
  const std::size_t n = dofs_.size();
  UGOKI_CHECK(w.size() == n && v.size() == n);
  double* const at = scratch().sweep.data();
  for (std::size_t k = 0; k < n; ++k) {
    const Dof& dof = dofs_[k];
    double* const a = at + 6 * k;
    double change = w[k] * dof.root;
    if (dof.parent < 0) {
      for (int j = 0; j < 6; ++j) a[j] = dof.S[j] * change;
    } else {
      const double* const up = at + 6 * static_cast<std::size_t>(dof.parent);
      change -= dof.inverse * product(dof.U, up);
      for (int j = 0; j < 6; ++j) a[j] = up[j] + dof.S[j] * change;
    }
    v[k] += change;
  }
}

void ArticulatedFactor::whiten_velocity(std::span<const double> v, std::span<double> w) const {
  if (closed_form_) return body_->whiten_velocity(v, w);
  const std::size_t n = dofs_.size();
  UGOKI_CHECK(w.size() == n && v.size() == n);
  double* const at = scratch().sweep.data();
  for (std::size_t k = 0; k < n; ++k) {
    const Dof& dof = dofs_[k];
    double* const a = at + 6 * k;
    double carried = 0;
    if (dof.parent < 0) {
      for (int j = 0; j < 6; ++j) a[j] = dof.S[j] * v[k];
    } else {
      const double* const up = at + 6 * static_cast<std::size_t>(dof.parent);
      carried = product(dof.U, up);
      for (int j = 0; j < 6; ++j) a[j] = up[j] + dof.S[j] * v[k];
    }
    w[k] = (dof.pivot * v[k] + carried) * dof.root;
  }
}

}  // namespace ugoki::dynamics
