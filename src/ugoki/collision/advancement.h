#pragma once
// Conservative advancement: when two moving bodies first touch, found from true distances so that nothing fast or thin gets past.
//
// At a time t at which two bodies are d apart along the unit vector n, no point of one can reach the other before they have come d
// closer. How fast they can is bounded by their velocities at t, n (v_b - v_a) + |n x w_a| r_a + |n x w_b| r_b, and by the
// greatest acceleration that any of their points can have until the end of the step. That gives a time until which nothing can
// happen; there the distance is measured anew.
// Sources: Mirtich, Impulse-based dynamic simulation of rigid body systems (1996); Zhang, Lee, Kim, Interactive continuous collision
// detection for non-convex polyhedra (2006); Zhang, Redon, Lee, Kim, Continuous collision detection for articulated models (2007).

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "ugoki/collision/pair_distance.h"
#include "ugoki/collision/scene.h"

namespace ugoki::collision {

struct AdvancementOptions {
  double tolerance = 1e-5;   ///< m: closer than this is touching
  int max_iterations = 500;  ///< distances measured for one pair
};

enum class ImpactStatus : std::uint8_t {
  none,           ///< nothing touches until the end of the step
  impact,         ///< they touch at `time`
  touching,       ///< they touch, or overlap, at the beginning (time 0)
  not_converged,  ///< the bound of iterations was reached: nothing touches before `time`, more is not known
  not_finite,     ///< a pose or velocity is NaN or infinite: nothing is known
};

struct Impact {
  ImpactStatus status = ImpactStatus::none;
  double time = 0;     ///< s from the beginning, never after the true impact; none: the length of the step
  PairDistance near;   ///< at `time`; status none: the last that was measured, perhaps nothing
  int iterations = 0;  ///< distances measured
};

/// A body that turns at a constant angular velocity about the centre of its bound, which moves at a constant velocity.
struct BodyMotion {
  Pose X_WS;  ///< m, world: of the shape at time 0
  Vec3 w;     ///< rad/s, world
  Vec3 v;     ///< m/s, world: of the shape's `centre`

  [[nodiscard]] Pose at(const Vec3& centre, double time) const;
};
/// From one pose to another in `dt`, the shorter way round.
[[nodiscard]] BodyMotion motion_between(const Collider& collider, const Pose& from, const Pose& to, double dt);

/// First time in [0, dt] at which two bodies come closer than the tolerance.
/// No allocation after the workspace has grown.
[[nodiscard]] Impact find_impact(const Collider& a, const BodyMotion& motion_a, const Collider& b, const BodyMotion& motion_b, double dt,
                                 PairCache& cache, DistanceWorkspace& workspace, const AdvancementOptions& options = {});

/// One system of a scene within a step: q(t) = q (+) v t. Spans of the caller's memory.
struct SystemMotion {
  std::span<const double> q, v;
};

struct SceneImpact {
  ImpactStatus status = ImpactStatus::none;  ///< touching does not occur: pairs that touch at the beginning are contacts, and left out
  double time = 0;                           ///< s, never after the true impact; none: the length of the step
  ContactPoint contact;                      ///< who with whom (-1, -1: the ground), where, normal, friction; key 0
  int shape_a = -1, shape_b = -1;            ///< indices into Scene::shapes(); -1: the ground
  int pairs = 0;                             ///< pairs that could meet within the step
  int distances = 0;                         ///< distances measured
};

/// The first impact of a scene within a step, in joint-space motion. Keeps scratch memory: one for each thread.
class ImpactSearch {
 public:
  /// The scene must outlive it.
  explicit ImpactSearch(const Scene& scene, const AdvancementOptions& options = {});

  /// Pairs as in find_contacts. Pairs closer than `margin` at the beginning are left out: they are contacts already, which the contact
  /// solver holds apart; with a smaller margin than that of find_contacts nothing falls between the two.
  /// @param systems [systems of the scene]
  /// @param margin m, at least the tolerance
  /// No allocation, unless the number of pairs grows.
  [[nodiscard]] SceneImpact find(std::span<const SystemMotion> systems, double dt, double margin);

  /// Whether anything gets so deep into anything else within the step that it may come out on the other side: deeper than half of what
  /// both are thick, whatever they were at the beginning. Where no pair moves that far, O(links). The ground, which has no other side, and
  /// pairs that are both not convex are left out; where one is, the core of the other must not reach its surface (core.h).
  /// @return status impact and the time [s] until which nothing was as deep; none, and the length of the step
  [[nodiscard]] SceneImpact find_passage(std::span<const SystemMotion> systems, double dt);

 private:
  /// A shape at a moment.
  struct Moving {
    Pose X_WS;
    Vec3 v, w;         // m/s of the bound's centre, rad/s; world
    double a = 0;      // m/s^2: greatest acceleration of the centre during the step
    double alpha = 0;  // rad/s^2: greatest angular acceleration
  };
  struct LinkBound {
    double w = 0, alpha = 0, a = 0;  // rad/s, rad/s^2, m/s^2 of the frame's origin
  };
  struct System {
    std::vector<double> q;
    std::vector<Pose> X_WB;
    std::vector<Vec6> V;  // in each link's frame
    std::vector<LinkBound> bounds;
    double time = -1;  // s: of X_WB, V
  };
  struct Candidate {
    int a, b;     // shapes; b = -1: the ground
    double time;  // s: nothing happens before
    int iterations = 0;
    PairCache cache;
  };
  struct Sweep {
    Vec3 centre;
    double radius = 0;  // m: holds the shape during the whole step
    double way = 0;     // m: no point of it goes farther
  };

  void prepare(std::size_t system, const SystemMotion& motion, double dt);
  void prepare_all(double dt, double least_way);
  bool passes(Candidate& c, double end, double dt);
  bool core_touches(Candidate& c, double end, double dt);
  void move_to(std::size_t system, double time);
  [[nodiscard]] Moving moving(int shape, double time);
  void find_candidates();
  void add_candidate(int a, int b);
  [[nodiscard]] SceneImpact make_impact(const Candidate& c, const PairDistance& d, ImpactStatus status) const;

  const Scene& scene_;
  AdvancementOptions options_;
  Collider ground_;
  std::span<const SystemMotion> motions_;
  std::vector<System> systems_;
  double least_way_ = 0;                       // m that two shapes must be able to go together to be looked at
  std::vector<Sweep> sweeps_;                  // [shapes]
  std::vector<double> half_width_;             // m [shapes] half of the least distance of two parallel planes that hold it
  std::vector<std::pair<double, int>> order_;  // [shapes] least x of its way, shape
  std::vector<Candidate> candidates_;
  std::vector<std::uint32_t> queue_;  // heap of candidates, the earliest first
  DistanceWorkspace workspace_;
};

}  // namespace ugoki::collision
