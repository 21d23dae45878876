#pragma once
// The Loops policy of kernel_forward.h for closed systems: processes the multipliers of the loops. For closed_kernels_*.cpp only.
//
// P are the columns of a loop at a node: bias forces (n, f) per unit of each multiplier. At every stage of the recursion, row k of the loop
// is
//   -P_k . a + g_k + sum Lambda lambda = 0     where a is the acceleration of the node that the recursion has reached.
// Eliminating a DOF gives s = S . P, P <- P - U d s, g <- g - s d u, Lambda <- Lambda + d s s^T, where d = 1 / D. A velocity product c
// gives g <- g - P . c. S, U, D, u and c: kernel_forward.h. Method and sources: closed_links.h.

#include "ugoki/dynamics/closed_kernels.h"
#include "ugoki/dynamics/kernel_forward.h"

namespace ugoki::dynamics {
namespace {  // NOLINT(google-build-namespaces): see spatial/lanes.h

#define UGOKI_NOINLINE __attribute__((noinline))

template <class T>
class LoopPass {
 public:
  using Rows = Lanes<double, loop_lanes>;
  using Columns = Vec6T<Rows>;

  explicit LoopPass(const ClosedArguments& arguments) : a_(arguments) {}

  /// Sets Lambda, `reduced` and `mobility` to zero. P and g are set by the caller (closed_run.cpp).
  void begin() {
    const Rows none(0);
    for (int i = 0; i < a_.entry_count; ++i) {
      none.store(a_.reduced[i].x);
      a_.mobility[i] = 0;
    }
    for (int i = 0; i < a_.block_count; ++i)
      for (auto& row : a_.Lambda[i].x) none.store(row);
  }

  [[nodiscard]] UGOKI_INLINE bool present_at(int node) const { return a_.nodes[node].present_count != 0; }

  // Inward sweep.

  /// Eliminates the multipliers of the loops that meet at the node. Adds their stiffness to A.
  UGOKI_INLINE void eliminate(int node, Articulated<T>& A) {
    if (a_.nodes[node].elimination_count == 0) return;
    Articulated<T> copy = A;  // only the address of the copy is taken, so A can stay in registers
    eliminate_all(node, &copy);
    A = copy;
  }

  /// Eliminates one DOF of the node from the columns of the loops that pass it.
  /// @param which index of the DOF among the node's DOFs @param f velocity index @param U, d, u as in kernel_forward.h
  /// @param along (columns P) -> S . P
  template <class Along>
  UGOKI_INLINE void dof(int node, int which, int f, const Vec6T<T>& U, T d, T u, T sign, Along&& along) {
    const ClosedStructure::Node& n = a_.nodes[node];
    if (n.passing_count != 0) pass_dof(n, which, f, U, d, u, sign, a_.turning[node] * d.v, along);
  }

  /// Processes the velocity-product acceleration c of the node: g -= P . c
  UGOKI_INLINE void velocity_product(int node, const Vec6T<T>& c) {
    if (a_.nodes[node].passing_count != 0) subtract_product(a_.nodes[node], c);
  }

  /// Transforms the columns of the loops that pass the node to the parent's frame, and adds them there.
  /// @param X crossing from the node's to the parent's axes @param r the node's origin in the parent's frame
  template <Crossing K>
  UGOKI_INLINE void pass_up(int node, const RevoluteCrossing<T, K>& X, const V3<T>& r) {
    if (a_.nodes[node].passing_count != 0) cross_joint(a_.nodes[node], RevoluteCrossing<Rows, K>{Rows(X.s.v), Rows(X.c.v)}, r);
  }
  void pass_up(int node, const MatrixCrossing<T>& X, const V3<T>& r) {
    if (a_.nodes[node].passing_count == 0) return;
    const Mat3T<T>& E = X.E;
    const Mat3T<Rows> wide{Rows(E.xx.v), Rows(E.xy.v), Rows(E.xz.v), Rows(E.yx.v), Rows(E.yy.v),
                           Rows(E.yz.v), Rows(E.zx.v), Rows(E.zy.v), Rows(E.zz.v)};
    cross_joint(a_.nodes[node], MatrixCrossing<Rows>{wide}, r);
  }

