#include "ugoki/collision/sphere_tree_build.h"

#include <algorithm>
#include <array>
#include <limits>

#include "ugoki/collision/triangle_distance.h"

namespace ugoki::collision::build {
namespace {

std::size_t at(std::int32_t i) { return static_cast<std::size_t>(i); }

/// A range of the ordered triangles: begin ... begin + count - 1.
struct Part {
  std::size_t begin, count;
};
/// The result of split(): the parts into which a part is split, one for each lane of a block.
struct Parts {
  std::array<Part, block_lanes> part;
  std::size_t count = 1;
};

/// Splits a part into at most eight. Repeatedly splits the largest of them near its middle, at a multiple of the triangle count of a full
/// subtree, so that the blocks below are full. The split positions depend only on the count of triangles. `divide(part, left)` must reorder
/// the part so that the triangles of the first half of the split come first; `left` is their count.
template <class Divide>
Parts split(const Part& whole, Divide divide) {
  Parts out;
  out.part[0] = whole;
  std::size_t grain = 1;  // count of triangles in a full subtree: a power of eight below whole.count, at most 512
  while (grain * block_lanes < whole.count && grain < 512) grain *= block_lanes;
  while (out.count < block_lanes) {
    std::size_t largest = 0;
    for (std::size_t i = 1; i < out.count; ++i)
      if (out.part[i].count > out.part[largest].count) largest = i;
    const Part p = out.part[largest];
    if (p.count <= grain) break;
    const std::size_t grains = (p.count + grain - 1) / grain, left = grain * (grains / 2);
    divide(p, left);
    std::move_backward(out.part.begin() + static_cast<std::ptrdiff_t>(largest) + 1,
                       out.part.begin() + static_cast<std::ptrdiff_t>(out.count),
                       out.part.begin() + static_cast<std::ptrdiff_t>(out.count) + 1);
    out.part[largest] = {p.begin, left};
    out.part[largest + 1] = {p.begin + left, p.count - left};
    ++out.count;
  }
  return out;
}

/// Unit eigenvectors of a symmetric matrix by Jacobi rotations, in the order of decreasing eigenvalues, right-handed.
std::array<Vec3, 3> principal_axes(const Sym3& s) {
  double a[3][3] = {{s.xx, s.xy, s.xz}, {s.xy, s.yy, s.yz}, {s.xz, s.yz, s.zz}};
  double v[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  for (int sweep = 0; sweep < 12; ++sweep) {
    const double off = std::fabs(a[0][1]) + std::fabs(a[0][2]) + std::fabs(a[1][2]);
    if (!(off > 1e-15 * (std::fabs(a[0][0]) + std::fabs(a[1][1]) + std::fabs(a[2][2])))) break;
    for (int p = 0; p < 2; ++p)
      for (int q = p + 1; q < 3; ++q) {
        if (a[p][q] == 0) continue;
        const double theta = (a[q][q] - a[p][p]) / (2 * a[p][q]);
        const double t = (theta < 0 ? -1 : 1) / (std::fabs(theta) + std::sqrt(theta * theta + 1));
        const double c = 1 / std::sqrt(t * t + 1), sn = t * c;
        for (auto& row : a) {
          const double x = row[p], y = row[q];
          row[p] = c * x - sn * y;
          row[q] = sn * x + c * y;
        }
        for (int k = 0; k < 3; ++k) {
          const double x = a[p][k], y = a[q][k];
          a[p][k] = c * x - sn * y;
          a[q][k] = sn * x + c * y;
        }
        for (auto& row : v) {
          const double x = row[p], y = row[q];
          row[p] = c * x - sn * y;
          row[q] = sn * x + c * y;
        }
      }
  }
  std::array<int, 3> order{0, 1, 2};
  std::sort(order.begin(), order.end(), [&](int i, int j) { return a[i][i] != a[j][j] ? a[i][i] > a[j][j] : i < j; });
  const Vec3 x = normalized(Vec3{v[0][order[0]], v[1][order[0]], v[2][order[0]]}, {1, 0, 0});
  Vec3 y{v[0][order[1]], v[1][order[1]], v[2][order[1]]};
  y = normalized(y - x * dot(x, y), {0, 1, 0});
  return {x, y, cross(x, y)};
}

/// Area [m^2] of triangles, and its first [m^3] and second [m^4] moments about the origin.
struct Moments {
  double area = 0;
  Vec3 first;
  Sym3 second;

  /// Adds the triangle a, b, c.
  void add(const Vec3& a, const Vec3& b, const Vec3& c) {
    const double s = 0.5 * norm(cross(b - a, c - a));
    const Vec3 sum = a + b + c;
    area += s;
    first += sum * (s / 3);
    const Mat3 m = (Mat3::outer(a, a) + Mat3::outer(b, b) + Mat3::outer(c, c) + Mat3::outer(sum, sum)) * (s / 12);
    second = second + symmetric_part(m);
  }
  /// Second moment about the centroid, m^4.
  [[nodiscard]] Sym3 covariance() const {
    const Vec3 mean = first / area;
    return second - symmetric_part(Mat3::outer(mean, mean)) * area;
  }
};

/// Computes the order of the triangles by recursive splitting.
class Order {
 public:
  Order(std::span<const Vec3> vertices, std::span<const Triangle> triangles, const Vec3& centre)
      : centroid_(triangles.size()), key_(triangles.size()), order_(triangles.size()), scratch_(triangles.size()) {
    for (std::size_t i = 0; i < triangles.size(); ++i) {
      const Triangle& t = triangles[i];
      centroid_[i] = (vertices[at(t[0])] - centre) + (vertices[at(t[1])] - centre) + (vertices[at(t[2])] - centre);
      order_[i] = static_cast<std::int32_t>(i);
    }
  }
  std::vector<std::int32_t> run() {
    arrange({0, order_.size()});
    return std::move(order_);
  }

 private:
  void arrange(const Part& whole) {  // NOLINT(misc-no-recursion): depth log(n)
    if (whole.count <= 1) return;
    const Parts parts = split(whole, [this](const Part& p, std::size_t left) { divide(p, left); });
    for (std::size_t i = 0; i < parts.count; ++i) arrange(parts.part[i]);
  }

  /// Partitions a part along the longest principal axis of its centroids. Ties are broken by index, so that the partition does not depend
  /// on the standard library's nth_element.
  void divide(const Part& p, std::size_t left) {
    const auto begin = order_.begin() + static_cast<std::ptrdiff_t>(p.begin), end = begin + static_cast<std::ptrdiff_t>(p.count);
    Vec3 sum;
    for (auto i = begin; i != end; ++i) sum += centroid_[at(*i)];
    const Vec3 mean = sum / static_cast<double>(p.count);
    Sym3 spread;
    for (auto i = begin; i != end; ++i) {
      const Vec3 r = centroid_[at(*i)] - mean;
      spread.xx += r.x * r.x;
      spread.yy += r.y * r.y;
      spread.zz += r.z * r.z;
      spread.xy += r.x * r.y;
      spread.xz += r.x * r.z;
      spread.yz += r.y * r.z;
    }
    const Vec3 axis = principal_axes(spread)[0];
    for (auto i = begin; i != end; ++i) key_[at(*i)] = dot(axis, centroid_[at(*i)] - mean);
    const auto before = [this](std::int32_t i, std::int32_t j) { return key_[at(i)] != key_[at(j)] ? key_[at(i)] < key_[at(j)] : i < j; };
    const auto copy = scratch_.begin() + static_cast<std::ptrdiff_t>(p.begin);
    std::copy(begin, end, copy);
    const auto nth = copy + static_cast<std::ptrdiff_t>(left);
    std::nth_element(copy, nth, copy + static_cast<std::ptrdiff_t>(p.count), before);
    const std::int32_t pivot = *nth;
    auto front = copy, back = copy + static_cast<std::ptrdiff_t>(left);
    for (auto i = begin; i != end; ++i) *(before(*i, pivot) ? front : back)++ = *i;
    std::copy(copy, copy + static_cast<std::ptrdiff_t>(p.count), begin);
  }

  std::vector<Vec3> centroid_;  // m: three times each triangle's centroid, relative to the mesh's centre
  std::vector<double> key_;     // m: coordinate along the axis of the current split
  std::vector<std::int32_t> order_, scratch_;
};

/// Fills the blocks of a tree with bounds, bottom-up.
class Fit {
 public:
  explicit Fit(SphereTree& tree) : tree_(tree) {}
  void run() {
    tree_.blocks.emplace_back();
    tree_.blocks[0].count = 1;
    fill(0, 0, {0, tree_.triangles.size()});
  }

 private:
  /// Fills one lane of a block with the bounds of a part, and the blocks below it. @return the moments of the part
  Moments fill(std::size_t block, int lane, const Part& part) {  // NOLINT(misc-no-recursion): depth log(n)
    Moments sum;
    if (part.count == 1) {
      const auto t = static_cast<std::int32_t>(part.begin);
      const Vec3 a = tree_.corner(t, 0), b = tree_.corner(t, 1), c = tree_.corner(t, 2);
      sum.add(a, b, c);
      tree_.blocks[block].child[lane] = -1 - t;
      const Vec3 x = normalized(b - a, {1, 0, 0}), other = c - a;
      const Vec3 y = normalized(other - x * dot(x, other), any_perpendicular(x));
      fit(block, lane, part, {x, y, cross(x, y)});
      return sum;
    }
    const Parts parts = split(part, [](const Part&, std::size_t) {});
    const std::size_t below = tree_.blocks.size();
    tree_.blocks.emplace_back();
    tree_.blocks[below].count = static_cast<std::int32_t>(parts.count);
    tree_.blocks[block].child[lane] = static_cast<std::int32_t>(below);
    for (std::size_t i = 0; i < parts.count; ++i) {
      const Moments m = fill(below, static_cast<int>(i), parts.part[i]);
      sum.area += m.area;
      sum.first += m.first;
      sum.second = sum.second + m.second;
    }
    fit(block, lane, part, sum.area > 0 ? principal_axes(sum.covariance()) : std::array<Vec3, 3>{Vec3{1, 0, 0}, {0, 1, 0}, {0, 0, 1}});
    return sum;
  }

  /// Fits the oriented box with the given axes, and then the sphere, to the triangles of a part.
  void fit(std::size_t block, int lane, const Part& part, const std::array<Vec3, 3>& axes) {
    BoundBlock& out = tree_.blocks[block];
    Vec3 axis[3];
    for (int k = 0; k < 2; ++k)
      for (int i = 0; i < 3; ++i) {
        out.axis[k][i][lane] = static_cast<float>(axes[static_cast<std::size_t>(k)][i]);
        axis[k][i] = static_cast<double>(out.axis[k][i][lane]);
      }
    axis[2] = cross(axis[0], axis[1]);
    constexpr double maximum = std::numeric_limits<double>::max();
    Vec3 low{maximum, maximum, maximum}, high{-maximum, -maximum, -maximum};
    each_corner(part, [&](const Vec3& v) {
      for (int k = 0; k < 3; ++k) {
        const double x = dot(axis[k], v);
        low[k] = std::min(low[k], x);
        high[k] = std::max(high[k], x);
      }
    });
    // Axes and centre are rounded to float; `slack` covers both errors.
    const Vec3 middle = axis[0] * (0.5 * (low.x + high.x)) + axis[1] * (0.5 * (low.y + high.y)) + axis[2] * (0.5 * (low.z + high.z));
    const double slack = 4e-7 * tree_.radius;
    for (int k = 0; k < 3; ++k) {
      out.box[k][lane] = static_cast<float>(middle[k]);
      out.half[k][lane] = static_cast<float>(0.5 * (high[k] - low[k]) + slack);
    }
    fit_sphere(out, lane, part, middle);
  }

  /// Fits the sphere of a part. Its centre is the surface point nearest to the centre of the box; for one triangle it is the point of the
  /// triangle nearest to its circumcentre. The radius contains the corners of the part's triangles; a sphere that contains the children's
  /// spheres would be larger.
  void fit_sphere(BoundBlock& out, int lane, const Part& part, const Vec3& middle) {
    Vec3 best;
    double best2 = std::numeric_limits<double>::infinity();
    for (std::size_t i = part.begin; i < part.begin + part.count; ++i) {
      const Vec3 x = nearest_to(static_cast<std::int32_t>(i), part.count == 1 ? circumcentre(static_cast<std::int32_t>(i)) : middle);
      const double d2 = dot(x - middle, x - middle);
      if (d2 < best2) {
        best2 = d2;
        best = x;
      }
    }
    Vec3 centre;
    for (int k = 0; k < 3; ++k) {
      out.sphere[k][lane] = static_cast<float>(best[k]);
      centre[k] = static_cast<double>(out.sphere[k][lane]);
    }
    double r2 = 0;
    each_corner(part, [&](const Vec3& v) { r2 = std::max(r2, dot(v - centre, v - centre)); });
    out.radius[lane] = static_cast<float>(std::sqrt(r2) * (1 + 2e-7) + std::numeric_limits<float>::min());
  }

  /// Circumcentre of a triangle. In an obtuse triangle the point nearest to it is the middle of the longest side.
  [[nodiscard]] Vec3 circumcentre(std::int32_t t) const {
    const Vec3 a = tree_.corner(t, 0), c = tree_.corner(t, 1) - a, b = tree_.corner(t, 2) - a;  // c: the longest side
    const double cc = dot(c, c), bc = dot(b, c), x = cc > 0 ? bc / cc : 0;
    const Vec3 g = b - c * x;
    const double gg = dot(g, g), height = gg > 0 ? 0.5 * (1 + (x * x - x) * cc / gg) : 0;
    return a + c * 0.5 + g * height;
  }

  [[nodiscard]] Vec3 nearest_to(std::int32_t t, const Vec3& p) const {
    return nearest_on_triangle({tree_.corner(t, 0), tree_.corner(t, 1), tree_.corner(t, 2)}, p).p;
  }

  template <class F>
  void each_corner(const Part& part, F f) const {
    for (std::size_t i = part.begin; i < part.begin + part.count; ++i)
      for (const std::int32_t v : tree_.triangles[i]) f(tree_.vertices[at(v)]);
  }

  SphereTree& tree_;
};

}  // namespace

std::vector<std::int32_t> order_triangles(std::span<const Vec3> vertices, std::span<const Triangle> triangles, const Vec3& centre) {
  return Order(vertices, triangles, centre).run();
}

void fit_bounds(SphereTree& tree) {
  tree.blocks.reserve(tree.triangles.size() / 6 + 2);
  Fit(tree).run();
}

}  // namespace ugoki::collision::build
