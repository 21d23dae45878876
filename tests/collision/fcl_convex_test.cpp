// Distances between convex shapes compared with FCL (Flexible Collision Library), to FCL's accuracy.

#include <gtest/gtest.h>

#ifdef UGOKI_HAS_FCL
#include <fcl/fcl.h>
#endif

#include "convex_oracles.h"

namespace ugoki::collision {
namespace {

#ifdef UGOKI_HAS_FCL

std::shared_ptr<fcl::CollisionGeometryd> to_fcl(const Support& s) {
  switch (s.kind) {
    case SupportKind::point: return std::make_shared<fcl::Sphered>(s.radius);
    case SupportKind::segment: return std::make_shared<fcl::Capsuled>(s.radius, 2 * s.size.z);
    case SupportKind::box: return std::make_shared<fcl::Boxd>(2 * s.size.x, 2 * s.size.y, 2 * s.size.z);
    case SupportKind::cylinder: return std::make_shared<fcl::Cylinderd>(s.size.x, 2 * s.size.z);
    case SupportKind::ellipsoid: return std::make_shared<fcl::Ellipsoidd>(s.size.x, s.size.y, s.size.z);
    default: break;
  }
  auto points = std::make_shared<std::vector<Eigen::Vector3d>>();
  for (const Vec3& v : s.hull->vertices) points->emplace_back(v.x, v.y, v.z);
  auto faces = std::make_shared<std::vector<int>>();
  for (int f = 0; f < s.hull->faces(); ++f) {
    faces->push_back(static_cast<int>(s.hull->face(f).size()));
    for (const std::int32_t c : s.hull->face(f)) faces->push_back(c);
  }
  return std::make_shared<fcl::Convexd>(points, s.hull->faces(), faces);
}

fcl::Transform3d to_fcl(const Pose& X) {
  fcl::Transform3d out = fcl::Transform3d::Identity();
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) out.linear()(i, j) = X.R.row(i)[j];
    out.translation()[i] = X.p[i];
  }
  return out;
}

TEST(Fcl, SameConvexDistances) {
  test::Random random(31);
  const std::vector<Hull> all = test::some_hulls(random);
  const std::vector<Hull> hulls(all.begin(), all.begin() + 8);  // FCL does not accept flat hulls
  int compared = 0, close = 0;
  for (int i = 0; i < 3000; ++i) {
    Support a = test::random_support(random, hulls), b = test::random_support(random, hulls);
    if (a.kind == SupportKind::box || a.kind == SupportKind::hull) a.radius = 0;
    if (b.kind == SupportKind::box || b.kind == SupportKind::hull) b.radius = 0;
    const Pose A = random.pose(0.3);
    Pose B = random.pose(0.3);
    B.p += random.unit() * 1.8;
    GilbertCache cache;
    const GilbertResult r = gilbert_distance(a, A, b, B, cache);
    if (r.distance < 0.01) continue;
    // Each of FCL's two solvers occasionally stops too early, with a distance that is too large; the minimum of both is used. A distance
    // is never too small by more than the tolerance.
    double theirs = 1e300;
    const fcl::CollisionObjectd one(to_fcl(a), to_fcl(A)), two(to_fcl(b), to_fcl(B));
    for (const auto solver : {fcl::GST_LIBCCD, fcl::GST_INDEP}) {
      fcl::DistanceRequestd request(true);
      request.gjk_solver_type = solver;
      request.distance_tolerance = 1e-8;
      fcl::DistanceResultd result;
      const double d = fcl::distance(&one, &two, request, result);
      if (d > 0) theirs = std::min(theirs, d);
    }
    ++compared;
    EXPECT_GT(theirs, r.distance - 1e-6) << i << " kinds " << int(a.kind) << " " << int(b.kind);
    close += theirs < r.distance + 1e-5 ? 1 : 0;
  }
  EXPECT_GT(compared, 2000);
  EXPECT_GT(close, compared * 97 / 100);
}

#else

TEST(Fcl, SameConvexDistances) {
  GTEST_SKIP() << "The Flexible Collision Library (libfcl-dev) is not installed; this comparison needs it.";
}

#endif

}  // namespace
}  // namespace ugoki::collision
