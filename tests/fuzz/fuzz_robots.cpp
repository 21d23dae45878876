#include <string>
#include <string_view>
#include <vector>

#include "fuzz_targets.h"
#include "ugoki/base/check.h"
#include "ugoki/formats/mechanism_json.h"
#include "ugoki/robot_formats/mesh_file.h"
#include "ugoki/robot_formats/sdf.h"
#include "ugoki/robot_formats/urdf.h"

namespace ugoki {
namespace {

using namespace robot_formats;

using Reader = Result<RobotModel> (*)(std::string_view, std::string_view, const RobotOptions&);

/// Splits the input at lines "=====" into the description, its loops file, and the mesh that is used for every mesh name.
std::vector<std::string> parts_of(std::string_view text) {
  constexpr std::string_view divider = "=====\n";
  std::vector<std::string> out;
  for (std::size_t at = text.find(divider); at != std::string_view::npos; at = text.find(divider)) {
    out.emplace_back(text.substr(0, at));
    text.remove_prefix(at + divider.size());
  }
  out.emplace_back(text);
  return out;
}

void check_error(const Error& error) {
  UGOKI_CHECK(!error.problems.empty());
  for (const Problem& p : error.problems) UGOKI_CHECK(!p.location.empty() && !p.message.empty());
}

void fuzz_robot(Reader read, const std::uint8_t* data, std::size_t size) {
  const std::vector<std::string> parts = parts_of({reinterpret_cast<const char*>(data), size});
  RobotOptions options;
  options.meshes = size % 4 == 0 ? Meshes::exact : size % 4 == 1 ? Meshes::hull : size % 4 == 2 ? Meshes::box : Meshes::none;
  options.require_meshes = size % 3 == 0;
  options.base = size % 5 == 0 ? Base::floating : size % 5 == 1 ? Base::fixed : Base::by_file;
  options.inertias = size % 7 == 0 ? Inertias::strict : Inertias::repair;
  if (parts.size() > 1) options.loops = SideFile{"fuzz.yaml", parts[1]};
  options.read_asset = [&](const std::string& path) -> Result<std::string> {
    if (parts.size() < 3) return fail(ErrorCode::io, path, "the file does not exist.");
    return parts[2];
  };
  const Result<RobotModel> model = read(parts[0], "fuzz.xml", options);
  if (!model) return check_error(model.error());
  const Mechanism& m = *model->mechanism;
  UGOKI_CHECK(model->X_BF.size() == static_cast<std::size_t>(m.link_count()));
  for (const JointName& j : model->joints) UGOKI_CHECK(m.find_link(j.link) >= 0 || m.find_loop(j.link) >= 0);
  for (const std::string& link : model->driven) UGOKI_CHECK(m.find_link(link) >= 0);
  // A mechanism that was read can be stored in the library.
  if (m.link_count() < 1000) UGOKI_CHECK(formats::read_mechanism(formats::write_mechanism(m), "again.json").has_value());
}

}  // namespace

void fuzz_urdf(const std::uint8_t* data, std::size_t size) { fuzz_robot(read_urdf, data, size); }
void fuzz_sdf(const std::uint8_t* data, std::size_t size) { fuzz_robot(read_sdf, data, size); }

/// Input: a line with the file name, then the mesh.
void fuzz_mesh(const std::uint8_t* data, std::size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  const std::size_t line = text.find('\n');
  if (line == std::string_view::npos || line == 0) return;
  const Result<MeshFile> mesh = read_mesh(text.substr(line + 1), text.substr(0, line));
  if (!mesh) return check_error(mesh.error());
  UGOKI_CHECK(!mesh->points.empty());
  for (const auto& t : mesh->triangles)
    for (const int i : t) UGOKI_CHECK(i >= 0 && i < static_cast<int>(mesh->points.size()));
  const Shape box = box_around(mesh->points);
  UGOKI_CHECK(box.half_extents.x > 0 && box.half_extents.y > 0 && box.half_extents.z > 0);
  for (const Vec3& p : mesh->points) {
    const Vec3 local = transpose_times(box.X_BS.R, p - box.X_BS.p);
    for (int i = 0; i < 3; ++i) UGOKI_CHECK(local[i] < box.half_extents[i] + 1e-6 && local[i] > -box.half_extents[i] - 1e-6);
  }
}

}  // namespace ugoki
