#include "ugoki/control/quadratic_program.h"

#include <CGAL/Gmpzf.h>
#include <CGAL/QP_functions.h>
#include <CGAL/QP_models.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

namespace ugoki::control {
namespace {

/// A random program with all kinds of rows.
struct Program {
  int n, m;
  double eps = 0.01;
  std::vector<double> w, x0;
  struct Row {
    std::vector<double> c, g;  // g is empty for equations
    double lower, upper, softness;
  };
  std::vector<Row> rows;

  Program(int n_, int m_, int equations, int equalities, int limits, std::mt19937_64& engine) : n(n_), m(m_) {
    std::uniform_real_distribution<double> unit(-1, 1);
    for (int i = 0; i < n; ++i) {
      w.push_back(0.1 + std::fabs(unit(engine)));
      x0.push_back(unit(engine));
    }
    for (int r = 0; r < equations + equalities + limits; ++r) {
      Row row;
      for (int i = 0; i < n; ++i) row.c.push_back(unit(engine));
      if (r >= equations)
        for (int k = 0; k < m; ++k) row.g.push_back(unit(engine));
      row.softness = r % 3 == 0 ? 0 : 0.05 * (1 + unit(engine));
      row.lower = row.upper = unit(engine);
      if (r >= equations + equalities) {
        row.softness = 1e-3;  // limits of a random program can contradict each other
        row.lower -= 0.3;
        row.upper += 0.3;
        if (r % 4 == 0) row.upper = std::numeric_limits<double>::infinity();
        if (r % 4 == 1) row.lower = -std::numeric_limits<double>::infinity();
      }
      rows.push_back(row);
    }
  }

