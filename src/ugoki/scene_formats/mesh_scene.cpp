// Reads mesh files in a guarded child process, which serialises its result as an answer; the calling process parses and checks this answer.

#include "ugoki/scene_formats/mesh_scene.h"

#include <algorithm>
#include <cstdint>
#include <string>

#include "ugoki/scene_formats/guarded_answer.h"
#include "ugoki/scene_formats/guarded_call.h"
#include "ugoki/scene_formats/mesh_parser.h"

namespace ugoki::scene_formats {
namespace {

/// Runs in the child process.
std::string answer_of(std::span<const std::byte> bytes, std::string_view file_name, const MeshOptions& options) {
  formats::ReadNotes notes;
  const Result<ParsedMesh> parsed = parse_mesh_scene(bytes, file_name, options, notes);
  std::string out;
  put_number(out, std::uint64_t{parsed.has_value()});
  if (!parsed) {
    put_error(out, parsed.error());
    return out;
  }
  const MeshScene* scene = &parsed->scene;
  put_number(out, notes.metres_per_unit);
  put_number(out, std::uint64_t{notes.unit_guessed} + 2 * std::uint64_t{notes.z_up} + 4 * std::uint64_t{scene->skinned} +
                      8 * std::uint64_t{scene->animated});
  put_number(out, std::uint64_t{notes.remarks.size()});
  for (const std::string& remark : notes.remarks) put(out, remark);
  put_list(out, scene->vertices);
  put_list(out, scene->normals);
  put_list(out, scene->uvs);
  put_number(out, std::uint64_t{scene->parts.size()});
  for (const MeshPart& part : scene->parts) {
    put(out, part.color);
    put_list(out, part.triangles);
    put_number(out, part.texture);
    put(out, part.tint);
    put_number(out, part.cutoff);
    put_number(out, std::uint64_t{part.both_sides});
  }
  put_number(out, std::uint64_t{parsed->textures.size()});
  for (const SceneTexture& texture : parsed->textures) {
    put(out, texture.path);
    put_list(out, texture.data);
  }
  return out;
}

/// Parses an answer of answer_of(). Returns false if it is damaged, which can happen if the child's memory was corrupted.
bool parse_answer(std::string_view in, Error& error, ParsedMesh& mesh, formats::ReadNotes& notes) {
  MeshScene& scene = mesh.scene;
  std::uint64_t good = 0, flags = 0, count = 0;
  std::string_view text;
  if (!take_number(in, good)) return false;
  if (good == 0) return take_error(in, error);
  if (!take_number(in, notes.metres_per_unit) || !take_number(in, flags) || !take_number(in, count)) return false;
  notes.unit_guessed = (flags & 1) != 0;
  notes.z_up = (flags & 2) != 0;
  scene.skinned = (flags & 4) != 0;
  scene.animated = (flags & 8) != 0;
  for (std::uint64_t i = 0; i < count; ++i) {
    if (!take(in, text)) return false;
    notes.remarks.emplace_back(text);
  }
  if (!take_list(in, scene.vertices) || !take_list(in, scene.normals) || !take_list(in, scene.uvs) || !take_number(in, count)) return false;
  if (scene.normals.size() != scene.vertices.size() || scene.uvs.size() != 2 * scene.vertices.size()) return false;
  for (std::uint64_t i = 0; i < count; ++i) {
    MeshPart& part = scene.parts.emplace_back();
    if (!take(in, text) || !take_list(in, part.triangles) || !take_number(in, part.texture)) return false;
    part.color = std::string(text);
    if (!take(in, text) || !take_number(in, part.cutoff) || !take_number(in, flags)) return false;
    part.tint = std::string(text);
    part.both_sides = flags != 0;
    for (const Triangle& t : part.triangles)
      for (const std::int32_t v : t)
        if (v < 0 || static_cast<std::size_t>(v) >= scene.vertices.size()) return false;
  }
  if (!take_number(in, count)) return false;
  for (std::uint64_t i = 0; i < count; ++i) {
    SceneTexture& texture = mesh.textures.emplace_back();
    if (!take(in, text) || !take_list(in, texture.data)) return false;
    texture.path = std::string(text);
  }
  return std::ranges::all_of(scene.parts, [&](const MeshPart& p) { return p.texture < static_cast<int>(mesh.textures.size()); });
}

/// Loads the textures; parts whose texture is missing show their colour.
void add_textures(ParsedMesh& mesh, const MeshOptions& options, formats::ReadNotes& notes) {
  const std::vector<int> place = load_textures(std::move(mesh.textures), options.companions, "the mesh", mesh.scene.textures, notes);
  for (MeshPart& part : mesh.scene.parts) {
    if (part.texture >= 0) part.texture = place[static_cast<std::size_t>(part.texture)];
    if (part.texture < 0 && !part.color.empty()) part.tint = part.color;
  }
}

}  // namespace

Result<MeshScene> read_mesh_scene(std::span<const std::byte> bytes, std::string_view file_name, const MeshOptions& options,
                                  formats::ReadNotes* notes) {
  const Result<std::string> answer =
      call_guarded([&] { return answer_of(bytes, file_name, options); }, file_name, {.seconds = options.seconds});
  if (!answer) return fail(answer.error());
  Error error;
  ParsedMesh mesh;
  formats::ReadNotes read_notes;
  if (!parse_answer(*answer, error, mesh, read_notes))
    return fail(ErrorCode::syntax, std::string(file_name),
                "The library that reads this format returned an incomplete answer: the file is damaged.", "Export it again.");
  if (!error.empty()) return fail(std::move(error));
  add_textures(mesh, options, read_notes);
  if (notes) *notes = std::move(read_notes);
  return std::move(mesh.scene);
}

}  // namespace ugoki::scene_formats
