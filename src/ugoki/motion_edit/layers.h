#pragma once
// Several motions at once on different joints.

#include <span>
#include <string>
#include <vector>

#include "ugoki/motion/motion.h"

namespace ugoki::motion_edit {

/// How much each link's joint takes part: [links] 0 ... 1.
using JointMask = std::vector<double>;

struct MaskEntry {
  std::string link;           ///< name or label; "*" for all
  double weight = 1;          ///< 0 ... 1
  bool with_children = true;  ///< everything behind it too
};
/// Entries one after the other, later ones override. No entries: everything takes part. Errors: unknown links, weights outside 0 ... 1.
[[nodiscard]] Result<JointMask> make_mask(const Mechanism& mechanism, std::span<const MaskEntry> entries);

/// Joint-wise mix: each joint goes from `base` to `other` by its weight in the mask, on great arcs. `other` begins at `offset` [s] of the
/// base; before and after it counts nothing, a cyclic one repeats. `fade` [s] eases it in and out. Errors: motions that do not fit; a mask
/// of another size.
struct LayerOptions {
  double weight = 1;  ///< of the whole layer, 0 ... 1 (additive: any number)
  double offset = 0;  ///< s
  double fade = 0.2;  ///< s
};
[[nodiscard]] Result<Motion> mix_joints(const Mechanism& mechanism, const Motion& base, const Motion& other, const JointMask& mask,
                                        const LayerOptions& options = {});

/// Additive layer: what `layer` does against its own first frame is done on top of `base`, in each joint's own frame. Otherwise as
/// mix_joints.
[[nodiscard]] Result<Motion> add_layer(const Mechanism& mechanism, const Motion& base, const Motion& layer, const JointMask& mask,
                                       const LayerOptions& options = {});

}  // namespace ugoki::motion_edit
