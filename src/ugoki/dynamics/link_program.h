#pragma once
// A mechanism compiled for the fast kernels: a flat list of nodes. A node is one body with one simple joint to its parent node.
//
// Fixed links are merged into the body to which they are fixed. Cylindrical, planar, universal and non-base floating joints become
// chains of simple joints with massless bodies in between. Nodes are in depth-first order: the first child of node i is node i + 1,
// and the subtree of a node is an index range. The origin of a node's frame is at the node's joint; its z axis is the joint's axis.
// If the joint's axis is a coordinate axis and the joint's frame is not rotated, the frames of node and parent differ only by a
// cyclic permutation of x, y, z, which needs no arithmetic.

#include <cstdint>
#include <span>
#include <vector>

#include "ugoki/mechanism/mechanism.h"
#include "ugoki/spatial/lane_array.h"

namespace ugoki::dynamics {

enum class NodeKind : std::uint8_t { revolute, prismatic, helical, spherical, floating };
/// Number of degrees of freedom of a node.
[[nodiscard]] constexpr int dofs_of(NodeKind kind) { return kind == NodeKind::floating ? 6 : kind == NodeKind::spherical ? 3 : 1; }

/// Form of NodeConstants::R, the rotation of a node's frame at q = 0 in its parent's frame. The form selects the code that transforms
/// vectors across the joint. For revolute joints R may be the identity (`none`) or a cyclic permutation: R v = (v.z, v.x, v.y)
/// for `cycle`, (v.y, v.z, v.x) for `cycle_back`. All other nodes use a full rotation matrix (`matrix`).
enum class Crossing : std::uint8_t { none, cycle, cycle_back, matrix };

/// Set of coordinate axes: x is bit 0, y bit 1, z bit 2.
using Axes = std::uint8_t;

/// Position of one node in the tree, and flags that select the kernels' code for it. Independent of the scalar type.
struct NodeOrder {
  NodeKind kind = NodeKind::revolute;
  Crossing crossing = Crossing::matrix;
  bool has_child = false;        ///< node + 1 is a child of this node
  bool first_child = false;      ///< node - 1 is the parent of this node
  bool last_child = false;       ///< the parent has several children, and this node is the last one
  bool turned = true;            ///< NodeConstants::R is not the identity
  bool massless = false;         ///< NodeConstants::mass, h and I are all zero
  bool oblique = false;          ///< the products of inertia (off-diagonal entries of I) are not all zero
  bool has_armature = false;     ///< NodeConstants::armature is not all zero
  bool reversed = false;         ///< NodeConstants::sign is -1
  bool children_offset = false;  ///< a child is not revolute or has its origin away from this node's origin
  Axes offset = 0;               ///< nonzero coordinates of NodeConstants::p
  Axes moment = 0;               ///< nonzero coordinates of NodeConstants::h
  int parent = -1;               ///< index of the parent node; -1: the world
  int level = 0;                 ///< number of ancestor nodes
  int slot = -1;                 ///< nodes with several children: index in the array of sums over children; else -1
  int q = 0, v = 0;              ///< first coordinate in q and first DOF in v
  int angle = -1;                ///< index of the joint angle among those of all revolute and helical nodes; -1: none
  int end = 0;                   ///< the subtree is the node range [node, end)
  int force_begin = 0;           ///< the DOFs of the subtree are [force_begin, force_end) in LinkProgram::force_dof;
  int force_end = 0;             ///< end of that range; the node's own DOFs are last in it, in descending order
  int twin_slot = -1;            ///< base node of twins (link_twins.h): index in the array of sums over its twins; else -1
};

/// Constants of a node. @tparam Real double, float, or LaneArray for a pair of twins (link_twins.h)
template <class Real>
struct alignas(64) NodeConstants {  // the members used most are in the first two cache lines
  Real p[3];                        ///< m: origin of the node's frame at q = 0 in the parent's frame
  Real sign;                        ///< +1: the joint turns about or slides along +z; -1: -z
  Real mass, h[3];                  ///< kg; kg m: mass times centre of mass, in the node's frame
  Real spread[3];                   ///< kg m^2: Izz - Iyy, Ixx - Izz, Iyy - Ixx
  Real I[6];                        ///< kg m^2: inertia about the node's origin, order xx yy zz xy xz yz
  Real second[6];                   ///< kg m^2: second moments of mass, tr(I)/2 1 - I, ordered as I
  Real armature[6];                 ///< kg | kg m^2: one for each DOF of the node
  Real R[9];                        ///< rotation of the node's frame at q = 0 in the parent's frame, row-major
  Real pitch;                       ///< m/rad: helical joints only
};

/// The node that carries a link, and the link's pose on it.
struct LinkAttachment {
  int node = -1;  ///< -1: the link is fixed to the world
  Pose X_NL;      ///< pose of the link's frame in the node's frame; if node is -1, in the world frame
};

/// The compiled mechanism. Immutable after construction.
struct LinkProgram {
  explicit LinkProgram(const Mechanism& mechanism);

  std::vector<NodeOrder> order;                  ///< [nodes] positions of the nodes in the tree
  std::vector<NodeConstants<double>> constants;  ///< [nodes] constants of the nodes
  std::vector<LinkAttachment> links;             ///< [links] node that carries each link
  std::vector<int> angle_q;                      ///< [angles] index in q of each angle
  std::vector<double> angle_sign;                ///< [angles] NodeConstants::sign of the angle's node
  std::vector<int> force_dof;                    ///< [nv] all DOFs, ordered from the last node to the first
  int slots = 0;                                 ///< number of nodes with several children: size of the array that NodeOrder::slot indexes
  int nq = 0, nv = 0;

  [[nodiscard]] int nodes() const { return static_cast<int>(order.size()); }
  [[nodiscard]] int angles() const { return static_cast<int>(angle_q.size()); }
};

/// Sets has_child, first_child, last_child and slot of every node from its parent. @return the number of slots
int mark_children(std::span<NodeOrder> order);

/// The constants rounded to single precision.
[[nodiscard]] std::vector<NodeConstants<float>> in_single_precision(std::span<const NodeConstants<double>> constants);

}  // namespace ugoki::dynamics
