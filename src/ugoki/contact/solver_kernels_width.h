#pragma once
// The kernels of solver_kernels.h for one SIMD width. Each solver_kernels_*.cpp defines UGOKI_WIDTH (the namespace of the table), and
// includes this header once. The functions are local to the file, so that no code for a wide register is called on other processors.

#include "ugoki/contact/contact_law.h"
#include "ugoki/contact/solver_kernels.h"

namespace ugoki::contact {
namespace {

/// Number of entries that two segments of one system share: the DOFs of their chains from the root up to the first difference.
inline int shared_length(const RowSegment& x, const RowSegment& y) {
  int shared = x.length < y.length ? x.length : y.length;
  if (x.index != y.index)
    while (shared > 0 && (x.index ? x.index[shared - 1] : shared - 1) != (y.index ? y.index[shared - 1] : shared - 1)) --shared;
  return shared;
}

inline const RowLanes& lanes_at(const double* y) { return *reinterpret_cast<const RowLanes*>(y); }
inline RowLanes& lanes_at(double* y) { return *reinterpret_cast<RowLanes*>(y); }

void make_matrix(const MatrixArguments& m) {
  int n = 0;
  for (int i = 0; i < m.count; ++i) {
    const RowBlock& a = m.blocks[m.order[i]];
    double* const rows = m.B + m.local[i] * m.stride;
    for (int j = 0; j <= i; ++j) {
      const RowBlock& b = m.blocks[m.order[j]];
      RowLanes sum[3] = {};
      for (int sa = 0; sa < a.segments; ++sa) {
        const RowSegment& x = m.segments[a.first_segment + sa];
        for (int sb = 0; sb < b.segments; ++sb) {
          const RowSegment& y = m.segments[b.first_segment + sb];
          if (x.system != y.system) continue;
          const int shared = shared_length(x, y);
          const double *X = m.rows + x.offset, *Y = m.rows + y.offset;
          if (a.rows == 1) {
            for (int e = 0; e < shared; ++e) sum[0] += X[4 * e] * lanes_at(Y + 4 * e);
            continue;
          }
          for (int e = 0; e < shared; ++e) {
            const RowLanes lanes = lanes_at(Y + 4 * e);
            sum[0] += X[4 * e] * lanes;
            sum[1] += X[4 * e + 1] * lanes;
            sum[2] += X[4 * e + 2] * lanes;
          }
        }
      }
      // The unused lanes are overwritten by later blocks and by the upper half, or belong to the padding.
      for (int r = 0; r < a.rows; ++r) lanes_at(rows + r * m.stride + m.local[j]) = sum[r];
    }
    n = m.local[i] + a.rows;
  }
  for (int i = 1; i < n; ++i) {  // the upper half is that of a symmetric matrix
    const double* const row = m.B + i * m.stride;
    double* to = m.B + i;
    for (int j = 0; j < i; ++j, to += m.stride) *to = row[j];
  }
}

void eliminate(double* A, int n, int width, double* inverse) {
  constexpr double dependent = 1e-13;  // fraction of a diagonal entry that is rounding
  for (int i = 0; i < n; ++i) inverse[i] = A[i * width + i];
  const auto find_pivot = [&](int k) {
    const double entry = A[k * width + k];
    inverse[k] = entry > dependent * inverse[k] ? 1 / entry : 0;
  };
  // First entry of row i to change. Entries before the diagonal are not used: whole registers that end with the row may cover some.
  const auto begin_of = [&](int i) {
    const int begin = width - ((width - i + 3) & ~3);
    return begin < 0 ? i : begin;
  };
  // Subtracts factor * row k from row i.
  const auto subtract = [&](int k, int i, double factor) {
    if (factor == 0) return;
    const double* const row = A + k * width;
    double* const other = A + i * width;
    int j = begin_of(i);
    for (; j + 4 <= width; j += 4) lanes_at(other + j) -= factor * lanes_at(row + j);
    for (; j < width; ++j) other[j] -= factor * row[j];
  };
  // Two rows at once: each entry below them is read and written once for both.
  int k = 0;
  for (; k + 1 < n; k += 2) {
    const double *const first = A + k * width, *const second = first + width;
    find_pivot(k);
    subtract(k, k + 1, first[k + 1] * inverse[k]);
    find_pivot(k + 1);
    for (int i = k + 2; i < n; ++i) {
      const double a = first[i] * inverse[k], b = second[i] * inverse[k + 1];
      if (a == 0 || b == 0) {
        subtract(k, i, a);
        subtract(k + 1, i, b);
        continue;
      }
      double* const other = A + i * width;
      int j = begin_of(i);
      for (; j + 4 <= width; j += 4) lanes_at(other + j) = (lanes_at(other + j) - a * lanes_at(first + j)) - b * lanes_at(second + j);
      for (; j < width; ++j) other[j] = (other[j] - a * first[j]) - b * second[j];
    }
  }
  if (k < n) find_pivot(k);
}

void add_product(const double* B, int stride, int n, const double* p, double* u) {
  // Four columns at once, added in order: each entry of u is read and written once for all.
  const double* column[4];
  double factor[4];
  int held = 0;
  for (int r = 0; r < n; ++r) {
    if (p[r] == 0) continue;
    column[held] = B + r * stride;
    factor[held] = p[r];
    if (++held < 4) continue;
    held = 0;
    int k = 0;
    for (; k + 4 <= n; k += 4) {
      RowLanes& to = lanes_at(u + k);
      to = (((to + lanes_at(column[0] + k) * factor[0]) + lanes_at(column[1] + k) * factor[1]) + lanes_at(column[2] + k) * factor[2]) +
           lanes_at(column[3] + k) * factor[3];
    }
    for (; k < n; ++k)
      u[k] = (((u[k] + column[0][k] * factor[0]) + column[1][k] * factor[1]) + column[2][k] * factor[2]) + column[3][k] * factor[3];
  }
  for (int h = 0; h < held; ++h)
    for (int k = 0; k < n; ++k) u[k] += column[h][k] * factor[h];
}

void add_to_envelope(const SortedBlock& s, const double* G, const EnvelopeArguments& A) {
  const double *const Z0 = s.Z, *const Z1 = Z0 + s.length, *const Z2 = Z1 + s.length;
  for (int e = 0; e < s.length; ++e) {
    double* const to_row = A.values + A.start[s.row[e]] - A.first[s.row[e]];
    const double z0 = Z0[e], z1 = s.rows == 3 ? Z1[e] : 0, z2 = s.rows == 3 ? Z2[e] : 0;
    const double g0 = z0 * G[0] + z1 * G[3] + z2 * G[6], g1 = z0 * G[1] + z1 * G[4] + z2 * G[7], g2 = z0 * G[2] + z1 * G[5] + z2 * G[8];
    for (int f = 0; f <= e;) {
      const int end = s.run[f] < e + 1 ? s.run[f] : e + 1;
      double* const to = to_row + s.row[f] - f;
      if (s.rows == 3)
        for (; f < end; ++f) to[f] += g0 * Z0[f] + g1 * Z1[f] + g2 * Z2[f];
      else
        for (; f < end; ++f) to[f] += g0 * Z0[f];
    }
  }
}

void add_to_upper_envelope(const SortedBlock& s, const double* G, const EnvelopeArguments& A) {
  const double *const Z0 = s.Z, *const Z1 = Z0 + s.length, *const Z2 = Z1 + s.length;
  for (int e = 0; e < s.length; ++e) {
    double* const to_row = A.upper + A.start[s.row[e]] - A.first[s.row[e]];
    const double z0 = Z0[e], z1 = s.rows == 3 ? Z1[e] : 0, z2 = s.rows == 3 ? Z2[e] : 0;
    const double h0 = G[0] * z0 + G[1] * z1 + G[2] * z2, h1 = G[3] * z0 + G[4] * z1 + G[5] * z2, h2 = G[6] * z0 + G[7] * z1 + G[8] * z2;
    for (int f = 0; f < e;) {
      const int end = s.run[f] < e ? s.run[f] : e;
      double* const to = to_row + s.row[f] - f;
      if (s.rows == 3)
        for (; f < end; ++f) to[f] += h0 * Z0[f] + h1 * Z1[f] + h2 * Z2[f];
      else
        for (; f < end; ++f) to[f] += h0 * Z0[f];
    }
  }
}

/// Scalar product of n elements: eight sums, added in a fixed order.
inline double long_product(const double* a, const double* b, int n) {
  RowLanes even = {}, odd = {};
  int k = 0;
  for (; k + 8 <= n; k += 8) {
    even += lanes_at(a + k) * lanes_at(b + k);
    odd += lanes_at(a + k + 4) * lanes_at(b + k + 4);
  }
  if (k + 4 <= n) {
    even += lanes_at(a + k) * lanes_at(b + k);
    k += 4;
  }
  even += odd;
  double sum = (even[0] + even[1]) + (even[2] + even[3]);
  for (; k < n; ++k) sum += a[k] * b[k];
  return sum;
}

void solve_envelope(const EnvelopeArguments& A, const double* b, double* x) {
  for (int i = 0; i < A.n; ++i) {
    double* const row = A.values + A.start[i];
    const int low = A.first[i];
    for (int j = low; j <= i; ++j) {
      const double* const other = A.values + A.start[j];
      const int other_low = A.first[j], from = low < other_low ? other_low : low;
      const double rest = row[j - low] - long_product(row + (from - low), other + (from - other_low), j - from);
      row[j - low] = j < i ? rest * other[j - other_low] : 1 / __builtin_sqrt(rest);
    }
    x[i] = (b[i] - long_product(row, x + low, i - low)) * row[i - low];
  }
  for (int i = A.n; i-- > 0;) {
    const double* const row = A.values + A.start[i];
    const int low = A.first[i];
    const double value = x[i] *= row[i - low];
    double* const to = x + low;
    for (int k = 0; k < i - low; ++k) to[k] -= row[k] * value;
  }
}

void solve_unsymmetric_envelope(const EnvelopeArguments& A, const double* b, double* x) {
  for (int i = 0; i < A.n; ++i) {
    double* const L = A.values + A.start[i];
    double* const U = A.upper + A.start[i];
    const int low = A.first[i];
    for (int j = low; j < i; ++j) {
      const double *const L_j = A.values + A.start[j], *const U_j = A.upper + A.start[j];
      const int other_low = A.first[j], from = low < other_low ? other_low : low;
      U[j - low] -= long_product(U + (from - low), L_j + (from - other_low), j - from);
      L[j - low] = (L[j - low] - long_product(L + (from - low), U_j + (from - other_low), j - from)) * L_j[j - other_low];
    }
    L[i - low] = 1 / (L[i - low] - long_product(L, U, i - low));
    x[i] = b[i] - long_product(L, x + low, i - low);
  }
  for (int i = A.n; i-- > 0;) {
    const double* const U = A.upper + A.start[i];
    const int low = A.first[i];
    const double value = x[i] *= A.values[A.start[i] + static_cast<std::size_t>(i - low)];
    double* const to = x + low;
    for (int k = 0; k < i - low; ++k) to[k] -= U[k] * value;
  }
}

/// Adds the products of the segment's rows with w to `sum`, in two alternating sums that do not wait for each other.
inline void add_velocities(const RowSegment& x, const double* rows, const double* w, RowLanes& sum) {
  const double* const y = rows + x.offset;
  const double* const v = w + x.first;
  RowLanes even = {}, odd = {};
  int e = 0;
  if (x.index != nullptr) {
    for (; e + 1 < x.length; e += 2) {
      even += lanes_at(y + 4 * e) * v[x.index[e]];
      odd += lanes_at(y + 4 * e + 4) * v[x.index[e + 1]];
    }
    if (e < x.length) even += lanes_at(y + 4 * e) * v[x.index[e]];
  } else {
    for (; e + 1 < x.length; e += 2) {
      even += lanes_at(y + 4 * e) * v[e];
      odd += lanes_at(y + 4 * e + 4) * v[e + 1];
    }
    if (e < x.length) even += lanes_at(y + 4 * e) * v[e];
  }
  sum += even + odd;
}

/// w += Y^T p for the rows Y of one segment.
inline void add_impulse(const RowSegment& x, int block_rows, const double* rows, const double* p, double* w) {
  const double* y = rows + x.offset;
  double* const v = w + x.first;
  if (block_rows == 1) {
    for (int e = 0; e < x.length; ++e, y += 4) v[x.index != nullptr ? x.index[e] : e] += y[0] * p[0];
  } else if (x.index != nullptr) {
    for (int e = 0; e < x.length; ++e, y += 4) v[x.index[e]] += y[0] * p[0] + y[1] * p[1] + y[2] * p[2];
  } else {
    for (int e = 0; e < x.length; ++e, y += 4) v[e] += y[0] * p[0] + y[1] * p[1] + y[2] * p[2];
  }
}

double sweep(const SweepArguments& m, bool forward, double minimum) {
  double maximum = 0;
  for (int k = 0; k < m.count; ++k) {
    RowBlock& b = m.blocks[m.order[forward ? k : m.count - 1 - k]];
    const RowSegment* const segments = m.segments + b.first_segment;
    const int last = b.segments - 1;
    double moved = m.motion[segments[0].system];
    if (last == 1) moved += m.motion[segments[1].system];
    b.change = 0;
    if ((moved - b.solved_motion) * b.size * b.lever <= minimum) continue;
    b.solved_motion = moved;
    RowLanes lanes = {};
    for (int s = 0; s <= last; ++s) add_velocities(segments[s], m.rows, m.w, lanes);
    double* const p = m.p + b.row;
    double u[3], next[3], change[3] = {0, 0, 0}, normal = 0, square = 0;
    for (int r = 0; r < b.rows; ++r) u[r] = m.target[b.row + r] + lanes[r];
    if (b.kind == RowKind::roll) {
      const RowBlock& contact = m.blocks[b.contact_block];
      normal = m.p[contact.row] + contact.impact_impulse;
    }
    next_impulse(b, u, p, normal, next);
    for (int r = 0; r < b.rows; ++r) {
      change[r] = next[r] - p[r];
      p[r] = next[r];
      square += change[r] * change[r];
    }
    if (square == 0) continue;
    b.change = velocity_change(b, change) * b.lever;
    maximum = larger(maximum, b.change);
    const double motion = b.size * __builtin_sqrt(square);
    for (int s = 0; s <= last; ++s) {
      add_impulse(segments[s], b.rows, m.rows, change, m.w);
      m.motion[segments[s].system] += motion;
    }
  }
  return maximum;
}

}  // namespace

namespace UGOKI_WIDTH {
extern const SolverKernels table;
const SolverKernels table = {
    sweep, make_matrix, eliminate, add_to_envelope, add_to_upper_envelope, solve_envelope, solve_unsymmetric_envelope, add_product};
}  // namespace UGOKI_WIDTH

}  // namespace ugoki::contact
