#pragma once
// The inner loops of the velocity solver. They are compiled for SSE2 and, on x86, for AVX2; the width is chosen at run time. Each value is
// computed by the same operations in the same order for every width, so that the bits are equal.

#include <cstddef>

#include "ugoki/contact/row_block.h"

namespace ugoki::contact {

/// The blocks of an island, for SolverKernels::make_matrix. Indices as in IslandRows.
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

/// The blocks of an island for SolverKernels::sweep, in the memory of the velocity solver (velocity_solver.h). Kernels change the impulses
/// p, the whitened velocities w, the sums `motion`, and RowBlock::solved_motion and RowBlock::change.
struct SweepArguments {
  RowBlock* blocks;
  const int* order;  ///< [count] index in `blocks` of each block of the island
  int count;
  const RowSegment* segments;
  const double* rows;    ///< whitened rows
  const double* target;  ///< m/s | rad/s: velocities without impulses minus wanted ones
  double* p;             ///< N s | N m s
  double* w;             ///< whitened velocities of all systems
  double* motion;        ///< [systems] upper bound of the sum of |change of w| over the sweeps so far
};

/// An envelope matrix (envelope_matrix.h): entry (row, column) is values[start[row] + column - first[row]].
struct EnvelopeArguments {
  int n;
  const int* first;          ///< [n] first column of each row
  const std::size_t* start;  ///< [n] index of the first entry of each row
  double* values;
  double* upper;  ///< like `values`: transposed upper triangle of an unsymmetric matrix, without its diagonal
};

/// The rows Z of a block, sorted by the row of the Newton matrix to which each entry belongs.
struct SortedBlock {
  int rows, length;
  const double* Z;  ///< [rows][length]
  const int* row;   ///< [length] matrix row of each entry, ascending
  const int* run;   ///< [length] end of the run of consecutive matrix rows that contains the entry
};

struct SolverKernels {
  /// Solves each block of the island by itself, if its velocity may have changed by more than `minimum` [m/s] since it was last solved.
  /// @return m/s: maximum change of a velocity
  double (*sweep)(const SweepArguments&, bool forward, double minimum);
  /// Calculates B = Y Y^T (Y: whitened rows).
  void (*make_matrix)(const MatrixArguments&);
  /// Eliminates the first n unknowns of n symmetric equations, whose right sides are further columns, without row exchanges.
  /// @param A [n][width] the upper half is used @param inverse [n, out] inverse pivots; 0 for rows that depend on the rows before
  void (*eliminate)(double* A, int n, int width, double* inverse);
  /// Adds Z^T G Z to the lower triangle of an envelope matrix. @param G [3][3]
  void (*add_to_envelope)(const SortedBlock&, const double* G, const EnvelopeArguments&);
  /// Adds Z^T G Z to the upper triangle of an unsymmetric envelope matrix, without its diagonal.
  void (*add_to_upper_envelope)(const SortedBlock&, const double* G, const EnvelopeArguments&);
  /// Solves A x = b and replaces A by its Cholesky factor with inverted diagonal. @param b [n] @param x [n, out]
  void (*solve_envelope)(const EnvelopeArguments& A, const double* b, double* x);
  /// Solves A x = b for an unsymmetric matrix and replaces A by its factors L U. @param b [n] @param x [n, out]
  void (*solve_unsymmetric_envelope)(const EnvelopeArguments& A, const double* b, double* x);
  /// Adds B p to u. @param B [n][stride] symmetric @param p [n] @param u [n]
  void (*add_product)(const double* B, int stride, int n, const double* p, double* u);
};

/// The kernels of the widest instruction set that the processor supports, or of the selected one.
const SolverKernels& solver_kernels();

/// Selects the instruction set for all following calls, for tests. Call this function before other threads run.
/// @param wide true: AVX2 @return false if the processor or the build does not support it; the selection then does not change
bool use_solver_kernels(bool wide);

}  // namespace ugoki::contact
