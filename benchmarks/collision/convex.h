#pragma once
// Pairs of convex hulls, as peers can take them: plain numbers.

#include <memory>
#include <string>
#include <vector>

namespace ugoki::benchmarks {

struct PlainHull {
  std::vector<double> vertices;         ///< [3 n] m
  std::vector<std::vector<int>> faces;  ///< corners counter-clockwise from outside
};

/// Rotation row by row, then translation [m].
struct PlainPlace {
  double R[9], p[3];
};

/// A library's distance of two hulls, with whatever it remembers from one query to the next.
class ConvexPeer {
 public:
  virtual ~ConvexPeer() = default;
  [[nodiscard]] virtual std::string name() const = 0;
  [[nodiscard]] virtual double distance(const PlainPlace& a, const PlainPlace& b) = 0;
};

using ConvexPeers = std::vector<std::unique_ptr<ConvexPeer>>;

/// Add what the installed library has; nothing where it is not installed.
void add_fcl_convex(ConvexPeers& peers, const PlainHull& a, const PlainHull& b);
void add_bullet_convex(ConvexPeers& peers, const PlainHull& a, const PlainHull& b);
void add_coal_convex(ConvexPeers& peers, const PlainHull& a, const PlainHull& b);

}  // namespace ugoki::benchmarks
