// `ugoki correct`: changes a motion so that it obeys the laws of mechanics.

#include "ugoki/correction/correct.h"

#include <cmath>
#include <memory>
#include <optional>

#include "motion_files.h"
#include "output.h"
#include "output_files.h"
#include "simulate.h"
#include "ugoki/base/number.h"
#include "ugoki/correction/rehearse.h"
#include "verb.h"

namespace ugoki::cli {
namespace {

using correction::CorrectionMeasures;
using correction::CorrectionReport;

struct Options {
  std::string input, out;
  SourceOptions source;
  correction::CorrectOptions correct;
  bool keep_floor = false, rehearse = false, json = false;
  int samples = correction::RehearseOptions{}.samples;
};

Json to_json(const CorrectionMeasures& m) {
  return {{"foot_skate_cm", m.skate_cm},    {"penetration_mm", m.penetration_mm}, {"residual_bw", m.residual_bw},
          {"flight_error_g", m.flight_g},   {"flight_spin_m2_s", m.spin},         {"jerk_1000rad_s3", m.jerk},
          {"limit_excess_deg", m.limit_deg}};
}

void print_report(const CorrectionReport& r) {
  const auto row = [](const char* name, double before, double after, int digits, const char* unit) {
    return std::vector<std::string>{name, to_fixed(before, digits), to_fixed(after, digits), unit};
  };
  const CorrectionMeasures &a = r.before, &b = r.after;
  print_table({{"measure", "before", "after", "unit"},
               row("foot skate", a.skate_cm, b.skate_cm, 2, "cm"),
               row("ground penetration", a.penetration_mm, b.penetration_mm, 1, "mm"),
               row("missing wrench on the root", a.residual_bw, b.residual_bw, 3, "bw"),
               row("acceleration error in flight", a.flight_g, b.flight_g, 3, "g"),
               row("change of spin in flight", a.spin, b.spin, 3, "m2/s"),
               row("jerk", a.jerk, b.jerk, 2, "1000 rad/s3"),
               row("excess of joint limits", a.limit_deg, b.limit_deg, 1, "deg")});
  std::string line = "Joints changed by " + to_fixed(r.change_deg, 2) + " degrees rms, root by " + to_fixed(r.root_move_cm, 1) + " cm rms.";
  if (r.replaced_frames > 0) line += " Popping frames of joints: " + std::to_string(r.replaced_frames) + ".";
  print_line(line);
  if (r.floor_height != 0 || r.floor_tilt != 0)
    print_line("The floor was at " + to_fixed(100 * r.floor_height, 1) + " cm and tilted by " + to_fixed(r.floor_tilt, 2) + " degrees.");
  if (r.travel > 0) print_line("The standing feet slid all the time; the motion now travels " + to_fixed(r.travel, 2) + " m/s faster.");
  if (std::fabs(r.duration_change) >= 0.0005)  // s: less is printed as 0
    print_line("Gravity was wrong in a flight; the duration changed by " + to_fixed(r.duration_change, 3) + " s.");
}

/// Writes the corrected motion. @param fields the measures, for --json @return nothing after an error, which has been printed
std::optional<std::string> put_result(const Options& o, const MotionSet& set, const Motion& made, const Json& fields) {
  const Result<std::string> put = put_motion(*set.mechanism, made, set.height, o.out, o.source);
  if (!put) {
    print_error(put.error(), o.json);
    return std::nullopt;
  }
  if (o.json) {
    Json all = {{"name", made.name}, {"out", o.out}, {"written", *put}, {"frames", made.frames}, {"duration_s", made.duration()}};
    all.update(fields);
    all["report"] = set.report;
    print_json(all);
  }
  return *put;
}

int run_rehearse(const Options& o, const MotionSet& set) {
  correction::RehearseOptions options;
  options.gravity = o.correct.gravity;
  options.friction = o.correct.friction;
  options.samples = o.samples;
  Progress progress("correct");
  options.progress = [&](double done) {
    progress.show(done);
    return !interrupted();
  };
  correction::RehearseReport report;
  const Result<Motion> made = correction::rehearse_motion(set.mechanism, set.motions[0], options, &report);
  progress.clear();
  if (!made) return print_error(interrupted() ? interrupted_error() : made.error(), o.json);
  const auto put = put_result(o, set, *made,
                              {{"assist_bw", report.assist_bw}, {"change_deg", report.change_deg}, {"root_move_cm", report.root_move_cm}});
  if (!put) return 1;
  if (o.json) return 0;
  print_line("The given motion needs a root assist of " + to_fixed(report.assist_bw, 2) + " body weights rms; the result needs none.");
  print_line("Joints changed by " + to_fixed(report.change_deg, 2) + " degrees rms, root by " + to_fixed(report.root_move_cm, 1) +
             " cm rms.");
  for (const std::string& line : set.report) print_line(line);
  print_line(*put);
  return 0;
}

int run_correct(const Options& o) {
  if (Result<void> may = check_outputs(input_files({o.input}, o.source), {{"--out", writes_file(o.out) ? o.out : ""}}); !may)
    return print_error(may.error(), o.json);
  const Result<MotionSet> set = load_motions({o.input}, o.source);
  if (!set) return print_error(set.error(), o.json);
  catch_interrupt();
  if (o.rehearse) return run_rehearse(o, *set);
  correction::CorrectOptions options = o.correct;
  options.level_floor = !o.keep_floor;
  Progress progress("correct");
  options.progress = [&](double done) {
    progress.show(done);
    return !interrupted();
  };
  CorrectionReport report;
  const Result<Motion> made = correction::correct_motion(*set->mechanism, set->motions[0], options, &report);
  progress.clear();
  if (!made) return print_error(interrupted() ? interrupted_error() : made.error(), o.json);
  const auto put = put_result(o, *set, *made,
                              {{"before", to_json(report.before)},
                               {"after", to_json(report.after)},
                               {"replaced_frames", report.replaced_frames},
                               {"floor_height_m", report.floor_height},
                               {"floor_tilt_deg", report.floor_tilt},
                               {"travel_m_s", report.travel},
                               {"flights", report.flights},
                               {"duration_change_s", report.duration_change},
                               {"change_deg", report.change_deg},
                               {"root_move_cm", report.root_move_cm}});
  if (!put) return 1;
  if (o.json) return 0;
  print_report(report);
  for (const std::string& line : set->report) print_line(line);
  print_line(*put);
  return 0;
}

}  // namespace

void add_correct_verb(Verb app, Action& action) {
  auto options = std::make_shared<Options>();
  Verb verb = app.add_subcommand("correct", "Correct a motion so that it obeys the laws of mechanics.");
  verb.add_option("input", options->input, "A BVH, AMC, C3D, TRC or glTF file or a motion of the library").required();
  verb.add_option("-o,--out", options->out, "Output: a .bvh or .glb file, or a name without a dot for an entry of the library").required();
  correction::CorrectOptions& o = options->correct;
  verb.add_option("--strength", o.strength, "0: no change, 1: complete correction").check(number_from(0, 1)).capture_default_str();
  verb.add_option("--gravity", o.gravity, "m/s^2").check(number_from(0.01, 100)).capture_default_str();
  verb.add_option("--friction", o.friction, "Coulomb coefficient of the ground").check(number_from(0, 10)).capture_default_str();
  verb.add_option("--smoothing", o.smoothing, "Cut-off of the low-pass filter, Hz; 0: no filter")
      .check(number_from(0, 1000))
      .capture_default_str();
  verb.add_flag("--rehearse", options->rehearse,
                "Simulate the motion and search for joint torques that reproduce it: for rolls and other motions on hands and back");
  verb.add_option("--samples", options->samples, "--rehearse: simulations of each 0.1 s")
      .check(number_from(25, 1000000))
      .capture_default_str();
  verb.add_flag("--keep-floor", options->keep_floor, "The floor of the motion is z = 0; do not search for it");
  verb.add_flag("--keep-duration", o.keep_duration, "Do not change the duration of flights in which gravity is wrong");
  add_skeleton_option(verb, options->source);
  add_person_options(verb, options->source);
  add_library_option(verb, options->source.library);
  verb.add_flag("--json", options->json, "Print one JSON object");
  verb.footer("Example:\n  ugoki correct keyed-jump.bvh -o jump.bvh");
  verb.callback(
      [options, &action] { action = [options] { return with_libraries(options->json, [&] { return run_correct(*options); }); }; });
}

}  // namespace ugoki::cli
