// The bodies of the heap, for ./bench contact and ./bench step.

#include <random>

#include "heap.h"
#include "ugoki/spatial/rotation.h"

namespace ugoki::benchmarks {

std::vector<HeapBody> make_heap(int count) {
  std::mt19937_64 engine(1);
  const auto uniform = [&](double low, double high) {  // gives the same values with every standard library
    return low + (high - low) * static_cast<double>(engine() >> 11) * 0x1p-53;
  };
  std::vector<HeapBody> heap;
  for (int i = 0; i < count; ++i) {
    HeapBody b;
    b.shape = static_cast<HeapShape>(i % 4);
    for (double& e : b.size) e = uniform(0.05, 0.25);
    if (b.shape == HeapShape::capsule) b.size[0] *= 0.5;
    b.density = uniform(300, 1000);
    const int k = i % 25;
    b.position[0] = 0.9 * (k % 5) - 1.8 + uniform(-0.01, 0.01);
    b.position[1] = 0.9 * (k / 5) - 1.8 + uniform(-0.01, 0.01);
    b.position[2] = 0.95 + 0.9 * (i / 25);
    const Quat turn = exp_map({uniform(-2, 2), uniform(-2, 2), uniform(-2, 2)});
    b.orientation[0] = turn.w;
    b.orientation[1] = turn.x;
    b.orientation[2] = turn.y;
    b.orientation[3] = turn.z;
    heap.push_back(b);
  }
  return heap;
}

}  // namespace ugoki::benchmarks
