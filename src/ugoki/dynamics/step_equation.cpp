#include <algorithm>
#include <cmath>

#include "ugoki/dynamics/rotation_chart.h"
#include "ugoki/dynamics/step_method.h"
#include "ugoki/mechanism/state.h"

namespace ugoki::dynamics {
namespace {

int first_not_finite(std::span<const double> x) {
  for (std::size_t i = 0; i < x.size(); ++i)
    if (!std::isfinite(x[i])) return static_cast<int>(i);
  return -1;
}

/// True if the first three DOFs of the joint are an angular velocity whose coordinates are a quaternion.
bool turns_freely(JointType type) { return type == JointType::spherical || type == JointType::floating; }

}  // namespace

StepEquation::StepEquation(MotionSystem& system, const IntegratorOptions& options, IntegrationStatistics& statistics)
    : system_(system),
      options_(options),
      statistics_(statistics),
      n_(static_cast<std::size_t>(system.mechanism().nv())),
      q_(static_cast<std::size_t>(system.mechanism().nq())),
      size_(n_),
      z_(2 * n_),
      column_(2 * n_) {}

void StepEquation::begin(double t, std::span<const double> q0, std::span<const double> v0) {
  t0_ = t;
  q0_ = q0;
  v0_ = v0;
  for (const Link& link : system_.mechanism().links()) {
    const double* q = q0.data() + link.q_index;
    double* size = size_.data() + link.v_index;
    const bool free = turns_freely(link.joint.type);
    for (int k = 0; k < link.joint.nv(); ++k) size[k] = !free ? std::fabs(q[k]) : k < 3 ? 1.0 : std::fabs(q[k - 3]);
  }
}

void StepEquation::calc_configuration(const double* u, std::span<double> q) const {
  integrate(system_.mechanism(), q0_, std::span(u, n_), 1.0, q);
}

StepFailure StepEquation::calc_acceleration(double t, std::span<const double> q, std::span<const double> v, std::span<double> a) {
  ++statistics_.accelerations;
  if (const int bad = system_.calc_acceleration(t, q, v, a); bad >= 0) return {IntegrationStatus::singular, bad};
  if (const int bad = first_not_finite(a); bad >= 0) return {IntegrationStatus::not_finite, bad};
  return {};
}

StepFailure StepEquation::calc_rate(double t, const double* z, double* rate) {
  const double* v = z + n_;
  if (const int bad = first_not_finite(std::span(z, 2 * n_)); bad >= 0) return {IntegrationStatus::not_finite, bad % static_cast<int>(n_)};
  calc_configuration(z, q_);
  for (std::size_t i = 0; i < n_; ++i) rate[i] = v[i];
  for (const Link& link : system_.mechanism().links()) {
    if (!turns_freely(link.joint.type)) continue;
    const auto f = static_cast<std::size_t>(link.v_index);
    const Vec3 r = rotation_vector_rate({z[f], z[f + 1], z[f + 2]}, {v[f], v[f + 1], v[f + 2]});
    for (int k = 0; k < 3; ++k) rate[f + static_cast<std::size_t>(k)] = r[k];
  }
  return calc_acceleration(t, q_, std::span(v, n_), std::span(rate + n_, n_));
}

double StepEquation::norm(const double* z1, const double* x) const {
  double sum = 0;
  for (std::size_t i = 0; i < n_; ++i) {
    const double e_u = x[i] / (options_.absolute_tolerance + options_.relative_tolerance * size_[i]);
    const double speed = std::max(std::fabs(v0_[i]), std::fabs(z1[n_ + i]));
    const double e_v = x[n_ + i] / (options_.absolute_tolerance + options_.relative_tolerance * speed);
    sum += e_u * e_u + e_v * e_v;
  }
  return n_ > 0 ? std::sqrt(sum / static_cast<double>(2 * n_)) : 0;
}

StepFailure StepEquation::calc_jacobian(std::span<const double> a0, std::span<double> da_du, std::span<double> da_dv) {
  ++statistics_.jacobians;
  if (system_.calc_acceleration_jacobian(t0_, q0_, v0_, da_du, da_dv)) {
    if (first_not_finite(da_du) < 0 && first_not_finite(da_dv) < 0) return {};
  }
  for (std::size_t j = 0; j < 2 * n_; ++j) {
    for (std::size_t i = 0; i < n_; ++i) {
      z_[i] = 0;
      z_[n_ + i] = v0_[i];
    }
    const double size = j < n_ ? size_[j] : std::fabs(v0_[j - n_]);
    const double step = 1.5e-8 * std::max(size, 1e-2);
    z_[j] += step;
    if (const StepFailure bad = calc_rate(t0_, z_.data(), column_.data()); bad.failed()) return bad;
    const std::span<double> out = j < n_ ? da_du : da_dv;
    for (std::size_t i = 0; i < n_; ++i) out[i * n_ + j % n_] = (column_[n_ + i] - a0[i]) / step;
  }
  return {};
}

}  // namespace ugoki::dynamics
