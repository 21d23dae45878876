#include "ugoki/control/ground_map.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>

#include "ugoki/mechanism/state.h"

namespace ugoki::control {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

std::size_t at(int i) { return static_cast<std::size_t>(i); }

Vec3 smaller(const Vec3& a, const Vec3& b) { return {std::min(a.x, b.x), std::min(a.y, b.y), std::min(a.z, b.z)}; }
Vec3 larger(const Vec3& a, const Vec3& b) { return {std::max(a.x, b.x), std::max(a.y, b.y), std::max(a.z, b.z)}; }

bool above(const Vec3& low, const Vec3& high, const Vec3& p) {
  return p.x >= low.x && p.x <= high.x && p.y >= low.y && p.y <= high.y && p.z >= low.z;
}

}  // namespace

GroundMap::GroundMap(std::span<const MechanismPtr> systems, int character, double floor)
    : floor_(floor), probe_(collision::make_collider(Shape::sphere(1e-9))) {
  contained_.resize(systems.size());
  for (std::size_t s = 0; s < systems.size(); ++s) {
    const Mechanism& m = *systems[s];
    contained_[s].assign(at(m.link_count()), 0);
    if (static_cast<int>(s) == character) continue;
    std::vector<Pose> X(at(m.link_count()));
    calc_poses(m, m.neutral(), X);
    for (int i = 0; i < m.link_count(); ++i) {
      const Link& link = m.link(i);
      contained_[s][at(i)] = link.joint.nv() == 0 && (link.parent < 0 || contained_[s][at(link.parent)]);
      if (!contained_[s][at(i)]) continue;
      for (const Shape& shape : link.shapes) {
        if (!shape.collides) continue;
        Item item{collision::make_collider(shape), X[at(i)] * shape.X_BS, {}, {}, {}};
        item.inverse = item.X_WS.inverse();
        const Mat3& R = item.X_WS.R;
        const Vec3 centre = item.X_WS * item.collider.centre, half = item.collider.half;
        const auto extent = [&](const Vec3& row) {
          return std::fabs(row.x) * half.x + std::fabs(row.y) * half.y + std::fabs(row.z) * half.z;
        };
        const Vec3 size{extent(R.row(0)), extent(R.row(1)), extent(R.row(2))};
        item.low = centre - size;
        item.high = centre + size;
        items_.push_back(std::move(item));
      }
    }
  }
  std::vector<int> order(items_.size());
  std::iota(order.begin(), order.end(), 0);
  nodes_.reserve(2 * order.size());
  if (!order.empty()) build(order);
}

int GroundMap::build(std::span<int> items) {
  Node node{{infinity, infinity, infinity}, {-infinity, -infinity, -infinity}, -1, -1, -1};
  for (const int i : items) {
    node.low = smaller(node.low, items_[at(i)].low);
    node.high = larger(node.high, items_[at(i)].high);
  }
  if (items.size() == 1) {
    node.item = items[0];
  } else {
    const Vec3 size = node.high - node.low;
    const int axis = size.x >= size.y ? 0 : 1;
    const auto middle = items.begin() + static_cast<std::ptrdiff_t>(items.size() / 2);
    std::nth_element(items.begin(), middle, items.end(), [&](int a, int b) {
      const double u = items_[at(a)].low[axis] + items_[at(a)].high[axis], v = items_[at(b)].low[axis] + items_[at(b)].high[axis];
      return u != v ? u < v : a < b;
    });
    node.left = build(items.first(items.size() / 2));
    node.right = build(items.subspan(items.size() / 2));
  }
  nodes_.push_back(node);
  return static_cast<int>(nodes_.size()) - 1;
}

bool GroundMap::contains(int system, int link) const {
  return system < 0 || (at(system) < contained_.size() && contained_[at(system)][at(link)]);
}

