#include "ugoki/dynamics/jacobian.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "random_mechanism.h"
#include "ugoki/dynamics/dynamics.h"

namespace ugoki::dynamics {
namespace {

using testing::RandomSource;

struct Scene {
  MechanismPtr m;
  State s;
  Workspace ws;
  std::vector<double> vdot;
  Vec3 local{0.11, -0.23, 0.31};
  int a, b;

  explicit Scene(unsigned seed) : Scene(seed, RandomSource(seed)) {}
  Scene(unsigned seed, RandomSource random) : m(Mechanism::make(random_spec(random, 16, {}, seed % 2 == 0)).value()), s(*m), ws(*m) {
    randomize(random, *m, s);
    vdot.resize(s.v.size());
    for (double& x : vdot) x = random.uniform(-5, 5);
    a = random.below(m->link_count());
    b = m->link_count() - 1 - random.below(3);
    update_kinematics(*m, s.q, s.v, ws);
  }
  std::size_t n() const { return s.v.size(); }
  Vec3 point(const Workspace& at) const { return at.X_WB[static_cast<std::size_t>(b)] * local; }

  /// Kinematics at time t of a motion: q displaced by (v + vdot t / 2) t. Velocity and acceleration at t = 0 are v and vdot of the scene.
  Workspace at_time(double t) const {
    Workspace out(*m);
    std::vector<double> q(s.q.size()), v(n()), mean(n());
    for (std::size_t i = 0; i < n(); ++i) {
      v[i] = s.v[i] + t * vdot[i];
      mean[i] = s.v[i] + 0.5 * t * vdot[i];
    }
    integrate(*m, s.q, mean, t, q);
    update_kinematics(*m, q, v, out);
    return out;
  }
};

/// Derivative of f at t = 0 by central differences with Richardson extrapolation to fourth order.
template <class F>
auto rate_of(F f, double h = 1e-3) {
  const auto slope = [&](double k) { return (f(k) - f(-k)) * (0.5 / k); };
  return slope(0.5 * h) * (4.0 / 3) - slope(h) * (1.0 / 3);
}

double size(const Vec6& x) { return norm(x.w) + norm(x.v); }

Vec6 product(const Workspace& ws, int link, std::span<const Vec6> columns, std::span<const double> x) {
  Vec6 out;
  const std::span<const int> chain = chain_of_link(ws, link);
  for (std::size_t k = 0; k < chain.size(); ++k) out += columns[k] * x[static_cast<std::size_t>(chain[k])];
  return out;
}

Vec6 product(std::span<const double> J, std::span<const double> x) {
  double y[6] = {};
  for (std::size_t r = 0; r < 6; ++r)
    for (std::size_t k = 0; k < x.size(); ++k) y[r] += J[r * x.size() + k] * x[k];
  return {{y[0], y[1], y[2]}, {y[3], y[4], y[5]}};
}

/// Twist of the moving pose X(t) at t = 0 by finite differences: angular velocity from R' R^T, linear velocity p'.
/// @param body true: in body axes; false: in world axes
Vec6 twist_of(const std::function<Pose(double)>& X, bool body) {
  const Mat3 R = X(0).R;
  const Mat3 W = rate_of([&](double t) { return X(t).R; }) * R.transposed();
  const Vec3 w = Vec3{W.zy - W.yz, W.xz - W.zx, W.yx - W.xy} * 0.5;
  const Vec3 v = rate_of([&](double t) { return X(t).p; });
  return body ? Vec6{transpose_times(R, w), transpose_times(R, v)} : Vec6{w, v};
}

TEST(Jacobian, TimesVelocityIsTheRateOfThePose) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    const Scene c(seed);
    std::vector<Vec6> J(c.n());
    for (const JacobianFrame frame : {JacobianFrame::world, JacobianFrame::body}) {
      const bool body = frame == JacobianFrame::body;
      calc_jacobian(c.ws, c.b, frame, c.point(c.ws), J);
      const Vec6 V = product(c.ws, c.b, J, c.s.v);
      const Vec6 expected = twist_of(
          [&](double t) {
            const Pose X = c.at_time(t).X_WB[static_cast<std::size_t>(c.b)];
            return body ? X : Pose{X.R, X * c.local};
          },
          body);
      EXPECT_LT(size(V - expected), 1e-7 * (1 + size(expected))) << "seed " << seed << " body " << body;
    }
  }
}

