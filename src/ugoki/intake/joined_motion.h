#pragma once
#include <vector>

#include "ugoki/motion/skeleton.h"

namespace ugoki::intake {

/// Concatenates motions on one skeleton, so that a body made from the result can reproduce all of them.
/// @param motions [>= 1] on skeletons that differ at most in which joints translate
MeasuredMotion joined(const std::vector<MeasuredMotion>& motions);

}  // namespace ugoki::intake
