#pragma once
// Motion data as a reference for motion control: consistent positions, velocities and accelerations. Measured frames contain millimetres of
// noise, whose second differences would be accelerations of many g; therefore the motion is filtered first.

#include <span>
#include <vector>

#include "ugoki/motion/clip.h"
#include "ugoki/motion/motion.h"

namespace ugoki {

class SmoothMotion {
 public:
  /// Filters every coordinate with filter_both_ways() (butterworth.h), with ends padded by reflection, or by the neighbouring cycles if the
  /// motion is cyclic. Then computes velocities and accelerations by central differences on the manifold.
  /// @param cutoff Hz; 0 or at least a third of the rate: no filter
  SmoothMotion(const Motion& motion, const Mechanism& mechanism, double cutoff);
  /// Filters like the other constructor, but with one cut-off for each link's joint. @param cutoffs [links] Hz
  SmoothMotion(const Motion& motion, const Mechanism& mechanism, std::span<const double> cutoffs);

  [[nodiscard]] double duration() const { return frames_ > 1 ? (frames_ - 1) / rate_ : 0; }
  [[nodiscard]] int frames() const { return frames_; }
  [[nodiscard]] double rate() const { return rate_; }

  /// Reference at time t [s] after the first frame. Before the first and after the last frame, q is constant and v = a = 0.
  /// @param q [nq, out]  @param v, a [nv, out] rad/s | m/s, rad/s^2 | m/s^2
  void sample(const Mechanism& mechanism, double t, std::span<double> q, std::span<double> v, std::span<double> a) const;

 private:
  double rate_ = 0;
  int frames_ = 0;
  std::size_t nq_ = 0, nv_ = 0;
  std::vector<double> q_, v_, a_;  // [frames][nq], [frames][nv], [frames][nv]
  std::vector<double> step_;       // [frames][nv] displacement to the next frame (difference()); zeros in the last row
};

/// Reference of a clip at track time t [s], with the clip's placement and speed applied. Before the clip's start and after its end, q is
/// constant and v = a = 0. @param q [nq, out]  @param v, a [nv, out]
void sample(const Clip& clip, const SmoothMotion& motion, const Mechanism& mechanism, double t, std::span<double> q, std::span<double> v,
            std::span<double> a);

}  // namespace ugoki
