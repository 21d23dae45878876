#pragma once
// A step that is checked afterwards for overlaps and for bodies that passed through each other.
//
// Overlaps. The stepper keeps the given contacts apart to first order, with their normals and positions at the beginning of the step. Two
// bodies can still overlap at the end: by a feature that was not the closest one, or because a body turned or slid by a large part of its
// size. Collision analysis of the end positions finds such overlaps, with gap g < 0 [m] and normal n. Each becomes a contact, and the step
// is repeated. With v the velocities of this pass, v' those of the next pass and g0 <= 0 the gap of the pair at the beginning, the next
// pass requires
//   u(v') >= u(v) - (g - g0) / dt,   u = n . (velocity of a - velocity of b) [m/s]
// at the contact point, mapped back to its position at the beginning on the body that turns more. This is Newton's method on the gap at
// the end. Positions are not corrected afterwards: they remain the integral of the velocities.
//
// Passage. Bodies that move by more than half their thickness are also followed during the step (collision/advancement.h). If a body would
// penetrate another one so deeply that it may exit on the far side, the step is split into substeps. A substep is halved until no body
// passes through. Each substep has its own contacts. After 256 attempts, or at 1/1024 of the step, all systems stop before a passage.
//
// Sources: Anitescu, Potra (1997) for steps with linearised gaps; Stewart (1998) for the errors of the linearisation.

#include <span>
#include <vector>

#include "ugoki/collision/scene.h"
#include "ugoki/contact/stepper.h"
#include "ugoki/contact/swept_contacts.h"
#include "ugoki/dynamics/known_kinematics.h"

namespace ugoki::contact {

struct GuardOptions {
  double depth = 4e-4;   ///< m: smaller overlaps at the end of a step are accepted
  int passes = 12;       ///< maximum number of times that a step or substep is solved, including the first
  double margin = 0.02;  ///< m: pairs of shapes closer than this at the beginning of a substep become contacts of the substep
};

/// Advances a Stepper by steps in which bodies neither overlap at the end nor pass through each other; see the top of this file.
class GuardedStep {
 public:
  /// Scene and stepper must have the same systems in the same order, and must outlive this object.
  GuardedStep(const collision::Scene& scene, Stepper& stepper, const GuardOptions& options = {});

  /// Advances all systems by dt [s], like Stepper::step(). On failure q and v keep their values from before the step.
  /// Allocates nothing after warm-up, unless the number of contacts grows.
  StepReport step(std::span<StepSystem> systems, std::span<const collision::ContactPoint> contacts, double dt);

  /// [systems] Kinematics at the end of the last step(), if it did not fail. The caller may exchange them for others.
  [[nodiscard]] std::span<dynamics::KnownKinematics> end() { return end_; }
  /// Computes the kinematics at the end of a step that was not guarded.
  void set_end(std::span<const StepSystem> systems);

  /// Discards cached results of collision analysis, but keeps the memory. See collision::Workspace::forget().
  void forget() { workspace_.forget(); }

  /// Contacts of the last step: first the given contacts, then those that the guard found at the end of the step or in its substeps.
  [[nodiscard]] std::span<const collision::ContactPoint> contacts() const { return all_contacts_; }
  /// [contacts()] N, world: mean force over the step on body a of each contact.
  [[nodiscard]] std::span<const Vec3> forces() const { return forces_; }
  [[nodiscard]] int passes() const { return passes_; }  ///< how often the last step, or its last substep, was solved
  /// m: maximum depth, at the end of the last step or substep, of overlaps that appeared or grew in it; 0: none.
  [[nodiscard]] double depth() const { return depth_; }

 private:
  /// Positions and velocities of all systems.
  struct States {
    std::vector<std::vector<double>> q, v;
    void save(std::span<const StepSystem> systems);
    void restore(std::span<const StepSystem> systems) const;
  };
  StepReport step_whole(std::span<StepSystem> systems, std::span<const collision::ContactPoint> contacts, double dt);
  StepReport step_in_substeps(std::span<StepSystem> systems, std::span<const collision::ContactPoint> contacts, double dt);
  double find_passage(std::span<const StepSystem> systems, double dt);
  void find_contacts(std::span<const StepSystem> systems, double dt);
  void stop_at(std::span<const StepSystem> systems, double time);
  void add_forces(double fraction);
  [[nodiscard]] bool needs_gap(const collision::ContactPoint& c) const;
  [[nodiscard]] bool is_convex_pair(const collision::ContactPoint& c) const;
  void set_end(std::size_t s, const StepSystem& system);
  void update_end_poses(std::span<const StepSystem> systems, double dt);
  [[nodiscard]] bool may_pass(std::size_t s, double dt) const;
  bool add_overlaps(std::span<const collision::ContactPoint> given, double dt);

  const collision::Scene* scene_;
  Stepper* stepper_;
  GuardOptions options_;
  collision::Workspace workspace_;
  collision::ImpactSearch search_;
  SweptContacts swept_;
  States attempt_begin_, step_begin_;  // states at the beginning of the present step or substep; of the complete step
  std::vector<collision::SystemMotion> motions_;
  std::vector<dynamics::KnownKinematics> end_;  // kinematics at the end of the step; stepper_ has those at its beginning
  std::vector<std::span<const Pose>> views_;    // poses in end_
  std::vector<std::size_t> first_link_;         // [systems + 1] index in size_ of each system's first link
  std::vector<double> size_;                    // m [links of all systems] radius about the link's origin that contains all its shapes
  std::vector<char> moved_;                     // [systems] 1: a point moved by more than GuardOptions::depth in this pass
  std::vector<char> may_pass_;                  // [systems] result of may_pass() for this pass
  std::vector<double> half_thickness_;          // m [links of all systems] half thickness of the link's thinnest shape
  std::vector<collision::ContactPoint> found_, contacts_, near_;
  std::vector<collision::ContactPoint> all_contacts_;
  std::vector<Vec3> forces_;
  int passes_ = 0;
  bool repeated_ = false;  // the last pass was Stepper::repeat(): only islands with new contacts changed
  double depth_ = 0;
};

}  // namespace ugoki::contact
