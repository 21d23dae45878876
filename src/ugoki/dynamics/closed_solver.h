#pragma once
// The recursive sweeps of closed_links.h over the links of a mechanism: factorization and solves. Internal to dynamics/.

#include <algorithm>
#include <cmath>

#include "ugoki/dynamics/closed_links.h"

namespace ugoki::dynamics {

inline ArticulatedInertia articulated(const Inertia& r) { return {r.I, Mat3::skew(r.h), {r.mass, r.mass, r.mass, 0, 0, 0}}; }

inline Vec6 operator*(const ArticulatedInertia& a, const Vec6& m) { return {a.I * m.w + a.H * m.v, transpose_times(a.H, m.w) + a.M * m.v}; }

inline Sym3 outer(const Vec3& a, double s) {
  return {s * a.x * a.x, s * a.y * a.y, s * a.z * a.z, s * a.x * a.y, s * a.x * a.z, s * a.y * a.z};
}

/// a += u u^T s
inline void add_outer(ArticulatedInertia& a, const Vec6& u, double s) {
  a.I = a.I + outer(u.w, s);
  a.H += Mat3::outer(u.w, u.v) * s;
  a.M = a.M + outer(u.v, s);
}

inline void add(ArticulatedInertia& a, const ArticulatedInertia& b) {
  a.I = a.I + b.I;
  a.H += b.H;
  a.M = a.M + b.M;
}

inline Inertia operator*(const Inertia& i, double s) { return {i.mass * s, i.h * s, i.I * s}; }

struct LinkResponses;

/// The recursive sweeps over the links: factorization and solves. The node index of a link is its link index; `world_` is the last node.
class ClosedSolver {
 public:
  ClosedSolver(const Mechanism& m, Workspace& ws, ClosedLinks& c)
      : m_(m), links_(m.places()), ws_(ws), c_(c), x_(c.over_links_), world_(m.link_count()) {}

  void update_rows(std::span<const double> q, std::span<const double> v) { update_rows(m_, ws_, c_, q, v); }
  static void update_rows(const Mechanism& m, const Workspace& ws, ClosedLinks& c, std::span<const double> q, std::span<const double> v) {
    update_loop_rows(m, ws, c.loops_, q, v, c.rows_);
  }

