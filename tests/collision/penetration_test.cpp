// Depth of penetration: compared with all separating axes of polytopes and with closed forms; symmetry; continuity of the signed distance.

#include <limits>

#include "../allocations/allocation_count.h"
#include "convex_oracles.h"

namespace ugoki::collision {
namespace {

/// Depth of overlapping polytopes by the separating-axis theorem: minimum overlap over all face normals and all cross products of edges.
double by_all_axes(const Hull& a, const Pose& A, const Hull& b, const Pose& B) {
  const Support sa = Support::of(a), sb = Support::of(b);
  double minimum = 1e300;
  const auto try_axis = [&](const Vec3& n) { minimum = std::min(minimum, test::reach(sa, A, n) + test::reach(sb, B, -n)); };
  for (const Vec3& n : a.normals) try_axis(A.R * n);
  for (const Vec3& n : b.normals) try_axis(-(B.R * n));
  const auto edges = [](const Hull& h, const Pose& X) {
    std::vector<Vec3> out;
    for (int v = 0; v < static_cast<int>(h.vertices.size()); ++v)
      for (const std::int32_t w : h.neighbours_of(v))
        if (w > v) out.push_back(normalized(X.R * (h.vertices[static_cast<std::size_t>(w)] - h.vertices[static_cast<std::size_t>(v)])));
    return out;
  };
  const std::vector<Vec3> of_b = edges(b, B);
  for (const Vec3& u : edges(a, A))
    for (const Vec3& v : of_b) {
      const Vec3 n = cross(u, v);
      if (norm(n) < 1e-8) continue;
      try_axis(n / norm(n));
      try_axis(-n / norm(n));
    }
  return minimum;
}

/// Violation [m] of the conditions on every result: translating along n by the depth separates the shapes, and pa, pb are in the shapes.
double error_of(const Support& a, const Pose& A, const Support& b, const Pose& B, const SignedDistance& s) {
  const double core = s.distance + a.radius + b.radius;
  if (core > 0) return test::certificate(a, A, b, B, s.distance, s.pa, s.pb, s.n);
  const double apart = -test::reach(a, A, -s.n) - test::reach(b, B, s.n);
  return std::max({std::fabs(apart - core), test::outside(a, A, s.pa + s.n * a.radius), test::outside(b, B, s.pb - s.n * b.radius),
                   norm(s.pa - s.pb - s.n * s.distance), std::fabs(norm(s.n) - 1)});
}

TEST(Penetration, MatchesTheSeparatingAxisTheorem) {
  test::Random random(21);
  PenetrationWorkspace workspace;
  int compared = 0;
  for (int i = 0; i < 1500; ++i) {
    const Hull a = test::hull_of(test::on_ellipsoid(random, 4 + random.below(12), {0.5, random.in(0.02, 0.5), i % 5 == 0 ? 1e-4 : 0.3}));
    const Hull b = i % 7 == 0 ? a : test::hull_of(test::on_ellipsoid(random, 4 + random.below(12), {0.5, random.in(0.02, 0.5), 0.4}));
    const double apart = i % 3 == 0 ? 0.0 : 0.4;
    const Pose A = random.pose(apart), B = i % 11 == 0 ? A : random.pose(apart);
    GilbertCache cache;
    const SignedDistance s = signed_distance(Support::of(a), A, Support::of(b), B, cache, workspace);
    if (s.distance > 0) continue;
    ++compared;
    ASSERT_EQ(s.status, DistanceStatus::penetrating) << i;
    ASSERT_NEAR(-s.distance, by_all_axes(a, A, b, B), 1e-10) << i;
    ASSERT_LE(error_of(Support::of(a), A, Support::of(b), B, s), 1e-9) << i;
  }
  EXPECT_GT(compared, 700);
}

TEST(Penetration, AllShapePairsAreBoundedAndWarmStartsAgree) {
  test::Random random(22);
  const std::vector<Hull> hulls = test::some_hulls(random);
  PenetrationWorkspace workspace;
  int deep = 0, open = 0;
  double worst = 0;
  for (int i = 0; i < 12000; ++i) {
    const Support a = test::random_support(random, hulls), b = test::random_support(random, hulls);
    const Pose A = random.pose(i % 4 == 0 ? 0 : 0.3), B = random.pose(i % 4 == 0 ? 0 : 0.3);
    const double size = test::size_of(a) + test::size_of(b);
    GilbertCache cache;
    const SignedDistance s = signed_distance(a, A, b, B, cache, workspace);
    const bool curved = a.kind >= SupportKind::cylinder || b.kind >= SupportKind::cylinder;
    deep += s.distance < 0 ? 1 : 0;
    if (s.status == DistanceStatus::not_converged) {
      // Two round bodies, one deep in the other: nearly all directions have the same depth; only the bounds are valid.
      ++open;
      ASSERT_TRUE(curved);
      ASSERT_LE((s.upper - s.lower) / size, 1e-3);
      continue;
    }
    worst = std::max(worst, (s.upper - s.lower) / size);
    ASSERT_LE((s.upper - s.lower) / size, 1e-9) << i;
    // For curved surfaces the depth is accurate to the tolerance, the points only to the square root of the tolerance.
    ASSERT_LE(error_of(a, A, b, B, s) / size, curved && s.distance < 0 ? 2e-5 : 1e-9)
        << i << " kinds " << int(a.kind) << " " << int(b.kind);
    const SignedDistance again = signed_distance(a, A, b, B, cache, workspace);
    ASSERT_NEAR(again.distance, s.distance, 4e-10 * size) << i;
  }
  EXPECT_GT(deep, 5000);
  EXPECT_LT(open, 150);
  std::printf("  %d overlapping, %d not converged, worst bracket %.2g of the size\n", deep, open, worst);
}

TEST(Penetration, SymmetricAndIndependentOfTheFrame) {
  test::Random random(23);
  const std::vector<Hull> hulls = test::some_hulls(random);
  PenetrationWorkspace workspace;
  for (int i = 0; i < 3000; ++i) {
    const Support a = test::random_support(random, hulls, true), b = test::random_support(random, hulls, true);
    const Pose A = random.pose(0.4), B = random.pose(0.4), F = random.pose(3);
    GilbertCache one, two, three;
    const SignedDistance s = signed_distance(a, A, b, B, one, workspace);
    EXPECT_NEAR(signed_distance(b, B, a, A, two, workspace).distance, s.distance, 1e-12);
    EXPECT_NEAR(signed_distance(a, F * A, b, F * B, three, workspace).distance, s.distance, 1e-12);
  }
}

TEST(Penetration, MatchesClosedForms) {
  PenetrationWorkspace workspace;
  const auto depth = [&](const Support& a, const Pose& A, const Support& b, const Pose& B) {
    GilbertCache cache;
    const SignedDistance s = signed_distance(a, A, b, B, cache, workspace);
    EXPECT_EQ(s.status, DistanceStatus::penetrating);
    EXPECT_LE(error_of(a, A, b, B, s), 1e-5);
    return -s.distance;
  };
  const Mat3 I = Mat3::identity();
  EXPECT_NEAR(depth(Support::sphere(0.5), {}, Support::sphere(0.25), {I, {0.5, 0, 0}}), 0.25, 1e-15);
  EXPECT_NEAR(depth(Support::sphere(0.5), {}, Support::sphere(0.25), {}), 0.75, 1e-15);
  EXPECT_NEAR(depth(Support::sphere(0.1), {I, {0, 0, 0.3}}, Support::capsule(0.2, 1), {}), 0.3, 1e-15);
  EXPECT_NEAR(depth(Support::capsule(0.1, 1), {}, Support::capsule(0.2, 1), {}), 0.3, 1e-15);
  EXPECT_NEAR(depth(Support::box({1, 2, 3}), {}, Support::box({1, 2, 3}), {}), 2, 1e-14);
  EXPECT_NEAR(depth(Support::box({1, 2, 3}), {}, Support::box({0.5, 0.5, 0.5}), {I, {0.3, 0, 0}}), 1.2, 1e-14);
  EXPECT_NEAR(depth(Support::box({1, 2, 3}), {}, Support::sphere(0.5), {I, {0, 1.5, 0}}), 1, 1e-14);
  EXPECT_NEAR(depth(Support::box({1, 1, 1}), {}, Support::half_space(), {I, {0, 0, 0.25}}), 1.25, 1e-14);
  EXPECT_NEAR(depth(Support::cylinder(0.5, 1), {}, Support::cylinder(0.25, 1), {I, {0.5, 0, 0}}), 0.25, 1e-9);
  EXPECT_NEAR(depth(Support::cylinder(0.5, 1), {}, Support::sphere(0.1), {I, {0, 0, 0.9}}), 0.2, 1e-9);
  EXPECT_NEAR(depth(Support::ellipsoid({1, 2, 3}), {}, Support::sphere(0.1), {I, {0.9, 0, 0}}), 0.2, 1e-9);
}

TEST(Penetration, FlatAndTouchingShapesHaveKnownDepth) {
  PenetrationWorkspace workspace;
  const Hull square = test::hull_of({{1, 1, 0}, {1, -1, 0}, {-1, 1, 0}, {-1, -1, 0}});
  const Hull rod = test::hull_of({{0, 0, -1}, {0, 0, 1}, {0, 0, 0.5}, {0, 0, -0.5}});
  const Mat3 I = Mat3::identity(), turned = rotation_about({0, 1, 0}, pi / 2);
  struct Case {
    const Hull *a, *b;
    Pose B;
    double depth;
  };
  const Case cases[] = {{&square, &square, {}, 0},                   // coincident
                        {&square, &square, {I, {0.5, 0.5, 0}}, 0},   // coplanar and overlapping
                        {&square, &square, {I, {2, 0, 0}}, 0},       // edges touch
                        {&square, &square, {I, {2, 2, 0}}, 0},       // corners touch
                        {&square, &square, {turned, {0, 0, 0}}, 1},  // crossed
                        {&square, &square, {turned, {0, 0, 1}}, 0},  // an edge touches the face
                        {&square, &rod, {I, {0, 0, 0}}, 1},          // the rod crosses the square
                        {&square, &rod, {turned, {0, 0, 0}}, 0},     // the rod is in the square's plane
                        {&rod, &rod, {}, 0},                         // on the same line
                        {&rod, &rod, {I, {0, 0, 2}}, 0},             // end to end
                        {&rod, &rod, {turned, {0, 0, 0}}, 0}};       // crossed
  for (const Case& c : cases)
    for (const bool moved : {false, true}) {
      const Pose F = moved ? Pose{rotation_about({0.6, 0.8, 0}, 1), {3, -4, 5}} : Pose{};
      GilbertCache cache;
      const SignedDistance s = signed_distance(Support::of(*c.a), F, Support::of(*c.b), F * c.B, cache, workspace);
      const auto which = &c - cases;
      EXPECT_NE(s.status, DistanceStatus::not_converged) << which;
      EXPECT_NEAR(s.distance, -c.depth, 1e-14) << which;
      EXPECT_LE(error_of(Support::of(*c.a), F, Support::of(*c.b), F * c.B, s), 1e-13) << which;
    }
}

/// Bodies of 1e-6 ... 1e6 m in all combinations, also thin, distant, coincident or aligned: results are finite, and lower <= true value <=
/// upper.
TEST(Penetration, AllSizesAndRatiosAreFiniteAndBounded) {
  test::Random random(27);
  const std::vector<Hull> some = test::some_hulls(random);
  std::vector<Hull> hulls;
  for (const Hull& h : some)
    for (const double scale : {1e-6, 1e-3, 1.0, 1e3, 1e6}) {
      std::vector<Vec3> vertices = h.vertices;
      for (Vec3& v : vertices) v *= scale;
      Result<Hull> scaled = assemble_hull(vertices, h.first_corner, h.corners);
      ASSERT_TRUE(scaled.has_value()) << scaled.error().text();
      hulls.push_back(std::move(*scaled));
    }
  const auto draw = [&] {
    Support s = test::random_support(random, hulls);
    if (s.kind == SupportKind::hull) return s;
    const double scale = std::pow(10, random.in(-6, 6));
    s.radius *= scale;
    s.size = s.size * scale;
    if (s.kind == SupportKind::box && random.below(3) == 0) s.size.x *= 1e-6;
    if (s.kind == SupportKind::cylinder && random.below(3) == 0) s.size.z *= 1e-5;
    return s;
  };
  PenetrationWorkspace workspace;
  for (int i = 0; i < 8000; ++i) {
    const Support a = draw(), b = draw();
    const double size = test::size_of(a) + test::size_of(b);
    Pose A = random.pose(size), B = random.pose(size);
    if (i % 3 == 0) B.p += random.unit() * size * std::pow(10, random.in(0, 5));
    if (i % 5 == 0) B = A;
    if (i % 7 == 0) B = {A.R, A.p + A.R.column(random.below(3)) * size};
    GilbertCache cache;
    const SignedDistance s = signed_distance(a, A, b, B, cache, workspace);
    ASSERT_TRUE(std::isfinite(s.distance) && is_finite(s.n) && is_finite(s.pa) && is_finite(s.pb)) << i;
    // Far from the origin, coordinates are rounded to 2e-16 of their magnitude.
    const double digits = size + 1e-5 * (norm(A.p) + norm(B.p));
    const double apart = -test::reach(a, A, -s.n) - test::reach(b, B, s.n) - a.radius - b.radius;
    // If the search did not converge (needles as thin as 1e-7 of their length), `lower` may belong to an earlier direction.
    const double allowed = s.status == DistanceStatus::not_converged ? 1e-7 : 1e-9;
    ASSERT_LE(s.lower, apart + allowed * digits) << i;  // n proves the bound: the slab with normal n is at least as thick
    ASSERT_GE(s.upper, s.lower - 1e-12 * digits) << i;
    if (s.status != DistanceStatus::not_converged) ASSERT_LE(s.upper - s.lower, 1e-9 * digits) << i;
  }
}

/// A body that moves by dx changes its distance by at most dx, also during penetration, with a warm start in each step.
TEST(Penetration, SignedDistanceIsContinuousThroughContact) {
  test::Random random(24);
  const std::vector<Hull> hulls = test::some_hulls(random);
  PenetrationWorkspace workspace;
  for (int run = 0; run < 60; ++run) {
    const Support a = test::random_support(random, hulls), b = test::random_support(random, hulls);
    const Pose A = random.pose(0.1);
    const Mat3 R = random.pose(1).R;
    const Vec3 direction = random.unit();
    GilbertCache cache;
    double last = 0;
    for (int i = 0; i <= 300; ++i) {
      const double t = 1.5 - 0.01 * i;
      const SignedDistance s = signed_distance(a, A, b, {R, direction * t}, cache, workspace);
      ASSERT_TRUE(is_finite(s.n) && is_finite(s.pa) && is_finite(s.pb));
      if (i > 0) ASSERT_LE(std::fabs(s.distance - last), 0.01 + 1e-7) << "run " << run << " step " << i;
      last = s.distance;
    }
  }
}

TEST(Penetration, AllocatesNothingAfterWarmUp) {
  test::Random random(25);
  const std::vector<Hull> hulls = test::some_hulls(random);
  PenetrationWorkspace workspace;
  for (int pass = 0; pass < 2; ++pass) {
    test::Random same(26);
    const long before = allocations_so_far();
    for (int i = 0; i < 2000; ++i) {
      const Support a = test::random_support(same, hulls), b = test::random_support(same, hulls);
      GilbertCache cache;
      const Pose A = same.pose(0.1), B = same.pose(0.1);
      (void)signed_distance(a, A, b, B, cache, workspace);
    }
    if (pass == 1) EXPECT_EQ(allocations_so_far(), before);
  }
}

}  // namespace
}  // namespace ugoki::collision
