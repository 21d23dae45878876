// Measures falls: a character under balance control is pushed until it falls, once with fall control and once as a ragdoll.

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

#include "lying.h"
#include "scene.h"
#include "ugoki/body/body.h"
#include "ugoki/control/fall_control.h"
#include "ugoki/dynamics/dynamics.h"
#include "ugoki/mechanism/state.h"
#include "ugoki/motion_edit/cycle.h"
#include "ugoki/samples/samples.h"

using namespace ugoki;

namespace {

constexpr const char* usage =
    "usage: ugoki_fall_bench [options] [files and sample motions]\n"
    "  files: BVH or AMC; person: a standing person with all joints movable (default); sample-stand, sample-walk\n"
    "  --push J       impulse per mass of each push, N s/kg (default 1.6)\n"
    "  --directions N number of directions (default 8)\n"
    "  --turn A       first direction, degrees (default 0: ahead)\n"
    "  --set NAME VALUE  parameter of fall control: tilt, height, reach, delay, frequency, strength\n"
    "  --lying N      no push: the bodies get up from N random lying postures\n"
    "  --height M     with --lying: height of the person, m (default 1.75)\n"
    "  --first N      number of the first lying posture (default 0)\n"
    "  --trace        print the phases of each fall or rise\n";

control::FallOptions settings;  // of all runs

enum class Way { ragdoll, protect, balance };

struct Fall {
  double braced = -1;    // s after the begin of the push; -1: the character does not brace
  double detected = -1;  // s after the begin of the push; -1: no fall
  double lying = -1;     // s after the detection
  double head = 0;       // m/s^2, maximum mean acceleration of the head within 15 ms
  std::string first;     // label of the first link, except the feet, that touches the ground
  bool low = false;      // the centre of mass ends low
};

Fall run(const MechanismPtr& mechanism, const std::shared_ptr<const bench::MotionReference>& reference, const Vec3& push, double begin,
         Way way) {
  constexpr double dt = 0.002, window = 0.015;
  const Mechanism& m = *mechanism;
  collision::Scene scene({mechanism});
  collision::Workspace workspace(scene);
  contact::Stepper stepper({mechanism}, {});
  contact::GuardedStep guard(scene, stepper);
  control::BalanceControl balance(mechanism, reference, {});
  control::BalanceState memory;
  control::FallControl fall(mechanism, settings);
  control::FallState state_of_fall;
  dynamics::Workspace ws(m);
  State state(m);
  std::vector<double> a(state.v.size()), gain(state.v.size()), velocity(state.v.size());
  reference->sample(0, state.q, state.v, a);
  std::vector<Pose> X(static_cast<std::size_t>(m.link_count()));
  std::vector<collision::ContactPoint> contacts;
  std::vector<char> foot(X.size());
  for (const control::Foot& f : balance.feet())
    for (const int link : f.parts) foot[static_cast<std::size_t>(link)] = 1;
  int chest = 0, head = 0;
  for (int i = 0; i < m.link_count(); ++i) {
    if (m.link(i).label == "chest") chest = i;
    if (m.link(i).label == "head") head = i;
  }
  const auto index = [](int i) { return static_cast<std::size_t>(i); };
  Fall out;
  std::vector<Vec3> speeds;
  const int span = static_cast<int>(window / dt + 0.5);
  for (int k = 0; k < static_cast<int>((begin + 4) / dt); ++k) {
    const double t = k * dt;
    calc_poses(m, state.q, X);
    const std::span<const Pose> poses(X);
    workspace.forget();
    collision::find_contacts(scene, std::span(&poses, 1), 0.02, workspace, contacts);
    std::ranges::fill(gain, 0.0);
    std::ranges::fill(velocity, 0.0);
    if (state_of_fall.mode < 2 || way == Way::balance) {
      const control::BalanceOutput b = balance.step({state.q, state.v, contacts, 0, dt}, memory, state.tau);
      if (way != Way::balance) {
        fall.check(state.q, state.v, balance.reference(), b.dcm_error, dt, state_of_fall);
        if (way == Way::protect) fall.brace(state.q, state.v, dt, state_of_fall, state.tau, gain, velocity);
        if (state_of_fall.mode == 1 && out.braced < 0) out.braced = t - begin;
      }
      if (state_of_fall.mode > 1 && out.detected < 0) out.detected = t - begin;
    } else if (way == Way::protect) {
      fall.step(state.q, state.v, contacts, 0, dt, state_of_fall, state.tau, gain, velocity);
      if (state_of_fall.mode == 3 && out.lying < 0) out.lying = t - begin - out.detected;
    } else {
      std::ranges::fill(state.tau, 0.0);
    }
    if (state_of_fall.mode > 0 && out.first.empty())
      for (const collision::ContactPoint& c : contacts)
        if (!foot[index(c.link_a)] && c.distance < 1e-3)
          out.first = m.link(c.link_a).label.empty() ? m.link(c.link_a).name : m.link(c.link_a).label;
    for (Vec6& w : state.external) w = {};
    if (t >= begin && t < begin + 0.2) {
      const Vec3 p = X[index(chest)] * m.link(chest).inertia.centre(), force = push * (m.mass() / 0.2);
      state.external[index(chest)] = {cross(p, force), force};
    }
    contact::StepSystem system{state.q, state.v, state.tau, state.external, gain, velocity};
    guard.forget();
    if (guard.step(std::span(&system, 1), contacts, dt).status != contact::StepStatus::ok) break;
    dynamics::update_kinematics(m, state.q, state.v, ws);
    speeds.push_back(dynamics::point_velocity(ws, head, ws.X_WB[index(head)] * m.link(head).inertia.centre()));
    if (out.braced >= 0 && static_cast<int>(speeds.size()) > span)
      out.head = std::max(out.head, norm(speeds.back() - speeds[speeds.size() - 1 - static_cast<std::size_t>(span)]) / window);
  }
  std::vector<double> q_ref(state.q.size()), v_ref(state.v.size());
  reference->sample(0, q_ref, v_ref, a);
  out.low = state.q[2] < 0.65 * q_ref[2];
  return out;
}

}  // namespace

