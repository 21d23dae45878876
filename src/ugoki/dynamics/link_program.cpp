#include "ugoki/dynamics/link_program.h"

#include <algorithm>

namespace ugoki::dynamics {
namespace {

/// A node before the nodes are numbered depth first. Drafts are in the order of the mechanism's links.
struct Draft {
  NodeKind kind;
  int parent;       // index of the parent draft; -1: the world
  Pose X_PN;        // pose of the node's frame in the parent node's frame at q = 0
  Mat3 Q;           // rotation of the node's frame in the frame of the node's joint
  Inertia inertia;  // inertia of all links merged into the node, in the node's frame
  int q, v;
  double sign = 1, pitch = 0;
  double armature[6] = {};
};

/// Rotation Q and sign with sign * (third column of Q) = joint axis. If the axis is along +-x, +-y or +-z, Q is a cyclic permutation.
struct Alignment {
  Mat3 Q;
  double sign;
};
Alignment align(const Vec3& axis) {
  constexpr Mat3 cyclic_x{0, 0, 1, 1, 0, 0, 0, 1, 0}, cyclic_y{0, 1, 0, 0, 0, 1, 1, 0, 0};
  for (const double sign : {1.0, -1.0}) {
    if (axis == Vec3{sign, 0, 0}) return {cyclic_x, sign};
    if (axis == Vec3{0, sign, 0}) return {cyclic_y, sign};
    if (axis == Vec3{0, 0, sign}) return {Mat3::identity(), sign};
  }
  return {to_matrix(rotation_between({0, 0, 1}, axis)), 1.0};
}

/// Turns the links of a mechanism into drafts, and finds the draft that carries each link.
class DraftBuilder {
 public:
  DraftBuilder(const Mechanism& m, LinkProgram& program) : m_(m), program_(program) {}

  void run() {
    program_.links.resize(m_.links().size());
    for (std::size_t i = 0; i < m_.links().size(); ++i) add_link(static_cast<int>(i));
  }
  std::vector<Draft> drafts;

 private:
  /// A frame to which the next joint is attached.
  struct Mount {
    int node;  ///< index of the draft that carries the frame; -1: the world
    Pose X;    ///< pose of the frame in that draft's frame, or in the world's
  };

  /// Appends a draft with one simple joint to the frame `at`. @return the joint's moving frame, parallel to `at` at q = 0
  Mount add(const Mount& at, NodeKind kind, const Vec3& axis, int q, int v, std::span<const Dof> dofs, double pitch = 0) {
    const bool aligned = kind != NodeKind::spherical && kind != NodeKind::floating;
    const Alignment a = aligned ? align(axis) : Alignment{Mat3::identity(), 1.0};
    Draft d{.kind = kind,
            .parent = at.node,
            .X_PN = {at.X.R * a.Q, at.X.p},
            .Q = a.Q,
            .inertia = {},
            .q = q,
            .v = v,
            .sign = a.sign,
            .pitch = pitch};
    for (std::size_t k = 0; k < dofs.size(); ++k) d.armature[k] = dofs[k].armature;
    drafts.push_back(d);
    return {static_cast<int>(drafts.size()) - 1, {a.Q.transposed(), {}}};
  }

  void add_link(int index) {
    const Link& link = m_.link(index);
    const Joint& j = link.joint;
    const LinkAttachment parent = link.parent < 0 ? LinkAttachment{} : program_.links[static_cast<std::size_t>(link.parent)];
    Mount at{parent.node, parent.X_NL * j.X_PJ};
    const std::span<const Dof> f = j.dofs;
    const int q = link.q_index, v = link.v_index;
    switch (j.type) {
      case JointType::fixed: break;
      case JointType::revolute: at = add(at, NodeKind::revolute, j.axis, q, v, f.first(1)); break;
      case JointType::prismatic: at = add(at, NodeKind::prismatic, j.axis, q, v, f.first(1)); break;
      case JointType::helical: at = add(at, NodeKind::helical, j.axis, q, v, f.first(1), j.pitch); break;
      case JointType::cylindrical:
        at = add(at, NodeKind::revolute, j.axis, q, v, f.first(1));
        at = add(at, NodeKind::prismatic, j.axis, q + 1, v + 1, f.subspan(1, 1));
        break;
      case JointType::planar:
        at = add(at, NodeKind::prismatic, {1, 0, 0}, q, v, f.first(1));
        at = add(at, NodeKind::prismatic, {0, 1, 0}, q + 1, v + 1, f.subspan(1, 1));
        at = add(at, NodeKind::revolute, {0, 0, 1}, q + 2, v + 2, f.subspan(2, 1));
        break;
      case JointType::universal:
        at = add(at, NodeKind::revolute, j.axis, q, v, f.first(1));
        at = add(at, NodeKind::revolute, j.axis2, q + 1, v + 1, f.subspan(1, 1));
        break;
      case JointType::spherical: at = add(at, NodeKind::spherical, {}, q, v, f.first(3)); break;
      case JointType::floating:
        if (at.node < 0) {
          at = add(at, NodeKind::floating, {}, q, v, f.first(6));
        } else {
          for (int k = 0; k < 3; ++k)
            at = add(at, NodeKind::prismatic, Mat3::identity().row(k), q + k, v + 3 + k, f.subspan(static_cast<std::size_t>(3 + k), 1));
          at = add(at, NodeKind::spherical, {}, q + 3, v, f.first(3));
        }
        break;
    }
    program_.links[static_cast<std::size_t>(index)] = {at.node, at.X};
    if (at.node >= 0) drafts[static_cast<std::size_t>(at.node)].inertia += link.inertia.in_parent(at.X);
  }

