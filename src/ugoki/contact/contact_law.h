#pragma once
// Laws of the row blocks: the impulse p of one block at a given velocity, all other impulses fixed.
//
// With u the velocity of the block including its own impulse, B = Y Y^T its inverse inertia and s the compliance of a contact,
//   contact (n, t1, t2):  u_n + s p_n >= 0,  p_n >= 0,  p_n (u_n + s p_n) = 0;  |p_t| <= mu (p_n + impact_impulse), opposed to u_t
//   limit:                u >= 0,  p >= 0,  p u = 0
//   friction:             |p| <= bound, opposed to u
//   roll (3 rows):        |p| <= mu (p_n + impact_impulse) of its contact, opposed to u; mu is the lever of rolling resistance [m]
// Sources: Moreau (1988), Unilateral contact and dry friction in finite DOF dynamics; Hwangbo, Lee, Hutter (2018), Per-contact
// iteration method for solving contact dynamics.

#include "ugoki/contact/row_block.h"

namespace ugoki::contact {

/// The impulse of a block that satisfies its law while all other impulses stay fixed (contacts: two rounds of a projected iteration).
/// @param u      [rows] m/s | rad/s: velocity with the present impulse
/// @param p      [rows] N s | N m s: present impulse
/// @param compliance s of a contact as a fraction of its B[0], which includes s
/// @param normal roll: p_n + impact_impulse of its contact [N s]; unused by the other kinds
/// @param next   [rows, out]
void next_impulse(const RowBlock& b, const double* u, const double* p, double compliance, double normal, double* next);

/// Projects (x, y) onto the disk of the given radius about the origin.
void clamp_to_disk(double& x, double& y, double radius);

}  // namespace ugoki::contact
