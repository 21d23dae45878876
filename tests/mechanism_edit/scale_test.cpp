#include "ugoki/mechanism_edit/scale.h"

#include <gtest/gtest.h>

#include "random_loops.h"
#include "ugoki/dynamics/dynamics.h"
#include "ugoki/mechanism_edit/growth.h"
#include "ugoki/samples/samples.h"
#include "whole.h"

namespace ugoki {
namespace {

using testing::RandomSource;

MechanismPtr human() { return samples::make_sample().resources.mechanisms.at("human"); }

/// Dynamic similarity: the scaled mechanism, in the scaled state and under the scaled forces, has the scaled accelerations.
TEST(Scale, IsDynamicallySimilar) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    SCOPED_TRACE(seed);
    RandomSource random(seed);
    MechanismSpec spec = testing::random_spec(random, 8);
    const MechanismPtr m = *Mechanism::make(spec);
    const double l = random.uniform(0.3, 3), mass = random.uniform(0.2, 5) * m->mass(), f = mass / m->mass();
    const auto scaled = scale(*m, {.length = l, .mass = mass});
    ASSERT_TRUE(scaled.has_value()) << scaled.error().text();
    const Mechanism& n = *scaled->mechanism;
    EXPECT_NEAR(n.mass(), mass, 1e-12 * mass);
    State s(*m), t(n);
    testing::randomize(random, *m, s);
    const double rate = 1 / std::sqrt(l);  // factor of angular velocities
    std::vector<double> expected(s.v.size()), got(s.v.size());
    t.q = s.q;
    for (const Link& link : m->links())
      for (int k = 0; k < link.joint.nv(); ++k) {
        const JointType type = link.joint.type;
        const bool is_displacement = type == JointType::prismatic || (type == JointType::cylindrical && k == 1) ||
                                     (type == JointType::planar && k < 2) || (type == JointType::floating && k >= 3);
        const std::size_t i = static_cast<std::size_t>(link.v_index + k);
        t.v[i] = s.v[i] * (is_displacement ? l * rate : rate);
        t.tau[i] = s.tau[i] * (is_displacement ? f : f * l);
        if (is_displacement) {  // positions come first in q of planar and floating joints
          const int at = type == JointType::floating ? k - 3 : k;
          t.q[static_cast<std::size_t>(link.q_index + at)] *= l;
        }
      }
    dynamics::Workspace ws(*m), wt(n);
    ASSERT_TRUE(dynamics::calc_forward_dynamics(*m, ws, s.q, s.v, s.tau, {0, 0, -9.81}, {}, expected));
    ASSERT_TRUE(dynamics::calc_forward_dynamics(n, wt, t.q, t.v, t.tau, {0, 0, -9.81}, {}, got));
    for (const Link& link : m->links())
      for (int k = 0; k < link.joint.nv(); ++k) {
        const JointType type = link.joint.type;
        const bool is_displacement = type == JointType::prismatic || (type == JointType::cylindrical && k == 1) ||
                                     (type == JointType::planar && k < 2) || (type == JointType::floating && k >= 3);
        const std::size_t i = static_cast<std::size_t>(link.v_index + k);
        EXPECT_NEAR(got[i], expected[i] * (is_displacement ? 1 : rate * rate), 1e-8 * (1 + std::fabs(expected[i])));
      }
  }
}

/// A box scaled along and across its bone has the inertia of the box of the new size at the same density.
TEST(Scale, InertiaFollowsDensityAndLength) {
  const Vec3 half{0.1, 0.2, 0.5};
  LinkSpec rod = testing::link_of("rod", "", JointType::floating);
  rod.shapes = {Shape::box(half, {Mat3::identity(), {0, 0, 0.5}})};
  rod.inertia = solid_inertia(rod.shapes[0], 800);
  const MechanismPtr m = *Mechanism::make({.name = "rod", .links = {rod}});
  const LinkScale stretch{.along = 1.7, .across = 0.6, .mass = 1.7 * 0.6 * 0.6};
  const auto scaled = scale_links(*m, {&stretch, 1});
  ASSERT_TRUE(scaled.has_value());
  const Link& link = scaled->mechanism->link(0);
  EXPECT_LT(norm(link.shapes[0].half_extents - Vec3{0.06, 0.12, 0.85}), 1e-12);
  EXPECT_LT(testing::difference(solid_inertia(Shape::box({0.06, 0.12, 0.85}, {Mat3::identity(), {0, 0, 0.85}}), 800), link.inertia), 1e-12);
}

