#pragma once
// A reference method for the accelerations of closed link systems in maximal coordinates. It shares only the joints' motion subspaces
// with the production code. Every link is a free body; joints and loops are conditions between two bodies. By Gauss's principle of least
// constraint, the accelerations are those that satisfy the conditions and are nearest, in the norm of the masses, to the accelerations of
// the free bodies.

#include <array>
#include <cmath>
#include <vector>

#include "ugoki/mechanism/state.h"

namespace ugoki::testing {

/// A mechanism with loops in maximal coordinates. `m` and `loops` must outlive it.
class MaximalCoordinates {
 public:
  MaximalCoordinates(const Mechanism& m, const std::vector<Loop>& loops) : m_(m), loops_(loops) {}

  /// [links] Angular acceleration, and linear acceleration of the centre of mass, in world axes. Armature is not included.
  std::vector<Vec6> accelerations(const State& s, const Vec3& gravity) {
    const std::size_t n = 6 * static_cast<std::size_t>(m_.link_count());
    place(s.q);
    const std::vector<double> V = velocities(s);
    std::vector<double> a = free_accelerations(s, V, gravity);
    const std::vector<std::vector<double>> rows = conditions(s.q);
    const std::vector<double> rates = rates_of_conditions(s, V);
    // Gram-Schmidt in the norm of the inverse masses: each condition corrects only the part not determined by the conditions before it
    std::vector<std::vector<double>> basis, images;
    for (std::size_t k = 0; k < rows.size(); ++k) {
      std::vector<double> c = rows[k];
      double rate = rates[k];
      const double before = dot_product(c, times_inverse_mass(c));
      for (int pass = 0; pass < 2; ++pass)
        for (std::size_t j = 0; j < basis.size(); ++j) {
          const double part = dot_product(c, images[j]);
          for (std::size_t i = 0; i < n; ++i) c[i] -= part * basis[j][i];
          rate -= part * basis_rates_[j];
        }
      std::vector<double> image = times_inverse_mass(c);
      const double size = dot_product(c, image);
      if (k == 0) basis_rates_.clear();
      if (!(size > 1e-16 * before) || !(before > 1e-20)) continue;
      const double scale = 1 / std::sqrt(size);
      for (std::size_t i = 0; i < n; ++i) {
        c[i] *= scale;
        image[i] *= scale;
      }
      rate *= scale;
      const double violation = dot_product(c, a) + rate;
      for (std::size_t i = 0; i < n; ++i) a[i] -= violation * image[i];
      basis.push_back(c);
      images.push_back(image);
      basis_rates_.push_back(rate);
    }
    rank_ = static_cast<int>(basis.size());
    std::vector<Vec6> out;
    for (std::size_t i = 0; i < n; i += 6) out.push_back({{a[i], a[i + 1], a[i + 2]}, {a[i + 3], a[i + 4], a[i + 5]}});
    return out;
  }

  /// Number of independent conditions (joints and loops) in the last call of accelerations().
  [[nodiscard]] int rank() const { return rank_; }

  /// The accelerations that result from q, v, vdot, by finite differences along the motion; for comparison with accelerations().
  std::vector<Vec6> accelerations_of(const State& s, const std::vector<double>& vdot) {
    constexpr double h = 3e-4, weight[4] = {1.0 / 12, -8.0 / 12, 8.0 / 12, -1.0 / 12};
    constexpr int offset_of[4] = {-2, -1, 1, 2};
    std::vector<Vec6> out(static_cast<std::size_t>(m_.link_count()));
    State at = s;
    for (int k = 0; k < 4; ++k) {
      const double t = h * offset_of[k];
      std::vector<double> mean(s.v.size());
      for (std::size_t i = 0; i < mean.size(); ++i) {
        mean[i] = s.v[i] + 0.5 * t * vdot[i];
        at.v[i] = s.v[i] + t * vdot[i];
      }
      integrate(m_, s.q, mean, t, at.q);
      place(at.q);
      const std::vector<double> V = velocities(at);
      for (std::size_t i = 0; i < out.size(); ++i)
        out[i] += Vec6{{V[6 * i], V[6 * i + 1], V[6 * i + 2]}, {V[6 * i + 3], V[6 * i + 4], V[6 * i + 5]}} * (weight[k] / h);
    }
    return out;
  }

