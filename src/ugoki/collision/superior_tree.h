#pragma once
// The superior tree: a hierarchy of boxes over the links of groups of links, with what is needed to carry bounds of distances from
// step to step.
//
// Each node (a link, or links together) adds up how far its points can have moved since the beginning. A lower bound of the
// distance of two nodes, found once, then holds for all later steps: less what both have moved since (pair_front.h). Boxes are
// made anew only where somebody asks for them.
// Sources: Nagashima (1999) section 6.2; Mirtich, Timewarp rigid body simulation (2000): bounds from motion; Li, Chen (1998): fronts.

#include <cstdint>
#include <span>
#include <vector>

#include "ugoki/collision/collider.h"

namespace ugoki::collision {

/// A link, or one shape of it, as the tree sees it.
struct TreeBody {
  Vec3 centre;        ///< m, of the box, in the body's frame
  Vec3 half_extents;  ///< m, along the axes of the body's frame: the box holds the body
  double radius = 0;  ///< m, of a sphere about `centre` that holds the body
  int group = 0;      ///< 0, 1, ...: the links of one figure, for example
};

/// Of a shape, in the frame of the SHAPE: the tree then wants X_WB * shape.X_BS. O(vertices) for meshes.
[[nodiscard]] TreeBody make_tree_body(const Collider& collider, int group);

/// Nodes: 0 ... bodies - 1 are the bodies themselves, the others hold two nodes each.
class SuperiorTree {
 public:
  struct Box {
    Vec3 low, high;  ///< m, world; low above high: nothing
  };

  SuperiorTree() = default;
  explicit SuperiorTree(std::span<const TreeBody> bodies);

  /// The bodies are now at these poses. Bodies at poses that are not finite are left out until they are finite again.
  /// O(bodies); no allocation.
  /// @param X_WB [bodies] m, world
  void update(std::span<const Pose> X_WB);

  [[nodiscard]] int bodies() const { return static_cast<int>(bodies_.size()); }
  [[nodiscard]] int groups() const { return static_cast<int>(group_root_.size()); }
  [[nodiscard]] int group_of(int body) const { return bodies_[static_cast<std::size_t>(body)].group; }
  /// Node over all bodies of a group; -1 where it has none.
  [[nodiscard]] int group_root(int group) const { return group_root_[static_cast<std::size_t>(group)]; }
  /// Node over everything; -1 without bodies.
  [[nodiscard]] int root() const { return root_; }
  [[nodiscard]] bool is_body(int node) const { return node < bodies(); }
  [[nodiscard]] int left(int node) const { return children_[static_cast<std::size_t>(node - bodies())].left; }
  [[nodiscard]] int right(int node) const { return children_[static_cast<std::size_t>(node - bodies())].right; }
  /// The one group to which all of the node's bodies belong, or -1.
  [[nodiscard]] int group_of_node(int node) const { return node_group_[static_cast<std::size_t>(node)]; }

  /// m, [nodes]: no point of a node has moved more between two moments than the difference of this.
  [[nodiscard]] const double* travel() const { return travel_.data(); }
  /// m: no point of the node has moved more in the last update.
  [[nodiscard]] double last_travel(int node) const { return step_[static_cast<std::size_t>(node)]; }
  /// Box of a node at the present poses. Made on demand: O(1) where it was asked for before, at most O(bodies in it).
  [[nodiscard]] const Box& box(int node) {
    if (box_made_[static_cast<std::size_t>(node)] != updates_) make_box(node);
    return boxes_[static_cast<std::size_t>(node)];
  }
  /// Changes when bounds that were found before do not hold any longer.
  [[nodiscard]] std::uint32_t epoch() const { return epoch_; }
  /// Changes when nodes hold other bodies than before (bounds of two bodies still hold).
  [[nodiscard]] std::uint32_t topology() const { return topology_; }
  /// m: how far bounds may be off by rounding.
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
  std::vector<Pose> poses_;            // [bodies] of the last update; where that was not finite, of the last that was
  std::vector<double> reaches_;        // [bodies] m, from the frame's origin, no less than it is
  std::vector<std::uint8_t> present_;  // [bodies] the pose is finite
  std::vector<Children> children_;     // [bodies - 1], a node before its children
  std::vector<double> travel_, step_;  // [nodes]
  std::vector<Box> boxes_;             // [nodes]
  std::vector<std::uint64_t> box_made_;
  std::vector<int> node_group_;
  std::vector<int> group_root_;
  std::vector<Item> items_, roots_;  // scratch of make_topology
  int root_ = -1, made_ = 0;
  std::uint64_t updates_ = 0;
  std::uint32_t epoch_ = 0, topology_ = 0;
  double slack_ = 0, size_when_made_ = 0;
};

/// Lower bound [m] of the signed distance of what two boxes hold: their distance, or where they overlap minus the least overlap.
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
