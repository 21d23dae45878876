#include "ugoki/motion_edit/rounds.h"

#include <algorithm>

namespace ugoki::motion_edit {

Motion several_rounds(const Motion& motion, const Mechanism& m, int around) {
  const int n = round_frames(motion), count = 1 + 2 * around;
  const auto nq = static_cast<std::size_t>(motion.nq);
  const Placement cycle = cycle_of(motion, m);
  const auto displacement = [&](int round) { return round < 0 ? repeated(inverse(cycle), -round) : repeated(cycle, round); };
  Motion out = motion;
  out.cyclic = false;
  out.frames = count * n + 1;
  out.q.clear();
  for (int round = -around; round <= around; ++round)
    for (int f = 0; f < n; ++f) {
      out.q.insert(out.q.end(), motion.frame(f), motion.frame(f) + nq);
      displace_root(m, displacement(round), {out.q.data() + out.q.size() - nq, nq});
    }
  out.q.insert(out.q.end(), motion.frame(0), motion.frame(0) + nq);
  displace_root(m, displacement(around + 1), {out.q.data() + out.q.size() - nq, nq});
  for (ContactTrack& track : out.contacts) {
    const std::vector<std::uint8_t> one(track.on.begin(), track.on.begin() + n);
    track.on.clear();
    for (int k = 0; k < count; ++k) track.on.insert(track.on.end(), one.begin(), one.end());
    track.on.push_back(one.front());
  }
  return out;
}

Motion middle_round(const Motion& rounds, const Mechanism& m, const Placement& cycle, int around) {
  const int n = (rounds.frames - 1) / (1 + 2 * around), first = around * n;
  const auto nq = static_cast<std::size_t>(rounds.nq);
  Motion out = rounds;
  out.cyclic = true;
  out.frames = n + 1;
  out.q.assign(rounds.frame(first), rounds.frame(first + n) + nq);
  std::copy(out.frame(0), out.frame(0) + nq, out.frame(n));
  displace_root(m, cycle, {out.frame(n), nq});
  for (ContactTrack& track : out.contacts) {
    track.on = std::vector<std::uint8_t>(track.on.begin() + first, track.on.begin() + first + n + 1);
    track.on.back() = track.on.front();
  }
  return out;
}

}  // namespace ugoki::motion_edit
