#pragma once
// Impulse of one block by the augmented Lagrangian of its law (contact_law.h):
//   p(u) = projection of p^ - u / R onto the set of impulses that the law allows
// p^ is an estimate of the impulse [N s | N m s], u the velocity [m/s | rad/s], and R a small fraction of the block's inverse inertia. p(u)
// is continuous, and -dp/du is symmetric and positive semidefinite. If p(u) = p^, p^ satisfies the law exactly.
// Contacts project onto the friction cone. The velocity of a sliding contact is shifted along the normal by mu |u_t| (de Saxce). With this
// shift the symmetric cone law equals Coulomb's law; without the shift, sliding contacts would separate.
// Sources: Alart, Curnier (1991), A mixed formulation for frictional contact problems prone to Newton-like methods; de Saxce, Feng (1998),
// The bipotential method.

#include "ugoki/contact/row_block.h"

namespace ugoki::contact {

struct AugmentedLaw {
  double regularization;  ///< R as a fraction of the block's inverse inertia
  const double* hat;      ///< [rows] N s | N m s: p^
  double shift;           ///< m/s: contact: shift of the normal velocity; other kinds: unused
  double normal;          ///< N s: p_n + impact_impulse of the contact of a roll block; other kinds: unused
};

/// Calculates the impulse p [rows] at the velocity u [rows], and G = -dp/du [9, row by row with three entries a row]. Entries of G outside
/// the block's rows are left unchanged.
void augmented_impulse(const RowBlock& b, const AugmentedLaw& law, const double* u, double* p, double* G);

/// Returns AugmentedLaw::shift of a contact with impulse p [3] and velocity u [3]: mu |u_t| if it slides, otherwise 0.
double sliding_shift(const RowBlock& b, const double* p, const double* u);

}  // namespace ugoki::contact
