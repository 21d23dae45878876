#pragma once
// Forward dynamics of a tree with few loops, in four stages: inward sweep of the open kernel; propagation of each loop's columns P along
// the loop's path (loop_paths.h); elimination of all loops at the world; outward sweep of the open kernel.
//
// The columns P of a loop stay in registers along their path. Each DOF gives s = S . P, P <- P - U d s, g <- g - s d u; then P is
// transformed across the joint. Lambda is the sum of d s s^T over the DOFs that two loops have in common. The multipliers change the
// reduced forces: u <- u - s . lambda. Symbols: kernel_loops.h. For closed_kernels_*.cpp only.

#include "ugoki/dynamics/kernel_loops.h"
#include "ugoki/dynamics/kernel_twins.h"

namespace ugoki::dynamics {
namespace {  // NOLINT(google-build-namespaces): see spatial/lanes.h

class PathForward {
 public:
  PathForward(const KernelArguments<double>& a, const ClosedArguments& c) : kernel_(a), a_(kernel_.a_), c_(c), paths_(*c.paths) {}

  /// @return false: singular inertia
  bool run() {
    if (c_.twins == nullptr) {
      kernel_.condense();
      solve_loops();
      kernel_.move();
      return !kernel_.bad_[0];
    }
    // The open recursion runs with twins (equal limbs, link_twins.h) in SIMD lanes. Nodes on paths are copied to kernel_, and their reduced
    // forces are copied back.
    twins::Forward open(*c_.twins);
    open.condense();
    kernel_.acceleration_[0] = {{0, 0, 0}, -vector_of<Lanes<double, 1>>(a_.gravity)};
    open.for_each_node([&](int node, const auto& kernel, int its_node, int lane) {
      if (c_.needed[node] != NodeWanted::nothing) kernel_.copy_dofs(node, kernel, its_node, lane);
    });
    solve_loops();
    open.for_each_node([&](int node, auto& kernel, int its_node, int lane) {
      if (c_.needed[node] != NodeWanted::nothing) kernel_.copy_forces_to(kernel, its_node, lane, node);
    });
    return open.move();
  }

 private:
  using One = Lanes<double, 1>;
  using Rows = Lanes<double, UGOKI_DOUBLE_LANES>;
  using Columns = Vec6T<Rows>;
  using Kernel = ForwardKernel<One>;

  void solve_loops() {
    LoopPass<One> loops(c_);
    loops.begin();
    for (const LoopPaths::Path& path : paths_.paths)
      for (int rows = 0; rows < path.rows; rows += Rows::count) follow(path, rows);
    for (const LoopPaths::Block& block : paths_.blocks)
      for (int lanes = 0; lanes < loop_lanes; lanes += Rows::count) couple(block, lanes);
    loops.solve_world(a_.nodes);
    for (const LoopPaths::Path& path : paths_.paths) apply_multipliers(path);
  }

  UGOKI_INLINE static Rows wide(One x) { return Rows(x.v); }
  UGOKI_INLINE static V3<Rows> wide(const V3<One>& x) { return {wide(x.x), wide(x.y), wide(x.z)}; }
  UGOKI_INLINE static Rows along(const V3<Rows>& P, const V3<One>& a) { return P.x * wide(a.x) + P.y * wide(a.y) + P.z * wide(a.z); }

  UGOKI_INLINE void add_columns(Columns& P, int present, int rows) const {
    const auto& c = c_.P[present].c;
    const auto component = [&](int k) { return Rows::load(c[k] + rows); };
    P.w += V3<Rows>{component(0), component(1), component(2)};
    P.v += V3<Rows>{component(3), component(4), component(5)};
  }

