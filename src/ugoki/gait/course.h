#pragma once
// Where the body goes, the phases of the legs, and where the feet stand. Internal to gait.

#include "ugoki/gait/walker.h"

namespace ugoki::gait {

/// One animation frame of the course.
struct CourseFrame {
  double x = 0, y = 0, heading = 0;  ///< m, rad: wanted position and heading of the body
  double speed = 0, turn = 0;        ///< m/s, rad/s
  double moving = 0;                 ///< 0: stands; 1: walks at a usual speed
  double run = 0;                    ///< share of running (two legs)
  double spring = 0;                 ///< share of gaits in which the trunk pitches: canter, gallop, bound
  double stride_time = 1;            ///< s
  double ramp = 0;                   ///< share of a stance in which the load rises, and in which it falls
  double ground = 0;                 ///< m: smoothed height of the ground
  double slope = 0;                  ///< rise per length ahead
};

/// A stance of a leg, with its times in frames.
struct Stance {
  double begin = 0, end = 0;
  Vec3 place;          ///< m, world: middle of the sole, on the ground
  double heading = 0;  ///< rad
  Vec3 normal{0, 0, 1};
};

/// What a leg does in a frame.
struct LegFrame {
  bool stands = true;
  double share = 0;  ///< of the stance or of the swing that is over, 0 to 1
  double load = 0;   ///< weight of its part of the load; 0 in swing
  double duty = 0.6;
  double length = 0;  ///< s: duration of the present stance or swing
  int stance = 0;     ///< index of the present stance, or of the stance before the present swing
};

struct Course {
  int frames = 0;
  int first = 0, last = 0;  ///< frames that belong to the motion; those around them exist for continuity
  double rate = 120;
  std::vector<CourseFrame> body;             ///< [frames]
  std::vector<std::vector<LegFrame>> legs;   ///< [legs][frames]
  std::vector<std::vector<Stance>> stances;  ///< [legs]
};

/// Share of the stance in which the load rises, and in which it falls, in a run of two legs. The mean load is then that of half a sine
/// (Alexander et al. 1979), 0.64 of the maximum.
inline constexpr double flight_ramp = 0.36;

[[nodiscard]] Course make_course(const Walker& walker, const GaitOptions& options);

/// Height of the ground; 0 without a ground.
[[nodiscard]] double ground_at(const GaitOptions& options, double x, double y);

[[nodiscard]] double smooth_step(double s);

}  // namespace ugoki::gait
