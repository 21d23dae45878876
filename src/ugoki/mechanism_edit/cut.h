#pragma once
// A part of a mechanism: what hangs on a link, or what is left without it.

#include <string_view>

#include "ugoki/mechanism_edit/edited.h"

namespace ugoki {

enum class Keep {
  rest,  ///< all but the link and what hangs on it
  part   ///< the link and what hangs on it
};

struct CutOptions {
  Keep keep = Keep::rest;
  JointType base = JointType::floating;  ///< part: how the link is now joined to the world, where it was in the neutral position
};

/// Cuts at the joint of the link. Loops (and gears) that have one end on each side are dropped, and told one by one; a virtual link whose
/// real link is cut off stays as a link of its own, and this is told. A loop from the kept part to the world stays. Errors: no such link,
/// nothing left, a base joint that is neither fixed nor floating.
[[nodiscard]] Result<Edited> cut(const Mechanism& mechanism, std::string_view link, const CutOptions& options = {});

}  // namespace ugoki