  /// Propagates the columns P of a loop's rows [rows, rows + Rows::count) from the loop's two ends to the world.
  void follow(const LoopPaths::Path& path, int rows) {
    const Rows none(0);
    const Columns zero{{none, none, none}, {none, none, none}};
    double* const at_g = c_.g[path.entry].x + rows;
    Columns P = zero;
    Rows g = Rows::load(at_g);
    mobility_ = 0;
    if (path.present_world >= 0) {
      add_columns(P, path.present_world, rows);
      g -= along(P.v, kernel_.acceleration_[0].v);
      P = zero;
    }
    if (path.present_a >= 0) add_columns(P, path.present_a, rows);
    cross(path.begin, path.fork_a, rows, P, g);
    const Columns from_a = P;
    P = zero;
    if (path.present_b >= 0) add_columns(P, path.present_b, rows);
    cross(path.fork_a, path.fork_b, rows, P, g);
    P.w += from_a.w;
    P.v += from_a.v;
    cross(path.fork_b, path.end, rows, P, g);
    g.store(at_g);
    c_.mobility[path.entry] = mobility_;
  }

  /// Propagates the columns P_out and residuals g_out across the nodes of LoopPaths::visits [begin, end).
  void cross(int begin, int end, int rows, Columns& P_out, Rows& g_out) {
    Columns P = P_out;
    Rows g = g_out;
    for (int k = begin; k < end; ++k) {
      const LoopPaths::Visit visit = paths_.visits[static_cast<std::size_t>(k)];
      double* const s = c_.s[visit.dof_begin].x + rows;
      double* const t = c_.t[visit.dof_begin].x + rows;
      const NodeOrder& o = a_.order[visit.node];
      switch (o.crossing) {
        case Crossing::none: revolute<Crossing::none>(visit.node, o, P, g, s, t); break;
        case Crossing::cycle: revolute<Crossing::cycle>(visit.node, o, P, g, s, t); break;
        case Crossing::cycle_back: revolute<Crossing::cycle_back>(visit.node, o, P, g, s, t); break;
        case Crossing::matrix: other(visit.node, o, P, g, s, t); break;
      }
      if (o.parent < 0 && o.kind != NodeKind::floating) g -= along(P.v, kernel_.acceleration_[0].v);
    }
    P_out = P;
    g_out = g;
  }

  /// Eliminates one DOF from the columns P and residuals g. @param x values s = S . P of the DOF
  UGOKI_INLINE static void pass(const Kernel::DofPass& f, const Rows& x, Columns& P, Rows& g, double* s, double* t) {
    const Rows y = x * wide(f.d);
    x.store(s);
    y.store(t);
    P.w.x -= wide(f.U.w.x) * y;
    P.w.y -= wide(f.U.w.y) * y;
    P.w.z -= wide(f.U.w.z) * y;
    P.v.x -= wide(f.U.v.x) * y;
    P.v.y -= wide(f.U.v.y) * y;
    P.v.z -= wide(f.U.v.z) * y;
    g -= y * wide(f.u);
  }

  template <Crossing K>
  UGOKI_INLINE void revolute(int i, const NodeOrder& o, Columns& P, Rows& g, double* s, double* t) {
    const NodeConstants<double>& c = a_.constants[i];
    pass(kernel_.dof_[o.v], P.w.z, P, g, s, t);
    mobility_ += kernel_.dof_[o.v].d.v;
    const V3<One> w = kernel_.w_[i + 1];
    const One rate = kernel_.v(o.v) * One(c.sign);
    g -= P.w.x * wide(w.y * rate) - P.w.y * wide(w.x * rate);
    const RevoluteCrossing<One, K> one = kernel_.pass_.template revolute<K>(o);
    const RevoluteCrossing<Rows, K> X{wide(one.s), wide(one.c)};
    P.v = X.up(P.v);
    if (o.offset != 0) g -= along(P.v, kernel_.velocity_product_[i]);
    P.w = X.up(P.w);
    add_cross(P.w, o.offset, c.p, P.v);
  }

