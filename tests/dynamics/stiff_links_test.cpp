// Closed links with added stiffness, compared with the equations that define them and with solutions for unit impulses.

#include "ugoki/dynamics/stiff_links.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "allocation_count.h"
#include "random_loops.h"
#include "ugoki/dynamics/dynamics.h"

namespace ugoki::dynamics {
namespace {

using testing::RandomLoops;
using testing::RandomSource;

/// A random mechanism with up to four of nine loops closed, stiffness of up to 1e4 times the inertia on a third of the links, and additions
/// to the diagonal.
struct Case {
  explicit Case(unsigned seed, bool with_loops = true) : c(seed), random(seed + 700), ws(*c.m) {
    std::vector<char> closed(c.loops.size());
    for (int k = with_loops ? 1 + random.below(4) : 0; k-- > 0;)
      closed[static_cast<std::size_t>(random.below(static_cast<int>(closed.size())))] = 1;
    links = std::make_unique<StiffLinks>(*c.m, c.loops, closed);
    update_kinematics(*c.m, c.state.q, c.state.v, ws);
    const std::size_t n = c.state.v.size();
    extra.resize(n);
    for (double& x : extra) x = random.below(2) == 0 ? random.uniform(0, 0.2) : 0;
    K.resize(static_cast<std::size_t>(c.m->link_count()));
    for (ArticulatedInertia& k : K) {
      if (random.below(3) != 0) continue;
      const double scale = std::pow(10.0, random.below(5));
      for (int row = 0; row < 3; ++row) {
        const Vec6 w{random.vec(1), random.vec(1)};
        add_product(k, w, w * scale);
      }
    }
    links->update_rows(*c.m, ws, c.state.q, c.state.v);
    singular = links->factor(*c.m, ws, dependent_row, extra, {});
    if (singular < 0) singular = links->factor(*c.m, ws, dependent_row, extra, K);
  }
  std::vector<double> vector(std::size_t n) {
    std::vector<double> x(n);
    for (double& e : x) e = random.uniform(-1, 1);
    return x;
  }
  RandomLoops c;
  RandomSource random;
  Workspace ws;
  std::unique_ptr<StiffLinks> links;
  std::vector<double> extra;
  std::vector<ArticulatedInertia> K;
  int singular = 0;
};

TEST(StiffLinks, SolutionSatisfiesItsEquations) {
  for (unsigned seed = 1; seed <= 150; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Case c(seed);
    const Mechanism& m = *c.c.m;
    ASSERT_EQ(c.singular, -1);
    const std::size_t n = c.extra.size(), count = static_cast<std::size_t>(m.link_count());
    const std::vector<double> r = c.vector(n), v = c.vector(n), closing = c.vector(static_cast<std::size_t>(c.links->rows().count()));
    std::vector<Vec6> wrenches(count);
    for (Vec6& w : wrenches) w = {c.random.vec(1), c.random.vec(1)};
    std::vector<double> x(n), F(n), J(n);
    c.links->solve(m, c.ws, r, wrenches, v, closing, x);
    // F = (M + extra) x + sum J^T (K V + f) - r - J^T lambda, with J_i from the motion subspaces
    std::vector<Vec6> V(count), f(count);
    double size = 1;
    for (std::size_t i = 0; i < count; ++i) {
      for (const int k : chain_of_link(c.ws, static_cast<int>(i)))
        V[i] += c.ws.S[static_cast<std::size_t>(k)] * x[static_cast<std::size_t>(k)];
      const Vec6 stiff = product(c.K[i], V[i]);
      f[i] = c.ws.I[i] * V[i] + stiff + wrenches[i];
      size = std::max({size, norm(stiff.w), norm(stiff.v)});
      EXPECT_NEAR(norm(c.ws.A[i].v - V[i].v), 0, 1e-10 * (1 + norm(V[i].v))) << "velocity change of link " << i;
    }
    for (std::size_t k = 0; k < n; ++k) F[k] = (c.ws.armature[k] + c.extra[k]) * x[k] - r[k];
    for (std::size_t i = 0; i < count; ++i)
      for (const int k : chain_of_link(c.ws, static_cast<int>(i)))
        F[static_cast<std::size_t>(k)] += dot(c.ws.S[static_cast<std::size_t>(k)], f[i]);
    for (std::size_t i = 0; i < c.c.loops.size(); ++i) {
      if (!c.links->links().is_closed(static_cast<int>(i))) continue;
      for (int row = 0; row < c.c.loops[i].rows(); ++row) {
        const auto at = static_cast<std::size_t>(c.links->rows().first[i] + row);
        calc_loop_jacobian_row(m, c.ws, c.c.loops[i], c.links->rows(), static_cast<int>(i), row, J);
        const double lambda = c.links->links().multipliers()[at];
        double u = closing[at];
        for (std::size_t k = 0; k < n; ++k) {
          F[k] -= J[k] * lambda;
          u += J[k] * (v[k] + x[k]);
        }
        size = std::max(size, std::fabs(lambda));
        if (c.links->links().independent()[at]) EXPECT_NEAR(u, 0, 1e-8) << "loop " << i << " row " << row;
      }
    }
    for (std::size_t k = 0; k < n; ++k) EXPECT_NEAR(F[k], 0, 1e-9 * size) << "DOF " << k;
  }
}

// The second method is one solution for each unit impulse.
TEST(StiffLinks, ResponsesAreSolutionsForUnitImpulses) {
  int coupled = 0;
  for (unsigned seed = 1; seed <= 150; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Case c(seed, seed % 5 != 0);
    const Mechanism& m = *c.c.m;
    ASSERT_EQ(c.singular, -1);
    if (c.links->links().rank() > 6) ++coupled;
    const std::size_t n = c.extra.size(), count = static_cast<std::size_t>(m.link_count());
    const LinkResponses responses = c.links->calc_responses(m, c.ws);
    const std::vector<double> zeros(n);
    std::vector<double> x(n);
    for (std::size_t i = 0; i < count; ++i)
      for (int axis = 0; axis < 6; ++axis) {
        std::vector<Vec6> wrenches(count);
        Vec6 unit;
        (axis < 3 ? unit.w[axis] : unit.v[axis - 3]) = 1;
        wrenches[i] = -unit;
        c.links->solve(m, c.ws, zeros, wrenches, zeros, {}, x);
        const Vec6 expected = c.ws.A[i], actual = product(responses.link[i], unit);
        const double size = 1 + norm(expected.w) + norm(expected.v);
        EXPECT_LT(norm(actual.w - expected.w) + norm(actual.v - expected.v), 1e-8 * size) << "link " << i << " axis " << axis;
      }
    for (std::size_t k = 0; k < n; ++k) {
      std::vector<double> unit(n);
      unit[k] = 1;
      c.links->solve(m, c.ws, unit, {}, zeros, {}, x);
      EXPECT_NEAR(responses.dof[k], x[k], 1e-8 * (1 + x[k])) << "DOF " << k;
    }
  }
  EXPECT_GT(coupled, 20);
}

TEST(StiffLinks, AllocatesNothing) {
  Case c(7);
  const std::vector<double> zeros(c.extra.size());
  std::vector<double> x(c.extra.size());
  const long before = allocations_so_far();
  c.links->update_rows(*c.c.m, c.ws, c.c.state.q, c.c.state.v);
  EXPECT_EQ(c.links->factor(*c.c.m, c.ws, dependent_row, c.extra, c.K), -1);
  c.links->solve(*c.c.m, c.ws, zeros, {}, zeros, {}, x);
  (void)c.links->calc_responses(*c.c.m, c.ws);
  EXPECT_EQ(allocations_so_far(), before);
}

}  // namespace
}  // namespace ugoki::dynamics
