#pragma once
// What kernel_forward.h does with the multipliers of loops. For closed_kernels_*.cpp only.
//
// P: columns of a loop's multipliers as bias forces at a node, (n, f) like pA; row k of the loop reads
//   -P_k . a + g_k + sum Lambda lambda = 0     at every stage of the recursion, a the acceleration of the node it has come to.
// A freedom (S, U, 1/d, u) turns this into s = S . P, P <- P - U d s, g <- g - s d u, Lambda <- Lambda + d s s^T; a velocity product
// c into g <- g - P . c. See closed_links.h for the sources.

#include "ugoki/dynamics/closed_kernels.h"
#include "ugoki/dynamics/kernel_forward.h"

namespace ugoki::dynamics {
namespace {  // NOLINT(google-build-namespaces): see spatial/lanes.h

#define UGOKI_APART __attribute__((noinline))

template <class T>
class LoopPass {
 public:
  using Rows = Lanes<double, loop_lanes>;
  using Columns = Vec6T<Rows>;

  explicit LoopPass(const ClosedArguments& arguments) : a_(arguments) {}

  void begin() {
    const Rows none(0);
    for (int i = 0; i < a_.entry_count; ++i) {
      none.store(a_.reduced[i].x);
      a_.moved[i] = 0;
    }
    for (int i = 0; i < a_.block_count; ++i)
      for (auto& row : a_.Lambda[i].x) none.store(row);
  }

  [[nodiscard]] UGOKI_INLINE bool present_at(int node) const { return a_.nodes[node].present_count != 0; }

  // At a node, from the leaves.

  /// Loops that meet at the node: their multipliers leave.
  UGOKI_INLINE void eliminate(int node, Articulated<T>& A) {
    if (a_.nodes[node].elimination_count == 0) return;
    Articulated<T> copy = A;  // A itself stays in registers
    eliminate_all(node, &copy);
    A = copy;
  }

  /// One freedom of the node whose motion is s_of(P) along the columns: `which` counts the node's freedoms.
  template <class Along>
  UGOKI_INLINE void freedom(int node, int which, int f, const Vec6T<T>& U, T d, T u, T sign, Along&& along) {
    const ClosedStructure::Node& n = a_.nodes[node];
    if (n.passing_count != 0) pass_freedom(n, which, f, U, d, u, sign, a_.turning[node] * d.v, along);
  }

  /// g -= P . c
  UGOKI_INLINE void velocity_product(int node, const Vec6T<T>& c) {
    if (a_.nodes[node].passing_count != 0) subtract_product(a_.nodes[node], c);
  }

  /// Across the joint: X turns a vector of the node into the parent's axes, r is the node's origin there.
  template <Crossing K>
  UGOKI_INLINE void hand_on(int node, const RevoluteCrossing<T, K>& X, const V3<T>& r) {
    if (a_.nodes[node].passing_count != 0) cross_joint(a_.nodes[node], RevoluteCrossing<Rows, K>{Rows(X.s.v), Rows(X.c.v)}, r);
  }
  void hand_on(int node, const MatrixCrossing<T>& X, const V3<T>& r) {
    if (a_.nodes[node].passing_count == 0) return;
    const Mat3T<T>& E = X.E;
    const Mat3T<Rows> wide{Rows(E.xx.v), Rows(E.xy.v), Rows(E.xz.v), Rows(E.yx.v), Rows(E.yy.v),
                           Rows(E.yz.v), Rows(E.zx.v), Rows(E.zy.v), Rows(E.zz.v)};
    cross_joint(a_.nodes[node], MatrixCrossing<Rows>{wide}, r);
  }

  /// A floating base takes all that is left of P: y = L^-1 P freedom by freedom, from the last one on.
  /// @param L [6][6], d [6], u [6] as solve_floating() leaves them; a0 the base's acceleration without its freedoms
  void floating(int node, const T (*L)[6], const T* d, const T* u, const Vec6T<T>& a0) {
    const ClosedStructure::Node& n = a_.nodes[node];
    if (n.passing_count == 0) return;
    const double moves = (d[0] + d[1] + d[2]).v + (d[3] + d[4] + d[5]).v / a_.length2;
    for (int i = 0; i < n.passing_count; ++i) {
      const Columns P = columns(n.present + i);
      const int e = a_.present[n.present + i].entry;
      subtract(e, along(P, a0));
      a_.moved[e] += moves;
      Rows y[6] = {P.w.x, P.w.y, P.w.z, P.v.x, P.v.y, P.v.z};
      for (int k = 6; k-- > 0;) {
        for (int j = 0; j < k; ++j) y[j] -= y[k] * Rows((L[k][j] * d[k]).v);
        y[k].store(a_.s[n.s_slot + k * n.passing_count + i].x);
        subtract(e, y[k] * Rows((d[k] * u[k]).v));
      }
    }
    couple_floating(n, d);
  }

  // From the base.

  /// The last loops; A0: the base's acceleration.
  void eliminate_world(int world, const Vec6T<T>& A0) {
    const ClosedStructure::Node& n = a_.nodes[world];
    for (int i = 0; i < n.present_count; ++i) subtract(a_.present[n.present + i].entry, along(columns(n.present + i), A0));
    solve_world(world);
  }
  void solve_world(int world) {
    eliminate_all(world, nullptr);
    recover_all(world, nullptr);
  }

