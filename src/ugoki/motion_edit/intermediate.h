#pragma once
// Intermediate motion: a cyclic motion mixed from two or more cyclic motions of one mechanism. See docs/design/intermediate-motion.md.

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "ugoki/motion_edit/cycle.h"

namespace ugoki::motion_edit {

struct IntermediateOptions {
  CycleOptions cycle;             ///< options of make_cyclic, which makes the sources cyclic
  std::vector<std::string> feet;  ///< names of the links that stand on the ground; empty: find_foot_limbs
};

/// Duration, speed, turn and foot sliding of a cycle.
struct CycleFacts {
  double duration = 0;  ///< s
  double speed = 0;     ///< m/s, mean speed of the root over the ground
  double turn = 0;      ///< rad, change of heading per cycle
  SkateReport skate;
};

/// Motions of one mechanism whose contacts and phases are aligned, ready to be mixed.
class Intermediate {
 public:
  /// Makes the sources cyclic (make_cyclic) and aligns their phases by those touch-downs of feet that have the same order in all sources.
  /// If no foot steps in all sources, phases are shifted so that the poses are most similar. `mechanism` must outlive the result. Errors:
  /// no source; a source that does not fit the mechanism or has no cycle; a foot whose number of steps per cycle differs between sources.
  [[nodiscard]] static Result<Intermediate> make(const Mechanism& mechanism, std::span<const Motion* const> sources,
                                                 const IntermediateOptions& options = {});
  Intermediate(Intermediate&&) noexcept;
  Intermediate& operator=(Intermediate&&) noexcept;
  ~Intermediate();

  [[nodiscard]] int count() const;
  /// The cyclic version of source i, and the report of make_cyclic about this source.
  [[nodiscard]] const Motion& cycle(int i) const;
  [[nodiscard]] const CycleReport& cycle_report(int i) const;
  /// True if the phases were aligned by the feet's touch-downs.
  [[nodiscard]] bool by_contacts() const;

  /// Returns the mixture with the given weights of the sources. Durations of the cycle and of stances, and the displacement over the
  /// ground, are weighted means; between two sources, the speed therefore changes monotonically with the weight. Feet are locked. If one
  /// source has all the weight, its cycle is returned exactly.
  /// @param weights [count] at least 0, not all 0; normalised to the sum 1
  [[nodiscard]] Result<Motion> blend(std::span<const double> weights, FootLockReport* report = nullptr) const;

  [[nodiscard]] CycleFacts facts(const Motion& cycle) const;

 private:
  struct Impl;
  explicit Intermediate(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

/// Aligns the sources (Intermediate::make) and returns their mixture (Intermediate::blend).
[[nodiscard]] Result<Motion> make_intermediate(const Mechanism& mechanism, std::span<const Motion* const> sources,
                                               std::span<const double> weights, const IntermediateOptions& options = {});

}  // namespace ugoki::motion_edit
