#pragma once
// A glTF file taken apart: nodes, and numbers out of accessors. Internal to formats.

#include <array>
#include <optional>
#include <vector>

#include "ugoki/formats/gltf.h"
#include "ugoki/json/json.h"
#include "ugoki/spatial/spatial.h"

namespace ugoki::formats {

/// Linear part (with scale) and translation.
struct Affine {
  Mat3 A = Mat3::identity();
  Vec3 p;
};
inline Affine operator*(const Affine& a, const Affine& b) { return {a.A * b.A, a.A * b.p + a.p}; }

struct GltfNode {
  std::string name;
  int parent = -1;
  Vec3 translation;
  Quat rotation;
  Vec3 scale{1, 1, 1};
  std::optional<Affine> matrix;  ///< instead of the three above
  int skin = -1;
};

struct GltfSkin {
  std::vector<int> joints;
  std::vector<Affine> inverse_binds;  ///< [joints] or empty
};

enum class GltfPath : unsigned char { translation, rotation, scale };
enum class GltfInterpolation : unsigned char { linear, step, cubic };

struct GltfChannel {
  int node = 0;
  GltfPath path = GltfPath::translation;
  GltfInterpolation interpolation = GltfInterpolation::linear;
  std::vector<double> times;   ///< s, rising
  std::vector<double> values;  ///< [times][3 or 4]; cubic: [times][in-tangent, value, out-tangent][3 or 4]
};

struct GltfAnimation {
  std::string name;
  std::vector<GltfChannel> channels;
};

struct GltfDocument {
  std::vector<GltfNode> nodes;  ///< any order
  std::vector<GltfSkin> skins;
  std::vector<GltfAnimation> animations;
};

[[nodiscard]] Result<GltfDocument> read_gltf_document(std::span<const std::byte> bytes, std::string_view file_name, const GltfFiles& files,
                                                      ReadNotes& notes);

}  // namespace ugoki::formats
