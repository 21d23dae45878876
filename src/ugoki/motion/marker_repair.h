#pragma once
// Measured markers made clean: spikes taken out, gaps closed, noise filtered.

#include <vector>

#include "ugoki/motion/markers.h"

namespace ugoki {

/// A stretch of frames [first, last] in which a marker was not seen.
struct MarkerGap {
  int marker = 0, first = 0, last = 0;
};

/// All gaps, by marker, then by frame.
[[nodiscard]] std::vector<MarkerGap> find_gaps(const MarkerMotion& motion);

/// Takes out single frames that jump: a position whose distance from the line between its neighbours is above `limit` [m] and six times
/// the marker's usual one becomes unseen. @return how many
int remove_spikes(MarkerMotion& motion, double limit = 0.02);

/// Fills gaps of at most `longest` [s] by cubic Hermite splines through the frames beside them. Gaps at the ends stay. Filled places get
/// a residual of 0. @return how many places
int fill_short_gaps(MarkerMotion& motion, double longest);

/// Fills what is left of a marker's gaps from three or more markers that move with it as one rigid body (those whose distances
/// from it vary least, below `rigid` [m]), by the rigid motion that fits them best in each frame; joined to the measured ends without
/// a jump. @return how many places
int fill_gaps_by_neighbours(MarkerMotion& motion, double rigid = 0.015);

/// The cut-off frequency [Hz] at which filtering begins to cut into the motion: residual analysis (Winter 2009, section 3.4.4.3) of
/// all coordinates together, between 4 Hz and a quarter of the rate.
[[nodiscard]] double choose_cutoff(const MarkerMotion& motion);

/// Zero-lag Butterworth filter of second order over every stretch of seen frames, forwards and backwards, ends padded by reflection.
void filter_markers(MarkerMotion& motion, double cutoff);

}  // namespace ugoki
