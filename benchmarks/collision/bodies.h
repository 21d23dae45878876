#pragma once
// Moving convex bodies as plain arrays, from which peers (other libraries) are built.

#include <memory>
#include <string>
#include <vector>

namespace ugoki::benchmarks {

/// A convex polytope, or a capsule along z (vertices empty).
struct PlainBody {
  std::vector<double> vertices;         ///< [3 n] m
  std::vector<std::vector<int>> faces;  ///< vertex indices, counter-clockwise seen from outside
  double radius = 0, half_length = 0;   ///< m, capsule
};

/// Motion of two groups of bodies: group a consists of bodies 0 to first_of_b - 1, group b of the others.
struct PlainMotion {
  std::vector<PlainBody> bodies;
  int first_of_b = 0;
  int steps = 0;                     ///< number of poses; the motion is periodic
  std::vector<double> rotations;     ///< [steps][bodies][9] row by row
  std::vector<double> translations;  ///< [steps][bodies][3] m
};

/// Signed distance [m] between bodies i and j at the current step. All libraries use the same function to list the pairs within a margin.
using PlainDistance = double (*)(void* context, int i, int j);

/// The bodies in one library's broad phase.
class BodiesPeer {
 public:
  virtual ~BodiesPeer() = default;
  [[nodiscard]] virtual std::string name() const = 0;
  /// Moves all bodies to a step's poses. @return minimum distance [m] between the groups; negative infinity: not supported
  [[nodiscard]] virtual double nearest(int step) = 0;
  /// Moves all bodies to a step's poses. @return number of pairs of bodies within `margin`
  [[nodiscard]] virtual int count_within(int step, double margin, PlainDistance distance, void* context) = 0;
};

/// Makes a peer; nullptr if the library is not installed. The motion must outlive the peer.
/// @param margin margin [m] of the later calls of count_within()
[[nodiscard]] std::unique_ptr<BodiesPeer> make_fcl_bodies(const PlainMotion& motion, double margin);
[[nodiscard]] std::unique_ptr<BodiesPeer> make_bullet_bodies(const PlainMotion& motion, double margin);

}  // namespace ugoki::benchmarks
