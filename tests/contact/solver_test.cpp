// VelocitySolver alone, on rows written by hand.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <vector>

#include "ugoki/contact/solver_kernels.h"
#include "ugoki/contact/velocity_solver.h"

namespace ugoki::contact {
namespace {

/// A foot slides fast over the ground and approaches the ground. Friction changes its normal velocity twice as much as an equal normal
/// impulse does. If normal and friction impulse are solved alternately, the iteration oscillates between three nonzero impulses and zero.
TEST(VelocitySolver, FastSlidingContactDoesNotKeepClosing) {
  constexpr double mu = 0.85, closing = -0.4;
  for (const double lift : {-2.0, 0.5, 2.0}) {
    for (const double sliding : {-4.7, 0.3, 4.7}) {
      VelocitySolver solver;
      solver.set_systems(std::array{0, 3});
      solver.begin_block(RowKind::contact, 1).mu = mu;
      const double entries[12] = {1, lift, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};  // for each DOF the entries of the three rows and a zero
      std::ranges::copy(entries, solver.add_segment(0, nullptr, 3).begin());
      const double target[3] = {closing, sliding, 0};
      solver.end_block(target, {});
      solver.solve({.iterations = 200, .tolerance = 1e-12, .softness = 0});
      const auto p = solver.impulses(solver.blocks()[0]);
      const double u = closing + p[0] + lift * p[1], slip = sliding + lift * p[0] + (lift * lift + 1) * p[1];
      const double jams =
          1 -
          mu * lift *
              (sliding > 0 ? 1 : -1);  // at or below zero: friction presses the foot down more than the normal impulse lifts it (jamming)
      if (jams <= 0) continue;
      EXPECT_GE(u, -1e-9) << "lift " << lift << ", sliding at " << sliding;
      EXPECT_LE(std::fabs(p[1]), mu * p[0] + 1e-12);
      EXPECT_LE(slip * p[1], 1e-9) << "friction should be opposed to the sliding";
      EXPECT_NEAR(u * p[0], 0, 1e-9);
    }
  }
}

/// Random constraint rows on one system: contacts, limits and dry friction.
struct RandomIsland {
  static constexpr int dofs = 24;
  VelocitySolver solver;
  std::vector<std::vector<double>> rows;  // [rows][dofs]
  std::vector<double> target;

  explicit RandomIsland(unsigned seed) {
    std::mt19937_64 engine(seed);
    const auto uniform = [&](double low, double high) { return low + (high - low) * static_cast<double>(engine() >> 11) * 0x1p-53; };
    solver.set_systems(std::array{0, dofs});
    const int blocks = 2 + static_cast<int>(engine() % 7);  // at most 20 rows on 24 DOFs: the impulses are unique
    for (int i = 0; i < blocks; ++i) {
      const auto kind = i % 4 == 3 ? (i % 8 == 3 ? RowKind::limit : RowKind::friction) : RowKind::contact;
      RowBlock& b = solver.begin_block(kind, static_cast<std::uint64_t>(i) + 1);
      b.mu = uniform(0, 1.2);
      b.bound = uniform(0.01, 0.5);
      const int count = b.rows;
      const std::span<double> to = solver.add_segment(0, nullptr, dofs);
      double wanted[3];
      for (int r = 0; r < count; ++r) {
        std::vector<double>& row = rows.emplace_back();
        for (int k = 0; k < dofs; ++k) row.push_back(uniform(-1, 1));
        for (int k = 0; k < dofs; ++k) to[static_cast<std::size_t>(4 * k + r)] = row[static_cast<std::size_t>(k)];
        wanted[r] = uniform(-1, r == 0 ? 0.3 : 1);
        target.push_back(wanted[r]);
      }
      solver.end_block(std::span(wanted).first(static_cast<std::size_t>(count)), {});
    }
  }

  /// [rows] velocities at the solver's impulses.
  [[nodiscard]] std::vector<double> velocities() const {
    const std::span<const double> p = solver.impulses();
    std::vector<double> w(dofs, 0.0), u = target;
    for (std::size_t r = 0; r < rows.size(); ++r)
      for (int k = 0; k < dofs; ++k) w[static_cast<std::size_t>(k)] += rows[r][static_cast<std::size_t>(k)] * p[r];
    for (std::size_t r = 0; r < rows.size(); ++r)
      for (int k = 0; k < dofs; ++k) u[r] += rows[r][static_cast<std::size_t>(k)] * w[static_cast<std::size_t>(k)];
    return u;
  }

