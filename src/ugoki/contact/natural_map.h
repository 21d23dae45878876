#pragma once
// The natural map of the contact laws, whose root the semi-smooth Newton methods find (equations: dense_island.h).

#include "ugoki/contact/row_block.h"

namespace ugoki::contact {

/// Sums of the natural map over the blocks of an island.
struct NaturalMap {
  /// Regularization of rows that may depend on each other (friction of redundant contacts), as a fraction of their inverse inertia. It is
  /// in Newton's matrix only, not in the law. With 1e-7 or 1e-2 a falling humanoid needs 1.5 times as many Newton steps.
  static constexpr double regularization = 1e-4;
  /// Regularization of limit rows, as a fraction of their inverse inertia. They depend on other rows only when a chain is jammed.
  static constexpr double limit_regularization = 1e-7;

  double augmentation = 1;  ///< a of the natural map
  double square = 0;        ///< m^2/s^2: squared norm of the map
  double maximum = 0;       ///< m/s: maximum entry of the map; an impulse at its bound counts as the velocity that it corresponds to

  /// Adds the entries of one block.
  /// @param normal N s: p_n + impact_impulse of the contact of a roll block; unused by the other kinds
  /// @param p, u   [rows] impulse and velocity of the block
  void add(const RowBlock& b, double normal, const double* p, const double* u);
};

/// The impulse of a block as a linear function of its velocity, p = c - G u: the law with the class of the block fixed (dense_island.h).
struct LinearLaw {
  double c[3];     ///< N s | N m s
  double G[9];     ///< [3][3] kg | kg m^2, row by row
  bool symmetric;  ///< false: friction of a sliding contact depends on its normal velocity
};

/// Calculates the linear law of a block for the class that it has at p and u. Parameters as in NaturalMap::add().
void find_linear_law(const RowBlock& b, double augmentation, double normal, const double* p, const double* u, LinearLaw& law);

/// Projects p - u / metric of a roll block onto the ball of its law.
/// @param x [3, out] @return the size before the projection as a fraction of the ball's radius; infinite for a radius of zero
double roll_projection(const RowBlock& b, const double* p, const double* u, double metric, double normal, double* x);

}  // namespace ugoki::contact
