#pragma once
// A step whose end is looked at: what would overlap there by more than a little is made a contact, and the step is taken again.
//
// The stepper keeps every contact that it is given apart, to first order: by its normal and place at the beginning. A body that lands
// on another feature than the nearest, or that turns or slides a good part of its size within the step, can still end inside
// another. Collision analysis of the end finds that, with the gap g < 0 and the normal n of the end. With v the velocities of this pass
// and g0 <= 0 the pair's gap at the beginning, the next pass asks of the point of contact, at its place at the beginning on the body that
// turns more,
//   u(v') >= u(v) - (g - g0) / dt,   u = n . (velocity of a - velocity of b)
// which is Newton's method on the gap at the end. Nothing is moved afterwards: velocities stay those that positions follow.
//
// Things that move by more than they are thick are also followed on their way (collision/advancement.h): where one would get so deep
// into another within the step that it may come out on its other side, the step is taken apart. It is halved until nothing passes, each
// part with contacts of its own; after 256 parts, or when a part is a 1024th of the step, what would still pass stops where it is. Source:
// Anitescu, Potra (1997) for steps with linearised gaps; Stewart (1998) for what their linearisation leaves.

#include <span>
#include <vector>

#include "ugoki/collision/scene.h"
#include "ugoki/contact/stepper.h"
#include "ugoki/contact/swept_contacts.h"

namespace ugoki::contact {

struct GuardOptions {
  double depth = 4e-4;   ///< m: less at the end of a step is left alone
  int passes = 12;       ///< greatest number of times that a step is taken
  double margin = 0.02;  ///< m: contacts of the parts of a step are looked for so far
};

class GuardedStep {
 public:
  /// Scene and stepper have the same systems, and must outlive it.
  GuardedStep(const collision::Scene& scene, Stepper& stepper, const GuardOptions& options = {});

  /// As Stepper::step(); q and v are left as they were where it fails.
  /// No allocation after warm-up, unless the number of contacts grows.
  StepReport step(std::span<StepSystem> systems, std::span<const collision::ContactPoint> contacts, double dt);

  /// As if nothing had been looked at before; keeps its memory. See collision::Workspace::forget().
  void forget() { workspace_.forget(); }

  /// The contacts of the last step: those given to it, then those found at its end or in its parts.
  [[nodiscard]] std::span<const collision::ContactPoint> contacts() const { return all_contacts_; }
  /// N, world, on body a of each of them: the mean over the step.
  [[nodiscard]] std::span<const Vec3> forces() const { return forces_; }
  [[nodiscard]] int passes() const { return passes_; }  ///< times that the last step, or its last part, was taken
  [[nodiscard]] int parts() const { return parts_; }    ///< of the last step; 1: it was not taken apart
  /// m: what was left at the end of the last step of overlaps that it should have prevented, as far as was looked
  [[nodiscard]] double depth() const { return depth_; }

 private:
  /// Positions and velocities of all systems.
  struct States {
    std::vector<std::vector<double>> q, v;
    void save(std::span<const StepSystem> systems);
    void restore(std::span<const StepSystem> systems) const;
  };
  StepReport take(std::span<StepSystem> systems, std::span<const collision::ContactPoint> contacts, double dt);
  StepReport take_apart(std::span<StepSystem> systems, std::span<const collision::ContactPoint> contacts, double dt);
  double find_passage(std::span<const StepSystem> systems, double dt);
  void find_contacts(std::span<const StepSystem> systems, double dt);
  void stop_at(std::span<const StepSystem> systems, double time);
  void add_forces(double part);
  [[nodiscard]] bool needs_gap(const collision::ContactPoint& c) const;
  [[nodiscard]] bool is_convex_pair(const collision::ContactPoint& c) const;
  void move(std::span<const StepSystem> systems);
  bool add_overlaps(std::span<const collision::ContactPoint> given, double dt);

  const collision::Scene* scene_;
  Stepper* stepper_;
  GuardOptions options_;
  collision::Workspace workspace_;
  collision::ImpactSearch search_;
  SweptContacts swept_;
  States begin_, whole_;  // of what is taken; of the step
  std::vector<collision::SystemMotion> motions_;
  std::vector<std::vector<Pose>> end_;        // [systems][links] those at the beginning are the stepper's
  std::vector<std::span<const Pose>> views_;  // of end_
  std::vector<double> size_;                  // m [links of all systems] how far a link's shapes reach from its origin
  std::vector<Vec6> speeds_;                  // [links of one system]
  std::vector<char> moved_;                   // [systems] by more than the depth
  std::vector<double> thin_;                  // m [links of all systems] half extent of its thinnest shape
  std::vector<collision::ContactPoint> found_, contacts_, near_;
  std::vector<collision::ContactPoint> all_contacts_;
  std::vector<Vec3> forces_;
  int passes_ = 0, parts_ = 1;
  bool again_ = false;  // the last pass solved anew only what its contacts touch
  double depth_ = 0;
};

}  // namespace ugoki::contact
