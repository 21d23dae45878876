#pragma once
// A character's editing track as a reference for motion control: at any time two clips and how far the second has
// taken over from the first.

#include <span>
#include <vector>

#include "ugoki/lsi/world.h"
#include "ugoki/motion/smooth_motion.h"

namespace ugoki::lsi {

/// A reference payload (pin type `motion`): q [nq], v [nv], a [nv], stance [feet] (1 while a foot is meant to stand).
struct ReferenceLayout {
  std::size_t nq = 0, nv = 0, feet = 0;
  [[nodiscard]] std::size_t v() const { return nq; }
  [[nodiscard]] std::size_t a() const { return nq + nv; }
  [[nodiscard]] std::size_t stance() const { return nq + 2 * nv; }
  [[nodiscard]] std::size_t size() const { return nq + 2 * nv + feet; }
};
[[nodiscard]] ReferenceLayout reference_layout(const Mechanism& mechanism, std::size_t feet);

/// How much the current clip counts, and how fast that changes [1/s, 1/s^2].
struct BlendWeight {
  double weight = 1, rate = 0, acceleration = 0;
};

/// Which clips play at a moment.
struct TrackMoment {
  int current = 0, previous = 0;  ///< indices of clips; equal where nothing is blended
  BlendWeight blend;
};

class TrackSampler {
 public:
  /// @param track not empty, by start
  /// @param smooth motions are made references as make_reference does; false: played as they are
  TrackSampler(MechanismPtr mechanism, std::vector<TrackClip> track, std::span<const int> feet, bool smooth);

  [[nodiscard]] const ReferenceLayout& layout() const { return layout_; }
  [[nodiscard]] TrackMoment moment(double t) const;
  /// One clip's reference at track time t. @param reference [layout().size(), out]
  void sample_clip(int clip, double t, std::span<double> reference) const;
  /// The whole track's reference. Allocates; a circuit does the same with its own memory.
  void sample(double t, std::span<double> reference) const;
  [[nodiscard]] bool smooth() const { return smooth_; }
  [[nodiscard]] const std::vector<TrackClip>& clips() const { return track_; }

 private:
  MechanismPtr mechanism_;
  std::vector<TrackClip> track_;
  std::vector<Clip> playing_;                      // clips that may run on below the next one's blend
  std::vector<SmoothMotion> motions_;              // one for each different motion
  std::vector<std::size_t> motion_of_;             // [clips]
  std::vector<std::vector<std::uint8_t>> stance_;  // [motions][frame * feet]
  ReferenceLayout layout_;
  bool smooth_;
};

/// Blends two references: positions along great arcs, velocities and accelerations as that motion has them.
/// @param out may alias neither input
void blend_references(const Mechanism& mechanism, const ReferenceLayout& layout, std::span<const double> previous,
                      std::span<const double> current, const BlendWeight& blend, std::span<double> out);

}  // namespace ugoki::lsi
