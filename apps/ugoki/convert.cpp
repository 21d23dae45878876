// `ugoki convert`: writes a file or an entry of the library in another format.

#include <algorithm>
#include <filesystem>
#include <memory>

#include "mechanism_output.h"
#include "output.h"
#include "output_files.h"
#include "sources.h"
#include "ugoki/base/number.h"
#include "ugoki/capture/capture.h"
#include "ugoki/files/files.h"
#include "ugoki/formats/asf.h"
#include "ugoki/formats/bvh.h"
#include "ugoki/formats/c3d.h"
#include "ugoki/formats/csv.h"
#include "ugoki/formats/gltf.h"
#include "ugoki/formats/mechanism_json.h"
#include "ugoki/formats/trc.h"
#include "ugoki/motion_edit/to_measured.h"
#include "verb.h"

namespace ugoki::cli {
namespace {

namespace fs = std::filesystem;

struct Options {
  std::string input, output, mechanism;
  SourceOptions source;
  bool positions = false, radians = false, fill = false, json = false;
  int decimals = 0;
};

/// What the input file or entry contains: mechanism, motion, markers ...; several members may be set.
struct Content {
  MechanismPtr mechanism;
  std::optional<MarkerMotion> markers;
  std::optional<MeasuredMotion> measured;
  MotionPtr motion;  ///< motion that moves `mechanism`
  bool only_mechanism = false;
  std::vector<std::string> report;
};

std::string ending_of(const std::string& path) {
  std::string ending = fs::path(path).extension().string();
  std::ranges::transform(ending, ending.begin(), [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; });
  return ending;
}

/// Reads a CSV file with coordinates of a mechanism.
Result<Content> load_coordinates(const Options& o, const std::string& text) {
  if (o.mechanism.empty())
    return fail(ErrorCode::structure, o.input, "The file contains coordinates of a mechanism, but not the mechanism.",
                "Name it with --mechanism FILE.");
  Result<intake::Intake> of = take_in_file(o.mechanism, o.source);
  if (!of) return fail(std::move(of.error()));
  formats::ReadNotes notes;
  Result<Motion> motion = formats::read_csv(text, o.input, *of->mechanism, &notes);
  if (!motion) return fail(std::move(motion.error()));
  Content out;
  out.mechanism = of->mechanism;
  out.motion = std::make_shared<const Motion>(std::move(*motion));
  out.report = std::move(notes.remarks);
  return out;
}

/// True if files with this extension contain mechanisms, not motions.
bool is_mechanism_file(std::string_view extension) {
  static constexpr std::string_view all[] = {".json", ".urdf", ".xml", ".mjcf"};
  return std::ranges::find(all, extension) != std::end(all);
}

Result<Content> load(const Options& o) {
  const Result<TargetKind> kind = kind_of(o.input);
  if (!kind) return fail(kind.error());
  Content out;
  if (*kind == TargetKind::entry) {
    Result<ClipSource> clip = load_clip(o.input, o.source);
    if (!clip) return fail(std::move(clip.error()));
    out.mechanism = clip->mechanism;
    out.motion = clip->motion;
    return out;
  }
  if (*kind != TargetKind::measured_file && *kind != TargetKind::mechanism_file)
    return fail(ErrorCode::unsupported, o.input, "This kind of file cannot be converted.", "Name a motion, a recording or a mechanism.");
  const std::optional<intake::FileKind> file = intake::file_kind(o.input);
  const std::string to = ending_of(o.output);
  const bool marker_output = to == ".c3d" || to == ".trc" || (to == ".csv" && !o.positions);
  if (file == intake::FileKind::csv || ((file == intake::FileKind::c3d || file == intake::FileKind::trc) && marker_output)) {
    // Markers are converted as markers; no body is fitted to them.
    const Result<std::string> bytes = files::read_file(o.input);
    if (!bytes) return fail(bytes.error());
    if (file == intake::FileKind::csv && formats::csv_kind(*bytes) == formats::CsvKind::coordinates) return load_coordinates(o, *bytes);
    if (marker_output) {
      formats::ReadNotes notes;
      Result<MarkerMotion> markers = intake::read_markers(*bytes, o.input, o.source.intake, notes);
      if (!markers) return fail(std::move(markers.error()));
      out.report = std::move(notes.remarks);
      if (o.fill) {
        capture::FilledMarkers filled = capture::fill_markers(*markers);
        out.report.insert(out.report.end(), filled.report.begin(), filled.report.end());
        out.markers = std::move(filled.markers);
      } else {
        out.markers = std::move(*markers);
      }
      return out;
    }
  }
  SourceOptions source = o.source;
  source.intake.motion_of_parts = !is_mechanism_file(to);
  Result<intake::Intake> loaded = take_in_file(o.input, source);
  if (!loaded) return fail(std::move(loaded.error()));
  out.mechanism = loaded->mechanism;
  out.measured = std::move(loaded->measured);
  out.markers = std::move(loaded->markers);
  if (loaded->motion) out.motion = std::make_shared<const Motion>(std::move(*loaded->motion));
  out.only_mechanism = !out.measured;
  out.report = std::move(loaded->report);
  return out;
}

/// Text or bytes of the output, and additional files in the same folder.
struct Written {
  std::string bytes;
  std::vector<std::pair<std::string, std::string>> extra_files;  ///< path and text of each additional file
  std::vector<std::string> notes;
};

Result<Written> write(const Content& c, const Options& o) {
  const std::string to = ending_of(o.output);
  const auto missing = [&](const char* what) {
    return fail(ErrorCode::structure, o.input, std::string("The input has no ") + what + ", which a " + to + " file needs.",
                "Choose another format.");
  };
  Written out;
  if (to == ".c3d" || to == ".trc") {
    if (!c.markers) return missing("markers");
    if (to == ".trc") {
      out.bytes = formats::write_trc(*c.markers, {.decimals = o.decimals > 0 ? o.decimals : 6});
      if (!c.markers->analog.empty() || !c.markers->events.empty())
        out.notes.push_back("TRC cannot store analog channels, force platforms and events; they are left out.");
      return out;
    }
    const Result<std::vector<std::byte>> bytes = formats::write_c3d(*c.markers);
    if (!bytes) return fail(bytes.error());
    out.bytes.assign(reinterpret_cast<const char*>(bytes->data()), bytes->size());
    return out;
  }
  const formats::CsvWriteOptions csv{.decimals = o.decimals, .degrees = !o.radians};
  if (to == ".csv" && c.markers && !o.positions) {
    out.bytes = formats::write_csv(*c.markers, csv);
    if (!c.markers->analog.empty() || !c.markers->events.empty())
      out.notes.push_back("CSV cannot store analog channels, force platforms and events; they are left out.");
    return out;
  }
  if (to == ".csv" && !o.positions) {
    if (!c.motion) return missing("motion");
    out.bytes = formats::write_csv(*c.motion, *c.mechanism, csv);
    return out;
  }
  std::optional<MeasuredMotion> made;
  if (!c.measured && c.motion) made = motion_edit::to_measured(*c.mechanism, *c.motion);
  const MeasuredMotion* measured = c.measured ? &*c.measured : made ? &*made : nullptr;
  if (!measured) return missing("motion");
  if (made) out.notes.push_back("The joints are the mechanism's links; the format cannot store masses and shapes.");
  if (to == ".csv") {
    out.bytes = formats::write_csv_positions(*measured, csv);
  } else if (to == ".bvh") {
    out.bytes = formats::write_bvh(*measured, {.decimals = o.decimals > 0 ? o.decimals : 8});
  } else if (to == ".glb") {
    const std::vector<std::byte> glb = formats::write_glb(*measured);
    out.bytes.assign(reinterpret_cast<const char*>(glb.data()), glb.size());
  } else {
    formats::AmcText text = formats::write_amc(*measured, {.decimals = o.decimals > 0 ? o.decimals : 10});
    out.bytes = std::move(text.amc);
    out.extra_files.emplace_back(
        (fs::path(o.output).parent_path() / intake::skeleton_name_for(fs::path(o.output).filename().string())).string(),
        std::move(text.asf));
    out.notes.insert(out.notes.end(), text.notes.begin(), text.notes.end());
    if (measured->rate != 120)
      out.notes.push_back("AMC does not store the frame rate; import the file with --rate " + to_text(measured->rate) + ".");
  }
  return out;
}

bool same_file(const std::string& a, const std::string& b) {
  std::error_code none;
  return fs::equivalent(a, b, none);
}

/// Names of the AMC files in the skeleton's folder that need this skeleton file, without the file `but`; sorted.
std::vector<std::string> motions_of(const std::string& skeleton, const std::string& but) {
  std::vector<std::string> out;
  const fs::path folder = fs::path(skeleton).has_parent_path() ? fs::path(skeleton).parent_path() : fs::path(".");
  std::error_code none;
  for (const auto& e : fs::directory_iterator(folder, none))
    if (ending_of(e.path().string()) == ".amc" && same_file(skeleton, intake::skeleton_name_for(e.path().string())) &&
        !same_file(e.path().string(), but))
      out.push_back(e.path().filename().string());
  std::ranges::sort(out);
  return out;
}

/// Refuses to overwrite the input, or a skeleton file that other motions need.
Result<void> check_written(const Options& o, const Written& written) {
  std::vector<NamedFile> inputs = input_files(o.input, o.source), outputs = {{"the output", o.output}};
  inputs.push_back({"--mechanism", o.mechanism});
  if (Result<void> may = check_outputs(inputs, outputs); !may) return may;
  for (const auto& [path, text] : written.extra_files) {
    outputs.push_back({"the skeleton of the output", path});
    if (Result<void> may = check_outputs({{"the input", o.input}}, outputs); !may) return may;
    const Result<std::string> existing = files::read_file(path);
    if (!existing || *existing == text) continue;
    const std::vector<std::string> others = motions_of(path, o.output);
    if (!others.empty())
      return fail(ErrorCode::conflict, path, "The file would be overwritten with another skeleton, but " + others.front() + " needs it.",
                  "Choose another name or folder for the output.");
  }
  return {};
}

int run_convert(const Options& o) {
  static constexpr const char* motions[] = {".bvh", ".amc", ".glb", ".csv", ".c3d", ".trc"};
  const std::string to = ending_of(o.output);
  const bool mechanism = is_mechanism_file(to);
  if (!mechanism && std::ranges::find(motions, to) == std::end(motions))
    return print_error(Error(ErrorCode::unsupported, o.output, "Files with this extension cannot be written.",
                             "Motions: .bvh, .amc (with .asf), .glb, .csv, .c3d, .trc. Mechanisms: .json, .urdf, .xml (MJCF)."),
                       o.json);
  Result<Content> content = load(o);
  if (!content) return print_error(content.error(), o.json);
  std::vector<std::string> report = std::move(content->report), extra_files;
  if (mechanism) {
    if (!content->mechanism)
      return print_error(Error(ErrorCode::structure, o.input, "The input has no mechanism.", "Choose another format."), o.json);
    if (const Result<void> may = check_written(o, {}); !may) return print_error(may.error(), o.json);
    const Result<std::vector<std::string>> notes = write_mechanism_file(*content->mechanism, o.output);
    if (!notes) return print_error(notes.error(), o.json);
    report.insert(report.end(), notes->begin(), notes->end());
  } else {
    const Result<Written> written = write(*content, o);
    if (!written) return print_error(written.error(), o.json);
    if (const Result<void> may = check_written(o, *written); !may) return print_error(may.error(), o.json);
    std::vector<files::FileText> all = {{o.output, written->bytes}};
    for (const auto& [path, text] : written->extra_files) {
      all.push_back({path, text});
      extra_files.push_back(path);
    }
    if (Result<void> done = files::write_files(all); !done) return print_error(done.error(), o.json);
    report.insert(report.end(), written->notes.begin(), written->notes.end());
  }
  if (o.json) {
    print_json({{"file", o.output}, {"beside", extra_files}, {"report", report}});
    return 0;
  }
  print_line(o.output + " written.");
  for (const std::string& path : extra_files) print_line(path + " written with it.");
  for (const std::string& line : report) print_line(line);
  return 0;
}

}  // namespace

void add_convert_verb(Verb app, Action& action) {
  auto o = std::make_shared<Options>();
  Verb verb = app.add_subcommand("convert", "Write a motion, a recording or a mechanism in another format.");
  verb.add_option("input", o->input, "A file, or a motion of the library").required();
  verb.add_option("output", o->output,
                  "Motions: .bvh, .amc (and its .asf), .glb, .csv; markers: .c3d, .trc, .csv; mechanisms: .json, .urdf, .xml")
      .required();
  verb.add_option("--decimals", o->decimals, "Digits after the decimal point (default: as many as the format needs)").check(range(1, 15));
  verb.add_flag("--positions", o->positions, "CSV: world positions of the joints instead of coordinates");
  verb.add_flag("--radians", o->radians, "CSV: angles in rad instead of degrees");
  verb.add_flag("--fill", o->fill, "Recordings of markers: fill gaps and remove spikes (default: as recorded)");
  verb.add_option("--mechanism", o->mechanism, "Mechanism of the coordinates in a CSV file");
  add_correction_options(verb, o->source);
  add_rate_option(verb, o->source);
  verb.add_option("--skeleton,--asf", o->source.asf,
                  "Skeleton of AMC files (default: NN.asf in the folder of NN_MM.amc), or body model of SMPL files (.npz)");
  add_robot_options(verb, o->source.robot);
  add_library_option(verb, o->source.library);
  verb.add_flag("--json", o->json, "Print one JSON object");
  verb.footer("Example:\n  ugoki convert walk.fbx walk.bvh\n  ugoki convert 02_01.c3d markers.csv\n  ugoki convert robot.urdf robot.xml");
  verb.callback([o, &action] { action = [o] { return run_convert(*o); }; });
}

}  // namespace ugoki::cli
