#pragma once
// Intermediate motion: a cyclic motion between two or more cyclic motions of one mechanism. docs/design/intermediate-motion.md

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "ugoki/motion_edit/cycle.h"

namespace ugoki::motion_edit {

struct IntermediateOptions {
  CycleOptions cycle;             ///< how motions that are not cyclic are made so
  std::vector<std::string> feet;  ///< links that stand; empty: found
};

/// A cycle in numbers.
struct CycleFacts {
  double duration = 0;  ///< s
  double speed = 0;     ///< m/s of the root over the ground
  double turn = 0;      ///< rad in a cycle
  SkateReport skate;
};

/// Motions of one mechanism whose contacts and phases are aligned, ready to be mixed.
class Intermediate {
 public:
  /// Makes the sources cyclic (make_cyclic) and aligns them: touch-downs of the feet at the same phases where all motions have them in the
  /// same order; motions without steps by the shift of phase at which their poses are most alike.
  /// Errors: no source; one that does not fit the mechanism or has no cycle; feet that step a different number of times in a cycle.
  [[nodiscard]] static Result<Intermediate> make(const Mechanism& mechanism, std::span<const Motion* const> sources,
                                                 const IntermediateOptions& options = {});
  Intermediate(Intermediate&&) noexcept;
  Intermediate& operator=(Intermediate&&) noexcept;
  ~Intermediate();

  [[nodiscard]] int count() const;
  /// The cyclic version of a source, and what was done to it.
  [[nodiscard]] const Motion& cycle(int i) const;
  [[nodiscard]] const CycleReport& cycle_report(int i) const;
  /// True if the phases were aligned by the feet's touch-downs.
  [[nodiscard]] bool by_contacts() const;

  /// The motion in which source i counts weights[i]. Durations of cycle and of stances are the weighted means; so is the way over the
  /// ground, so the speed of two motions changes from one to the other without a turn. Feet are locked. With all weight on one source its
  /// cycle comes back exactly. @param weights [count] at least 0, not all 0; they are made to sum to 1
  [[nodiscard]] Result<Motion> blend(std::span<const double> weights, FootLockReport* report = nullptr) const;

  [[nodiscard]] CycleFacts facts(const Motion& cycle) const;

 private:
  struct Impl;
  explicit Intermediate(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

/// The same at once.
[[nodiscard]] Result<Motion> make_intermediate(const Mechanism& mechanism, std::span<const Motion* const> sources,
                                               std::span<const double> weights, const IntermediateOptions& options = {});

}  // namespace ugoki::motion_edit
