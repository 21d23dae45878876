#pragma once
// Sphere trees of the meshes in meshes.h.

#include <gtest/gtest.h>

#include <utility>

#include "meshes.h"
#include "ugoki/collision/sphere_tree.h"

namespace ugoki::collision::test {

inline SphereTree tree_of(const Mesh& m) {
  Result<SphereTree> made = make_sphere_tree(m.vertices, m.triangles);
  EXPECT_TRUE(made.has_value()) << made.error().text();
  return made ? std::move(*made) : SphereTree{};
}

}  // namespace ugoki::collision::test
