#include "ugoki/robot_formats/mjcf_source.h"

#include <algorithm>
#include <cmath>

#include "ugoki/robot_formats/mesh_file.h"

namespace ugoki::robot_formats {
namespace {

constexpr std::size_t max_hull_points = 20'000;  // maximum number of points for a hull, because computing it costs O(points * triangles)

std::string folder_of(const std::string& path) {
  const std::size_t slash = path.find_last_of('/');
  return slash == std::string::npos ? std::string() : path.substr(0, slash + 1);
}

}  // namespace

Mat3 z_turned_to(const Vec3& direction) {
  const Vec3 axis{-direction.y, direction.x, 0};
  const double s = norm(axis);
  if (s < 1e-10) return direction.z > 0 ? Mat3::identity() : Mat3::diagonal(1, -1, -1);
  return rotation_about(axis / s, atan2(s, direction.z));
}

bool MjcfSource::load(std::string_view text, const std::string& path, MjcfFiles& files, std::vector<std::string> ancestors) {
  files_ = &files;
  folder_ = folder_of(path);
  ancestors_ = std::move(ancestors);
  ancestors_.push_back(path);
  if (!document_.load(text, path, folder_, files)) return false;
  read_compiler();
  defaults_.read(document_);
  read_assets();
  return true;
}

void MjcfSource::read_compiler() {
  MjcfCompiler& c = compiler_;
  for (const MjcfElement& e : document_.sections("compiler")) {
    const MjcfAttributes a(e);
    c.degrees = a.keyword("angle", {"radian", "degree"}, c.degrees ? 1 : 0) == 1;
    if (a.has("eulerseq")) {
      const std::string order = a.text("eulerseq");
      if (order.size() == 3 && order.find_first_not_of("xyzXYZ") == std::string::npos)
        c.eulerseq = order;
      else
        e.problem(ErrorCode::syntax, "'eulerseq' is " + formats::in_quotes(order) + ", not three of the letters x, y, z, X, Y, Z.",
                  "Write for example eulerseq=\"xyz\".");
    }
    if (a.keyword("coordinate", {"local", "global"}, 0) == 1)
      e.problem(ErrorCode::unsupported, "The model uses global coordinates, which MuJoCo no longer supports.",
                "Load and save it with MuJoCo 2.3.3 or older.");
    c.autolimits = a.flag("autolimits", c.autolimits);
    c.strip_path = a.flag("strippath", c.strip_path);
    if (a.has("assetdir")) c.mesh_folder = a.text("assetdir");
    if (a.has("meshdir")) c.mesh_folder = a.text("meshdir");
    c.inertia_from_geoms = static_cast<MjcfCompiler::FromGeoms>(
        a.keyword("inertiafromgeom", {"auto", "true", "false"}, static_cast<int>(c.inertia_from_geoms)));
    double groups[2];
    if (a.numbers("inertiagrouprange", groups, {0, 5})) c.inertia_groups = {static_cast<int>(groups[0]), static_cast<int>(groups[1])};
    c.min_mass = a.number("boundmass", c.min_mass, not_negative);
    c.min_inertia = a.number("boundinertia", c.min_inertia, not_negative);
    c.balance_inertia = a.flag("balanceinertia", c.balance_inertia);
    c.total_mass = std::max(0.0, a.number("settotalmass", c.total_mass));
  }
}

void MjcfSource::read_assets() {
  for (const MjcfElement& section : document_.sections("asset"))
    for (const MjcfElement& e : document_.children(section)) {
      const std::string file = e.text("file");
      const std::string name = e.has("name") ? e.text("name") : formats::stem_of(file);
      if (e.kind() == "mesh") {
        MjcfMeshAsset mesh;
        mesh.element = e;
        if (!meshes_.emplace(name, std::move(mesh)).second)
          e.problem(ErrorCode::duplicate, "Two meshes are named " + formats::in_quotes(name) + ".", "Rename one of them.");
      } else if (e.kind() == "hfield") {
        if (!height_fields_.emplace(name, MjcfHeightField{e, false, {}, {}}).second)
          e.problem(ErrorCode::duplicate, "Two height fields are named " + formats::in_quotes(name) + ".", "Rename one of them.");
      } else if (e.kind() == "model") {
        const std::string path = folder_ + file;
        if (std::ranges::find(ancestors_, path) != ancestors_.end()) {
          e.problem(ErrorCode::structure, "The model " + formats::path_in_quotes(path) + " contains itself.",
                    "Remove one of its <model> assets.");
          continue;
        }
        const Result<std::string> text = files_->read(path);
        if (!text) {
          e.problem(ErrorCode::io, "The model " + formats::path_in_quotes(path) + " cannot be read: " + text.error().problems[0].message,
                    "Copy it to that path.");
          continue;
        }
        auto source = std::make_unique<MjcfSource>();
        if (!source->load(*text, path, *files_, ancestors_)) continue;
        const std::string own = source->document().root().text("model");
        models_.emplace(e.has("name") ? name : own.empty() ? name : own, std::move(source));
      }
    }
}

MjcfSource* MjcfSource::model(const std::string& name) const {
  const auto it = models_.find(name);
  return it == models_.end() ? nullptr : it->second.get();
}

MjcfMeshAsset* MjcfSource::mesh(const std::string& name) {
  const auto it = meshes_.find(name);
  if (it == meshes_.end()) return nullptr;
  if (!it->second.tried) load_mesh(it->second);
  return &it->second;
}

std::string MjcfSource::mesh_path(const std::string& file) const {
  const std::size_t slash = file.find_last_of("/\\");
  const std::string name = compiler_.strip_path && slash != std::string::npos ? file.substr(slash + 1) : file;
  if (name.starts_with('/')) return name;
  std::string folder = compiler_.mesh_folder;
  if (!folder.empty() && !folder.ends_with('/')) folder += '/';
  return folder.starts_with('/') ? folder + name : folder_ + folder + name;
}

void MjcfSource::load_mesh(MjcfMeshAsset& mesh) const {
  mesh.tried = true;
  const MjcfAttributes a = defaults_.attributes(mesh.element, {});
  mesh.kind = static_cast<MeshInertia>(a.keyword("inertia", {"convex", "exact", "legacy", "shell"}, static_cast<int>(MeshInertia::legacy)));
  if (a.has("file")) {
    const std::string path = mesh_path(a.text("file"));
    const Result<std::string> bytes = files_->read(path);
    if (!bytes) {
      mesh.absent = "the mesh file " + formats::path_in_quotes(path) + " was not found";
      return;
    }
    Result<MeshFile> content = read_mesh(*bytes, path);
    if (!content) {
      const Problem& why = content.error().problems[0];
      mesh.element.problem(why.code, "The file " + formats::path_in_quotes(path) + " is not a mesh: " + why.message, why.remedy);
      mesh.absent = "the mesh file " + formats::path_in_quotes(path) + " is damaged";
      return;
    }
    mesh.points = std::move(content->points);
    mesh.triangles = std::move(content->triangles);
  } else if (a.has("vertex")) {
    const MjcfElement& e = mesh.element;
    const std::vector<double> v = e.file->list(e.attribute("vertex"), 12, 30'000'000);
    for (std::size_t i = 0; i + 2 < v.size(); i += 3) mesh.points.push_back({v[i], v[i + 1], v[i + 2]});
    const std::vector<double> f = e.has("face") ? e.file->list(e.attribute("face"), 3, 30'000'000, not_negative) : std::vector<double>();
    for (std::size_t i = 0; i + 2 < f.size(); i += 3) {
      if (std::max({f[i], f[i + 1], f[i + 2]}) < static_cast<double>(mesh.points.size()))
        mesh.triangles.push_back({static_cast<int>(f[i]), static_cast<int>(f[i + 1]), static_cast<int>(f[i + 2])});
      else
        e.problem(ErrorCode::range, "A face refers to a vertex that does not exist.", "Number the vertices from 0.");
    }
  }
  if (mesh.points.empty()) {
    mesh.absent = "the mesh " + mesh.element.title() + " has no vertices";
    return;
  }
  double q[4] = {1, 0, 0, 0};
  (void)a.numbers("refquat", q);
  const Mat3 R = to_matrix(normalized(Quat{q[0], q[1], q[2], q[3]}));
  const Vec3 p = a.vec3("refpos", {}), scale = a.vec3("scale", {1, 1, 1});
  for (Vec3& point : mesh.points) {
    const Vec3 v = transpose_times(R, point - p);
    point = {v.x * scale.x, v.y * scale.y, v.z * scale.z};
  }
  if (scale.x * scale.y * scale.z < 0)
    for (MeshTriangle& t : mesh.triangles) std::swap(t[1], t[2]);
  if (mesh.triangles.empty() || mesh.kind == MeshInertia::convex) {
    if (mesh.points.size() > max_hull_points) {
      mesh.element.problem(ErrorCode::unsupported, "The convex hull of the mesh is needed, but it has more than 20,000 vertices.",
                           "Use a smaller mesh, or a mesh with faces.");
      return;
    }
    mesh.triangles = convex_hull(mesh.points);
  }
}

Mat3 MjcfSource::from_euler_angles(const Vec3& angles) const {
  Mat3 R = Mat3::identity();
  for (int i = 0; i < 3; ++i) {
    const char letter = compiler_.eulerseq[static_cast<std::size_t>(i)];
    const bool fixed_axis = letter < 'a';
    const int axis = fixed_axis ? letter - 'X' : letter - 'x';
    Vec3 e;
    e[axis] = 1;
    const Mat3 turn = rotation_about(e, compiler_.radians(angles[i]));
    R = fixed_axis ? turn * R : R * turn;
  }
  return R;
}

Mat3 MjcfSource::orientation(const MjcfAttributes& a) const {
  int own = 0;
  for (const char* name : {"quat", "axisangle", "xyaxes", "zaxis", "euler"}) own += a.own().has(name) ? 1 : 0;
  if (own > 1)
    a.own().problem(ErrorCode::structure, "The orientation is given more than once.",
                    "Keep one of quat, axisangle, xyaxes, zaxis and euler.");
  const auto without_direction = [](const MjcfElement& e, const char* name) {
    e.problem(ErrorCode::structure, "'" + std::string(name) + "' does not define a direction.",
              "Give vectors that are not zero and not parallel.");
    return Mat3::identity();
  };
  // As in MuJoCo, axisangle, xyaxes, zaxis and euler override quat, even if they are set only in a default class.
  for (const MjcfElement& e : a.levels()) {
    double v[6];
    if (e.has("axisangle")) {
      if (!e.file->numbers(e.attribute("axisangle"), std::span(v, 4))) return Mat3::identity();
      const Vec3 axis{v[0], v[1], v[2]};
      if (norm(axis) < 1e-14) return without_direction(e, "axisangle");
      return rotation_about(normalized(axis), compiler_.radians(v[3]));
    }
    if (e.has("xyaxes")) {
      if (!e.file->numbers(e.attribute("xyaxes"), std::span(v, 6))) return Mat3::identity();
      const Vec3 x = normalized({v[0], v[1], v[2]}, {}), y0{v[3], v[4], v[5]}, y = normalized(y0 - x * dot(x, y0), {});
      if (norm(x) < 0.5 || norm(y0 - x * dot(x, y0)) < 1e-14) return without_direction(e, "xyaxes");
      return Mat3::columns(x, y, cross(x, y));
    }
    if (e.has("zaxis")) {
      const Vec3 z = e.file->vec3(e.attribute("zaxis"), {0, 0, 1});
      if (norm(z) < 1e-14) return without_direction(e, "zaxis");
      return z_turned_to(normalized(z));
    }
    if (e.has("euler")) return from_euler_angles(e.file->vec3(e.attribute("euler"), {}));
  }
  double q[4] = {1, 0, 0, 0};
  if (!a.numbers("quat", q)) return Mat3::identity();
  if (!(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3] > 1e-28)) return without_direction(a.own(), "quat");
  return to_matrix(normalized(Quat{q[0], q[1], q[2], q[3]}));
}

}  // namespace ugoki::robot_formats
