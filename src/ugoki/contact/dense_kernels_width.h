#pragma once
// The kernels of dense_kernels.h for one SIMD width. Each dense_kernels_*.cpp defines UGOKI_WIDTH (the namespace of the table), and
// includes this header once. The functions are local to the file, so that no code for a wide register is called on other processors.

#include "ugoki/contact/dense_kernels.h"

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

void make_matrix(const MatrixArguments& m) {
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
      const int col = m.local[j];
      for (int r = 0; r < a.rows; ++r) {
        *reinterpret_cast<RowLanes*>(rows + r * m.stride + col) = sum[r];  // later blocks, or the padding, overwrite the unused lanes
        for (int c = 0; c < b.rows; ++c) m.B[(col + c) * m.stride + m.local[i] + r] = sum[r][c];
      }
    }
  }
}

void eliminate(double* A, int n, int width, double* inverse) {
  constexpr double dependent = 1e-13;  // fraction of a diagonal entry that is rounding
  for (int i = 0; i < n; ++i) inverse[i] = A[i * width + i];
  for (int k = 0; k < n; ++k) {
    const double* const row = A + k * width;
    const double pivot = row[k] > dependent * inverse[k] ? 1 / row[k] : 0;
    inverse[k] = pivot;
    for (int i = k + 1; i < n; ++i) {
      const double factor = row[i] * pivot;
      if (factor == 0) continue;
      double* const other = A + i * width;
      for (int j = i; j < width; ++j) other[j] -= factor * row[j];
    }
  }
}

void add_product(const double* B, int stride, int n, const double* p, double* u) {
  for (int r = 0; r < n; ++r) {
    const double factor = p[r];
    if (factor == 0) continue;
    const double* const column = B + r * stride;
    for (int k = 0; k < n; ++k) u[k] += column[k] * factor;
  }
}

}  // namespace

namespace UGOKI_WIDTH {
extern const DenseKernels table;
const DenseKernels table = {make_matrix, eliminate, add_product};
}  // namespace UGOKI_WIDTH

}  // namespace ugoki::contact
