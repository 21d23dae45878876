#pragma once
// The plan of `ugoki bake`: the content and the variations that are run.

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "sources.h"
#include "ugoki/base/result.h"

namespace ugoki::cli {

/// A varied quantity: a list of values, or a range from which --random draws.
struct Variation {
  std::string name;                 ///< short name ("push", "friction" ...), JSON pointer ("/gravity/2") or "lsi:ID.PARAMETER"
  std::vector<std::string> values;  ///< texts of numbers or words; empty: a range
  double low = 0, high = 0;         ///< range
};

/// Reads "NAME=1,2,5", "NAME=0:10:5" (5 values from 0 to 10) or, with `random`, "NAME=0:10".
[[nodiscard]] Result<Variation> read_variation(const std::string& text, bool random);

/// The runs of a sweep. The run with index `number` always has the same target and values.
struct SweepPlan {
  std::vector<std::string> targets;
  std::vector<std::uint64_t> hashes;  ///< of the executable data of each target, so that a changed target is noticed
  std::vector<Variation> variations;
  std::uint64_t random = 0;  ///< number of runs with random values for each target; 0: one run for every combination of values
  std::uint64_t seed = 1;
  double duration = 0;  ///< s; 0: the duration of the content

  [[nodiscard]] std::uint64_t size() const;
  /// Returns the index of the target and the values of a run, in the order of `variations`.
  [[nodiscard]] std::pair<std::size_t, std::vector<std::string>> run(std::uint64_t number) const;
  /// Returns a text that is equal only for equal plans.
  [[nodiscard]] std::string text() const;
};

/// Changes a scenario by one value. Errors name the quantity.
[[nodiscard]] Result<void> apply_variations(content::Scenario& scenario, const content::Resources& resources,
                                            const std::vector<Variation>& variations, const std::vector<std::string>& values);

/// Checks all values of push-link: each must be a link of the character that is pushed, and there must be a push.
[[nodiscard]] Result<void> check_push_links(const content::Scenario& scenario, const content::Resources& resources,
                                            const std::vector<Variation>& variations);

/// Names of the measures of a run, in the order of their columns.
[[nodiscard]] const std::vector<std::string>& sweep_measures();

}  // namespace ugoki::cli