  void give(QuadraticProgram& to) const {
    to.begin(n, m, eps);
    std::ranges::copy(w, to.weights().begin());
    std::ranges::copy(x0, to.centre().begin());
    for (const Row& r : rows) {
      if (r.g.empty()) {
        std::ranges::copy(r.c, to.add_equation(r.lower, r.softness).begin());
      } else {
        const QuadraticProgram::Balance b = to.add_balance(r.lower, r.upper, r.softness);
        std::ranges::copy(r.c, b.c.begin());
        std::ranges::copy(r.g, b.g.begin());
      }
    }
  }
};

/// Returns the exact rational solution by CGAL: x, then beta. Unknowns are x, beta, and one slack for each soft row.
std::vector<double> solve_exactly(const Program& p) {
  CGAL::Quadratic_program<double> qp(CGAL::EQUAL, false, 0, false, 0);
  for (int i = 0; i < p.n; ++i) {
    qp.set_d(i, i, p.w[static_cast<std::size_t>(i)]);  // set_d takes twice the coefficient of x^2
    qp.set_c(i, -p.w[static_cast<std::size_t>(i)] * p.x0[static_cast<std::size_t>(i)]);
  }
  for (int k = 0; k < p.m; ++k) {
    qp.set_d(p.n + k, p.n + k, p.eps);
    qp.set_l(p.n + k, true, 0);
  }
  int next = p.n + p.m, row = 0;
  for (const Program::Row& r : p.rows) {
    const int slack = r.softness > 0 ? next++ : -1;
    if (slack >= 0) qp.set_d(slack, slack, 1 / r.softness);
    const auto add = [&](double bound, CGAL::Comparison_result relation) {
      if (std::isinf(bound)) return;
      for (int i = 0; i < p.n; ++i) qp.set_a(i, row, r.c[static_cast<std::size_t>(i)]);
      for (std::size_t k = 0; k < r.g.size(); ++k) qp.set_a(p.n + static_cast<int>(k), row, r.g[k]);
      if (slack >= 0) qp.set_a(slack, row, 1);
      qp.set_b(row, bound);
      qp.set_r(row, relation);
      ++row;
    };
    if (r.lower == r.upper) {
      add(r.lower, CGAL::EQUAL);
    } else {
      add(r.lower, CGAL::LARGER);
      add(r.upper, CGAL::SMALLER);
    }
  }
  const auto solution = CGAL::solve_quadratic_program(qp, CGAL::Gmpzf());
  EXPECT_TRUE(solution.is_optimal());
  std::vector<double> out;
  int count = 0;
  for (auto v = solution.variable_values_begin(); count < p.n + p.m; ++v, ++count) out.push_back(CGAL::to_double(*v));
  return out;
}

TEST(QuadraticProgram, MatchesExactRationalSolver) {
  std::mt19937_64 engine(7);
  QuadraticProgram program;
  for (int trial = 0; trial < 60; ++trial) {
    const Program p(6, 8, trial % 4, 2, trial % 5, engine);
    p.give(program);
    EXPECT_TRUE(program.solve()) << "trial " << trial;
    const std::vector<double> exact = solve_exactly(p);
    for (int i = 0; i < p.n; ++i)
      EXPECT_NEAR(program.x()[static_cast<std::size_t>(i)], exact[static_cast<std::size_t>(i)], 1e-6) << "trial " << trial;
    for (int k = 0; k < p.m; ++k)
      EXPECT_NEAR(program.loads()[static_cast<std::size_t>(k)], exact[static_cast<std::size_t>(p.n + k)], 1e-6) << "trial " << trial;
  }
}

TEST(QuadraticProgram, ConvergesWithManyNearlyParallelLimits) {
  // Limits whose rows are nearly parallel: in a Newton step for all of them, some multipliers would get the wrong sign.
  std::mt19937_64 engine(5);
  QuadraticProgram program;
  for (int trial = 0; trial < 200; ++trial) {
    Program p(6, 8, 2, 2, 8, engine);
    p.eps = 1e-4;
    for (std::size_t r = 5; r < p.rows.size(); ++r) {
      for (std::size_t i = 0; i < p.rows[r].c.size(); ++i) p.rows[r].c[i] = p.rows[4].c[i] + 0.05 * p.rows[r].c[i];
      for (std::size_t k = 0; k < p.rows[r].g.size(); ++k) p.rows[r].g[k] = p.rows[4].g[k] + 0.05 * p.rows[r].g[k];
    }
    p.give(program);
    EXPECT_TRUE(program.solve()) << "trial " << trial;
    if (trial % 10 != 0) continue;
    const std::vector<double> exact = solve_exactly(p);
    for (std::size_t i = 0; i < 6; ++i) EXPECT_NEAR(program.x()[i], exact[i], 1e-6) << "trial " << trial;
  }
}

TEST(QuadraticProgram, StartAndLaterBalancesDoNotChangeTheSolution) {
  std::mt19937_64 engine(11);
  std::uniform_real_distribution<double> unit(-1, 1);
  QuadraticProgram cold, warm, grown;
  for (int trial = 0; trial < 40; ++trial) {
    const Program p(10, 12, 3, 4, 4, engine);
    p.give(cold);
    ASSERT_TRUE(cold.solve());
    p.give(warm);
    std::vector<double> start(4);
    for (double& z : start) z = unit(engine);
    ASSERT_TRUE(warm.solve(start));
    Program first = p;
    first.rows.resize(p.rows.size() - 2);
    first.give(grown);
    ASSERT_TRUE(grown.solve());
    for (std::size_t r = first.rows.size(); r < p.rows.size(); ++r) {
      const QuadraticProgram::Balance b = grown.add_balance(p.rows[r].lower, p.rows[r].upper, p.rows[r].softness);
      std::ranges::copy(p.rows[r].c, b.c.begin());
      std::ranges::copy(p.rows[r].g, b.g.begin());
    }
    ASSERT_TRUE(grown.solve());
    for (std::size_t i = 0; i < 10; ++i) {
      EXPECT_NEAR(warm.x()[i], cold.x()[i], 1e-8);
      EXPECT_NEAR(grown.x()[i], cold.x()[i], 1e-8);
    }
  }
}

TEST(QuadraticProgram, StartFromTheSolutionNeedsNoStep) {
  std::mt19937_64 engine(3);
  const Program p(20, 16, 6, 6, 0, engine);
  QuadraticProgram program;
  p.give(program);
  ASSERT_TRUE(program.solve());
  EXPECT_GT(program.iterations(), 1);
  const std::vector<double> z(program.balance_multipliers().begin(), program.balance_multipliers().end());
  p.give(program);
  ASSERT_TRUE(program.solve(z));
  EXPECT_LE(program.iterations(), 1);
}

TEST(QuadraticProgram, LimitThatIsNotReachedHasNoEffect) {
  QuadraticProgram program;
  program.begin(2, 0, 1);
  program.centre()[0] = 1;
  const QuadraticProgram::Balance far = program.add_balance(-5, 5, 0);
  far.c[0] = far.c[1] = 1;
  ASSERT_TRUE(program.solve());
  EXPECT_DOUBLE_EQ(program.x()[0], 1);
  EXPECT_DOUBLE_EQ(program.balance_multipliers()[0], 0);
  const QuadraticProgram::Balance near = program.add_balance(-1e300, 0.5, 0);
  near.c[0] = 1;
  ASSERT_TRUE(program.solve());
  EXPECT_NEAR(program.x()[0], 0.5, 1e-12);
  EXPECT_LT(program.balance_multipliers()[1], 0);
}

}  // namespace
}  // namespace ugoki::control