 private:
  static double dot_product(const std::vector<double>& a, const std::vector<double>& b) {
    double sum = 0;
    for (std::size_t i = 0; i < a.size(); ++i) sum += a[i] * b[i];
    return sum;
  }

  void place(const std::vector<double>& q) {
    X_.resize(static_cast<std::size_t>(m_.link_count()));
    calc_poses(m_, q, X_);
    q_ = q;
  }
  [[nodiscard]] Pose pose(int link) const { return link < 0 ? Pose{} : X_[static_cast<std::size_t>(link)]; }
  [[nodiscard]] Vec3 centre(int link) const {
    const Link& l = m_.link(link);
    return pose(link) * (l.inertia.h / l.inertia.mass);
  }
  /// Rotational inertia about the centre of mass, world axes.
  [[nodiscard]] Mat3 central_inertia(int link) const {
    const Link& l = m_.link(link);
    const Vec3 c = l.inertia.h / l.inertia.mass;
    const Mat3 I = (l.inertia.I - point_inertia(c) * l.inertia.mass).matrix();
    return pose(link).R * I * pose(link).R.transposed();
  }

  std::vector<double> velocities(const State& s) const {
    std::vector<Vec6> V(static_cast<std::size_t>(m_.link_count()));
    calc_velocities(m_, s.q, s.v, V);
    std::vector<double> out;
    for (int i = 0; i < m_.link_count(); ++i) {
      const Vec6 B = V[static_cast<std::size_t>(i)];
      const Vec3 w = pose(i).R * B.w, v = pose(i).R * B.v + cross(w, centre(i) - pose(i).p);
      out.insert(out.end(), {w.x, w.y, w.z, v.x, v.y, v.z});
    }
    return out;
  }

  std::vector<double> times_inverse_mass(const std::vector<double>& c) const {
    std::vector<double> out(c.size());
    for (int i = 0; i < m_.link_count(); ++i) {
      const auto k = static_cast<std::size_t>(6 * i);
      const Vec3 w = inverse(central_inertia(i)) * Vec3{c[k], c[k + 1], c[k + 2]};
      const double mass = m_.link(i).inertia.mass;
      const double values[6] = {w.x, w.y, w.z, c[k + 3] / mass, c[k + 4] / mass, c[k + 5] / mass};
      for (std::size_t j = 0; j < 6; ++j) out[k + j] = values[j];
    }
    return out;
  }

  /// Adds `sign` times the wrench f (moment about p; force) to the wrench on a link in F. Wrenches in F are about the centres of mass.
  void add_wrench(std::vector<double>& F, int link, const Vec3& p, const Vec6& f, double sign) const {
    if (link < 0) return;
    const auto k = static_cast<std::size_t>(6 * link);
    const Vec3 moment = f.w + cross(p - centre(link), f.v);
    for (int j = 0; j < 3; ++j) {
      F[k + static_cast<std::size_t>(j)] += sign * moment[j];
      F[k + 3 + static_cast<std::size_t>(j)] += sign * f.v[j];
    }
  }

