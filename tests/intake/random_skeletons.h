#pragma once
// Random skeletons with motion: random trees, and human skeletons with random changes.

#include <cstdint>

#include "ugoki/motion/skeleton.h"

namespace ugoki::testing {

/// Numbers of a pseudo-random sequence (splitmix64).
class RandomNumbers {
 public:
  explicit RandomNumbers(std::uint64_t seed) : state_(seed) {}
  std::uint64_t next();
  /// Whole number from 0 to n - 1.
  int below(int n) { return static_cast<int>(next() % static_cast<std::uint64_t>(n)); }
  bool chance(double share) { return uniform() < share; }
  double uniform() { return static_cast<double>(next() >> 11) * 0x1p-53; }
  double between(double low, double high) { return low + (high - low) * uniform(); }

 private:
  std::uint64_t state_;
};

/// A valid measured motion: parents before children, finite values, unit quaternions, at least one joint, 0 to 5 frames. Equal seeds give
/// equal motions. Half of the skeletons are human with random changes: joints inserted, moved, renamed, removed or turned; the others are
/// random trees. Names repeat and may be empty; offsets are zero, tiny, ordinary or huge; joints have 0 to 3 rotation DOFs and may
/// translate.
MeasuredMotion random_skeleton(std::uint64_t seed);

}  // namespace ugoki::testing