/// Finds the triangle of an upright field in the cell of its grid through which the ray passes.
bool GroundMap::cast_field(const Item& item, const HeightField& field, const Vec3& from, Point& hit) {
  const Vec3 start = item.inverse * from;
  const double u = 0.5 * (start.x / field.half_x + 1) * (field.columns - 1), v = 0.5 * (start.y / field.half_y + 1) * (field.rows - 1);
  if (!(u >= 0 && u <= field.columns - 1 && v >= 0 && v <= field.rows - 1)) return false;
  const int column = std::min(static_cast<int>(u), field.columns - 2), row = std::min(static_cast<int>(v), field.rows - 2);
  const Vec3 a = field.point(column, row), c = field.point(column + 1, row + 1);
  const Vec3 b = u - column >= v - row ? field.point(column + 1, row) : field.point(column, row + 1);
  Vec3 n = normalized(cross(b - a, c - a));
  if (n.z < 0) n = -n;
  const double height = a.z - (n.x * (start.x - a.x) + n.y * (start.y - a.y)) / n.z;
  if (start.z < height) return false;
  hit = {from.z - (start.z - height), item.X_WS.R * n};
  return true;
}

bool GroundMap::cast(const Item& item, const Vec3& from, Point& hit) const {
  if (item.collider.shape.type == ShapeType::box) {
    // Distances along the ray at which it enters and leaves the three pairs of faces.
    const Vec3 start = item.inverse * from, ray = item.inverse.R * Vec3{0, 0, -1}, half = item.collider.shape.half_extents;
    double enter = -infinity, leave = infinity;
    int face = 0;
    for (int k = 0; k < 3; ++k) {
      if (std::fabs(ray[k]) < 1e-12) {
        if (std::fabs(start[k]) > half[k]) return false;
        continue;
      }
      const double middle = -start[k] / ray[k], width = half[k] / std::fabs(ray[k]);
      if (middle - width > enter) enter = middle - width, face = k;
      leave = std::min(leave, middle + width);
    }
    if (enter > leave || enter < 0) return false;
    hit.height = from.z - enter;
    hit.normal = item.X_WS.R.column(face) * (ray[face] > 0 ? -1.0 : 1.0);
    return true;
  }
  if (const HeightField* field = item.collider.shape.field.get(); field != nullptr && item.X_WS.R.column(2).z > 1 - 1e-12)
    return cast_field(item, *field, from, hit);
  // The ray moves by the distance from the shape, so that it never passes the surface (sphere tracing, Hart 1996).
  constexpr int max_steps = 100;
  constexpr double touching = 1e-4;  // m
  Pose X{Mat3::identity(), from};
  collision::PairCache cache;
  for (int step = 0; step < max_steps && X.p.z > item.low.z; ++step) {
    const collision::PairDistance d = find_pair_distance(probe_, X, item.collider, item.X_WS, infinity, cache, workspace_);
    if (d.method == collision::DistanceMethod::none || (step == 0 && d.distance <= 0)) return false;
    if (d.distance <= touching) {
      hit = {X.p.z - std::max(0.0, d.distance), norm(d.n) > 0.5 ? d.n : hit.normal};
      return true;
    }
    hit.normal = d.n;
    X.p.z -= d.distance;
  }
  return false;
}

GroundMap::Point GroundMap::below(const Vec3& from) const {
  Point best{floor_, {0, 0, 1}};
  if (nodes_.empty()) return best;
  std::array<int, 64> stack;  // the tree is balanced, so its depth is below 32
  std::size_t size = 0;
  stack[size++] = static_cast<int>(nodes_.size()) - 1;
  while (size > 0) {
    const Node& node = nodes_[at(stack[--size])];
    if (node.high.z <= best.height || !above(node.low, node.high, from)) continue;
    if (node.item >= 0) {
      Point hit;
      if (cast(items_[at(node.item)], from, hit) && hit.height > best.height) best = hit;
    } else {
      stack[size++] = node.left;
      stack[size++] = node.right;
    }
  }
  return best;
}

}  // namespace ugoki::control