  std::vector<double> free_accelerations(const State& s, const std::vector<double>& V, const Vec3& gravity) const {
    std::vector<double> F(V.size());
    for (int i = 0; i < m_.link_count(); ++i) {
      const Link& l = m_.link(i);
      const auto k = static_cast<std::size_t>(6 * i);
      const Vec3 w{V[k], V[k + 1], V[k + 2]};
      add_wrench(F, i, centre(i), {-cross(w, central_inertia(i) * w), gravity * l.inertia.mass}, 1);
      add_wrench(F, i, {}, s.external[static_cast<std::size_t>(i)], 1);
      Vec6 S[6];
      const int nv = joint_subspace(l.joint, s.q.data() + l.q_index, S);
      const std::vector<Vec6> dual = dual_basis(std::vector<Vec6>(S, S + nv));
      Vec6 f;
      for (int j = 0; j < nv; ++j) f += dual[static_cast<std::size_t>(j)] * s.tau[static_cast<std::size_t>(l.v_index + j)];
      const Vec6 f_W{pose(i).R * f.w, pose(i).R * f.v};
      add_wrench(F, i, pose(i).p, f_W, 1);
      add_wrench(F, l.parent, pose(i).p, f_W, -1);
    }
    return times_inverse_mass(F);
  }

  /// Dual basis D of S in the span of S: D_i . S_j = 1 if i = j, otherwise 0.
  static std::vector<Vec6> dual_basis(const std::vector<Vec6>& S) {
    std::vector<Vec6> D = S;
    const std::size_t n = S.size();
    std::vector<double> G(n * n), inverse_G(n * n);
    for (std::size_t i = 0; i < n; ++i)
      for (std::size_t j = 0; j < n; ++j) {
        G[i * n + j] = dot(S[i], S[j]);
        inverse_G[i * n + j] = i == j ? 1 : 0;
      }
    for (std::size_t k = 0; k < n; ++k) {  // Gauss-Jordan elimination; a Gram matrix needs no pivoting
      const double pivot = G[k * n + k];
      for (std::size_t j = 0; j < n; ++j) {
        G[k * n + j] /= pivot;
        inverse_G[k * n + j] /= pivot;
      }
      for (std::size_t i = 0; i < n; ++i) {
        if (i == k) continue;
        const double f = G[i * n + k];
        for (std::size_t j = 0; j < n; ++j) {
          G[i * n + j] -= f * G[k * n + j];
          inverse_G[i * n + j] -= f * inverse_G[k * n + j];
        }
      }
    }
    for (std::size_t i = 0; i < n; ++i) {
      D[i] = {};
      for (std::size_t j = 0; j < n; ++j) D[i] += S[j] * inverse_G[i * n + j];
    }
    return D;
  }

  /// Appends six conditions: the velocity of b relative to a, at the point p in the axes R, has no component outside the span of `allowed`.
  /// The number of independent conditions is 6 minus the number of allowed motions.
  void forbid(std::vector<std::vector<double>>& rows, int a, int b, const Vec3& p, const Mat3& R, const std::vector<Vec6>& allowed) const {
    const std::vector<Vec6> dual = dual_basis(allowed);
    for (int k = 0; k < 6; ++k) {
      Vec6 f;
      (k < 3 ? f.w[k] : f.v[k - 3]) = 1;
      const Vec6 unit = f;
      for (std::size_t j = 0; j < allowed.size(); ++j) f -= allowed[j] * dot(dual[j], unit);
      // f is now orthogonal to the allowed motions, because the projector is symmetric
      std::vector<double> row(6 * static_cast<std::size_t>(m_.link_count()));
      const Vec6 f_W{R * f.w, R * f.v};
      add_wrench(row, b, p, f_W, 1);
      add_wrench(row, a, p, f_W, -1);
      rows.push_back(std::move(row));
    }
  }

  std::vector<std::vector<double>> conditions(const std::vector<double>& q) {
    place(q);
    std::vector<std::vector<double>> rows;
    for (int i = 0; i < m_.link_count(); ++i) {
      const Link& l = m_.link(i);
      Vec6 S[6];
      const int nv = joint_subspace(l.joint, q.data() + l.q_index, S);
      forbid(rows, l.parent, i, pose(i).p, pose(i).R, std::vector<Vec6>(S, S + nv));
    }
    for (const Loop& loop : loops_) add_loop(rows, loop);
    return rows;
  }

