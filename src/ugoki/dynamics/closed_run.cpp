// Closed forward dynamics from q and v: runs the kernel's motion pass, computes the loops' rows, then runs the kernel's forward pass.

#include "ugoki/dynamics/closed_run.h"

#include <algorithm>

#include "ugoki/base/check.h"

namespace ugoki::dynamics {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

ClosedTree tree_of_nodes(const LinkProgram& program) {
  ClosedTree tree;
  tree.node_of_dof.resize(at(program.nv));
  for (const NodeOrder& o : program.order) {
    const int n = dofs_of(o.kind);
    for (int k = 0; k < n; ++k) tree.node_of_dof[at(o.v + k)] = static_cast<int>(tree.parent.size());
    tree.parent.push_back(o.parent);
    tree.dofs.push_back(n);
  }
  for (const LinkAttachment& attachment : program.links) tree.node_of_link.push_back(attachment.node);
  return tree;
}

/// The mechanism with inertias divided between real links and their massless virtual links; null if there is nothing to divide.
/// A real link and its n virtual links get 1 / (n + 1) of the inertia each.
MechanismPtr with_shares(const Mechanism& m, std::span<const InertiaShare> shares) {
  if (shares.empty()) return nullptr;
  MechanismSpec spec = m.spec();
  for (const InertiaShare& s : shares) {
    const Inertia& source = m.link(s.source).inertia;
    Inertia& share = spec.links[at(s.link)].inertia;
    share = {source.mass * s.part, source.h * s.part, source.I * s.part};
    if (s.link != s.source) share = share.in_parent(m.link(s.link).X_RV.inverse());
  }
  return Mechanism::make(std::move(spec)).value();
}

/// True if the loop connects a link with the world by a ball joint or a weld. The loop's rows need only the rotation and angular velocity
/// of the link's node. The rows state that the link's point at J_B does not accelerate and, for a weld, that the link has no angular
/// acceleration.
bool is_world_bound(const ClosedKernelState& k, const Loop& loop) {
  return k.by_paths && (loop.type == LoopType::weld || loop.type == LoopType::ball) && loop.link_a < 0 && loop.link_b >= 0 &&
         k.program.links[at(loop.link_b)].node >= 0;
}

Mat3 rotation_of(const NodeMotion& motion) {
  const double* R = motion.R;
  return {R[0], R[1], R[2], R[3], R[4], R[5], R[6], R[7], R[8]};
}
Vec3 vec(const double* p) { return {p[0], p[1], p[2]}; }

}  // namespace

ClosedKernelState::ClosedKernelState(const Mechanism& m, const ClosedLinks& links, std::span<const char> closed, std::span<const char> rows)
    : shared(with_shares(m, links.shares_)),
      program(shared ? *shared : m),
      over_nodes(tree_of_nodes(program), links.loops(), closed, links.rows().first, rows),
      twins(program),
      needed(program.order.size()),
      motion(program.order.size()),
      X_WB(m.links().size()),
      V(m.links().size()) {
  // With more than `few` loops by_paths stays false: eliminating all loops at the world can need a block of Lambda for each pair of loops.
  if (constexpr std::size_t few = 16; over_nodes.entries.size() <= few) {
    ClosedStructure at_world(tree_of_nodes(program), links.loops(), closed, links.rows().first, rows, ClosedStructure::Meeting::world);
    by_paths = paths_are_faster(program, over_nodes, at_world);
    if (by_paths) {
      over_nodes = std::move(at_world);
      paths = LoopPaths(program, over_nodes);
    }
  }
  for (const ClosedStructure::Entry& e : over_nodes.entries) {
    const Loop& loop = links.loops()[at(e.loop)];
    if (loop.type == LoopType::gear) continue;
    for (const int link : {loop.link_a, loop.link_b})
      if (link >= 0) end_links.push_back(link);
  }
  std::ranges::sort(end_links);
  end_links.erase(std::ranges::unique(end_links).begin(), end_links.end());
  world_bound = std::ranges::all_of(over_nodes.entries,
                                    [&](const ClosedStructure::Entry& e) { return is_world_bound(*this, links.loops()[at(e.loop)]); });
  for (const int link : end_links)
    for (int node = program.links[at(link)].node; node >= 0; node = program.order[at(node)].parent) needed[at(node)] = NodeWanted::passage;
  for (const int link : end_links)
    if (const int node = program.links[at(link)].node; node >= 0)
      needed[at(node)] = world_bound ? NodeWanted::rotation : NodeWanted::motion;
  P.resize(over_nodes.present.size());
  g.resize(over_nodes.entries.size());
  s.resize(by_paths ? paths.dof.size() : at(over_nodes.s_slots));
  t.resize(paths.dof.size());
  reduced.resize(g.size());
  lambda.resize(g.size());
  Lambda.resize(at(over_nodes.blocks));
  Y.resize(over_nodes.neighbours.size());
  factor.resize(g.size());
  mobility.resize(g.size());
  length2 = links.length_ * links.length_;
  for (const NodeOrder& o : program.order) turning.push_back(o.kind == NodeKind::prismatic ? 1 / length2 : 1.0);
  scratch.resize(scratch_size(program, sizeof(double), 1) / sizeof(CacheLine) + 1);
  if (by_paths && !twins.pairs.empty()) twin_scratch.resize(twins.scratch / sizeof(CacheLine) + 1);
}