  const Mechanism& m_;
  LinkProgram& program_;
};

/// Numbers the drafts depth first, children in the order of their drafts: node_of[draft] is the node's index. O(nodes), no recursion.
std::vector<int> depth_first(std::span<const Draft> drafts) {
  const std::size_t n = drafts.size();
  std::vector<int> first(n, -1), next(n, -1), node_of(n), open;
  std::vector<int> roots;
  for (std::size_t i = n; i-- > 0;) {
    const int parent = drafts[i].parent;
    if (parent < 0) {
      roots.push_back(static_cast<int>(i));
    } else {
      next[i] = first[static_cast<std::size_t>(parent)];
      first[static_cast<std::size_t>(parent)] = static_cast<int>(i);
    }
  }
  int count = 0;
  std::vector<int> children;
  open = roots;  // used as a stack: `roots` is in descending order, so the first root is on top
  while (!open.empty()) {
    const auto i = static_cast<std::size_t>(open.back());
    open.pop_back();
    node_of[i] = count++;
    children.clear();
    for (int c = first[i]; c >= 0; c = next[static_cast<std::size_t>(c)]) children.push_back(c);
    open.insert(open.end(), children.rbegin(), children.rend());
  }
  return node_of;
}

Crossing crossing_of(NodeKind kind, const Mat3& R) {
  if (kind != NodeKind::revolute) return Crossing::matrix;
  if (R == Mat3::identity()) return Crossing::none;
  if (R == Mat3{0, 0, 1, 1, 0, 0, 0, 1, 0}) return Crossing::cycle;
  if (R == Mat3{0, 1, 0, 0, 0, 1, 1, 0, 0}) return Crossing::cycle_back;
  return Crossing::matrix;
}

NodeConstants<double> constants_of(const Draft& d) {
  NodeConstants<double> c{};
  const Vec3& p = d.X_PN.p;
  const Mat3& R = d.X_PN.R;
  const Inertia& inertia = d.inertia;
  const double position[] = {p.x, p.y, p.z}, h[] = {inertia.h.x, inertia.h.y, inertia.h.z};
  const double rotation[] = {R.xx, R.xy, R.xz, R.yx, R.yy, R.yz, R.zx, R.zy, R.zz};
  const double I[] = {inertia.I.xx, inertia.I.yy, inertia.I.zz, inertia.I.xy, inertia.I.xz, inertia.I.yz};
  std::ranges::copy(position, c.p);
  std::ranges::copy(h, c.h);
  std::ranges::copy(rotation, c.R);
  std::ranges::copy(I, c.I);
  const double half_trace = 0.5 * (I[0] + I[1] + I[2]);
  for (int k = 0; k < 6; ++k) c.second[k] = (k < 3 ? half_trace : 0.0) - I[k];
  for (int k = 0; k < 3; ++k) c.spread[k] = I[(k + 2) % 3] - I[(k + 1) % 3];
  std::ranges::copy(d.armature, c.armature);
  c.sign = d.sign;
  c.mass = inertia.mass;
  c.pitch = d.pitch;
  return c;
}

Axes axes_of(const double* x) { return static_cast<Axes>((x[0] != 0 ? 1 : 0) | (x[1] != 0 ? 2 : 0) | (x[2] != 0 ? 4 : 0)); }

}  // namespace

LinkProgram::LinkProgram(const Mechanism& m) : nq(m.nq()), nv(m.nv()) {
  DraftBuilder builder(m, *this);
  builder.run();
  const std::span<const Draft> drafts = builder.drafts;
  const std::vector<int> node_of = depth_first(drafts);
  std::vector<std::size_t> draft_of(drafts.size());
  for (std::size_t i = 0; i < drafts.size(); ++i) draft_of[static_cast<std::size_t>(node_of[i])] = i;
  for (LinkAttachment& link : links)
    if (link.node >= 0) link.node = node_of[static_cast<std::size_t>(link.node)];

  std::vector<int> last(drafts.size(), -1);  // last child of each node; -1: none
  for (std::size_t i = 0; i < drafts.size(); ++i) {
    const Draft& d = drafts[draft_of[i]];
    NodeOrder node;
    node.kind = d.kind;
    node.crossing = crossing_of(d.kind, d.X_PN.R);
    node.turned = d.X_PN.R != Mat3::identity();
    node.massless = d.inertia == Inertia{};
    node.parent = d.parent < 0 ? -1 : node_of[static_cast<std::size_t>(d.parent)];
    node.level = node.parent < 0 ? 0 : order[static_cast<std::size_t>(node.parent)].level + 1;
    node.q = d.q;
    node.v = d.v;
    if (d.kind == NodeKind::revolute || d.kind == NodeKind::helical) {
      node.angle = angles();
      angle_q.push_back(d.q);
      angle_sign.push_back(d.sign);
    }
    if (node.parent >= 0) last[static_cast<std::size_t>(node.parent)] = static_cast<int>(i);
    constants.push_back(constants_of(d));
    const NodeConstants<double>& c = constants.back();
    node.offset = axes_of(c.p);
    node.moment = axes_of(c.h);
    node.oblique = axes_of(c.I + 3) != 0;
    node.has_armature = axes_of(c.armature) != 0 || axes_of(c.armature + 3) != 0;
    node.reversed = c.sign < 0;
    if (node.parent >= 0)
      order[static_cast<std::size_t>(node.parent)].children_offset |= node.offset != 0 || node.kind != NodeKind::revolute;
    order.push_back(node);
  }
  slots = mark_children(order);
  for (std::size_t i = order.size(); i-- > 0;) {
    order[i].force_begin = last[i] < 0 ? static_cast<int>(force_dof.size()) : order[static_cast<std::size_t>(last[i])].force_begin;
    for (int k = dofs_of(order[i].kind); k-- > 0;) force_dof.push_back(order[i].v + k);
    order[i].force_end = static_cast<int>(force_dof.size());
    order[i].end = last[i] < 0 ? static_cast<int>(i) + 1 : order[static_cast<std::size_t>(last[i])].end;
  }
}

int mark_children(std::span<NodeOrder> order) {
  std::vector<int> children(order.size()), last(order.size(), -1);
  for (std::size_t i = 0; i < order.size(); ++i) {
    NodeOrder& o = order[i];
    o.has_child = o.first_child = o.last_child = false;
    o.slot = -1;
    if (o.parent < 0) continue;
    const auto p = static_cast<std::size_t>(o.parent);
    ++children[p];
    last[p] = static_cast<int>(i);
    o.first_child = p + 1 == i;
    if (o.first_child) order[p].has_child = true;
  }
  int slots = 0;
  for (std::size_t i = order.size(); i-- > 0;) {
    if (children[i] < 2) continue;
    order[i].slot = slots++;
    order[static_cast<std::size_t>(last[i])].last_child = true;
  }
  return slots;
}

std::vector<NodeConstants<float>> in_single_precision(std::span<const NodeConstants<double>> constants) {
  std::vector<NodeConstants<float>> out(constants.size());
  const auto convert = [](auto& to, const auto& from) { std::ranges::transform(from, to, [](double x) { return static_cast<float>(x); }); };
  for (std::size_t i = 0; i < out.size(); ++i) {
    const NodeConstants<double>& c = constants[i];
    convert(out[i].p, c.p);
    convert(out[i].h, c.h);
    convert(out[i].I, c.I);
    convert(out[i].spread, c.spread);
    convert(out[i].second, c.second);
    convert(out[i].armature, c.armature);
    convert(out[i].R, c.R);
    out[i].sign = static_cast<float>(c.sign);
    out[i].mass = static_cast<float>(c.mass);
    out[i].pitch = static_cast<float>(c.pitch);
  }
  return out;
}

}  // namespace ugoki::dynamics