  /// Eliminates the six DOFs of a floating base from the columns P of the loops that pass it, and stores s (P, s: top of this file). The
  /// six DOFs allow every motion of the node. After their elimination P is zero, so nothing is passed to the world.
  /// @param L [6][6], d [6], u [6] from solve_floating() @param a0 acceleration of the node for vdot = 0
  void floating(int node, const T (*L)[6], const T* d, const T* u, const Vec6T<T>& a0) {
    const ClosedStructure::Node& n = a_.nodes[node];
    if (n.passing_count == 0) return;
    const double mobility = (d[0] + d[1] + d[2]).v + (d[3] + d[4] + d[5]).v / a_.length2;
    for (int i = 0; i < n.passing_count; ++i) {
      const Columns P = columns(n.present + i);
      const int e = a_.present[n.present + i].entry;
      subtract(e, along(P, a0));
      a_.mobility[e] += mobility;
      Rows y[6] = {P.w.x, P.w.y, P.w.z, P.v.x, P.v.y, P.v.z};
      for (int k = 6; k-- > 0;) {
        for (int j = 0; j < k; ++j) y[j] -= y[k] * Rows((L[k][j] * d[k]).v);
        y[k].store(a_.s[n.s_slot + k * n.passing_count + i].x);
        subtract(e, y[k] * Rows((d[k] * u[k]).v));
      }
    }
    couple_floating(n, d);
  }

  // Outward sweep.

  /// Solves for the multipliers of the loops that meet at the world. @param A0 acceleration of the world
  void eliminate_world(int world, const Vec6T<T>& A0) {
    const ClosedStructure::Node& n = a_.nodes[world];
    for (int i = 0; i < n.present_count; ++i) subtract(a_.present[n.present + i].entry, along(columns(n.present + i), A0));
    solve_world(world);
  }
  /// Does the same as eliminate_world() for a g from which the term P . A0 is already subtracted.
  void solve_world(int world) {
    eliminate_all(world, nullptr);
    recover_all(world, nullptr);
  }

  /// Part of a DOF's reduced force that the multipliers cause: s . lambda. @param which index of the DOF among the node's DOFs
  UGOKI_INLINE T along_multipliers(int node, int which) const {
    const ClosedStructure::Node& n = a_.nodes[node];
    if (n.passing_count == 0) return T(0);
    const LoopLanes* const s = a_.s + n.s_slot + which * n.passing_count;
    Rows sum(0);
    for (int i = 0; i < n.passing_count; ++i) sum += Rows::load(s[i].x) * Rows::load(a_.lambda[a_.present[n.present + i].entry].x);
    return total(sum);
  }

  /// Recovers the multipliers of the loops that were eliminated at the node. @param A acceleration of the node
  UGOKI_INLINE void recover(int node, const Vec6T<T>& A) {
    if (a_.nodes[node].elimination_count != 0) recover_all(node, &A);
  }

 private:
  UGOKI_INLINE static T total(Rows x) {
    const auto& v = x.v;
    return ((v[0] + v[1]) + (v[2] + v[3])) + ((v[4] + v[5]) + (v[6] + v[7]));
  }
  UGOKI_INLINE Columns columns(int present) const {
    const LoopColumns& P = a_.P[present];
    return {{Rows::load(P.c[0]), Rows::load(P.c[1]), Rows::load(P.c[2])}, {Rows::load(P.c[3]), Rows::load(P.c[4]), Rows::load(P.c[5])}};
  }
  UGOKI_INLINE void store(const Columns& P, int present) {
    LoopColumns& to = a_.P[present];
    P.w.x.store(to.c[0]);
    P.w.y.store(to.c[1]);
    P.w.z.store(to.c[2]);
    P.v.x.store(to.c[3]);
    P.v.y.store(to.c[4]);
    P.v.z.store(to.c[5]);
  }
  UGOKI_INLINE static Rows along(const Columns& P, const Vec6T<T>& a) {
    return P.w.x * Rows(a.w.x.v) + P.w.y * Rows(a.w.y.v) + P.w.z * Rows(a.w.z.v) + P.v.x * Rows(a.v.x.v) + P.v.y * Rows(a.v.y.v) +
           P.v.z * Rows(a.v.z.v);
  }
  UGOKI_INLINE void subtract(int entry, Rows x) {
    LoopLanes& g = a_.g[entry];
    (Rows::load(g.x) - x).store(g.x);
  }
  // Functions for nodes with passing loops are not inlined: the code for all other nodes (the majority) then needs fewer registers.

