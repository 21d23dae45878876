#include "mesh_info.h"

#include <chrono>
#include <cmath>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "ugoki/collision/prepared_geometry.h"
#include "ugoki/geometry/make_hull.h"

namespace ugoki::cli {
namespace {

std::string hash_text(std::uint64_t hash) {
  std::string out(16, '0');
  for (std::size_t i = 0; i < 16; ++i) out[i] = "0123456789abcdef"[(hash >> (60 - 4 * i)) & 15];
  return out;
}

/// Wall-clock time that the call of the function `call` takes, ms.
template <class Call>
double time_of(const Call& call) {
  const auto begin = std::chrono::steady_clock::now();
  call();
  const double ms = std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin).count();
  return std::round(1000 * ms) / 1000;
}

void add_found(const GeometryFindings& found, Json& problems) {
  const auto add = [&](std::size_t count, const char* what) {
    if (count > 0) problems.push_back(std::to_string(count) + " " + what);
  };
  add(found.doubled_vertices, "vertices at the position of another vertex were welded");
  add(found.unused_vertices, "vertices without a triangle were left out");
  add(found.flat_triangles, "triangles without area were left out");
  add(found.doubled_triangles, "duplicate triangles were left out");
  if (found.inside_out) problems.push_back("the triangles faced inwards and were reversed");
}

/// A geometry and the links of the mechanism that use it.
struct Use {
  GeometryPtr geometry;
  std::string links;
  int shapes = 0;
  bool collides = false;
};

void add_spheres(const collision::SphereTree& spheres, Json& row) {
  const collision::SphereTreeReport report = collision::report_of(spheres);
  row["spheres"] = report.spheres;
  row["spheres_bytes"] = report.bytes;
  Json levels = Json::array();
  for (std::size_t depth = 0; depth < report.spheres_at.size(); ++depth)
    levels.push_back({{"depth", depth},
                      {"spheres", report.spheres_at[depth]},
                      {"mean_overlap", std::round(1000 * report.mean_overlap[depth]) / 1000},
                      {"mean_radius_mm", std::round(1e6 * report.mean_radius[depth]) / 1000}});
  row["levels"] = std::move(levels);
}

Json row_of(const Use& use, const robot_formats::MeshRead* read) {
  const Geometry& g = *use.geometry;
  Json problems = Json::array();
  Json row = {{"geometry", hash_text(g.hash)},
              {"file", read ? read->file : ""},
              {"links", use.links},
              {"shapes", use.shapes},
              {"kind", g.convex ? "convex hull" : "surface"}};
  if (read) row["triangles_in_file"] = read->triangles;
  row["vertices"] = g.vertices.size();
  row["triangles"] = g.triangles.size();
  row["volume_m3"] = g.solid.mass;
  if (read) add_found(read->found, problems);
  const GeometryFindings now = inspect(g);
  if (now.open_edges > 0) problems.push_back("the surface has holes: " + std::to_string(now.open_edges) + " open sides of triangles");
  if (now.inside_out) problems.push_back("the triangles face inwards");

  Result<collision::Hull> hull = fail(ErrorCode::structure, "", "");
  row["hull_ms"] = time_of([&] { hull = geometry::make_hull(g.vertices); });
  row["hull_vertices"] = hull ? hull->vertices.size() : 0;
  row["hull_faces"] = hull ? hull->normals.size() : 0;
  if (!hull) problems.push_back("no hull: " + hull.error().problems[0].message);
  if (hull && hull->dimension < 3) problems.push_back("all points are in a plane or on a line");
  if (!g.convex) {
    Result<collision::SphereTree> spheres = fail(ErrorCode::structure, "", "");
    row["spheres_ms"] = time_of([&] { spheres = collision::make_sphere_tree(g.vertices, g.triangles); });
    if (spheres) add_spheres(*spheres, row);
  }
  row["prepared"] = g.prepared != nullptr;
  row["problems"] = std::move(problems);
  return row;
}

}  // namespace

Json meshes_json(const Mechanism& m, const robot_formats::RobotModel* robot) {
  std::map<std::uint64_t, Use> uses;
  std::vector<std::uint64_t> order;
  for (const Link& link : m.links())
    for (const Shape& s : link.shapes) {
      if (s.type != ShapeType::mesh) continue;
      const auto [it, is_new] = uses.try_emplace(s.geometry->hash);
      Use& use = it->second;
      if (is_new) order.push_back(s.geometry->hash);
      if (is_new || (s.geometry->prepared && !use.geometry->prepared)) use.geometry = s.geometry;
      if (use.shapes < 3) use.links += (use.links.empty() ? "" : ", ") + link.name;
      if (use.shapes == 3) use.links += " ...";
      ++use.shapes;
    }
  if (order.empty()) return nullptr;
  Json out = Json::object();
  for (const std::uint64_t hash : order) {
    const robot_formats::MeshRead* read = nullptr;
    if (robot)
      for (const robot_formats::MeshRead& r : robot->meshes)
        if (r.geometry == hash && !read) read = &r;
    out[hash_text(hash)] = row_of(uses.at(hash), read);
  }
  return out;
}

Json height_fields_json(const Mechanism& m) {
  Json out = Json::array();
  for (const Link& link : m.links())
    for (const Shape& s : link.shapes)
      if (s.type == ShapeType::height_field)
        out.push_back({{"link", link.name},
                       {"columns", s.field->columns},
                       {"rows", s.field->rows},
                       {"width_m", 2 * s.field->half_x},
                       {"depth_m", 2 * s.field->half_y},
                       {"lowest_m", s.field->lowest},
                       {"highest_m", s.field->highest}});
  return out.empty() ? Json(nullptr) : out;
}

}  // namespace ugoki::cli
