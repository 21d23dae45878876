#pragma once
// Laws of the row blocks: the impulse p of one block at a given velocity, all other impulses fixed.
//
// u: velocity of the block, including the effect of p; s: compliance of a contact; mu: friction coefficient; n, t1, t2: normal, tangents.
//   contact (n, t1, t2):  u_n + s p_n >= 0,  p_n >= 0,  p_n (u_n + s p_n) = 0;  |p_t| <= mu (p_n + impact_impulse), opposed to u_t
//   limit:                u >= 0,  p >= 0,  p u = 0
//   friction:             |p| <= bound, opposed to u
//   grip (3 rows):        u = 0, any p
//   roll (3 rows):        |p| <= mu (p_n + impact_impulse) of its contact, opposed to u; mu is the lever of rolling resistance [m]
// Sources: Moreau (1988), Unilateral contact and dry friction in finite DOF dynamics; Hwangbo, Lee, Hutter (2018), Per-contact
// iteration method for solving contact dynamics.

#include "ugoki/contact/row_block.h"

namespace ugoki::contact {

/// Calculates the impulse of a block that satisfies its law while all other impulses stay fixed. The impulse of a sliding contact is
/// approximate (two rounds of a projected iteration).
/// @param u      [rows] m/s | rad/s: velocity with the present impulse
/// @param p      [rows] N s | N m s: present impulse
/// @param normal N s: p_n + impact_impulse of the contact of a roll block; unused by the other kinds
/// @param next   [rows, out] N s | N m s: the new impulse
void next_impulse(const RowBlock& b, const double* u, const double* p, double normal, double* next);

/// Returns the maximum change of the block's velocity [m/s | rad/s] that a change of its impulses causes: the largest entry of |B change|.
/// The rows of a contact within one mechanism may depend on each other; large changes of their impulses can then cancel out.
/// @param change [rows] N s | N m s
double velocity_change(const RowBlock& b, const double* change);

/// Projects (x, y) onto the disk of the given radius about the origin.
void clamp_to_disk(double& x, double& y, double radius);

}  // namespace ugoki::contact