  template <class Along>
  UGOKI_NOINLINE void pass_dof(const ClosedStructure::Node& n, int which, int f, const Vec6T<T>& U, T d, T u, T sign, double mobility,
                               Along along) {
    LoopLanes* const s = a_.s + n.s_slot + which * n.passing_count;
    const Rows Ux(U.w.x.v), Uy(U.w.y.v), Uz(U.w.z.v), Vx(U.v.x.v), Vy(U.v.y.v), Vz(U.v.z.v), D(d.v), step((d * u).v);
    for (int i = 0; i < n.passing_count; ++i) {
      Columns P = columns(n.present + i);
      Rows x = along(P);
      if (n.gear_count != 0) x = x - gears(n, i, f, sign.v);
      x.store(s[i].x);
      const Rows t = x * D;
      P.w.x -= Ux * t;
      P.w.y -= Uy * t;
      P.w.z -= Uz * t;
      P.v.x -= Vx * t;
      P.v.y -= Vy * t;
      P.v.z -= Vz * t;
      store(P, n.present + i);
      const int e = a_.present[n.present + i].entry;
      LoopLanes& g = a_.g[e];
      (Rows::load(g.x) - x * step).store(g.x);
      a_.mobility[e] += mobility;
    }
    couple(n, s, d.v);
  }
  UGOKI_NOINLINE void subtract_product(const ClosedStructure::Node& n, const Vec6T<T>& c) {
    for (int i = 0; i < n.passing_count; ++i) subtract(a_.present[n.present + i].entry, along(columns(n.present + i), c));
  }

  template <class Crossing>
  UGOKI_NOINLINE void cross_joint(const ClosedStructure::Node& n, const Crossing& X, const V3<T>& r) {
    const V3<Rows> at{Rows(r.x.v), Rows(r.y.v), Rows(r.z.v)};
    for (int i = 0; i < n.passing_count; ++i) {
      const Columns P = columns(n.present + i);
      Columns up{X.up(P.w), X.up(P.v)};
      up.w += cross(at, up.v);
      const int parent = a_.present[n.present + i].parent;
      store(columns(parent) + up, parent);
    }
  }

  /// Coefficient of a DOF in row 0 of a gear; zero if the gear does not couple the DOF.
  Rows gears(const ClosedStructure::Node& n, int passing, int f, double sign) const {
    Rows x(0);
    for (int k = n.gears; k < n.gears + n.gear_count; ++k) {
      const ClosedStructure::Gear& gear = a_.gears[k];
      if (gear.dof == f && gear.passing == passing) x.v[0] += sign * (gear.second ? -a_.slope[gear.loop] : 1.0);
    }
    return x;
  }
  /// Adds the effect of one DOF to the blocks of all passing loops: Lambda += d s s^T.
  UGOKI_INLINE void couple(const ClosedStructure::Node& n, const LoopLanes* s, double d) {
    for (int k = n.pairs; k < n.pairs + n.pair_count; ++k) {
      const ClosedStructure::Pair& pair = a_.pairs[k];
      LoopBlock& block = a_.Lambda[pair.block];
      const int rows = a_.entries[a_.present[n.present + pair.a].entry].rows;
      const Rows t = Rows::load(s[pair.b].x) * Rows(d);
      for (int i = 0; i < rows; ++i) (Rows::load(block.x[i]) + Rows(s[pair.a].x[i]) * t).store(block.x[i]);
    }
  }

  /// Does the same as couple() for all six DOFs of a floating base.
  UGOKI_NOINLINE void couple_floating(const ClosedStructure::Node& n, const T* d) {
    const LoopLanes* const s = a_.s + n.s_slot;
    for (int p = n.pairs; p < n.pairs + n.pair_count; ++p) {
      const ClosedStructure::Pair& pair = a_.pairs[p];
      LoopBlock& block = a_.Lambda[pair.block];
      const int rows = a_.entries[a_.present[n.present + pair.a].entry].rows;
      Rows t[6];
      for (int k = 0; k < 6; ++k) t[k] = Rows::load(s[k * n.passing_count + pair.b].x) * Rows(d[k].v);
      for (int i = 0; i < rows; ++i) {
        Rows sum = Rows::load(block.x[i]);
        for (int k = 6; k-- > 0;) sum += Rows(s[k * n.passing_count + pair.a].x[i]) * t[k];
        sum.store(block.x[i]);
      }
    }
  }

