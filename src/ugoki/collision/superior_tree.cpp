#include "ugoki/collision/superior_tree.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "ugoki/base/check.h"

namespace ugoki::collision {
namespace {

constexpr std::uint64_t updates_between_checks = 64;  // count of updates between two checks of the total size of the boxes
constexpr double rebuild_growth = 1.5;                // the hierarchy is rebuilt when the total size of the boxes has grown by this factor
constexpr double max_travel = 1e5;                    // m: limit at which update() resets travel to 0, to keep its rounding error small
constexpr double rounding = 4e-15;                    // rounding error relative to the coordinates: about 18 units of 2^-52

double sum_of_magnitudes(const Vec3& v) { return std::fabs(v.x) + std::fabs(v.y) + std::fabs(v.z); }

/// Upper bound [m] of the motion of a body's points between two poses. Not finite if a pose is not finite.
/// A rotation from R to R' by the angle t moves points of a sphere by at most 2 sin(t/2) radius. The Frobenius norm |R - R'| is
/// 2 sqrt(2) sin(t/2).
double bound_of_motion(const TreeBody& body, const Pose& from, const Pose& to) {
  const Mat3 D{to.R.xx - from.R.xx, to.R.xy - from.R.xy, to.R.xz - from.R.xz, to.R.yx - from.R.yx, to.R.yy - from.R.yy,
               to.R.yz - from.R.yz, to.R.zx - from.R.zx, to.R.zy - from.R.zy, to.R.zz - from.R.zz};
  const Vec3 centre = D * body.centre + (to.p - from.p), x = D.row(0), y = D.row(1), z = D.row(2);
  return std::sqrt(dot(centre, centre)) + std::sqrt(0.5 * (dot(x, x) + dot(y, y) + dot(z, z))) * body.radius;
}

double half_perimeter(const SuperiorTree::Box& b) {
  const Vec3 d = b.high - b.low;
  return d.x + d.y + d.z;
}

}  // namespace

TreeBody make_tree_body(const Collider& collider, int group) {
  const Bounds b = bounds(collider.shape);
  return {(b.low + b.high) * 0.5, (b.high - b.low) * 0.5, collider.bound, group};
}

SuperiorTree::SuperiorTree(std::span<const TreeBody> bodies) : bodies_(bodies.begin(), bodies.end()) {
  int last_group = -1;
  for (const TreeBody& b : bodies_) {
    UGOKI_CHECK(b.group >= 0);
    last_group = std::max(last_group, b.group);
  }
  const std::size_t count = bodies_.size(), nodes = count == 0 ? 0 : 2 * count - 1;
  poses_.resize(count);
  for (const TreeBody& b : bodies_) reaches_.push_back(sum_of_magnitudes(b.centre) + b.radius);
  present_.assign(count, 1);
  children_.resize(count == 0 ? 0 : count - 1);
  travel_.resize(nodes);
  step_.resize(nodes);
  boxes_.resize(nodes);
  box_made_.resize(nodes);
  node_group_.resize(nodes);
  group_root_.resize(static_cast<std::size_t>(last_group + 1), -1);
  items_.reserve(count);
  roots_.reserve(group_root_.size());
}

void SuperiorTree::update(std::span<const Pose> X_WB) {
  UGOKI_CHECK(X_WB.size() == bodies_.size());
  const std::size_t count = bodies_.size();
  if (count == 0) return;
  ++updates_;
  for (std::size_t i = 0; i < count; ++i) step_[i] = bound_of_motion(bodies_[i], poses_[i], X_WB[i]);
  bool bounds_valid = true;
  double farthest = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const bool present = step_[i] < std::numeric_limits<double>::infinity();
    bounds_valid = bounds_valid && present == (present_[i] != 0);
    present_[i] = present ? 1 : 0;
    if (!present) {
      step_[i] = 0;
      continue;
    }
    poses_[i] = X_WB[i];
    const double away = sum_of_magnitudes(X_WB[i].p) + reaches_[i];
    const double moved = step_[i] > 0 ? step_[i] + rounding * away : 0;
    const double travel = travel_[i] + moved;
    step_[i] = moved;
    travel_[i] = travel;
    farthest = std::max(farthest, away + travel);
  }
  slack_ = rounding * farthest;
  if (farthest > 2 * max_travel) {
    double maximum = 0;
    for (std::size_t i = 0; i < count; ++i) maximum = std::max(maximum, travel_[i]);
    if (maximum > max_travel) {
      std::ranges::fill(travel_, 0.0);
      bounds_valid = false;
    }
  }
  if (!bounds_valid) ++epoch_;
  const bool check = updates_ == 1 || updates_ % updates_between_checks == 0;
  if (updates_ == 1 || !bounds_valid || (check && total_size() > rebuild_growth * size_when_made_)) {
    make_topology();
  } else {
    for (std::size_t i = count - 1; i-- > 0;) {
      const Children& c = children_[i];
      const double moved = std::max(step_[static_cast<std::size_t>(c.left)], step_[static_cast<std::size_t>(c.right)]);
      step_[count + i] = moved;
      travel_[count + i] += moved;
    }
  }
}

