#pragma once
// Eigenvalues and eigenvectors of symmetric 3 x 3 matrices. Used by robot_formats and publish.

#include "ugoki/spatial/spatial.h"

namespace ugoki::robot_formats {

/// Eigendecomposition S = V diag(values) V^T. V is a rotation whose columns are the eigenvectors; the values are not sorted.
struct SymmetricEigen {
  Vec3 values;
  Mat3 V;
};
/// Computes the decomposition by Jacobi's method (Golub, Van Loan, Matrix Computations, 8.5), with at most 30 sweeps. Finite
/// input gives finite output.
[[nodiscard]] SymmetricEigen symmetric_eigen(const Sym3& s);

}  // namespace ugoki::robot_formats
