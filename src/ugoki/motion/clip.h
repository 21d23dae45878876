#pragma once
// A clip is a motion placed on a track. It defines the part of the motion that is played, its time, its speed and its place on the floor.

#include <span>

#include "ugoki/motion/motion.h"

namespace ugoki {

/// A displacement that keeps the floor level: rotation by `heading` [rad] about Z, then translation by (x, y, z) [m].
struct Placement {
  double x = 0, y = 0, z = 0;
  double heading = 0;
  friend bool operator==(const Placement&, const Placement&) = default;
};

/// Composition: b is applied first, then a.
[[nodiscard]] Placement operator*(const Placement& a, const Placement& b);
[[nodiscard]] Placement inverse(const Placement& a);
/// a composed with itself `count` times; count >= 0. O(log count).
[[nodiscard]] Placement repeated(const Placement& a, long count);
[[nodiscard]] Pose to_pose(const Placement& a);

/// Position and heading of a character's root. The heading is the twist about Z in the swing-twist decomposition of the root's rotation.
/// Zero for a mechanism whose first joint is neither floating nor planar.
/// @param q [nq]
[[nodiscard]] Placement root_placement(const Mechanism& mechanism, std::span<const double> q);

/// Displaces the whole character by `by` in the world. No effect if the first joint is neither floating nor planar.
/// @param q [nq, in and out]
void displace_root(const Mechanism& mechanism, const Placement& by, std::span<double> q);

/// One clip of a track, ready to play.
struct Clip {
  double start = 0;     ///< s: start time on the track
  double length = 0;    ///< s: duration on the track
  double offset = 0;    ///< s: time in the motion at the clip's start
  double speed = 1;     ///< s of motion per s of track
  double blend = 0;     ///< s, duration of the cross-fade from the previous clip
  bool loop = false;    ///< the motion repeats; each repetition continues where the previous one ended
  Placement placement;  ///< displacement applied to the recorded motion
  Placement cycle;      ///< displacement that each repetition adds (loop)

  [[nodiscard]] double end() const { return start + length; }
};

/// Playback position of a clip in its motion.
struct ClipPhase {
  double time = 0;  ///< s from the motion's first animation frame, in [0, duration]
  long rounds = 0;  ///< completed repetitions (loop)
};

/// Playback position at track time t [s]; t is clamped to the clip's start and end. @param duration s: duration of the motion
[[nodiscard]] ClipPhase phase_of(const Clip& clip, double duration, double t);

/// Displacement of the recorded motion after `rounds` repetitions: placement * cycle^rounds.
[[nodiscard]] Placement placement_in(const Clip& clip, long rounds);

/// Displacement of the root from the motion's first to its last animation frame, without the change of height: the offset between
/// repetitions of a looped clip.
[[nodiscard]] Placement cycle_of(const Motion& motion, const Mechanism& mechanism);

/// Coordinates of the character at track time t [s], including the clip's placement. @param q [nq, out]
void sample(const Clip& clip, const Motion& motion, const Mechanism& mechanism, double t, std::span<double> q);

/// Sets clip.placement and clip.cycle so that at the clip's start the root has the x, y and heading of `at`. The root's height is the
/// recorded height plus at.z.
void lay_clip(Clip& clip, const Motion& motion, const Mechanism& mechanism, const Placement& at);

/// x, y and heading of the root at track time t [s], for aligning the next clip. z is the clip's placement.z, not the root's height.
[[nodiscard]] Placement floor_placement(const Clip& clip, const Motion& motion, const Mechanism& mechanism, double t);

}  // namespace ugoki