  /// Factors the closed system. @return false if a DOF moves no inertia
  bool factor(double dependent) {
    std::ranges::copy(ws_.I, c_.I_.begin());
    for (const InertiaShare& s : c_.shares_) c_.I_[at(s.link)] = ws_.I[at(s.source)] * s.part;
    begin_factor();
    if (!eliminate(dependent, {})) return false;
    c_.note_rank();
    return true;
  }
  /// Factors the closed system with additions (stiff_links.h); the inertias ws.I are already shared (share_virtual_inertias).
  /// @param extra [nv] or empty, added to the pivots @param stiffness [links] or empty, added to the inertias of the links
  /// @param rows [rows of all loops] 1: the row is used; or empty: rows are chosen by `dependent`
  bool factor_stiff(double dependent, std::span<const double> extra, std::span<const ArticulatedInertia> stiffness,
                    std::span<const char> rows) {
    use_rows_ = rows;
    std::ranges::copy(ws_.I, c_.I_.begin());
    begin_factor();
    for (std::size_t i = 0; i < stiffness.size(); ++i) add(ws_.IA[i], stiffness[i]);
    return eliminate(dependent, extra);
  }
  /// Solves for vdot and the multipliers. Inputs: bias forces ws.pA [links], residuals g_, base acceleration A0 and, if
  /// `with_velocity_products`, ws.C. Overwrites ws.pA, ws.u, ws.A, g_.
  void solve(std::span<const double> tau, bool with_velocity_products, const Vec6& A0, std::span<double> vdot) {
    for (int node = world_ - 1; node >= 0; --node) {
      Vec6& p = ws_.pA[at(node)];
      reduce_at(node, &p);
      const Node& n = x_.nodes[at(node)];
      const LinkPlace& link = links_[at(node)];
      for (int f = link.v_index + link.nv; f-- > link.v_index;) {
        const double u = (tau.empty() ? 0.0 : tau[at(f)]) - dot(ws_.S[at(f)], p);
        const double du = ws_.d[at(f)] * u;
        ws_.u[at(f)] = u;
        p += ws_.U[at(f)] * du;
        const double* s = s_of(n, link, f);
        for_passing_multipliers(n, [&](int g, int row) { c_.g_[at(g)] -= s[row] * du; });
      }
      if (with_velocity_products) {
        const Vec6& C = ws_.C[at(node)];
        p += ws_.IA[at(node)] * C;
        for_passing_multipliers(n, [&](int g, int row) { c_.g_[at(g)] -= dot(c_.P_[at(n.row + row)], C); });
      }
      if (link.parent >= 0) ws_.pA[at(link.parent)] += p;
    }
    reduce_at(world_, nullptr);
    recover_at(world_, A0);
    for (int node = 0; node < world_; ++node) {
      const LinkPlace& link = links_[at(node)];
      const Node& n = x_.nodes[at(node)];
      Vec6 A = link.parent >= 0 ? ws_.A[at(link.parent)] : A0;
      if (with_velocity_products) A += ws_.C[at(node)];
      for (int f = link.v_index; f < link.v_index + link.nv; ++f) {
        double u = ws_.u[at(f)] - dot(ws_.U[at(f)], A);
        const double* s = s_of(n, link, f);
        for_passing_multipliers(n, [&](int g, int row) { u -= s[row] * c_.lambda_[at(g)]; });
        vdot[at(f)] = ws_.d[at(f)] * u;
        A += ws_.S[at(f)] * vdot[at(f)];
      }
      ws_.A[at(node)] = A;
      recover_at(node, A);
    }
    std::ranges::fill(c_.multipliers_, 0.0);
    for (std::size_t k = 0; k < x_.row.size(); ++k) c_.multipliers_[at(x_.row[k])] = c_.lambda_[k];
  }

  /// Sets ws.pA to the velocity-dependent forces minus the external forces, and g_ to the velocity products of the rows.
  void forces_of_motion(std::span<const Vec6> external) {
    for (std::size_t i = 0; i < ws_.pA.size(); ++i) {
      ws_.pA[i] = cross_force(ws_.V[i], c_.I_[i] * ws_.V[i]);
      if (!external.empty()) ws_.pA[i] -= Vec6{external[i].w - cross(ws_.p0, external[i].v), external[i].v};
    }
    for (std::size_t k = 0; k < x_.row.size(); ++k) c_.g_[k] = c_.rows_.drift[at(x_.row[k])];
  }
  /// Returns the change of v that removes the residuals g_: -M^-1 J^T (J M^-1 J^T)^-1 g. @return [nv], valid until the next solve
  std::span<const double> correct() {
    std::ranges::fill(ws_.pA, Vec6{});
    solve({}, false, {}, c_.delta_);
    return c_.delta_;
  }

  /// g_ <- J v
  void residual_of_velocity(std::span<const double> v) {
    for (const ClosedStructure::Entry& e : x_.entries) {
      const Loop& loop = c_.loops_[at(e.loop)];
      if (loop.type == LoopType::gear) {
        c_.g_[at(e.first)] = v[at(loop.dof_a)] - c_.rows_.slope[at(e.loop)] * v[at(loop.dof_b)];
        continue;
      }
      const Vec6 V_ba = velocity(loop.link_b) - velocity(loop.link_a);
      for (int k = e.first; k < e.first + e.rows; ++k) c_.g_[at(k)] = dot(c_.rows_.W[at(x_.row[at(k)])], V_ba);
    }
  }
  /// Adds given values to g_. @param values [rows of all loops]
  void add_residual(std::span<const double> values) {
    for (std::size_t k = 0; k < x_.row.size(); ++k) c_.g_[k] += values[at(x_.row[k])];
  }
  /// Reserves the memory of find_responses().
  static void make_room(const Mechanism& m, const ClosedLinks& c, LinkResponses& out);
  /// Calculates the inverse inertias of links and DOFs of the last factorization; stiff_links.cpp.
  void find_responses(LinkResponses& out) const;
  void residual_of_position() {
    for (std::size_t k = 0; k < x_.row.size(); ++k) c_.g_[k] = c_.rows_.gap[at(x_.row[k])];
  }
  /// Computes the link velocities for the DOF velocities v into ws.A, from the motion subspaces ws.S.
  void sweep_velocity(std::span<const double> v) {
    for (int node = 0; node < world_; ++node) {
      const LinkPlace& link = links_[at(node)];
      Vec6 V = link.parent >= 0 ? ws_.A[at(link.parent)] : Vec6{};
      for (int f = link.v_index; f < link.v_index + link.nv; ++f) V += ws_.S[at(f)] * v[at(f)];
      ws_.A[at(node)] = V;
    }
  }

