#pragma once
// Convex bodies in motion, as peers can take them: plain numbers.

#include <memory>
#include <string>
#include <vector>

namespace ugoki::benchmarks {

/// A convex polytope, or a capsule along z (vertices empty).
struct PlainBody {
  std::vector<double> vertices;         ///< [3 n] m
  std::vector<std::vector<int>> faces;  ///< corners counter-clockwise from outside
  double radius = 0, half_length = 0;   ///< m, capsule
};

/// Bodies 0 ... first_of_b - 1 are group a, the others group b.
struct PlainMotion {
  std::vector<PlainBody> bodies;
  int first_of_b = 0;
  int steps = 0;                     ///< after the last comes the first again
  std::vector<double> rotations;     ///< [steps][bodies][9] row by row
  std::vector<double> translations;  ///< [steps][bodies][3] m
};

/// Signed distance of bodies i and j at the step that was set last, with all libraries' lists of pairs.
using PlainDistance = double (*)(void* context, int i, int j);

/// A library's own structure over all bodies.
class BodiesPeer {
 public:
  virtual ~BodiesPeer() = default;
  [[nodiscard]] virtual std::string name() const = 0;
  /// Moves all bodies to a step's poses and finds the least distance between the groups. Negative infinity: cannot do it.
  [[nodiscard]] virtual double nearest(int step) = 0;
  /// Moves all bodies and counts the pairs, of any two bodies, not farther than `margin`.
  [[nodiscard]] virtual int count_within(int step, double margin, PlainDistance distance, void* context) = 0;
};

/// nullptr where the library is not installed. The motion must outlive the peer.
/// @param margin m, of count_within
[[nodiscard]] std::unique_ptr<BodiesPeer> make_fcl_bodies(const PlainMotion& motion, double margin);
[[nodiscard]] std::unique_ptr<BodiesPeer> make_bullet_bodies(const PlainMotion& motion, double margin);

}  // namespace ugoki::benchmarks