TEST(Scale, MeshesAndLoopsGrow) {
  const Vec3 corners[] = {{0, 0, 0}, {0.3, 0, 0}, {0, 0.2, 0}, {0, 0, 0.1}};
  const Triangle faces[] = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
  MechanismSpec spec{.name = "pair", .links = {}};
  for (const char* name : {"a", "b"}) {
    LinkSpec l = testing::link_of(name, "", JointType::revolute);
    l.joint.X_PJ.p = {1, 2, 3};
    l.shapes = {Shape::mesh(*make_geometry(corners, faces, false, "mesh"))};
    l.inertia = solid_inertia(l.shapes[0], 1000);
    spec.links.push_back(l);
  }
  spec.loops = {
      {.name = "rod", .type = LoopType::distance, .link_a = "a", .link_b = "b", .X_AJ = {Mat3::identity(), {0.1, 0, 0}}, .length = 0.5}};
  const auto scaled = scale(**Mechanism::make(spec), {.length = 2});
  ASSERT_TRUE(scaled.has_value()) << scaled.error().text();
  const Mechanism& m = *scaled->mechanism;
  EXPECT_NEAR(m.link(0).shapes[0].geometry->solid.mass, 8 * 0.3 * 0.2 * 0.1 / 6, 1e-15);
  EXPECT_NEAR(m.link(0).inertia.mass, 1000 * 8 * 0.3 * 0.2 * 0.1 / 6, 1e-12);
  EXPECT_LT(testing::difference(solid_inertia(m.link(0).shapes[0], 1000), m.link(0).inertia), 1e-12);
  EXPECT_EQ(m.loops()[0].length, 1.0);
  EXPECT_EQ(m.loops()[0].X_AJ.p, (Vec3{0.2, 0, 0}));
  EXPECT_EQ(m.link(0).joint.X_PJ.p, (Vec3{2, 4, 6}));
}

TEST(Growth, SharesSumToOneAndMediansIncrease) {
  for (double age = 2; age <= 20; age += 0.25) {
    const MassShares s = mass_shares(age);
    EXPECT_NEAR(s.head + s.trunk + 2 * (s.upper_arm + s.forearm + s.hand + s.thigh + s.shank + s.foot), 1, 1e-12);
    for (const double part : {s.head, s.trunk, s.upper_arm, s.forearm, s.hand, s.thigh, s.shank, s.foot}) EXPECT_GT(part, 0.004);
    if (age > 2) {
      EXPECT_GE(median_growth(age, GrowthSex::boy).height, median_growth(age - 0.25, GrowthSex::boy).height);
      EXPECT_GT(median_growth(age, GrowthSex::girl).mass, median_growth(age - 0.25, GrowthSex::girl).mass);
    }
  }
  EXPECT_GT(mass_shares(5).head, 2 * mass_shares(18).head);
  EXPECT_NEAR(mass_shares(12).thigh, 0.11, 0.001);
}

/// Published medians of the charts, for the middle of the months before and after each birthday; a birthday is between the two.
TEST(Growth, MediansMatchTheCharts) {
  struct Median {
    int age;
    double boy_height[2], boy_mass[2], girl_height[2], girl_mass[2];  // cm, kg
  };
  const Median published[] = {{4, {101.9373, 102.5105}, {16.1455, 16.3168}, {100.4681, 101.0339}, {15.7082, 15.8782}},
                              {8, {127.6320, 128.1237}, {25.5261, 25.7526}, {127.3522, 127.8263}, {25.4988, 25.7570}},
                              {11, {143.3107, 143.7304}, {35.7169, 36.0726}, {143.6950, 144.2609}, {37.0211, 37.3909}},
                              {12, {148.7917, 149.3088}, {40.2683, 40.6744}, {150.8936, 151.4866}, {41.4634, 41.8280}},
                              {13, {155.7642, 156.4099}, {45.3696, 45.8134}, {156.9644, 157.3437}, {45.6578, 45.9837}},
                              {14, {163.5350, 164.1418}, {50.7786, 51.2310}, {160.2997, 160.4777}, {49.2299, 49.4908}},
                              {15, {169.7405, 170.1393}, {56.0712, 56.4910}, {161.8174, 161.8980}, {51.9493, 52.1357}},
                              {16, {173.4014, 173.6101}, {60.7470, 61.0954}, {162.5287, 162.5690}, {53.8214, 53.9454}},
                              {17, {175.2398, 175.3410}, {64.4403, 64.6996}, {162.9013, 162.9238}, {55.0917, 55.1822}},
                              {18, {176.1348, 176.1850}, {67.1064, 67.2899}, {163.1172, 163.1308}, {56.1410, 56.2297}},
                              {19, {176.5911, 176.6179}, {69.0518, 69.1947}, {163.2504, 163.2590}, {57.2568, 57.3518}}};
  for (const Median& m : published) {
    SCOPED_TRACE(m.age);
    const auto middle = [](const double* x) { return 0.5 * (x[0] + x[1]); };
    const Growth boy = median_growth(m.age, GrowthSex::boy), girl = median_growth(m.age, GrowthSex::girl);
    EXPECT_NEAR(100 * boy.height, middle(m.boy_height), 0.051);
    EXPECT_NEAR(boy.mass, middle(m.boy_mass), 0.051);
    EXPECT_NEAR(100 * girl.height, middle(m.girl_height), 0.051);
    EXPECT_NEAR(girl.mass, middle(m.girl_mass), 0.051);
  }
}