 private:
  static std::size_t at(int i) { return static_cast<std::size_t>(i); }

  using Node = ClosedStructure::Node;
  using Entry = ClosedStructure::Entry;
  using Elimination = ClosedStructure::Elimination;

  [[nodiscard]] Vec6 velocity(int link) const { return link < 0 ? Vec6{} : ws_.A[at(link)]; }

  /// Calls f(multiplier index, row index at the node) for every multiplier of the node's passing loops (closed_structure.h).
  template <class F>
  void for_passing_multipliers(const Node& n, F&& f) const {
    for (int i = 0; i < n.passing_count; ++i) {
      const ClosedStructure::Present& p = x_.present[at(n.present + i)];
      const Entry& e = x_.entries[at(p.entry)];
      for (int k = 0; k < e.rows; ++k) f(e.first + k, p.row - n.row + k);
    }
  }

  double* s_of(const Node& n, const LinkPlace& link, int dof) const {
    return c_.s_.data() + n.s_row + (dof - link.v_index) * n.passing_rows;
  }
  /// rows_at(), first_row(): number of rows and index of the first row of passing loop `passing` at the node.
  int rows_at(const Node& n, int passing) const { return x_.entries[at(x_.present[at(n.present + passing)].entry)].rows; }
  int first_row(const Node& n, int passing) const { return x_.present[at(n.present + passing)].row - n.row; }
  double* block(int index) const { return c_.Lambda_.data() + 36 * index; }

  /// The recursion from the tips to the base. @param extra [nv] or empty, added to the pivots
  bool eliminate(double dependent, std::span<const double> extra) {
    dependent_ = dependent;
    c_.singular_dof_ = -1;
    c_.min_pivot_ratio_ = 1;
    for (int node = world_ - 1; node >= 0; --node) {
      ArticulatedInertia& IA = ws_.IA[at(node)];
      eliminate_at(node, &IA);
      if (!pass_joint(node, IA, extra)) return false;
      if (const int parent = links_[at(node)].parent; parent >= 0) add(ws_.IA[at(parent)], IA);
      const Node& n = x_.nodes[at(node)];
      for (int i = n.present; i < n.present + n.passing_count; ++i) {
        const ClosedStructure::Present& p = x_.present[at(i)];
        const int up = x_.present[at(p.parent)].row;
        for (int k = 0; k < x_.entries[at(p.entry)].rows; ++k) c_.P_[at(up + k)] += c_.P_[at(p.row + k)];
      }
    }
    eliminate_at(world_, nullptr);
    c_.rank_ = 0;
    std::ranges::fill(c_.independent_, char{0});
    for (std::size_t i = 0; i < x_.entries.size(); ++i) {
      const Entry& e = x_.entries[i];
      c_.rank_ += c_.rank_of_[i];
      for (int k = 0; k < c_.rank_of_[i]; ++k) c_.independent_[at(x_.row[at(e.first + c_.pivots_[at(e.first + k)])])] = 1;
    }
    return true;
  }

