#pragma once
// Mechanism data: the structure of a human, an animal or another linked system. Immutable once built.

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "ugoki/base/result.h"
#include "ugoki/mechanism/joint.h"
#include "ugoki/mechanism/loop.h"
#include "ugoki/mechanism/shape.h"
#include "ugoki/mechanism/skin.h"

namespace ugoki {

/// A link in the editable description: refers to its parent by name.
struct LinkSpec {
  std::string name;
  std::string parent;  ///< empty: the joint connects the link to the world
  Joint joint;
  Inertia inertia;  ///< in the link's frame
  std::vector<Shape> shapes;
  std::string real;   ///< name of the real link, if this link is virtual (second body of a link at which a loop was cut); else empty
  Pose X_RV;          ///< virtual links: pose of this link in the real link's frame while the loop is closed
  std::string label;  ///< anatomical name, for display and for matching ("left shank"); may be empty
};

struct MechanismSpec {
  std::string name;
  std::vector<LinkSpec> links;                              ///< any order
  std::vector<LoopSpec> loops = {};                         ///< without the loops of virtual links, which follow from LinkSpec::real
  std::vector<std::array<std::string, 2>> exclusions = {};  ///< names of two links whose shapes do not collide with each other
  SkinPtr skin = {};                                        ///< drawn surface of the whole mechanism; null: none
  std::vector<SkinBone> skin_bones = {};                    ///< bones of the skin; several can be attached to one link
};

/// A link in the run-time form. Index -1 means none. The members that each step reads come first, so that they are in few cache lines.
/// Source: Nagashima (1999), table 2.
struct Link {
  int parent = -1;   ///< next link towards the base; -1: the world
  int child = -1;    ///< first link with this link as its parent
  int sibling = -1;  ///< next link with the same parent
  int real = -1;     ///< virtual link: index of the real link that it stands for
  int q_index = 0;   ///< index in q of the first coordinate of the link's joint
  int v_index = 0;   ///< index in v of the first DOF of the link's joint
  Inertia inertia;
  Joint joint;
  Pose X_RV;
  std::vector<Shape> shapes;
  std::string name;
  std::string label;
};

/// Place of a link in the tree and of its joint in q and v: all that most recursions need to know of a Link. Four of them fill a cache
/// line; a Link has 13 lines.
struct LinkPlace {
  int parent;       ///< as Link::parent
  int q_index;      ///< as Link::q_index
  int v_index;      ///< as Link::v_index
  JointType type;   ///< of the link's joint
  std::uint8_t nv;  ///< number of DOFs of the link's joint
};

class Mechanism {
 public:
  /// Builds the run-time form: orders links with parents before children (otherwise in the given order) and sets the indices. Reports all
  /// problems, each with the name of its link or loop: missing or duplicate name, unknown parent or real link, cycle of parents, axis that
  /// is not a unit vector, lower limit above upper limit, negative damping, impossible inertia (negative mass, triangle inequality),
  /// movable joint without armature whose link and descendants have no mass, loop between a link and itself, loop without length or DOF,
  /// exclusion of an unknown link or of a link with itself, damaged skin, bone of the skin on an unknown link,
  /// values that are not finite. O(links log links)
  [[nodiscard]] static Result<std::shared_ptr<const Mechanism>> make(MechanismSpec spec);

  [[nodiscard]] const std::string& name() const { return name_; }
  [[nodiscard]] std::span<const Link> links() const { return links_; }
  [[nodiscard]] int link_count() const { return static_cast<int>(links_.size()); }
  [[nodiscard]] const Link& link(int i) const { return links_[static_cast<std::size_t>(i)]; }
  /// [links] places of the links in tree, q and v.
  [[nodiscard]] std::span<const LinkPlace> places() const { return places_; }
  [[nodiscard]] int nq() const { return nq_; }
  [[nodiscard]] int nv() const { return nv_; }
  [[nodiscard]] double mass() const { return mass_; }  ///< kg, including virtual links
  /// All loops: first those of MechanismSpec::loops in that order, then one weld for each virtual link, with the link's name.
  [[nodiscard]] std::span<const Loop> loops() const { return loops_; }
  [[nodiscard]] bool has_loops() const { return !loops_.empty(); }
  /// Pairs of links whose shapes do not collide with each other: indices, the smaller one first; sorted, each pair once.
  [[nodiscard]] std::span<const std::array<int, 2>> exclusions() const { return exclusions_; }
  /// The drawn surface; null: none.
  [[nodiscard]] const SkinPtr& skin() const { return skin_; }
  [[nodiscard]] std::span<const SkinBone> skin_bones() const { return skin_bones_; }
  /// Index of the loop with this name, or -1. O(loops).
  [[nodiscard]] int find_loop(std::string_view name) const;
  /// Index of the link with this name, or -1. O(links).
  [[nodiscard]] int find_link(std::string_view name) const;
  /// Index of the link whose joint has velocity index i.
  [[nodiscard]] int link_of_dof(int i) const { return link_of_dof_[static_cast<std::size_t>(i)]; }
  /// Parent of each DOF in the tree of DOFs, [nv]: the previous DOF of the same joint, or the last DOF of the nearest
  /// movable ancestor; -1 at the base. (Featherstone's lambda.)
  [[nodiscard]] std::span<const int> dof_parents() const { return dof_parents_; }
  /// Properties of the DOF with velocity index i.
  [[nodiscard]] const Dof& dof(int i) const;
  /// Neutral position [nq]: zeros and identity quaternions.
  [[nodiscard]] std::vector<double> neutral() const;
  /// The editable description of this mechanism, for saving and editing. Mechanism::make(spec()) gives an equal mechanism.
  [[nodiscard]] MechanismSpec spec() const;

 private:
  Mechanism() = default;
  std::string name_;
  std::vector<Link> links_;
  std::vector<LinkPlace> places_;
  std::vector<Loop> loops_;
  std::vector<std::array<int, 2>> exclusions_;
  SkinPtr skin_;
  std::vector<SkinBone> skin_bones_;
  std::vector<int> link_of_dof_;
  std::vector<int> dof_parents_;
  int nq_ = 0, nv_ = 0;
  double mass_ = 0;
};

using MechanismPtr = std::shared_ptr<const Mechanism>;

}  // namespace ugoki
