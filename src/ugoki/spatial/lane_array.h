#pragma once
// Values of N SIMD lanes in memory, for code that is compiled only once, for all register widths. See lanes.h.

namespace ugoki {

template <class Real, int N>
struct LaneArray {
  Real x[N];
};

}  // namespace ugoki
