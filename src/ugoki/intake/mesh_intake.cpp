#include "ugoki/intake/mesh_intake.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <span>
#include <utility>

#include "ugoki/base/number.h"
#include "ugoki/formats/mechanism_json.h"
#include "ugoki/formats/text.h"
#include "ugoki/scene_formats/mesh_scene.h"

namespace ugoki::intake {
namespace {

using Json = nlohmann::ordered_json;

std::string mesh_summary(const MeshBody& body, const std::string& source) {
  Json summary = {{"dofs", body.mechanism->nv()},
                  {"links", body.mechanism->link_count()},
                  {"mass", body.mechanism->mass()},
                  {"source", source},
                  {"mesh",
                   {{"colors", body.colors},
                    {"size", {body.size.x, body.size.y, body.size.z}},
                    {"volume", body.volume},
                    {"closed", body.closed},
                    {"triangles", body.triangles},
                    {"parts", body.parts}}}};
  if (body.mechanism->skin()) summary["skin"] = {{"bytes", bytes_of(*body.mechanism->skin())}};
  return summary.dump(-1, ' ', false, Json::error_handler_t::replace);
}

std::string describe_textures(const Skin& skin) {
  std::size_t bytes = 0;
  for (const SkinTexture& t : skin.textures) bytes += t.data.size();
  const double kilobytes = static_cast<double>(bytes) / 1024;
  return "The surface has " + std::to_string(skin.textures.size()) + (skin.textures.size() == 1 ? " texture of " : " textures of ") +
         (kilobytes < 1000 ? to_fixed(kilobytes, 1) + " KB." : to_fixed(kilobytes / 1024, 1) + " MB.");
}

void describe_mesh(const MeshBody& body, const formats::ReadNotes& notes, Intake& out) {
  ConversionReport& report = out.conversion;
  report.read.push_back("A mesh of " + std::to_string(body.triangles) + (body.triangles == 1 ? " triangle, " : " triangles, ") +
                        to_fixed(body.size.x, 2) + " x " + to_fixed(body.size.y, 2) + " x " + to_fixed(body.size.z, 2) + " m.");
  const std::string volume = body.volume < 0.1 ? to_fixed(1000 * body.volume, 3) + " litres." : to_fixed(body.volume, 3) + " m3.";
  if (body.closed) report.read.push_back("The surface is closed; its volume is " + volume);
  if (body.mechanism->skin()) report.read.push_back(describe_textures(*body.mechanism->skin()));
  report.add_remarks(notes.remarks);
  report.changed.insert(report.changed.end(), body.changed.begin(), body.changed.end());
  report.check.insert(report.check.end(), body.checks.begin(), body.checks.end());
  out.report = notes.remarks;
  out.report.insert(out.report.end(), body.checks.begin(), body.checks.end());
}

/// True if a glTF, COLLADA or FBX file has no skin.
bool has_no_skin(std::string_view bytes) {
  for (const char* word : {"\"skins\"", "<library_controllers", "Deformer"})
    if (bytes.find(word) != std::string_view::npos) return false;
  return true;
}

/// True if the motions move rigid parts (a lid, a coin), but no limb: each joint keeps its pose relative to its parent, or is at the place
/// of its parent and only turns there. (Files divide the movement of one part among several transforms at one place.)
bool move_no_limb(std::span<const MeasuredMotion> motions) {
  constexpr double place = 1e-5, turn = 1e-5;  // m and rad: rounding errors of files
  const std::vector<SkeletonJoint>& joints = motions[0].skeleton.joints;
  for (std::size_t i = 0; i < joints.size(); ++i) {
    if (joints[i].parent < 0) continue;
    double farthest = 0, shift = 0, angle = 0;
    for (const MeasuredMotion& m : motions)
      for (std::size_t f = 0; f < static_cast<std::size_t>(m.frames); ++f) {
        const std::size_t k = f * joints.size() + i;
        farthest = std::max(farthest, norm(m.translations[k]));
        shift = std::max(shift, norm(m.translations[k] - motions[0].translations[i]));
        angle = std::max(angle, 2 * norm((motions[0].rotations[i].conjugate() * m.rotations[k]).vec()));
      }
    if (farthest > place && (shift > place || angle > turn)) return false;
  }
  return true;
}

}  // namespace

bool is_still(std::string_view bytes) {
  for (const char* word : {"\"skins\"", "\"animations\"", "<library_controllers", "<library_animations", "AnimationCurve", "Deformer"})
    if (bytes.find(word) != std::string_view::npos) return false;
  return true;
}

Result<Intake> take_in_mesh(std::string_view bytes, std::string_view file_name, const IntakeOptions& options) {
  formats::ReadNotes notes;
  Result<scene_formats::MeshScene> scene =
      scene_formats::read_mesh_scene(std::as_bytes(std::span(bytes.data(), bytes.size())), file_name,
                                     {.metres_per_unit = options.unit, .companions = options.files}, &notes);
  if (!scene) return fail(std::move(scene.error()));
  Intake out;
  out.source = std::string(file_name.substr(file_name.find_last_of("/\\") + 1));
  out.metres_per_unit = notes.metres_per_unit;
  out.unit_guessed = notes.unit_guessed;
  const Orientation read_as = usual_orientation(notes.z_up);
  out.axes = options.axes.value_or(read_as);
  if (out.axes != read_as) {
    const Mat3 R = rotation_to_ours(out.axes) * rotation_to_ours(read_as).transposed();
    for (Vec3& p : scene->vertices) p = R * p;
    for (Vec3& n : scene->normals) n = R * n;
  }
  const std::string name = options.name.empty() ? formats::stem_of(out.source) : options.name;
  Result<MeshBody> body = make_mesh_body(*scene, name, file_name);
  if (!body) return fail(std::move(body.error()));
  describe_mesh(*body, notes, out);
  out.mechanism = body->mechanism;
  const std::string text = formats::write_mechanism(*out.mechanism);
  const auto* data = reinterpret_cast<const std::byte*>(text.data());
  out.items = {{store::EntryKind::mechanism, name, mesh_summary(*body, out.source), options.tags, {data, data + text.size()}}};
  out.mesh = std::move(*body);
  return out;
}

std::optional<Intake> take_in_rigid_parts(std::string_view bytes, std::string_view file_name, const IntakeOptions& options,
                                          std::span<const MeasuredMotion> motions) {
  if (options.motion_of_parts || !has_no_skin(bytes) || !move_no_limb(motions)) return std::nullopt;
  Result<Intake> mesh = take_in_mesh(bytes, file_name, options);
  if (!mesh) return std::nullopt;
  const std::string sentence =
      "The file moves rigid parts, but no limbs: it contains no body that could be controlled. It is imported as a mesh, from which "
      "props are made; its motion is left out.";
  mesh->report.push_back(sentence);
  mesh->conversion.check.push_back(sentence);
  return std::move(*mesh);
}

}  // namespace ugoki::intake
