// `ugoki run`: runs a clip, a project or executable data as dynamics and prints measures of the run.

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>

#include "output.h"
#include "output_files.h"
#include "simulate.h"
#include "sources.h"
#include "ugoki/base/hash.h"
#include "ugoki/base/number.h"
#include "ugoki/correction/correct.h"
#include "ugoki/files/files.h"
#include "verb.h"

namespace ugoki::cli {
namespace {

struct Options {
  std::string target;
  SourceOptions source;
  double rate = 500, duration = 0;
  double push = 0, push_time = 1, push_duration = 0.2;
  std::string push_link = "chest";
  std::vector<double> push_direction = {1, 0};
  double assist_limit = -1;
  std::string frames, executable, inputs;
  std::uint64_t steps = 0;
  int threads = 1;
  bool rate_given = false, correct = false, json = false;
};

/// Executable data to run, with name, frame count and body height from their source.
struct Content {
  std::string name;
  std::vector<std::byte> ugx;
  int frames = 0;                                          ///< recorded frames of a clip; 0: use the number of display frames
  double height = 0;                                       ///< height of the recorded person of a clip, m; 0: not known
  std::vector<std::string> checks;                         ///< sentences: what dynamics cannot follow in a measured motion
  std::optional<correction::CorrectionReport> correction;  ///< with --correct
};

/// Whether a run follows its motion so badly that the user needs the reason.
bool is_lost(const content::PlayerMeasures& m) {
  constexpr double far_deg = 10;  // joints; clean captures are followed within 4 degrees
  return m.fell || m.release_time >= 0 || m.tracking_rms_deg > far_deg;
}

/// A sentence about the time in which the limited root assist did not suffice; empty if it is below a twentieth of the run.
std::string describe_capped(const CharacterReport& c) {
  constexpr double few = 0.05;
  if (!c.tracks || c.capped_share < few || !(c.assist_limit > 0)) return {};
  return c.name + ": the root assist was at its limit of " + to_text(c.assist_limit) + " body weights in " +
         to_fixed(100 * c.capped_share, 0) + " % of the time (first at " + to_fixed(c.capped_from, 2) +
         " s). There the motion accelerates or turns the body more than the ground can, from where the feet touch it: the body lags "
         "behind.";
}

/// Applies --rate, --assist-limit (all characters) and --push (the first character that follows a track) to the scenario.
Result<void> apply_options(content::Scenario& s, const content::Resources& resources, const Options& options) {
  if (options.rate_given) s.step = 1 / options.rate;
  const auto target = std::find_if(s.characters.begin(), s.characters.end(),
                                   [](const content::ScenarioCharacter& c) { return c.control.mode != content::ControlMode::passive; });
  if (options.assist_limit >= 0)
    for (content::ScenarioCharacter& c : s.characters) c.control.assist_limit = options.assist_limit;
  if (options.push == 0) return {};
  if (target == s.characters.end())
    return fail(ErrorCode::structure, "--push", "The content has no character that follows a track.", "Omit --push.");
  content::ScenarioEvent push;
  push.id = "command-line-push";
  push.time = options.push_time;
  push.duration = options.push_duration;
  push.character = target->id;
  push.link = options.push_link;
  const double length = std::hypot(options.push_direction[0], options.push_direction[1]);
  // Relative to the character's heading at the start: x is forward, y left.
  const SinCos heading = sin_cos(target->place.heading * pi / 180);
  const double x = options.push_direction[0] / length * options.push, y = options.push_direction[1] / length * options.push;
  push.force = {heading.cos * x - heading.sin * y, heading.sin * x + heading.cos * y, 0};
  const Mechanism& mechanism = *resources.mechanisms.at(target->mechanism);
  if (content::find_link(mechanism, push.link) < 0) {
    std::string links;
    for (const Link& link : mechanism.links())
      links += (links.empty() ? "" : ", ") + (link.label.empty() ? link.name : link.name + " (" + link.label + ")");
    return fail(ErrorCode::unknown, "--push-link", "The character has no link '" + push.link + "'.", "It has: " + links + ".");
  }
  s.events.push_back(push);
  return {};
}

/// Replaces the motion of a clip by a near one that obeys the laws of mechanics.
Result<correction::CorrectionReport> correct_clip(SceneSource& clip) {
  MotionPtr& motion = clip.resources.motions.at("motion");
  correction::CorrectionReport report;
  Result<Motion> made = correction::correct_motion(*clip.resources.mechanisms.at("mechanism"), *motion, {}, &report);
  if (!made) return fail(std::move(made.error()));
  clip.frames = made->frames;
  clip.scenario.duration = clip.scenario.characters[0].track[0].length = std::max(0.001, made->duration());
  motion = std::make_shared<const Motion>(std::move(*made));
  return report;
}

Result<Content> load(const Options& options) {
  const Result<TargetKind> kind = kind_of(options.target);
  if (!kind) return fail(kind.error());
  Content out;
  if (*kind == TargetKind::executable) {
    if (options.push != 0 || options.rate_given || options.assist_limit >= 0 || options.correct)
      return fail(ErrorCode::unsupported, options.target, "Executable data cannot be run with --rate, --push, --assist-limit or --correct.",
                  "Name the project instead.");
    const Result<std::string> text = files::read_file(options.target);
    if (!text) return fail(text.error());
    const auto* p = reinterpret_cast<const std::byte*>(text->data());
    out.ugx = {p, p + text->size()};
    out.name = options.target;
    return out;
  }
  Result<SceneSource> scene = load_scene(options.target, options.source, 1 / options.rate);
  if (!scene) return fail(std::move(scene.error()));
  if (options.correct) {
    if (*kind == TargetKind::project)
      return fail(ErrorCode::unsupported, "--correct", "Motions of a project cannot be corrected by a run.",
                  "Correct them in the studio, or name a motion file.");
    const Result<correction::CorrectionReport> done = correct_clip(*scene);
    if (!done) return fail(done.error());
    out.correction = *done;
  }
  out.name = scene->name;
  out.frames = scene->frames;
  out.height = scene->height;
  out.checks = scene->checks;
  if (Result<void> done = apply_options(scene->scenario, scene->resources, options); !done) return fail(std::move(done.error()));
  Result<std::vector<std::byte>> ugx = content::generate(scene->scenario, scene->resources);
  if (!ugx) return fail(std::move(ugx.error()));
  out.ugx = std::move(*ugx);
  return out;
}

Json measures_json(const content::PlayerMeasures& m) {
  return {{"tracking_rms_deg", m.tracking_rms_deg},
          {"root_assist_rms_bw", m.assist_rms_bw},
          {"root_assist_force_rms_bw", m.assist_force_rms_bw},
          {"root_assist_max_bw", m.assist_max_bw},
          {"foot_skate_cm", m.foot_skate_cm},
          {"foot_skate_worst_cm", m.foot_skate_worst_cm},
          {"penetration_mm", m.penetration_mm},
          {"penetration_rms_mm", m.penetration_rms_mm},
          {"fell", m.fell},
          {"release_time", m.release_time >= 0 ? Json(m.release_time) : Json(nullptr)}};
}

/// One touch event as JSON; a side that is the ground is null.
Json touch_json(const RunReport& report, const content::PlayerTouch& t) {
  const auto side = [&](int character, int link) -> Json {
    if (character < 0) return nullptr;
    const CharacterReport& c = report.characters[static_cast<std::size_t>(character)];
    const bool named = link >= 0 && static_cast<std::size_t>(link) < c.links.size();
    return {{"character", c.id}, {"link", named ? Json(c.links[static_cast<std::size_t>(link)]) : Json(nullptr)}};
  };
  if (t.omitted > 0) return {{"time", t.time}, {"event", "omitted"}, {"count", t.omitted}, {"text", t.words}};
  return {{"time", t.time},
          {"event", t.ended ? "end" : "begin"},
          {"a", side(t.character_a, t.link_a)},
          {"b", side(t.character_b, t.link_b)},
          {"point_m", {t.point.x, t.point.y, t.point.z}},
          {"impulse_Ns", {t.impulse.x, t.impulse.y, t.impulse.z}},
          {"duration_s", t.duration},
          {"text", t.words}};
}

int run_run(const Options& options) {
  std::vector<NamedFile> inputs = input_files(options.target, options.source);
  inputs.push_back({"--inputs", options.inputs});
  if (Result<void> may = check_outputs(inputs, {{"--ugx", options.executable}, {"--frames", options.frames}}); !may)
    return print_error(may.error(), options.json);
  Result<Content> content = load(options);
  if (!content) return print_error(content.error(), options.json);
  if (!options.executable.empty())
    if (Result<void> written = files::write_file(options.executable, std::span<const std::byte>(content->ugx)); !written)
      return print_error(written.error(), options.json);
  Result<RunReport> report =
      simulate(content->ugx, content->name, {options.duration, options.frames, options.inputs, options.steps, options.threads});
  if (!report) return print_error(report.error(), options.json);
  const content::PlayerMeasures worst = report->worst();
  if (is_lost(worst))
    for (const CharacterReport& c : report->characters)
      if (std::string sentence = describe_capped(c); !sentence.empty()) content->checks.push_back(std::move(sentence));
  double mass = 0;
  for (const CharacterReport& c : report->characters)
    if (c.tracks && mass == 0) mass = c.mass;
  std::string hash(16, '0');
  for (std::size_t i = 0; i < 16; ++i) hash[i] = "0123456789abcdef"[(report->state_hash >> (60 - 4 * i)) & 15];
  if (options.json) {
    const long frames = content->frames > 0 ? content->frames : std::lround(report->duration * report->frame_rate);
    Json json = {{"clip", content->name},
                 {"frames", frames},
                 {"duration_s", report->duration},
                 {"steps", report->steps},
                 {"steps_per_s", report->steps_per_second()}};
    json.update(measures_json(worst));
    json["realtime_factor"] = report->realtime_factor();
    json["realtime_factor_cpu"] = report->processor_realtime_factor();
    json["mass"] = mass;
    json["height"] = content->height > 0 ? Json(content->height) : Json(nullptr);
    json["state_hash"] = hash;
    Json characters = Json::array();
    for (const CharacterReport& c : report->characters) {
      Json character = {{"id", c.id}, {"name", c.name}, {"mass", c.mass}, {"tracks", c.tracks}};
      if (c.tracks) character.update(measures_json(c.measures));
      characters.push_back(std::move(character));
    }
    json["characters"] = std::move(characters);
    json["checks"] = content->checks;
    if (content->correction)
      json["correction"] = {{"change_deg", content->correction->change_deg}, {"root_move_cm", content->correction->root_move_cm}};
    json["touches"] = Json::array();
    for (const content::PlayerTouch& t : report->touches) json["touches"].push_back(touch_json(*report, t));
    json["touch_count"] = report->touch_count;
    json["not_converged"] = report->quality.not_converged;
    json["split_steps"] = report->quality.split_steps;
    json["substeps"] = report->quality.substeps;
    json["step_failures"] = report->quality.failures;
    print_json(json);
    return 0;
  }
  print_line(content->name + ": " + to_fixed(report->duration, 2) + " s in " + std::to_string(report->steps) + " steps of " +
             to_fixed(1000 * report->step, 3) + " ms, " + to_fixed(report->realtime_factor(), 1) + " times faster than real time, state " +
             hash);
  std::vector<std::vector<std::string>> rows = {
      {"character", "tracking deg", "assist bw", "skate cm", "penetration mm", "released s", "fell"}};
  for (const CharacterReport& c : report->characters) {
    if (!c.tracks) {
      rows.push_back({c.name, "-", "-", "-", "-", "-", "-"});
      continue;
    }
    const content::PlayerMeasures& m = c.measures;
    rows.push_back({c.name, to_fixed(m.tracking_rms_deg, 2), to_fixed(m.assist_rms_bw, 3), to_fixed(m.foot_skate_cm, 2),
                    to_fixed(m.penetration_mm, 1), m.release_time >= 0 ? to_fixed(m.release_time, 2) : "-", m.fell ? "yes" : "no"});
  }
  print_table(rows);
  if (content->correction)
    print_line("The motion was corrected before the run: its joints changed by " + to_fixed(content->correction->change_deg, 1) +
               " degrees rms, its root by " + to_fixed(content->correction->root_move_cm, 1) + " cm rms.");
  if (is_lost(worst)) {
    for (const std::string& sentence : content->checks) print_line(sentence);
    if (content->frames > 0 && !content->correction)
      print_line("With --correct, the run follows a motion near this one that obeys the laws of mechanics as far as possible.");
    print_line("`ugoki judge " + options.target + "` shows when the motion needs forces that the ground cannot give.");
  }
  return 0;
}

}  // namespace

void add_run_verb(Verb app, Action& action) {
  auto options = std::make_shared<Options>();
  Verb verb = app.add_subcommand("run", "Run a clip, a project or executable data as dynamics, and print measures.");
  verb.add_option("target", options->target, "BVH or AMC file, motion of the library, *.ugoki or *.ugx").required();
  const Option rate = verb.add_option("--rate", options->rate, "Steps per second (default of a project: its own step)")
                          .check(range(250.0, 2000.0))
                          .capture_default_str();
  verb.add_option("--duration", options->duration, "Seconds to run (default: to the end)").check(range(0.0005, 86400.0));
  verb.add_option("--steps", options->steps, "Simulation steps to run (default: to the end)").check(range(1, 1'000'000'000));
  verb.add_option("--threads", options->threads, "Number of threads; the result does not depend on it")
      .check(range(1, 64))
      .capture_default_str();
  verb.add_option("--inputs", options->inputs, "Recorded inputs, JSON (docs/export.md)");
  verb.add_option("--push", options->push, "Push with this force in N").check(range(-1e6, 1e6));
  verb.add_option("--push-time", options->push_time, "Time at which the push begins, s").check(range(0.0, 86400.0)).capture_default_str();
  verb.add_option("--push-duration", options->push_duration, "Duration of the push, s").check(range(0.0005, 3600.0)).capture_default_str();
  verb.add_option("--push-link", options->push_link, "Link to push, by name or label").capture_default_str();
  verb.add_option("--push-direction", options->push_direction,
                  "Direction x,y of the push; x is the character's forward direction at the start, y its left")
      .delimiter(',')
      .expected(2);
  verb.add_option("--assist-limit", options->assist_limit, "Cap of the root assist, body weights").check(range(0.0, 10.0));
  verb.add_flag("--correct", options->correct,
                "First correct the clip as `ugoki correct` does: run a motion near it that obeys the laws of mechanics");
  verb.add_option("--frames", options->frames, "Write the display frames to this file (docs/files.md)");
  verb.add_option("--ugx", options->executable, "Write the executable data to this file");
  add_skeleton_option(verb, options->source);
  add_person_options(verb, options->source);
  add_correction_options(verb, options->source);
  add_library_option(verb, options->source.library);
  verb.add_flag("--json", options->json, "Print one JSON object");
  verb.footer("Example:\n  ugoki run walk.bvh --json\n  ugoki run 12_01.amc --push 150 --push-time 2 --push-direction 0,1");
  verb.callback([options, rate, &action] {
    options->rate_given = rate.given();
    if (std::hypot(options->push_direction[0], options->push_direction[1]) < 1e-9) refuse("--push-direction", "must not be 0,0.");
    action = [options] { return with_libraries(options->json, [&] { return run_run(*options); }); };
  });
}

}  // namespace ugoki::cli
