#include "ugoki/dynamics/closed_links.h"

#include <algorithm>
#include <cmath>

#include "ugoki/base/check.h"
#include "ugoki/dynamics/dynamics.h"
#include "ugoki/mechanism/state.h"

namespace ugoki::dynamics {
namespace {

/// A pivot below this part of what the row was before eliminations is rounding: the row follows from others. The multipliers'
/// matrix is quadratic in the Jacobian, so rows whose angle to the others is below 1e-6 rad count as dependent.
constexpr double dependent = 1e-12;

std::size_t at(int i) { return static_cast<std::size_t>(i); }

ArticulatedInertia articulated(const Inertia& r) { return {r.I, Mat3::skew(r.h), {r.mass, r.mass, r.mass, 0, 0, 0}}; }

Vec6 operator*(const ArticulatedInertia& a, const Vec6& m) { return {a.I * m.w + a.H * m.v, transpose_times(a.H, m.w) + a.M * m.v}; }

Sym3 outer(const Vec3& a, double s) { return {s * a.x * a.x, s * a.y * a.y, s * a.z * a.z, s * a.x * a.y, s * a.x * a.z, s * a.y * a.z}; }

/// a += u u^T s
void add_outer(ArticulatedInertia& a, const Vec6& u, double s) {
  a.I = a.I + outer(u.w, s);
  a.H += Mat3::outer(u.w, u.v) * s;
  a.M = a.M + outer(u.v, s);
}

void add(ArticulatedInertia& a, const ArticulatedInertia& b) {
  a.I = a.I + b.I;
  a.H += b.H;
  a.M = a.M + b.M;
}

/// Greatest distance of a link from the reference point, m.
double extent(const Workspace& ws) {
  double greatest = 0;
  for (const Pose& X : ws.X_WB) greatest = std::max(greatest, norm(X.p - ws.p0));
  return greatest;
}

Inertia operator*(const Inertia& i, double s) { return {i.mass * s, i.h * s, i.I * s}; }

}  // namespace

/// The sweeps over the nodes.
class ClosedSolver {
 public:
  ClosedSolver(const Mechanism& m, Workspace& ws, ClosedLinks& c) : m_(m), ws_(ws), c_(c), world_(m.link_count()) {}

  void update_rows(std::span<const double> q, std::span<const double> v) { update_loop_rows(m_, ws_, c_.loops_, q, v, c_.rows_); }

  bool factor() {
    begin_factor();
    for (int node = world_ - 1; node >= 0; --node) {
      ArticulatedInertia& IA = ws_.IA[at(node)];
      eliminate_at(node, &IA);
      if (!pass_joint(node, IA)) return false;
      if (const int parent = m_.link(node).parent; parent >= 0) add(ws_.IA[at(parent)], IA);
      for (const ClosedLinks::Present& p : present(node))
        for (int k = 0; p.parent_P >= 0 && k < c_.entries_[at(p.entry)].rows; ++k) c_.P_[at(p.parent_P + k)] += c_.P_[at(p.P + k)];
    }
    eliminate_at(world_, nullptr);
    c_.rank_ = 0;
    std::ranges::fill(c_.independent_, char{0});
    for (const ClosedLinks::Entry& e : c_.entries_) {
      c_.rank_ += e.rank;
      for (int k = 0; k < e.rank; ++k) c_.independent_[at(c_.row_[at(e.first + c_.pivots_[at(e.first + k)])])] = 1;
    }
    return true;
  }

