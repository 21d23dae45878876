#pragma once
// Cuts a mechanism at the joint of a link.

#include <string_view>

#include "ugoki/mechanism_edit/edited.h"

namespace ugoki {

enum class Keep {
  rest,  ///< all links except the given link and its descendants
  part   ///< the given link and its descendants
};

struct CutOptions {
  Keep keep = Keep::rest;
  JointType base = JointType::floating;  ///< for Keep::part: new joint of the link to the world, at the link's pose in the neutral position
};

/// Cuts the mechanism at the joint of the link. Loops and gears that connect to a dropped link are dropped, each with a sentence in the
/// report. Keep::part also drops a gear on the cut joint. A virtual link (LinkSpec::real) whose real link is dropped becomes an ordinary
/// link, which is reported too. Loops from kept links to the world stay. Errors: an unknown link; nothing left; a base joint that is
/// neither fixed nor floating.
[[nodiscard]] Result<Edited> cut(const Mechanism& mechanism, std::string_view link, const CutOptions& options = {});

}  // namespace ugoki
