// `ugoki judge`: measures how natural a motion is, as recorded and when run as dynamics, and compares the values with limits.

#include <algorithm>
#include <filesystem>
#include <memory>

#include "judge_output.h"
#include "output.h"
#include "output_files.h"
#include "simulate.h"
#include "sources.h"
#include "ugoki/base/number.h"
#include "ugoki/files/files.h"
#include "ugoki/naturalness/judge_motion.h"
#include "ugoki/project/project.h"
#include "verb.h"

namespace ugoki::cli {
namespace {

using naturalness::MeasureId;

struct Options {
  std::string target, svg;
  SourceOptions source;
  double rate = 500, assist_limit = -1;
  double max_tracking = -1, max_assist = -1, max_skate = -1, max_penetration = -1;  // below 0: the default limit
  std::vector<std::string> limits;                                                  // KEY=NUMBER
  bool kinematic = false, strict = false, json = false;
};

struct Verdict {
  std::string name;
  std::vector<JudgedPart> parts;  ///< of a clip: "motion" and "dynamics"; of content: one for each character
  [[nodiscard]] bool good() const {
    return std::ranges::all_of(parts, [](const JudgedPart& p) { return p.report.good(); });
  }
};

/// The limits of the options: pairs of a measure and its maximum.
Result<std::vector<std::pair<MeasureId, double>>> limits_of(const Options& o) {
  std::vector<std::pair<MeasureId, double>> out;
  for (const auto& [id, limit] : {std::pair{MeasureId::tracking, o.max_tracking},
                                  {MeasureId::assist, o.max_assist},
                                  {MeasureId::slip, o.max_skate},
                                  {MeasureId::penetration, o.max_penetration}})
    if (limit >= 0) out.emplace_back(id, limit);
  for (const std::string& text : o.limits) {
    const std::size_t at = text.find('=');
    const naturalness::MeasureInfo* info = naturalness::find_measure(std::string_view(text).substr(0, at));
    const std::optional<double> limit = at == std::string::npos ? std::nullopt : parse_double(std::string_view(text).substr(at + 1));
    if (!info) {
      std::string keys;
      for (const naturalness::MeasureInfo& m : naturalness::measure_list()) keys += (keys.empty() ? "" : ", ") + std::string(m.key);
      return fail(ErrorCode::unknown, "--limit " + text, "There is no measure with this name.", "Use one of: " + keys + ".");
    }
    if (!limit || !(*limit >= 0))
      return fail(ErrorCode::range, "--limit " + text, "The limit must be a number of at least 0.",
                  "Write, for example, --limit " + std::string(info->key) + "=" + to_fixed(info->limits.high, info->digits) + ".");
    out.emplace_back(info->id, *limit);
  }
  return out;
}

Result<Verdict> judge_content(std::span<const std::byte> ugx, const std::string& name) {
  RunOptions run;
  run.over_time = true;
  Result<RunReport> report = simulate(ugx, name, run);
  if (!report) return fail(report.error());
  Verdict verdict{report->name, {}};
  for (CharacterReport& c : report->characters)
    if (c.tracks) verdict.parts.push_back({c.name, std::move(c.over_time)});
  return verdict;
}

Result<Verdict> judge(const Options& options) {
  const Result<TargetKind> kind = kind_of(options.target);
  if (!kind) return fail(kind.error());
  if (*kind == TargetKind::executable || *kind == TargetKind::project) {
    const Result<ExecutableSource> source = load_executable(options.target, options.source, 1 / options.rate);
    if (!source) return fail(source.error());
    return judge_content(source->ugx, options.target);
  }
  const Result<ClipSource> clip = load_clip(options.target, options.source);
  if (!clip) return fail(clip.error());
  Verdict verdict{clip->name, {}};
  verdict.parts.push_back({"motion", naturalness::judge_motion(*clip->mechanism, *clip->motion)});
  if (options.kinematic) return verdict;
  content::Scenario scenario = clip_scenario(*clip, 1 / options.rate);
  if (options.assist_limit >= 0)
    for (content::ScenarioCharacter& c : scenario.characters) c.control.assist_limit = options.assist_limit;
  const Result<std::vector<std::byte>> ugx = content::generate(scenario, clip_resources(*clip));
  if (!ugx) return fail(ugx.error());
  Result<Verdict> dynamics = judge_content(*ugx, clip->name);
  if (!dynamics) return fail(dynamics.error());
  for (JudgedPart& part : dynamics->parts) verdict.parts.push_back({"dynamics", std::move(part.report)});
  return verdict;
}

Result<void> write_pictures(const Verdict& verdict, const std::string& path) {
  if (!path.ends_with(".svg")) {
    std::error_code failed;
    std::filesystem::create_directories(path, failed);
    if (failed) return fail(ErrorCode::io, path, "The folder cannot be created: " + failed.message() + ".", "Choose another folder.");
  }
  const std::vector<JudgePicture> pictures = judge_pictures(verdict.parts, verdict.name, path);
  for (const JudgePicture& picture : pictures)
    if (Result<void> may = check_derived(picture.path, "class=\"ugoki-measures\""); !may && !path.ends_with(".svg")) return may;
  for (const JudgePicture& picture : pictures)
    if (Result<void> written = files::write_file(picture.path, picture.svg); !written) return written;
  return {};
}

int run_judge(const Options& options) {
  const auto limits = limits_of(options);
  if (!limits) return print_error(limits.error(), options.json);
  if (options.svg.ends_with(".svg"))
    if (Result<void> may = check_outputs(input_files(options.target, options.source), {{"--svg", options.svg}}); !may)
      return print_error(may.error(), options.json);
  Result<Verdict> verdict = judge(options);
  if (!verdict) return print_error(verdict.error(), options.json);
  for (JudgedPart& part : verdict->parts)
    for (const auto& [id, limit] : *limits) {
      naturalness::Limits& l = part.report.measures[naturalness::index_of(id)].limits;
      l.high = limit;
      l.good_high = std::min(l.good_high, limit);
      l.low = std::min(l.low, limit);
      l.good_low = std::min(l.good_low, limit);
    }
  if (!options.svg.empty())
    if (Result<void> written = write_pictures(*verdict, options.svg); !written) return print_error(written.error(), options.json);
  if (options.json) {
    print_json({{"clip", verdict->name}, {"good", verdict->good()}, {"parts", judge_json(verdict->parts)}});
  } else {
    print_line(verdict->name);
    print_judgement(verdict->parts);
  }
  return options.strict && !verdict->good() ? 1 : 0;
}

}  // namespace

void add_judge_verb(Verb app, Action& action) {
  auto options = std::make_shared<Options>();
  Verb verb = app.add_subcommand("judge", "Measure how natural a motion is, as recorded and as dynamics, and compare with limits.");
  verb.add_option("target", options->target, "Motion file, motion of the library, *.ugoki or *.ugx").required();
  verb.add_flag("--kinematic", options->kinematic, "Judge only the recorded motion; do not run it as dynamics");
  verb.add_flag("--strict", options->strict, "Exit status 1 if a measure is over its limit");
  verb.add_option("--svg", options->svg, "Plots over time: a picture (*.svg), or a folder for one picture of each measure")
      .type_name("PATH");
  verb.add_option("--limit", options->limits, "Upper limit of a measure, for example --limit jerk=1.5; may be repeated")
      .type_name("KEY=NUMBER");
  verb.add_option("--rate", options->rate, "Steps per second").check(range(250.0, 2000.0)).capture_default_str();
  verb.add_option("--assist-limit", options->assist_limit, "Limit of the root assist of a motion's simulation, body weights (default: 0.5)")
      .check(range(0.0, 10.0));
  const auto add_limit = [&](const std::string& measure, MeasureId id, double& limit, const char* about) {
    const naturalness::MeasureInfo& info = naturalness::info_of(id);
    verb.add_option("--max-" + measure, limit, std::string(about) + " (default: " + to_fixed(info.limits.high, 2) + ")");
    verb.add_option("--most-" + measure, limit, "").group("");  // name in earlier versions; an empty group hides the option from the help
  };
  add_limit("tracking", MeasureId::tracking, options->max_tracking, "Maximum tracking error, degrees (rms)");
  add_limit("assist", MeasureId::assist, options->max_assist, "Maximum root assist, body weights (rms)");
  add_limit("skate", MeasureId::slip, options->max_skate, "Maximum foot skate, cm per stance");
  add_limit("penetration", MeasureId::penetration, options->max_penetration, "Maximum ground penetration, mm");
  add_skeleton_option(verb, options->source);
  add_person_options(verb, options->source);
  add_correction_options(verb, options->source);
  add_library_option(verb, options->source.library);
  verb.add_flag("--json", options->json, "Print one JSON object");
  verb.footer("Example:\n  ugoki judge walk.bvh --svg walk.svg\n  ugoki judge park.ugoki --strict");
  verb.callback([options, &action] { action = [options] { return with_libraries(options->json, [&] { return run_judge(*options); }); }; });
}

}  // namespace ugoki::cli
