#pragma once
// Map of the ground: the floor and all immovable shapes of other mechanisms. A character sees steps and slopes ahead in this map.

#include <span>
#include <vector>

#include "ugoki/collision/collider.h"
#include "ugoki/collision/pair_distance.h"
#include "ugoki/mechanism/mechanism.h"

namespace ugoki::control {

/// Heights of the ground. Shapes that can move are not in the map.
class GroundMap {
 public:
  /// A level floor. @param floor m: its height
  explicit GroundMap(double floor = 0) : floor_(floor) {}
  /// The floor, and the shapes of `systems` that only fixed joints connect to the world. O(shapes log shapes).
  /// @param character index of the system that stands on the ground; its own shapes are left out @param floor m
  GroundMap(std::span<const MechanismPtr> systems, int character, double floor);

  /// A point of the ground.
  struct Point {
    double height = 0;     ///< m, world
    Vec3 normal{0, 0, 1};  ///< unit, world
  };
  /// Highest surface below the point `from` [m, world]: the hit of a ray downwards. A shape that contains `from` is ignored.
  /// O(log shapes) if few shapes are above each other; no allocation for boxes.
  [[nodiscard]] Point below(const Vec3& from) const;
  /// True if the shapes of this link are in the map. A negative system is the floor.
  [[nodiscard]] bool contains(int system, int link) const;

 private:
  struct Item {
    collision::Collider collider;
    Pose X_WS, inverse;
    Vec3 low, high;  // m, world: box around the shape
  };
  /// Node of a tree of boxes. A leaf has one item.
  struct Node {
    Vec3 low, high;             // m, world
    int left = -1, right = -1;  // nodes; -1: this node is a leaf
    int item = -1;
  };
  int build(std::span<int> items);
  /// Casts a ray downwards to one shape. @return false: no hit
  bool cast(const Item& item, const Vec3& from, Point& hit) const;
  static bool cast_field(const Item& item, const HeightField& field, const Vec3& from, Point& hit);

  double floor_ = 0;
  std::vector<Item> items_;
  std::vector<Node> nodes_;                   // the root is the last one
  std::vector<std::vector<char>> contained_;  // [systems][links] 1: in the map
  collision::Collider probe_;                 // a point
  mutable collision::DistanceWorkspace workspace_;
};

}  // namespace ugoki::control