/// One call of calc_closed_forward_dynamics() from q and v.
class ClosedRun {
 public:
  ClosedRun(const Mechanism& m, ClosedLinks& links, std::span<const double> q, std::span<const double> v)
      : m_(m), links_(links), k_(*links.kernel_), x_(k_.over_nodes), q_(q), v_(v) {}

  bool run(std::span<const double> tau, const Vec3& gravity, std::span<const Vec6> external, std::span<double> vdot) {
    const KernelArguments<double> a = arguments(tau, gravity, external, vdot);
    ClosedArguments c = closed_arguments();
    TwinArguments twins;
    if (!k_.twin_scratch.empty() && a.external == nullptr) {
      KernelArguments<double> with_twin_scratch = a;
      with_twin_scratch.scratch = k_.twin_scratch.data()->bytes;
      twins = k_.twins.arguments(with_twin_scratch);
      c.twins = &twins;
    }
    closed_kernels().motion(a, c);
    if (k_.world_bound) {
      for (std::size_t e = 0; e < x_.entries.size(); ++e) begin_world_bound(e, gravity);
    } else {
      move_end_links();
      update_loop_rows(m_, p0_, k_.X_WB, k_.V, links_.loops_, q_, v_, false, links_.rows_);
      if (!k_.by_paths) std::ranges::fill(k_.P, LoopColumns{});
      for (std::size_t e = 0; e < x_.entries.size(); ++e) begin_loop(e);
    }
    const bool ok = k_.by_paths ? closed_kernels().forward_by_paths(a, c) : closed_kernels().forward(a, c);
    if (ok) copy_results();
    return ok;
  }

