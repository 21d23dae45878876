#include "ugoki/robot_formats/collada_points.h"

#include <array>
#include <map>

#include "ugoki/robot_formats/xml_fields.h"

namespace ugoki::robot_formats {
namespace {

constexpr std::size_t most_points = 50'000'000;

/// x -> A x + b, any linear A: scales are allowed.
struct Placement {
  Mat3 A = Mat3::identity();
  Vec3 b;
};
Placement operator*(const Placement& o, const Placement& i) { return {o.A * i.A, o.A * i.b + o.b}; }

std::string_view without_hash(std::string_view url) { return url.starts_with('#') ? url.substr(1) : url; }

class ColladaReader {
 public:
  explicit ColladaReader(XmlFields& xml) : xml_(xml) {}

  std::vector<Vec3> read() {
    const pugi::xml_node root = xml_.root();
    unit_ = xml_.number(xml_.attribute(root.child("asset").child("unit"), "meter"), 1.0, {1e-6, 1e6});
    for (const pugi::xml_node g : root.child("library_geometries").children("geometry")) read_geometry(g);
    bool placed = false;
    for (const pugi::xml_node scene : root.child("library_visual_scenes").children("visual_scene"))
      for (const pugi::xml_node node : scene.children("node")) placed = place(node) || placed;
    if (!placed)
      for (const auto& [id, points] : geometries_) add(points, {});
    return std::move(out_);
  }

 private:
  void read_geometry(pugi::xml_node geometry) {
    const pugi::xml_node mesh = geometry.child("mesh");
    const std::string_view id =
        without_hash(mesh.child("vertices").find_child_by_attribute("input", "semantic", "POSITION").attribute("source").value());
    for (const pugi::xml_node source : mesh.children("source")) {
      if (id != source.attribute("id").value()) continue;
      const std::vector<double> v = xml_.list(xml_.element(source, "float_array"), 0, 3 * most_points);
      std::vector<Vec3>& points = geometries_[geometry.attribute("id").value()];
      for (std::size_t i = 0; i + 2 < v.size(); i += 3) points.push_back({v[i], v[i + 1], v[i + 2]});
    }
  }

  Placement own(pugi::xml_node node) {
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

  /// The node and all below it, without recursion.
  bool place(pugi::xml_node top) {
    bool placed = false;
    std::vector<std::pair<pugi::xml_node, Placement>> todo = {{top, {}}};
    while (!todo.empty()) {
      const auto [node, above] = todo.back();
      todo.pop_back();
      const Placement here = above * own(node);
      for (const pugi::xml_node instance : node.children("instance_geometry"))
        if (const auto it = geometries_.find(without_hash(instance.attribute("url").value())); it != geometries_.end()) {
          add(it->second, here);
          placed = true;
        }
      for (const pugi::xml_node child : node.children("node")) todo.emplace_back(child, here);
    }
    return placed;
  }

  void add(const std::vector<Vec3>& points, const Placement& where) {
    if (out_.size() + points.size() > most_points) return;
    for (const Vec3& p : points) out_.push_back((where.A * p + where.b) * unit_);
  }

  XmlFields& xml_;
  double unit_ = 1;
  std::map<std::string, std::vector<Vec3>, std::less<>> geometries_;
  std::vector<Vec3> out_;
};

}  // namespace

Result<std::vector<Vec3>> collada_points(std::string_view text, const std::string& file_name) {
  XmlFields xml(file_name, "COLLADA");
  if (!xml.parse(text)) return fail(xml.take_problems());
  std::vector<Vec3> points = ColladaReader(xml).read();
  if (xml.failed()) return fail(xml.take_problems());
  return points;
}

}  // namespace ugoki::robot_formats