  void add_loop(std::vector<std::vector<double>>& rows, const Loop& loop) const {
    if (loop.type == LoopType::gear) return add_gear(rows, loop);
    const Pose A = pose(loop.link_a) * loop.X_AJ, B = pose(loop.link_b) * loop.X_BJ;
    const Vec3 e = loop.axis, u = any_perpendicular(e), w = cross(e, u), zero{};
    const Vec3 second = transpose_times(A.R, B.R * loop.axis2);
    std::vector<Vec6> allowed;
    switch (loop.type) {
      case LoopType::weld: break;
      case LoopType::ball: allowed = {{{1, 0, 0}, zero}, {{0, 1, 0}, zero}, {{0, 0, 1}, zero}}; break;
      case LoopType::revolute: allowed = {{e, zero}}; break;
      case LoopType::prismatic: allowed = {{zero, e}}; break;
      case LoopType::cylindrical: allowed = {{e, zero}, {zero, e}}; break;
      case LoopType::planar: allowed = {{e, zero}, {zero, u}, {zero, w}}; break;
      case LoopType::universal: allowed = {{e, zero}, {second, zero}}; break;
      default: {
        std::vector<double> row(6 * static_cast<std::size_t>(m_.link_count()));
        const Vec6 f{{}, normalized(B.p - A.p)};
        add_wrench(row, loop.link_b, B.p, f, 1);
        add_wrench(row, loop.link_a, A.p, f, -1);
        rows.push_back(std::move(row));
        return;
      }
    }
    forbid(rows, loop.link_a, loop.link_b, B.p, A.R, allowed);
  }

  void add_gear(std::vector<std::vector<double>>& rows, const Loop& loop) const {
    std::vector<double> row(6 * static_cast<std::size_t>(m_.link_count()));
    const auto add = [&](int dof, double factor) {
      const int i = m_.link_of_dof(dof);
      const Link& l = m_.link(i);
      Vec6 S[6];
      const int nv = joint_subspace(l.joint, q_.data() + l.q_index, S);
      const Vec6 f = dual_basis(std::vector<Vec6>(S, S + nv))[static_cast<std::size_t>(dof - l.v_index)];
      const Vec6 f_W{pose(i).R * f.w, pose(i).R * f.v};
      add_wrench(row, i, pose(i).p, f_W, factor);
      add_wrench(row, l.parent, pose(i).p, f_W, -factor);
    };
    const Link& lb = m_.link(m_.link_of_dof(loop.dof_b));
    double x[6];
    joint_displacement(lb.joint, q_.data() + lb.q_index, x);
    const double xb = x[loop.dof_b - lb.v_index];
    double slope = 0;
    for (int k = 1; k < 5; ++k) slope += k * loop.polynomial[static_cast<std::size_t>(k)] * std::pow(xb, k - 1);
    add(loop.dof_a, 1);
    add(loop.dof_b, -slope);
    rows.push_back(std::move(row));
  }

  /// (dC/dt) V, where the rows of C are the conditions and V are the velocities of the bodies; by finite differences of order 4.
  std::vector<double> rates_of_conditions(const State& s, const std::vector<double>& V) {
    constexpr double h = 3e-4, weight[4] = {1.0 / 12, -8.0 / 12, 8.0 / 12, -1.0 / 12};
    constexpr int offset_of[4] = {-2, -1, 1, 2};
    std::vector<double> out, q(s.q.size());
    for (int k = 0; k < 4; ++k) {
      integrate(m_, s.q, s.v, h * offset_of[k], q);
      const std::vector<std::vector<double>> rows = conditions(q);
      out.resize(rows.size());
      for (std::size_t i = 0; i < rows.size(); ++i) out[i] += weight[k] / h * dot_product(rows[i], V);
    }
    place(s.q);
    return out;
  }

  const Mechanism& m_;
  const std::vector<Loop>& loops_;
  std::vector<Pose> X_;
  std::vector<double> q_, basis_rates_;
  int rank_ = 0;
};

}  // namespace ugoki::testing
