#pragma once
// The generator: turns a scenario document with its mechanisms and motions into executable data.

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

/// Adds the mechanisms of the scenario's props that are not yet there, except props whose mesh is not there.
void add_props(const Scenario& scenario, Resources& resources);

/// Returns the properties of a mechanism or motion that check_scenario() needs.
[[nodiscard]] MechanismFacts facts_of(const Mechanism& mechanism);
[[nodiscard]] MotionFacts facts_of(const Motion& motion);
/// Returns the properties of all resources that check_scenario() needs.
[[nodiscard]] Catalogue catalogue_of(const Resources& resources);

/// Returns the index of the link with the name `text`, or else of the first link with the label `text` ("chest", "thigh left"); -1: none.
[[nodiscard]] int find_link(const Mechanism& mechanism, std::string_view text);

/// Makes executable data (*.ugx, see ugx.h) with only those resources that the document uses. Each clip begins at the planar pose in which
/// the previous clip of its track ends. Equal input gives equal bytes. All problems are reported.
[[nodiscard]] Result<std::vector<std::byte>> generate(const Scenario& scenario, const Resources& resources);

}  // namespace ugoki::content
