#pragma once
// Which shapes can collide with which, prepared once; and the search for all contact points of a moment.

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "ugoki/collision/contact_manifold.h"
#include "ugoki/collision/contact_point.h"
#include "ugoki/collision/pair_table.h"
#include "ugoki/mechanism/mechanism.h"

namespace ugoki::collision {

struct SceneOptions {
  bool with_ground = true;      ///< there is a ground plane
  bool between_systems = true;  ///< shapes of different mechanisms collide
  bool self_collision = false;  ///< links of one mechanism collide, at the start; see Scene::set_self_collision
};

/// A shape that collides, as it runs.
struct SceneShape : Collider {
  int system = 0, link = 0;
  bool movable = true;                                 ///< false: no joint between it and the world moves
  double ground_friction = 0, ground_restitution = 0;  ///< of the pair with the ground
};

/// Two shapes, indices into Scene::shapes().
struct ShapePair {
  std::int32_t a, b;
};

/// Immutable but for the self-collision switches.
class Scene {
 public:
  Scene() = default;
  /// Takes every shape with `collides` of every mechanism. Shapes of one mechanism can collide unless their links are
  /// the same body (welded by fixed joints, or a virtual link and its real link), are joined by one joint, hang with
  /// coinciding joints on the same link, or the two shapes overlap in the neutral position. Shapes that nothing moves
  /// collide neither with the ground nor with each other. O(shapes^2) for each mechanism.
  explicit Scene(std::vector<MechanismPtr> systems, const Ground& ground = {}, const SceneOptions& options = {});

  [[nodiscard]] std::span<const MechanismPtr> systems() const { return systems_; }
  [[nodiscard]] const Ground& ground() const { return ground_; }
  [[nodiscard]] const SceneOptions& options() const { return options_; }
  [[nodiscard]] std::span<const SceneShape> shapes() const { return shapes_; }
  /// Shapes of system s are shapes()[first_shape(s)] ... shapes()[first_shape(s + 1) - 1].
  [[nodiscard]] int first_shape(int system) const { return first_shape_[static_cast<std::size_t>(system)]; }
  /// The pairs inside system s that can collide, whether its switch is on or not.
  [[nodiscard]] std::span<const ShapePair> self_pairs(int system) const { return self_pairs_[static_cast<std::size_t>(system)]; }
  [[nodiscard]] bool self_collision(int system) const { return self_on_[static_cast<std::size_t>(system)] != 0; }
  void set_self_collision(int system, bool on) { self_on_[static_cast<std::size_t>(system)] = on ? 1 : 0; }
  /// Of the shapes: where it is the same, what a Workspace remembers of pairs fits.
  [[nodiscard]] std::uint64_t content() const { return content_; }

 private:
  std::vector<MechanismPtr> systems_;
  Ground ground_;
  SceneOptions options_;
  std::vector<SceneShape> shapes_;
  std::vector<int> first_shape_;                    // [systems + 1]
  std::vector<std::vector<ShapePair>> self_pairs_;  // [systems]
  std::vector<std::uint8_t> self_on_;               // [systems]
  std::uint64_t content_ = 0;
};

class BroadPhase;

/// Scratch memory of find_contacts; one for each thread. Any scene may use it; it grows to the largest.
struct Workspace {
  struct Ball {
    Vec3 c;
    double r;
  };
  struct Extent {
    Vec3 low, high;
  };
  std::vector<Ball> balls;           ///< [shapes] bounding spheres in the world
  std::vector<Pose> poses;           ///< [shapes] X_WS
  std::vector<Extent> extents;       ///< [systems] boxes along the world's axes that hold all balls of a system
  std::vector<ShapePair> near;       ///< those looked at, of a crowd
  PairTable pairs;                   ///< by pair of shapes: where the last search ended
  std::vector<std::int32_t> lowest;  ///< [shapes] vertex of the hull that was nearest to the ground
  std::uint64_t content = 0;         ///< of the scene to which `pairs` and `lowest` belong
  ManifoldWorkspace manifold;
  std::unique_ptr<BroadPhase> broad_phase;  ///< made where many shapes can meet

  Workspace();
  explicit Workspace(const Scene& scene);
  Workspace(Workspace&&) noexcept;
  Workspace& operator=(Workspace&&) noexcept;
  ~Workspace();
  /// As if nothing had been searched before; keeps its memory. Warm starts change the last bits of distances: who must get the
  /// same bits after going back in time forgets.
  void forget();
};

/// Where the next search of pairs of convex shapes begins: the normals of their contacts at these poses, the first of each pair. Spares
/// find_contacts with a negative margin the depth of what has hardly moved.
void begin_from(const Scene& scene, std::span<const std::span<const Pose>> X_WB, std::span<const ContactPoint> contacts,
                Workspace& workspace);

/// All contact points with a distance below `margin`, in an order that depends only on the scene: ground contacts by
/// shape, pairs inside each system, pairs between systems.
///   points of a pair: sphere or ellipsoid with anything convex 1; capsule with ground, capsule or box up to 2; box with ground
///   every corner within the margin; other convex shapes with each other up to 4; with the ground up to 6; what is not
///   convex up to 16.
/// The least distance of a pair is the true distance between the two shapes (boxes that overlap, cylinders and meshes: to 1e-4 of
/// the least half extent, because faces are preferred to edges), unless it is above the margin. Surfaces of triangles that
/// pierce each other: see surface_manifold.h.
/// Shapes at poses that are not finite have no contacts.
/// @param X_WB [systems][links] m, world
/// @param margin m, may be negative
/// @param moved [systems] only pairs of which one system has moved (not 0), with each other and with the ground; empty: all
/// @param out cleared and filled; keeps its memory
/// Two figures' pairs are gone through, those of a crowd, or of a mechanism of hundreds of links, come from the superior tree
/// (broad_phase.h): the contacts are the same.
/// No allocation after the first calls with the same workspace and out, unless pairs come near that were not, or contacts grow in
/// number.
void find_contacts(const Scene& scene, std::span<const std::span<const Pose>> X_WB, double margin, Workspace& workspace,
                   std::vector<ContactPoint>& out, std::span<const char> moved = {});

}  // namespace ugoki::collision