 private:
  KernelArguments<double> arguments(std::span<const double> tau, const Vec3& gravity, std::span<const Vec6> external,
                                    std::span<double> vdot) {
    const LinkProgram& program = k_.program;
    return {.order = program.order.data(),
            .constants = program.constants.data(),
            .nodes = program.nodes(),
            .slots = program.slots,
            .nv = program.nv,
            .links = program.links.data(),
            .link_count = static_cast<int>(program.links.size()),
            .angle_q = program.angle_q.data(),
            .angle_sign = program.angle_sign.data(),
            .angles = program.angles(),
            .q = q_.data(),
            .v = v_.data(),
            .in = tau.empty() ? nullptr : tau.data(),
            .external = nonzero_wrenches(external),
            .out = vdot.data(),
            .gravity = {gravity.x, gravity.y, gravity.z},
            .scratch = k_.scratch.data()->bytes,
            .entry_index = nullptr,
            .stride = 1};
  }
  ClosedArguments closed_arguments() {
    return {.dependent = dependent_row,
            .immobile = immobile_row,
            .length2 = k_.length2,
            .entries = x_.entries.data(),
            .nodes = x_.nodes.data(),
            .present = x_.present.data(),
            .pairs = x_.pairs.data(),
            .eliminations = x_.eliminations.data(),
            .neighbours = x_.neighbours.data(),
            .updates = x_.updates.data(),
            .gears = x_.gears.data(),
            .entry_count = static_cast<int>(x_.entries.size()),
            .block_count = x_.blocks,
            .slope = links_.rows_.slope.data(),
            .turning = k_.turning.data(),
            .paths = &k_.paths,
            .twins = nullptr,
            .needed = k_.needed.data(),
            .world_bound = k_.world_bound,
            .motion = k_.motion.data(),
            .P = k_.P.data(),
            .g = k_.g.data(),
            .s = k_.s.data(),
            .t = k_.t.data(),
            .reduced = k_.reduced.data(),
            .mobility = k_.mobility.data(),
            .Lambda = k_.Lambda.data(),
            .Y = k_.Y.data(),
            .factor = k_.factor.data(),
            .lambda = k_.lambda.data()};
  }

  /// Computes poses and velocities of the links that loops connect, and the reference point p0_ of the wrenches. p0_ is the origin of the
  /// first such link, so that wrenches keep their accuracy far from the world origin.
  void move_end_links() {
    bool first = true;
    for (const int link : k_.end_links) {
      const LinkAttachment& attachment = k_.program.links[at(link)];
      Pose X = attachment.X_NL;
      Vec6 V;
      if (attachment.node >= 0) {
        const NodeMotion& motion = k_.motion[at(attachment.node)];
        const Pose X_WN{rotation_of(motion), vec(motion.p)};
        X = X_WN * attachment.X_NL;
        if (first) p0_ = X.p;
        V.w = vec(motion.w);
        V.v = vec(motion.v) + cross(V.w, p0_ - X_WN.p);
      } else if (first) {
        p0_ = X.p;
      }
      first = false;
      k_.X_WB[at(link)] = X;
      k_.V[at(link)] = V;
    }
  }

  /// Sets the loop's unit wrenches P at its two nodes, and its residual g.
  void begin_loop(std::size_t index) {
    const ClosedStructure::Entry& e = x_.entries[index];
    const Loop& loop = links_.loops_[at(e.loop)];
    LoopLanes& g = k_.g[index];
    g = {};
    for (int k = 0; k < e.rows; ++k) g.x[k] = links_.rows_.drift[at(x_.row[at(e.first + k)])];
    if (loop.type == LoopType::gear) return;
    if (k_.by_paths) k_.P[at(e.present_a)] = k_.P[at(e.present_b)] = {};
    add_end(e, loop.link_b, e.present_b, -1, g);
    add_end(e, loop.link_a, e.present_a, 1, g);
  }
  /// Adds the unit wrenches of a loop at one of its links to P, in the axes of the link's node about the node's origin.
  /// @param sign -1 for link b, 1 for link a
  void add_end(const ClosedStructure::Entry& e, int link, int present, double sign, LoopLanes& g) {
    LoopColumns& P = k_.P[at(present)];
    const int node = link < 0 ? -1 : k_.program.links[at(link)].node;
    Mat3 R = Mat3::identity();
    Vec3 p = -p0_, turning;
    if (node >= 0) {
      const NodeMotion& motion = k_.motion[at(node)];
      R = rotation_of(motion);
      p = vec(motion.p) - p0_;
      turning = cross(vec(motion.w), vec(motion.v));  // in kernels the acceleration of a node is the spatial acceleration + w x v
    }
    const Mat3 along = R.transposed() * sign;
    for (int k = 0; k < e.rows; ++k) {
      const Vec6& w = links_.rows_.W[at(x_.row[at(e.first + k)])];
      const Vec3 n = along * (w.w - cross(p, w.v)), f = along * w.v;
      P.c[0][k] += n.x;
      P.c[1][k] += n.y;
      P.c[2][k] += n.z;
      P.c[3][k] += f.x;
      P.c[4][k] += f.y;
      P.c[5][k] += f.z;
      g.x[k] += sign * dot(w.v, turning);
    }
  }

