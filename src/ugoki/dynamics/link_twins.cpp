#include "ugoki/dynamics/link_twins.h"

#include <algorithm>

namespace ugoki::dynamics {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }
int int_of(std::size_t n) { return static_cast<int>(n); }

/// Number of coordinates of a node of this kind in a twin subtree. A floating node is a root of the tree, so it is never in a twin.
int coordinates_of(NodeKind kind) { return kind == NodeKind::spherical ? 4 : 1; }

/// Finds the pairs of twins in a program and fills in a LinkTwins.
class Search {
 public:
  Search(const LinkProgram& program, LinkTwins& twins) : p_(program), t_(twins), lane_(at(program.nodes())) {}

  void run() {
    for (int i = 0; i < p_.nodes(); ++i)
      if (lane_[at(i)] == 0) pair_children(i);
    make_trunk();
    for (const auto& [a, b] : found_) make_pair(a, b);
    order_forces();
    gather_angles();
  }

 private:
  [[nodiscard]] const NodeOrder& order(int i) const { return p_.order[at(i)]; }

  /// Records the pairs of twins among the children of a trunk node.
  void pair_children(int base) {
    std::vector<int> children;
    for (int c = base + 1; c < order(base).end; c = order(c).end) children.push_back(c);
    for (std::size_t i = 0; i < children.size(); ++i)
      for (std::size_t j = i + 1; j < children.size(); ++j) {
        const int a = children[i], b = children[j];
        if (lane_[at(a)] != 0 || lane_[at(b)] != 0 || int_of(found_.size()) == TwinArguments::max_pairs || !alike(a, b)) continue;
        for (int k = a; k < order(a).end; ++k) {
          lane_[at(k)] = 1;
          lane_[at(b + k - a)] = 2;
        }
        found_.emplace_back(a, b);
      }
  }

  /// True if the subtrees of nodes a and b have the same joints in the same order and are large enough to run as a pair.
  [[nodiscard]] bool alike(int a, int b) const {
    constexpr int min_nodes = 3;  // for smaller subtrees, copying values into SIMD lanes costs more than the lanes save
    if (order(a).end - a < min_nodes || order(a).end - a != order(b).end - b) return false;
    for (int k = 0; k < order(a).end - a; ++k) {
      const NodeOrder &x = order(a + k), &y = order(b + k);
      if (x.kind != y.kind || x.crossing != y.crossing || x.turned != y.turned || x.massless != y.massless) return false;
      if (k > 0 && x.parent - a != y.parent - b) return false;
    }
    return true;
  }

  void make_trunk() {
    trunk_of_.assign(at(p_.nodes()), -1);
    LinkTwins::Part<double>& t = t_.trunk;
    for (int i = 0; i < p_.nodes(); ++i) {
      if (lane_[at(i)] != 0) continue;
      trunk_of_[at(i)] = int_of(t.order.size());
      NodeOrder o = order(i);
      o.parent = o.parent < 0 ? -1 : trunk_of_[at(o.parent)];
      if (o.angle >= 0) {
        t.angle_q.push_back(p_.angle_q[at(o.angle)]);
        t.angle_sign.push_back(p_.angle_sign[at(o.angle)]);
        o.angle = int_of(t.angle_q.size()) - 1;
      }
      t.order.push_back(o);
      t.node.push_back(i);
      t.constants.push_back(p_.constants[at(i)]);
    }
    t.nq = p_.nq;
    t.nv = p_.nv;
    t.slots = mark_children(t.order);
    t_.scratch = rounded(scratch_size(int_of(t.order.size()), t.nv, t.slots, int_of(t.angle_q.size()), sizeof(double), 1));
  }

