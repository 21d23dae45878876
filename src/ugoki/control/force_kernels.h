#pragma once
// Inner loops of ContactForceProblem. They are compiled for the baseline processor and, on x86, for AVX2; the width is that of
// dynamics/kernels.h. Each value is computed by the same operations in the same order for every width, so that the bits are equal. Internal
// to control/.

#include <cstddef>

namespace ugoki::control {

/// Newton's equation H x = b of the dual problem: H = 1 + sum g g^T / eps over the columns g that bear load, lower triangle.
struct NewtonEquation {
  double H[6][6];
  double b[6];
};

/// The columns of `count` supports: [supports][6][4], the four edges of a support in SIMD lanes.
struct ForceKernels {
  /// Computes pressed = G^T y. @param y [6] @param pressed [supports][4, out] @return |max(0, pressed)|^2
  double (*press)(const double* columns, std::size_t count, const double* y, double* pressed);
  /// Adds g g^T / eps of the columns that bear load to equation.H, and subtracts g pressed / eps from equation.b.
  /// @param loaded [supports][4] 1: the edge bears load, else 0 @param stiffness 1 / eps @param scaled [supports][6][4] scratch
  void (*add_columns)(const double* columns, std::size_t count, const double* loaded, const double* pressed, double stiffness,
                      double* scaled, NewtonEquation& equation);
};

const ForceKernels& force_kernels();

}  // namespace ugoki::control
