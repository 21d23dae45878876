#pragma once
// Scene: the shapes of all mechanisms and the pairs of shapes that can collide, prepared once. find_contacts() finds all contact points
// at given poses.

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "ugoki/collision/contact_manifold.h"
#include "ugoki/collision/contact_point.h"
#include "ugoki/collision/pair_table.h"
#include "ugoki/mechanism/mechanism.h"

namespace ugoki::collision {

/// Options of a scene. A system is one mechanism of the scene.
struct SceneOptions {
  bool with_ground = true;      ///< there is a ground plane
  bool between_systems = true;  ///< shapes of different systems collide
  bool self_collision = false;  ///< initial value of Scene::self_collision(): links of one system collide with each other
};

/// A shape that can collide: its Collider, its link, and its coefficients with the ground.
struct SceneShape : Collider {
  int system = 0, link = 0;                            ///< indices of its system in the scene and of its link in the mechanism
  bool movable = true;                                 ///< false: only fixed joints are between the shape and the world
  double ground_friction = 0, ground_restitution = 0;  ///< combined coefficients of this shape and the ground
};

/// What the first tests of a shape need. A scene has these data in an array of their own, because a SceneShape occupies five times as much
/// of the processor's cache.
struct ShapeOutline {
  Vec3 centre;   ///< m, link's frame: centre of the bounding sphere
  double bound;  ///< m: radius of the bounding sphere
  Vec3 origin;   ///< m, link's frame: origin of the shape's frame
  double reach;  ///< m: Collider::reach
  std::int32_t link;
  bool movable;  ///< SceneShape::movable
};

/// Two shapes, indices into Scene::shapes().
struct ShapePair {
  std::int32_t a, b;
};

/// The shapes of several systems (mechanisms) and the ground. Immutable except for the self-collision switch of each system.
class Scene {
 public:
  Scene() = default;
  /// Takes all shapes of all mechanisms for which Shape::collides is true. Two shapes of one mechanism can collide unless one of these is
  /// true:
  ///   - their links are the same body (welded by fixed joints, or a virtual link and its real link);
  ///   - a joint or a loop joint connects their bodies;
  ///   - their groups do not collide (can_collide()), or Mechanism::exclusions() contains their links;
  ///   - their joints are attached to the same body at the same point (to 1e-6 m);
  ///   - the shapes overlap or touch (distance <= 1e-9 m) in the neutral position.
  /// Shapes that are not movable collide neither with the ground nor with each other. O(shapes^2) for each mechanism.
  explicit Scene(std::vector<MechanismPtr> systems, const Ground& ground = {}, const SceneOptions& options = {});

  [[nodiscard]] std::span<const MechanismPtr> systems() const { return systems_; }
  [[nodiscard]] const Ground& ground() const { return ground_; }
  [[nodiscard]] const SceneOptions& options() const { return options_; }
  [[nodiscard]] std::span<const SceneShape> shapes() const { return shapes_; }
  /// [shapes] outlines of shapes(), in the same order.
  [[nodiscard]] std::span<const ShapeOutline> outlines() const { return outlines_; }
  /// The shapes of system s are shapes()[first_shape(s)] ... shapes()[first_shape(s + 1) - 1].
  [[nodiscard]] int first_shape(int system) const { return first_shape_[static_cast<std::size_t>(system)]; }
  /// The pairs inside a system that can collide while its self-collision is on.
  [[nodiscard]] std::span<const ShapePair> self_pairs(int system) const { return self_pairs_[static_cast<std::size_t>(system)]; }
  [[nodiscard]] bool self_collision(int system) const { return self_on_[static_cast<std::size_t>(system)] != 0; }
  /// Switches collisions between the links of one system on or off.
  void set_self_collision(int system, bool on) { self_on_[static_cast<std::size_t>(system)] = on ? 1 : 0; }
  /// Hash of the shapes and the self-pairs. The warm starts and near pairs in a Workspace are valid for every scene with the same hash.
  [[nodiscard]] std::uint64_t content() const { return content_; }