TEST(Jacobian, RateIsTheDerivativeOfItsEntries) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    const Scene c(seed);
    std::vector<Vec6> S_dot(c.n()), J(c.n()), J_dot(c.n());
    calc_subspace_rates(*c.m, c.ws, S_dot);
    for (const JacobianFrame frame : {JacobianFrame::world, JacobianFrame::body}) {
      calc_jacobian_rate(c.ws, S_dot, c.b, frame, c.point(c.ws), J_dot);
      for (std::size_t k = 0; k < chain_of_link(c.ws, c.b).size(); ++k) {
        const Vec6 expected = rate_of([&](double t) {
          const Workspace at = c.at_time(t);
          calc_jacobian(at, c.b, frame, c.point(at), J);
          return J[k];
        });
        EXPECT_LT(size(J_dot[k] - expected), 1e-7 * (1 + size(expected))) << "seed " << seed << " column " << k;
      }
      const Vec6 bias = calc_jacobian_bias(*c.m, c.ws, c.b, frame, c.point(c.ws));
      EXPECT_LT(size(product(c.ws, c.b, J_dot, c.s.v) - bias), 1e-11 * (1 + size(bias))) << "seed " << seed;
    }
  }
}

TEST(RelativeJacobian, TimesVelocityIsTheRateOfTheRelativePose) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    Scene c(seed);
    for (const int a : {c.a, -1}) {
      const auto pose = [&](double t) {
        const Workspace at = c.at_time(t);
        const Pose X_WA = a < 0 ? Pose{} : at.X_WB[static_cast<std::size_t>(a)];
        return X_WA.inverse() * Pose{at.X_WB[static_cast<std::size_t>(c.b)].R, c.point(at)};
      };
      std::vector<double> J(6 * c.n()), J_dot(6 * c.n());
      std::vector<Vec6> S_dot(c.n());
      calc_relative_jacobian(c.ws, a, c.b, c.point(c.ws), J);
      const Vec6 V = product(J, c.s.v), expected = twist_of(pose, false);
      EXPECT_LT(size(V - expected), 1e-7 * (1 + size(expected))) << "seed " << seed;

      calc_subspace_rates(*c.m, c.ws, S_dot);
      calc_relative_jacobian_rate(c.ws, S_dot, a, c.b, c.point(c.ws), J_dot);
      const Vec6 rate = product(J, c.vdot) + product(J_dot, c.s.v);
      const Vec6 expected_rate = rate_of([&](double t) {
        const Workspace at = c.at_time(t);
        std::vector<double> J_at(6 * c.n()), v(c.n());
        for (std::size_t i = 0; i < v.size(); ++i) v[i] = c.s.v[i] + t * c.vdot[i];
        calc_relative_jacobian(at, a, c.b, c.point(at), J_at);
        return product(J_at, v);
      });
      EXPECT_LT(size(rate - expected_rate), 1e-7 * (1 + size(expected_rate))) << "seed " << seed;
    }
  }
}

TEST(Jacobian, ExpandsToAllDofs) {
  const Scene c(3);
  std::vector<Vec6> J(c.n());
  std::vector<double> full(6 * c.n()), relative(6 * c.n());
  calc_jacobian(c.ws, c.b, JacobianFrame::world, c.point(c.ws), J);
  expand_columns(c.ws, c.b, J, full);
  calc_relative_jacobian(c.ws, -1, c.b, c.point(c.ws), relative);
  EXPECT_EQ(full, relative);
}

}  // namespace
}  // namespace ugoki::dynamics
