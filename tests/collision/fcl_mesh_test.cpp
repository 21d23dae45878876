// Distances between meshes compared with FCL (Flexible Collision Library).

#include <gtest/gtest.h>

#ifdef UGOKI_HAS_FCL
#include <fcl/fcl.h>
#endif

#include "meshes.h"
#include "ugoki/collision/bubble.h"

namespace ugoki::collision {
namespace {

#ifdef UGOKI_HAS_FCL

using Model = fcl::BVHModel<fcl::OBBRSSd>;

std::unique_ptr<Model> to_fcl(const test::Mesh& m) {
  std::vector<fcl::Vector3d> vertices;
  for (const Vec3& v : m.vertices) vertices.push_back({v.x, v.y, v.z});
  std::vector<fcl::Triangle> triangles;
  for (const Triangle& t : m.triangles)
    triangles.emplace_back(static_cast<std::size_t>(t[0]), static_cast<std::size_t>(t[1]), static_cast<std::size_t>(t[2]));
  auto out = std::make_unique<Model>();
  out->beginModel(static_cast<int>(triangles.size()), static_cast<int>(vertices.size()));
  out->addSubModel(vertices, triangles);
  out->endModel();
  return out;
}

fcl::Transform3d to_fcl(const Pose& X) {
  fcl::Transform3d out = fcl::Transform3d::Identity();
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) out.linear()(i, j) = X.R.row(i)[j];
    out.translation()[i] = X.p[i];
  }
  return out;
}

TEST(FclMesh, SameDistances) {
  const test::Mesh torus = test::bumpy_torus(4000), knot = test::torus_knot(4000);
  const Result<SphereTree> a = make_sphere_tree(torus.vertices, torus.triangles), b = make_sphere_tree(knot.vertices, knot.triangles);
  ASSERT_TRUE(a && b);
  const auto fcl_a = to_fcl(torus), fcl_b = to_fcl(knot);
  test::Random random(81);
  BubbleWorkspace workspace;
  TrianglePair warm;
  int apart = 0, meeting = 0;
  for (int i = 0; i < 200; ++i) {
    const Pose A = random.pose(1), B = random.pose(i % 2 == 0 ? 1 : 2.5);
    const fcl::DistanceRequestd request(true);
    fcl::DistanceResultd result;
    const double theirs = std::max(fcl::distance(fcl_a.get(), to_fcl(A), fcl_b.get(), to_fcl(B), request, result), 0.0);
    const double ours = find_distance(*a, A, *b, B, warm, workspace).distance;
    ASSERT_NEAR(ours, theirs, 1e-12) << i;
    (ours > 0 ? apart : meeting) += 1;
  }
  EXPECT_GT(apart, 50);
  EXPECT_GT(meeting, 20);
}

#else

TEST(FclMesh, SameDistances) { GTEST_SKIP() << "The Flexible Collision Library (libfcl-dev) is not installed; this comparison needs it."; }

#endif

}  // namespace
}  // namespace ugoki::collision
