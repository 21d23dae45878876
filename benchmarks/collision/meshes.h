#pragma once
// Two non-convex meshes in coherent motion as plain arrays, for our code and for peers (other libraries).

#include <memory>
#include <string>
#include <vector>

namespace ugoki::benchmarks {

struct PlainMesh {
  std::vector<double> vertices;  ///< [3 * vertices] m
  std::vector<int> triangles;    ///< [3 * triangles]
};

/// Pose of the second mesh in the frame of the first: rotation row by row, then translation [m].
struct PlainPose {
  double R[9], p[3];
};

/// Calculates the distance between two meshes with one library.
class MeshPeer {
 public:
  virtual ~MeshPeer() = default;
  [[nodiscard]] virtual std::string name() const = 0;
  /// Distance [m] between the meshes; 0 or less if they intersect.
  virtual double distance(const PlainPose& X_AB) = 0;
};

enum class MeshBounds { rss, obb_rss };
/// Makes a peer; null if the library is not installed.
[[nodiscard]] std::unique_ptr<MeshPeer> make_fcl_meshes(const PlainMesh& a, const PlainMesh& b, MeshBounds bounds);
[[nodiscard]] std::unique_ptr<MeshPeer> make_coal_meshes(const PlainMesh& a, const PlainMesh& b, MeshBounds bounds);
/// PQP with a warm start from the closest triangles of the previous query.
[[nodiscard]] std::unique_ptr<MeshPeer> make_pqp_meshes(const PlainMesh& a, const PlainMesh& b);

}  // namespace ugoki::benchmarks
