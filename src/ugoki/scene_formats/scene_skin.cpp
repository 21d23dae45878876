#include "ugoki/scene_formats/scene_skin.h"

#include <assimp/config.h>
#include <assimp/postprocess.h>

#include <algorithm>
#include <assimp/Importer.hpp>
#include <string>

#include "ugoki/formats/text.h"
#include "ugoki/scene_formats/guarded_answer.h"
#include "ugoki/scene_formats/guarded_call.h"
#include "ugoki/scene_formats/scene_meshes.h"
#include "ugoki/scene_formats/scene_metadata.h"

namespace ugoki::scene_formats {
namespace {

bool take_text(std::string_view& in, std::string& out) {
  std::string_view text;
  if (!take(in, text)) return false;
  out = text;
  return true;
}

/// Writes or reads all lists of a skin, except its parts and textures, with `each`.
template <class SkinType, class Each>
bool each_list(SkinType& skin, Each each) {
  return each(skin.positions) && each(skin.normals) && each(skin.uvs) && each(skin.colors) && each(skin.bones) && each(skin.weights) &&
         each(skin.indices);
}

std::string text_of(const SceneMeshes& meshes) {
  std::string out;
  put_number(out, std::uint64_t{1});
  const Skin& skin = meshes.file.skin;
  (void)each_list(skin, [&](const auto& list) { return put_list(out, list), true; });
  put_number(out, std::uint64_t{skin.parts.size()});
  for (const SkinPart& p : skin.parts) {
    put(out, p.color);
    put_number(out, p.texture);
    put_number(out, p.first);
    put_number(out, p.count);
    put_number(out, p.cutoff);
    put_number(out, std::uint64_t{p.both_sides});
  }
  put_number(out, std::uint64_t{meshes.file.bones.size()});
  for (const formats::FileBone& b : meshes.file.bones) {
    put(out, b.joint);
    for (int c = 0; c < 3; ++c) put_number(out, b.A.column(c));
    put_number(out, b.p);
  }
  put_number(out, std::uint64_t{meshes.textures.size()});
  for (const SceneTexture& t : meshes.textures) {
    put(out, t.path);
    put_list(out, t.data);
  }
  put_number(out, std::uint64_t{meshes.remarks.size()});
  for (const std::string& r : meshes.remarks) put(out, r);
  return out;
}

/// Reads what text_of() wrote; false if it is damaged.
bool read_text(std::string_view in, SceneMeshes& out) {
  Skin& skin = out.file.skin;
  std::uint64_t count = 0, flag = 0;
  if (!each_list(skin, [&](auto& list) { return take_list(in, list); }) || !take_number(in, count)) return false;
  for (std::uint64_t i = 0; i < count; ++i) {
    SkinPart p;
    if (!take_text(in, p.color) || !take_number(in, p.texture) || !take_number(in, p.first) || !take_number(in, p.count) ||
        !take_number(in, p.cutoff) || !take_number(in, flag))
      return false;
    p.both_sides = flag != 0;
    skin.parts.push_back(std::move(p));
  }
  if (!take_number(in, count)) return false;
  for (std::uint64_t i = 0; i < count; ++i) {
    formats::FileBone b;
    Vec3 columns[3];
    if (!take_text(in, b.joint) || !take_number(in, columns[0]) || !take_number(in, columns[1]) || !take_number(in, columns[2]) ||
        !take_number(in, b.p))
      return false;
    b.A = Mat3::columns(columns[0], columns[1], columns[2]);
    out.file.bones.push_back(std::move(b));
  }
  if (!take_number(in, count)) return false;
  for (std::uint64_t i = 0; i < count; ++i) {
    SceneTexture t;
    if (!take_text(in, t.path) || !take_list(in, t.data)) return false;
    out.textures.push_back(std::move(t));
  }
  if (!take_number(in, count)) return false;
  for (std::uint64_t i = 0; i < count; ++i)
    if (!take_text(in, out.remarks.emplace_back())) return false;
  return true;
}

/// Runs in the child process: reads the joints from the checked core of the file, and the meshes from the file itself.
std::string answer_of(std::span<const std::byte> bytes, std::string_view file_name, const SceneOptions& options) {
  const std::string location(file_name);
  const auto refused = [](const Error& error) {
    std::string out;
    put_number(out, std::uint64_t{0});
    put_error(out, error);
    return out;
  };
  formats::ReadNotes notes;
  NodePlaces places;
  if (const auto motions = read_scene_unguarded(bytes, file_name, options, notes, &places); !motions) return refused(motions.error());
  Assimp::Importer importer;
  set_importer(importer);
  importer.SetPropertyBool(AI_CONFIG_IMPORT_NO_SKELETON_MESHES, true);    // assimp draws skeletons of files without meshes
  importer.SetPropertyBool(AI_CONFIG_IMPORT_FBX_READ_ANIMATIONS, false);  // the motions are read from the checked file (fbx_core.h)
  const std::string_view ending = file_name.substr(std::min(file_name.size(), file_name.rfind('.') + 1));
  const aiScene* scene = importer.ReadFileFromMemory(bytes.data(), bytes.size(), aiProcess_Triangulate | aiProcess_JoinIdenticalVertices,
                                                     formats::equal_ignoring_case(ending, "fbx") ? "fbx" : "dae");
  Error error;
  if (!scene) {
    error.add(ErrorCode::syntax, location, formats::utf8(importer.GetErrorString()) + ".", "Export the character again, or as glTF.");
    return refused(error);
  }
  const Result<SceneMeshes> meshes = collect_meshes(*scene, places, location);
  keep_repeated_bones(importer);
  return meshes ? text_of(*meshes) : refused(meshes.error());
}

/// Moves the pictures that can be shown into the skin; the others are reported.
void add_textures(SceneMeshes& meshes, const formats::GltfFiles& files, formats::ReadNotes& notes) {
  Skin& skin = meshes.file.skin;
  const std::vector<int> place = load_textures(std::move(meshes.textures), files, "the character's file", skin.textures, notes);
  for (SkinPart& part : skin.parts)
    if (part.texture >= 0) part.texture = place.at(static_cast<std::size_t>(part.texture));
}

}  // namespace

Result<formats::FileSkin> read_scene_skin(std::span<const std::byte> bytes, std::string_view file_name, const SceneOptions& options,
                                          const formats::GltfFiles& files, formats::ReadNotes& notes) {
  const std::string location(file_name);
  const Result<std::string> answer =
      call_guarded([&] { return answer_of(bytes, file_name, options); }, file_name, {.seconds = options.seconds});
  if (!answer) return fail(answer.error());
  std::string_view in = *answer;
  std::uint64_t good = 0;
  Error error;
  SceneMeshes meshes;
  const bool complete = take_number(in, good) && (good != 0 ? read_text(in, meshes) : take_error(in, error));
  if (!error.empty()) return fail(std::move(error));
  const auto wrong_texture = [&](const SkinPart& p) { return p.texture >= static_cast<int>(meshes.textures.size()); };
  if (!complete || std::ranges::any_of(meshes.file.skin.parts, wrong_texture))
    return fail(ErrorCode::syntax, location, "The library that reads this format returned an incomplete answer: the meshes are damaged.",
                "Export the character again.");
  notes.remarks.insert(notes.remarks.end(), meshes.remarks.begin(), meshes.remarks.end());
  add_textures(meshes, files, notes);
  if (meshes.file.skin.indices.empty()) return formats::FileSkin{};
  check_skin(meshes.file.skin, meshes.file.bones.size(), location, error);
  const auto damaged = [](const formats::FileBone& b) {
    return !is_finite(b.p) || !is_finite(b.A.column(0)) || !is_finite(b.A.column(1)) || !is_finite(b.A.column(2));
  };
  if (std::ranges::any_of(meshes.file.bones, damaged))
    error.add(ErrorCode::range, location, "The matrix of a bone is not finite.", "Export the character again.");
  if (!error.empty()) return fail(std::move(error));
  formats::remove_unused(meshes.file);
  return std::move(meshes.file);
}

}  // namespace ugoki::scene_formats
