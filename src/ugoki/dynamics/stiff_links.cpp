#include "ugoki/dynamics/stiff_links.h"

#include <algorithm>
#include <utility>

#include "ugoki/dynamics/closed_solver.h"

namespace ugoki::dynamics {
namespace {

/// Solves C^T X = X in place, with the lower triangular matrix C [rank][stride]. @param x [rank][columns]
void solve_transposed(const double* C, int stride, int rank, double* x, int columns) {
  for (int k = rank; k-- > 0;)
    for (int j = 0; j < columns; ++j) {
      double y = x[k * columns + j];
      for (int i = k + 1; i < rank; ++i) y -= C[i * stride + k] * x[i * columns + j];
      x[k * columns + j] = y / C[k * stride + k];
    }
}

void solve_transposed(const double* C, int stride, int rank, Vec6* x) {
  for (int k = rank; k-- > 0;) {
    for (int i = k + 1; i < rank; ++i) x[k] -= x[i] * C[i * stride + k];
    x[k] = x[k] * (1.0 / C[k * stride + k]);
  }
}

}  // namespace

/// Selected inversion, from the base to the tips (equations: stiff_links.h).
void ClosedSolver::find_responses(LinkResponses& out) const {
  std::ranges::fill(out.lambda, 0.0);
  const auto block_of = [&](int index) { return out.lambda.data() + 36 * index; };
  const auto recover = [&](int node, const ArticulatedInertia& A) {
    const Node& n = x_.nodes[at(node)];
    for (int x = n.eliminations + n.elimination_count; x-- > n.eliminations;) {
      const Elimination& elimination = x_.eliminations[at(x)];
      const Entry& e = x_.entries[at(elimination.entry)];
      const int r = e.rows, rank = c_.rank_of_[at(elimination.entry)], first = elimination.neighbours, count = elimination.neighbour_count;
      const double* C = c_.C_.data() + 36 * elimination.entry;
      const int* order = c_.pivots_.data() + e.first;
      Vec6* const own = out.cross.data() + x_.present[at(elimination.present)].row;
      std::fill_n(own, r, Vec6{});
      double* const diagonal = block_of(e.diagonal);
      std::fill_n(diagonal, r * r, 0.0);
      // lambda_e = K A + sum of K_o lambda_o + e
      Vec6 K[6];
      for (int k = 0; k < rank; ++k) K[k] = c_.Z_[at(e.first + k)];
      solve_transposed(C, r, rank, K);
      for (int k = 0; k < rank; ++k) own[order[k]] = product(A, K[k]);
      for (int o = 0; o < count; ++o) {
        const ClosedStructure::Neighbour& other = x_.neighbours[at(first + o)];
        const int columns = neighbour(first + o).rows;
        double* const K_o = out.Y.data() + 36 * o;
        const double* const from = Y(first + o);
        for (int k = 0; k < rank * columns; ++k) K_o[k] = -from[k];
        solve_transposed(C, r, rank, K_o, columns);
        const Vec6* const cross = out.cross.data() + x_.present[at(other.present)].row;
        double* const to = block_of(other.block);
        std::fill_n(to, r * columns, 0.0);
        for (int k = 0; k < rank; ++k)
          for (int j = 0; j < columns; ++j) {
            own[order[k]] += cross[j] * K_o[k * columns + j];
            to[other.transposed ? j * r + order[k] : order[k] * columns + j] = dot(K[k], cross[j]);
          }
      }
      const auto add = [&](int to, int by, const double* between, bool transposed) {  // Cov(e, to) += K_by Cov(by, to)
        const ClosedStructure::Neighbour& other = x_.neighbours[at(first + to)];
        const int columns = neighbour(first + to).rows, middle = neighbour(first + by).rows;
        double* const sum = block_of(other.block);
        const double* const K_o = out.Y.data() + 36 * by;
        for (int k = 0; k < rank; ++k)
          for (int j = 0; j < columns; ++j) {
            double value = 0;
            for (int i = 0; i < middle; ++i) value += K_o[k * middle + i] * between[transposed ? j * middle + i : i * columns + j];
            sum[other.transposed ? j * r + order[k] : order[k] * columns + j] += value;
          }
      };
      for (int k = elimination.updates; k < elimination.updates + elimination.update_count; ++k) {
        const ClosedStructure::Update& u = x_.updates[at(k)];
        add(u.b - first, u.a - first, block_of(u.block), false);
        if (u.a != u.b) add(u.a - first, u.b - first, block_of(u.block), true);
      }
      double T[36] = {};  // C^-T
      for (int k = 0; k < rank; ++k) T[k * rank + k] = 1;
      solve_transposed(C, r, rank, T, rank);
      for (int k = 0; k < rank; ++k)
        for (int l = 0; l < rank; ++l) {
          double value = dot(K[k], own[order[l]]);
          for (int i = 0; i < rank; ++i) value -= T[k * rank + i] * T[l * rank + i];
          for (int o = 0; o < count; ++o) {
            const ClosedStructure::Neighbour& other = x_.neighbours[at(first + o)];
            const int columns = neighbour(first + o).rows;
            const double* const to = block_of(other.block);
            for (int j = 0; j < columns; ++j)
              value += out.Y[at(36 * o + k * columns + j)] * to[other.transposed ? j * r + order[l] : order[l] * columns + j];
          }
          diagonal[order[k] * r + order[l]] = value;
        }
    }
  };
  recover(world_, {});
  for (int node = 0; node < world_; ++node) {
    const LinkPlace& link = links_[at(node)];
    const Node& n = x_.nodes[at(node)];
    ArticulatedInertia A = link.parent >= 0 ? out.link[at(link.parent)] : ArticulatedInertia{};
    Vec6* const cross = out.cross.data() + n.row;
    for (int i = 0; i < n.passing_count; ++i) {
      const ClosedStructure::Present& p = x_.present[at(n.present + i)];
      const bool at_world = link.parent < 0;
      for (int k = 0; k < x_.entries[at(p.entry)].rows; ++k)
        cross[p.row - n.row + k] = at_world ? Vec6{} : out.cross[at(x_.present[at(p.parent)].row + k)];
    }
    for (int f = link.v_index; f < link.v_index + link.nv; ++f) {
      const Vec6 &S = ws_.S[at(f)], &U = ws_.U[at(f)];
      const double d = ws_.d[at(f)];
      const double* s = s_of(n, link, f);
      // g: covariance with U . A + s . lambda
      Vec6 g = product(A, U);
      for (int k = 0; k < n.passing_rows; ++k) g += cross[k] * s[k];
      double h = dot(U, g);
      double* const g_lambda = out.Y.data();
      for (int k = 0; k < n.passing_rows; ++k) g_lambda[k] = dot(cross[k], U);
      for (int k = n.pairs; k < n.pairs + n.pair_count; ++k) {
        const ClosedStructure::Pair& pair = x_.pairs[at(k)];
        const int a = first_row(n, pair.a), b = first_row(n, pair.b), rows_a = rows_at(n, pair.a), rows_b = rows_at(n, pair.b);
        const double* from = block_of(pair.block);
        for (int i = 0; i < rows_a; ++i)
          for (int j = 0; j < rows_b; ++j, ++from) {
            g_lambda[a + i] += *from * s[b + j];
            if (a != b) g_lambda[b + j] += *from * s[a + i];
          }
      }
      for (int k = 0; k < n.passing_rows; ++k) h += s[k] * g_lambda[k];
      const double variance = d * d * h + d;
      out.dof[at(f)] = variance;
      for (int k = 0; k < n.passing_rows; ++k) cross[k] -= S * (d * g_lambda[k]);
      // A' = A - d (S g^T + g S^T) + variance S S^T
      const Vec6 half = S * (0.5 * variance) - g * d;
      add_product(A, S, half);
      add_product(A, half, S);
    }
    out.link[at(node)] = A;
    recover(node, A);
  }
}

void ClosedSolver::make_room(const Mechanism& m, const ClosedLinks& c, LinkResponses& out) {
  const ClosedStructure& x = c.over_links_;
  out.link.resize(m.links().size());
  out.dof.resize(at(m.nv()));
  out.cross.resize(at(x.present_rows));
  out.lambda.resize(36 * at(x.blocks));
  int rows = 0;
  for (const Node& n : x.nodes) rows = std::max(rows, n.passing_rows);
  for (const Elimination& e : x.eliminations) rows = std::max(rows, 36 * e.neighbour_count);
  out.Y.resize(at(rows));
}

StiffLinks::StiffLinks(const Mechanism& m) : links_(m), rows_(links_.independent().size()) {
  ClosedSolver::make_room(m, links_, responses_);
}

StiffLinks::StiffLinks(const Mechanism& m, std::vector<Loop> loops, std::span<const char> closed)
    : links_(m, std::move(loops), closed), rows_(links_.independent().size()) {
  ClosedSolver::make_room(m, links_, responses_);
}

void StiffLinks::update_rows(const Mechanism& m, const Workspace& ws, std::span<const double> q, std::span<const double> v) {
  ClosedSolver::update_rows(m, ws, links_, q, v);
}

int StiffLinks::factor(const Mechanism& m, Workspace& ws, double dependent, std::span<const double> extra,
                       std::span<const ArticulatedInertia> stiffness) {
  ClosedSolver solver(m, ws, links_);
  if (stiffness.empty()) {
    if (!solver.factor_stiff(dependent, extra, {}, {})) return links_.singular_dof();
    std::ranges::copy(links_.independent(), rows_.begin());
    return -1;
  }
  return solver.factor_stiff(dependent, extra, stiffness, rows_) ? -1 : links_.singular_dof();
}

void StiffLinks::solve(const Mechanism& m, Workspace& ws, std::span<const double> r, std::span<const Vec6> wrenches,
                       std::span<const double> v, std::span<const double> closing, std::span<double> x) {
  ClosedSolver solver(m, ws, links_);
  solver.sweep_velocity(v);
  solver.residual_of_velocity(v);
  if (!closing.empty()) solver.add_residual(closing);
  if (wrenches.empty())
    std::ranges::fill(ws.pA, Vec6{});
  else
    std::ranges::copy(wrenches, ws.pA.begin());
  solver.solve(r, false, {}, x);
}

const LinkResponses& StiffLinks::calc_responses(const Mechanism& m, Workspace& ws) {
  ClosedSolver(m, ws, links_).find_responses(responses_);
  return responses_;
}

}  // namespace ugoki::dynamics