  /// Pivoted Cholesky factorization of the loop's diagonal block, largest pivot first. Dependent rows get no pivot.
  void factor_block(const ClosedStructure::Elimination& x) {
    const ClosedStructure::Entry& e = a_.entries[x.entry];
    const LoopBlock& A = a_.Lambda[e.diagonal];
    LoopFactor& F = a_.factor[x.entry];
    const double* const reduced = a_.reduced[x.entry].x;
    double diagonal[6], maximum[2] = {};  // maximum: [0] of the position rows, [1] of the rotation rows
    for (int i = 0; i < e.rows; ++i) {
      F.order[i] = i;
      diagonal[i] = A.x[i][i];
      double& scale = maximum[i < e.position_rows ? 0 : 1];
      if (diagonal[i] + reduced[i] > scale) scale = diagonal[i] + reduced[i];
    }
    const double rounding = a_.immobile * a_.mobility[x.entry];
    double limit[6];
    for (int i = 0; i < e.rows; ++i) {
      const bool position = i < e.position_rows;
      const double minimum = position ? rounding * a_.length2 : rounding;
      limit[i] = a_.dependent * maximum[position ? 0 : 1];
      if (limit[i] < minimum) limit[i] = minimum;
    }
    F.min_pivot_ratio = 1;
    for (F.rank = 0; F.rank < e.rows; ++F.rank) {
      const int k = F.rank;
      int best = k;
      for (int i = k + 1; i < e.rows; ++i) {
        const int a = F.order[i], b = F.order[best];
        if (!(diagonal[b] > limit[b]) || diagonal[a] * limit[b] > diagonal[b] * limit[a]) best = i;
      }
      if (!(diagonal[F.order[best]] > limit[F.order[best]])) return;
      const double part = diagonal[F.order[best]] / maximum[F.order[best] < e.position_rows ? 0 : 1];
      if (part < F.min_pivot_ratio) F.min_pivot_ratio = part;
      if (best != k) {
        const int order = F.order[k];
        F.order[k] = F.order[best];
        F.order[best] = order;
        for (int j = 0; j < k; ++j) {
          const double c = F.C[k][j];
          F.C[k][j] = F.C[best][j];
          F.C[best][j] = c;
        }
      }
      const double c = __builtin_sqrt(diagonal[F.order[k]]), inverse = 1.0 / c;
      F.C[k][k] = inverse;
      for (int i = k + 1; i < e.rows; ++i) {
        double y = A.x[F.order[i]][F.order[k]];
        for (int j = 0; j < k; ++j) y -= F.C[i][j] * F.C[k][j];
        y *= inverse;
        F.C[i][k] = y;
        diagonal[F.order[i]] -= y * y;
      }
    }
  }

  /// Eliminates all loops that meet at the node. @param A articulated inertia of the node; null at the world, whose acceleration is known
  void eliminate_all(int node, Articulated<T>* A) {
    const ClosedStructure::Node& n = a_.nodes[node];
    for (int i = n.eliminations; i < n.eliminations + n.elimination_count; ++i) {
      const ClosedStructure::Elimination& x = a_.eliminations[i];
      factor_block(x);
      LoopFactor& F = a_.factor[x.entry];
      const double* const g = a_.g[x.entry].x;
      for (int k = 0; k < F.rank; ++k) {
        double z = g[F.order[k]];
        for (int j = 0; j < k; ++j) z -= F.C[k][j] * F.z[j];
        F.z[k] = z * F.C[k][k];
      }
      if (A != nullptr) stiffen(x, F, *A);
      for (int o = x.neighbours; o < x.neighbours + x.neighbour_count; ++o) reduce(x, F, o, A != nullptr);
      for (int u = x.updates; u < x.updates + x.update_count; ++u) update(F.rank, a_.updates[u]);
    }
  }

  /// Adds an eliminated loop's stiffness to the node: IA += Z^T Z, pA -= Z^T z, with Z = C^-1 P^T.
  void stiffen(const ClosedStructure::Elimination& x, LoopFactor& F, Articulated<T>& A) {
    const LoopColumns& P = a_.P[x.present];
    for (int k = 0; k < F.rank; ++k) {
      double row[loop_lanes] = {};
      for (int c = 0; c < 6; ++c) row[c] = P.c[c][F.order[k]];
      Rows Z = Rows::load(row);
      for (int j = 0; j < k; ++j) Z -= Rows::load(F.Z[j]) * Rows(F.C[k][j]);
      Z *= Rows(F.C[k][k]);
      Z.store(F.Z[k]);
      const V3<T> a{T(F.Z[k][0]), T(F.Z[k][1]), T(F.Z[k][2])}, b{T(F.Z[k][3]), T(F.Z[k][4]), T(F.Z[k][5])};
      A.I = A.I + Sym3T<T>{a.x * a.x, a.y * a.y, a.z * a.z, a.x * a.y, a.x * a.z, a.y * a.z};
      A.M = A.M + Sym3T<T>{b.x * b.x, b.y * b.y, b.z * b.z, b.x * b.y, b.x * b.z, b.y * b.z};
      A.H += Mat3T<T>::outer(a, b);
      A.n -= a * T(F.z[k]);
      A.f -= b * T(F.z[k]);
    }
  }

