#pragma once
// Runs an imported motion, or its mean pose, under dynamics.

#include <string>

#include "ugoki/intake/intake.h"

namespace ugoki::dialects {

struct Outcome {
  double tracking = 0;   ///< degrees, rms difference of the joints from the motion
  double assist = 0;     ///< rms of the root assist, in body weights
  double released = -1;  ///< s, time at which control was released; below 0: never
  std::string error;     ///< reason why the run stopped early; empty: it did not
};

/// Runs the first motion of the file to its end.
[[nodiscard]] Outcome simulate(const intake::Intake& in);
/// Makes the character keep the measured pose that is closest to the mean pose for `duration` s, with its lowest point on the floor.
[[nodiscard]] Outcome stand(const intake::Intake& in, double duration = 5);

}  // namespace ugoki::dialects
