#pragma once
// Mechanism data: the structure of a human, an animal or another linked system. Immutable once built.

#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "ugoki/base/result.h"
#include "ugoki/mechanism/joint.h"
#include "ugoki/mechanism/loop.h"
#include "ugoki/mechanism/shape.h"

namespace ugoki {

/// A link as people write it: it names its parent.
struct LinkSpec {
  std::string name;
  std::string parent;  ///< empty: the joint connects it to the world
  Joint joint;
  Inertia inertia;  ///< in the link's frame
  std::vector<Shape> shapes;
  std::string real;   ///< not empty: this is a virtual link, a second body for the link named here, at which a loop was cut
  Pose X_RV;          ///< virtual links: frame of this link in the real link's frame when the loop is closed
  std::string label;  ///< anatomical meaning, for people and for matching ("left shank"); may be empty
};

struct MechanismSpec {
  std::string name;
  std::vector<LinkSpec> links;       ///< any order
  std::vector<LoopSpec> loops = {};  ///< beside those of the virtual links
};

/// A link as it runs. Indices are -1 where there is none. (Paper, table 2.)
struct Link {
  std::string name;
  std::string label;
  int parent = -1;   ///< nearer to the base; -1: the world
  int child = -1;    ///< first link that hangs on this one
  int brother = -1;  ///< next link with the same parent
  int real = -1;     ///< virtual pointer: the real link of which this is the second body
  Joint joint;
  int q_index = 0;  ///< first coordinate of its joint in q
  int v_index = 0;  ///< first freedom of its joint in v
  Inertia inertia;
  Pose X_RV;
  std::vector<Shape> shapes;
};

class Mechanism {
 public:
  /// Orders links parents first (otherwise as given), sets the pointers and checks everything; each problem names the
  /// link at fault: no or double name, unknown parent or real link, a circle of parents, axis without direction, lower
  /// above upper limit, negative damping, inertia impossible for a body (negative mass, triangle inequality), a movable
  /// joint with nothing behind it that has mass (or armature), a loop between a link and itself or without length or
  /// freedom, not finite numbers.
  [[nodiscard]] static Result<std::shared_ptr<const Mechanism>> make(MechanismSpec spec);

  [[nodiscard]] const std::string& name() const { return name_; }
  [[nodiscard]] std::span<const Link> links() const { return links_; }
  [[nodiscard]] int link_count() const { return static_cast<int>(links_.size()); }
  [[nodiscard]] const Link& link(int i) const { return links_[static_cast<std::size_t>(i)]; }
  [[nodiscard]] int nq() const { return nq_; }
  [[nodiscard]] int nv() const { return nv_; }
  [[nodiscard]] double mass() const { return mass_; }  ///< kg, virtual links included
  /// Loops: first those of the spec in its order, then one weld for each virtual link, named after it.
  [[nodiscard]] std::span<const Loop> loops() const { return loops_; }
  [[nodiscard]] bool has_loops() const { return !loops_.empty(); }
  /// Index of the loop with this name, or -1. O(loops).
  [[nodiscard]] int find_loop(std::string_view name) const;
  /// Index of the link with this name, or -1. O(links).
  [[nodiscard]] int find_link(std::string_view name) const;
  /// The link to which freedom i of v belongs.
  [[nodiscard]] int link_of_freedom(int i) const { return link_of_freedom_[static_cast<std::size_t>(i)]; }
  /// Freedom i's parent in the tree of freedoms: the previous one of the same joint, or the last one of the nearest
  /// movable ancestor; -1 at the base. (Featherstone's lambda.)
  [[nodiscard]] std::span<const int> freedom_parents() const { return freedom_parents_; }
  /// The properties of freedom i of v.
  [[nodiscard]] const Freedom& freedom(int i) const;
  /// Neutral position. [nq]
  [[nodiscard]] std::vector<double> neutral() const;
  /// The form people write, for saving and editing.
  [[nodiscard]] MechanismSpec spec() const;

 private:
  Mechanism() = default;
  std::string name_;
  std::vector<Link> links_;
  std::vector<Loop> loops_;
  std::vector<int> link_of_freedom_;
  std::vector<int> freedom_parents_;
  int nq_ = 0, nv_ = 0;
  double mass_ = 0;
};

using MechanismPtr = std::shared_ptr<const Mechanism>;

}  // namespace ugoki
