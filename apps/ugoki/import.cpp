// `ugoki import`: stores measured files and mechanism files as library entries.

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>

#include "output.h"
#include "output_files.h"
#include "sources.h"
#include "ugoki/base/number.h"
#include "ugoki/files/files.h"
#include "ugoki/formats/bvh.h"
#include "verb.h"

namespace ugoki::cli {
namespace {

namespace fs = std::filesystem;

struct Options {
  std::vector<std::string> files;
  SourceOptions source;
  std::string bvh;
  bool dry = false, json = false;
};

/// Writes the measured motion as BVH and reads it again. @return maximum position error of a joint over all frames, m
Result<double> write_back(const MeasuredMotion& measured, const std::string& path) {
  const std::string text = formats::write_bvh(measured);
  formats::BvhOptions same_unit;
  same_unit.metres_per_unit = measured.skeleton.unit;
  const Result<MeasuredMotion> read_back = formats::read_bvh(text, path, same_unit);
  if (!read_back) return fail(read_back.error());
  if (Result<void> written = files::write_file(path, text); !written) return fail(std::move(written.error()));
  double worst = read_back->frames == measured.frames && read_back->joint_count() == measured.joint_count() ? 0 : INFINITY;
  std::vector<Pose> before(static_cast<std::size_t>(measured.joint_count())), after(before.size());
  for (int frame = 0; std::isfinite(worst) && frame < measured.frames; ++frame) {
    measured.calc_joint_poses(frame, before);
    read_back->calc_joint_poses(frame, after);
    for (std::size_t j = 0; j < before.size(); ++j)
      if (const double off = norm(before[j].p - after[j].p); !(off <= worst)) worst = off;
  }
  return worst;
}

bool same_file(const std::string& a, const std::string& b) {
  std::error_code ignored;
  return a == b || fs::equivalent(a, b, ignored);
}

/// Path of the BVH copy of a measured file. If --bvh names a folder, the copy has the name of the measured file, with a number if this run
/// has already written that name.
Result<std::string> copy_path(const std::string& path, const Options& options, const std::vector<std::string>& written) {
  std::error_code ignored;
  std::string out = options.bvh;
  if (fs::is_directory(options.bvh, ignored)) {
    const std::string stem = fs::path(path).stem().string();
    const auto is_written = [&] { return std::ranges::any_of(written, [&](const std::string& w) { return same_file(w, out); }); };
    out = (fs::path(options.bvh) / (stem + ".bvh")).string();
    for (int number = 2; is_written(); ++number) out = (fs::path(options.bvh) / (stem + "-" + std::to_string(number) + ".bvh")).string();
  }
  if (Result<void> may = check_outputs(input_files(options.files, options.source), {{"--bvh", out}}); !may)
    return fail(std::move(may.error()));
  return out;
}

/// Imports one file completely or, on an error, not at all.
/// @param written [in, out] paths of the copies written by this run
Result<Json> import_one(const std::string& path, const Options& options, store::Library* library, std::vector<std::string>& written) {
  Result<intake::Intake> loaded = take_in_file(path, options.source);
  if (!loaded) return fail(std::move(loaded.error()));
  Json row = {{"file", path}, {"name", loaded->items.front().name}};
  if (loaded->measured) {
    row["frames"] = loaded->measured->frames;
    row["joints"] = loaded->measured->joint_count();
    row["duration_s"] = loaded->measured->duration();
    row["rate"] = loaded->measured->rate;
    row["height_m"] = loaded->body->height;
  } else {
    row["joints"] = loaded->mechanism->link_count();
  }
  row["mass_kg"] = loaded->mechanism->mass();
  row["dofs"] = loaded->mechanism->nv();
  row["links"] = loaded->mechanism->link_count();
  if (loaded->body) row["human"] = loaded->body->human;
  if (loaded->metres_per_unit > 0) row["metres_per_unit"] = loaded->metres_per_unit;
  if (!options.bvh.empty() && loaded->measured) {
    const Result<std::string> out = copy_path(path, options, written);
    if (!out) return fail(out.error());
    const Result<double> error = write_back(*loaded->measured, *out);
    if (!error) return fail(error.error());
    written.push_back(*out);
    row["bvh"] = *out;
    row["bvh_error_m"] = *error;
  }
  if (library) {
    const Result<std::vector<std::string>> ids = intake::put(*library, *loaded);
    if (!ids) return fail(ids.error());
    for (std::size_t i = 0; i < ids->size(); ++i) row["ids"][std::string(store::name_of(loaded->items[i].kind))] = (*ids)[i];
  }
  row["report"] = loaded->report;
  return row;
}

std::string cell(const Json& row, const char* key, int digits) {
  if (!row.contains(key)) return "-";
  const Json& value = row[key];
  return value.is_number_integer() ? std::to_string(value.get<long>()) : to_fixed(value.get<double>(), digits);
}

int run_import(Options options) {
  catch_interrupt();
  options.source.intake.cancelled = interrupted;
  std::unique_ptr<store::Library> library;
  if (!options.dry) {
    Result<store::Library> opened = store::Library::open(library_path(options.source.library));
    if (!opened) return print_error(opened.error(), options.json);
    print_warning(opened->warning());
    library = std::make_unique<store::Library>(std::move(*opened));
  }
  Json files = Json::array(), errors = Json::array();
  std::vector<std::vector<std::string>> table = {{"name", "frames", "joints", "s", "1/s", "height m", "mass kg", "dofs", "motion"}};
  std::vector<std::string> copies;
  Progress progress("import");
  bool failed = false;
  for (std::size_t i = 0; i < options.files.size(); ++i) {
    progress.show(static_cast<double>(i) / static_cast<double>(options.files.size()));
    Result<Json> row = interrupted() ? fail(interrupted_error()) : import_one(options.files[i], options, library.get(), copies);
    if (!row) {
      failed = true;
      progress.clear();
      (void)print_error(row.error(), false);
      Json error = json::error_json(row.error());
      error["file"] = options.files[i];
      errors.push_back(std::move(error));
      if (interrupted()) break;
      continue;
    }
    table.push_back({(*row)["name"], cell(*row, "frames", 0), cell(*row, "joints", 0), cell(*row, "duration_s", 3), cell(*row, "rate", 2),
                     cell(*row, "height_m", 3), cell(*row, "mass_kg", 2), cell(*row, "dofs", 0),
                     row->contains("ids") && (*row)["ids"].contains("motion") ? (*row)["ids"]["motion"].get<std::string>() : "-"});
    files.push_back(std::move(*row));
  }
  progress.clear();
  if (options.json) {
    print_json({{"files", std::move(files)}, {"errors", std::move(errors)}});
    return failed ? 1 : 0;
  }
  if (table.size() > 1) print_table(table);
  for (const Json& file : files) {
    for (const Json& line : file["report"]) print_line(file["name"].get<std::string>() + ": " + line.get<std::string>());
    if (file.contains("bvh"))
      print_line(file["name"].get<std::string>() + ": written to " + file["bvh"].get<std::string>() +
                 "; maximum position error of a joint: " + to_text(file["bvh_error_m"].get<double>()) + " m.");
  }
  return failed ? 1 : 0;
}

}  // namespace

void add_import_verb(Verb app, Action& action) {
  auto options = std::make_shared<Options>();
  Verb verb = app.add_subcommand("import", "Read measured files, build bodies for them, and store both in the library.");
  verb.add_option("files", options->files,
                  "BVH, AMC (with their ASF), C3D, TRC, CSV, glTF, FBX, COLLADA, mechanism JSON, URDF, SDF or MJCF files")
      .required();
  verb.add_option("--name", options->source.intake.name, "Name of the entries (one file only; default: the file's name)");
  verb.add_option("--tags", options->source.intake.tags, "Tags of the entries, separated by commas").delimiter(',');
  add_person_options(verb, options->source);
  add_correction_options(verb, options->source);
  add_rate_option(verb, options->source);
  add_skeleton_option(verb, options->source);
  add_robot_options(verb, options->source.robot);
  verb.add_option("--bvh", options->bvh, "Also write the measured motion as BVH: a file, or a folder for several inputs");
  add_library_option(verb, options->source.library);
  verb.add_flag("--dry-run", options->dry, "Read and report, but store nothing");
  verb.add_flag("--json", options->json, "Print one JSON object");
  verb.footer("Example:\n  ugoki import walk.bvh --tags walk,slow\n  ugoki import 12_01.amc --asf 12.asf --mass 70 --bvh copy.bvh");
  verb.callback([options, &action] {
    std::error_code ignored;
    if (options->files.size() > 1 && !options->source.intake.name.empty()) refuse("--name", "can be used only with one input file.");
    if (options->files.size() > 1 && !options->bvh.empty() && !fs::is_directory(options->bvh, ignored))
      refuse("--bvh", "must be an existing folder when there are several files.");
    action = [options] { return run_import(*options); };
  });
}

}  // namespace ugoki::cli
