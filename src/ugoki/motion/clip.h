#pragma once
// A motion laid on a track: which part of it plays when, how fast, and where on the floor.

#include <span>

#include "ugoki/motion/motion.h"

namespace ugoki {

/// A displacement that keeps the floor level: turn by `heading` [rad] about Z, then move by (x, y, z) [m].
struct Placement {
  double x = 0, y = 0, z = 0;
  double heading = 0;
  friend bool operator==(const Placement&, const Placement&) = default;
};

/// First b, then a.
[[nodiscard]] Placement operator*(const Placement& a, const Placement& b);
[[nodiscard]] Placement inverse(const Placement& a);
/// `count` times a; count >= 0. O(log count).
[[nodiscard]] Placement repeated(const Placement& a, long count);
[[nodiscard]] Pose to_pose(const Placement& a);

/// Where the root of a figure stands: its position, and as heading the part of its rotation that is about Z
/// (twist of the swing-twist decomposition). Zero for a mechanism whose first joint is neither floating nor planar.
/// @param q [nq]
[[nodiscard]] Placement root_placement(const Mechanism& mechanism, std::span<const double> q);

/// Moves the whole figure by `by` in the world. Does nothing where the first joint is neither floating nor planar.
/// @param q [nq, in and out]
void displace_root(const Mechanism& mechanism, const Placement& by, std::span<double> q);

/// One clip of a track, ready to play.
struct Clip {
  double start = 0;   ///< s on the track
  double length = 0;  ///< s on the track
  double offset = 0;  ///< s into the motion at the clip's start
  double speed = 1;   ///< s of motion per s of track
  double blend = 0;   ///< s of cross-fade from what played before
  bool loop = false;  ///< the motion repeats; each round goes on from where the last one ended
  Placement place;    ///< displacement of the motion as it was recorded
  Placement cycle;    ///< displacement that one round of the motion adds (loop)

  [[nodiscard]] double end() const { return start + length; }
};

/// Where a clip is in its motion.
struct ClipPhase {
  double time = 0;  ///< s from the motion's first frame, in [0, duration]
  long rounds = 0;  ///< whole rounds before this one (loop)
};

/// Phase at track time t [s]; before the clip's start and after its end those count. @param duration [s] of the motion
[[nodiscard]] ClipPhase phase_of(const Clip& clip, double duration, double t);

/// Displacement of the recorded motion in that round: place * cycle^rounds.
[[nodiscard]] Placement placement_in(const Clip& clip, long rounds);

/// Displacement from a motion's first to its last frame, by which each round of a loop continues the one before.
[[nodiscard]] Placement cycle_of(const Motion& motion, const Mechanism& mechanism);

/// The figure's position as the clip has it at track time t [s], placement included. @param q [nq, out]
void sample(const Clip& clip, const Motion& motion, const Mechanism& mechanism, double t, std::span<double> q);

/// Lays `clip` so that its root stands at its start on the floor where `at` is: x, y and heading of `at`; the recorded
/// height is kept and raised by at.z. Sets clip.place and clip.cycle.
void lay_clip(Clip& clip, const Motion& motion, const Mechanism& mechanism, const Placement& at);

/// Where on the floor the clip has the root at track time t: what the next clip is laid on. z is the clip's own raise.
[[nodiscard]] Placement floor_placement(const Clip& clip, const Motion& motion, const Mechanism& mechanism, double t);

}  // namespace ugoki
