#pragma once
// The generator: from a scenario document and what it names to executable data.

#include <map>
#include <string>
#include <vector>

#include "ugoki/base/result.h"
#include "ugoki/content/scenario.h"
#include "ugoki/mechanism/mechanism.h"
#include "ugoki/motion/motion.h"

namespace ugoki::content {

/// Mechanisms and motions by id.
struct Resources {
  std::map<std::string, MechanismPtr, std::less<>> mechanisms;
  std::map<std::string, MotionPtr, std::less<>> motions;
};

[[nodiscard]] MechanismFacts facts_of(const Mechanism& mechanism);
[[nodiscard]] MotionFacts facts_of(const Motion& motion);
[[nodiscard]] Catalogue catalogue_of(const Resources& resources);

/// Index of the link that `text` names by its name, or by its label ("chest", "thigh left"); -1: none.
[[nodiscard]] int find_link(const Mechanism& mechanism, std::string_view text);

/// Executable data (*.ugx, see ugx.h) with only the resources that the document uses. Each clip is laid where the one
/// before it leaves off. Equal input gives equal bytes. All problems are reported.
[[nodiscard]] Result<std::vector<std::byte>> generate(const Scenario& scenario, const Resources& resources);

}  // namespace ugoki::content
