#pragma once
// Two mechanisms as one: a rider on a horse, a sword in a hand, a man's trunk on a horse's.

#include <string>
#include <string_view>
#include <vector>

#include "ugoki/mechanism_edit/edited.h"

namespace ugoki {

/// What holds the two together.
enum class Attachment {
  joint,  ///< link b hangs on link a by a joint (fixed: a weld); b's tree has no other joint to the world
  loop    ///< both keep their own joints to the world; a loop closes between link a and link b
};

struct CombineOptions {
  std::string name = {};                 ///< empty: "A + B"
  std::string link_a = {}, link_b = {};  ///< where they are joined, by their names before combining; link_a empty: the world
  Pose X_AB = {};                        ///< link b in link a when every joint is neutral
  Pose X_BJ = {};                        ///< the joint's (or loop's) frame in link b
  Attachment attachment = Attachment::joint;
  Joint joint = {};    ///< type, axes in J, freedoms; its X_PJ is not used
  LoopSpec loop = {};  ///< type, axes in J, length, name (empty: made of the links' names); ends and frames are not used
  std::string prefix_a = {}, prefix_b = {};  ///< put before every name of links and loops
};

struct Combined {
  MechanismPtr mechanism;
  std::vector<std::string> links_a, links_b;  ///< [links of a, of b] their names in the new mechanism
  std::vector<std::string> report;
};

/// Puts b beside a. Links, loops and shapes are kept, so mass and inertia are those of both together. Where names of the two are the same
/// and no prefix keeps them apart, b's are prefixed with its name, and this is told.
///   joint: if link b is not the root of its tree, the tree is turned round; b's joint to the world is dropped.
///   loop:  b's tree is moved, joint to the world and all, so that the loop is closed in the neutral position.
/// Errors: an unknown link, names that are still double, a joint or loop that Mechanism::make refuses.
[[nodiscard]] Result<Combined> combine(const Mechanism& a, const Mechanism& b, const CombineOptions& options);

}  // namespace ugoki
