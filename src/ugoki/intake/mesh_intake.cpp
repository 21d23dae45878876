#include "ugoki/intake/mesh_intake.h"

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
  const Json summary = {{"dofs", body.mechanism->nv()},
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
  return summary.dump(-1, ' ', false, Json::error_handler_t::replace);
}

void describe_mesh(const MeshBody& body, const formats::ReadNotes& notes, Intake& out) {
  ConversionReport& report = out.conversion;
  report.read.push_back("A mesh of " + std::to_string(body.triangles) + (body.triangles == 1 ? " triangle, " : " triangles, ") +
                        to_fixed(body.size.x, 2) + " x " + to_fixed(body.size.y, 2) + " x " + to_fixed(body.size.z, 2) + " m.");
  const std::string volume = body.volume < 0.1 ? to_fixed(1000 * body.volume, 3) + " litres." : to_fixed(body.volume, 3) + " m3.";
  if (body.closed) report.read.push_back("The surface is closed; its volume is " + volume);
  report.add_remarks(notes.remarks);
  report.changed.insert(report.changed.end(), body.changed.begin(), body.changed.end());
  report.check.insert(report.check.end(), body.checks.begin(), body.checks.end());
  out.report = notes.remarks;
  out.report.insert(out.report.end(), body.checks.begin(), body.checks.end());
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

}  // namespace ugoki::intake
