// Conservative advancement, compared with closed forms and dense sampling.

#include "ugoki/collision/advancement.h"

#include <gtest/gtest.h>

#include "allocation_count.h"
#include "random_shapes.h"
#include "ugoki/mechanism/state.h"

namespace ugoki::collision {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

Impact impact(const Shape& a, const BodyMotion& A, const Shape& b, const BodyMotion& B, double dt, const AdvancementOptions& options = {}) {
  PairCache cache;
  DistanceWorkspace workspace;
  return find_impact(make_collider(a), A, make_collider(b), B, dt, cache, workspace, options);
}

BodyMotion at_rest(const Vec3& p = {}) { return {{Mat3::identity(), p}, {}, {}}; }
BodyMotion moving(const Vec3& p, const Vec3& v, const Vec3& w = {}) { return {{Mat3::identity(), p}, w, v}; }

TEST(Advancement, TwoBallsMeetAtTheRootOfTheQuadratic) {
  test::Random random(3);
  int hits = 0;
  for (int i = 0; i < 3000; ++i) {
    const double ra = random.in(0.01, 0.5), rb = random.in(0.01, 0.5);
    const Vec3 gap = random.unit() * (ra + rb + random.in(0.01, 1)), v = random.unit() * random.in(0.1, 300);
    const Vec3 common = random.vec(10);  // a common velocity, and spins, do not change the time of impact
    const Impact found =
        impact(Shape::sphere(ra), moving(gap, v + common, random.vec(50)), Shape::sphere(rb), moving({}, common, random.vec(50)), 1.0);
    const double b = dot(gap, v), c = dot(gap, gap) - (ra + rb) * (ra + rb), d = b * b - dot(v, v) * c;
    const double expected = b < 0 && d > 0 ? (-b - std::sqrt(d)) / dot(v, v) : infinity;
    if (expected < 1 && std::sqrt(d) > 0.05 * norm(v) * (ra + rb)) {  // not grazing
      ++hits;
      ASSERT_EQ(found.status, ImpactStatus::impact) << i;
      EXPECT_LE(found.time, expected + 1e-12);
      EXPECT_NEAR(found.time, expected, 2e-4 / norm(v)) << i;
      EXPECT_LE(found.near.distance, 1e-5);
    } else if (expected > 1) {
      ASSERT_NE(found.status, ImpactStatus::impact) << i << " expected " << expected;
    }
  }
  EXPECT_GT(hits, 100);
}

TEST(Advancement, ImpactTimeOfATurningBoxCornerIsExact) {
  // A box turns about a horizontal axis while it falls; the height of a corner is h(t) = z - v t - |e| sin(phase + w t).
  const double w = 3, v = 2, z = 1.5, e = std::sqrt(0.2 * 0.2 + 0.1 * 0.1), phase = std::atan2(0.1, 0.2);
  const Impact found = impact(Shape::box({0.2, 0.5, 0.1}), moving({0, 0, z}, {0, 0, -v}, {0, w, 0}), Shape::box({5, 5, 0.5}),
                              at_rest({0, 0, -0.5}), 1.0, {.tolerance = 1e-9});
  const auto lowest = [&](double t) {
    double maximum = 0;
    for (const double corner : {phase, -phase, pi - phase, pi + phase}) maximum = std::max(maximum, std::sin(corner + w * t));
    return z - v * t - e * maximum;
  };
  double low = 0, high = 1;
  for (int i = 0; i < 60; ++i) (lowest(0.5 * (low + high)) > 0 ? low : high) = 0.5 * (low + high);
  ASSERT_EQ(found.status, ImpactStatus::impact);
  EXPECT_NEAR(found.time, low, 1e-8);
  EXPECT_LE(found.time, low + 1e-12);
  EXPECT_GT(found.near.n.z, 0.999999);
}

TEST(Advancement, ImpactTimeOfATurningRodIsExact) {
  // A rod along x turns about its middle towards a small ball at the radius 0.8 m and the angle 1 rad.
  const double radius = 1e-3, w = 40, angle = 1;
  const Impact found =
      impact(Shape::capsule(radius, {-1, 0, 0}, {1, 0, 0}), {Shape::capsule(radius, {-1, 0, 0}, {1, 0, 0}).X_BS, {0, 0, w}, {}},
             Shape::sphere(radius), at_rest(Vec3{std::cos(angle), std::sin(angle), 0} * 0.8), 0.1, {.tolerance = 1e-9});
  const double expected = (angle - std::asin(2 * radius / 0.8)) / w;
  ASSERT_EQ(found.status, ImpactStatus::impact);
  EXPECT_NEAR(found.time, expected, 1e-8);
  EXPECT_LE(found.time, expected + 1e-12);
}

TEST(Advancement, FastBallDoesNotPassThinPlate) {
  for (const double speed : {3.0, 300.0, 3e4}) {
    const Impact found = impact(Shape::sphere(0.01), moving({0, 0, 1}, {0, 0, -speed}), Shape::box({1, 1, 0.0025}), at_rest(), 1.0);
    ASSERT_EQ(found.status, ImpactStatus::impact);
    EXPECT_NEAR(found.time * speed, 1 - 0.01 - 0.0025, 1e-5);
    EXPECT_LT(found.iterations, 20);
    EXPECT_NEAR(found.near.n.z, 1, 1e-12);
  }
}

/// First of the sampled times dt * k / count at which a and b overlap; infinity if none.
double first_overlap(const Collider& a, const BodyMotion& A, const Collider& b, const BodyMotion& B, double dt, int count) {
  DistanceWorkspace workspace;
  for (int k = 0; k <= count; ++k) {
    const double t = dt * k / count;
    PairCache cache;
    if (find_pair_distance(a, A.at(a.centre, t), b, B.at(b.centre, t), infinity, cache, workspace).distance < 0) return t;
  }
  return infinity;
}

TEST(Advancement, ThinAndFastShapesAreNotMissed) {
  test::Random random(12);
  int hits = 0, misses = 0, long_ones = 0;
  for (int i = 0; i < 600; ++i) {
    const auto thin = [&] {
      switch (random.below(4)) {
        case 0: return Shape::box({random.in(0.2, 1), random.in(0.2, 1), 0.001});
        case 1: return Shape::box({random.in(0.2, 1), 0.002, 0.002});
        case 2: {
          Shape s = Shape::capsule(0.002, {-0.5, 0, 0}, {0.5, 0, 0});
          s.X_BS = {};
          return s;
        }
        default: return Shape::sphere(random.in(0.003, 0.02));
      }
    };
    const Collider a = make_collider(thin()), b = make_collider(thin());
    const Vec3 towards = random.vec(0.4);
    const Pose XA{rotation_about(random.unit(), random.in(-pi, pi)), random.unit() * random.in(1, 3)}, XB = random.pose(0.1);
    const double speed = random.in(1, 300), dt = 2.5 * norm(XA.p) / speed;
    const BodyMotion A{XA, random.vec(8 / dt), normalized(towards - XA.p) * speed}, B{XB, random.vec(8 / dt), random.vec(2)};
    PairCache cache;
    DistanceWorkspace workspace;
    const Impact found = find_impact(a, A, b, B, dt, cache, workspace);
    const double sampled = first_overlap(a, A, b, B, dt, 1500);
    if (found.status == ImpactStatus::touching) continue;
    if (found.status == ImpactStatus::not_converged) {
      ++long_ones;
      ASSERT_LE(found.time, sampled) << i;
      continue;
    }
    if (sampled < infinity) {
      ++hits;
      ASSERT_EQ(found.status, ImpactStatus::impact) << i;
      ASSERT_LE(found.time, sampled) << i;
    } else {
      ++misses;
    }
    if (found.status == ImpactStatus::impact) {
      // At the time of the impact the shapes are within the tolerance.
      PairCache fresh;
      const double d =
          find_pair_distance(a, A.at(a.centre, found.time), b, B.at(b.centre, found.time), infinity, fresh, workspace).distance;
      ASSERT_LE(d, 1.1e-5) << i;
      ASSERT_GE(d, 0) << i;
    }
  }
  EXPECT_GT(hits, 80);
  EXPECT_GT(misses, 80);
  EXPECT_LT(long_ones, 5);
}

/// A plate with a square window of half width 0.2 m in the plane x = 0, as one non-convex mesh.
Collider window() {
  std::vector<Vec3> vertices;
  std::vector<Triangle> triangles;
  for (const double x : {-0.01, 0.01})
    for (const double size : {0.2, 1.0})
      for (const auto& [y, z] : std::vector<std::pair<double, double>>{{-1, -1}, {1, -1}, {1, 1}, {-1, 1}})
        vertices.push_back({x, y * size, z * size});
  const auto quad = [&](std::int32_t a, std::int32_t b, std::int32_t c, std::int32_t d) {
    triangles.push_back({a, b, c});
    triangles.push_back({a, c, d});
  };
  for (std::int32_t k = 0; k < 4; ++k) {
    const std::int32_t l = (k + 1) % 4;
    quad(k, 4 + k, 4 + l, l);            // back
    quad(8 + k, 8 + l, 12 + l, 12 + k);  // front
    quad(k, l, 8 + l, 8 + k);            // inner wall of the window
    quad(4 + k, 12 + k, 12 + l, 4 + l);  // rim
  }
  return make_collider(Shape::mesh(make_geometry(vertices, triangles, false, "window").value()));
}

TEST(Advancement, BallPassesWindowOrHitsFrame) {
  const Collider plate = window(), ball = make_collider(Shape::sphere(0.05));
  for (const double y : {0.0, 0.1, 0.14, 0.16, 0.3, 0.9, 1.1}) {
    PairCache cache;
    DistanceWorkspace workspace;
    const Impact found = find_impact(ball, moving({-1, y, 0}, {200, 0, 0}, {30, 20, 10}), plate, at_rest(), 0.02, cache, workspace);
    if (y < 0.15 || y > 1.05) {
      EXPECT_EQ(found.status, ImpactStatus::none) << y;
    } else {
      ASSERT_EQ(found.status, ImpactStatus::impact) << y;
      if (y > 0.2) {
        EXPECT_NEAR(found.time * 200, 1 - 0.01 - 0.05, 2e-5) << y;
      }
      EXPECT_GE(found.near.distance, 0);
    }
  }
}

TEST(Advancement, MotionBetweenTwoPosesReachesBoth) {
  test::Random random(4);
  for (int i = 0; i < 200; ++i) {
    const Collider c = make_collider(random.shape());
    const Pose from = random.pose(1), to = random.pose(1);
    const BodyMotion m = motion_between(c, from, to, 0.01);
    const Pose end = m.at(c.centre, 0.01), begin = m.at(c.centre, 0);
    EXPECT_LT(norm(end.p - to.p), 1e-12);
    EXPECT_LT(norm(begin.p - from.p), 1e-12);
    for (int k = 0; k < 3; ++k) EXPECT_LT(norm(end.R.row(k) - to.R.row(k)), 1e-12);
  }
}

TEST(Advancement, ReportsNonFiniteMotionAndInitialTouching) {
  const Shape ball = Shape::sphere(0.1);
  EXPECT_EQ(impact(ball, moving({0, 0, std::nan("")}, {0, 0, -1}), ball, at_rest(), 1).status, ImpactStatus::not_finite);
  EXPECT_EQ(impact(ball, moving({0, 0, 1}, {0, 0, -infinity}), ball, at_rest(), 1).status, ImpactStatus::not_finite);
  EXPECT_EQ(impact(ball, moving({0, 0, 0.1}, {0, 0, -1}), ball, at_rest(), 1).status, ImpactStatus::touching);
  const Impact away = impact(ball, moving({0, 0, 1}, {0, 0, 1}), ball, at_rest(), 1);
  EXPECT_EQ(away.status, ImpactStatus::none);
  EXPECT_EQ(away.time, 1);
  EXPECT_EQ(away.iterations, 1);
}

// --- Link systems ---

MechanismPtr free_body(const Shape& shape) {
  LinkSpec l;
  l.name = "body";
  l.joint.type = JointType::floating;
  l.inertia = Inertia::from_centre(1, {}, {0.1, 0.1, 0.1, 0, 0, 0});
  l.shapes = {shape};
  MechanismSpec spec;
  spec.name = "free";
  spec.links = {l};
  return Mechanism::make(spec).value();
}

/// A chain of bars along x with joints about z and y alternately; the last bar is a thin blade.
MechanismPtr arm(int links, const Vec3& base, JointType type = JointType::revolute) {
  MechanismSpec spec;
  spec.name = "arm";
  for (int i = 0; i < links; ++i) {
    LinkSpec l;
    l.name = "link" + std::to_string(i);
    if (i > 0) l.parent = "link" + std::to_string(i - 1);
    l.joint.type = type;
    l.joint.axis = i % 2 == 0 ? Vec3{0, 0, 1} : Vec3{0, 1, 0};
    l.joint.axis2 = {1, 0, 0};
    l.joint.X_PJ.p = i == 0 ? base : Vec3{0.4, 0, 0};
    l.inertia = Inertia::from_centre(1, {0.2, 0, 0}, {0.01, 0.01, 0.01, 0, 0, 0});
    l.shapes = {i + 1 < links ? Shape::capsule(0.03, {0.05, 0, 0}, {0.35, 0, 0})
                              : Shape::box({0.4, 0.02, 0.001}, {Mat3::identity(), {0.4, 0, 0}})};
    spec.links.push_back(l);
  }
  return Mechanism::make(spec).value();
}

struct Systems {
  std::vector<std::vector<double>> q, v;
  std::vector<SystemMotion> motions;