  /// What the multipliers take from a freedom's reduced force: s . lambda
  UGOKI_INLINE T along_multipliers(int node, int which) const {
    const ClosedStructure::Node& n = a_.nodes[node];
    if (n.passing_count == 0) return T(0);
    const LoopLanes* const s = a_.s + n.s_slot + which * n.passing_count;
    Rows sum(0);
    for (int i = 0; i < n.passing_count; ++i) sum += Rows::load(s[i].x) * Rows::load(a_.lambda[a_.present[n.present + i].entry].x);
    return total(sum);
  }

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
  // The work at a node that loops pass stays out of line: most nodes have none, and keep their registers.

  template <class Along>
  UGOKI_APART void pass_freedom(const ClosedStructure::Node& n, int which, int f, const Vec6T<T>& U, T d, T u, T sign, double moves,
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
      a_.moved[e] += moves;
    }
    couple(n, s, d.v);
  }
  UGOKI_APART void subtract_product(const ClosedStructure::Node& n, const Vec6T<T>& c) {
    for (int i = 0; i < n.passing_count; ++i) subtract(a_.present[n.present + i].entry, along(columns(n.present + i), c));
  }

  template <class Crossing>
  UGOKI_APART void cross_joint(const ClosedStructure::Node& n, const Crossing& X, const V3<T>& r) {
    const V3<Rows> at{Rows(r.x.v), Rows(r.y.v), Rows(r.z.v)};
    for (int i = 0; i < n.passing_count; ++i) {
      const Columns P = columns(n.present + i);
      Columns up{X.up(P.w), X.up(P.v)};
      up.w += cross(at, up.v);
      const int parent = a_.present[n.present + i].parent;
      store(columns(parent) + up, parent);
    }
  }

  /// Row 0 of a gear that turns this freedom.
  Rows gears(const ClosedStructure::Node& n, int place, int f, double sign) const {
    Rows x(0);
    for (int k = n.gears; k < n.gears + n.gear_count; ++k) {
      const ClosedStructure::Gear& gear = a_.gears[k];
      if (gear.freedom == f && gear.place == place) x.v[0] += sign * (gear.second ? -a_.slope[gear.loop] : 1.0);
    }
    return x;
  }
  /// Lambda += d s s^T
  UGOKI_INLINE void couple(const ClosedStructure::Node& n, const LoopLanes* s, double d) {
    for (int k = n.pairs; k < n.pairs + n.pair_count; ++k) {
      const ClosedStructure::Pair& pair = a_.pairs[k];
      LoopBlock& block = a_.Lambda[pair.block];
      const int rows = a_.entries[a_.present[n.present + pair.a].entry].rows;
      const Rows t = Rows::load(s[pair.b].x) * Rows(d);
      for (int i = 0; i < rows; ++i) (Rows::load(block.x[i]) + Rows(s[pair.a].x[i]) * t).store(block.x[i]);
    }
  }

  /// The same for the six freedoms of a floating base at once.
  UGOKI_APART void couple_floating(const ClosedStructure::Node& n, const T* d) {
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

  /// Cholesky of the loop's own block with the greatest pivot first; rows that follow from others get none.
  void factor_block(const ClosedStructure::Elimination& x) {
    const ClosedStructure::Entry& e = a_.entries[x.entry];
    const LoopBlock& A = a_.Lambda[e.diagonal];
    LoopFactor& F = a_.factor[x.entry];
    const double* const reduced = a_.reduced[x.entry].x;
    double diagonal[6], greatest[2] = {};  // positions, rotations
    for (int i = 0; i < e.rows; ++i) {
      F.order[i] = i;
      diagonal[i] = A.x[i][i];
      double& scale = greatest[i < e.position_rows ? 0 : 1];
      if (diagonal[i] + reduced[i] > scale) scale = diagonal[i] + reduced[i];
    }
    const double rounding = a_.immobile * a_.moved[x.entry];
    double limit[6];
    for (int i = 0; i < e.rows; ++i) {
      const bool position = i < e.position_rows;
      const double least = position ? rounding * a_.length2 : rounding;
      limit[i] = a_.dependent * greatest[position ? 0 : 1];
      if (limit[i] < least) limit[i] = least;
    }
    F.weakest = 1;
    for (F.rank = 0; F.rank < e.rows; ++F.rank) {
      const int k = F.rank;
      int best = k;
      for (int i = k + 1; i < e.rows; ++i) {
        const int a = F.order[i], b = F.order[best];
        if (!(diagonal[b] > limit[b]) || diagonal[a] * limit[b] > diagonal[b] * limit[a]) best = i;
      }
      if (!(diagonal[F.order[best]] > limit[F.order[best]])) return;
      const double part = diagonal[F.order[best]] / greatest[F.order[best] < e.position_rows ? 0 : 1];
      if (part < F.weakest) F.weakest = part;
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

  /// @param A null at the world, whose acceleration is known
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

  /// IA += Z^T Z, pA -= Z^T z
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

  /// Y = C^-1 Lambda(e, o); P_o -= Z^T Y; g_o -= Y^T z
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

  /// lambda = C^-T (Z A - z - Y lambda_neighbours)
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
