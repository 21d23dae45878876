#pragma once
// A falling heap of boxes, balls, capsules and cylinders as plain values, for our code and for peers (other engines).

#include <vector>

namespace ugoki::benchmarks {

enum class HeapShape : unsigned char { box, sphere, capsule, cylinder };

struct HeapBody {
  HeapShape shape = HeapShape::box;
  double size[3] = {0, 0, 0};            ///< m; box: half extents; sphere, capsule and cylinder: radius, half length along z
  double density = 0;                    ///< kg/m^3
  double position[3] = {0, 0, 0};        ///< m
  double orientation[4] = {1, 0, 0, 0};  ///< w x y z
};

/// Makes a heap whose lowest body is 0.5 m above the ground z = 0; friction 0.9, no restitution.
[[nodiscard]] std::vector<HeapBody> make_heap(int count);

struct HeapResult {
  bool measured = false;  ///< false: the peer is not installed
  double deepest = 0;     ///< m: maximum overlap at any step
};

constexpr double heap_friction = 0.9;

// Each function runs the heap from its beginning with the default settings of its library.
HeapResult run_heap(const std::vector<HeapBody>& heap, double dt, int steps);
HeapResult run_bullet_heap(const std::vector<HeapBody>& heap, double dt, int steps);
HeapResult run_mujoco_heap(const std::vector<HeapBody>& heap, double dt, int steps);

}  // namespace ugoki::benchmarks
