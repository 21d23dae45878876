#pragma once
// The kernels of force_kernels.h for one SIMD width. Each force_kernels_*.cpp defines UGOKI_WIDTH (the namespace of the table), and
// includes this header once. The functions are local to the file, so that no code for a wide register is called on other processors.

#include "ugoki/control/force_kernels.h"

namespace ugoki::control {
namespace {

/// Four numbers in SIMD lanes. Lanes do not affect each other.
typedef double Four __attribute__((vector_size(32), aligned(8), may_alias));

inline const Four& lanes(const double* x, std::size_t i) { return *reinterpret_cast<const Four*>(x + 4 * i); }
inline Four& lanes(double* x, std::size_t i) { return *reinterpret_cast<Four*>(x + 4 * i); }
inline double sum(const Four& a) { return (a[0] + a[1]) + (a[2] + a[3]); }

double press(const double* columns, std::size_t count, const double* y, double* pressed) {
  Four squares = {};
  for (std::size_t i = 0; i < count; ++i) {
    const Four* const g = &lanes(columns, 6 * i);
    const Four b = ((g[0] * y[0] + g[1] * y[1]) + (g[2] * y[2] + g[3] * y[3])) + (g[4] * y[4] + g[5] * y[5]);
    lanes(pressed, i) = b;
    const Four positive = b > 0 ? b : Four{};
    squares += positive * positive;
  }
  return sum(squares);
}

/// Adds the products of row r of the scaled columns with rows 0 to r. @tparam r index of the row
template <std::size_t r>
void add_row(const double* columns, std::size_t count, const double* scaled, const double* pressed, NewtonEquation& equation) {
  Four row[r + 1] = {}, side = {};
  for (std::size_t i = 0; i < count; ++i) {
    const Four s = lanes(scaled, 6 * i + r);
    for (std::size_t c = 0; c <= r; ++c) row[c] += s * lanes(columns, 6 * i + c);
    side += s * lanes(pressed, i);
  }
  for (std::size_t c = 0; c <= r; ++c) equation.H[r][c] += sum(row[c]);
  equation.b[r] -= sum(side);
}

void add_columns(const double* columns, std::size_t count, const double* loaded, const double* pressed, double stiffness, double* scaled,
                 NewtonEquation& equation) {
  for (std::size_t i = 0; i < count; ++i) {
    const Four factor = lanes(loaded, i) * stiffness;
    for (std::size_t k = 0; k < 6; ++k) lanes(scaled, 6 * i + k) = lanes(columns, 6 * i + k) * factor;
  }
  add_row<0>(columns, count, scaled, pressed, equation);
  add_row<1>(columns, count, scaled, pressed, equation);
  add_row<2>(columns, count, scaled, pressed, equation);
  add_row<3>(columns, count, scaled, pressed, equation);
  add_row<4>(columns, count, scaled, pressed, equation);
  add_row<5>(columns, count, scaled, pressed, equation);
}

}  // namespace

namespace UGOKI_WIDTH {
extern const ForceKernels table;
const ForceKernels table = {press, add_columns};
}  // namespace UGOKI_WIDTH

}  // namespace ugoki::control
