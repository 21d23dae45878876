#pragma once
// Far ends of the bones of an FBX file, estimated from the skins. Internal to scene_formats.

#include <map>
#include <span>
#include <string>

#include "ugoki/scene_formats/fbx_tree.h"
#include "ugoki/spatial/vec3.h"

namespace ugoki::scene_formats {

/// A cluster of a skin: the vertices of a mesh that a bone moves.
struct FbxSkinPart {
  const FbxRecord* mesh;
  const FbxRecord* cluster;
  std::string bone;  ///< name of the bone's model
};

/// A mesh without a skin, which moves rigidly with a model.
struct FbxRigidMesh {
  const FbxRecord* mesh;
  const FbxRecord* model;
  std::string bone;  ///< name of the model
};

/// The far end of each bone [bone's frame, file units] by the name of the bone's model: the mean of the farthest vertices that follow the
/// bone more than any other bone; without a skin, the mean of the farthest vertices of the bone's rigid mesh. Bones without such vertices
/// have none. Meshes and clusters that cannot be read are left out.
[[nodiscard]] std::map<std::string, Vec3> fbx_mesh_ends(const FbxFile& file, std::span<const FbxSkinPart> parts,
                                                        std::span<const FbxRigidMesh> rigid);

}  // namespace ugoki::scene_formats
