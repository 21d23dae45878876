#pragma once
// Motion data: the coordinates of a mechanism over time.

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "ugoki/base/result.h"
#include "ugoki/mechanism/mechanism.h"

namespace ugoki {

/// Ground-contact labels of one link, for example a foot.
struct ContactTrack {
  std::string link;              ///< name of the link
  std::vector<std::uint8_t> on;  ///< [frames] 1 while the link is in contact with the ground
};

struct MotionTorques;  // motion/torques.h

struct Motion {
  std::string name;
  std::string source;     ///< origin of the data, for display
  std::string mechanism;  ///< name of the mechanism for which the motion was made
  double rate = 120;      ///< frames per second
  int frames = 0;
  int nq = 0;
  std::vector<double> q;  ///< [frames][nq] coordinates of the mechanism
  std::vector<ContactTrack> contacts;
  bool cyclic = false;  ///< the last animation frame equals the first except for the displacement of the root
  /// Torque-oriented form of this motion; null: the motion has only coordinates. Read it with torques_of(), because torques do not fit
  /// coordinates that were changed after the torques were computed.
  std::shared_ptr<const MotionTorques> torques;

  [[nodiscard]] double duration() const { return frames > 1 ? (frames - 1) / rate : 0; }
  [[nodiscard]] const double* frame(int i) const { return q.data() + static_cast<std::size_t>(i) * static_cast<std::size_t>(nq); }
  [[nodiscard]] double* frame(int i) { return q.data() + static_cast<std::size_t>(i) * static_cast<std::size_t>(nq); }
};
using MotionPtr = std::shared_ptr<const Motion>;

/// Returns the problems that make the motion unusable with this mechanism: different nq, no frames, invalid rate, values that are not
/// finite, quaternions that are not of unit length, contact labels of unknown links or of wrong length. Empty if there are none.
[[nodiscard]] Error check_motion(const Motion& motion, const Mechanism& mechanism);

/// Coordinates at time t [s] after the first frame; t is clamped to the motion. Interpolates linearly, and along the shorter great arc for
/// quaternions. @param q [nq, out]
void sample(const Motion& motion, const Mechanism& mechanism, double t, std::span<double> q);

}  // namespace ugoki
