#pragma once
// The superior tree: a hierarchy of boxes over groups of links. It also bounds the motion of its nodes, so that bounds of distances stay
// usable in later steps.
//
// Each node (one link, or several) accumulates an upper bound of the motion of its points, called travel. A lower bound of the distance
// between two nodes, computed once, remains valid in all later steps after the travel of both nodes since then is subtracted (PairFront in
// pair_queries.h). Boxes are recomputed only on demand.
// Sources: Nagashima (1999) section 6.2; Mirtich, Timewarp rigid body simulation (2000): bounds from motion; Li, Chen (1998): fronts.

#include <cstdint>
#include <span>
#include <vector>

#include "ugoki/collision/collider.h"

namespace ugoki::collision {

/// Bounds of one body of the tree: a link, or one shape of a link.
struct TreeBody {
  Vec3 centre;        ///< m, body's frame: centre of the box
  Vec3 half_extents;  ///< m, along the axes of the body's frame: the box contains the body
  double radius = 0;  ///< m: radius of a sphere about `centre` that contains the body
  int group = 0;      ///< index of its group: 0, 1, ...; for example, the links of each character form one group
};

/// Bounds of a shape in the frame of the SHAPE: SuperiorTree::update() must then get X_WB * shape.X_BS. O(vertices) for meshes.
[[nodiscard]] TreeBody make_tree_body(const Collider& collider, int group);

/// Binary tree over bodies. Nodes 0 ... bodies() - 1 are the bodies themselves; every other node has two children.
class SuperiorTree {
 public:
  /// Axis-aligned box.
  struct Box {
    Vec3 low, high;  ///< m, world; low above high: empty
  };

  SuperiorTree() = default;
  explicit SuperiorTree(std::span<const TreeBody> bodies);

  /// Moves the bodies to the given poses. A body whose pose is not finite is excluded until its pose is finite again.
  /// O(bodies), O(bodies log bodies) when the hierarchy is rebuilt; no allocation.
  /// @param X_WB [bodies] m, world
  void update(std::span<const Pose> X_WB);

  [[nodiscard]] int bodies() const { return static_cast<int>(bodies_.size()); }
  [[nodiscard]] int groups() const { return static_cast<int>(group_root_.size()); }
  [[nodiscard]] int group_of(int body) const { return bodies_[static_cast<std::size_t>(body)].group; }
  /// Index of the node that contains all bodies of a group; -1 if the group has no bodies.
  [[nodiscard]] int group_root(int group) const { return group_root_[static_cast<std::size_t>(group)]; }
  /// Index of the node that contains all bodies; -1 if the tree has no bodies.
  [[nodiscard]] int root() const { return root_; }
  [[nodiscard]] bool is_body(int node) const { return node < bodies(); }
  [[nodiscard]] int left(int node) const { return children_[static_cast<std::size_t>(node - bodies())].left; }
  [[nodiscard]] int right(int node) const { return children_[static_cast<std::size_t>(node - bodies())].right; }
  /// Index of the group of all bodies of the node; -1 if the bodies belong to more than one group.
  [[nodiscard]] int group_of_node(int node) const { return node_group_[static_cast<std::size_t>(node)]; }

  /// [nodes] m: accumulated bound of motion. Between two times no point of a node moves farther than the node's travel grows.
  [[nodiscard]] const double* travel() const { return travel_.data(); }
  /// m: upper bound of the motion of the node's points in the last update.
  [[nodiscard]] double last_travel(int node) const { return step_[static_cast<std::size_t>(node)]; }
  /// Box of a node at the present poses. Computed at the first call after an update, O(bodies in the node); later calls O(1).
  [[nodiscard]] const Box& box(int node) {
    if (box_made_[static_cast<std::size_t>(node)] != updates_) make_box(node);
    return boxes_[static_cast<std::size_t>(node)];
  }
  /// Counter that changes when lower bounds of distances from earlier steps are no longer valid.
  [[nodiscard]] std::uint32_t epoch() const { return epoch_; }
  /// Counter that changes when the hierarchy is rebuilt. Bounds of pairs of bodies remain valid, bounds of other pairs of nodes do not.
  [[nodiscard]] std::uint32_t topology() const { return topology_; }
  /// Upper bound [m] of the rounding error in the bounds of distances.
  [[nodiscard]] double slack() const { return slack_; }

 private:
  struct Children {
    int left, right;
  };
  struct Item {
    int node;
    Vec3 centre;
  };
  void make_box(int node);
  void make_topology();
  int make_subtree(std::span<Item> items, int group);
  [[nodiscard]] double total_size();

  std::vector<TreeBody> bodies_;
  std::vector<Pose> poses_;              // [bodies] last finite pose
  std::vector<double> reaches_;          // [bodies] m: upper bound of the distance of a body's points from the origin of its frame
  std::vector<std::uint8_t> present_;    // [bodies] 1: the pose is finite
  std::vector<Children> children_;       // [bodies - 1] entry i: children of node bodies + i; parents are before their children
  std::vector<double> travel_, step_;    // [nodes] m: travel(), last_travel()
  std::vector<Box> boxes_;               // [nodes] result of box(); valid if box_made_ equals updates_
  std::vector<std::uint64_t> box_made_;  // [nodes] value of updates_ when the box was computed
  std::vector<int> node_group_;          // [nodes] group_of_node()
  std::vector<int> group_root_;          // [groups] result of group_root()
  std::vector<Item> items_, roots_;      // scratch of make_topology()
  int root_ = -1, made_ = 0;             // made_: next free index into children_
  std::uint64_t updates_ = 0;
  std::uint32_t epoch_ = 0, topology_ = 0;
  double slack_ = 0, size_when_made_ = 0;
};

/// Lower bound [m] of the signed distance between two bodies, from the boxes that contain them: the distance between the boxes or, if the
/// boxes overlap, minus the minimum overlap over the three axes.
[[nodiscard]] inline double box_distance(const SuperiorTree::Box& a, const SuperiorTree::Box& b) {
  const auto gap = [](double low_a, double high_a, double low_b, double high_b) {
    const double x = low_a - high_b, y = low_b - high_a;
    return x > y ? x : y;
  };
  const double x = gap(a.low.x, a.high.x, b.low.x, b.high.x), y = gap(a.low.y, a.high.y, b.low.y, b.high.y),
               z = gap(a.low.z, a.high.z, b.low.z, b.high.z);
  if (x <= 0 && y <= 0 && z <= 0) return x > y ? (x > z ? x : z) : (y > z ? y : z);
  const double px = x > 0 ? x : 0, py = y > 0 ? y : 0, pz = z > 0 ? z : 0;
  return std::sqrt(px * px + py * py + pz * pz);
}

}  // namespace ugoki::collision
