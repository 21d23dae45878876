// Constraint rows of every loop type: Jacobian rows and velocity products compared with finite differences along the motion.

#include "ugoki/dynamics/loop_rows.h"

#include <gtest/gtest.h>

#include "random_loops.h"
#include "ugoki/dynamics/dynamics.h"
#include "ugoki/dynamics/integrators.h"

namespace ugoki::dynamics {
namespace {

using testing::RandomSource;

struct Case : testing::RandomLoops {
  using RandomLoops::RandomLoops;

  /// Rows after motion with constant acceleration `vdot` for time t. @param rates [rows, out] J v at that time; null: not computed
  LoopRows rows_at(double t, std::span<const double> vdot, std::vector<double>* rates = nullptr) const {
    State s = state;
    for (std::size_t i = 0; i < s.v.size(); ++i) s.v[i] += 0.5 * t * vdot[i];  // mean velocity: accurate to second order
    integrate(*m, state.q, s.v, t, s.q);
    for (std::size_t i = 0; i < s.v.size(); ++i) s.v[i] = state.v[i] + t * vdot[i];
    Workspace ws(*m);
    update_kinematics(*m, s.q, s.v, ws);
    LoopRows rows(loops);
    update_loop_rows(*m, ws, loops, s.q, s.v, rows);
    if (rates) {
      std::vector<double> J(static_cast<std::size_t>(m->nv()));
      for (std::size_t i = 0; i < loops.size(); ++i)
        for (int r = 0; r < loops[i].rows(); ++r) {
          calc_loop_jacobian_row(*m, ws, loops[i], rows, static_cast<int>(i), r, J);
          double rate = 0;
          for (std::size_t k = 0; k < J.size(); ++k) rate += J[k] * s.v[k];
          rates->push_back(rate);
        }
    }
    return rows;
  }
};

TEST(LoopRows, GapsAreZeroWhereFramesCoincide) {
  for (unsigned seed = 1; seed < 20; ++seed) {
    const Case c(seed);
    const LoopRows rows = c.rows_at(0, c.state.v);
    for (std::size_t i = 0; i + 1 < c.loops.size(); ++i)
      for (auto k = static_cast<std::size_t>(rows.first[i]); k < static_cast<std::size_t>(rows.first[i + 1]); ++k)
        EXPECT_NEAR(rows.gap[k], 0, 1e-12) << name_of(c.loops[i].type) << ", seed " << seed;
  }
}

TEST(LoopRows, JacobianIsTheRateOfTheGap) {
  const double h = 1e-5;
  for (unsigned seed = 1; seed < 20; ++seed) {
    // Rotation rows are the exact rate of their gap only if the loop is closed; all other rows are exact everywhere.
    for (const bool closed : {true, false}) {
      const Case c(seed, closed);
      const std::vector<double> zero(c.state.v.size());
      std::vector<double> rates;
      c.rows_at(0, zero, &rates);
      const LoopRows before = c.rows_at(-h, zero), after = c.rows_at(h, zero);
      for (std::size_t i = 0; i < c.loops.size(); ++i) {
        const LoopType type = c.loops[i].type;
        if (!closed && (type == LoopType::weld || type == LoopType::prismatic)) continue;
        for (auto k = static_cast<std::size_t>(before.first[i]); k < static_cast<std::size_t>(before.first[i + 1]); ++k)
          EXPECT_NEAR((after.gap[k] - before.gap[k]) / (2 * h), rates[k], 1e-6 * (1 + std::fabs(rates[k])))
              << name_of(type) << ", seed " << seed << (closed ? "" : ", open");
      }
    }
  }
}

TEST(LoopRows, VelocityProductsMatchRateOfVelocityRows) {
  const double h = 1e-6;
  for (unsigned seed = 1; seed < 20; ++seed) {
    const Case c(seed, false);
    RandomSource random(seed + 1000);
    std::vector<double> vdot(c.state.v.size());
    for (double& a : vdot) a = random.uniform(-3, 3);
    Workspace ws(*c.m);
    update_kinematics(*c.m, c.state.q, c.state.v, ws);
    LoopRows rows(c.loops);
    update_loop_rows(*c.m, ws, c.loops, c.state.q, c.state.v, rows);
    std::vector<double> products(static_cast<std::size_t>(rows.count())), J(c.state.v.size()), before, after;
    calc_loop_velocity_products(*c.m, ws, c.loops, rows, products);
    c.rows_at(-h, vdot, &before);
    c.rows_at(h, vdot, &after);
    for (std::size_t i = 0; i < c.loops.size(); ++i)
      for (int r = 0; r < c.loops[i].rows(); ++r) {
        const auto k = static_cast<std::size_t>(rows.first[i] + r);
        calc_loop_jacobian_row(*c.m, ws, c.loops[i], rows, static_cast<int>(i), r, J);
        double rate = products[k];
        for (std::size_t f = 0; f < J.size(); ++f) rate += J[f] * vdot[f];
        EXPECT_NEAR((after[k] - before[k]) / (2 * h), rate, 2e-5 * (1 + std::fabs(rate))) << name_of(c.loops[i].type) << ", seed " << seed;
      }
  }
}

}  // namespace
}  // namespace ugoki::dynamics
