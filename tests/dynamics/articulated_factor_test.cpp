#include "ugoki/dynamics/articulated_factor.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "random_mechanism.h"
#include "ugoki/dynamics/dynamics.h"
#include "ugoki/dynamics/kernels.h"

namespace ugoki::dynamics {
namespace {

using testing::RandomSource;

struct Case {
  explicit Case(unsigned seed) : random(seed) {
    m = Mechanism::make(random_spec(random, 1 + random.below(25), {}, seed % 2 == 0)).value();
    ws = std::make_unique<Workspace>(*m);
    State s(*m);
    randomize(random, *m, s);
    update_kinematics(*m, s.q, s.v, *ws);
    extra.resize(s.v.size());
    for (double& x : extra) x = random.below(2) == 0 ? random.uniform(0, 0.2) : 0;
    calc_inertia_rows(*m, *ws);
    matrix_ok = dynamics::factor(*ws, extra) < 0;
    by_bodies = std::make_unique<ArticulatedFactor>(*m);
    bodies_ok = by_bodies->factor(*ws, extra) < 0;
  }
  std::vector<double> vector() {
    std::vector<double> x(extra.size());
    for (double& e : x) e = random.uniform(-1, 1);
    return x;
  }
  RandomSource random;
  MechanismPtr m;
  std::unique_ptr<Workspace> ws;
  std::unique_ptr<ArticulatedFactor> by_bodies;
  std::vector<double> extra;
  bool matrix_ok = false, bodies_ok = false;
};

void expect_near(std::span<const double> a, std::span<const double> b, double relative, const char* label) {
  double scale = 1e-12;
  for (const double x : b) scale = std::max(scale, std::fabs(x));
  for (std::size_t i = 0; i < b.size(); ++i) EXPECT_NEAR(a[i], b[i], relative * scale) << label << ", entry " << i;
}

// The second method is the sparse factor of the inertia matrix (calc_inertia_rows, factor). The tolerance allows for the condition number
// of M (up to 1e5 here).
constexpr double tolerance = 1e-9;

TEST(ArticulatedFactor, AgreesWithTheSparseFactor) {
  for (unsigned seed = 1; seed <= 80; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Case c(seed);
    ASSERT_TRUE(c.matrix_ok && c.bodies_ok);
    const std::size_t n = c.extra.size();
    for (std::size_t k = 0; k < n; ++k)
      EXPECT_NEAR(c.by_bodies->inverse_pivot(k) / c.ws->D_inverse[k], 1, tolerance) << "pivot of degree of freedom " << k;

    const std::vector<double> x = c.vector();
    std::vector<double> a = x, b = x;
    c.by_bodies->solve(a);
    solve(*c.ws, b);
    expect_near(a, b, tolerance, "solution");

    // The velocity change of a whitened impulse w is L^-1 D^-1/2 w.
    std::vector<double> change(n, 0.0), expected(n);
    c.by_bodies->add_whitened(x, change);
    for (std::size_t k = 0; k < n; ++k) {
      double sum = x[k] * std::sqrt(c.ws->D_inverse[k]);
      for (int d = 0; d < c.ws->depth[k]; ++d)
        sum -= c.ws->L[static_cast<std::size_t>(c.ws->row_start[k] + d)] *
               expected[static_cast<std::size_t>(c.ws->chain[static_cast<std::size_t>(c.ws->row_start[k] + d)])];
      expected[k] = sum;
    }
    expect_near(change, expected, tolerance, "velocity change");
  }
}

TEST(ArticulatedFactor, HasTheSameBitsForAllSimdWidths) {
  for (unsigned seed = 1; seed <= 40; ++seed) {
    Case c(seed);
    const std::size_t n = c.extra.size();
    const std::vector<double> x = c.vector();
    const Vec6 wrenches[3] = {{c.random.vec(1), c.random.vec(1)}, {c.random.vec(1), c.random.vec(1)}, {c.random.vec(1), c.random.vec(1)}};
    std::vector<double> first;
    for (const SimdWidth width : {SimdWidth::plain, SimdWidth::avx2, SimdWidth::avx512}) {
      if (!use_simd(width)) continue;
      ASSERT_LT(c.by_bodies->factor(*c.ws, c.extra), 0);
      std::vector<double> results = x, change(n, 0.5), y(4 * n);
      c.by_bodies->solve(results);
      c.by_bodies->add_whitened(x, change);
      c.by_bodies->whiten_wrenches(static_cast<int>(n) - 1, wrenches, y.data());
      for (const std::vector<double>& more : {change, y}) results.insert(results.end(), more.begin(), more.end());
      for (std::size_t k = 0; k < n; ++k) results.push_back(c.by_bodies->pivot(k));
      if (width == SimdWidth::plain) first = results;
      EXPECT_EQ(std::memcmp(results.data(), first.data(), first.size() * sizeof(double)), 0) << "seed " << seed;
    }
    use_simd(widest_simd());
  }
}

TEST(ArticulatedFactor, WhitensRowsLikeTheSparseFactor) {
  for (unsigned seed = 1; seed <= 80; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Case c(seed);
    ASSERT_TRUE(c.matrix_ok && c.bodies_ok);
    const auto whiten = [&](int last, std::span<double> y) {
      apply_inverse_transposed_factor(*c.ws, last, y);
      for (std::size_t e = 0; e < y.size(); ++e) {
        const int dof = c.ws->chain[static_cast<std::size_t>(c.ws->row_start[static_cast<std::size_t>(last)]) + e];
        y[e] *= std::sqrt(c.ws->D_inverse[static_cast<std::size_t>(dof)]);
      }
    };
    for (int link = 0; link < c.m->link_count(); ++link) {
      const std::span<const int> chain = chain_of_link(*c.ws, link);
      if (chain.empty()) continue;
      const int last = chain.back();
      Vec6 f[3];
      for (Vec6& wrench : f) wrench = {c.random.vec(1), c.random.vec(1)};
      std::vector<double> y(4 * chain.size(), NAN), row(chain.size());
      c.by_bodies->whiten_wrenches(last, f, y.data());
      for (int r = 0; r < 3; ++r) {
        for (std::size_t e = 0; e < row.size(); ++e) row[e] = dot(f[r], c.ws->S[static_cast<std::size_t>(chain[e])]);
        whiten(last, row);
        std::vector<double> lane(row.size());
        for (std::size_t e = 0; e < row.size(); ++e) lane[e] = y[4 * e + static_cast<std::size_t>(r)];
        expect_near(lane, row, tolerance, "wrench");
      }
      for (std::size_t e = 0; e < row.size(); ++e) EXPECT_EQ(y[4 * e + 3], 0);
      const std::size_t count = 1 + static_cast<std::size_t>(c.random.below(static_cast<int>(chain.size())));
      for (std::size_t e = 0; e < row.size(); ++e) row[e] = e + count < row.size() ? 0 : c.random.uniform(-1, 1);
      c.by_bodies->whiten_row(last, std::span(row).last(count), y.data());
      whiten(last, row);
      std::vector<double> lane(row.size());
      for (std::size_t e = 0; e < row.size(); ++e) lane[e] = y[4 * e];
      expect_near(lane, row, tolerance, "row");
    }
  }
}
/// A free body with a turned joint, an off-centre centre of mass and random principal axes.
MechanismPtr free_body(RandomSource& random) {
  MechanismSpec spec;
  LinkSpec link;
  link.name = "body";
  link.joint.type = JointType::floating;
  link.joint.X_PJ = {to_matrix(exp_map(random.vec(2))), random.vec(1)};
  const Mat3 R = to_matrix(exp_map(random.vec(2)));
  link.inertia = Inertia::from_centre(random.uniform(0.1, 5), random.vec(0.5), rotated(Sym3{1, 1.5, 2, 0, 0, 0}, R));
  spec.links.push_back(link);
  return Mechanism::make(spec).value();
}

// The second method is the sparse factor of the inertia matrix, and for whiten_velocity() the identity y . w = J v.
TEST(ArticulatedFactor, FreeBodyHasTheSparseFactorInClosedForm) {
  for (unsigned seed = 1; seed <= 40; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    RandomSource random(seed);
    const MechanismPtr m = free_body(random);
    ASSERT_TRUE(FreeBodyFactor::applies_to(*m));
    Workspace ws(*m);
    State s(*m);
    randomize(random, *m, s);
    update_kinematics(*m, s.q, s.v, ws);
    calc_inertia_rows(*m, ws);
    ASSERT_EQ(dynamics::factor(ws, {}), -1);
    ArticulatedFactor factor(*m);
    ASSERT_EQ(factor.factor(ws, std::vector<double>(6)), -1);
    for (std::size_t k = 0; k < 6; ++k) {
      EXPECT_NEAR(factor.inverse_pivot(k) / ws.D_inverse[k], 1, 1e-12);
      EXPECT_NEAR(factor.pivot(k) * ws.D_inverse[k], 1, 1e-12);
    }
    std::vector<double> x(6), v(6), w(6), row(6);
    for (std::size_t k = 0; k < 6; ++k) x[k] = random.uniform(-1, 1), v[k] = random.uniform(-1, 1);
    std::vector<double> a = x, b = x;
    factor.solve(a);
    solve(ws, b);
    expect_near(a, b, 1e-12, "solution");
    Vec6 f[3];
    for (Vec6& wrench : f) wrench = {random.vec(1), random.vec(1)};
    std::vector<double> y(24, NAN);
    factor.whiten_wrenches(5, f, y.data());
    factor.whiten_velocity(v, w);
    for (std::size_t r = 0; r < 3; ++r) {
      double velocity = 0, whitened = 0;
      for (std::size_t k = 0; k < 6; ++k) {
        row[k] = dot(f[r], ws.S[k]);
        velocity += row[k] * v[k];
        whitened += y[4 * k + r] * w[k];
        EXPECT_EQ(y[4 * k + 3], 0);
      }
      EXPECT_NEAR(velocity, whitened, 1e-12);
      apply_inverse_transposed_factor(ws, 5, row);
      for (std::size_t k = 0; k < 6; ++k) EXPECT_NEAR(y[4 * k + r], row[k] * std::sqrt(ws.D_inverse[k]), 1e-12);
    }
    // J M^-1 J^T of one row on all DOFs, and the velocity change of a unit impulse along it.
    factor.whiten_row(5, x, y.data());
    std::vector<double> change(6), lane(6);
    for (std::size_t k = 0; k < 6; ++k) lane[k] = y[4 * k];
    factor.add_whitened(lane, change);
    expect_near(change, b, 1e-12, "velocity change");
    // Moments alone, as for rolling resistance: rows on the rotations only.
    for (Vec6& wrench : f) wrench.v = {};
    std::vector<double> short_y(12, NAN);
    factor.whiten_wrenches(2, f, short_y.data());
    factor.whiten_wrenches(5, f, y.data());
    for (std::size_t e = 0; e < 12; ++e) EXPECT_EQ(short_y[e], y[e]);
    // With a damper the recursion takes over.
    const std::vector<double> extra = {0.1, 0, 0, 0, 0.2, 0};
    ASSERT_EQ(factor.factor(ws, extra), -1);
    calc_inertia_rows(*m, ws);
    ASSERT_EQ(dynamics::factor(ws, extra), -1);
    a = b = x;
    factor.solve(a);
    solve(ws, b);
    expect_near(a, b, 1e-12, "solution with damping");
  }
}

/// Factors, solutions and velocity changes of several mechanisms in turn, with scratch memory of their own or shared by all.
TEST(ArticulatedFactor, SharedScratchMemoryHasNoEffect) {
  FactorScratch scratch;
  std::vector<Case> cases;
  for (unsigned seed = 1; seed <= 6; ++seed) cases.emplace_back(seed);
  std::vector<std::vector<double>> input, own;
  const auto results = [&](std::size_t k) {
    Case& c = cases[k];
    EXPECT_LT(c.by_bodies->factor(*c.ws, c.extra), 0);
    std::vector<double> x = input[k], w(x.size());
    c.by_bodies->solve(x);
    c.by_bodies->add_whitened(input[k], x);
    c.by_bodies->whiten_velocity(x, w);
    x.insert(x.end(), w.begin(), w.end());
    return x;
  };
  for (std::size_t k = 0; k < cases.size(); ++k) {
    input.push_back(cases[k].vector());
    own.push_back(results(k));
    cases[k].by_bodies->make_room(scratch);
  }
  for (const int round : {0, 1})
    for (std::size_t k = 0; k < cases.size(); ++k) {
      cases[k].by_bodies->use(scratch);
      EXPECT_EQ(results(k), own[k]) << "mechanism " << k << ", round " << round;
    }
}

TEST(ArticulatedFactor, NamesTheDofThatMovesNoInertia) {
  MechanismSpec spec;
  LinkSpec link;
  link.name = "a";
  link.joint.type = JointType::revolute;
  link.inertia = Inertia::from_centre(1, {1, 0, 0}, {});
  spec.links.push_back(link);
  link.name = "b";
  link.parent = "a";
  link.joint.type = JointType::prismatic;
  link.joint.dofs[0].armature = 1;
  link.inertia = {};
  spec.links.push_back(link);
  const MechanismPtr m = Mechanism::make(spec).value();
  Workspace ws(*m);
  const State s(*m);
  update_kinematics(*m, s.q, s.v, ws);
  ws.armature[1] = 0;
  ArticulatedFactor factor(*m);
  EXPECT_EQ(factor.factor(ws, {}), 1);
  const std::vector<double> extra = {0, 0.5};
  EXPECT_EQ(factor.factor(ws, extra), -1);
  EXPECT_DOUBLE_EQ(factor.inverse_pivot(1), 2);
}

}  // namespace
}  // namespace ugoki::dynamics
