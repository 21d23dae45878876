#include "ugoki/content/mechanism_display.h"

#include <algorithm>
#include <cstdint>
#include <limits>

#include "ugoki/base/base64.h"
#include "ugoki/content/film_json.h"
#include "ugoki/content/scenario_json.h"
#include "ugoki/json/json.h"
#include "ugoki/mechanism/state.h"

namespace ugoki::content {
namespace {

using json::Json;

template <class T>
std::string packed(const std::vector<T>& values) {
  return to_base64({reinterpret_cast<const std::uint8_t*>(values.data()), values.size() * sizeof(T)});
}

/// Returns a surface as JSON: vertices as 32-bit floats x y z and triangles as 32-bit indices, both in Base64.
Json surface_json(const Geometry& g) {
  std::vector<float> points;
  for (const Vec3& p : g.vertices)
    for (int i = 0; i < 3; ++i) points.push_back(static_cast<float>(p[i]));
  return {{"vertices", packed(points)}, {"triangles", packed(g.triangles)}};
}

Json surface_json(const HeightField& f) {
  const std::vector<float> heights(f.heights.begin(), f.heights.end());
  return {{"columns", f.columns}, {"rows", f.rows}, {"half_x", f.half_x},
          {"half_y", f.half_y},   {"base", f.base}, {"heights", packed(heights)}};
}

/// Returns the skin as JSON: its lists in Base64 (positions, normals, uvs: 32-bit floats; bones, weights, colors: 16 bits; indices: 32
/// bits).
Json skin_json(const Mechanism& m) {
  const Skin& skin = *m.skin();
  Json parts = Json::array(), textures = Json::array(), links = Json::array(), matrices = Json::array();
  for (const SkinPart& p : skin.parts)
    parts.push_back({{"color", p.color},
                     {"texture", p.texture},
                     {"first", p.first},
                     {"count", p.count},
                     {"cutoff", p.cutoff},
                     {"both_sides", p.both_sides}});
  for (const SkinTexture& t : skin.textures) textures.push_back({{"type", t.type}, {"data", packed(t.data)}});
  for (const SkinBone& b : m.skin_bones()) {
    links.push_back(m.find_link(b.link));
    for (int row = 0; row < 3; ++row)
      for (const double x : {b.A.row(row).x, b.A.row(row).y, b.A.row(row).z, b.p[row]}) matrices.push_back(x);
  }
  Json out = {{"positions", packed(skin.positions)}, {"normals", packed(skin.normals)}, {"uvs", packed(skin.uvs)},
              {"bones", packed(skin.bones)},         {"weights", packed(skin.weights)}, {"indices", packed(skin.indices)},
              {"parts", std::move(parts)},           {"textures", std::move(textures)}, {"links", std::move(links)},
              {"matrices", std::move(matrices)}};
  if (!skin.colors.empty()) out["colors"] = packed(skin.colors);
  return out;
}

std::vector<Pose> poses_at(const Mechanism& mechanism, std::span<const double> q) {
  std::vector<Pose> X(static_cast<std::size_t>(mechanism.link_count()));
  calc_poses(mechanism, q, X);
  return X;
}
std::vector<Pose> neutral_poses(const Mechanism& mechanism) { return poses_at(mechanism, mechanism.neutral()); }

}  // namespace

std::vector<double> pose_json(const Pose& X) {
  const Quat q = to_quat(X.R);
  return {X.p.x, X.p.y, X.p.z, q.w, q.x, q.y, q.z};
}

double shown_height(const Mechanism& mechanism) {
  const std::vector<Pose> X = neutral_poses(mechanism);
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (int i = 0; i < mechanism.link_count(); ++i) {
    for (const Shape& s : mechanism.link(i).shapes) {
      if (!s.visible) continue;
      const Pose X_WS = X[static_cast<std::size_t>(i)] * s.X_BS;
      low = std::min(low, X_WS.p.z - reach(s, -X_WS.R.row(2)));
      high = std::max(high, X_WS.p.z + reach(s, X_WS.R.row(2)));
    }
  }
  return high > low ? high - low : 0;
}

namespace {

Json mechanism_display(std::string_view id, const Mechanism& mechanism, std::span<const double> q, bool skin = true) {
  const std::vector<Pose> X = q.empty() ? neutral_poses(mechanism) : poses_at(mechanism, q);
  Json links = Json::array(), surfaces = Json::object();
  for (int i = 0; i < mechanism.link_count(); ++i) {
    const Link& link = mechanism.link(i);
    Json shapes = Json::array();
    for (const Shape& s : link.shapes) {
      if (!s.visible) continue;
      shapes.push_back({{"type", ugoki::name_of(s.type)},
                        {"radius", s.radius},
                        {"half_length", s.half_length},
                        {"half_extents", {s.half_extents.x, s.half_extents.y, s.half_extents.z}},
                        {"pose", pose_json(s.X_BS)}});
      if (s.geometry) {
        const std::string key = std::to_string(s.geometry->hash);
        shapes.back()["surface"] = key;
        if (!surfaces.contains(key)) surfaces[key] = surface_json(*s.geometry);
      }
      if (s.field) {
        const std::string key = std::to_string(s.field->hash);
        shapes.back()["surface"] = key;
        if (!surfaces.contains(key)) surfaces[key] = surface_json(*s.field);
      }
    }
    links.push_back({{"name", link.name},
                     {"label", link.label},
                     {"parent", link.parent},
                     {"joint", ugoki::name_of(link.joint.type)},
                     {"dofs", link.joint.nv()},
                     {"shapes", std::move(shapes)},
                     {"neutral", pose_json(X[static_cast<std::size_t>(i)])}});
  }
  Json out = {{"id", id},
              {"name", mechanism.name()},
              {"dofs", mechanism.nv()},
              {"mass", mechanism.mass()},
              {"height", shown_height(mechanism)},
              {"surfaces", std::move(surfaces)},
              {"links", std::move(links)}};
  if (skin && mechanism.skin()) out["skin"] = skin_json(mechanism);
  return out;
}

}  // namespace

std::string mechanism_json(std::string_view id, const Mechanism& mechanism, std::span<const double> q) {
  return json::to_text(mechanism_display(id, mechanism, q));
}

std::string scene_json(const Executable& content, bool skins) {
  Json characters = Json::array(), mechanisms = Json::array();
  for (const ExecutableCharacter& c : content.characters) {
    characters.push_back({{"id", c.id},
                          {"name", c.name},
                          {"color", c.color},
                          {"mechanism", c.mechanism},
                          {"tracks", c.control.mode != ControlMode::passive && !c.track.empty()},
                          {"assist_limit", c.control.assist_limit}});
    write_material(c.material, characters.back());
  }
  for (std::size_t i = 0; i < content.mechanisms.size(); ++i)
    mechanisms.push_back(mechanism_display(content.mechanism_ids[i], *content.mechanisms[i], {}, skins));
  Json scene = Json{{"name", content.name},
                    {"duration", content.duration},
                    {"frame_rate", content.frame_rate},
                    {"step", content.step},
                    {"ground", {{"height", content.ground.height}}},
                    {"camera",
                     {{"follow", content.camera.follow},
                      {"distance", content.camera.distance},
                      {"azimuth", content.camera.azimuth},
                      {"elevation", content.camera.elevation}}},
                    {"look", to_json(content.look)},
                    {"characters", std::move(characters)},
                    {"mechanisms", std::move(mechanisms)}};
  write_film(content.cameras, content.shots, scene);
  if (!content.variables.empty()) scene["variables"] = Json::array();
  for (const ScenarioVariable& v : content.variables) scene["variables"].push_back(to_json(v));
  return json::to_text(scene);
}

}  // namespace ugoki::content