  void make_pair(int a, int b) {
    LinkTwins::Pair t;
    for (int i = a; i < order(a).end; ++i) {
      NodeOrder o = order(i);
      const NodeOrder& other = order(b + i - a);
      o.offset |= other.offset;
      o.moment |= other.moment;
      o.oblique |= other.oblique;
      o.has_armature |= other.has_armature;
      o.children_offset |= other.children_offset;
      o.parent = i == a ? -1 : o.parent - a;
      if (o.angle >= 0) {
        for (const NodeOrder* x : {&order(i), &other}) t.angle_sign.push_back(p_.angle_sign[at(x->angle)]);
        o.angle = int_of(t.angle_q.size());
        t.angle_q.push_back(t.nq);
      }
      for (int k = 0; k < coordinates_of(o.kind); ++k) t.q_of.insert(t.q_of.end(), {order(i).q + k, other.q + k});
      for (int k = 0; k < dofs_of(o.kind); ++k) t.v_of.insert(t.v_of.end(), {order(i).v + k, other.v + k});
      o.force_begin -= order(a).force_begin;
      o.force_end -= order(a).force_begin;
      o.q = t.nq;
      o.v = t.nv;
      t.nq = int_of(t.q_of.size() / 2);
      t.nv = int_of(t.v_of.size() / 2);
      t.order.push_back(o);
      t.node.insert(t.node.end(), {i, b + i - a});
      t.constants.push_back(side_by_side(p_.constants[at(i)], p_.constants[at(b + i - a)]));
    }
    for (int k = 0; k < order(a).force_end - order(a).force_begin; ++k)
      for (const int root : {a, b}) t.force_dof.push_back(p_.force_dof[at(order(root).force_begin + k)]);
    for (const NodeOrder& o : t.order)
      for (int k = 0; k < dofs_of(o.kind); ++k) t.entries += 2 * (o.force_end - o.force_begin - k);
    t.slots = mark_children(t.order);
    t.base = trunk_of_[at(order(a).parent)];
    int& slot = t_.trunk.order[at(t.base)].twin_slot;
    t.first = slot < 0;
    if (t.first) slot = t_.twin_slots++;
    t.twin_slot = slot;
    t.scratch = t_.scratch;
    // Memory for two lanes: arrays q, v, in and out, and scratch memory of the kernels
    t_.scratch += rounded(scratch_size(int_of(t.order.size()), t.nv, t.slots, int_of(t.angle_q.size()), sizeof(double), 2));
    t_.pairs.push_back(std::move(t));
  }

  /// Rebuilds force_begin, force_end and force_dof of the trunk. A node's range contains the DOFs of its subtree in the trunk, then the
  /// DOFs of the pairs of twins attached to the node, then its own DOFs.
  void order_forces() {
    LinkTwins::Part<double>& t = t_.trunk;
    std::vector<int> begin(t.order.size(), -1);  // index in force_dof where each node's subtree starts; -1: no child visited yet
    for (std::size_t i = t.order.size(); i-- > 0;) {
      NodeOrder& o = t.order[i];
      o.force_begin = begin[i] < 0 ? int_of(t.force_dof.size()) : begin[i];
      for (std::size_t k = t_.pairs.size(); k-- > 0;) {
        LinkTwins::Pair& pair = t_.pairs[k];
        if (pair.base != int_of(i)) continue;
        pair.force_begin = int_of(t.force_dof.size());
        t.force_dof.insert(t.force_dof.end(), pair.force_dof.begin(), pair.force_dof.end());
      }
      for (int k = dofs_of(o.kind); k-- > 0;) t.force_dof.push_back(o.v + k);
      o.force_end = int_of(t.force_dof.size());
      if (o.parent >= 0 && begin[at(o.parent)] < 0) begin[at(o.parent)] = o.force_begin;
    }
  }

  void gather_angles() {
    t_.angle_q = t_.trunk.angle_q;
    t_.angle_sign = t_.trunk.angle_sign;
    const auto fill_up = [&](std::size_t unit) {
      while (t_.angle_q.size() % unit != 0) {
        t_.angle_q.push_back(0);
        t_.angle_sign.push_back(0);
      }
    };
    for (LinkTwins::Pair& pair : t_.pairs) {
      fill_up(2);
      pair.angle_begin = int_of(t_.angle_q.size());
      for (const int q : pair.angle_q) t_.angle_q.insert(t_.angle_q.end(), {pair.q_of[at(2 * q)], pair.q_of[at(2 * q + 1)]});
      t_.angle_sign.insert(t_.angle_sign.end(), pair.angle_sign.begin(), pair.angle_sign.end());
    }
    fill_up(16);
    t_.sines = t_.scratch;
    t_.scratch += 2 * t_.angle_q.size() * sizeof(double);
  }

  static NodeConstants<LinkTwins::Both> side_by_side(const NodeConstants<double>& a, const NodeConstants<double>& b) {
    NodeConstants<LinkTwins::Both> c{};
    const auto both = [](LinkTwins::Both* to, const double* x, const double* y, int n) {
      for (int k = 0; k < n; ++k) to[k] = {{x[k], y[k]}};
    };
    both(c.p, a.p, b.p, 3);
    both(&c.sign, &a.sign, &b.sign, 1);
    both(&c.mass, &a.mass, &b.mass, 1);
    both(c.h, a.h, b.h, 3);
    both(c.I, a.I, b.I, 6);
    both(c.spread, a.spread, b.spread, 3);
    both(c.second, a.second, b.second, 6);
    both(c.armature, a.armature, b.armature, 6);
    both(c.R, a.R, b.R, 9);
    both(&c.pitch, &a.pitch, &b.pitch, 1);
    return c;
  }
  static std::size_t rounded(std::size_t bytes) { return (bytes + 63) / 64 * 64; }

