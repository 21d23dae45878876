#pragma once
// Operations on one or two motions along their time. Each leaves its inputs as they are and gives a motion that fits the same mechanism;
// contact labels go along. Errors name the motion and what to change; a motion of more than 100 million coordinates is not made.

#include <span>

#include "ugoki/motion/clip.h"

namespace ugoki::motion_edit {

/// Frames first ... last, both included. Errors: frames that it does not have.
[[nodiscard]] Result<Motion> trim(const Motion& motion, int first, int last);

/// The other way round in time.
[[nodiscard]] Motion reverse(const Motion& motion);

/// The motion at another frame rate, by cubic pieces on the manifold. Its duration stays: the frames of a cyclic motion divide it evenly,
/// so its rate may differ a little from the one asked for; others lose less than a frame at the end. A lower rate filters first what it
/// cannot hold (zero-lag Butterworth at 0.4 of the new rate). @param rate frames a second, 1 ... 100000
[[nodiscard]] Result<Motion> resample(const Mechanism& mechanism, const Motion& motion, double rate);

struct ScaleOptions {
  double length = 1;    ///< all lengths: the root's place and sliding joints; the mechanism must be scaled alike
  double time = 1;      ///< of the motion's duration: 2 is half as fast
  bool froude = false;  ///< time is the square root of length, so that weight moves it as before
};
/// Errors: factors outside of 1e-6 ... 1e6; a rate outside of 0.001 ... 100000 frames a second.
[[nodiscard]] Result<Motion> scale(const Mechanism& mechanism, const Motion& motion, const ScaleOptions& options);

/// A moment of the new motion and the moment of the source that it shows. s
struct TimePoint {
  double time = 0, source = 0;
};
/// The motion played along a monotone curve through the points (cubic, no overshoot: Fritsch and Carlson 1980), from the first point's
/// time, which becomes 0, to the last one's. Errors: fewer than two points, times that do not rise, source times that fall or lie outside.
[[nodiscard]] Result<Motion> time_warp(const Mechanism& mechanism, const Motion& motion, std::span<const TimePoint> points);

struct JoinOptions {
  double blend = 0.3;         ///< s in which the end of the first goes over into the beginning of the second
  bool where_it_ends = true;  ///< the second is laid where the first ends; false: it stays where it is
};
/// One motion after the other. The rate is that of the first. Errors: a motion that does not fit the mechanism; a blend longer than either.
[[nodiscard]] Result<Motion> join(const Mechanism& mechanism, const Motion& first, const Motion& second, const JoinOptions& options = {});

}  // namespace ugoki::motion_edit
