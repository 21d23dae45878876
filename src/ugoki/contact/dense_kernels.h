#pragma once
// The inner loops of DenseIsland. They are compiled for SSE2 and, on x86, for AVX2; the width is chosen at run time. Each value is computed
// by the same operations in the same order for every width, so that the bits are equal.

#include "ugoki/contact/row_block.h"

namespace ugoki::contact {

/// The blocks of an island, for DenseKernels::make_matrix. Indices as in IslandRows.
struct MatrixArguments {
  const RowBlock* blocks;
  const int* order;  ///< [count] index in `blocks` of each block of the island
  int count;
  const RowSegment* segments;
  const double* rows;  ///< whitened rows
  const int* local;    ///< [count] first row of each block in B
  double* B;           ///< [rows of the island][stride, out] stride is at least the number of rows + 3; the padding is undefined
  int stride;
};

struct DenseKernels {
  /// Calculates B = Y Y^T (Y: whitened rows).
  void (*make_matrix)(const MatrixArguments&);
  /// Eliminates the first n unknowns of n symmetric equations, whose right sides are further columns, without row exchanges.
  /// @param A [n][width] the upper half is used @param inverse [n, out] inverse pivots; 0 for rows that depend on the rows before
  void (*eliminate)(double* A, int n, int width, double* inverse);
  /// Adds B p to u. @param B [n][stride] symmetric @param p [n] @param u [n]
  void (*add_product)(const double* B, int stride, int n, const double* p, double* u);
};

/// The kernels of the widest instruction set that the processor supports, or of the selected one.
const DenseKernels& dense_kernels();

/// Selects the instruction set for all following calls, for tests. Call this function before other threads run.
/// @param wide true: AVX2 @return false if the processor or the build does not support it; the selection then does not change
bool use_dense_kernels(bool wide);

}  // namespace ugoki::contact