  void begin_factor() {
    for (std::size_t i = 0; i < ws_.IA.size(); ++i) ws_.IA[i] = articulated(c_.I_[i]);
    std::ranges::fill(c_.P_, Vec6{});
    std::ranges::fill(c_.Lambda_, 0.0);
    std::ranges::fill(c_.reduced_, 0.0);
    std::ranges::fill(c_.terms_, 0.0);
    for (const Entry& e : x_.entries) {
      if (e.present_b < 0) continue;  // a gear
      const int a = x_.present[at(e.present_a)].row, b = x_.present[at(e.present_b)].row;
      for (int k = 0; k < e.rows; ++k) {
        const Vec6& w = c_.rows_.W[at(x_.row[at(e.first + k)])];
        c_.P_[at(b + k)] -= w;
        c_.P_[at(a + k)] += w;
      }
    }
  }

  /// Eliminates the node's DOFs from IA, and from P and Lambda of the loops that pass it. @return false: a pivot is not positive
  bool pass_joint(int node, ArticulatedInertia& IA, std::span<const double> extra) {
    const Node& n = x_.nodes[at(node)];
    const LinkPlace& link = links_[at(node)];
    for (int f = link.v_index + link.nv; f-- > link.v_index;) {
      const Vec6& S = ws_.S[at(f)];
      const Vec6 U = IA * S;
      const double pivot = dot(S, U) + ws_.armature[at(f)] + (extra.empty() ? 0.0 : extra[at(f)]);
      if (!(pivot > 0)) {
        c_.singular_dof_ = f;
        return false;
      }
      const double d = 1.0 / pivot;
      ws_.U[at(f)] = U;
      ws_.d[at(f)] = d;
      add_outer(IA, U, -d);
      if (n.passing_rows == 0) continue;
      double* s = s_of(n, link, f);
      Vec6* P = c_.P_.data() + n.row;
      for (int k = 0; k < n.passing_rows; ++k) s[k] = dot(S, P[k]);
      for (int k = n.gears; k < n.gears + n.gear_count; ++k) {
        const ClosedStructure::Gear& gear = x_.gears[at(k)];
        if (gear.dof == f) s[first_row(n, gear.passing)] -= gear.second ? -c_.rows_.slope[at(gear.loop)] : 1.0;
      }
      for_passing_multipliers(n, [&](int g, int row) {
        const double f2 = dot(P[row].v, P[row].v), arm2 = c_.length_ * c_.length_;
        c_.terms_[at(g)] += d * (dot(S.w, S.w) * (dot(P[row].w, P[row].w) + arm2 * f2) + dot(S.v, S.v) * f2);
      });
      for (int k = 0; k < n.passing_rows; ++k) P[k] -= U * (d * s[k]);
      for (int k = n.pairs; k < n.pairs + n.pair_count; ++k) {
        const ClosedStructure::Pair& pair = x_.pairs[at(k)];
        const double *a = s + first_row(n, pair.a), *b = s + first_row(n, pair.b);
        const int rows_a = rows_at(n, pair.a), rows_b = rows_at(n, pair.b);
        double* to = block(pair.block);
        for (int i = 0; i < rows_a; ++i)
          for (int j = 0; j < rows_b; ++j) *to++ += d * a[i] * b[j];
      }
    }
    return true;
  }

