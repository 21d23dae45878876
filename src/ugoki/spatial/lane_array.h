#pragma once
// Memory layout of the values of N SIMD lanes, for code that is compiled once for all register widths. See lanes.h.

namespace ugoki {

template <class Real, int N>
struct LaneArray {
  Real x[N];
};

}  // namespace ugoki
