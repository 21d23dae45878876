#pragma once
// Combines two mechanisms into one: a rider on a horse, a sword in a hand, a human trunk on the body of a horse.

#include <string>
#include <string_view>
#include <vector>

#include "ugoki/mechanism_edit/edited.h"

namespace ugoki {

/// How the two mechanisms are connected.
enum class Attachment {
  joint,  ///< link b becomes a child of link a by a joint (type fixed: a weld); the joint of b's tree to the world is dropped
  loop    ///< both mechanisms keep their joints to the world; a loop connects link a and link b
};

struct CombineOptions {
  std::string name = {};                 ///< empty: "A + B"
  std::string link_a = {}, link_b = {};  ///< links to connect, by their names before combining; empty link_a: the world
  Pose X_AB = {};                        ///< pose of link b in link a in the neutral position
  Pose X_BJ = {};                        ///< pose of the joint's (or loop's) frame in link b
  Attachment attachment = Attachment::joint;
  Joint joint = {};                          ///< type, axes, DOFs; X_PJ is not used
  LoopSpec loop = {};                        ///< type, axes, length, name (empty: made from the link names); links and frames are not used
  std::string prefix_a = {}, prefix_b = {};  ///< prepended to all names of links and loops of a (prefix_a) and of b (prefix_b)
};

struct Combined {
  MechanismPtr mechanism;
  std::vector<std::string> links_a, links_b;  ///< [links of a], [links of b] names in the new mechanism
  std::vector<std::string> report;
};

/// Combines a and b. All links, loops and shapes are kept, so mass and inertia are the sums. If names occur in both, b's names are prefixed
/// with the name of b, which the report states.
///   joint: if link b is not the root of its tree, the tree is rerooted at link b; b's joint to the world is dropped.
///   loop:  b's tree, with its joint to the world, is moved so that the loop is closed in the neutral position.
/// Errors: an unknown link; a joint or loop that Mechanism::make refuses.
[[nodiscard]] Result<Combined> combine(const Mechanism& a, const Mechanism& b, const CombineOptions& options);

}  // namespace ugoki
