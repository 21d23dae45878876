// Rings of links whose joints permit only planar motion, only rotation about one point, or only translation. Most constraint
// rows of such a loop are zero, because no joint moves in their direction. In rotated frames their entries are rounding errors instead.

#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "dense_loops.h"
#include "random_mechanism.h"
#include "ugoki/dynamics/closed_links.h"

namespace ugoki::dynamics {
namespace {

using testing::RandomSource;

enum class RingKind { planar, spherical, sliding };

struct Ring {
  MechanismPtr m;
  State state;
  std::vector<Loop> loops;
};

/// A random rotation, or the identity.
Mat3 turned(RandomSource& random, bool turn) { return turn ? random.rotation() : Mat3::identity(); }

/// A random ring: a chain of links and one loop that closes it.
/// @param turn gives all frames random rotations, so that exact zeros become rounding errors
/// @param flat rad: above zero, the configuration is within this angle of a change point
/// @param ratio each mass is multiplied by a random factor between 1 / ratio and ratio
Ring make_ring(unsigned seed, RingKind kind, LoopType type, bool floating, bool turn, double flat, double ratio) {
  RandomSource random(seed);
  const int count = 4 + random.below(4);
  const Mat3 R = turned(random, turn);
  const Vec3 axis = R.column(2), origin = random.vec(1);
  MechanismSpec spec;
  spec.name = "ring";
  std::vector<Pose> X;
  std::vector<double> angles;
  double heading = 0;
  Vec3 at = origin;
  for (int i = 0; i < count; ++i) {
    LinkSpec l;
    l.name = "link" + std::to_string(i);
    if (i > 0) l.parent = "link" + std::to_string(i - 1);
    const Pose here{turned(random, turn), at};
    Vec3 along = axis;
    if (kind == RingKind::spherical) along = R * normalized(Vec3{random.uniform(-1, 1), random.uniform(-1, 1), 0.5});
    if (kind == RingKind::sliding) along = R * normalized(Vec3{random.uniform(-1, 1), random.uniform(-1, 1), 0});
    l.joint.type = i == 0 && floating ? JointType::floating : kind == RingKind::sliding ? JointType::prismatic : JointType::revolute;
    const double angle = random.uniform(-2, 2);
    if (l.joint.type != JointType::floating) {
      l.joint.axis = here.R.transposed() * along;
      Pose moved;
      if (kind == RingKind::sliding)
        moved.p = l.joint.axis * -angle;
      else
        moved.R = rotation_about(l.joint.axis, -angle);
      l.joint.X_PJ = (i > 0 ? X.back().inverse() : Pose{}) * here * moved;
      angles.push_back(angle);
    }
    l.inertia = testing::random_inertia(random);
    const double factor = std::pow(ratio, random.uniform(-1, 1));
    l.inertia = {l.inertia.mass * factor, l.inertia.h * factor, l.inertia.I * factor};
    X.push_back(here);
    spec.links.push_back(l);
    heading = flat > 0 ? flat * random.uniform(-1, 1) + (random.below(2) == 0 ? 0 : 3.14159265358979) : random.uniform(-3, 3);
    if (kind != RingKind::spherical) at += R * Vec3{std::cos(heading), std::sin(heading), 0} * random.uniform(0.2, 0.6);
    if (kind == RingKind::planar && turn) at += axis * random.uniform(-0.2, 0.2);
  }
  Ring out;
  out.m = *Mechanism::make(std::move(spec));
  out.state = State(*out.m);
  testing::randomize(random, *out.m, out.state);
  for (std::size_t k = 0; k < angles.size(); ++k) out.state.q[out.state.q.size() - angles.size() + k] = angles[k];
  Workspace ws(*out.m);
  update_kinematics(*out.m, out.state.q, out.state.v, ws);
  Loop l{.type = type, .link_a = floating ? 0 : -1, .link_b = count - 1};
  const Pose X_0 = floating ? ws.X_WB[0] * X[0].inverse() : Pose{};  // displacement of the entire ring
  const Mat3 R_J = turned(random, turn);
  const Vec3 in_plane = R * normalized(Vec3{random.uniform(-1, 1), random.uniform(-1, 1), 0});
  Vec3 loop_axis = axis;
  if (kind == RingKind::spherical && type != LoopType::planar) loop_axis = R * random.direction();
  if (type == LoopType::prismatic || (type == LoopType::planar && kind == RingKind::sliding)) loop_axis = in_plane;
  const Pose X_J = X_0 * Pose{R_J, kind == RingKind::spherical ? origin : at};
  l.axis = R_J.transposed() * loop_axis;
  l.axis2 = normalized(cross(l.axis, R_J.transposed() * (in_plane + loop_axis * 0.1)));
  l.length = 0.4;
  l.X_BJ = ws.X_WB.back().inverse() * X_J;
  l.X_AJ = (floating ? ws.X_WB[0].inverse() : Pose{}) * X_J;
  if (type == LoopType::distance) l.X_AJ = l.X_AJ * Pose{Mat3::identity(), R_J.transposed() * in_plane * l.length};
  out.loops.push_back(l);
  return out;
}

/// Relative errors of the forward dynamics of a ring.
struct Errors {
  double to_dense = 0;  ///< accelerations, compared with the dense solution
  double row = 0;       ///< acceleration along the independent constraint rows; should be zero
  double balance = 0;   ///< error of the joint forces, with the loop forces included
  int rank = 0;         ///< rank found by calc_closed_forward_dynamics()
  int dense_rank = 0;   ///< rank found by the dense solution
  int staged_rank = 0;  ///< rank found by factor_closed_links()
};

Errors errors_of(Ring& r) {
  const std::vector<char> closed(r.loops.size(), 1);
  Workspace ws(*r.m);
  ClosedLinks links(*r.m, r.loops, closed);
  update_kinematics(*r.m, r.state.q, r.state.v, ws);
  EXPECT_EQ(factor_closed_links(*r.m, ws, links, r.state.q, r.state.v), ClosedStatus::ok);
  Errors out;
  out.staged_rank = links.rank();
  project_velocity(*r.m, ws, links, r.state.v);
  const testing::Dense dense = testing::solve_by_kkt(*r.m, r.state, r.loops, closed);
  std::vector<double> vdot(r.state.v.size());
  EXPECT_EQ(calc_closed_forward_dynamics(*r.m, links, r.state.q, r.state.v, r.state.tau, {0, 0, -9.81}, r.state.external, vdot),
            ClosedStatus::ok);
  out.rank = links.rank();
  out.dense_rank = dense.rank;
  out.to_dense = testing::max_difference(vdot, dense.vdot);
  update_kinematics(*r.m, r.state.q, r.state.v, ws);
  LoopRows rows(r.loops);
  update_loop_rows(*r.m, ws, r.loops, r.state.q, r.state.v, rows);
  std::vector<double> products(static_cast<std::size_t>(rows.count())), J(vdot.size()), tau(vdot.size());
  calc_loop_velocity_products(*r.m, ws, r.loops, rows, products);
  calc_inverse_dynamics(*r.m, ws, vdot, {0, 0, -9.81}, r.state.external, tau);
  double size = 1, speed = 1;
  for (const double x : vdot) speed = std::max(speed, std::fabs(x));
  std::vector<double> rest(vdot.size());
  for (std::size_t f = 0; f < rest.size(); ++f) rest[f] = tau[f] - r.state.tau[f], size = std::max(size, std::fabs(tau[f]));
  for (int k = 0; k < rows.count(); ++k) {
    calc_loop_jacobian_row(*r.m, ws, r.loops[0], rows, 0, k, J);
    double a = products[static_cast<std::size_t>(k)];
    const double lambda = links.multipliers()[static_cast<std::size_t>(k)];
    for (std::size_t f = 0; f < J.size(); ++f) {
      a += J[f] * vdot[f];
      rest[f] -= J[f] * lambda;
      size = std::max(size, std::fabs(J[f] * lambda));
    }
    if (links.independent()[static_cast<std::size_t>(k)] != 0) out.row = std::max(out.row, std::fabs(a) / speed);
  }
  for (const double x : rest) out.balance = std::max(out.balance, std::fabs(x) / size);
  return out;
}

constexpr LoopType types[] = {LoopType::weld,        LoopType::ball,   LoopType::revolute,  LoopType::prismatic,
                              LoopType::cylindrical, LoopType::planar, LoopType::universal, LoopType::distance};

/// Rank of a planar ring's loop in general position. Rows of motions out of the plane do not count.
int rank_in_the_plane(LoopType type) {
  return type == LoopType::weld ? 3 : type == LoopType::planar ? 0 : type == LoopType::distance ? 1 : 2;
}

TEST(Rings, RowsThatNoJointMovesGetNoMultiplier) {
  for (const RingKind kind : {RingKind::planar, RingKind::spherical, RingKind::sliding})
    for (const LoopType type : types)
      for (const double ratio : {1.0, 1000.0})
        for (unsigned seed = 0; seed < 60; ++seed) {
          Ring r = make_ring(seed, kind, type, seed % 2 == 0, seed % 8 > 1, 0, ratio);
          if (seed % 4 == 0) r.state.q[0] += 100;  // m: move the floating base far from the world's origin
          const Errors e = errors_of(r);
          const auto where = [&] {
            return std::string(name_of(type)) + ", kind " + std::to_string(static_cast<int>(kind)) + ", seed " + std::to_string(seed);
          };
          ASSERT_EQ(e.rank, e.dense_rank) << where();
          ASSERT_EQ(e.staged_rank, e.dense_rank) << where() << ", staged";
          ASSERT_LT(e.to_dense, ratio > 1 ? 1e-6 : 1e-8) << where();
          ASSERT_LT(e.row, ratio > 1 ? 1e-8 : 1e-11) << where();
          ASSERT_LT(e.balance, ratio > 1 ? 1e-7 : 1e-10) << where();
        }
}

/// Near a change point the dense solution is too inaccurate for a comparison. Instead: forces balance, independent rows are satisfied, and
/// at most one row is dropped.
TEST(Rings, ForcesBalanceNearChangePoints) {
  for (const LoopType type : types)
    for (const double flat : {0.1, 1e-3, 1e-5, 1e-7})
      for (unsigned seed = 0; seed < 100; ++seed) {
        Ring r = make_ring(seed, RingKind::planar, type, seed % 2 == 0, seed % 8 > 1, flat, 1);
        const Errors e = errors_of(r);
        const int rank = rank_in_the_plane(type);
        const auto where = [&] { return std::string(name_of(type)) + ", flat " + std::to_string(flat) + ", seed " + std::to_string(seed); };
        ASSERT_TRUE(e.rank == rank || e.rank == rank - 1) << where() << ", rank " << e.rank;
        ASSERT_TRUE(e.staged_rank == rank || e.staged_rank == rank - 1) << where() << ", staged rank " << e.staged_rank;
        ASSERT_LT(e.row, 1e-8) << where();
        ASSERT_LT(e.balance, 1e-8) << where();
      }
}

}  // namespace
}  // namespace ugoki::dynamics