  /// Maximum violation of the laws of contact: natural residual p - projection(p - u) of the impulses p and velocities u.
  [[nodiscard]] double violation(double softness) const {
    const std::span<const double> p = solver.impulses();
    const std::vector<double> u = velocities();
    double worst = 0;
    for (const RowBlock& b : solver.blocks()) {
      const auto at = static_cast<std::size_t>(b.row);
      const auto residual = [&](double next, std::size_t r) { worst = std::max(worst, std::fabs(next - p[r])); };
      switch (b.kind) {
        case RowKind::contact: {
          residual(std::max(0.0, p[at] - (u[at] + softness / (1 + softness) * b.B[0] * p[at])), at);
          double t1 = p[at + 1] - u[at + 1], t2 = p[at + 2] - u[at + 2];
          const double size = std::hypot(t1, t2), radius = b.mu * p[at];
          if (size > radius) {
            t1 *= radius / size;
            t2 *= radius / size;
          }
          residual(t1, at + 1);
          residual(t2, at + 2);
          break;
        }
        case RowKind::limit: residual(std::max(0.0, p[at] - u[at]), at); break;
        default: residual(std::clamp(p[at] - u[at], -b.bound, b.bound), at); break;
      }
    }
    return worst;
  }
};

TEST(VelocitySolver, DenseIslandsSatisfyTheLawsAsSweepsDo) {
  int handed_over = 0, newton_steps = 0, sparse_steps = 0, compared = 0;
  for (unsigned seed = 0; seed < 400; ++seed) {
    RandomIsland dense(seed), swept(seed);
    const SolverReport report = dense.solver.solve({.iterations = 5000, .tolerance = 1e-11});
    handed_over += report.handed_over;
    newton_steps += report.newton_steps;
    EXPECT_LT(dense.violation(1e-4), 1e-8) << "seed " << seed;
    sparse_steps +=  // by sweeps and semi-smooth Newton steps on the velocities
        swept.solver.solve({.iterations = 5000, .tolerance = 1e-11, .softness = 1e-4, .max_dense_rows = 0}).newton_steps;
    if (swept.violation(1e-4) > 1e-9) continue;  // no convergence: no comparison
    ++compared;
    for (std::size_t r = 0; r < dense.target.size(); ++r)
      EXPECT_NEAR(dense.solver.impulses()[r], swept.solver.impulses()[r], 1e-7) << "seed " << seed << ", row " << r;
  }
  EXPECT_LT(handed_over, 40) << "of 400";
  EXPECT_GT(newton_steps, 200);
  EXPECT_GT(sparse_steps, 200);
  EXPECT_GT(compared, 380) << "of 400";
}

/// At a solution, the linear law of each block returns its impulse: the class and both Newton methods then agree with the contact laws.
TEST(VelocitySolver, LinearLawsContainTheSolution) {
  double worst = 0;
  for (unsigned seed = 0; seed < 100; ++seed) {
    RandomIsland island(seed);
    island.solver.solve({.iterations = 5000, .tolerance = 1e-12});
    if (island.violation(1e-4) > 1e-10) continue;
    const std::vector<double> u = island.velocities();
    for (const RowBlock& b : island.solver.blocks()) {
      const std::span<const double> p = island.solver.impulses(b);
      LinearLaw law;
      find_linear_law(b, 1, 0, p.data(), u.data() + b.row, law);
      for (std::size_t r = 0; r < static_cast<std::size_t>(b.rows); ++r) {
        double next = law.c[r];
        for (std::size_t c = 0; c < static_cast<std::size_t>(b.rows); ++c)
          next -= law.G[3 * r + c] * u[static_cast<std::size_t>(b.row) + c];
        worst = std::max(worst, std::fabs(next - p[r]));
      }
    }
  }
  EXPECT_LT(worst, 1e-5);  // the compliance and the regularization divide the velocities by 1e-4 and 1e-7 of the inverse inertia
}

TEST(VelocitySolver, DenseIslandRepeatsItsBits) {
  RandomIsland a(5), b(5);
  a.solver.solve({});
  b.solver.solve({});
  EXPECT_TRUE(std::ranges::equal(a.solver.impulses(), b.solver.impulses()));
}

TEST(VelocitySolver, SweepsHaveTheSameBitsForEveryWidth) {
  for (unsigned seed = 0; seed < 40; ++seed) {
    RandomIsland plain(seed), wide(seed);
    use_solver_kernels(false);
    plain.solver.solve({.iterations = 50, .max_dense_rows = 0});
    if (!use_solver_kernels(true)) GTEST_SKIP() << "the processor has no AVX2";
    wide.solver.solve({.iterations = 50, .max_dense_rows = 0});
    EXPECT_TRUE(std::ranges::equal(plain.solver.impulses(), wide.solver.impulses())) << "seed " << seed;
  }
}

}  // namespace
}  // namespace ugoki::contact