  /// Effect of eliminating loop e on a neighbour o: Y = C^-1 Lambda(e, o); P_o -= Z^T Y; g_o -= Y^T z. C, Z, z: see LoopFactor.
  /// @param stiffens false at the world: P_o is not needed
  void reduce(const ClosedStructure::Elimination& x, const LoopFactor& F, int neighbour, bool stiffens) {
    const ClosedStructure::Neighbour& o = a_.neighbours[neighbour];
    const LoopBlock& block = a_.Lambda[o.block];
    LoopBlock& Y = a_.Y[neighbour];
    Rows g = Rows::load(a_.g[o.entry].x), reduced = Rows::load(a_.reduced[o.entry].x);
    Columns P = stiffens ? columns(o.present) : Columns{};
    for (int k = 0; k < F.rank; ++k) {
      double row[loop_lanes] = {};
      if (o.transposed)
        for (int j = 0; j < a_.entries[o.entry].rows; ++j) row[j] = block.x[j][F.order[k]];
      Rows y = o.transposed ? Rows::load(row) : Rows::load(block.x[F.order[k]]);
      for (int j = 0; j < k; ++j) y -= Rows::load(Y.x[j]) * Rows(F.C[k][j]);
      y *= Rows(F.C[k][k]);
      y.store(Y.x[k]);
      reduced += y * y;
      g -= y * Rows(F.z[k]);
      if (!stiffens) continue;
      P.w.x -= y * Rows(F.Z[k][0]);
      P.w.y -= y * Rows(F.Z[k][1]);
      P.w.z -= y * Rows(F.Z[k][2]);
      P.v.x -= y * Rows(F.Z[k][3]);
      P.v.y -= y * Rows(F.Z[k][4]);
      P.v.z -= y * Rows(F.Z[k][5]);
    }
    g.store(a_.g[o.entry].x);
    reduced.store(a_.reduced[o.entry].x);
    if (stiffens) store(P, o.present);
    (void)x;
  }

  /// Lambda(a, b) -= Y_a^T Y_b
  void update(int rank, const ClosedStructure::Update& u) {
    LoopBlock& block = a_.Lambda[u.block];
    const LoopBlock &Ya = a_.Y[u.a], &Yb = a_.Y[u.b];
    const int rows = a_.entries[a_.neighbours[u.a].entry].rows;
    for (int i = 0; i < rows; ++i) {
      Rows x = Rows::load(block.x[i]);
      for (int k = 0; k < rank; ++k) x -= Rows::load(Yb.x[k]) * Rows(Ya.x[k][i]);
      x.store(block.x[i]);
    }
  }

  /// Back substitution for all loops that meet at the node: lambda = C^-T (Z A - z - Y lambda_neighbours).
  /// @param A acceleration of the node; null at the world
  void recover_all(int node, const Vec6T<T>* A) {
    const ClosedStructure::Node& n = a_.nodes[node];
    for (int i = n.eliminations + n.elimination_count; i-- > n.eliminations;) {
      const ClosedStructure::Elimination& x = a_.eliminations[i];
      const LoopFactor& F = a_.factor[x.entry];
      double y[6];
      for (int k = 0; k < F.rank; ++k) {
        Rows sum(0);
        for (int o = x.neighbours; o < x.neighbours + x.neighbour_count; ++o)
          sum += Rows::load(a_.Y[o].x[k]) * Rows::load(a_.lambda[a_.neighbours[o].entry].x);
        y[k] = -F.z[k] - total(sum).v;
        if (A == nullptr) continue;
        const double* const Z = F.Z[k];
        y[k] += (Z[0] * A->w.x.v + Z[1] * A->w.y.v + Z[2] * A->w.z.v) + (Z[3] * A->v.x.v + Z[4] * A->v.y.v + Z[5] * A->v.z.v);
      }
      LoopLanes& lambda = a_.lambda[x.entry];
      Rows(0).store(lambda.x);
      for (int k = F.rank; k-- > 0;) {
        for (int j = k + 1; j < F.rank; ++j) y[k] -= F.C[j][k] * y[j];
        y[k] *= F.C[k][k];
        lambda.x[F.order[k]] = y[k];
      }
    }
  }

  const ClosedArguments& a_;
};

}  // namespace
}  // namespace ugoki::dynamics
