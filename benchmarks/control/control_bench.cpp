// Measures balance control: characters that follow motion files or sample motions without root assist.

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <utility>

#include "rose_plot.h"
#include "scene.h"
#include "scenes.h"
#include "ugoki/files/files.h"
#include "ugoki/motion_edit/cycle.h"
#include "ugoki/spatial/elementary.h"

using namespace ugoki;

namespace {

constexpr const char* usage =
    "usage: ugoki_control_bench [options] [files and sample motions]\n"
    "  files: BVH or AMC; sample motions: sample-stand, sample-walk, sample-dog-stand, sample-dog-trot,\n"
    "  gait-SPEED: a computed walk of 60 s at this speed (m/s)\n"
    "  --loop SECONDS       make each motion cyclic and repeat it\n"
    "  --push J             push rose: impulse J per mass (N s/kg) in 0.2 s at the chest, 8 directions; needs --loop.\n"
    "                       Several --push options measure several impulses\n"
    "  --phases N           number of phases of the cycle for --push (default 4)\n"
    "  --svg FILE           write a plot of all push roses\n"
    "  --slope DEGREES, --steps M, --tiles M   terrain that the reference does not contain\n"
    "  --one TIME ANGLE J   one push with impulse J per mass (N s/kg) at TIME (s) towards ANGLE (degrees)\n"
    "  --starts N           N runs of each motion (at most 9): one as it is, the others with a push of 0.03 N s/kg after 1 s in\n"
    "                       N - 1 directions; prints the number of falls and the time for each fall\n"
    "  --friction MU        friction of the floor (default 0.9)\n"
    "  --self               collisions between the links of the character\n"
    "  --set NAME VALUE     parameter of the controller\n"
    "  --scenes             run the scenes with a known answer instead of motions\n"
    "  --trace              print the state every 0.05 s\n"
    "  --landings           print a line for each landing of a foot\n";

struct Options {
  bench::RunSettings settings;
  bool scenes = false;
  double loop = 0, one = 0;
  std::vector<double> roses;  // N s/kg
  std::string svg;
  int phases = 4, starts = 1;
  std::vector<std::string> files;
};

/// The parameters that the option --set changes, with their names.
std::vector<std::pair<std::string, double*>> parameters(control::BalanceOptions& o) {
  return {{"com-gain", &o.com_gain},
          {"com-weight", &o.com_weight},
          {"height-frequency", &o.height_frequency},
          {"trunk-frequency", &o.trunk_frequency},
          {"pelvis-weight", &o.pelvis_weight},
          {"momentum-weight", &o.momentum_weight},
          {"joint-frequency", &o.joint_frequency},
          {"leg-weight", &o.leg_weight},
          {"swing-frequency", &o.swing_frequency},
          {"sole-weight", &o.sole_weight},
          {"load-cost", &o.load_cost},
          {"hover", &o.hover},
          {"max-hover", &o.max_hover},
          {"hover-weight", &o.hover_weight},
          {"press-margin", &o.press_margin},
          {"hover-time", &o.hover_time},
          {"hover-speed", &o.hover_speed},
          {"friction-margin", &o.friction_margin},
          {"touch", &o.touch},
          {"lifting", &o.lifting},
          {"anchor-time", &o.anchor_time},
          {"sole-share", &o.sole_share},
          {"pressure-reach", &o.pressure_reach},
          {"exact", &o.exact},
          {"exact-uneven", &o.exact_uneven},
          {"max-gap", &o.max_gap},
          {"heading-time", &o.heading_time},
          {"homing", &o.homing},
          {"max-homing", &o.max_homing},
          {"max-turn-home", &o.max_turn_home},
          {"homing-slope", &o.homing_slope},
          {"shift-growth", &o.shift_growth},
          {"max-transfer", &o.max_transfer},
          {"clearance", &o.clearance},
          {"rough-clearance", &o.rough_clearance},
          {"raise-speed", &o.raise_speed},
          {"max-raise", &o.max_raise},
          {"scuff", &o.scuff},
          {"max-tiptoe", &o.max_tiptoe},
          {"aim-depth", &o.aim_depth},
          {"press-speed", &o.press_speed},
          {"late-rate", &o.late_rate},
          {"early-rate", &o.early_rate},
          {"early", &o.early},
          {"hurry", &o.hurry},
          {"pace-time", &o.pace_time},
          {"max-pace", &o.max_pace},
          {"pace-slope", &o.pace_slope},
          {"landing", &o.landing},
          {"jump-landing", &o.jump_landing},
          {"push-off", &o.push_off},
          {"limit-time", &o.limit_time},
          {"turn-time", &o.turn_time},
          {"ground-time", &o.ground_time},
          {"leg-share", &o.leg_share},
          {"lower-time", &o.lower_time},
          {"move-cost", &o.move_cost},
          {"foothold-margin", &o.foothold_margin},
          {"max-move", &o.max_move},
          {"hold", &o.hold},
          {"hold-from", &o.hold_from},
          {"momentum-gain", &o.momentum_gain},
          {"chest-weight", &o.chest_weight},
          {"swing-weight", &o.swing_weight},
          {"turn-margin", &o.turn_margin},
          {"sole-damping", &o.sole_damping},
          {"lifted", &o.lifted},
          {"max-shift", &o.max_shift},
          {"shift-time", &o.shift_time},
          {"separation", &o.separation},
          {"step-delay", &o.step_delay},
          {"step-clearance", &o.step_clearance},
          {"max-hurry", &o.max_hurry},
          {"hurry-from", &o.hurry_from},
          {"step-time", &o.step_time},
          {"step-margin", &o.step_margin},
          {"step-error", &o.step_error}};
}

bool parse(int argc, char** argv, Options& o) {
  for (int i = 1; i < argc; ++i) {
    const std::string a = argv[i];
    const auto number = [&] { return i + 1 < argc ? std::atof(argv[++i]) : 0.0; };
    if (a == "--loop") {
      o.loop = number();
    } else if (a == "--scenes") {
      o.scenes = true;
    } else if (a == "--trace") {
      o.settings.trace = true;
    } else if (a == "--landings") {
      o.settings.landings = true;
    } else if (a == "--self") {
      o.settings.self_collision = true;
    } else if (a == "--friction") {
      o.settings.friction = number();
    } else if (a == "--push") {
      o.roses.push_back(number());
    } else if (a == "--starts") {
      o.starts = std::clamp(static_cast<int>(number()), 1, 9);
    } else if (a == "--svg" && i + 1 < argc) {
      o.svg = argv[++i];
    } else if (a == "--phases") {
      o.phases = std::max(1, static_cast<int>(number()));
    } else if (a == "--slope") {
      o.settings.terrain.slope = number();
    } else if (a == "--steps") {
      o.settings.terrain.steps = number();
    } else if (a == "--tiles") {
      o.settings.terrain.tiles = number();
    } else if (a == "--one") {
      o.settings.push.time = number();
      const double angle = number() * pi / 180;
      o.one = number();
      o.settings.push.force = {ugoki::cos(angle), ugoki::sin(angle), 0};
    } else if (a == "--set" && i + 2 < argc) {
      const auto all = parameters(o.settings.control);
      const std::string name = argv[++i];
      const auto found = std::find_if(all.begin(), all.end(), [&](const auto& p) { return p.first == name; });
      if (found == all.end()) {
        std::fprintf(stderr, "'%s' is not a parameter. Parameters:", name.c_str());
        for (const auto& p : all) std::fprintf(stderr, " %s", p.first.c_str());
        std::fprintf(stderr, "\n");
        return false;
      }
      *found->second = number();
    } else if (a.starts_with("--")) {
      std::fputs(usage, a == "--help" ? stdout : stderr);
      return false;
    } else {
      o.files.push_back(a);
    }
  }
  if (o.files.empty()) {
    o.files = {"sample-stand", "sample-walk"};
    if (o.loop == 0) o.loop = 20;
  }
  return true;
}

void run_rose(const bench::ClipFile& clip, const Motion& motion, const std::shared_ptr<const bench::MotionReference>& reference,
              const Options& o, double impulse, std::vector<bench::RosePoint>& points) {
  int stood = 0, tries = 0;
  std::string marks;
  const double cycle = motion.duration();
  std::vector<double> q(clip.mechanism->neutral().size()), v(static_cast<std::size_t>(clip.mechanism->nv())), a(v.size());
  // Direction of the walk between two times
  const auto heading = [&](double from, double to) {
    reference->sample(from, q, v, a);
    const Vec3 start{q[0], q[1], 0};
    reference->sample(to, q, v, a);
    const Vec3 way = Vec3{q[0], q[1], 0} - start;
    return norm(way) > 0.05 ? ugoki::atan2(way.y, way.x) : 0.0;
  };
  for (int direction = 0; direction < 8; ++direction) {
    int survived = 0;
    for (int phase = 0; phase < o.phases; ++phase) {
      bench::RunSettings s = o.settings;
      const double angle = pi * direction / 4, force = impulse * clip.mechanism->mass() / s.push.duration;
      s.push.time = 3 * cycle + phase * cycle / o.phases;
      s.push.force = Vec3{ugoki::cos(angle), ugoki::sin(angle), 0} * force;
      s.duration = s.push.time + 6;
      const bool fell = bench::run(clip.mechanism, reference, s).fell;
      ++tries;
      survived += fell ? 0 : 1;
      marks += fell ? 'x' : '.';
    }
    marks += ' ';
    stood += survived;
    points.push_back({impulse, pi * direction / 4 - heading(2.5 * cycle, 4.5 * cycle), survived, o.phases});
  }
  std::printf("%-18s %.2f N s/kg: %d / %d  %s\n", clip.name.c_str(), impulse, stood, tries, marks.c_str());
}

}  // namespace

