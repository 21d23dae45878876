#pragma once
// A mechanism as the fast kernels run it: a flat list of one-step operations ("nodes"), each a body with one simple joint.
//
// Fixed links are merged into the body they are fixed to; cylindrical, planar, universal and non-base floating joints become
// chains of simple joints with massless bodies between. Nodes stand in depth-first order, so that the first child of node i is
// i + 1 and a subtree is a range. A node's frame sits at its joint, its z along the joint's axis. Where the axis is a coordinate
// axis and the joint's frame is not turned, the frames differ by a cyclic exchange of x, y, z, which costs nothing.

#include <cstdint>
#include <span>
#include <vector>

#include "ugoki/mechanism/mechanism.h"
#include "ugoki/spatial/lane_array.h"

namespace ugoki::dynamics {

enum class NodeKind : std::uint8_t { revolute, prismatic, helical, spherical, floating };
[[nodiscard]] constexpr int freedoms_of(NodeKind kind) { return kind == NodeKind::floating ? 6 : kind == NodeKind::spherical ? 3 : 1; }

/// What a node costs to cross: a revolute joint whose frame is that of the parent with x, y, z exchanged cyclically (R v =
/// (v.z, v.x, v.y) for `cycle`, (v.y, v.z, v.x) for `cycle_back`), or a whole rotation matrix.
enum class Crossing : std::uint8_t { none, cycle, cycle_back, matrix };

/// Some of x (bit 0), y (bit 1), z (bit 2).
using Axes = std::uint8_t;

/// What does not depend on the scalar.
struct NodeOrder {
  NodeKind kind = NodeKind::revolute;
  Crossing crossing = Crossing::matrix;
  bool has_child = false;    ///< node + 1 is its child
  bool first_child = false;  ///< node - 1 is its parent
  bool last_child = false;   ///< of a parent with several children: the one that comes last
  bool turned = true;        ///< R is not the identity
  bool massless = false;     ///< mass, h and I are zero
  bool oblique = false;      ///< I has products of inertia
  bool armed = false;        ///< armature is not zero
  bool reversed = false;     ///< sign is -1
  bool bends = false;        ///< its children's origins are not all its own
  Axes offset = 0;           ///< coordinates of p that are not zero
  Axes moment = 0;           ///< coordinates of h that are not zero
  int parent = -1;           ///< node; -1: the world
  int level = 0;             ///< nodes above
  int slot = -1;             ///< of a node with several children: where what they pass on is added up
  int q = 0, v = 0;          ///< first coordinate and freedom
  int angle = -1;            ///< place of its angle among those of all revolute and helical nodes
  int end = 0;               ///< its subtree is [node, end)
  int force_begin = 0;       ///< the freedoms of its subtree are [force_begin, force_end) in force_freedom, its own the last,
  int force_end = 0;         ///< the first of them at the end
  int twins = -1;            ///< of a node that carries twins: the place of what they hand on (link_twins.h)
};

/// Constants of a node; Real: double or float.
template <class Real>
struct alignas(64) NodeConstants {  // what most kernels need of most nodes is in the first two cache lines
  Real p[3];                        ///< m: the node's origin in the parent's frame at q = 0
  Real sign;                        ///< +1; -1: the joint turns about, or slides along, -z
  Real mass, h[3];                  ///< kg, kg m: in the node's frame
  Real spread[3];                   ///< kg m^2: Izz - Iyy, Ixx - Izz, Iyy - Ixx
  Real I[6];                        ///< kg m^2 about the node's origin: xx yy zz xy xz yz
  Real second[6];                   ///< kg m^2: second moments of mass, tr(I)/2 1 - I, in the order of I
  Real armature[6];                 ///< of its freedoms
  Real R[9];                        ///< rotation of the node's frame at q = 0 in the parent's, row by row
  Real pitch;                       ///< m/rad (helical)
};

struct LinkPlace {
  int node = -1;  ///< the body that carries the link; -1: fixed to the world
  Pose X_NL;      ///< the link's frame in the node's (in the world)
};

struct LinkProgram {
  explicit LinkProgram(const Mechanism& mechanism);

  std::vector<NodeOrder> order;                  ///< [nodes]
  std::vector<NodeConstants<double>> constants;  ///< [nodes]
  std::vector<LinkPlace> links;                  ///< [links]
  std::vector<int> angle_q;                      ///< [angles] the coordinate of each angle
  std::vector<double> angle_sign;                ///< [angles]
  std::vector<int> force_freedom;                ///< [nv] freedoms from the last node's to the first's
  int slots = 0;
  int nq = 0, nv = 0;

  [[nodiscard]] int nodes() const { return static_cast<int>(order.size()); }
  [[nodiscard]] int angles() const { return static_cast<int>(angle_q.size()); }
};

/// Sets who comes first and last among a node's children, and the slots of nodes with several. @return how many slots
int mark_children(std::span<NodeOrder> order);

/// The constants in single precision.
[[nodiscard]] std::vector<NodeConstants<float>> in_single_precision(std::span<const NodeConstants<double>> constants);

}  // namespace ugoki::dynamics
