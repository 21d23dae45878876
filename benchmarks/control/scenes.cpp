#include "scenes.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "scene.h"
#include "ugoki/body/body.h"
#include "ugoki/dynamics/centroidal.h"
#include "ugoki/dynamics/dynamics.h"
#include "ugoki/mechanism/state.h"
#include "ugoki/samples/samples.h"
#include "ugoki/spatial/elementary.h"

namespace ugoki::bench {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

/// A sample motion for a person of the height [m]. Its time is scaled so that the Froude number is that of the sample.
ClipFile person(bool walks, double height) {
  const MeasuredMotion walk = samples::make_human_walk();
  body::BodyOptions options;
  options.height = height;
  const body::Body body = body::make_body(walk, options).value(), usual = body::make_body(walk).value();
  Motion motion = body::to_motion(body, walks ? walk : samples::make_human_stand());
  motion.cyclic = true;
  motion.rate *= std::sqrt(usual.height / height);
  return {"", body.mechanism, std::make_shared<const Motion>(std::move(motion))};
}

Outcome follow(const ClipFile& clip, double seconds, const RunSettings& settings) {
  return run(clip.mechanism, std::make_shared<const MotionReference>(clip.mechanism, *clip.motion, seconds), settings);
}

/// The sample human stands in a wind of 20 N: horizontal distance from its start after the time, m.
SceneRow stand_in_wind(double seconds) {
  RunSettings s;
  s.push = {0, 1e9, {20 * ugoki::cos(0.6), 20 * ugoki::sin(0.6), 0}};
  const ClipFile clip = person(false, 1.75);
  const Outcome a = follow(clip, seconds, s), b = follow(clip, std::min(seconds, 3.0), s), c = follow(clip, std::min(seconds, 3.0), s);
  return {"stand " + std::to_string(static_cast<int>(seconds)) + " s in 20 N of wind",
          "m",
          a.travel,
          "stands, below 0.1",
          !a.fell && a.travel < 0.1,
          b.hash == c.hash};
}

/// A human in the air whose joints are driven to and fro: largest change of the angular momentum / the largest momentum of one link.
SceneRow spin_in_the_air() {
  const ClipFile clip = person(true, 1.75);
  const Mechanism& m = *clip.mechanism;
  const auto measure = [&](std::uint64_t& bits) {
    contact::Stepper stepper({clip.mechanism}, {});
    State state(m);
    std::ranges::copy(std::span<const double>(clip.motion->frame(10), at(m.nq())), state.q.begin());
    state.q[2] += 10;
    state.v[0] = 1;
    state.v[1] = 2;
    dynamics::Workspace ws(m);
    double worst = 0, scale = 0;
    Vec3 begin;
    for (int k = 0; k < 250; ++k) {
      dynamics::update_kinematics(m, state.q, state.v, ws);
      const Vec3 spin = dynamics::calc_centroidal(m, ws).momentum.w;
      if (k == 0) begin = spin;
      worst = std::max(worst, norm(spin - begin));
      scale = std::max(scale, norm(spin));
      for (int i = 6; i < m.nv(); ++i) state.tau[at(i)] = 0.03 * std::min(300.0, m.dof(i).effort) * ugoki::sin(0.02 * k * (1 + i % 5));
      contact::StepSystem stepped[1] = {{state.q, state.v, state.tau, state.external, {}, {}}};
      if (stepper.step(stepped, {}, 0.002).status != contact::StepStatus::ok) return 1.0;
    }
    bits = 0;
    for (const double x : state.q) bits = bits * 31 + std::bit_cast<std::uint64_t>(x);
    return worst / scale;
  };
  std::uint64_t one = 0, two = 1;
  const double change = measure(one);
  (void)measure(two);
  return {"change of the angular momentum in 0.5 s in the air", "1", change, "below 1e-6", change < 1e-6, one == two};
}

/// The sample walk of persons of other sizes: tracking error, degrees.
SceneRow walk_of(const char* name, double height) {
  const ClipFile clip = person(true, height);
  const Outcome a = follow(clip, 20, {}), b = follow(clip, 2, {}), c = follow(clip, 2, {});
  return {std::string(name) + " walks for 20 s", "deg", a.tracking_deg, "walks, below 5", !a.fell && a.tracking_deg < 5, b.hash == c.hash};
}

}  // namespace

std::vector<SceneRow> run_scenes(double wind_seconds) {
  return {stand_in_wind(wind_seconds), spin_in_the_air(), walk_of("child of 1.1 m", 1.1), walk_of("giant of 2.6 m", 2.6)};
}

}  // namespace ugoki::bench
