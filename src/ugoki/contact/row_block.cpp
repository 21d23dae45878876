#include "ugoki/contact/row_block.h"

#include <algorithm>
#include <cmath>

namespace ugoki::contact {
namespace {

/// Inverse of a symmetric 3 x 3 matrix with entries 00 11 22 01 02 12, regularised by 1e-12 of its trace.
void invert(const double* S, double* out) {
  const double small = 1e-12 * (S[0] + S[1] + S[2]);  // the rows of a contact on a system with one DOF are dependent
  const double a = S[0] + small, b = S[1] + small, c = S[2] + small, d = S[3], e = S[4], f = S[5];
  const double A = b * c - f * f, D = e * f - d * c, E = d * f - e * b;
  const double scale = 1 / (a * A + d * D + e * E);
  out[0] = A * scale;
  out[1] = (a * c - e * e) * scale;
  out[2] = (a * b - d * d) * scale;
  out[3] = D * scale;
  out[4] = E * scale;
  out[5] = (d * e - a * f) * scale;
}

}  // namespace

void finish_block(RowBlock& b, double softness) {
  if (b.kind == RowKind::contact) {
    const double soft = std::max(b.softness, softness);
    b.B[0] *= 1 + soft;
    b.compliance = soft / (1 + soft);
  }
  b.size = std::sqrt(b.rows == 3 ? std::max({b.B[0], b.B[1], b.B[2]}) : b.B[0]);
  b.inverse_normal = 1 / b.B[0];
  if (b.rows == 1) return;
  invert(b.B, b.inverse);
  const double mean = 0.5 * (b.B[1] + b.B[2]), half = 0.5 * (b.B[1] - b.B[2]);
  b.friction_step = 1 / (b.kind == RowKind::contact ? mean + std::sqrt(half * half + b.B[5] * b.B[5]) : b.size * b.size);
}

}  // namespace ugoki::contact
