#pragma once
// Motion data made ready to be a reference for motion control: position, velocity and acceleration that belong together.
// Measured frames carry noise of millimetres; its second difference would ask for accelerations of many g.

#include <span>
#include <vector>

#include "ugoki/motion/clip.h"
#include "ugoki/motion/motion.h"

namespace ugoki {

class SmoothMotion {
 public:
  /// Zero-lag Butterworth filter (second order, forwards and backwards, ends padded by reflection: Winter 2009, ch. 2) on
  /// every coordinate, then velocities and accelerations by central differences on the manifold. Cyclic motions are
  /// padded with the rounds before and after.
  /// @param cutoff Hz; 0 or above a third of the rate: no filter
  SmoothMotion(const Motion& motion, const Mechanism& mechanism, double cutoff);
  /// The same with a cut-off for each link's joint. @param cutoffs [links] Hz
  SmoothMotion(const Motion& motion, const Mechanism& mechanism, std::span<const double> cutoffs);

  [[nodiscard]] double duration() const { return frames_ > 1 ? (frames_ - 1) / rate_ : 0; }
  [[nodiscard]] int frames() const { return frames_; }
  [[nodiscard]] double rate() const { return rate_; }

  /// Reference at time t [s] from the first frame; held at rest before the first and after the last frame.
  /// @param q [nq, out]  @param v, a [nv, out] 1/s, 1/s^2 of the coordinates
  void sample(const Mechanism& mechanism, double t, std::span<double> q, std::span<double> v, std::span<double> a) const;

 private:
  double rate_ = 0;
  int frames_ = 0;
  std::size_t nq_ = 0, nv_ = 0;
  std::vector<double> q_, v_, a_;  // [frames][nq], [frames][nv]
};

/// The reference that a clip gives at track time t [s]: placed on the floor, at the clip's speed. Before the clip's start and
/// after its end it stands still. Sizes as above.
void sample(const Clip& clip, const SmoothMotion& motion, const Mechanism& mechanism, double t, std::span<double> q, std::span<double> v,
            std::span<double> a);

}  // namespace ugoki
