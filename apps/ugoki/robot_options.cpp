#include "robot_options.h"

#include <filesystem>

#include "ugoki/files/files.h"

namespace ugoki::cli {
namespace {

namespace fs = std::filesystem;
using namespace robot_formats;

constexpr std::size_t max_asset = std::size_t{1} << 28;

Result<std::string> read_asset(const std::string& path) {
  std::error_code ignored;
  if (!fs::is_regular_file(path, ignored)) return fail(ErrorCode::io, path, "There is no such file.");
  return files::read_file(path, max_asset);
}

/// robot.yaml beside robot.urdf, if it is there and names loops.
Result<std::optional<SideFile>> loops_beside(const std::string& path) {
  for (const char* ending : {".yaml", ".yml"}) {
    const std::string beside = fs::path(path).replace_extension(ending).string();
    std::error_code ignored;
    if (!fs::is_regular_file(beside, ignored)) continue;
    Result<std::string> text = files::read_file(beside, max_asset);
    if (!text) return fail(std::move(text.error()));
    if (text->find("closed_loop") != std::string::npos) return SideFile{beside, std::move(*text)};
  }
  return std::nullopt;
}

}  // namespace

void add_robot_options(CLI::App& verb, RobotChoice& choice) {
  verb.add_option("--base", choice.base, "Of a URDF, SDF or MJCF: fixed to the world or floating (otherwise as the file says)")
      ->check(CLI::IsMember({"fixed", "floating"}));
  verb.add_option("--meshes", choice.meshes, "Meshes: their exact surface, convex hull, the box around them, or left out (otherwise hull)")
      ->check(CLI::IsMember({"exact", "hull", "box", "none"}));
  verb.add_flag("--require-meshes", choice.require_meshes, "A mesh that collides and is missing or unusable is an error, not a note");
  verb.add_option("--inertias", choice.inertias, "Inertias that no body can have: repaired or refused (otherwise repair)")
      ->check(CLI::IsMember({"repair", "strict"}));
  verb.add_option("--loops", choice.loops, "YAML file that names the loops of a URDF or SDF (otherwise NAME.yaml beside it)");
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
  Result<std::optional<SideFile>> beside = loops_beside(path);
  if (!beside) return fail(std::move(beside.error()));
  out.loops = std::move(*beside);
  return out;
}

}  // namespace ugoki::cli
