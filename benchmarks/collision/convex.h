#pragma once
// Pairs of convex hulls as plain arrays, from which peers (other libraries) are built.

#include <memory>
#include <string>
#include <vector>

namespace ugoki::benchmarks {

struct PlainHull {
  std::vector<double> vertices;         ///< [3 n] m
  std::vector<std::vector<int>> faces;  ///< vertex indices, counter-clockwise seen from outside
};

/// Pose: rotation row by row, then translation [m].
struct PlainPlace {
  double R[9], p[3];
};

/// Calculates the distance between two hulls with one library, including the library's own warm start from query to query.
class ConvexPeer {
 public:
  virtual ~ConvexPeer() = default;
  [[nodiscard]] virtual std::string name() const = 0;
  [[nodiscard]] virtual double distance(const PlainPlace& a, const PlainPlace& b) = 0;
};

using ConvexPeers = std::vector<std::unique_ptr<ConvexPeer>>;

/// Each function adds the solvers of one library; it adds nothing if the library is not installed.
void add_fcl_convex(ConvexPeers& peers, const PlainHull& a, const PlainHull& b);
void add_bullet_convex(ConvexPeers& peers, const PlainHull& a, const PlainHull& b);
void add_coal_convex(ConvexPeers& peers, const PlainHull& a, const PlainHull& b);

}  // namespace ugoki::benchmarks