int main(int argc, char** argv) {
  double push = 1.6, turn = 0, height = 1.75;
  int directions = 8;
  bool trace = false;
  bench::LyingSettings lying;
  lying.count = 0;
  std::vector<std::string> files;
  for (int i = 1; i < argc; ++i) {
    const std::string a = argv[i];
    const auto number = [&] { return i + 1 < argc ? std::atof(argv[++i]) : 0.0; };
    if (a == "--push") {
      push = number();
    } else if (a == "--directions") {
      directions = static_cast<int>(number());
    } else if (a == "--turn") {
      turn = number();
    } else if (a == "--set" && i + 2 < argc) {
      const std::string name = argv[++i];
      double* value = name == "tilt"        ? &settings.brace.tilt
                      : name == "height"    ? &settings.brace.height
                      : name == "reach"     ? &settings.brace.reach
                      : name == "delay"     ? &settings.delay
                      : name == "frequency" ? &settings.frequency
                      : name == "strength"  ? &settings.strength
                                            : nullptr;
      if (!value) {
        std::fputs(usage, stderr);
        return 2;
      }
      *value = number();
    } else if (a == "--lying") {
      lying.count = static_cast<int>(number());
    } else if (a == "--height") {
      height = number();
    } else if (a == "--first") {
      lying.first = static_cast<std::uint64_t>(number());
    } else if (a == "--trace") {
      trace = true;
    } else if (a.starts_with("--")) {
      std::fputs(usage, a == "--help" ? stdout : stderr);
      return 2;
    } else {
      files.push_back(a);
    }
  }
  if (files.empty()) files = {"person"};
  std::setvbuf(stdout, nullptr, _IOLBF, 0);
  for (const std::string& file : files) {
    bench::ClipFile clip;
    if (file == "person" && lying.count > 0) {
      clip = {file, samples::make_person(height).value(), nullptr};
    } else if (file == "person") {
      body::BodyOptions all;
      all.keep_unmoved = true;
      const body::Body body = body::make_body(samples::make_human_stand(), all).value();
      Motion motion = body::to_motion(body, samples::make_human_stand());
      motion.cyclic = true;
      clip = {file, body.mechanism, std::make_shared<const Motion>(std::move(motion))};
    } else {
      Result<bench::ClipFile> read = bench::read_clip(file);
      if (!read) {
        std::fprintf(stderr, "%s\n", read.error().text().c_str());
        continue;
      }
      clip = std::move(*read);
    }
    if (lying.count > 0) {
      lying.mechanism = clip.mechanism;
      lying.trace = trace;
      const bench::LyingResult r = bench::run_lying(lying);
      std::printf("%-14s %d of %d stand within 6 s, %d within 20 s (mean %.1f s)\n", clip.name.c_str(), r.in_time, lying.count, r.stood,
                  r.time);
      continue;
    }
    Motion motion = *clip.motion;
    if (!motion.cyclic) {
      Result<Motion> cyclic = motion_edit::make_cyclic(*clip.mechanism, motion);
      if (!cyclic) {
        std::fprintf(stderr, "%s\n", cyclic.error().text().c_str());
        continue;
      }
      motion = std::move(*cyclic);
    }
    const auto reference = std::make_shared<const bench::MotionReference>(clip.mechanism, motion, 60.0);
    int falls = 0, halved = 0, hands = 0, wrong = 0, missed = 0;
    double ratio = 0, time = 0, lie = 0;
    for (int d = 0; d < directions; ++d) {
      const double angle = pi * (turn / 180 + 2.0 * d / directions), begin = 2 + 0.13 * d;
      const Vec3 force = Vec3{ugoki::cos(angle), ugoki::sin(angle), 0} * push;
      const Fall protect = run(clip.mechanism, reference, force, begin, Way::protect);
      const Fall balance = run(clip.mechanism, reference, force, begin, Way::balance);
      wrong += protect.detected >= 0 && !balance.low ? 1 : 0;
      missed += protect.detected < 0 && balance.low ? 1 : 0;
      if (protect.detected < 0) continue;
      const Fall ragdoll = run(clip.mechanism, reference, force, begin, Way::ragdoll);
      ++falls;
      halved += protect.head < 0.5 * ragdoll.head ? 1 : 0;
      hands += protect.first.starts_with("hand") || protect.first.starts_with("fingers") ? 1 : 0;
      ratio += protect.head / ragdoll.head;
      time += protect.braced;
      lie = std::max(lie, protect.lying < 0 ? 9 : protect.lying);
      if (trace)
        std::printf(
            "  %4.0f deg: braces after %.2f s, falls after %.2f s, lies after %.2f s; head %.0f m/s^2, ragdoll %.0f; first %s, ragdoll "
            "%s%s\n",
            180 / pi * angle, protect.braced, protect.detected, protect.lying, protect.head, ragdoll.head, protect.first.c_str(),
            ragdoll.first.c_str(), balance.low ? "" : "  WRONG: balance control alone stays up");
    }
    std::printf(
        "%-14s %.2f N s/kg: %d of %d fall (%d without need, %d not detected); hands first %d; head below half of the ragdoll %d, mean "
        "ratio %.2f; braces after %.2f s, longest until at rest %.2f s\n",
        clip.name.c_str(), push, falls, directions, wrong, missed, hands, halved, ratio / std::max(1, falls), time / std::max(1, falls),
        lie);
  }
  return 0;
}