  /// Pivoted Cholesky factorization of the loop's diagonal block, largest pivot first. Stops when only dependent rows are left.
  void factor_block(int entry) {
    const Entry& e = x_.entries[at(entry)];
    const int r = e.rows;
    const double* A = block(e.diagonal);
    double* C = c_.C_.data() + 36 * entry;
    int* order = c_.pivots_.data() + e.first;
    for (int i = 0; i < r; ++i) order[i] = i;
    double diagonal[6], maximum[2] = {};  // maximum: [0] of the position rows, [1] of the rotation rows
    for (int i = 0; i < r; ++i) {
      diagonal[i] = A[i * r + i];
      double& scale = maximum[i < e.position_rows ? 0 : 1];
      scale = std::max(scale, diagonal[i] + c_.reduced_[at(e.first + i)]);
    }
    int& rank = c_.rank_of_[at(entry)];
    for (rank = 0; rank < r; ++rank) {
      const int k = rank;
      int best = k;
      const auto part = [&](int i) {
        if (!use_rows_.empty()) return use_rows_[at(x_.row[at(e.first + order[i])])] ? diagonal[order[i]] : 0.0;
        const double scale = maximum[order[i] < e.position_rows ? 0 : 1];
        return diagonal[order[i]] > immobile_row * c_.terms_[at(e.first + order[i])] ? diagonal[order[i]] / scale : 0.0;
      };
      for (int i = k + 1; i < r; ++i)
        if (part(i) > part(best)) best = i;
      if (!(part(best) > (use_rows_.empty() ? dependent_ : 0.0))) break;
      c_.min_pivot_ratio_ = std::min(c_.min_pivot_ratio_, part(best));
      if (best != k) {
        std::swap(order[k], order[best]);
        for (int j = 0; j < k; ++j) std::swap(C[k * r + j], C[best * r + j]);
      }
      const double c = std::sqrt(diagonal[order[k]]);
      C[k * r + k] = c;
      for (int i = k + 1; i < r; ++i) {
        double x = A[order[i] * r + order[k]];
        for (int j = 0; j < k; ++j) x -= C[i * r + j] * C[k * r + j];
        C[i * r + k] = x / c;
        diagonal[order[i]] -= C[i * r + k] * C[i * r + k];
      }
    }
  }

  /// Eliminates the multipliers of the loops that meet at the node: IA += Z Z^T, with Z = P C^-T.
  /// P: columns of a loop, C: Cholesky factor of its block. @param IA null at the world
  void eliminate_at(int node, ArticulatedInertia* IA) {
    const Node& n = x_.nodes[at(node)];
    for (int x = n.eliminations; x < n.eliminations + n.elimination_count; ++x) {
      const Elimination& elimination = x_.eliminations[at(x)];
      factor_block(elimination.entry);
      const Entry& e = x_.entries[at(elimination.entry)];
      const int r = e.rows, rank = c_.rank_of_[at(elimination.entry)];
      const double* C = c_.C_.data() + 36 * elimination.entry;
      const int* order = c_.pivots_.data() + e.first;
      const int row = x_.present[at(elimination.present)].row;
      Vec6* Z = c_.Z_.data() + e.first;
      for (int k = 0; k < rank; ++k) {
        Z[k] = c_.P_[at(row + order[k])];
        for (int j = 0; j < k; ++j) Z[k] -= Z[j] * C[k * r + j];
        Z[k] = Z[k] * (1.0 / C[k * r + k]);
        if (IA) add_outer(*IA, Z[k], 1.0);
      }
      for (int o = 0; o < elimination.neighbour_count; ++o) reduce_neighbour(elimination, elimination.neighbours + o);
      for (int k = elimination.updates; k < elimination.updates + elimination.update_count; ++k) {
        const ClosedStructure::Update& u = x_.updates[at(k)];
        const int rows_a = neighbour(u.a).rows, rows_b = neighbour(u.b).rows;
        for (int q = 0; q < rank; ++q) {
          const double *Ya = Y(u.a) + q * rows_a, *Yb = Y(u.b) + q * rows_b;
          double* to = block(u.block);
          for (int i = 0; i < rows_a; ++i)
            for (int j = 0; j < rows_b; ++j) *to++ -= Ya[i] * Yb[j];
        }
      }
    }
  }

  const Entry& neighbour(int index) const { return x_.entries[at(x_.neighbours[at(index)].entry)]; }
  double* Y(int neighbour) const { return c_.Y_.data() + 36 * neighbour; }

