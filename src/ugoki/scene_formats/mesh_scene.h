#pragma once
// Reads the triangles, material colours and colour textures of mesh files: glTF, OBJ, STL, PLY, COLLADA, FBX. docs/formats.md lists what is
// read.

#include <cstddef>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "ugoki/base/result.h"
#include "ugoki/formats/read_notes.h"
#include "ugoki/mechanism/geometry.h"
#include "ugoki/mechanism/skin.h"

namespace ugoki::scene_formats {

/// The triangles of one material.
struct MeshPart {
  std::string color;                ///< "#rrggbb", base colour of the material; empty: the file gives none
  std::vector<Triangle> triangles;  ///< indices into MeshScene::vertices, counter-clockwise seen from outside
  int texture = -1;                 ///< index in MeshScene::textures; -1: none
  std::string tint = "#ffffff";     ///< "#rrggbb", multiplied with the texture
  double cutoff = 0;                ///< 0 ... 1: where the texture's alpha is below, nothing is drawn
  bool both_sides = false;          ///< also triangles that are seen from behind are drawn
};

/// All meshes of a file in one frame: metres, Z up.
struct MeshScene {
  std::vector<Vec3> vertices;  ///< m; neighbouring triangles may have vertices of their own at the same place
  std::vector<Vec3> normals;   ///< [vertices] unit vectors; zero: the file gives none
  std::vector<float> uvs;      ///< [vertices][2] of the textures; (0, 0) is the top left corner of the picture
  std::vector<SkinTexture> textures;
  std::vector<MeshPart> parts;
  bool skinned = false;   ///< a mesh is bound to bones
  bool animated = false;  ///< the file has animations
};

/// Returns the bytes of a file to which the mesh file refers (buffers of .gltf, materials of .obj, textures), by its name without folders.
using MeshCompanions = std::function<Result<std::vector<std::byte>>(std::string_view name)>;

struct MeshOptions {
  double metres_per_unit = 0;      ///< m per file unit; 0: as the file or its format states, otherwise 1, or a guess if that is implausible
  MeshCompanions companions = {};  ///< null: there are no other files
  double seconds = 60;             ///< maximum time for reading, s
};

/// Reads a mesh file. The library that parses it runs in a child process: a crash, and more than `seconds` or 4 GB, give an Error. It can
/// open no file except through `companions`. Errors: another kind of file, a damaged file, no triangle, more than max_triangles triangles,
/// coordinates that are not finite.
/// @param file_name its extension selects the format; the name appears in the location of every problem
/// @param notes receives unit, up axis and remarks; may be null
[[nodiscard]] Result<MeshScene> read_mesh_scene(std::span<const std::byte> bytes, std::string_view file_name,
                                                const MeshOptions& options = {}, formats::ReadNotes* notes = nullptr);

/// True if files of this extension contain meshes that read_mesh_scene() can read.
[[nodiscard]] bool is_mesh_file(std::string_view file_name);

}  // namespace ugoki::scene_formats