int main(int argc, char** argv) {
  Options o;
  if (!parse(argc, argv, o)) return 2;
  std::setvbuf(stdout, nullptr, _IOLBF, 0);
  if (o.scenes) {
    bool good = true;
    for (const bench::SceneRow& row : bench::run_scenes(60)) {
      std::printf("%-52s %10.4g %-4s (%s) %s, %s\n", row.name.c_str(), row.value, row.unit.c_str(), row.expected.c_str(),
                  row.good ? "good" : "NOT REACHED", row.same_bits ? "same bits again" : "OTHER BITS");
      good = good && row.good && row.same_bits;
    }
    return good ? 0 : 1;
  }
  std::vector<bench::RosePoint> points;
  int runs = 0, falls = 0;
  double seconds = 0;
  for (const std::string& file : o.files) {
    const Result<bench::ClipFile> clip = bench::read_clip(file);
    if (!clip) {
      std::fprintf(stderr, "%s\n", clip.error().text().c_str());
      continue;
    }
    Motion motion = *clip->motion;
    if (o.loop > 0 && !motion.cyclic) {
      Result<Motion> cyclic = motion_edit::make_cyclic(*clip->mechanism, motion);
      if (!cyclic) {
        std::fprintf(stderr, "%s\n", cyclic.error().text().c_str());
        continue;
      }
      motion = std::move(*cyclic);
    }
    const auto reference = std::make_shared<const bench::MotionReference>(clip->mechanism, motion, o.loop);
    for (const double impulse : o.roses) run_rose(*clip, motion, reference, o, impulse, points);
    if (!o.roses.empty()) continue;
    for (int start = 0; start < o.starts; ++start) {
      bench::RunSettings s = o.settings;
      s.push.force = s.push.force * (o.one * clip->mechanism->mass() / s.push.duration);
      if (start > 0) {
        const double angle = 2 * pi * (start - 1) / (o.starts - 1);
        s.push.time = 1;
        s.push.force = Vec3{ugoki::cos(angle), ugoki::sin(angle), 0} * (0.03 * clip->mechanism->mass() / s.push.duration);
      }
      const bench::Outcome r = bench::run(clip->mechanism, reference, s);
      std::printf(
          "%-18s %s %6.2f / %6.2f s  tracking %5.2f deg  slip mean %.2f worst %.2f cm  depth %.1f mm  travel %.1f m  control %5.1f us "
          "total "
          "%5.1f us (%.1f x real time)  "
          "iterations %d unsolved %d  state %016llx\n",
          clip->name.c_str(), r.fell ? "FELL " : "whole", r.time, reference->end(), r.tracking_deg, r.slip_mean_cm, r.slip_worst_cm,
          r.penetration_mm, r.travel, r.control_us, r.total_us, 1e6 * s.dt / r.total_us, r.max_iterations, r.unsolved,
          static_cast<unsigned long long>(r.hash));
      ++runs;
      falls += r.fell ? 1 : 0;
      seconds += r.time;
    }
  }
  if (runs > 1) std::printf("%d falls in %d runs, %.0f s; %.0f s for each fall\n", falls, runs, seconds, seconds / std::max(1, falls));
  if (!o.svg.empty()) {
    const Result<void> written = files::write_file(o.svg, bench::rose_svg(points));
    if (!written) {
      std::fprintf(stderr, "%s\n", written.error().text().c_str());
      return 1;
    }
  }
  return 0;
}