 private:
  std::vector<MechanismPtr> systems_;
  Ground ground_;
  SceneOptions options_;
  std::vector<SceneShape> shapes_;
  std::vector<ShapeOutline> outlines_;              // [shapes]
  std::vector<int> first_shape_;                    // [systems + 1] see first_shape()
  std::vector<std::vector<ShapePair>> self_pairs_;  // [systems] see self_pairs()
  std::vector<std::uint8_t> self_on_;               // [systems] 1: self-collision is on
  std::uint64_t content_ = 0;
};

class BroadPhase;

/// Scratch memory and warm starts of find_contacts(); one for each thread. Any scene may use it; the memory grows to the needs of the
/// largest scene.
struct Workspace {
  /// Bounding sphere.
  struct Ball {
    Vec3 c;    ///< m, world
    double r;  ///< m
  };
  /// Axis-aligned box.
  struct Extent {
    Vec3 low, high;  ///< m, world
  };
  /// The self-pairs of one system whose bounding spheres were near at the centres `at`; see near_self_pairs.h.
  struct NearPairs {
    std::vector<Vec3> at;  ///< [shapes of the system] m, world; empty: no pairs known
    std::vector<ShapePair> pairs;
    double margin = 0;  ///< m: margin for which the pairs hold
  };
  std::vector<Ball> balls;           ///< [shapes] bounding spheres
  std::vector<Pose> poses;           ///< [shapes] X_WS, where posed[shape] == call
  std::vector<std::uint64_t> posed;  ///< [shapes] call of find_contacts() that computed poses[shape]
  std::uint64_t call = 0;            ///< number of the present call of find_contacts()
  std::vector<NearPairs> near_self;  ///< [systems]
  std::vector<Extent> extents;       ///< [systems] boxes that contain all bounding spheres of a system
  std::vector<ShapePair> near;       ///< candidate pairs from the broad phase
  PairTable pairs;                   ///< warm start of each pair of convex shapes
  std::vector<std::int32_t> lowest;  ///< [shapes] index of the hull vertex that was nearest to the ground; start of the next search
  std::uint64_t content = 0;         ///< Scene::content() of the scene to which `pairs` and `lowest` belong
  ManifoldWorkspace manifold;
  std::unique_ptr<BroadPhase> broad_phase;  ///< created for scenes with many possible pairs

  Workspace();
  explicit Workspace(const Scene& scene);
  Workspace(Workspace&&) noexcept;
  Workspace& operator=(Workspace&&) noexcept;
  ~Workspace();
  /// Resets all warm starts; keeps the memory. Warm starts change the last bits of distances. Call forget() after a state was restored, if
  /// the simulation must repeat bit by bit.
  void forget();
};

/// Sets the warm starts of pairs of convex shapes from `contacts`, which were found at the poses X_WB: the normal of the first contact of
/// each pair. A following find_contacts() with a negative margin then usually need not compute the depth of pairs that have hardly moved.
/// @param X_WB [systems][links] m, world
void begin_from(const Scene& scene, std::span<const std::span<const Pose>> X_WB, std::span<const ContactPoint> contacts,
                Workspace& workspace);

/// Finds all contact points with a distance below `margin`, in an order that depends only on the scene: ground contacts by shape, then
/// pairs inside each system, then pairs between systems.
///
/// Count of points for each pair of shapes:
/// - sphere or ellipsoid with any convex shape: 1;
/// - capsule with ground, capsule or box: up to 2;
/// - box with ground: every corner within the margin;
/// - other convex shapes: up to 4 with each other, up to 6 with the ground;
/// - pairs with a non-convex shape: up to 16.
/// The minimum distance over the points of a pair is the true distance between the two shapes, if this distance is below the margin. For
/// overlapping boxes, cylinders and meshes the minimum is accurate to 1e-4 of the smallest half extent, because faces are preferred to
/// edges. For surfaces of triangles that pierce each other, see surface_manifold.h. Shapes at poses that are not finite have no contacts.
///
/// Scenes with few possible pairs test all pairs; larger scenes (crowds, mechanisms with hundreds of links) get candidate pairs from the
/// superior tree (broad_phase.h). Both methods give the same contacts. No allocation after the first calls with the same workspace and
/// `out`, unless new pairs come near or the count of contacts grows.
/// @param X_WB [systems][links] m, world
/// @param margin m, may be negative
/// @param out cleared and filled; keeps its memory
/// @param moved [systems] not 0: the system has moved. Only pairs with a moved system are tested, also with the ground; empty: all pairs
void find_contacts(const Scene& scene, std::span<const std::span<const Pose>> X_WB, double margin, Workspace& workspace,
                   std::vector<ContactPoint>& out, std::span<const char> moved = {});

}  // namespace ugoki::collision
