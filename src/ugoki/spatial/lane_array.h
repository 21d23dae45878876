#pragma once
// Numbers of N lanes as they lie in memory, for code that is compiled once for all widths of registers. See lanes.h.

namespace ugoki {

template <class Real, int N>
struct LaneArray {
  Real x[N];
};

}  // namespace ugoki
