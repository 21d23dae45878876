#pragma once
// Cleaning of measured markers: removes spikes, fills gaps, filters noise.

#include <functional>
#include <vector>

#include "ugoki/motion/markers.h"

namespace ugoki {

/// A range of animation frames [first, last] in which a marker was not seen.
struct MarkerGap {
  int marker = 0, first = 0, last = 0;
};

/// All gaps, sorted by marker, then by frame.
[[nodiscard]] std::vector<MarkerGap> find_gaps(const MarkerMotion& motion);

/// Marks single outliers as unseen: positions whose distance from the midpoint of the two neighbouring frames is above both `limit` [m] and
/// six times the median of these distances for the marker. @return number of positions removed
int remove_spikes(MarkerMotion& motion, double limit = 0.02);

/// Fills gaps of at most `longest` [s] by cubic Hermite splines through the frames next to them. Gaps at the ends of the recording stay.
/// Filled positions get a residual of 0. @return number of positions filled
int fill_short_gaps(MarkerMotion& motion, double longest);

/// Fills the remaining gaps of a marker from at least three (at most six) markers that move with it like one rigid body: those with the
/// smallest standard deviation of their distance from the marker, below `rigid` [m]. The position follows the best-fitting rigid motion of
/// these markers, blended between both measured ends of the gap. @return number of positions filled
int fill_gaps_by_neighbours(MarkerMotion& motion, double rigid = 0.015);

/// Cut-off frequency [Hz] above which filtering removes mainly noise: residual analysis (Winter 2009, section 3.4.4.3) of all coordinates
/// together, between 4 Hz and 0.7 times a quarter of the rate. 0 (no filter) for rates up to 20 Hz or fewer than 20 frames.
/// @param cancelled called before each of up to 15 passes over the recording; true ends the work with a meaningless result
[[nodiscard]] double choose_cutoff(const MarkerMotion& motion, const std::function<bool()>& cancelled = {});

/// Filters every run of seen frames with filter_both_ways() (butterworth.h), with ends padded by reflection. Filters only if `cutoff`
/// [Hz] is between 0 and a third of the rate, and only runs of at least 4 frames.
void filter_markers(MarkerMotion& motion, double cutoff);

}  // namespace ugoki
