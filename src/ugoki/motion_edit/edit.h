#pragma once
// Operations on the time axis of one or two motions. Each operation returns a new motion for the same mechanism, including contact labels.
// Errors name the motion and a remedy. Results with more than 100 million coordinates are refused.

#include <span>

#include "ugoki/motion/clip.h"

namespace ugoki::motion_edit {

/// Returns frames first to last, both included. Errors: frames that the motion does not have.
[[nodiscard]] Result<Motion> trim(const Motion& motion, int first, int last);

/// Returns the motion reversed in time.
[[nodiscard]] Motion reverse(const Motion& motion);

/// Returns the motion at another frame rate, by cubic interpolation on the manifold. A cyclic motion keeps its duration, so its rate may
/// differ slightly from `rate`; other motions lose less than one frame at the end. If the new rate is below 0.8 of the old one, the motion
/// is first low-pass filtered with a cut-off of 0.4 of the new rate (zero-lag Butterworth). @param rate frames per second, 1 to 100000
[[nodiscard]] Result<Motion> resample(const Mechanism& mechanism, const Motion& motion, double rate);

struct ScaleOptions {
  double length = 1;    ///< factor of all lengths: root position and sliding joints; scale the mechanism by the same factor
  double time = 1;      ///< factor of the duration: 2 is half as fast
  bool froude = false;  ///< also multiply the duration by sqrt(length): dynamic similarity under the same gravity (Froude number)
};
/// Scales lengths and duration. Errors: factors outside 1e-6 to 1e6; a resulting rate outside 0.001 to 100000 frames per second.
[[nodiscard]] Result<Motion> scale(const Mechanism& mechanism, const Motion& motion, const ScaleOptions& options);

/// A pair of times [s]: time in the new motion and the corresponding time in the source.
struct TimePoint {
  double time = 0, source = 0;
};
/// Returns the motion with its time mapped by a monotone cubic curve through the points (no overshoot: Fritsch and Carlson 1980). The time
/// of the first point becomes 0. Errors: fewer than two points; times that do not increase; source times that decrease or are outside the
/// motion.
[[nodiscard]] Result<Motion> time_warp(const Mechanism& mechanism, const Motion& motion, std::span<const TimePoint> points);

struct JoinOptions {
  double blend = 0.3;         ///< s, time of overlap in which the first motion is cross-faded to the second
  bool where_it_ends = true;  ///< true: the second motion is displaced to start where the first ends; false: it is not displaced
};
/// Returns the first motion followed by the second, at the rate of the first. Errors: a motion that does not fit the mechanism; a blend
/// longer than one of the motions.
[[nodiscard]] Result<Motion> join(const Mechanism& mechanism, const Motion& first, const Motion& second, const JoinOptions& options = {});

}  // namespace ugoki::motion_edit
