#pragma once
// Test data of this module: the shared measured files, if present, and a synthetic character.

#include <string>
#include <vector>

#include "ugoki/motion/skeleton.h"

namespace ugoki::body::testing {

/// Relative paths of all files of the shared human data, such as "bvh/x.bvh"; empty if the data are absent.
std::vector<std::string> all_files();
/// The files with human motion (skeletons of 30 or 31 joints).
std::vector<std::string> human_files();
/// Reads one of these files; aborts the test program with a message if it cannot be read.
MeasuredMotion read(const std::string& file);

/// A synthetic character of 1.75 m with 19 joints whose rest posture is a T. It bends its knees and swings its arms with both feet on the
/// floor, and jumps forward by 0.5 m every second. @param floor m, height of the floor at x = 0 @param slope rise of the floor along x, m/m
MeasuredMotion made_character(int frames = 120, double floor = 0.25, double slope = 0);

}  // namespace ugoki::body::testing
