#include "ugoki/mechanism_edit/mirror.h"

#include <gtest/gtest.h>

#include "random_loops.h"
#include "ugoki/dynamics/dynamics.h"
#include "ugoki/dynamics/loop_rows.h"
#include "ugoki/formats/mechanism_json.h"
#include "ugoki/mechanism_edit/mirrored_names.h"
#include "ugoki/samples/samples.h"
#include "whole.h"

namespace ugoki {
namespace {

using testing::RandomSource;

TEST(MirroredNames, LeftAndRightAreExchanged) {
  for (const auto& [from, to] :
       {std::pair("LeftArm", "RightArm"), std::pair("upper arm left", "upper arm right"), std::pair("hand_L", "hand_R"),
        std::pair("mixamorig:RightHandThumb1", "mixamorig:LeftHandThumb1"), std::pair("l.foot", "r.foot"), std::pair("FL_hip", "FR_hip"),
        std::pair("RR_thigh", "RL_thigh"), std::pair("cleft", "cleft"), std::pair("leftover", "leftover"), std::pair("bright", "bright"),
        std::pair("lumbar_l5", "lumbar_l5"), std::pair("LEFT_KNEE", "RIGHT_KNEE"), std::pair("spine", "spine")}) {
    EXPECT_EQ(mirrored_word(from), to);
    EXPECT_EQ(mirrored_word(to), from);
  }
  const std::vector<std::string> names = {"lhand", "rhand", "root", "lowerback", "rib"};
  EXPECT_EQ(mirrored_names(names), (std::vector<std::string>{"rhand", "lhand", "root", "lowerback", "rib"}));
}

/// A tree with every joint and loop type, limits, shapes and a mesh.
MechanismPtr everything(unsigned seed) {
  RandomSource random(seed);
  testing::RandomLoops r(seed);
  MechanismSpec spec = r.m->spec();
  const Vec3 corners[] = {{0, 0, 0}, {0.3, 0, 0}, {0, 0.2, 0}, {0, 0, 0.1}};
  const Triangle faces[] = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
  for (LinkSpec& l : spec.links) {
    for (Dof& f : l.joint.dofs) {
      f.lower = random.uniform(-2, 0);
      f.upper = random.uniform(0, 2);
      f.stiffness = random.uniform(0, 3);
      f.rest = random.uniform(-1, 1);
    }
    l.shapes = {Shape::mesh(*make_geometry(corners, faces, false, "mesh"), {random.rotation(), random.vec(0.2)}),
                Shape::capsule(0.1, random.vec(1), random.vec(1))};
  }
  for (std::size_t i = 0; i < r.loops.size(); ++i) {
    const Loop& l = r.loops[i];
    const bool gear = l.type == LoopType::gear;
    const auto name = [&](int k) { return k < 0 ? std::string() : spec.links[static_cast<std::size_t>(k)].name; };
    const int a = gear ? r.m->link_of_dof(l.dof_a) : l.link_a, b = gear ? r.m->link_of_dof(l.dof_b) : l.link_b;
    spec.loops.push_back({.name = "loop" + std::to_string(i),
                          .type = l.type,
                          .link_a = name(a),
                          .link_b = name(b),
                          .X_AJ = l.X_AJ,
                          .X_BJ = l.X_BJ,
                          .axis = l.axis,
                          .axis2 = l.axis2,
                          .length = l.length,
                          .dof_a = gear ? l.dof_a - r.m->link(a).v_index : 0,
                          .dof_b = gear ? l.dof_b - r.m->link(b).v_index : 0,
                          .polynomial = l.polynomial});
  }
  spec.exclusions = {{spec.links[0].name, spec.links[2].name}};
  return *Mechanism::make(spec);
}

TEST(Mirror, MirroringTwiceGivesTheOriginalBits) {
  for (unsigned seed = 1; seed <= 15; ++seed)
    for (int normal = 0; normal < 3; ++normal) {
      const MechanismPtr m = everything(seed);
      const auto once = mirror(*m, {.normal = normal});
      ASSERT_TRUE(once.has_value()) << once.error().text();
      const auto twice = mirror(*once->mechanism, {.normal = normal});
      ASSERT_TRUE(twice.has_value());
      EXPECT_EQ(formats::write_mechanism(*twice->mechanism), formats::write_mechanism(*m));
      EXPECT_NE(formats::write_mechanism(*once->mechanism), formats::write_mechanism(*m));
    }
}

/// Poses, inertias, limits, springs, shapes and loop gaps of the mirrored mechanism in the mirrored position are the mirror images.
TEST(Mirror, PosesInertiasLimitsShapesAndLoopsAreReflected) {
  for (unsigned seed = 1; seed <= 15; ++seed)
    for (int normal = 0; normal < 3; ++normal) {
      SCOPED_TRACE(seed);
      const MechanismPtr m = everything(seed);
      const auto image = *mirror(*m, {.normal = normal});
      RandomSource random(seed + 5);
      State s(*m);
      testing::randomize(random, *m, s);
      std::vector<double> q(s.q.size()), later(s.q.size()), later_image(s.q.size());
      mirror_position(*m, s.q, q, {.normal = normal});
      std::vector<Pose> X(12), Y(12);
      calc_poses(*m, s.q, X);
      calc_poses(*image.mechanism, q, Y);
      Mat3 S = Mat3::identity();
      (normal == 0 ? S.xx : normal == 1 ? S.yy : S.zz) = -1;
      for (std::size_t i = 0; i < 12; ++i) {
        EXPECT_LT(testing::distance({S * (X[i].R * S), S * X[i].p}, Y[i]), 1e-12) << name_of(m->links()[i].joint.type);
        const Inertia a = m->links()[i].inertia.in_parent(X[i]), b = image.mechanism->links()[i].inertia.in_parent(Y[i]);
        EXPECT_LT(testing::difference({a.mass, S * a.h, symmetric_part(S * (a.I.matrix() * S))}, b), 1e-12);
        // The distances of the displacement from the limits and from the rest position are kept.
        const Joint &j = m->links()[i].joint, &k = image.mechanism->links()[i].joint;
        double x[6], y[6];
        joint_displacement(j, s.q.data() + m->links()[i].q_index, x);
        joint_displacement(k, q.data() + m->links()[i].q_index, y);
        for (std::size_t f = 0; f < static_cast<std::size_t>(j.nv()); ++f) {
          if (j.type == JointType::floating) continue;
          EXPECT_NEAR(std::min(x[f] - j.dofs[f].lower, j.dofs[f].upper - x[f]), std::min(y[f] - k.dofs[f].lower, k.dofs[f].upper - y[f]),
                      1e-12);
          EXPECT_NEAR(std::fabs(x[f] - j.dofs[f].rest), std::fabs(y[f] - k.dofs[f].rest), 1e-12);
        }
        const auto high = [&](const Mechanism& of, const std::vector<Pose>& P, int shape, const Vec3& d) {
          const Shape& sh = of.links()[i].shapes[static_cast<std::size_t>(shape)];
          const Pose W = P[i] * sh.X_BS;
          return dot(W.p, d) + reach(sh, transpose_times(W.R, d));
        };
        const Vec3 d = random.direction();
        for (int shape = 0; shape < 2; ++shape) EXPECT_NEAR(high(*m, X, shape, d), high(*image.mechanism, Y, shape, S * d), 1e-12);
        EXPECT_NEAR(image.mechanism->links()[i].shapes[0].geometry->solid.mass, m->links()[i].shapes[0].geometry->solid.mass, 1e-15);
      }
      // The image of a closed loop is closed. All loops of RandomLoops are closed at its state.
      testing::RandomLoops r(seed);
      mirror_position(*m, r.state.q, q, {.normal = normal});
      dynamics::Workspace ws(*image.mechanism);
      std::vector<double> v(static_cast<std::size_t>(m->nv()));
      dynamics::update_kinematics(*image.mechanism, q, v, ws);
      std::vector<Loop> loops(image.mechanism->loops().begin(), image.mechanism->loops().end());
      dynamics::LoopRows rows(loops);
      dynamics::update_loop_rows(*image.mechanism, ws, loops, q, v, rows);
      dynamics::Workspace ws0(*m);
      dynamics::update_kinematics(*m, r.state.q, v, ws0);
      std::vector<Loop> loops0(m->loops().begin(), m->loops().end());
      dynamics::LoopRows rows0(loops0);
      dynamics::update_loop_rows(*m, ws0, loops0, r.state.q, v, rows0);
      for (std::size_t k = 0; k < rows.gap.size(); ++k) EXPECT_NEAR(std::fabs(rows.gap[k]), std::fabs(rows0.gap[k]), 1e-11) << k;
    }
}

/// The sample's human is symmetric, so its mirror image with exchanged names equals the original.
TEST(Mirror, SymmetricBodyIsItsOwnImage) {
  const MechanismPtr man = samples::make_sample().resources.mechanisms.at("human");
  const auto image = mirror(*man);
  ASSERT_TRUE(image.has_value()) << image.error().text();
  for (const Link& l : man->links()) {
    const int at = image->mechanism->find_link(l.name);
    ASSERT_GE(at, 0) << l.name;
    const Link& o = image->mechanism->link(at);
    EXPECT_EQ(o.label, l.label);
    EXPECT_LT(testing::distance(o.joint.X_PJ, l.joint.X_PJ), 1e-12) << l.name;
    EXPECT_LT(testing::difference(o.inertia, l.inertia), 1e-12) << l.name;
    EXPECT_EQ(o.joint.type, l.joint.type);
  }
}

}  // namespace
}  // namespace ugoki