  /// Solves with the forces in ws.pA [links], the accelerations `C` of the joints (or none), the residuals in g_, and the base's
  /// acceleration A0; overwrites ws.pA, ws.u, ws.A.
  void solve(std::span<const double> tau, bool with_velocity_products, const Vec6& A0, std::span<double> vdot) {
    for (int node = world_ - 1; node >= 0; --node) {
      Vec6& p = ws_.pA[at(node)];
      reduce_at(node, &p);
      const ClosedLinks::Node& n = c_.nodes_[at(node)];
      const Link& link = m_.link(node);
      for (int f = link.v_index + link.joint.nv(); f-- > link.v_index;) {
        const double u = (tau.empty() ? 0.0 : tau[at(f)]) - dot(ws_.S[at(f)], p);
        const double du = ws_.d[at(f)] * u;
        ws_.u[at(f)] = u;
        p += ws_.U[at(f)] * du;
        const double* s = c_.s_.data() + c_.s_start_[at(f)];
        for_passing_multipliers(n, [&](int g, int row) { c_.g_[at(g)] -= s[row] * du; });
      }
      if (with_velocity_products) {
        const Vec6& C = ws_.C[at(node)];
        p += ws_.IA[at(node)] * C;
        for_passing_multipliers(n, [&](int g, int row) { c_.g_[at(g)] -= dot(c_.P_[at(n.P + row)], C); });
      }
      if (link.parent >= 0) ws_.pA[at(link.parent)] += p;
    }
    reduce_at(world_, nullptr);
    recover_at(world_, A0);
    for (int node = 0; node < world_; ++node) {
      const Link& link = m_.link(node);
      const ClosedLinks::Node& n = c_.nodes_[at(node)];
      Vec6 A = link.parent >= 0 ? ws_.A[at(link.parent)] : A0;
      if (with_velocity_products) A += ws_.C[at(node)];
      for (int f = link.v_index; f < link.v_index + link.joint.nv(); ++f) {
        double u = ws_.u[at(f)] - dot(ws_.U[at(f)], A);
        const double* s = c_.s_.data() + c_.s_start_[at(f)];
        for_passing_multipliers(n, [&](int g, int row) { u -= s[row] * c_.lambda_[at(g)]; });
        vdot[at(f)] = ws_.d[at(f)] * u;
        A += ws_.S[at(f)] * vdot[at(f)];
      }
      ws_.A[at(node)] = A;
      recover_at(node, A);
    }
    std::ranges::fill(c_.multipliers_, 0.0);
    for (std::size_t k = 0; k < c_.row_.size(); ++k) c_.multipliers_[at(c_.row_[k])] = c_.lambda_[k];
  }

  void forces_of_motion(std::span<const Vec6> external) {
    for (std::size_t i = 0; i < ws_.pA.size(); ++i) {
      ws_.pA[i] = cross_force(ws_.V[i], c_.I_[i] * ws_.V[i]);
      if (!external.empty()) ws_.pA[i] -= Vec6{external[i].w - cross(ws_.p0, external[i].v), external[i].v};
    }
    for (std::size_t k = 0; k < c_.row_.size(); ++k) c_.g_[k] = c_.rows_.drift[at(c_.row_[k])];
  }
  void no_forces() { std::ranges::fill(ws_.pA, Vec6{}); }

  /// g_ <- J v
  void residual_of_velocity(std::span<const double> v) {
    for (const ClosedLinks::Entry& e : c_.entries_) {
      const Loop& loop = c_.loops_[at(e.loop)];
      if (loop.type == LoopType::gear) {
        c_.g_[at(e.first)] = v[at(loop.freedom_a)] - c_.rows_.slope[at(e.loop)] * v[at(loop.freedom_b)];
        continue;
      }
      const Vec6 V_ba = velocity(loop.link_b) - velocity(loop.link_a);
      for (int k = e.first; k < e.first + e.rows; ++k) c_.g_[at(k)] = dot(c_.rows_.W[at(c_.row_[at(k)])], V_ba);
    }
  }
  void residual_of_position() {
    for (std::size_t k = 0; k < c_.row_.size(); ++k) c_.g_[k] = c_.rows_.gap[at(c_.row_[k])];
  }
  /// ws.A <- velocities of the links at v, by the subspaces that are there.
  void sweep_velocity(std::span<const double> v) {
    for (int node = 0; node < world_; ++node) {
      const Link& link = m_.link(node);
      Vec6 V = link.parent >= 0 ? ws_.A[at(link.parent)] : Vec6{};
      for (int f = link.v_index; f < link.v_index + link.joint.nv(); ++f) V += ws_.S[at(f)] * v[at(f)];
      ws_.A[at(node)] = V;
    }
  }

 private:
  [[nodiscard]] Vec6 velocity(int link) const { return link < 0 ? Vec6{} : ws_.A[at(link)]; }

  std::span<const ClosedLinks::Present> present(int node) const {
    const ClosedLinks::Node& n = c_.nodes_[at(node)];
    return std::span(c_.present_).subspan(at(n.present), at(n.present_count));
  }

