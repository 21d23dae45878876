#pragma once
// Two meshes that are not convex, in coherent motion, as plain numbers for us and for the peers.

#include <memory>
#include <string>
#include <vector>

namespace ugoki::benchmarks {

struct PlainMesh {
  std::vector<double> vertices;  ///< [3 * vertices] m
  std::vector<int> triangles;    ///< [3 * triangles]
};

/// Pose of the second mesh in the frame of the first, row by row, and translation.
struct PlainPose {
  double R[9], p[3];
};

/// A library's distance of two meshes.
class MeshPeer {
 public:
  virtual ~MeshPeer() = default;
  [[nodiscard]] virtual std::string name() const = 0;
  /// m; 0 (or less) where they pierce each other
  virtual double distance(const PlainPose& X_AB) = 0;
};

enum class MeshBounds { rss, obb_rss };
/// Null where the library is not there.
[[nodiscard]] std::unique_ptr<MeshPeer> make_fcl_meshes(const PlainMesh& a, const PlainMesh& b, MeshBounds bounds);
[[nodiscard]] std::unique_ptr<MeshPeer> make_coal_meshes(const PlainMesh& a, const PlainMesh& b, MeshBounds bounds);
/// Warm: it keeps the last triangles.
[[nodiscard]] std::unique_ptr<MeshPeer> make_pqp_meshes(const PlainMesh& a, const PlainMesh& b);

}  // namespace ugoki::benchmarks
