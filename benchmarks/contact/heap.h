#pragma once
// A heap of mixed bodies, plain numbers for us and for the peers: boxes, balls, capsules and cylinders that fall on each other.

#include <vector>

namespace ugoki::benchmarks {

enum class HeapShape : unsigned char { box, sphere, capsule, cylinder };

struct HeapBody {
  HeapShape shape = HeapShape::box;
  double size[3] = {0, 0, 0};            ///< m: half extents; round ones: radius, half length along z
  double density = 0;                    ///< kg/m^3
  double position[3] = {0, 0, 0};        ///< m
  double orientation[4] = {1, 0, 0, 0};  ///< w x y z
};

/// The lowest at 0.5 m over the ground z = 0; friction 0.9 everywhere, no restitution.
[[nodiscard]] std::vector<HeapBody> make_heap(int count);

struct HeapResult {
  bool measured = false;  ///< false: the peer is not installed
  double deepest = 0;     ///< m, at any instant
};

constexpr double heap_friction = 0.9;

// Each runs the heap from its beginning, with the usual settings of its library.
HeapResult run_heap(const std::vector<HeapBody>& heap, double dt, int steps);
HeapResult run_bullet_heap(const std::vector<HeapBody>& heap, double dt, int steps);
HeapResult run_mujoco_heap(const std::vector<HeapBody>& heap, double dt, int steps);

}  // namespace ugoki::benchmarks
