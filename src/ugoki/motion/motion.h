#pragma once
// Motion data: the coordinates of a mechanism over time.

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "ugoki/base/result.h"
#include "ugoki/mechanism/mechanism.h"

namespace ugoki {

/// Links whose ground contact a motion labels, for example both feet.
struct ContactTrack {
  std::string link;              ///< name of the link
  std::vector<std::uint8_t> on;  ///< [frames] 1 while it bears on the ground
};

struct Motion {
  std::string name;
  std::string source;     ///< where it comes from, for people
  std::string mechanism;  ///< name of the mechanism for which it was made
  double rate = 120;      ///< frames a second
  int frames = 0;
  int nq = 0;
  std::vector<double> q;  ///< [frames][nq]
  std::vector<ContactTrack> contacts;
  bool cyclic = false;  ///< the last frame leads into the first (but for the root's path)

  [[nodiscard]] double duration() const { return frames > 1 ? (frames - 1) / rate : 0; }
  [[nodiscard]] const double* frame(int i) const { return q.data() + static_cast<std::size_t>(i) * static_cast<std::size_t>(nq); }
  [[nodiscard]] double* frame(int i) { return q.data() + static_cast<std::size_t>(i) * static_cast<std::size_t>(nq); }
};
using MotionPtr = std::shared_ptr<const Motion>;

/// Problems that make the motion unusable on this mechanism: other nq, no frames, numbers not finite, quaternions not unit.
[[nodiscard]] Error check_motion(const Motion& motion, const Mechanism& mechanism);

/// q at time t [s] from the first frame, clamped to the ends: shortest-arc interpolation between frames. @param q [nq, out]
void sample(const Motion& motion, const Mechanism& mechanism, double t, std::span<double> q);

}  // namespace ugoki
