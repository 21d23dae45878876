#pragma once
// Eigenvalues and eigenvectors of symmetric 3 x 3 matrices; internal to robot_formats.

#include "ugoki/spatial/spatial.h"

namespace ugoki::robot_formats {

/// S = V diag(values) V^T, V a rotation whose columns are the eigenvectors.
struct SymmetricEigen {
  Vec3 values;
  Mat3 V;
};
/// Jacobi's method (Golub, Van Loan, Matrix Computations, 8.5). Finite in, finite out; at most 30 sweeps.
[[nodiscard]] SymmetricEigen symmetric_eigen(const Sym3& s);

}  // namespace ugoki::robot_formats
