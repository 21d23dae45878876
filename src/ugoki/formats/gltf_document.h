#pragma once
// The parsed content of a glTF file: nodes, skins and animations, with the values of their accessors. Internal to formats.

#include <array>
#include <optional>
#include <vector>

#include "ugoki/formats/gltf_unpack.h"
#include "ugoki/json/json.h"
#include "ugoki/spatial/spatial.h"

namespace ugoki::formats {

/// Affine transform x -> A x + p; A includes scale and shear.
struct Affine {
  Mat3 A = Mat3::identity();
  Vec3 p;
};
inline Affine operator*(const Affine& a, const Affine& b) { return {a.A * b.A, a.A * b.p + a.p}; }

struct GltfNode {
  std::string name;
  int parent = -1;  ///< index in GltfDocument::nodes; -1: root
  Vec3 translation;
  Quat rotation;
  Vec3 scale{1, 1, 1};
  std::optional<Affine> matrix;  ///< if set, replaces translation, rotation and scale
  int skin = -1;                 ///< index in GltfDocument::skins; -1: none
  std::optional<Vec3> mesh_end;  ///< far end of a mesh without skin, in the node's frame
  /// The node does not move and only carries a mesh of its parent, which has none: it is no joint. Set in files in which several such nodes
  /// are at one point of the scene, to which their vertices are relative, although their parents are at other places.
  bool mesh_of_parent = false;
};

/// Transform of a node relative to its parent.
[[nodiscard]] Affine local_of(const GltfNode& n);

struct GltfSkin {
  std::vector<int> joints;            ///< indices in GltfDocument::nodes
  std::vector<Affine> inverse_binds;  ///< [joints], or empty if the file gives none
  /// [joints] far end of the part of the mesh that follows the joint, in the joint's frame in the bind pose; or empty
  std::vector<std::optional<Vec3>> mesh_ends;
};

enum class GltfPath : unsigned char { translation, rotation, scale };
enum class GltfInterpolation : unsigned char { linear, step, cubic };

/// Animation keys of one property of one node.
struct GltfChannel {
  int node = 0;  ///< index in GltfDocument::nodes
  GltfPath path = GltfPath::translation;
  GltfInterpolation interpolation = GltfInterpolation::linear;
  std::vector<double> times;   ///< s, not decreasing
  std::vector<double> values;  ///< [times][3 or 4]; cubic: [times][in-tangent, value, out-tangent][3 or 4]
};

struct GltfAnimation {
  std::string name;
  std::vector<GltfChannel> channels;
};

struct GltfDocument {
  std::vector<GltfNode> nodes;  ///< in file order; children may precede their parent
  std::vector<GltfSkin> skins;
  std::vector<GltfAnimation> animations;
};

/// Parses and validates a .gltf or .glb file. Errors have the location "file:JSON path" or "file:chunk".
/// @param files loads buffers in other files; may be null
/// @param unpack unpacks buffer views of EXT_meshopt_compression; may be null
/// @param notes receives remarks on extensions that are not supported
[[nodiscard]] Result<GltfDocument> read_gltf_document(std::span<const std::byte> bytes, std::string_view file_name, const GltfFiles& files,
                                                      const GltfUnpack& unpack, ReadNotes& notes);

}  // namespace ugoki::formats
