#pragma once
// Characters and motions for the tests: the project's samples, and recordings if the shared data is available.

#include <gtest/gtest.h>

#include <fstream>
#include <iterator>

#include "ugoki/body/body.h"
#include "ugoki/formats/asf.h"
#include "ugoki/mechanism/state.h"
#include "ugoki/motion/clip.h"
#include "ugoki/samples/samples.h"

namespace ugoki::motion_edit {

inline std::size_t at(int i) { return static_cast<std::size_t>(i); }

struct Character {
  MechanismPtr mechanism;
  Motion motion;
  [[nodiscard]] const Mechanism& m() const { return *mechanism; }
};

inline Character human_walk() {
  const MeasuredMotion measured = samples::make_human_walk();
  const body::Body body = body::make_body(measured, {.keep_unmoved = true}).value();
  Character f{body.mechanism, body::to_motion(body, measured)};
  f.motion.cyclic = true;
  return f;
}

inline Character dog_trot() {
  Character f;
  f.mechanism = samples::make_dog();
  f.motion = samples::make_dog_trot(*f.mechanism);
  return f;
}

/// The cyclic motion repeated `rounds` times, not marked as cyclic.
inline Motion unrolled(const Mechanism& m, const Motion& cycle, int rounds) {
  Motion out = cycle;
  out.cyclic = false;
  out.contacts.clear();
  out.q.clear();
  const Placement way = cycle_of(cycle, m);
  const auto nq = at(cycle.nq);
  for (int r = 0; r < rounds; ++r)
    for (int f = 0; f < cycle.frames - (r + 1 < rounds ? 1 : 0); ++f) {
      out.q.insert(out.q.end(), cycle.frame(f), cycle.frame(f) + nq);
      displace_root(m, repeated(way, r), {out.q.data() + out.q.size() - nq, nq});
    }
  out.frames = static_cast<int>(out.q.size() / nq);
  return out;
}

/// Maximum difference of any DOF between two motions of the same length.
inline double max_difference(const Mechanism& m, const Motion& a, const Motion& b) {
  EXPECT_EQ(a.frames, b.frames);
  double worst = 0;
  std::vector<double> d(at(m.nv()));
  for (int f = 0; f < std::min(a.frames, b.frames); ++f) {
    difference(m, {a.frame(f), at(a.nq)}, {b.frame(f), at(b.nq)}, d);
    for (const double x : d) worst = std::max(worst, std::fabs(x));
  }
  return worst;
}

inline std::string recording(const std::string& name) { return std::string(UGOKI_SHARED_DATA) + "/human/asf_amc/" + name; }
inline bool has_recordings() { return std::ifstream(recording("02.asf")).good(); }

inline MeasuredMotion read_recording(const std::string& skeleton, const std::string& trial) {
  const auto text = [](const std::string& path) {
    std::ifstream file(path);
    return std::string(std::istreambuf_iterator<char>(file), {});
  };
  const auto asf = formats::read_asf(text(recording(skeleton + ".asf")), skeleton + ".asf").value();
  return formats::read_amc(text(recording(trial + ".amc")), trial + ".amc", asf).value();
}

}  // namespace ugoki::motion_edit
