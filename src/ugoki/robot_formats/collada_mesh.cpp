#include "ugoki/robot_formats/collada_mesh.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <utility>

#include "ugoki/robot_formats/xml_fields.h"

namespace ugoki::robot_formats {
namespace {

constexpr std::size_t max_points = 50'000'000;

/// Vertices and triangles of one <geometry>, in the frame of this geometry.
struct Part {
  std::vector<Vec3> points;
  std::vector<std::array<int, 3>> triangles;
};

/// Affine map x -> A x + b. A may contain scaling.
struct Placement {
  Mat3 A = Mat3::identity();
  Vec3 b;
};
Placement operator*(const Placement& o, const Placement& i) { return {o.A * i.A, o.A * i.b + o.b}; }

std::string_view without_hash(std::string_view url) { return url.starts_with('#') ? url.substr(1) : url; }

class ColladaReader {
 public:
  explicit ColladaReader(XmlFields& xml) : xml_(xml) {}

  MeshFile read() {
    const pugi::xml_node root = xml_.root();
    unit_ = xml_.number(xml_.attribute(root.child("asset").child("unit"), "meter"), 1.0, {1e-6, 1e6});
    for (const pugi::xml_node g : root.child("library_geometries").children("geometry")) read_geometry(g);
    bool placed = false;
    for (const pugi::xml_node scene : root.child("library_visual_scenes").children("visual_scene"))
      for (const pugi::xml_node node : scene.children("node")) placed = place(node) || placed;
    if (!placed)
      for (const auto& [id, part] : geometries_) add(part, {});
    return std::move(out_);
  }

 private:
  void read_geometry(pugi::xml_node geometry) {
    const pugi::xml_node mesh = geometry.child("mesh");
    const std::string_view id =
        without_hash(mesh.child("vertices").find_child_by_attribute("input", "semantic", "POSITION").attribute("source").value());
    for (const pugi::xml_node source : mesh.children("source")) {
      if (id != source.attribute("id").value()) continue;
      const std::vector<double> v = xml_.list(xml_.element(source, "float_array"), 0, 3 * max_points);
      Part& part = geometries_[geometry.attribute("id").value()];
      for (std::size_t i = 0; i + 2 < v.size(); i += 3) part.points.push_back({v[i], v[i + 1], v[i + 2]});
      for (const pugi::xml_node faces : mesh.children()) read_faces(faces, part);
    }
  }

  /// Adds the faces of one <triangles>, <polylist> or <polygons> element. Polygons are split into triangle fans.
  void read_faces(pugi::xml_node faces, Part& part) {
    const std::string_view kind = faces.name();
    if (kind != "triangles" && kind != "polylist" && kind != "polygons") return;
    std::size_t stride = 1, offset = 0;
    for (const pugi::xml_node input : faces.children("input")) {
      const auto at = static_cast<std::size_t>(xml_.integer(xml_.attribute(input, "offset"), 0, 0, 100));
      stride = std::max(stride, at + 1);
      if (std::string_view(input.attribute("semantic").value()) == "VERTEX") offset = at;
    }
    std::vector<double> counts;
    if (kind == "polylist") counts = xml_.list(xml_.element(faces, "vcount"), 0, max_points, not_negative);
    std::size_t polygon = 0;
    for (const pugi::xml_node list : faces.children("p")) {
      const std::vector<double> p = xml_.list(xml_.content(list), 0, 10 * max_points, not_negative);
      const std::size_t corners = p.size() / stride;
      for (std::size_t first = 0; first < corners;) {
        std::size_t n = kind == "triangles" ? 3 : corners;
        if (kind == "polylist") n = polygon < counts.size() ? static_cast<std::size_t>(counts[polygon++]) : 0;
        if (n == 0 && (kind != "polylist" || polygon >= counts.size())) break;
        n = std::min(n, corners - first);
        const auto corner = [&](std::size_t i) { return p[(first + i) * stride + offset]; };
        for (std::size_t i = 2; i < n; ++i) {
          if (!(std::max({corner(0), corner(i - 1), corner(i)}) < static_cast<double>(part.points.size()))) {
            xml_.problem(faces, ErrorCode::range, "A face refers to a vertex that does not exist.", "Export the mesh again.");
            return;
          }
          part.triangles.push_back({static_cast<int>(corner(0)), static_cast<int>(corner(i - 1)), static_cast<int>(corner(i))});
        }
        first += n;
      }
    }
  }

  Placement local_placement(pugi::xml_node node) {
    Placement all;
    for (const pugi::xml_node child : node.children()) {
      const std::string_view kind = child.name();
      Placement step;
      if (std::array<double, 16> m; kind == "matrix" && xml_.numbers(xml_.content(child), m)) {
        step = {{m[0], m[1], m[2], m[4], m[5], m[6], m[8], m[9], m[10]}, {m[3], m[7], m[11]}};
      } else if (kind == "translate") {
        step.b = xml_.vec3(xml_.content(child), {});
      } else if (kind == "scale") {
        const Vec3 s = xml_.vec3(xml_.content(child), {1, 1, 1});
        step.A = Mat3::diagonal(s.x, s.y, s.z);
      } else if (std::array<double, 4> r; kind == "rotate" && xml_.numbers(xml_.content(child), r, {-1e6, 1e6})) {
        step.A = rotation_about(normalized(Vec3{r[0], r[1], r[2]}), r[3] * (pi / 180));
      }
      all = all * step;
    }
    return all;
  }

  /// Adds the geometries of the node and its descendants; without recursion, so that deep files cannot exhaust the stack. True if it added
  /// any.
  bool place(pugi::xml_node top) {
    bool placed = false;
    std::vector<std::pair<pugi::xml_node, Placement>> todo = {{top, {}}};
    while (!todo.empty()) {
      const auto [node, above] = todo.back();
      todo.pop_back();
      const Placement here = above * local_placement(node);
      for (const pugi::xml_node instance : node.children("instance_geometry"))
        if (const auto it = geometries_.find(without_hash(instance.attribute("url").value())); it != geometries_.end()) {
          add(it->second, here);
          placed = true;
        }
      for (const pugi::xml_node child : node.children("node")) todo.emplace_back(child, here);
    }
    return placed;
  }

  void add(const Part& part, const Placement& where) {
    if (out_.points.size() + part.points.size() > max_points || out_.triangles.size() + part.triangles.size() > max_points) return;
    const int first = static_cast<int>(out_.points.size());
    for (const Vec3& p : part.points) out_.points.push_back((where.A * p + where.b) * unit_);
    const bool mirrored = where.A.determinant() < 0;
    for (const auto& [a, b, c] : part.triangles)
      out_.triangles.push_back({first + a, first + (mirrored ? c : b), first + (mirrored ? b : c)});
  }

  XmlFields& xml_;
  double unit_ = 1;
  std::map<std::string, Part, std::less<>> geometries_;
  MeshFile out_;
};

}  // namespace

Result<MeshFile> collada_mesh(std::string_view text, const std::string& file_name) {
  XmlFields xml(file_name, "COLLADA");
  if (!xml.parse(text)) return fail(xml.take_problems());
  MeshFile mesh = ColladaReader(xml).read();
  if (xml.failed()) return fail(xml.take_problems());
  return mesh;
}

}  // namespace ugoki::robot_formats
