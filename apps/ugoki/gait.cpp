// `ugoki gait`: makes a walk, a trot ... without measured data.

#include "ugoki/gait/gait.h"

#include <algorithm>
#include <cmath>
#include <memory>

#include "gait_ground.h"
#include "motion_files.h"
#include "output.h"
#include "output_files.h"
#include "simulate.h"
#include "target_body.h"
#include "ugoki/base/number.h"
#include "ugoki/content/scenario.h"
#include "ugoki/files/files.h"
#include "ugoki/formats/mechanism_json.h"
#include "ugoki/project/project.h"
#include "ugoki/spatial/elementary.h"
#include "verb.h"

namespace ugoki::cli {
namespace {

constexpr double degree = pi / 180;

struct Options {
  std::string body, kind = "walk", style = "usual", out, mechanism_out, project;
  std::vector<std::string> then, path;
  std::vector<double> phases;
  double height = 0, speed = -1, turn = 0, assist = 0;
  GaitGround ground;
  bool stride = false, moving = false, json = false;
  bool timed = false;  ///< the duration was given
  gait::GaitOptions gait;
  SourceOptions source;
};

/// Splits "a,b,c" into numbers. Nothing: not so many numbers.
std::optional<std::vector<double>> numbers_of(const std::string& text, std::size_t count) {
  std::vector<double> out;
  for (std::size_t from = 0; from <= text.size();) {
    const std::size_t to = std::min(text.find(',', from), text.size());
    const std::optional<double> x = parse_double(text.substr(from, to - from));
    if (!x || !std::isfinite(*x)) return std::nullopt;
    out.push_back(*x);
    from = to + 1;
  }
  if (out.size() != count) return std::nullopt;
  return out;
}

Result<gait::GaitKind> kind_of_gait(const std::string& name) {
  if (const std::optional<gait::GaitKind> kind = gait::kind_named(name)) return *kind;
  std::string names;
  for (int k = 0; k < gait::kind_count; ++k) names += (k > 0 ? ", " : "") + std::string(gait::name_of(static_cast<gait::GaitKind>(k)));
  return fail(ErrorCode::unknown, "--kind", "There is no gait '" + name + "'.", "Use " + names + ".");
}

/// Stage "TIME,KIND,SPEED,TURN" of --then.
Result<gait::GaitStage> stage_of(const std::string& text) {
  const std::size_t a = text.find(','), b = a == std::string::npos ? a : text.find(',', a + 1);
  const auto wrong = [&] {
    return fail(ErrorCode::syntax, "--then '" + text + "'", "This is not a stage.",
                "Give time, kind, speed and turn rate, for example 5,walk,1.5,0.");
  };
  if (b == std::string::npos) return wrong();
  const std::optional<std::vector<double>> time = numbers_of(text.substr(0, a), 1), rest = numbers_of(text.substr(b + 1), 2);
  if (!time || !rest) return wrong();
  const Result<gait::GaitKind> kind = kind_of_gait(text.substr(a + 1, b - a - 1));
  if (!kind) return fail(kind.error());
  return gait::GaitStage{(*time)[0], *kind, (*rest)[0], (*rest)[1] * degree};
}

Result<gait::GaitOptions> gait_options(const Options& o) {
  gait::GaitOptions out = o.gait;
  const Result<gait::GaitKind> kind = kind_of_gait(o.kind);
  if (!kind) return fail(kind.error());
  out.stages = {{0, *kind, o.speed, o.turn * degree}};
  for (const std::string& text : o.then) {
    const Result<gait::GaitStage> stage = stage_of(text);
    if (!stage) return fail(stage.error());
    out.stages.push_back(*stage);
  }
  std::ranges::sort(out.stages, {}, &gait::GaitStage::time);
  const std::optional<gait::GaitStyle> style = gait::style_named(o.style);
  if (!style) {
    std::string names;
    for (const std::string_view name : gait::style_names()) names += (names.empty() ? "" : ", ") + std::string(name);
    return fail(ErrorCode::unknown, "--style", "There is no style '" + o.style + "'.", "Use " + names + ".");
  }
  out.style = *style;
  out.one_stride = o.stride;
  out.phases = o.phases;
  if (o.moving) out.from_stand = out.to_stand = false;
  for (const std::string& text : o.path) {
    const std::optional<std::vector<double>> point = numbers_of(text, 2);
    if (!point) return fail(ErrorCode::syntax, "--path '" + text + "'", "This is not a point.", "Give x and y in m, for example 2,0.5.");
    out.path.push_back({(*point)[0], (*point)[1], 0});
  }
  if (o.project.empty()) out.ground = height_of(o.ground);  // in a project, balance control adapts the gait of level ground
  return out;
}

/// A project in which the character performs the gait.
Result<void> write_project(const Options& o, const MechanismPtr& mechanism, const Motion& motion) {
  ClipSource clip{motion.name, mechanism, std::make_shared<const Motion>(motion), 0};
  content::Scenario scenario = clip_scenario(clip, 0.002);
  scenario.name = motion.name;
  for (content::ScenarioCharacter& c : scenario.characters) c.control.assist_limit = o.assist;
  if (Result<void> put = add_ground(o.ground, motion, scenario); !put) return fail(std::move(put.error()));
  const Result<project::Project> made = project::Project::create(o.project, scenario, clip_resources(clip));
  if (!made) return fail(made.error());
  return {};
}

int run_gait(const Options& o) {
  if (Result<void> may = check_outputs(
          {{"body", o.body}}, {{"--out", writes_file(o.out) ? o.out : ""}, {"--mechanism-out", o.mechanism_out}, {"--project", o.project}});
      !may)
    return print_error(may.error(), o.json);
  if (!o.project.empty() && !o.out.empty() && !o.ground.level())
    return print_error(
        {ErrorCode::range, "--out",
         "In a project, a slope or stairs are props, and the motion is that of level ground; a motion file follows the ground.",
         "Call `ugoki gait` twice, once with --project and once with --out."},
        o.json);
  Result<gait::GaitOptions> options = gait_options(o);
  if (!options) return print_error(options.error(), o.json);
  const Result<MechanismPtr> body = load_body(o.body, o.height, o.source);
  if (!body) return print_error(body.error(), o.json);
  for (gait::GaitStage& stage : options->stages) {
    if (stage.speed >= 0) continue;
    const Result<double> speed = gait::usual_speed(*body, stage.kind, options->gravity);
    if (!speed) return print_error(speed.error(), o.json);
    stage.speed = *speed;
  }
  if (options->path.size() > 1 && !o.timed && !o.stride && !o.moving)
    if (const Result<void> fitted = gait::fit_to_path(*body, *options); !fitted) return print_error(fitted.error(), o.json);
  gait::GaitReport report;
  const Result<Motion> made = gait::make_gait(*body, *options, &report);
  if (!made) return print_error(made.error(), o.json);
  std::vector<std::string> written;
  if (!o.out.empty()) {
    const Result<std::string> put = put_motion(**body, *made, o.height, o.out, o.source);
    if (!put) return print_error(put.error(), o.json);
    written.push_back(*put);
  }
  if (!o.mechanism_out.empty()) {
    if (const Result<void> put = files::write_file(o.mechanism_out, formats::write_mechanism(**body)); !put)
      return print_error(put.error(), o.json);
    written.push_back("Mechanism written to " + o.mechanism_out + ".");
  }
  if (!o.project.empty()) {
    if (const Result<void> put = write_project(o, *body, *made); !put) return print_error(put.error(), o.json);
    written.push_back("Project written to " + o.project + ". Open it with: ugoki studio " + o.project);
  }
  if (o.json) {
    Json legs = Json::array();
    for (std::size_t k = 0; k < report.legs.size(); ++k) {
      Json stances = Json::array();
      for (const gait::FootStance& s : report.stances[k])
        stances.push_back({{"begin", s.begin}, {"end", s.end}, {"place", {s.place.x, s.place.y, s.place.z}}, {"heading", s.heading}});
      legs.push_back({{"foot", report.legs[k]}, {"stances", stances}});
    }
    print_json({{"name", made->name},
                {"frames", made->frames},
                {"rate", made->rate},
                {"duration_s", made->duration()},
                {"stride_s", report.stride_time},
                {"duty", report.duty},
                {"miss_mm", 1000 * report.max_miss},
                {"lowered_cm", 100 * report.max_lowering},
                {"pressure_error_cm", 100 * report.pressure_rms},
                {"legs", legs},
                {"notes", report.notes},
                {"written", written}});
    return 0;
  }
  print_line(made->name + ": " + to_fixed(made->duration(), 2) + " s, stride " + to_fixed(report.stride_time, 3) + " s, each foot stands " +
             to_fixed(100 * report.duty, 0) + " % of it.");
  print_line("Largest distance of a foot from its path: " + to_fixed(1000 * report.max_miss, 1) +
             " mm. Error of the centre of pressure: " + to_fixed(100 * report.pressure_rms, 1) + " cm rms.");
  for (const std::string& note : report.notes) print_line(note);
  for (const std::string& line : written) print_line(line);
  return 0;
}

}  // namespace

void add_gait_verb(Verb app, Action& action) {
  auto o = std::make_shared<Options>();
  Verb verb = app.add_subcommand("gait", "Make a walk, trot, gallop ... of any body with legs, without measured data.");
  verb.add_option("body", o->body, "human, dog, mechanism file (JSON, URDF, SDF, MJCF), measured file, or entry of the library");
  verb.add_option("--height", o->height, "Instead of a body: a person of this height in m").check(range(0.8, 5.0));
  verb.add_option("--kind", o->kind, "walk, run, trot, pace, canter, gallop, rotary, bound, pronk").capture_default_str();
  verb.add_option("--speed", o->speed, "m/s (default: a usual speed of the kind)").check(number_from(0, 100));
  verb.add_option("--turn", o->turn, "Degrees per second, positive to the left").check(number_from(-570, 570)).capture_default_str();
  verb.add_option("--then", o->then, "Further stage TIME,KIND,SPEED,TURN (s, m/s, degrees per second), for example 5,walk,1.5,0");
  const Option seconds = verb.add_option("--seconds", o->gait.seconds, "Duration; with --path: until the end of the path")
                             .check(number_from(0.05, 3600))
                             .capture_default_str();
  verb.add_flag("--stride", o->stride, "One stride, cyclic, instead of a duration");
  verb.add_flag("--moving", o->moving, "Do not start and end with standing");
  verb.add_option("--style", o->style, "usual, sneak, tired, proud, hurried").capture_default_str();
  verb.add_option("--path", o->path, "Points X,Y of a path over the ground, in m; the turn rates are then not used").expected(2, 1000);
  verb.add_option("--step-height", o->gait.step_height, "Height of the swing feet, m (default: from the table)").check(number_from(0, 10));
  verb.add_option("--stride-time", o->gait.stride_time, "Duration of a stride, s (default: from the table)").check(number_from(0, 20));
  verb.add_option("--duty", o->gait.duty, "Share of the stride in which a foot stands (default: from the table)")
      .check(number_from(0, 0.95));
  verb.add_option("--phases", o->phases, "Touch-down of each leg as a share of the stride, in the order of the report").delimiter(',');
  verb.add_option("--slope", o->ground.slope, "Slope of the ground ahead, degrees").check(number_from(-30, 30));
  verb.add_option("--stairs", o->ground.stairs, "Height of the steps of stairs that begin 1 m ahead, m; negative: downwards")
      .check(number_from(-1, 1));
  verb.add_option("--stair-depth", o->ground.stair_depth, "Depth of a step, m").check(number_from(0.05, 10)).capture_default_str();
  verb.add_option("--rate", o->gait.rate, "Frames per second").check(number_from(20, 1000)).capture_default_str();
  verb.add_option("--gravity", o->gait.gravity, "m/s^2").check(number_from(0.1, 100)).capture_default_str();
  verb.add_option("-o,--out", o->out, "Output: a .bvh or .glb file, or the name of a new entry in the library");
  verb.add_option("--mechanism-out", o->mechanism_out, "Also write the mechanism, as JSON");
  verb.add_option("--project", o->project, "Also write a project (*.ugoki) in which the character performs the gait");
  verb.add_option("--assist", o->assist, "Assist limit in the project, body weights").check(number_from(0, 10)).capture_default_str();
  add_robot_options(verb, o->source.robot);
  add_library_option(verb, o->source.library);
  verb.add_flag("--json", o->json, "Print one JSON object");
  verb.footer(
      "Example:\n  ugoki gait human --kind walk --speed 1.25 --seconds 10 --turn 45 -o walk.bvh\n  ugoki gait dog --kind trot --speed 2 "
      "--then 5,trot,2.5,0 --project dog.ugoki\n  ugoki gait robot.urdf --stride -o step.glb");
  verb.callback([o, seconds, &action] {
    o->timed = seconds.given();
    if (o->body.empty() && !(o->height > 0)) refuse("body", "or --height is required.");
    action = [o] { return run_gait(*o); };
  });
}

}  // namespace ugoki::cli
