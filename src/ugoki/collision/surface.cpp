#include "ugoki/collision/surface.h"

#include <algorithm>

namespace ugoki::collision {
namespace {

constexpr double side_tolerance = 1e-7;  // fraction of the longest side: a point closer to a side than this is on the side
constexpr double sine_tolerance = 1e-6;  // rad: directions within this angle count as equal
constexpr int max_around = 1000;         // maximum count of triangles visited around a corner in each sense, to bound the time

double square(double x) { return x * x; }

/// True if n is between m and `other`, the normals of two triangles that share a convex side.
bool between(const Vec3& m, const Vec3& other, const Vec3& n) {
  const Vec3 turn = cross(m, other);
  return dot(cross(m, n), turn) >= -sine_tolerance * norm(turn) && dot(cross(n, other), turn) >= -sine_tolerance * norm(turn);
}

/// True if corner k of the facet is farther along n than all corners of the triangles around it, so that a body in direction n can touch
/// the corner.
/// @param is_first [in, out] set to false if a triangle around the corner has a smaller index than the facet
bool corner_is_extreme(const Surface& surface, const Surface::Facet& facet, int k, const Vec3& n, bool& is_first) {
  const Vec3 v = facet.p[static_cast<std::size_t>(k)];
  const auto rises = [&](const Vec3& p) { return dot(n, p - v) > sine_tolerance * norm(p - v); };
  for (const int sense : {0, 1}) {  // goes around the corner in one sense; if the surface has a border there, in the other sense too
    Surface::Facet here = facet;
    int corner = k;
    for (int step = 0; step < max_around; ++step) {
      if (rises(here.p[static_cast<std::size_t>((corner + 1) % 3)]) || rises(here.p[static_cast<std::size_t>((corner + 2) % 3)]))
        return false;
      const std::int32_t next = surface.across(here.index, sense == 0 ? corner : (corner + 2) % 3);
      if (next < 0) break;
      if (next == facet.index) return true;
      is_first = is_first && facet.index < next;
      here = surface.facet(next);
      corner = -1;
      for (int i = 0; i < 3; ++i)
        if (here.p[static_cast<std::size_t>(i)] == v) corner = i;
      if (corner < 0) return true;
    }
  }
  return true;
}

}  // namespace

Surface::Facet Surface::facet(std::int32_t t) const {
  Facet out;
  out.index = t;
  if (field_ != nullptr) {
    const int cell = t / 2, column = cell % (field_->columns - 1), row = cell / (field_->columns - 1);
    out.p[0] = field_->point(column, row);
    out.p[1] = t % 2 == 0 ? field_->point(column + 1, row) : field_->point(column + 1, row + 1);
    out.p[2] = t % 2 == 0 ? field_->point(column + 1, row + 1) : field_->point(column, row + 1);
  } else {
    for (int k = 0; k < 3; ++k) out.p[static_cast<std::size_t>(k)] = prepared_->spheres.corner(t, k) + prepared_->spheres.centre;
  }
  out.n = normalized(cross(out.p[1] - out.p[0], out.p[2] - out.p[0]));
  return out;
}

std::int32_t Surface::across(std::int32_t t, int k) const {
  if (field_ == nullptr) return prepared_->across[static_cast<std::size_t>(t)][static_cast<std::size_t>(k)];
  const int columns = field_->columns - 1, rows = field_->rows - 1, cell = t / 2, column = cell % columns, row = cell / columns;
  if (t % 2 == 0) {  // adjacent triangles at sides 0, 1, 2: below, right, diagonal
    if (k == 0) return row > 0 ? 2 * (cell - columns) + 1 : -1;
    if (k == 1) return column + 1 < columns ? 2 * (cell + 1) + 1 : -1;
    return t + 1;
  }
  if (k == 0) return t - 1;  // adjacent triangles at sides 0, 1, 2: diagonal, above, left
  if (k == 1) return row + 1 < rows ? 2 * (cell + columns) : -1;
  return column > 0 ? 2 * (cell - 1) : -1;
}

void Surface::collect_cells(const Bounds& box, std::vector<std::int32_t>& out) const {
  const auto first = [](double x, double half, int cells) {
    return static_cast<int>(std::clamp((x / half + 1) * 0.5 * cells, 0.0, static_cast<double>(cells)));
  };
  const int columns = field_->columns - 1, rows = field_->rows - 1;
  if (!(box.low.x <= field_->half_x && box.high.x >= -field_->half_x && box.low.y <= field_->half_y && box.high.y >= -field_->half_y))
    return;
  const int c1 = std::min(first(box.high.x, field_->half_x, columns), columns - 1);
  const int r1 = std::min(first(box.high.y, field_->half_y, rows), rows - 1);
  for (int row = std::min(first(box.low.y, field_->half_y, rows), rows - 1); row <= r1; ++row)
    for (int column = std::min(first(box.low.x, field_->half_x, columns), columns - 1); column <= c1; ++column) {
      const double a = field_->point(column, row).z, b = field_->point(column + 1, row).z, c = field_->point(column + 1, row + 1).z,
                   d = field_->point(column, row + 1).z;
      if (std::max({a, b, c, d}) < box.low.z) continue;  // no upper limit: a box below the surface is inside the solid
      out.push_back(2 * (row * columns + column));
      out.push_back(2 * (row * columns + column) + 1);
    }
}

void Surface::collect(const Bounds& box, std::vector<std::int32_t>& stack, std::vector<std::int32_t>& out) const {
  if (field_ != nullptr) return collect_cells(box, out);
  const SphereTree& tree = prepared_->spheres;
  if (tree.empty()) return;
  const Vec3 low = box.low - tree.centre, high = box.high - tree.centre;
  stack.clear();
  stack.push_back(0);
  while (!stack.empty()) {
    const BoundBlock& block = tree.blocks[static_cast<std::size_t>(stack.back())];
    stack.pop_back();
    for (int lane = 0; lane < block.count; ++lane) {
      double d2 = 0;
      for (int i = 0; i < 3; ++i) {
        const double c = block.sphere[i][lane];
        d2 += square(c < low[i] ? low[i] - c : c > high[i] ? c - high[i] : 0);
      }
      if (d2 > square(block.radius[lane])) continue;
      const std::int32_t child = block.child[lane];
      if (child >= 0)
        stack.push_back(child);
      else
        out.push_back(-1 - child);
    }
  }
}

bool touches_from(const Surface& surface, const Surface::Facet& f, const Vec3& q, const Vec3& n) {
  const double along = dot(n, f.n);
  if (along > 1 - 0.5 * sine_tolerance * sine_tolerance) return true;
  if (surface.closed() && along <= -1 + 1e-9) return false;
  const double size = std::max({norm(f.p[1] - f.p[0]), norm(f.p[2] - f.p[1]), norm(f.p[0] - f.p[2])});
  int sides[3], count = 0;
  for (int k = 0; k < 3; ++k) {
    const Vec3 from = f.p[static_cast<std::size_t>(k)], edge = f.p[static_cast<std::size_t>((k + 1) % 3)] - from;
    const Vec3 inward = normalized(cross(f.n, edge), {});
    if (dot(inward, q - from) < side_tolerance * size) sides[count++] = k;
  }
  if (count == 0)
    return !surface.closed() || along > 0.999;  // q is inside the triangle: a solid needs n within 2.6 degrees of the triangle's normal
  if (count == 1) {
    const std::int32_t next = surface.across(f.index, sides[0]);
    if (next < 0) return !surface.closed() || along > -sine_tolerance;
    if (next < f.index) return false;
    const Surface::Facet other = surface.facet(next);
    // The side is convex only if the other triangle is below the plane of facet f.
    const Vec3 from = f.p[static_cast<std::size_t>(sides[0])];
    // `lowest` is a minimum of heights, not the height h of largest magnitude. Reason: clang 19 loses the second fabs of
    // "if (fabs(h) > fabs(height)) height = h" when it unrolls the loop.
    double lowest = 0, far = 0;
    for (const Vec3& p : other.p) {
      lowest = std::min(lowest, dot(f.n, p - from));
      far = std::max(far, norm(p - from));
    }
    return lowest < -sine_tolerance * far && between(f.n, other.n, n);
  }
  const int corner = (sides[0] == 0 && sides[1] == 2) ? 0 : sides[1];
  bool is_first = true;
  return corner_is_extreme(surface, f, corner, n, is_first) && is_first;
}

}  // namespace ugoki::collision
