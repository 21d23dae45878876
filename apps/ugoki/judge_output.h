#pragma once
// Output of `ugoki judge`: tables, JSON and pictures of measures of naturalness.

#include <string>
#include <vector>

#include "output.h"
#include "ugoki/naturalness/report.h"

namespace ugoki::cli {

/// One judged motion: the recording, or a character of a simulation.
struct JudgedPart {
  std::string name;
  naturalness::Report report;
};

/// Measures with a value as JSON; those without a value have `value` null and a `reason`.
[[nodiscard]] Json judge_json(const std::vector<JudgedPart>& parts);

/// Prints one table for the measures of all parts, one for the worst time spans, and the measures that do not apply.
void print_judgement(const std::vector<JudgedPart>& parts);

/// The pictures for --svg. A path that ends in ".svg" is one picture with all parts; another path is a folder with one picture for each
/// part and one for each measure of each part.
struct JudgePicture {
  std::string path, svg;
};
[[nodiscard]] std::vector<JudgePicture> judge_pictures(const std::vector<JudgedPart>& parts, const std::string& name,
                                                       const std::string& path);

}  // namespace ugoki::cli