TEST(Growth, SixYearOldHasAHeavierHeadAndShorterLegs) {
  const MechanismPtr man = human();
  const auto child = grow(*man, {.age = 6});
  ASSERT_TRUE(child.has_value()) << child.error().text();
  const Mechanism& m = *child->mechanism;
  EXPECT_NEAR(m.mass(), 20.7, 1e-9);
  EXPECT_NEAR(standing_height(m), 1.154, 1.154e-5);
  double head = 0, before = 0;
  double thigh = 0, thigh_before = 0;
  for (int i = 0; i < m.link_count(); ++i) {
    const std::string& label = m.link(i).label;
    if (label == "head" || label.starts_with("neck")) {
      head += m.link(i).inertia.mass;
      before += man->link(i).inertia.mass;
    }
    if (label == "shank left") {
      thigh = norm(m.link(i).joint.X_PJ.p);
      thigh_before = norm(man->link(i).joint.X_PJ.p);
    }
  }
  EXPECT_GT(head / m.mass(), 2 * before / man->mass());                   // a child's head is heavy for its body
  EXPECT_LT(thigh / thigh_before, 0.95 * 1.154 / standing_height(*man));  // a child's legs are short for its height
  EXPECT_GT(thigh / thigh_before, 0.80 * 1.154 / standing_height(*man));
  // Density is kept: shapes and mass of every link shrink alike.
  double volume_before = 0, volume_after = 0;
  for (int i = 0; i < m.link_count(); ++i)
    for (std::size_t k = 0; k < m.link(i).shapes.size(); ++k) {
      volume_before += volume(man->link(i).shapes[k]);
      volume_after += volume(m.link(i).shapes[k]);
    }
  EXPECT_NEAR(m.mass() / volume_after / (man->mass() / volume_before), 1, 0.05);
}

TEST(Growth, HeightAndMassAreReachedWithoutAge) {
  const MechanismPtr dog = samples::make_dog();
  const auto giant = grow(*dog, {.height = 2 * standing_height(*dog)});
  ASSERT_TRUE(giant.has_value());
  EXPECT_NEAR(giant->mechanism->mass(), 8 * dog->mass(), 1e-9);
  EXPECT_NEAR(standing_height(*giant->mechanism), 2 * standing_height(*dog), 1e-9);
  const auto fat = grow(*dog, {.mass = 2 * dog->mass()});
  ASSERT_TRUE(fat.has_value());
  EXPECT_NEAR(fat->mechanism->mass(), 2 * dog->mass(), 1e-9);
  const auto pup = grow(*dog, {.age = 5});
  ASSERT_TRUE(pup.has_value());
  EXPECT_NE(pup->report.back().find("evenly"), std::string::npos);
}

TEST(Growth, InvalidOptionsAreRefused) {
  const MechanismPtr man = human();
  EXPECT_FALSE(grow(*man, {}).has_value());
  EXPECT_FALSE(grow(*man, {.age = 0.5}).has_value());
  EXPECT_FALSE(grow(*man, {.height = NAN}).has_value());
  EXPECT_FALSE(grow(*man, {.mass = -3}).has_value());
  EXPECT_FALSE(scale(*man, {.length = 0}).has_value());
  EXPECT_FALSE(scale(*man, {.length = INFINITY}).has_value());
}

}  // namespace
}  // namespace ugoki
