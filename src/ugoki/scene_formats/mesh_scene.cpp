// Reads mesh files in a guarded child process, which serialises its result as an answer; the calling process parses and checks this answer.

#include "ugoki/scene_formats/mesh_scene.h"

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
  const Result<MeshScene> scene = parse_mesh_scene(bytes, file_name, options, notes);
  std::string out;
  put_number(out, std::uint64_t{scene.has_value()});
  if (!scene) {
    put_error(out, scene.error());
    return out;
  }
  put_number(out, notes.metres_per_unit);
  put_number(out, std::uint64_t{notes.unit_guessed} + 2 * std::uint64_t{notes.z_up} + 4 * std::uint64_t{scene->skinned} +
                      8 * std::uint64_t{scene->animated});
  put_number(out, std::uint64_t{notes.remarks.size()});
  for (const std::string& remark : notes.remarks) put(out, remark);
  put_list(out, scene->vertices);
  put_number(out, std::uint64_t{scene->parts.size()});
  for (const MeshPart& part : scene->parts) {
    put(out, part.color);
    put_list(out, part.triangles);
  }
  return out;
}

/// Parses an answer of answer_of(). Returns false if it is damaged, which can happen if the child's memory was corrupted.
bool parse_answer(std::string_view in, Error& error, MeshScene& scene, formats::ReadNotes& notes) {
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
  if (!take_list(in, scene.vertices) || !take_number(in, count)) return false;
  for (std::uint64_t i = 0; i < count; ++i) {
    MeshPart& part = scene.parts.emplace_back();
    if (!take(in, text) || !take_list(in, part.triangles)) return false;
    part.color = std::string(text);
    for (const Triangle& t : part.triangles)
      for (const std::int32_t v : t)
        if (v < 0 || static_cast<std::size_t>(v) >= scene.vertices.size()) return false;
  }
  return true;
}

}  // namespace

Result<MeshScene> read_mesh_scene(std::span<const std::byte> bytes, std::string_view file_name, const MeshOptions& options,
                                  formats::ReadNotes* notes) {
  const Result<std::string> answer =
      call_guarded([&] { return answer_of(bytes, file_name, options); }, file_name, {.seconds = options.seconds});
  if (!answer) return fail(answer.error());
  Error error;
  MeshScene scene;
  formats::ReadNotes read_notes;
  if (!parse_answer(*answer, error, scene, read_notes))
    return fail(ErrorCode::syntax, std::string(file_name),
                "The library that reads this format returned an incomplete answer: the file is damaged.", "Export it again.");
  if (!error.empty()) return fail(std::move(error));
  if (notes) *notes = std::move(read_notes);
  return scene;
}

}  // namespace ugoki::scene_formats
