#include "sources.h"

#include <filesystem>
#include <fstream>

#include "output.h"
#include "output_files.h"
#include "ugoki/content/flatten.h"
#include "ugoki/files/files.h"
#include "ugoki/formats/mechanism_json.h"
#include "ugoki/formats/motion_binary.h"
#include "ugoki/intake/mapping_file.h"
#include "ugoki/intake/support.h"
#include "ugoki/mechanism/state.h"
#include "ugoki/motion/clip.h"
#include "ugoki/project/project.h"
#include "ugoki/project/project_file.h"
#include "ugoki/store/sqlite.h"

namespace ugoki::cli {
namespace {

namespace fs = std::filesystem;

Result<ClipSource> clip_of(intake::Intake loaded) {
  if (!loaded.motion)
    return fail(ErrorCode::structure, loaded.source, "The file contains a mechanism without a motion.", "Name a BVH or AMC file.");
  return ClipSource{loaded.motion->name, loaded.mechanism, std::make_shared<const Motion>(std::move(*loaded.motion)),
                    loaded.body ? loaded.body->height : 0, std::move(loaded.conversion.check)};
}

/// Adds what dynamics cannot follow. A measured file has been checked when it was taken in.
ClipSource checked(ClipSource clip) {
  if (std::string sentence = intake::describe_missing_support(*clip.mechanism, *clip.motion, clip.height); !sentence.empty())
    clip.checks.push_back(std::move(sentence));
  return clip;
}

Result<ClipSource> clip_of_entry(const std::string& target, const SourceOptions& options) {
  const Result<store::Library> library = library_of(target, options);
  if (!library) return fail(library.error());
  Result<store::LibraryEntry> entry = library->resolve(target, "motion");
  if (!entry) {
    Result<store::LibraryEntry> measured = library->resolve(target);
    if (!measured)
      return fail(ErrorCode::unknown, target, "The file does not exist, and the library (" + library->path() + ") has no such motion.",
                  "List its motions with `ugoki db list --kind motion`.");
    entry = std::move(measured);
  }
  Result<std::vector<std::byte>> data = library->data(entry->id);
  if (!data) return fail(std::move(data.error()));
  const std::string location = "library entry " + entry->id;
  if (entry->kind == store::EntryKind::mechanism)
    return fail(ErrorCode::structure, location, "'" + entry->name + "' is a mechanism, not a motion.", "Name a motion.");
  if (entry->kind == store::EntryKind::measured) {
    Result<MeasuredMotion> measured = formats::read_measured_motion(*data, location);
    if (!measured) return fail(std::move(measured.error()));
    body::BodyOptions body_options;
    body_options.height = options.intake.height;
    body_options.mass = options.intake.mass;
    Result<body::Body> body = body::make_body(*measured, body_options);
    if (!body) return fail(std::move(body.error()));
    return checked({entry->name, body->mechanism, std::make_shared<const Motion>(body::to_motion(*body, *measured)), body->height});
  }
  Result<Motion> motion = formats::read_motion(*data, location);
  if (!motion) return fail(std::move(motion.error()));
  const Json summary = Json::parse(entry->summary, nullptr, false);
  const std::string mechanism_id = summary.is_object() && summary.contains("mechanism") && summary["mechanism"].is_string()
                                       ? summary["mechanism"].get<std::string>()
                                       : "";
  Result<std::vector<std::byte>> mechanism_data = library->content(mechanism_id);
  if (!mechanism_data)
    return fail(ErrorCode::unknown, location, "The library lacks the mechanism '" + mechanism_id + "' of the motion '" + entry->name + "'.",
                "Import the measured file again.");
  Result<MechanismPtr> mechanism = formats::read_mechanism({reinterpret_cast<const char*>(mechanism_data->data()), mechanism_data->size()},
                                                           "library entry " + mechanism_id);
  if (!mechanism) return fail(std::move(mechanism.error()));
  const double height = summary.contains("height") && summary["height"].is_number() ? summary["height"].get<double>() : 0;
  return checked({entry->name, std::move(*mechanism), std::make_shared<const Motion>(std::move(*motion)), height});
}

}  // namespace

void add_library_option(Verb verb, std::string& path) {
  verb.add_option("--library", path, "Library file (default: $UGOKI_LIBRARY or ~/.local/share/ugoki/library.db)");
}

void add_skeleton_option(Verb verb, SourceOptions& options) {
  verb.add_option("--skeleton,--asf", options.asf,
                  "Skeleton of AMC files (default: NN.asf in the folder of NN_MM.amc), or model of SMPL (.npz) and OpenSim (.osim) files");
}

void add_rate_option(Verb verb, SourceOptions& options) {
  verb.add_option("--rate", options.intake.rate, "Frames per second of AMC files, which do not store it")
      .check(range(1.0, 10000.0))
      .capture_default_str();
}

void add_person_options(Verb verb, SourceOptions& options) {
  verb.add_option("--height", options.intake.height, "Height of the person in m (default: estimated)").check(range(0.1, 30.0));
  verb.add_option("--mass", options.intake.mass, "Mass of the person in kg (default: estimated)").check(range(0.01, 100000.0));
}

void add_correction_options(Verb verb, SourceOptions& options) {
  verb.add_option("--unit", options.intake.unit, "Metres per unit of length of the file (default: as the file specifies, or estimated)")
      .check(range(1e-6, 1000.0));
  verb.add_option("--species", options.intake.species,
                  "Species of an animal (\"deer\"), whose usual mass limits its size; none: ignore names (default: by names in the file)");
  verb.add_flag("--travel", options.intake.travel, "Give a character that walks in place (on a treadmill) the travel of its feet");
  verb.add_flag("--correct-labels", options.intake.correct_labels, "Exchange marker labels that are exchanged in the whole recording");
  verb.add_option("--mapping", options.mapping, "Correct the recognised anatomy by a JSON file that `ugoki info --mapping-out` wrote");
  verb.add_option("--character", options.intake.character, "Character of a file with several: its number from 1, or its root joint");
  verb.add_option("--take", options.intake.take, "Motion of a file with several: its number from 1, or its name");
  const auto axis = [&options](bool is_up) {
    return Check([&options, is_up](const std::string& text) -> std::string {
      const std::optional<intake::FileAxis> named = intake::file_axis_named(text);
      if (!named) return "must be x, -x, y, -y, z or -z.";
      intake::Orientation& o = options.intake.axes ? *options.intake.axes : options.intake.axes.emplace(intake::usual_orientation(false));
      (is_up ? o.up : o.forward) = *named;
      // If no forward axis is given, it is the axis that follows the up axis: Z forward with Y up, X forward with Z up.
      if (is_up) o.forward = {(named->axis + 1) % 3, false};
      return {};
    });
  };
  verb.add_option("--up", "Up axis of the file: x, -x, y, -y, z or -z (default: as the file specifies, or by the character's posture)")
      .check(axis(true));
  verb.add_option("--forward", "Forward axis of the file, after --up (default: z for y up, x for z up, y for x up)").check(axis(false));
}

std::string library_path(const std::string& option) { return option.empty() ? store::Library::default_path() : option; }

Result<store::Library> library_of(const std::string& target, const SourceOptions& options) {
  const std::string path = library_path(options.library);
  if (!store::Library::exists(path))
    return fail(ErrorCode::unknown, target,
                "The file does not exist, and there is no library (" + path + ") that could contain such an entry.",
                "Check the name, or import something first.");
  Result<store::Library> library = store::Library::open_read_only(path);
  if (library) print_warning(library->warning());
  return library;
}

Result<TargetKind> kind_of(const std::string& target) {
  std::error_code ignored;
  if (!fs::exists(target, ignored)) {
    // A name with a folder or a known file extension is a missing file, not an entry.
    if (target.find('/') != std::string::npos || target.ends_with(".ugoki") || target.ends_with(".ugx") || intake::file_kind(target))
      return fail(ErrorCode::io, target, "The file does not exist.", "Check its name.");
    return TargetKind::entry;
  }
  if (Result<void> readable = files::check_readable(target); !readable) return fail(std::move(readable.error()));
  std::string head(72, '\0');
  if (fs::is_regular_file(target, ignored)) {  // a pipe cannot be read twice; its kind follows from its extension
    std::ifstream file(target, std::ios::binary);
    file.read(head.data(), static_cast<std::streamsize>(head.size()));
  }
  if (head.starts_with("UGOKIUGX")) return TargetKind::executable;
  if (head.starts_with("SQLite format 3")) {
    // The header is read here and not by SQLite: opening the database is the task of the code that checks it.
    std::int64_t application = 0;  // SQLite's application id: big-endian u32 at offset 68
    for (std::size_t i = 68; i < 72; ++i) application = application << 8 | static_cast<unsigned char>(head[i]);
    return application == project::project_application_id ? TargetKind::project : TargetKind::library;
  }
  if (target.ends_with(".ugoki")) return TargetKind::project;  // a damaged project is reported when it is opened
  if (target.ends_with(".ugx")) return TargetKind::executable;
  const std::optional<intake::FileKind> kind = intake::file_kind(target);
  if (!kind)
    return fail(ErrorCode::unsupported, target, "The kind of this file is unknown.",
                "Name a .bvh, .amc, .c3d, .trc, .gltf, .glb, .usda, .mvnx, .npz, .mot, .sto, .txt, .osim, .json, .urdf, .sdf, .xml, .obj, "
                ".stl, .ply, .ugoki "
                "or .ugx file.");
  const bool mechanism = *kind == intake::FileKind::mechanism_json || *kind == intake::FileKind::robot || *kind == intake::FileKind::mesh;
  return mechanism ? TargetKind::mechanism_file : TargetKind::measured_file;
}

namespace {
Result<intake::Intake> take_in_mapped(const std::string& path, const SourceOptions& options) {
  Result<std::string> bytes = files::read_file(path);
  if (!bytes) return fail(std::move(bytes.error()));
  const std::optional<intake::FileKind> kind = intake::file_kind(path);
  if (kind == intake::FileKind::robot) {
    Result<robot_formats::RobotOptions> robot = robot_options(path, options.robot);
    if (!robot) return fail(std::move(robot.error()));
    intake::IntakeOptions intake_options = options.intake;
    intake_options.robot = std::move(*robot);
    Result<intake::Intake> loaded = intake::take_in(*bytes, path, nullptr, intake_options);
    if (loaded && intake_options.robot.loops) loaded->report.push_back("Loops are read from " + intake_options.robot.loops->name + ".");
    return loaded;
  }
  if (kind == intake::FileKind::gltf || kind == intake::FileKind::mesh || kind == intake::FileKind::scene) {
    intake::IntakeOptions gltf_options = options.intake;
    gltf_options.files = [&](std::string_view uri) -> Result<std::vector<std::byte>> {
      const fs::path relative = fs::path(uri).lexically_normal();
      if (relative.is_absolute() || relative.begin() == relative.end() || *relative.begin() == "..")
        return fail(ErrorCode::unsupported, path, "The file '" + std::string(uri) + "', to which it refers, is outside its folder.",
                    "Copy it to the folder of the file.");
      const std::string buffer = (fs::path(path).parent_path() / relative).string();
      note_read(buffer);
      Result<std::string> text = files::read_regular_file(buffer);
      if (!text) return fail(std::move(text.error()));
      const auto* p = reinterpret_cast<const std::byte*>(text->data());
      return std::vector<std::byte>(p, p + text->size());
    };
    return intake::take_in(*bytes, path, nullptr, gltf_options);
  }
  const bool has_model = kind == intake::FileKind::smpl || kind == intake::FileKind::opensim || kind == intake::FileKind::deepmimic;
  if (has_model && !options.asf.empty()) {
    Result<std::string> model = files::read_file(options.asf);
    if (!model) return fail(std::move(model.error()));
    intake::IntakeOptions model_options = options.intake;
    model_options.model = std::move(*model);
    model_options.model_name = options.asf;
    return intake::take_in(*bytes, path, nullptr, model_options);
  }
  if (kind != intake::FileKind::amc) return intake::take_in(*bytes, path, nullptr, options.intake);
  const std::string asf_path = options.asf.empty() ? intake::skeleton_name_for(path) : options.asf;
  std::error_code ignored;
  if (options.asf.empty() && !fs::exists(asf_path, ignored))
    return fail(ErrorCode::io, path, "The skeleton " + asf_path + " does not exist.", "Name the skeleton with --skeleton FILE.");
  Result<std::string> asf_text = files::read_file(asf_path);
  if (!asf_text) return fail(std::move(asf_text.error()));
  formats::AsfOptions asf_options;
  asf_options.metres_per_unit = options.intake.unit;
  const Result<formats::Asf> asf = formats::read_asf(*asf_text, asf_path, asf_options);
  if (!asf) return fail(asf.error());
  return intake::take_in(*bytes, path, &*asf, options.intake);
}
}  // namespace

Result<intake::Intake> take_in_file(const std::string& path, const SourceOptions& options) {
  if (options.mapping.empty()) return take_in_mapped(path, options);
  const Result<std::string> text = files::read_file(options.mapping);
  if (!text) return fail(text.error());
  Result<body::AnatomyMapping> mapping = intake::read_mapping(*text, options.mapping);
  if (!mapping) return fail(std::move(mapping.error()));
  SourceOptions mapped = options;
  mapped.intake.mapping = std::move(*mapping);
  return take_in_mapped(path, mapped);
}

Result<ClipSource> load_clip(const std::string& target, const SourceOptions& options) {
  const Result<TargetKind> kind = kind_of(target);
  if (!kind) return fail(kind.error());
  if (*kind == TargetKind::entry) return clip_of_entry(target, options);
  if (*kind != TargetKind::measured_file)
    return fail(ErrorCode::unsupported, target, "This is not a motion.",
                "Name a .bvh, .amc, .c3d, .trc, .gltf, .glb, .usda, .mvnx or .npz file, or a motion of the library.");
  SourceOptions with_motion = options;
  with_motion.intake.motion_of_parts = true;  // here rigid parts that move are a motion, not a mesh
  Result<intake::Intake> loaded = take_in_file(target, with_motion);
  if (!loaded) return fail(std::move(loaded.error()));
  if (!loaded->motion)
    return fail(ErrorCode::structure, target, "The file contains a mesh without a motion.", "Name a file with a motion.");
  return clip_of(std::move(*loaded));
}

Result<SceneSource> load_scene(const std::string& target, const SourceOptions& options, double step) {
  const Result<TargetKind> kind = kind_of(target);
  if (!kind) return fail(kind.error());
  SceneSource out;
  if (*kind == TargetKind::project) {
    const Result<project::Project> project = project::Project::open_read_only(target);
    if (!project) return fail(project.error());
    print_warning(project->warning());
    out.scenario = content::flatten(project->scenario());
    out.resources = project->resources();
    out.name = out.scenario.name;
    return out;
  }
  const Result<ClipSource> clip = load_clip(target, options);
  if (!clip) return fail(clip.error());
  out.scenario = clip_scenario(*clip, step);
  out.resources = clip_resources(*clip);
  out.name = clip->name;
  out.frames = clip->motion->frames;
  out.height = clip->height;
  out.checks = clip->checks;
  return out;
}

Result<ExecutableSource> load_executable(const std::string& target, const SourceOptions& options, double step) {
  const Result<TargetKind> kind = kind_of(target);
  if (!kind) return fail(kind.error());
  if (*kind == TargetKind::executable) {
    const Result<std::string> text = files::read_file(target);
    if (!text) return fail(text.error());
    const auto* p = reinterpret_cast<const std::byte*>(text->data());
    return ExecutableSource{fs::path(target).stem().string(), {p, p + text->size()}};
  }
  const Result<SceneSource> scene = load_scene(target, options, step);
  if (!scene) return fail(scene.error());
  Result<std::vector<std::byte>> ugx = content::generate(scene->scenario, scene->resources);
  if (!ugx) return fail(std::move(ugx.error()));
  return ExecutableSource{scene->name, std::move(*ugx)};
}

namespace {

/// Distance [m] from which a camera sees the whole character with some floor around it, at any size: a rat, a person, a horse.
double camera_distance(const ClipSource& clip) {
  constexpr double sizes = 2.8, nearest = 0.1;  // a person is seen from 5 m
  const Mechanism& m = *clip.mechanism;
  std::vector<Pose> X(static_cast<std::size_t>(m.link_count()));
  calc_poses(m, {clip.motion->frame(0), static_cast<std::size_t>(clip.motion->nq)}, X);
  Vec3 low = X[0].p, high = low;
  for (const Pose& pose : X)
    for (int k = 0; k < 3; ++k) {
      low[k] = std::min(low[k], pose.p[k]);
      high[k] = std::max(high[k], pose.p[k]);
    }
  return std::max(nearest, sizes * std::max(clip.height, norm(high - low)));
}

}  // namespace

content::Scenario clip_scenario(const ClipSource& clip, double step) {
  content::Scenario s;
  s.name = clip.name;
  s.duration = std::max(0.001, clip.motion->duration());
  s.step = step;
  content::ScenarioCharacter character;
  character.id = "character";
  character.name = clip.mechanism->name().empty() ? "character" : clip.mechanism->name();
  character.mechanism = "mechanism";
  // The motion keeps its measured position, because its floor and objects are at that position.
  const Placement start = root_placement(*clip.mechanism, {clip.motion->frame(0), static_cast<std::size_t>(clip.motion->nq)});
  character.place = {start.x, start.y, 0, start.heading * (180 / pi)};
  content::ScenarioClip clip_part;
  clip_part.id = "k1";
  clip_part.motion = "motion";
  clip_part.length = s.duration;
  clip_part.blend = 0;
  character.track.push_back(clip_part);
  s.camera.follow = "character";
  s.camera.distance = camera_distance(clip);
  s.characters.push_back(character);
  return s;
}

content::Resources clip_resources(const ClipSource& clip) {
  content::Resources resources;
  resources.mechanisms["mechanism"] = clip.mechanism;
  resources.motions["motion"] = clip.motion;
  return resources;
}

}  // namespace ugoki::cli
