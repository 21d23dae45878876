#pragma once
// The real measured files that the tests of this module work on, where they exist, and a small figure of our own.

#include <string>
#include <vector>

#include "ugoki/motion/skeleton.h"

namespace ugoki::body::testing {

/// "bvh/x.bvh", "asf_amc/x.amc": every file under the shared human data; empty where it is absent.
std::vector<std::string> all_files();
/// All that are human beings walking, running, sword fighting: with 30 or 31 joints.
std::vector<std::string> human_files();
/// Reads one of them; ends the test program with a sentence if it cannot be read.
MeasuredMotion read(const std::string& file);

/// A figure of 1.75 m in T position: 19 joints, `frames` of standing still with knees that bend and arms that swing, feet
/// on the floor at height `floor`, which rises by `slope` along x. The figure advances by `speed` m/s when it lifts its feet.
MeasuredMotion made_figure(int frames = 120, double floor = 0.25, double slope = 0);

}  // namespace ugoki::body::testing
