#pragma once
// The meshes of a glTF file with their materials and textures. Internal to formats.

#include <string>
#include <vector>

#include "ugoki/formats/gltf_unpack.h"
#include "ugoki/mechanism/skin.h"

namespace ugoki::formats {

/// The triangles of one material in one node of the file.
struct GltfSurface {
  std::size_t node = 0;                ///< with the mesh; its skin gives the meaning of `joints`
  std::size_t sets = 0;                ///< joints of a vertex: 0, 4 or 8
  std::vector<float> positions;        ///< [vertices][3] in the frame of the mesh
  std::vector<float> normals;          ///< [vertices][3], or empty
  std::vector<float> uvs;              ///< [vertices][2]
  std::vector<double> colors;          ///< [vertices][3] linear, or empty
  std::vector<std::uint32_t> joints;   ///< [vertices][sets] indices in GltfSkin::joints; not checked
  std::vector<double> weights;         ///< [vertices][sets]
  std::vector<std::uint32_t> corners;  ///< of the triangles, indices of vertices
  SkinPart part;                       ///< material
};

struct GltfMeshes {
  std::vector<GltfSurface> surfaces;
  std::vector<SkinTexture> textures;
};

/// Reads the meshes of all nodes. Parts that are not supported or damaged are left out, with a remark in `notes`. Errors: as
/// read_gltf_document(); more vertices or triangles than a skin can have.
[[nodiscard]] Result<GltfMeshes> read_gltf_meshes(std::span<const std::byte> bytes, std::string_view file_name, const GltfFiles& files,
                                                  const GltfUnpack& unpack, ReadNotes& notes);

}  // namespace ugoki::formats
