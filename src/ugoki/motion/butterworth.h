#pragma once
// Zero-lag low-pass filter over rows of samples.

#include <vector>

namespace ugoki {

/// Second-order Butterworth low-pass forwards and backwards over the row, in place; what lies before the first sample counts as
/// equal to it, so callers pad the ends. Both passes together have the cut-off (the one of each is raised by
/// (2^(1/2) - 1)^(-1/4)). Source: Winter (2009), section 3.4.4.2.
/// @param rate samples a second  @param cutoff Hz, below rate / 3
void filter_both_ways(std::vector<double>& x, double rate, double cutoff);

}  // namespace ugoki
