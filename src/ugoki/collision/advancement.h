#pragma once
// Conservative advancement: finds the time at which two moving bodies first touch, from their true distances. No impact of a fast or
// thin body is missed.
//
// At time t the distance between bodies a and b is d, along the unit vector n from b towards a. They cannot touch before they have
// approached each other by d. Their approach speed at t is at most n . (v_b - v_a) + |n x w_a| r_a + |n x w_b| r_b. For each body, v is the
// velocity of its centre, w its angular velocity, and r the maximum distance of its points from its centre. The maximum acceleration of the
// points bounds the growth of the approach speed until the end of the step. These two bounds give a time before which the bodies cannot
// touch. The search advances to that time and measures the distance again.
// Sources: Mirtich, Impulse-based dynamic simulation of rigid body systems (1996); Zhang, Lee, Kim, Interactive continuous collision
// detection for non-convex polyhedra (2006); Zhang, Redon, Lee, Kim, Continuous collision detection for articulated models (2007).

#include <cmath>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "ugoki/collision/pair_distance.h"
#include "ugoki/collision/scene.h"

namespace ugoki::collision {

struct AdvancementOptions {
  double tolerance = 1e-5;   ///< m: bodies closer than this count as touching
  int max_iterations = 500;  ///< maximum count of distances measured for one pair
};

enum class ImpactStatus : std::uint8_t {
  none,           ///< the bodies do not touch until the end of the step
  impact,         ///< the bodies touch at Impact::time
  touching,       ///< the bodies touch or overlap at time 0
  not_converged,  ///< max_iterations was reached: no contact before `time`, unknown afterwards
  not_finite,     ///< a pose or velocity is NaN or infinite: the result is undefined
};

/// Result of find_impact().
struct Impact {
  ImpactStatus status = ImpactStatus::none;
  double time = 0;     ///< s from the start of the step, never after the true impact; status none: the step length
  PairDistance near;   ///< distance between the bodies at `time`; status none: the last measured distance, at an earlier time
  int iterations = 0;  ///< count of distances measured
};

/// Motion with constant angular velocity about the centre of the shape's bounding sphere; the centre moves at constant velocity.
struct BodyMotion {
  Pose X_WS;  ///< m, world: pose of the shape at time 0
  Vec3 w;     ///< rad/s, world
  Vec3 v;     ///< m/s, world: velocity of the centre of the bounding sphere

  /// Pose of the shape in the world at `time` [s].
  /// @param centre m, shape's frame: Collider::centre of the shape
  [[nodiscard]] Pose at(const Vec3& centre, double time) const;
};
/// Motion that takes the shape from one world pose to another in `dt` [s], turning by the smaller angle (at most pi).
[[nodiscard]] BodyMotion motion_between(const Collider& collider, const Pose& from, const Pose& to, double dt);

/// First time in [0, dt] at which two bodies come closer than options.tolerance.
/// @param cache [in, out] warm start of this pair
/// No allocation once the workspace has grown.
[[nodiscard]] Impact find_impact(const Collider& a, const BodyMotion& motion_a, const Collider& b, const BodyMotion& motion_b, double dt,
                                 PairCache& cache, DistanceWorkspace& workspace, const AdvancementOptions& options = {});

/// Motion of one system (mechanism) of a scene within a step, at constant joint velocities: q(t) = q (+) v t, where (+) integrates on the
/// joints' manifolds. The spans refer to memory of the caller. q: [nq] m | rad | unit quaternions; v: [nv] m/s | rad/s.
/// X_WB: [links] m, world: poses of the links at q; empty: they are computed.
struct SystemMotion {
  std::span<const double> q, v;
  std::span<const Pose> X_WB = {};
};

/// Result of ImpactSearch.
struct SceneImpact {
  ImpactStatus status = ImpactStatus::none;  ///< never `touching`: pairs that touch at the beginning are skipped as contacts
  double time = 0;                           ///< s from the start, never after the true impact; status none: the step length
  ContactPoint contact;                      ///< links (-1, -1: the ground), point, normal and friction of the impact; key = 0
  int shape_a = -1, shape_b = -1;            ///< indices into Scene::shapes(); -1: the ground
  int pairs = 0;                             ///< count of pairs whose swept spheres overlap within the step
  int distances = 0;                         ///< count of distances measured
};

/// Finds the first impact between shapes of a scene within a step. The motion is given in joint space. Owns scratch memory: use one
/// object per thread.
class ImpactSearch {
 public:
  /// The scene must outlive this object.
  explicit ImpactSearch(const Scene& scene, const AdvancementOptions& options = {});

  /// Returns the first impact within [0, dt]. Tests the same pairs as find_contacts. Pairs closer than `margin` at the beginning are
  /// skipped: they are contacts, and the contact solver keeps them apart. Use a margin below that of find_contacts, so that every pair
  /// is either a contact or tested here.
  /// No allocation, unless the number of pairs grows.
  /// @param systems [systems of the scene] motion of each system
  /// @param dt s
  /// @param margin m, at least options.tolerance
  [[nodiscard]] SceneImpact find(std::span<const SystemMotion> systems, double dt, double margin);