  void other(int i, const NodeOrder& o, Columns& P, Rows& g, double* s, double* t) {
    if (o.kind == NodeKind::floating) {
      floating(i, o, P, g, s, t);
      return;
    }
    const NodeConstants<double>& c = a_.constants[i];
    const Vec6T<One> product = kernel_.velocity_product(i);  // subtracted before the DOFs are eliminated, as in the inward sweep
    g -= along(P.w, product.w) + along(P.v, product.v);
    for (int k = dofs_of(o.kind); k-- > 0;) {
      Rows x = o.kind == NodeKind::spherical ? P.w[k] : o.kind == NodeKind::prismatic ? P.v.z : P.w.z;
      if (o.kind == NodeKind::helical) x += P.v.z * Rows(c.pitch);
      pass(kernel_.dof_[o.v + k], x, P, g, s + k * loop_lanes, t + k * loop_lanes);
      mobility_ += kernel_.dof_[o.v + k].d.v * c_.turning[i];
    }
    const Mat3T<One>& E = kernel_.pass_.E[i];
    const MatrixCrossing<Rows> X{
        {wide(E.xx), wide(E.xy), wide(E.xz), wide(E.yx), wide(E.yy), wide(E.yz), wide(E.zx), wide(E.zy), wide(E.zz)}};
    P.v = X.up(P.v);
    P.w = X.up(P.w) + ugoki::cross(wide(kernel_.pass_.origin(i)), P.v);
  }

  /// Eliminates the six DOFs of a floating base from the columns, from the last to the first: y = L^-1 P.
  void floating(int i, const NodeOrder& o, Columns& P, Rows& g, double* s, double* t) {
    g -= along(P.v, kernel_.pass_.down(i, kernel_.acceleration_[0].v));
    Rows y[6] = {P.w.x, P.w.y, P.w.z, P.v.x, P.v.y, P.v.z};
    for (int k = 6; k-- > 0;) {
      const Kernel::DofPass& f = kernel_.dof_[o.v + k];
      const Rows scaled = y[k] * wide(f.d);
      y[k].store(s + k * loop_lanes);
      scaled.store(t + k * loop_lanes);
      for (int j = 0; j < k; ++j) y[j] -= scaled * wide(j < 3 ? f.U.w[j] : f.U.v[j - 3]);
      g -= scaled * wide(f.u);
      mobility_ += k < 3 ? f.d.v : f.d.v / c_.length2;
    }
  }

  /// Computes the lanes [lanes, lanes + Rows::count) of a block of Lambda.
  void couple(const LoopPaths::Block& block, int lanes) const {
    Rows sum[6] = {Rows(0), Rows(0), Rows(0), Rows(0), Rows(0), Rows(0)};
    for (int r = block.run; r < block.run + block.run_count; ++r) {
      const LoopPaths::Run run = paths_.runs[static_cast<std::size_t>(r)];
      const LoopLanes* const s = c_.s + run.a;
      const LoopLanes* const t = c_.t + run.b;
      for (int k = 0; k < run.count; ++k) {
        const Rows x = Rows::load(t[k].x + lanes);
        for (int i = 0; i < 6; ++i) sum[i] += Rows(s[k].x[i]) * x;
      }
    }
    for (int i = 0; i < 6; ++i) sum[i].store(c_.Lambda[block.block].x[i] + lanes);
  }

  /// Applies a loop's multipliers to the reduced forces of its path: u <- u - s . lambda
  void apply_multipliers(const LoopPaths::Path& path) {
    using Four = Lanes<double, 4>;
    const double* const lambda = c_.lambda[path.entry].x;
    const Four low = Four::load(lambda), high = Four::load(lambda + 4);
    for (int k = path.dof_begin; k < path.dof_begin + path.dof_count; ++k) {
      const double* const s = c_.s[k].x;
      const auto sum = (Four::load(s) * low + Four::load(s + 4) * high).v;
      One& u = kernel_.dof_[paths_.dof[static_cast<std::size_t>(k)]].u;
      u -= One((sum[0] + sum[2]) + (sum[1] + sum[3]));
    }
  }

  Kernel kernel_;
  const KernelArguments<double>& a_;
  const ClosedArguments& c_;
  const LoopPaths& paths_;
  double mobility_ = 0;  // ClosedArguments::mobility of the current path
};

}  // namespace
}  // namespace ugoki::dynamics