  /// f(place of the multiplier, its place among the node's rows) for every multiplier that passes the node.
  template <class F>
  void for_passing_multipliers(const ClosedLinks::Node& n, F&& f) const {
    for (int i = 0; i < n.passing_count; ++i) {
      const ClosedLinks::Present& p = c_.present_[at(n.present + i)];
      const ClosedLinks::Entry& e = c_.entries_[at(p.entry)];
      for (int k = 0; k < e.rows; ++k) f(e.first + k, p.P - n.P + k);
    }
  }

  void begin_factor() {
    std::ranges::copy(ws_.I, c_.I_.begin());
    for (const ClosedLinks::Share& s : c_.shares_) c_.I_[at(s.link)] = ws_.I[at(s.source)] * s.part;
    for (std::size_t i = 0; i < ws_.IA.size(); ++i) ws_.IA[i] = articulated(c_.I_[i]);
    std::ranges::fill(c_.P_, Vec6{});
    std::ranges::fill(c_.Lambda_, 0.0);
    std::ranges::fill(c_.reduced_, 0.0);
    for (const ClosedLinks::Entry& e : c_.entries_) {
      if (e.P_b < 0) continue;  // a gear
      for (int k = 0; k < e.rows; ++k) {
        const Vec6& w = c_.rows_.W[at(c_.row_[at(e.first + k)])];
        c_.P_[at(e.P_b + k)] -= w;
        c_.P_[at(e.P_a + k)] += w;
      }
    }
  }

  bool pass_joint(int node, ArticulatedInertia& IA) {
    const ClosedLinks::Node& n = c_.nodes_[at(node)];
    const Link& link = m_.link(node);
    for (int f = link.v_index + link.joint.nv(); f-- > link.v_index;) {
      const Vec6& S = ws_.S[at(f)];
      const Vec6 U = IA * S;
      const double pivot = dot(S, U) + ws_.freedoms[at(f)].armature;
      if (!(pivot > 0)) return false;
      const double d = 1.0 / pivot;
      ws_.U[at(f)] = U;
      ws_.d[at(f)] = d;
      add_outer(IA, U, -d);
      if (n.passing_rows == 0) continue;
      double* s = c_.s_.data() + c_.s_start_[at(f)];
      Vec6* P = c_.P_.data() + n.P;
      for (int k = 0; k < n.passing_rows; ++k) s[k] = dot(S, P[k]);
      for (int k = n.gears; k < n.gears + n.gear_count; ++k) {
        const ClosedLinks::Gear& gear = c_.gears_[at(k)];
        if (gear.freedom == f) c_.s_[at(gear.s)] -= gear.second ? -c_.rows_.slope[at(gear.loop)] : 1.0;
      }
      for (int k = 0; k < n.passing_rows; ++k) P[k] -= U * (d * s[k]);
      for (int k = n.pairs; k < n.pairs + n.pair_count; ++k) {
        const ClosedLinks::Pair& pair = c_.pairs_[at(k)];
        double* block = c_.Lambda_.data() + pair.block;
        for (int i = 0; i < pair.rows_a; ++i) {
          const double t = d * s[pair.a + i];
          for (int j = 0; j < pair.rows_b; ++j) *block++ += t * s[pair.b + j];
        }
      }
    }
    return true;
  }

  /// Cholesky of the entry's own block with the greatest pivot first; stops where only dependent rows are left.
  void factor_block(ClosedLinks::Entry& e) {
    const int r = e.rows;
    double* A = c_.Lambda_.data() + e.diagonal;  // full, symmetric; its lower part is overwritten
    double* C = c_.C_.data() + e.C;
    int* order = c_.pivots_.data() + e.first;
    for (int i = 0; i < r; ++i) order[i] = i;
    double diagonal[6], before[6];
    for (int i = 0; i < r; ++i) {
      diagonal[i] = A[i * r + i];
      before[i] = diagonal[i] + c_.reduced_[at(e.first + i)];
    }
    e.rank = 0;
    for (int k = 0; k < r; ++k) {
      int best = k;
      const auto part = [&](int i) { return before[order[i]] > 0 ? diagonal[order[i]] / before[order[i]] : 0.0; };
      for (int i = k + 1; i < r; ++i)
        if (part(i) > part(best)) best = i;
      if (!(part(best) > dependent)) break;
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
      ++e.rank;
    }
  }

