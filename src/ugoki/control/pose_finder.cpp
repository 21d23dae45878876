#include "ugoki/control/pose_finder.h"

#include <algorithm>
#include <cmath>

#include "ugoki/dynamics/centroidal.h"
#include "ugoki/dynamics/dynamics.h"
#include "ugoki/mechanism/state.h"
#include "ugoki/spatial/elementary.h"

namespace ugoki::control {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

constexpr int limit_rounds = 3;
constexpr double damping = 1e-5;  // added to the diagonal of the normal equations, relative to goals of weight 1

}  // namespace

void clamp_to_limits(const Mechanism& m, std::span<double> q) {
  for (const Link& link : m.links()) {
    const Joint& joint = link.joint;
    if (joint.type == JointType::floating || joint.nv() == 0) continue;
    double x[6];
    double* own = q.data() + link.q_index;
    joint_displacement(joint, own, x);
    bool outside = false;
    for (int k = 0; k < joint.nv(); ++k) {
      const double inside = std::clamp(x[k], joint.dofs[at(k)].lower, joint.dofs[at(k)].upper);
      outside = outside || inside != x[k];
      x[k] = inside;
    }
    if (!outside) continue;
    if (joint.type == JointType::spherical) {
      const Quat r = exp_map({x[0], x[1], x[2]});
      own[0] = r.w;
      own[1] = r.x;
      own[2] = r.y;
      own[3] = r.z;
    } else {
      for (int k = 0; k < joint.nv(); ++k) own[k] = x[k];
    }
  }
}

PoseFinder::PoseFinder(MechanismPtr mechanism) : mechanism_(std::move(mechanism)), ws_(*mechanism_), n_(at(mechanism_->nv())) {
  q_.resize(at(mechanism_->nq()));
  for (std::vector<double>* v : {&zero_, &row_, &g_, &step_, &displacement_}) v->resize(n_);
  H_.resize(n_ * n_);
  L_.resize(n_ * n_);
  fixed_.resize(n_);
  A_G_.resize(n_);
}

void PoseFinder::begin(std::span<const double> q) {
  std::ranges::copy(q, q_.begin());
  dynamics::update_kinematics(*mechanism_, q_, zero_, ws_);
  std::ranges::fill(H_, 0);
  std::ranges::fill(g_, 0);
}

void PoseFinder::add_row(double error, double weight) {
  for (std::size_t i = 0; i < n_; ++i) {
    if (row_[i] == 0) continue;
    const double scaled = weight * row_[i];
    g_[i] += scaled * error;
    for (std::size_t j = 0; j <= i; ++j) H_[i * n_ + j] += scaled * row_[j];
  }
  std::ranges::fill(row_, 0);
}

void PoseFinder::add_point(int link, const Vec3& p, const Vec3& target, const Vec3& weights) {
  const Vec3 now = ws_.X_WB[at(link)] * p, error = target - now;
  for (int k = 0; k < 3; ++k) {
    if (weights[k] == 0) continue;
    for (const int i : dynamics::chain_of_link(ws_, link)) row_[at(i)] = (ws_.S[at(i)].v + cross(ws_.S[at(i)].w, now - ws_.p0))[k];
    add_row(error[k], weights[k]);
  }
}

void PoseFinder::add_centre(const Vec3& target, const Vec3& weights) {
  const Vec3 error = target - dynamics::calc_centroidal(*mechanism_, ws_).centre;
  dynamics::calc_centroidal_matrix(*mechanism_, ws_, A_G_);
  for (int k = 0; k < 3; ++k) {
    if (weights[k] == 0) continue;
    for (std::size_t i = 0; i < n_; ++i) row_[i] = A_G_[i].v[k] / mechanism_->mass();
    add_row(error[k], weights[k]);
  }
}

void PoseFinder::add_turn(int link, const Mat3& R_target, double weight) {
  const Vec3 error = log_map(to_quat(R_target * ws_.X_WB[at(link)].R.transposed()));
  for (int k = 0; k < 3; ++k) {
    for (const int i : dynamics::chain_of_link(ws_, link)) row_[at(i)] = ws_.S[at(i)].w[k];
    add_row(error[k], weight);
  }
}

void PoseFinder::add_axis(int link, const Vec3& axis, const Vec3& target, double weight) {
  const Vec3 now = ws_.X_WB[at(link)].R * axis, turn = cross(now, target);
  const double sine = norm(turn);
  const Vec3 direction = sine > 1e-9 ? turn / sine : any_perpendicular(now);
  const Vec3 error = direction * atan2(sine, dot(now, target));
  const Vec3 first = any_perpendicular(now), second = cross(now, first);
  for (const Vec3& d : {first, second}) {
    for (const int i : dynamics::chain_of_link(ws_, link)) row_[at(i)] = dot(ws_.S[at(i)].w, d);
    add_row(dot(error, d), weight);
  }
}

void PoseFinder::solve() {
  L_ = H_;
  for (std::size_t i = 0; i < n_; ++i)
    if (fixed_[i]) L_[i * n_ + i] += 1e9;
  // Cholesky factorization in place, then two triangular solves. The matrix is positive definite because of the damping.
  for (std::size_t j = 0; j < n_; ++j) {
    double* row_j = &L_[j * n_];
    for (std::size_t k = 0; k <= j; ++k) {
      const double* row_k = &L_[k * n_];
      double sum = row_j[k];
      for (std::size_t c = 0; c < k; ++c) sum -= row_j[c] * row_k[c];
      row_j[k] = k == j ? std::sqrt(std::max(sum, 1e-12)) : sum / row_k[k];
    }
  }
  for (std::size_t i = 0; i < n_; ++i) {
    double sum = g_[i];
    for (std::size_t c = 0; c < i; ++c) sum -= L_[i * n_ + c] * step_[c];
    step_[i] = sum / L_[i * n_ + i];
  }
  for (std::size_t i = n_; i-- > 0;) {
    double sum = step_[i];
    for (std::size_t c = i + 1; c < n_; ++c) sum -= L_[c * n_ + i] * step_[c];
    step_[i] = sum / L_[i * n_ + i];
  }
}

void PoseFinder::step(std::span<const double> preferred, double weight, double max_turn, std::span<double> q) {
  difference(*mechanism_, q_, preferred, displacement_);
  for (std::size_t i = 0; i < n_; ++i) {
    H_[i * n_ + i] += damping;
    if (i < 6) continue;
    H_[i * n_ + i] += weight;
    g_[i] += weight * displacement_[i];
  }
  for (const Link& link : mechanism_->links())
    joint_displacement(link.joint, q_.data() + link.q_index, displacement_.data() + link.v_index);
  std::ranges::fill(fixed_, 0);
  for (int round = 0; round < limit_rounds; ++round) {
    solve();
    // A coordinate at its limit does not move outwards; the others are solved for again.
    bool changed = false;
    for (std::size_t i = 6; i < n_; ++i) {
      const Dof& d = ws_.dofs[i];
      const bool outwards = (displacement_[i] >= d.upper - 1e-3 && step_[i] > 0) || (displacement_[i] <= d.lower + 1e-3 && step_[i] < 0);
      if (!outwards || fixed_[i]) continue;
      fixed_[i] = 1;
      changed = true;
    }
    if (!changed) break;
  }
  double largest = 0;
  for (const double s : step_) largest = std::max(largest, std::fabs(s));
  const double scale = largest > max_turn ? max_turn / largest : 1;
  integrate(*mechanism_, q_, step_, scale, q);
  clamp_to_limits(*mechanism_, q);
}

}  // namespace ugoki::control