void SuperiorTree::make_box(int node) {
  const auto k = static_cast<std::size_t>(node);
  box_made_[k] = updates_;
  Box& out = boxes_[k];
  if (is_body(node)) {
    const TreeBody& b = bodies_[k];
    const Mat3& R = poses_[k].R;
    const Vec3 centre = poses_[k] * b.centre;
    const Vec3& e = b.half_extents;
    const auto along = [&](const Vec3& row) { return std::fabs(row.x) * e.x + std::fabs(row.y) * e.y + std::fabs(row.z) * e.z; };
    Vec3 half{along(R.row(0)), along(R.row(1)), along(R.row(2))};
    for (int i = 0; i < 3; ++i) half[i] = std::min(half[i], b.radius);
    constexpr double infinity = std::numeric_limits<double>::infinity();
    if (present_[k] == 0)
      out = {{infinity, infinity, infinity}, {-infinity, -infinity, -infinity}};
    else
      out = {centre - half, centre + half};
    return;
  }
  const Box l = box(left(node)), r = box(right(node));
  for (int i = 0; i < 3; ++i) {
    out.low[i] = std::min(l.low[i], r.low[i]);
    out.high[i] = std::max(l.high[i], r.high[i]);
  }
}

/// Splits the items at the median along the axis of the largest spread of their centres; ties are broken by node index. @return the node
/// over all items
int SuperiorTree::make_subtree(std::span<Item> items, int group) {
  if (items.size() == 1) return items[0].node;
  Vec3 low = items[0].centre, high = low;
  for (const Item& item : items) {
    for (int i = 0; i < 3; ++i) {
      low[i] = std::min(low[i], item.centre[i]);
      high[i] = std::max(high[i], item.centre[i]);
    }
  }
  const Vec3 d = high - low;
  const int axis = d.x >= d.y && d.x >= d.z ? 0 : d.y >= d.z ? 1 : 2;
  const std::size_t half = items.size() / 2;
  std::nth_element(items.begin(), items.begin() + static_cast<std::ptrdiff_t>(half), items.end(), [axis](const Item& a, const Item& b) {
    return a.centre[axis] != b.centre[axis] ? a.centre[axis] < b.centre[axis] : a.node < b.node;
  });
  const int index = made_++;
  const int l = make_subtree(items.first(half), group), r = make_subtree(items.subspan(half), group);
  children_[static_cast<std::size_t>(index)] = {l, r};
  node_group_[static_cast<std::size_t>(bodies() + index)] = group;
  return bodies() + index;
}

void SuperiorTree::make_topology() {
  ++topology_;
  std::ranges::fill(box_made_, 0);
  std::fill(travel_.begin() + bodies(), travel_.end(), 0.0);
  std::fill(step_.begin() + bodies(), step_.end(), 0.0);
  // The bodies are sorted by group, then by index.
  items_.clear();
  for (int i = 0; i < bodies(); ++i) {
    const auto k = static_cast<std::size_t>(i);
    items_.push_back({i, poses_[k] * bodies_[k].centre});
    node_group_[k] = bodies_[k].group;
  }
  std::ranges::sort(items_, [&](const Item& a, const Item& b) {
    const int ga = group_of(a.node), gb = group_of(b.node);
    return ga != gb ? ga < gb : a.node < b.node;
  });
  // Parents must be before their children. The nodes above the groups take the first indices, so the groups are counted first.
  std::size_t with_bodies = 0;
  for (std::size_t first = 0, last = 0; first < items_.size(); first = last, ++with_bodies)
    while (last < items_.size() && group_of(items_[last].node) == group_of(items_[first].node)) ++last;
  made_ = static_cast<int>(with_bodies) - 1;
  roots_.clear();
  for (std::size_t first = 0, last = 0; first < items_.size(); first = last) {
    const int group = group_of(items_[first].node);
    while (last < items_.size() && group_of(items_[last].node) == group) ++last;
    const int node = make_subtree(std::span(items_).subspan(first, last - first), group);
    group_root_[static_cast<std::size_t>(group)] = node;
    const Box& b = box(node);
    const Vec3 centre = (b.low + b.high) * 0.5;
    roots_.push_back({node, is_finite(centre) ? centre : Vec3{}});
  }
  made_ = 0;
  root_ = make_subtree(roots_, with_bodies == 1 ? node_group_[static_cast<std::size_t>(roots_[0].node)] : -1);
  size_when_made_ = total_size();
}

double SuperiorTree::total_size() {
  double sum = 0;
  for (std::size_t i = 0; i < children_.size(); ++i) {
    const double size = half_perimeter(box(bodies() + static_cast<int>(i)));
    if (size > 0) sum += size;
  }
  return sum;
}

}  // namespace ugoki::collision
