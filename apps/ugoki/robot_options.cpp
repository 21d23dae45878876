#include "robot_options.h"

#include <filesystem>

#include "output_files.h"
#include "ugoki/files/files.h"

namespace ugoki::cli {
namespace {

namespace fs = std::filesystem;
using namespace robot_formats;

constexpr std::size_t max_asset = std::size_t{1} << 28;

Result<std::string> read_asset(const std::string& path) {
  note_read(path);
  return files::read_regular_file(path, max_asset);
}

/// Path of robot.yaml in the folder of robot.urdf, if it exists and lists loops.
Result<std::optional<SideFile>> find_loops_file(const std::string& path) {
  for (const char* ending : {".yaml", ".yml"}) {
    const std::string loops_path = fs::path(path).replace_extension(ending).string();
    std::error_code ignored;
    if (!fs::is_regular_file(loops_path, ignored)) continue;
    Result<std::string> text = files::read_file(loops_path, max_asset);
    if (!text) return fail(std::move(text.error()));
    if (text->find("closed_loop") == std::string::npos) continue;
    note_read(loops_path);
    return SideFile{loops_path, std::move(*text)};
  }
  return std::nullopt;
}

}  // namespace

void add_robot_options(Verb verb, RobotChoice& choice) {
  verb.add_option("--base", choice.base, "Base of a URDF, SDF or MJCF: fixed to the world or floating (default: as the file specifies)")
      .check(one_of({"fixed", "floating"}));
  verb.add_option("--meshes", choice.meshes, "Meshes: exact surface, convex hull, bounding box, or left out (default: hull)")
      .check(one_of({"exact", "hull", "box", "none"}));
  verb.add_flag("--require-meshes", choice.require_meshes, "Treat a missing or unusable collision mesh as an error instead of a note");
  verb.add_option("--inertias", choice.inertias, "Physically impossible inertias: repair or refuse (default: repair)")
      .check(one_of({"repair", "strict"}));
  verb.add_option("--loops", choice.loops, "YAML file that lists the loops of a URDF or SDF (default: NAME.yaml in its folder)");
}

Result<RobotOptions> robot_options(const std::string& path, const RobotChoice& choice) {
  RobotOptions out;
  out.base = choice.base == "fixed" ? Base::fixed : choice.base == "floating" ? Base::floating : Base::by_file;
  out.meshes = choice.meshes == "exact"  ? Meshes::exact
               : choice.meshes == "box"  ? Meshes::box
               : choice.meshes == "none" ? Meshes::none
                                         : Meshes::hull;
  out.require_meshes = choice.require_meshes;
  out.inertias = choice.inertias == "strict" ? Inertias::strict : Inertias::repair;
  out.read_asset = read_asset;
  if (!choice.loops.empty()) {
    Result<std::string> text = files::read_file(choice.loops, max_asset);
    if (!text) return fail(std::move(text.error()));
    out.loops = SideFile{choice.loops, std::move(*text)};
    return out;
  }
  Result<std::optional<SideFile>> loops_file = find_loops_file(path);
  if (!loops_file) return fail(std::move(loops_file.error()));
  out.loops = std::move(*loops_file);
  return out;
}

}  // namespace ugoki::cli
