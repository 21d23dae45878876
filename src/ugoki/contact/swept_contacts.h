#pragma once
// Swept contacts: contacts that a body reaches within a step although the body is still farther away than the margin of collision analysis
// (a kicked ball, a sword).
//
// Conservative advancement (collision/advancement.h) finds the time t [s] at which two bodies touch. The contact points of that time are
// mapped back to their present positions on the bodies. Let u [m/s] be the present separation velocity of such a point. Its distance is
//   d = d(t) - t u
// The stepper requires d + dt u' >= 0, u' being the separation velocity after the step. The present velocities times t / dt satisfy this:
// with them the bodies just reach the impact, however far they rotate. An impact with restitution takes place within the step. A contact
// is added only for a real impact, so that a body does not bounce off the extended plane of a plate that it misses.

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "ugoki/collision/advancement.h"
#include "ugoki/collision/contact_manifold.h"
#include "ugoki/dynamics/dynamics.h"

namespace ugoki::contact {

/// Finds the first impact of every system within a step and adds its contact points.
class SweptContacts {
 public:
  /// Keeps a pointer to the scene, which must outlive this object.
  explicit SweptContacts(const collision::Scene& scene);

  /// Adds the contact points of the first impact of every system within the step.
  /// @param X_WB     [systems][links] poses in the world at the beginning of the step
  /// @param margin   m: the margin with which find_contacts() was called
  /// @param contacts [in, out] contacts from find_contacts(); the new ones are appended
  /// @return number of impacts found, at most 32
  /// Allocates only at the first impact of each system, and when the number of contacts grows.
  int add(std::span<const collision::SystemMotion> systems, std::span<const std::span<const Pose>> X_WB, double dt, double margin,
          std::vector<collision::ContactPoint>& contacts);

  /// Limits the number of distances that all following calls together may measure; see collision::ImpactSearch::limit_work().
  void limit_work(std::int64_t distances) { search_.limit_work(distances); }

 private:
  /// One body of an impact: its pose at the beginning of the step (now) and at the impact (then).
  struct Side {
    int system = -1;
    int link = 0;
    Pose now, then;
    /// Maps a point of the body from its world position at the impact to its present world position; back_with() maps a direction.
    [[nodiscard]] Vec3 back(const Vec3& p) const { return system < 0 ? p : now * (then.inverse() * p); }
    [[nodiscard]] Vec3 back_with(const Vec3& n) const { return system < 0 ? n : now.R * transpose_times(then.R, n); }
  };
  Side side_at(int system, int link, std::span<const std::span<const Pose>> X_WB, double time);
  void find_points(const collision::SceneImpact& impact, const Side& a, const Side& b, double margin);

  const collision::Scene* scene_;
  collision::ImpactSearch search_;
  std::vector<collision::SystemMotion> motions_;
  std::vector<double> still_;  // [nv] zeros: velocities of systems whose impact is already found
  std::vector<double> q_;      // [nq] used by side_at(): coordinates of one system at the time of an impact
  std::vector<Pose> X_;        // [links] used by side_at(): poses of the links of this system at that impact
  std::vector<std::unique_ptr<dynamics::Kinematics>> kinematics_;  // [systems] null until the first impact of the system
  collision::ManifoldWorkspace work_;
  collision::Manifold points_;
};

}  // namespace ugoki::contact
