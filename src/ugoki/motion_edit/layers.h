#pragma once
// Layers: mixing of several motions on selected joints.

#include <span>
#include <string>
#include <vector>

#include "ugoki/motion/motion.h"

namespace ugoki::motion_edit {

/// Weight (0 to 1) of each link's joint in a mixture: one value for each link.
using JointMask = std::vector<double>;

struct MaskEntry {
  std::string link;           ///< name or label of a link; "*" for all links
  double weight = 1;          ///< 0 to 1
  bool with_children = true;  ///< also applies to all descendants of the link
};
/// Makes a mask from entries; later entries override earlier ones. Without entries all weights are 1; otherwise links without an entry have
/// weight 0. Errors: unknown links, weights outside 0 to 1.
[[nodiscard]] Result<JointMask> make_mask(const Mechanism& mechanism, std::span<const MaskEntry> entries);

struct LayerOptions {
  double weight = 1;  ///< weight of the whole layer, 0 to 1 (additive layers: any finite value)
  double offset = 0;  ///< s, time in the base motion at which the layer begins
  double fade = 0.2;  ///< s in which the layer fades in and out
};

/// Mixes two motions joint by joint: interpolates each joint from `base` to `other` by its weight in the mask; rotations along great arcs.
/// `other` begins at options.offset of the base; outside its duration it has no effect, unless it is cyclic: then it repeats.
/// Errors: motions that do not fit the mechanism; a mask of another size; a weight outside 0 to 1; invalid times.
[[nodiscard]] Result<Motion> mix_joints(const Mechanism& mechanism, const Motion& base, const Motion& other, const JointMask& mask,
                                        const LayerOptions& options = {});

/// Additive layer: adds to each joint of `base` the displacement of this joint in `layer` since the first frame of `layer`, in the joint's
/// own coordinate frame. Timing and errors are the same as in mix_joints.
[[nodiscard]] Result<Motion> add_layer(const Mechanism& mechanism, const Motion& base, const Motion& layer, const JointMask& mask,
                                       const LayerOptions& options = {});

}  // namespace ugoki::motion_edit
