// VelocitySolver alone, on rows written by hand.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "ugoki/contact/velocity_solver.h"

namespace ugoki::contact {
namespace {

/// A foot slides fast over the ground while it closes. Friction changes its normal velocity twice as much as an equal normal impulse does.
/// If normal and friction impulse are solved alternately, the iteration oscillates between three nonzero impulses and zero.
TEST(VelocitySolver, FastSlidingContactDoesNotKeepClosing) {
  constexpr double mu = 0.85, closing = -0.4;
  for (const double lift : {-2.0, 0.5, 2.0}) {
    for (const double sliding : {-4.7, 0.3, 4.7}) {
      VelocitySolver solver;
      solver.set_systems(std::array{0, 3});
      solver.begin_block(RowKind::contact, 1).mu = mu;
      const double rows[9] = {1, 0, 0, lift, 1, 0, 0, 0, 1};
      std::ranges::copy(rows, solver.add_segment(0, nullptr, 3).begin());
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

}  // namespace
}  // namespace ugoki::contact