  /// Sets P and g of a loop for which is_world_bound() is true:
  ///   position rows  e . (a + w' x r + w x (w x r) + gravity) = 0,   rotation rows  e . w' = 0
  /// with the axes e of J_A, r the point held by the loop in the node's frame, w and w' the node's angular velocity and acceleration, and a
  /// the acceleration of the node's origin relative to free fall.
  void begin_world_bound(std::size_t index, const Vec3& gravity) {
    const ClosedStructure::Entry& e = x_.entries[index];
    const Loop& loop = links_.loops_[at(e.loop)];
    const LinkAttachment& attachment = k_.program.links[at(loop.link_b)];
    const NodeMotion& motion = k_.motion[at(attachment.node)];
    const Mat3 R_NW = rotation_of(motion).transposed();
    const Vec3 r = attachment.X_NL * loop.X_BJ.p, w = vec(motion.spin);
    const Vec3 drift = cross(w, cross(w, r)) + R_NW * gravity;
    LoopColumns& P = k_.P[at(e.present_b)];
    LoopLanes& g = k_.g[index];
    const int first = links_.rows_.first[at(e.loop)];
    for (int k = 0; k < e.rows; ++k) {
      const int row = x_.row[at(e.first + k)] - first;
      const Vec3 axis = R_NW * loop.X_AJ.R.column(row % 3);
      const bool position = row < 3;
      const Vec3 n = position ? cross(axis, r) : -axis;
      for (int c = 0; c < 3; ++c) {
        P.c[c][k] = n[c];
        P.c[c + 3][k] = position ? -axis[c] : 0.0;
      }
      g.x[k] = position ? dot(axis, drift) : 0.0;
    }
  }

  /// Copies rank, multipliers and independent rows from the kernel's memory to ClosedLinks.
  void copy_results() {
    links_.rank_ = 0;
    links_.min_pivot_ratio_ = 1;
    std::ranges::fill(links_.multipliers_, 0.0);
    std::ranges::fill(links_.independent_, char{0});
    for (std::size_t i = 0; i < x_.entries.size(); ++i) {
      const ClosedStructure::Entry& e = x_.entries[i];
      const LoopFactor& F = k_.factor[i];
      links_.rank_ += F.rank;
      links_.min_pivot_ratio_ = std::min(links_.min_pivot_ratio_, F.min_pivot_ratio);
      for (int k = 0; k < e.rows; ++k) links_.multipliers_[at(x_.row[at(e.first + k)])] = k_.lambda[i].x[k];
      for (int k = 0; k < F.rank; ++k) links_.independent_[at(x_.row[at(e.first + F.order[k])])] = 1;
    }
    links_.note_rank();
  }

  const Mechanism& m_;
  ClosedLinks& links_;
  ClosedKernelState& k_;
  const ClosedStructure& x_;
  std::span<const double> q_, v_;
  Vec3 p0_;
};

ClosedStatus calc_closed_forward_dynamics(const Mechanism& m, ClosedLinks& closed, std::span<const double> q, std::span<const double> v,
                                          std::span<const double> tau, const Vec3& gravity, std::span<const Vec6> external,
                                          std::span<double> vdot) {
  UGOKI_CHECK(static_cast<int>(q.size()) == m.nq() && static_cast<int>(v.size()) == m.nv() && vdot.size() == v.size());
  return ClosedRun(m, closed, q, v).run(tau, gravity, external, vdot) ? ClosedStatus::ok : ClosedStatus::singular_inertia;
}

const ClosedKernels& closed_kernels() {
#ifdef UGOKI_X86_WIDTHS
  const Kernels* const in_use = &kernels();
  if (in_use == &avx512::table) return avx512::closed_table;
  if (in_use == &avx2::table) return avx2::closed_table;
#endif
  return plain::closed_table;
}

}  // namespace ugoki::dynamics