  void eliminate_at(int node, ArticulatedInertia* IA) {
    const ClosedLinks::Node& n = c_.nodes_[at(node)];
    for (int x = n.eliminations; x < n.eliminations + n.elimination_count; ++x) {
      const ClosedLinks::Elimination& elimination = c_.eliminations_[at(x)];
      ClosedLinks::Entry& e = c_.entries_[at(elimination.entry)];
      factor_block(e);
      const int r = e.rows;
      const double* C = c_.C_.data() + e.C;
      const int* order = c_.pivots_.data() + e.first;
      Vec6* Z = c_.Z_.data() + e.first;
      for (int k = 0; k < e.rank; ++k) {
        Z[k] = c_.P_[at(elimination.P + order[k])];
        for (int j = 0; j < k; ++j) Z[k] -= Z[j] * C[k * r + j];
        Z[k] = Z[k] * (1.0 / C[k * r + k]);
        if (IA) add_outer(*IA, Z[k], 1.0);
      }
      for (int o = elimination.neighbours; o < elimination.neighbours + elimination.neighbour_count; ++o)
        reduce_neighbour(e, c_.neighbours_[at(o)]);
      for (int k = elimination.updates; k < elimination.updates + elimination.update_count; ++k) {
        const ClosedLinks::Update& u = c_.updates_[at(k)];
        const ClosedLinks::Neighbour &a = c_.neighbours_[at(elimination.neighbours + u.a)],
                                     &b = c_.neighbours_[at(elimination.neighbours + u.b)];
        const int rows_a = c_.entries_[at(a.entry)].rows, rows_b = c_.entries_[at(b.entry)].rows;
        for (int q = 0; q < e.rank; ++q) {
          const double *Ya = c_.Y_.data() + a.Y + q * rows_a, *Yb = c_.Y_.data() + b.Y + q * rows_b;
          double* block = c_.Lambda_.data() + u.block;
          for (int i = 0; i < rows_a; ++i)
            for (int j = 0; j < rows_b; ++j) *block++ -= Ya[i] * Yb[j];
        }
      }
    }
  }

  /// Y = C^-1 Lambda(e, o); P_o -= Z^T Y
  void reduce_neighbour(const ClosedLinks::Entry& e, const ClosedLinks::Neighbour& o) {
    const ClosedLinks::Entry& other = c_.entries_[at(o.entry)];
    const int r = e.rows, columns = other.rows;
    const double* C = c_.C_.data() + e.C;
    const int* order = c_.pivots_.data() + e.first;
    const double* block = c_.Lambda_.data() + o.block;
    double* Y = c_.Y_.data() + o.Y;
    for (int k = 0; k < e.rank; ++k)
      for (int j = 0; j < columns; ++j) {
        double y = o.transposed ? block[j * r + order[k]] : block[order[k] * columns + j];
        for (int i = 0; i < k; ++i) y -= C[k * r + i] * Y[i * columns + j];
        y /= C[k * r + k];
        Y[k * columns + j] = y;
        c_.reduced_[at(other.first + j)] += y * y;
        c_.P_[at(o.P + j)] -= c_.Z_[at(e.first + k)] * y;
      }
  }

  void reduce_at(int node, Vec6* p) {
    const ClosedLinks::Node& n = c_.nodes_[at(node)];
    for (int x = n.eliminations; x < n.eliminations + n.elimination_count; ++x) {
      const ClosedLinks::Elimination& elimination = c_.eliminations_[at(x)];
      const ClosedLinks::Entry& e = c_.entries_[at(elimination.entry)];
      const double* C = c_.C_.data() + e.C;
      double* z = c_.z_.data() + e.first;
      for (int k = 0; k < e.rank; ++k) {
        double y = c_.g_[at(e.first + c_.pivots_[at(e.first + k)])];
        for (int j = 0; j < k; ++j) y -= C[k * e.rows + j] * z[j];
        z[k] = y / C[k * e.rows + k];
        if (p) *p -= c_.Z_[at(e.first + k)] * z[k];
        for (int o = elimination.neighbours; o < elimination.neighbours + elimination.neighbour_count; ++o) {
          const ClosedLinks::Neighbour& other = c_.neighbours_[at(o)];
          const ClosedLinks::Entry& oe = c_.entries_[at(other.entry)];
          const double* Y = c_.Y_.data() + other.Y + k * oe.rows;
          for (int j = 0; j < oe.rows; ++j) c_.g_[at(oe.first + j)] -= Y[j] * z[k];
        }
      }
    }
  }