  void finish() {
    motions.clear();
    for (std::size_t i = 0; i < q.size(); ++i) motions.push_back({q[i], v[i]});
  }
};

/// First sampled time at which shapes of two systems are closer than `closer` [m]; infinity if none.
double sampled_impact(const Scene& scene, const Systems& s, double dt, int count, double closer) {
  DistanceWorkspace workspace;
  for (int k = 0; k <= count; ++k) {
    const double t = dt * k / count;
    std::vector<std::vector<Pose>> X;
    for (std::size_t i = 0; i < s.q.size(); ++i) {
      const Mechanism& m = *scene.systems()[i];
      std::vector<double> q(s.q[i].size());
      integrate(m, s.q[i], s.v[i], t, q);
      calc_poses(m, q, X.emplace_back(static_cast<std::size_t>(m.link_count())));
    }
    const auto shapes = scene.shapes();
    for (std::size_t i = 0; i < shapes.size(); ++i)
      for (std::size_t j = i + 1; j < shapes.size(); ++j) {
        if (shapes[i].system == shapes[j].system) continue;
        const auto pose = [&](const SceneShape& p) {
          return X[static_cast<std::size_t>(p.system)][static_cast<std::size_t>(p.link)] * p.shape.X_BS;
        };
        PairCache cache;
        if (find_pair_distance(shapes[i], pose(shapes[i]), shapes[j], pose(shapes[j]), infinity, cache, workspace).distance < closer)
          return t;
      }
  }
  return infinity;
}

TEST(ImpactSearch, FastBallHitsPlateOfAnotherSystem) {
  const Scene scene({free_body(Shape::sphere(0.01)), free_body(Shape::box({0.5, 0.5, 0.0025}))});
  Systems s;
  s.q = {{0, 0, 2, 1, 0, 0, 0}, {0, 0, 1, 1, 0, 0, 0}};
  s.v = {{0, 0, 0, 0, 0, -300}, {0, 0, 0, 0, 0, 0}};
  s.finish();
  ImpactSearch search(scene);
  const SceneImpact found = search.find(s.motions, 1.0 / 60, 1e-3);
  ASSERT_EQ(found.status, ImpactStatus::impact);
  EXPECT_NEAR(found.time, (1 - 0.01 - 0.0025) / 300, 1e-7);
  EXPECT_EQ(found.contact.system_a, 0);
  EXPECT_EQ(found.contact.system_b, 1);
  EXPECT_NEAR(found.contact.n.z, 1, 1e-9);
  EXPECT_NEAR(found.contact.p.z, 1.0025, 1e-5);
  // In a time step that ends before the impact, no impact is found.
  EXPECT_EQ(search.find(s.motions, 0.9 / 300, 1e-3).status, ImpactStatus::none);
}

TEST(ImpactSearch, FirstGroundImpactIsFound) {
  const Scene scene({free_body(Shape::sphere(0.1)), free_body(Shape::box({0.1, 0.1, 0.1}, {Mat3::identity(), {3, 0, 0}}))});
  Systems s;
  s.q = {{0, 0, 2, 1, 0, 0, 0}, {0, 0, 1, 1, 0, 0, 0}};
  s.v = {{0, 0, 0, 0, 0, -100}, {0, 0, 0, 0, 0, -10}};
  s.finish();
  ImpactSearch search(scene);
  const SceneImpact found = search.find(s.motions, 0.1, 1e-3);
  ASSERT_EQ(found.status, ImpactStatus::impact);
  EXPECT_NEAR(found.time, 1.9 / 100, 1e-6);
  EXPECT_EQ(found.contact.system_b, -1);
  EXPECT_EQ(found.shape_b, -1);
}

TEST(ImpactSearch, FirstOfManyImpactsIsFound) {
  // Balls fly towards a wall from different distances, among many balls at rest.
  std::vector<MechanismPtr> systems{free_body(Shape::box({0.01, 100, 1}))};
  const MechanismPtr ball = free_body(Shape::sphere(0.1));
  for (int i = 0; i < 150; ++i) systems.push_back(ball);
  const Scene scene(systems);
  Systems s;
  s.q.push_back({0, 0, 5, 1, 0, 0, 0});
  s.v.push_back({0, 0, 0, 0, 0, 0});
  for (int i = 0; i < 150; ++i) {
    s.q.push_back({2.0 + (i * 37) % 150, -80.0 + i, 5, 1, 0, 0, 0});
    s.v.push_back({0, 0, 0, i % 3 == 1 ? -40.0 : 0.0, 0, 0});
  }
  s.finish();
  ImpactSearch search(scene);
  const SceneImpact found = search.find(s.motions, 4, 1e-3);
  double nearest = infinity;
  int first = -1;
  for (int i = 1; i < 150; i += 3)
    if (s.q[static_cast<std::size_t>(i) + 1][0] < nearest) nearest = s.q[static_cast<std::size_t>(i) + 1][0], first = i + 1;
  ASSERT_EQ(found.status, ImpactStatus::impact);
  EXPECT_NEAR(found.time, (nearest - 0.11) / 40, 1e-6);
  EXPECT_EQ(found.contact.system_b, first);
}

TEST(ImpactSearch, PairsWithinTheMarginAreIgnored) {
  const Scene scene({free_body(Shape::sphere(0.1))});
  Systems s;
  s.q = {{0, 0, 0.1002, 1, 0, 0, 0}};
  s.v = {{0, 0, 0, 0, 0, -10}};
  s.finish();
  ImpactSearch search(scene);
  EXPECT_EQ(search.find(s.motions, 0.1, 1e-3).status, ImpactStatus::none);
  EXPECT_EQ(search.find(s.motions, 0.1, 1e-4).status, ImpactStatus::impact);
}

TEST(ImpactSearch, ThinLinksOfTurningArmsAreNotMissed) {
  test::Random random(40);
  int hits = 0, misses = 0, tight = 0;
  double distances = 0;
  for (int i = 0; i < 150; ++i) {
    const JointType type = i % 3 == 0 ? JointType::universal : JointType::revolute;
    SceneOptions options;
    options.with_ground = false;
    const Scene scene({arm(4, {}, type), arm(3, {0.6, 0.3, 0.1}, type), free_body(Shape::sphere(0.02))}, {}, options);
    Systems s;
    for (const MechanismPtr& m : scene.systems()) {
      State state(*m);
      for (std::size_t k = 0; k < state.v.size(); ++k) state.v[k] = random.in(-25, 25);
      std::vector<double> q(state.q);
      integrate(*m, state.q, state.v, random.in(-1, 1), q);
      s.q.push_back(q);
      s.v.push_back(state.v);
    }
    s.q[2][0] = random.in(-1.5, 2), s.q[2][1] = random.in(-1.5, 1.5), s.q[2][2] = random.in(-0.5, 0.5);
    s.finish();
    const double dt = 0.08, margin = 2e-3;
    if (sampled_impact(scene, s, 0, 1, margin) < infinity) continue;
    ImpactSearch search(scene);
    const SceneImpact found = search.find(s.motions, dt, margin);
    const double sampled = sampled_impact(scene, s, dt, 500, 0);
    ASSERT_NE(found.status, ImpactStatus::not_finite);
    if (sampled < infinity) {
      ++hits;
      ASSERT_EQ(found.status, ImpactStatus::impact) << i;
      ASSERT_LE(found.time, sampled) << i;
    } else {
      ++misses;
    }
    if (found.status == ImpactStatus::impact) {
      EXPECT_LE(found.contact.distance, 1.1e-5);
      EXPECT_GE(found.contact.distance, 0);
      // Sampling confirms the distance at the time of impact.
      tight += sampled_impact(scene, s, found.time, 1, 1.2e-5) <= found.time ? 1 : 0;
      EXPECT_EQ(sampled_impact(scene, s, found.time * (1 - 1e-9), 300, 0), infinity) << i;
    }
    distances += found.distances;
  }
  EXPECT_GT(hits, 20);
  EXPECT_GT(misses, 10);
  EXPECT_GE(tight, hits);
  EXPECT_LT(distances, 150.0 * (hits + misses));
}

TEST(ImpactSearch, StepsAllocateNothing) {
  const Scene scene({arm(4, {}), arm(3, {1.2, 0.3, 0.1}), free_body(Shape::sphere(0.02))});
  Systems s;
  for (const MechanismPtr& m : scene.systems()) {
    s.q.push_back(m->neutral());
    s.v.emplace_back(static_cast<std::size_t>(m->nv()), 3.0);
  }
  s.q[2][2] = 2;
  s.finish();
  ImpactSearch search(scene);
  const SceneImpact first = search.find(s.motions, 0.02, 1e-3);
  const long before = allocations_so_far();
  for (int i = 0; i < 10; ++i) {
    const SceneImpact again = search.find(s.motions, 0.02, 1e-3);
    EXPECT_EQ(again.time, first.time);
  }
  EXPECT_EQ(allocations_so_far(), before);
}

}  // namespace
}  // namespace ugoki::collision
