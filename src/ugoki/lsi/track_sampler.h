#pragma once
// Samples the editing track of a character as a reference for motion control. At any time at most two clips play: the current one and,
// during a transition, the previous one.

#include <span>
#include <vector>

#include "ugoki/lsi/world.h"
#include "ugoki/motion/smooth_motion.h"

namespace ugoki::lsi {

/// Layout of a reference payload (pin type `motion`): q [nq], v [nv], a [nv], stance [feet] (1 while a foot should stand, otherwise 0). The
/// functions return the index of the first number of q, v, a and stance.
struct ReferenceLayout {
  std::size_t nq = 0, nv = 0, feet = 0;
  [[nodiscard]] std::size_t v() const { return nq; }
  [[nodiscard]] std::size_t a() const { return nq + nv; }
  [[nodiscard]] std::size_t stance() const { return nq + 2 * nv; }
  [[nodiscard]] std::size_t size() const { return nq + 2 * nv + feet; }
};
[[nodiscard]] ReferenceLayout reference_layout(const Mechanism& mechanism, std::size_t feet);

/// Weight of the current clip in a transition, and the weight's first and second time derivatives.
struct BlendWeight {
  double weight = 1, rate = 0, acceleration = 0;  ///< 1, 1/s, 1/s^2
};

/// Returns the weight at `passed` s after the begin of a transition that lasts `duration` s.
[[nodiscard]] BlendWeight blend_weight(double passed, double duration);

/// The clips that play at one time.
struct TrackMoment {
  int current = 0, previous = 0;  ///< indices of clips; equal outside transitions
  BlendWeight blend;
};

class TrackSampler {
 public:
  /// @param track   not empty, sorted by start
  /// @param feet    indices of the links that are feet
  /// @param smooth  true: the motions are filtered (make_reference); false: they are played unchanged
  TrackSampler(MechanismPtr mechanism, std::vector<TrackClip> track, std::span<const int> feet, bool smooth);

  [[nodiscard]] const ReferenceLayout& layout() const { return layout_; }
  [[nodiscard]] TrackMoment moment(double t) const;
  /// Writes the reference of one clip at track time t, s. @param reference [layout().size(), out]
  void sample_clip(int clip, double t, std::span<double> reference) const;
  /// Writes the reference of the motion of clip `clip`, but played as `placed`. @param reference [layout().size(), out]
  void sample_as(int clip, const Clip& placed, double t, std::span<double> reference) const;
  /// The clip as it plays: extended into the transition to the next clip where its motion is long enough.
  [[nodiscard]] const Clip& playing(int clip) const { return playing_[static_cast<std::size_t>(clip)]; }
  /// Writes the reference of the track at time t, s, including transitions. Allocates; a circuit instead uses the LSIs "motion retrieval"
  /// and "interpolation". @param reference [layout().size(), out]
  void sample(double t, std::span<double> reference) const;
  [[nodiscard]] bool smooth() const { return smooth_; }
  [[nodiscard]] const std::vector<TrackClip>& clips() const { return track_; }
  /// True if the motion of the clip was computed (is_computed), so that the stances of its reference are those for which it was made.
  [[nodiscard]] bool knows_stances(int clip) const { return computed_[motion_of_[static_cast<std::size_t>(clip)]]; }

 private:
  MechanismPtr mechanism_;
  std::vector<TrackClip> track_;
  std::vector<Clip> playing_;                      // [clips] the clips, extended into the transition to the next clip where possible
  std::vector<SmoothMotion> motions_;              // one for each different motion
  std::vector<std::size_t> motion_of_;             // [clips] index into motions_
  std::vector<std::vector<std::uint8_t>> stance_;  // [motions][frames * feet] 1: the foot stands
  std::vector<bool> computed_;                     // [motions]
  ReferenceLayout layout_;
  bool smooth_;
};

/// Blends two references. Rotations are interpolated along great arcs; velocities and accelerations are the time derivatives of the blended
/// position.
/// @param out  must not alias an input
void blend_references(const Mechanism& mechanism, const ReferenceLayout& layout, std::span<const double> previous,
                      std::span<const double> current, const BlendWeight& blend, std::span<double> out);

}  // namespace ugoki::lsi
