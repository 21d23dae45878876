#pragma once
// What became of a file, in sentences for people: what was read, what was guessed, what was changed, what was left out, what to check.

#include <string>
#include <vector>

#include "ugoki/body/body.h"
#include "ugoki/motion/markers.h"
#include "ugoki/motion/motion.h"
#include "ugoki/motion/skeleton.h"

namespace ugoki::intake {

struct ConversionReport {
  std::vector<std::string> read;      ///< what the file holds
  std::vector<std::string> guessed;   ///< what the file does not tell
  std::vector<std::string> changed;   ///< what was repaired, filled in, renamed, made
  std::vector<std::string> left_out;  ///< what of the file is not in the library
  std::vector<std::string> check;     ///< what looks wrong, and what to do about it

  /// Puts a reader's remarks where they belong, by their words. Each sentence once.
  void add_remarks(const std::vector<std::string>& remarks);
};

/// Frames, joints and unit of a skeleton's motions; all on the same skeleton, at least one.
void describe(ConversionReport& report, const std::vector<MeasuredMotion>& motions);
/// Markers, channels, platforms, events.
void describe(ConversionReport& report, const MarkerMotion& markers);
/// Size, mass, freedoms; what cannot be right of a person who lies, floats, is a giant, or moves faster than anybody.
void describe(ConversionReport& report, const body::Body& body, const MeasuredMotion& measured);
void describe(ConversionReport& report, const Mechanism& mechanism);

/// "a, b, c and 4 more"
[[nodiscard]] std::string list_of(const std::vector<std::string>& names, std::size_t most = 8);

}  // namespace ugoki::intake