  /// Effect of eliminating loop e on another loop o: Y = C^-1 Lambda(e, o); P_o -= Z Y. C, Z: see eliminate_at().
  void reduce_neighbour(const Elimination& elimination, int index) {
    const Entry &e = x_.entries[at(elimination.entry)], &other = neighbour(index);
    const ClosedStructure::Neighbour& o = x_.neighbours[at(index)];
    const int r = e.rows, columns = other.rows;
    const double* C = c_.C_.data() + 36 * elimination.entry;
    const int* order = c_.pivots_.data() + e.first;
    const double* from = block(o.block);
    const int row = x_.present[at(o.present)].row;
    double* to = Y(index);
    for (int k = 0; k < c_.rank_of_[at(elimination.entry)]; ++k)
      for (int j = 0; j < columns; ++j) {
        double y = o.transposed ? from[j * r + order[k]] : from[order[k] * columns + j];
        for (int i = 0; i < k; ++i) y -= C[k * r + i] * to[i * columns + j];
        y /= C[k * r + k];
        to[k * columns + j] = y;
        c_.reduced_[at(other.first + j)] += y * y;
        c_.P_[at(row + j)] -= c_.Z_[at(e.first + k)] * y;
      }
  }

  /// Forward substitution for the elimination in eliminate_at(): updates g_ and p. @param p bias force of the node; null at the world
  void reduce_at(int node, Vec6* p) {
    const Node& n = x_.nodes[at(node)];
    for (int x = n.eliminations; x < n.eliminations + n.elimination_count; ++x) {
      const Elimination& elimination = x_.eliminations[at(x)];
      const Entry& e = x_.entries[at(elimination.entry)];
      const double* C = c_.C_.data() + 36 * elimination.entry;
      double* z = c_.z_.data() + e.first;
      for (int k = 0; k < c_.rank_of_[at(elimination.entry)]; ++k) {
        double y = c_.g_[at(e.first + c_.pivots_[at(e.first + k)])];
        for (int j = 0; j < k; ++j) y -= C[k * e.rows + j] * z[j];
        z[k] = y / C[k * e.rows + k];
        if (p) *p -= c_.Z_[at(e.first + k)] * z[k];
        for (int o = elimination.neighbours; o < elimination.neighbours + elimination.neighbour_count; ++o) {
          const Entry& other = neighbour(o);
          for (int j = 0; j < other.rows; ++j) c_.g_[at(other.first + j)] -= Y(o)[k * other.rows + j] * z[k];
        }
      }
    }
  }

  /// Back substitution: lambda = C^-T (Z^T A - z - Y lambda_neighbours). @param A acceleration of the node
  void recover_at(int node, const Vec6& A) {
    const Node& n = x_.nodes[at(node)];
    for (int x = n.eliminations + n.elimination_count; x-- > n.eliminations;) {
      const Elimination& elimination = x_.eliminations[at(x)];
      const Entry& e = x_.entries[at(elimination.entry)];
      const int rank = c_.rank_of_[at(elimination.entry)];
      const double* C = c_.C_.data() + 36 * elimination.entry;
      const int* order = c_.pivots_.data() + e.first;
      double y[6] = {};
      for (int k = 0; k < rank; ++k) {
        y[k] = dot(c_.Z_[at(e.first + k)], A) - c_.z_[at(e.first + k)];
        for (int o = elimination.neighbours; o < elimination.neighbours + elimination.neighbour_count; ++o) {
          const Entry& other = neighbour(o);
          for (int j = 0; j < other.rows; ++j) y[k] -= Y(o)[k * other.rows + j] * c_.lambda_[at(other.first + j)];
        }
      }
      for (int k = 0; k < e.rows; ++k) c_.lambda_[at(e.first + k)] = 0;
      for (int k = rank; k-- > 0;) {
        for (int i = k + 1; i < rank; ++i) y[k] -= C[i * e.rows + k] * y[i];
        y[k] /= C[k * e.rows + k];
        c_.lambda_[at(e.first + order[k])] = y[k];
      }
    }
  }

  const Mechanism& m_;
  std::span<const LinkPlace> links_;
  Workspace& ws_;
  ClosedLinks& c_;
  const ClosedStructure& x_;
  int world_;
  double dependent_ = dependent_row;
  std::span<const char> use_rows_;
};

}  // namespace ugoki::dynamics
