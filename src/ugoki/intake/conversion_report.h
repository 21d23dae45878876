#pragma once
// Conversion report: sentences for the user about what was read, guessed, changed and left out during an import, and what to check.

#include <string>
#include <vector>

#include "ugoki/body/body.h"
#include "ugoki/motion/markers.h"
#include "ugoki/motion/motion.h"
#include "ugoki/motion/skeleton.h"

namespace ugoki::intake {

/// Sentences of one import, by category.
struct ConversionReport {
  std::vector<std::string> read;      ///< contents of the file
  std::vector<std::string> guessed;   ///< assumptions about properties that the file does not specify
  std::vector<std::string> changed;   ///< repaired, filled in, renamed or added data
  std::vector<std::string> left_out;  ///< parts of the file that are not in the library
  std::vector<std::string> check;     ///< suspicious results, and what to do about them

  /// Sorts a reader's remarks into the categories by key phrases (conversion_report.cpp). Repeated sentences are added once.
  void add_remarks(const std::vector<std::string>& remarks);
};

/// Describes frames, joints and unit. @param motions at least one, all on the same skeleton
void describe(ConversionReport& report, const std::vector<MeasuredMotion>& motions);
/// Describes markers, analog channels, force platforms and events.
void describe(ConversionReport& report, const MarkerMotion& markers);
/// Describes size, mass and DOFs of a body. Adds checks for implausible size, posture (lying, floating) or speed.
void describe(ConversionReport& report, const body::Body& body, const MeasuredMotion& measured);
/// Describes links, DOFs, mass and loops of a mechanism.
void describe(ConversionReport& report, const Mechanism& mechanism);

/// Joins the names: "a, b, c and 4 more". @param maximum number of names listed (one more if only one remains)
[[nodiscard]] std::string list_of(const std::vector<std::string>& names, std::size_t maximum = 8);

}  // namespace ugoki::intake
