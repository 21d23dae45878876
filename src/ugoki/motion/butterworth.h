#pragma once
// Zero-lag low-pass filter for a sequence of samples.

#include <vector>

namespace ugoki {

/// Filters x in place with a second-order Butterworth low-pass, forwards and backwards. Each pass assumes that all samples before its first
/// one are equal to it; callers pad the ends. `cutoff` is the frequency at which both passes together halve the power; the cut-off of a
/// single pass is higher by the factor (2^(1/2) - 1)^(-1/4). Source: Winter (2009), section 3.4.4.2.
/// @param rate samples per second  @param cutoff Hz, below rate / 3
void filter_both_ways(std::vector<double>& x, double rate, double cutoff);

}  // namespace ugoki