  const LinkProgram& p_;
  LinkTwins& t_;
  std::vector<char> lane_;                  ///< [nodes] 0: trunk, 1: first twin, 2: second twin of a pair
  std::vector<int> trunk_of_;               ///< [nodes] index of the node in the trunk; -1: the node is in a pair
  std::vector<std::pair<int, int>> found_;  ///< root nodes of the two twins of each pair
};

template <class Constant>
KernelArguments<double, Constant> part_arguments(const LinkTwins::Part<Constant>& part, const KernelArguments<double>& whole) {
  KernelArguments<double, Constant> a{};
  a.order = part.order.data();
  a.constants = part.constants.data();
  a.nodes = int_of(part.order.size());
  a.slots = part.slots;
  a.nv = part.nv;
  a.angle_q = part.angle_q.data();
  a.angle_sign = part.angle_sign.data();
  a.angles = int_of(part.angle_q.size());
  std::ranges::copy(whole.gravity, a.gravity);
  return a;
}

}  // namespace

std::vector<std::pair<int, int>> LinkTwins::entry_dofs() const {
  std::vector<std::pair<int, int>> out;
  const auto append = [&](const std::vector<NodeOrder>& order, const std::vector<int>& force_dof, int lanes) {
    for (std::size_t i = order.size(); i-- > 0;) {
      const NodeOrder& o = order[i];
      for (int k = 0; k < dofs_of(o.kind); ++k)
        for (int e = o.force_begin * lanes; e < (o.force_end - k) * lanes; ++e)
          out.emplace_back(force_dof[at((o.force_end - 1 - k) * lanes + e % lanes)], force_dof[at(e)]);
    }
  };
  for (std::size_t i = pairs.size(); i-- > 0;) append(pairs[i].order, pairs[i].force_dof, 2);
  append(trunk.order, trunk.force_dof, 1);
  return out;
}

LinkTwins::LinkTwins(const LinkProgram& program) { Search(program, *this).run(); }

TwinArguments LinkTwins::arguments(const KernelArguments<double>& whole) const {
  TwinArguments out;
  out.trunk = part_arguments(trunk, whole);
  out.trunk.q = whole.q;
  out.trunk.v = whole.v;
  out.trunk.in = whole.in;
  out.trunk.out = whole.out;
  out.trunk.scratch = whole.scratch;
  out.trunk.stride = 1;
  out.angle_q = angle_q.data();
  out.angle_sign = angle_sign.data();
  out.angles = int_of(angle_q.size());
  double* const sin = reinterpret_cast<double*>(whole.scratch + sines);
  double* const cos = sin + angle_q.size();
  out.trunk.sin = sin;
  out.trunk.cos = cos;
  out.trunk_node = trunk.node.data();
  out.pair_count = int_of(pairs.size());
  out.twin_slots = twin_slots;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const Pair& p = pairs[i];
    TwinArguments::Pair& to = out.pairs[i];
    to = {part_arguments(p, whole),
          nullptr,
          nullptr,
          nullptr,
          p.nq,
          p.q_of.data(),
          p.v_of.data(),
          p.node.data(),
          p.base,
          p.twin_slot,
          p.force_begin,
          p.first};
    std::byte* next = whole.scratch + p.scratch;
    const auto allocate = [&](int n) {
      return reinterpret_cast<double*>(std::exchange(next, next + (at(n) * sizeof(double) + 63) / 64 * 64));
    };
    to.a.q = to.q = allocate(2 * p.nq);
    to.a.v = to.v = allocate(2 * p.nv);
    to.in = allocate(2 * p.nv);
    to.a.in = whole.in == nullptr ? nullptr : to.in;
    to.a.out = allocate(2 * p.nv);
    if (whole.entry_index != nullptr) to.a.out = whole.out;  // the pair writes its inertia matrix entries directly to whole.out
    to.a.scratch = next;
    to.a.stride = 2;
    to.a.sin = sin + p.angle_begin;
    to.a.cos = cos + p.angle_begin;
  }
  // In entry_index the matrix entries of the pairs come first, last pair first (see entry_dofs)
  if (const int* next_entry = whole.entry_index; next_entry != nullptr) {
    for (std::size_t i = pairs.size(); i-- > 0;) {
      out.pairs[i].a.entry_index = next_entry;
      next_entry += pairs[i].entries;
    }
    out.trunk.entry_index = next_entry;
  }
  return out;
}

}  // namespace ugoki::dynamics
