// `ugoki judge`: measures how natural a motion is, as recorded and when run as dynamics, and compares the values with limits.

#include <memory>

#include "output.h"
#include "simulate.h"
#include "sources.h"
#include "ugoki/base/number.h"
#include "ugoki/files/files.h"
#include "ugoki/mechanism/state.h"
#include "ugoki/motion/contact_labels.h"
#include "ugoki/motion/foot_slip.h"
#include "ugoki/motion/measures.h"
#include "ugoki/project/project.h"
#include "verb.h"

namespace ugoki::cli {
namespace {

struct Options {
  std::string target;
  SourceOptions source;
  double rate = 500;
  double max_tracking = 5, max_assist = 0.15, max_skate = 3, max_penetration = 20;
  bool kinematic = false, strict = false, json = false;
};

/// One measured value and the maximum allowed for it.
struct Judgement {
  std::string measure, unit;
  double value = 0, limit = 0;
  [[nodiscard]] bool good() const { return value <= limit; }
};

/// Judges the recorded motion without dynamics.
std::vector<Judgement> judge_motion(const ClipSource& clip, const Options& options) {
  const Mechanism& mechanism = *clip.mechanism;
  const Motion& motion = *clip.motion;
  const std::vector<int> feet = find_feet(mechanism);
  FootSlip skate(mechanism, feet);
  GroundPenetration penetration(mechanism);
  std::vector<const ContactTrack*> tracks(feet.size(), nullptr);
  for (std::size_t i = 0; i < feet.size(); ++i)
    for (const ContactTrack& track : motion.contacts)
      if (track.link == mechanism.link(feet[i]).name) tracks[i] = &track;
  std::vector<Pose> X_WB(static_cast<std::size_t>(mechanism.link_count()));
  std::vector<std::uint8_t> on(feet.size());
  for (int frame = 0; frame < motion.frames; ++frame) {
    calc_poses(mechanism, {motion.frame(frame), static_cast<std::size_t>(motion.nq)}, X_WB);
    for (std::size_t i = 0; i < feet.size(); ++i) on[i] = tracks[i] ? tracks[i]->on[static_cast<std::size_t>(frame)] : 0;
    skate.add(X_WB, on, 1 / motion.rate);
    penetration.add(X_WB);
  }
  return {{"foot skate", "cm", skate.mean_cm(), options.max_skate},
          {"ground penetration", "mm", penetration.worst_mm(), options.max_penetration}};
}

/// Compares the measures of a dynamics run with their limits.
std::vector<Judgement> judge_run(const content::PlayerMeasures& m, const Options& options) {
  return {{"tracking error", "deg", m.tracking_rms_deg, options.max_tracking},
          {"root assist", "bw", m.assist_rms_bw, options.max_assist},
          {"foot skate", "cm", m.foot_skate_cm, options.max_skate},
          {"ground penetration", "mm", m.penetration_mm, options.max_penetration},
          {"falls", "", m.fell ? 1.0 : 0.0, 0}};
}

Json to_json(const std::vector<Judgement>& judgements) {
  Json list = Json::array();
  for (const Judgement& j : judgements)
    list.push_back({{"measure", j.measure}, {"unit", j.unit}, {"value", j.value}, {"limit", j.limit}, {"good", j.good()}});
  return list;
}

/// All judgements in named groups. For a clip the groups are "motion" and "dynamics"; for content there is one group for each character.
struct Verdict {
  std::string name;
  std::vector<std::pair<std::string, std::vector<Judgement>>> parts;
  [[nodiscard]] bool good() const {
    for (const auto& [part, judgements] : parts)
      for (const Judgement& j : judgements)
        if (!j.good()) return false;
    return true;
  }
};

Result<Verdict> judge_content(const std::vector<std::byte>& ugx, const std::string& name, const Options& options) {
  const Result<RunReport> report = simulate(ugx, name, {});
  if (!report) return fail(report.error());
  Verdict verdict{report->name, {}};
  for (const CharacterReport& c : report->characters)
    if (c.tracks) verdict.parts.emplace_back(c.name, judge_run(c.measures, options));
  return verdict;
}

Result<Verdict> judge(const Options& options) {
  const Result<TargetKind> kind = kind_of(options.target);
  if (!kind) return fail(kind.error());
  if (*kind == TargetKind::executable) {
    const Result<std::string> text = files::read_file(options.target);
    if (!text) return fail(text.error());
    const auto* p = reinterpret_cast<const std::byte*>(text->data());
    return judge_content({p, p + text->size()}, options.target, options);
  }
  if (*kind == TargetKind::project) {
    const Result<project::Project> project = project::Project::open_read_only(options.target);
    if (!project) return fail(project.error());
    print_warning(project->warning());
    const Result<std::vector<std::byte>> ugx = project->generate();
    if (!ugx) return fail(ugx.error());
    return judge_content(*ugx, options.target, options);
  }
  const Result<ClipSource> clip = load_clip(options.target, options.source);
  if (!clip) return fail(clip.error());
  Verdict verdict{clip->name, {}};
  verdict.parts.emplace_back("motion", judge_motion(*clip, options));
  if (options.kinematic) return verdict;
  const Result<std::vector<std::byte>> ugx = content::generate(clip_scenario(*clip, 1 / options.rate), clip_resources(*clip));
  if (!ugx) return fail(ugx.error());
  const Result<RunReport> report = simulate(*ugx, clip->name, {});
  if (!report) return fail(report.error());
  verdict.parts.emplace_back("dynamics", judge_run(report->worst(), options));
  return verdict;
}

int run_judge(const Options& options) {
  const Result<Verdict> verdict = judge(options);
  if (!verdict) return print_error(verdict.error(), options.json);
  if (options.json) {
    Json json = {{"clip", verdict->name}, {"good", verdict->good()}};
    for (const auto& [part, judgements] : verdict->parts) json["parts"].push_back({{"part", part}, {"measures", to_json(judgements)}});
    print_json(json);
  } else {
    std::vector<std::vector<std::string>> rows = {{"part", "measure", "value", "limit", "unit", ""}};
    for (const auto& [part, judgements] : verdict->parts)
      for (const Judgement& j : judgements)
        rows.push_back({part, j.measure, to_fixed(j.value, 3), to_fixed(j.limit, 3), j.unit, j.good() ? "good" : "TOO MUCH"});
    print_line(verdict->name);
    print_table(rows);
  }
  return options.strict && !verdict->good() ? 1 : 0;
}

}  // namespace

void add_judge_verb(CLI::App& app, Action& action) {
  auto options = std::make_shared<Options>();
  CLI::App* verb = app.add_subcommand("judge", "Measure how natural a motion is, as recorded and as dynamics, and compare with limits.");
  verb->add_option("target", options->target, "BVH or AMC file, motion of the library, *.ugoki or *.ugx")->required();
  verb->add_flag("--kinematic", options->kinematic, "Judge only the recorded motion; do not run it as dynamics");
  verb->add_flag("--strict", options->strict, "Exit status 1 if a measure is over its limit");
  verb->add_option("--rate", options->rate, "Steps per second")->check(CLI::Range(250.0, 2000.0))->capture_default_str();
  const auto add_limit = [&](const std::string& measure, double& limit, const char* about) {
    verb->add_option("--max-" + measure, limit, about)->capture_default_str();
    verb->add_option("--most-" + measure, limit)->group("");  // name in earlier versions; an empty group hides the option from the help
  };
  add_limit("tracking", options->max_tracking, "Maximum tracking error, degrees (rms)");
  add_limit("assist", options->max_assist, "Maximum root assist, body weights (rms)");
  add_limit("skate", options->max_skate, "Maximum foot skate, cm per stance");
  add_limit("penetration", options->max_penetration, "Maximum ground penetration, mm");
  verb->add_option("--skeleton,--asf", options->source.asf,
                   "Skeleton of AMC files (default: NN.asf in the folder of NN_MM.amc), or model of SMPL (.npz) and OpenSim (.osim) files");
  verb->add_option("--height", options->source.intake.height, "Height of the person in m (default: estimated)")
      ->check(CLI::Range(0.1, 30.0));
  verb->add_option("--mass", options->source.intake.mass, "Mass of the person in kg (default: estimated)")
      ->check(CLI::Range(0.01, 100000.0));
  add_correction_options(*verb, options->source);
  verb->add_option("--library", options->source.library, "Library file (default: $UGOKI_LIBRARY or ~/.local/share/ugoki/library.db)");
  verb->add_flag("--json", options->json, "Print one JSON object");
  verb->footer("Example:\n  ugoki judge walk.bvh\n  ugoki judge park.ugoki --strict");
  verb->callback([options, &action] { action = [options] { return with_libraries(options->json, [&] { return run_judge(*options); }); }; });
}

}  // namespace ugoki::cli