  /// Checks whether a shape may pass through another one within the step. Pairs with the ground and pairs of two non-convex shapes are
  /// skipped. Up to the returned time, no pair exceeds its limit. The limits are:
  /// - Two convex shapes: a penetration depth of half the sum of their half widths (half_width_of(), core.h). If their depth at the start
  ///   exceeds 0.4 of that sum, the limit is this depth plus a tenth of the sum.
  /// - A convex shape and a surface of triangles: the core of the convex shape (core.h) comes close to the surface.
  /// Convex pairs that approach by less than the sum of their half widths are skipped; their distance is not measured.
  /// @return status impact with the time [s] up to which no limit is exceeded, or status none with the length of the step
  [[nodiscard]] SceneImpact find_passage(std::span<const SystemMotion> systems, double dt);

  /// Limits the number of distances that all following searches together may measure, until the next call. Initially there is no limit.
  /// At the limit, find() reports a pair that is not proved apart as not_converged, and find_passage() reports it as passing.
  /// @param distances maximum number of measured distances
  void limit_work(std::int64_t distances) { work_left_ = distances; }
  /// Returns true if the limit of limit_work() is reached.
  [[nodiscard]] bool is_exhausted() const { return work_left_ <= 0; }

 private:
  /// Pose and velocity of a shape at one time, and bounds of its acceleration.
  struct Moving {
    Pose X_WS;
    Vec3 v, w;         // world; v: m/s, of the bounding sphere's centre; w: rad/s
    double a = 0;      // m/s^2: upper bound of the centre's acceleration during the step
    double alpha = 0;  // rad/s^2: upper bound of the angular acceleration during the step
  };
  /// Upper bounds of a link's motion during the step.
  struct LinkBound {
    double w = 0, alpha = 0, a = 0;  // w: rad/s; alpha: rad/s^2; a: m/s^2, of the origin of the link's frame
  };
  struct System {
    std::vector<double> q;
    std::vector<Pose> X_WB;
    std::vector<Vec6> V;  // [links] spatial velocity of each link, in the link's frame
    std::vector<LinkBound> bounds;
    double time = -1;  // s: time for which X_WB and V were computed; -1: none
  };
  struct Candidate {
    int a, b;     // indices into Scene::shapes(); b = -1: the ground
    double time;  // s: the pair does not touch before this time
    int iterations = 0;
    PairCache cache;
  };
  /// Bounding sphere of a shape on its link.
  struct Ball {
    int system, link;
    Vec3 centre;           // m, link's frame
    double lever, radius;  // m; lever: distance of the centre from the origin of the link's frame
  };
  struct Sweep {
    Vec3 centre;
    double radius = 0;  // m: the sphere about `centre` contains the shape during the whole step
    double travel = 0;  // m: upper bound of the path length of any point of the shape during the step
  };

  /// The swept spheres of a system together.
  struct SystemSweep {
    Vec3 low{HUGE_VAL, HUGE_VAL, HUGE_VAL}, high{-HUGE_VAL, -HUGE_VAL, -HUGE_VAL};  // m, world: box that contains the spheres
    double travel = 0;                                                              // m: maximum Sweep::travel
  };

  void prepare(std::size_t system, const SystemMotion& motion, double dt);
  void prepare_all(double dt, double min_travel);
  bool passes_through(Candidate& c, double end, double dt);
  bool core_touches(Candidate& c, double end, double dt);
  void move_to(std::size_t system, double time);
  [[nodiscard]] Moving moving(int shape, double time);
  void find_system_sweeps();
  void add_candidates_between(int system_a, int system_b);
  void find_candidates();
  void add_candidate(int a, int b);
  [[nodiscard]] SceneImpact make_impact(const Candidate& c, const PairDistance& d, ImpactStatus status) const;

  const Scene& scene_;
  AdvancementOptions options_;
  Collider ground_;
  std::span<const SystemMotion> motions_;
  std::vector<System> systems_;
  double min_travel_ = 0;                      // m: pairs of shapes whose summed Sweep::travel is below this are skipped
  std::vector<Ball> balls_;                    // [shapes]
  std::vector<Sweep> sweeps_;                  // [shapes] swept sphere of each shape
  std::vector<double> half_width_;             // [shapes] m: half_width_of() of each shape
  std::vector<SystemSweep> system_sweeps_;     // [systems]
  std::vector<std::pair<double, int>> order_;  // [systems] sorted: minimum x [m, world] of the box of a system, index of the system
  std::vector<Candidate> candidates_;
  std::vector<std::uint32_t> queue_;  // heap of indices into candidates_, the earliest time first
  DistanceWorkspace workspace_;
  std::int64_t work_left_ = INT64_MAX;  // distances that may still be measured
};

}  // namespace ugoki::collision