  /// lambda = C^-T (Z A - z - Y lambda_neighbours)
  void recover_at(int node, const Vec6& A) {
    const ClosedLinks::Node& n = c_.nodes_[at(node)];
    for (int x = n.eliminations + n.elimination_count; x-- > n.eliminations;) {
      const ClosedLinks::Elimination& elimination = c_.eliminations_[at(x)];
      const ClosedLinks::Entry& e = c_.entries_[at(elimination.entry)];
      const double* C = c_.C_.data() + e.C;
      const int* order = c_.pivots_.data() + e.first;
      double y[6] = {};
      for (int k = 0; k < e.rank; ++k) {
        y[k] = dot(c_.Z_[at(e.first + k)], A) - c_.z_[at(e.first + k)];
        for (int o = elimination.neighbours; o < elimination.neighbours + elimination.neighbour_count; ++o) {
          const ClosedLinks::Neighbour& other = c_.neighbours_[at(o)];
          const ClosedLinks::Entry& oe = c_.entries_[at(other.entry)];
          const double* Y = c_.Y_.data() + other.Y + k * oe.rows;
          for (int j = 0; j < oe.rows; ++j) y[k] -= Y[j] * c_.lambda_[at(oe.first + j)];
        }
      }
      for (int k = 0; k < e.rows; ++k) c_.lambda_[at(e.first + k)] = 0;
      for (int k = e.rank; k-- > 0;) {
        for (int i = k + 1; i < e.rank; ++i) y[k] -= C[i * e.rows + k] * y[i];
        y[k] /= C[k * e.rows + k];
        c_.lambda_[at(e.first + order[k])] = y[k];
      }
    }
  }

  const Mechanism& m_;
  Workspace& ws_;
  ClosedLinks& c_;
  int world_;
};

ClosedStatus factor_closed_links(const Mechanism& m, Workspace& ws, ClosedLinks& closed, std::span<const double> q,
                                 std::span<const double> v) {
  ClosedSolver solver(m, ws, closed);
  solver.update_rows(q, v);
  return solver.factor() ? ClosedStatus::ok : ClosedStatus::singular_inertia;
}

void calc_closed_forward_dynamics(const Mechanism& m, Workspace& ws, ClosedLinks& closed, std::span<const double> tau, const Vec3& gravity,
                                  std::span<const Vec6> external, std::span<double> vdot) {
  ClosedSolver solver(m, ws, closed);
  solver.forces_of_motion(external);
  solver.solve(tau, true, {{}, -gravity}, vdot);
}

void project_velocity(const Mechanism& m, Workspace& ws, ClosedLinks& closed, std::span<double> v) {
  ClosedSolver solver(m, ws, closed);
  solver.sweep_velocity(v);
  solver.residual_of_velocity(v);
  solver.no_forces();
  solver.solve({}, false, {}, ws.vdot);
  for (std::size_t i = 0; i < v.size(); ++i) v[i] += ws.vdot[i];
}

ClosedStatus project_position(const Mechanism& m, Workspace& ws, ClosedLinks& closed, std::span<double> q, std::span<const double> v,
                              double& gap, int limit) {
  double last = HUGE_VAL;
  for (int step = 0;; ++step) {
    update_kinematics(m, q, v, ws);
    if (factor_closed_links(m, ws, closed, q, v) != ClosedStatus::ok) return ClosedStatus::singular_inertia;
    gap = greatest_gap(closed);
    const double rounding = 1e-16 * (1 + extent(ws));
    if (gap <= 4 * rounding || (gap <= 1e3 * rounding && gap >= 0.5 * last)) return ClosedStatus::ok;
    if (step >= limit || !std::isfinite(gap)) return ClosedStatus::not_closed;
    last = gap;
    ClosedSolver solver(m, ws, closed);
    solver.residual_of_position();
    solver.no_forces();
    solver.solve({}, false, {}, ws.vdot);
    integrate(m, q, ws.vdot, 1.0, q);
  }
}

double greatest_gap(const ClosedLinks& closed) {
  double greatest = 0;
  const LoopRows& rows = closed.rows();
  for (std::size_t i = 0; i < closed.loops().size(); ++i)
    for (int k = rows.first[i]; closed.is_closed(static_cast<int>(i)) && k < rows.first[i + 1]; ++k)
      greatest = std::max(greatest, std::fabs(rows.gap[at(k)]));
  return greatest;
}

}  // namespace ugoki::dynamics
