#pragma once
// Blocks of whitened constraint rows, the unknowns of the velocity solver (velocity_solver.h defines whitened rows).

#include <cstdint>

namespace ugoki::contact {

/// Kinds of row blocks; contact_law.h states the law of each.
enum class RowKind : unsigned char { contact, limit, friction, roll };

/// The whitened rows of a block on one system: `RowBlock::rows` vectors of `length` entries, beginning at rows_[offset].
struct RowSegment {
  int system;
  int first;         ///< first DOF of the system in w
  const int* index;  ///< [length] DOF of each entry (the chain of a link); null: 0 ... length - 1
  int length;
  int offset;
};

/// Rows that are solved together: one contact, limit, friction or rolling resistance.
struct RowBlock {
  RowKind kind;
  int rows;               ///< 3 for contact and roll, 1 for the others
  int row;                ///< first entry in target and impulse
  int first_segment;      ///< index of the first segment
  int segments;           ///< 1 or 2: systems that the block acts on
  int contact;            ///< index into the step's contacts; -1: none
  int contact_block;      ///< roll: index of the block of its contact
  double mu;              ///< Coulomb coefficient; roll: lever of rolling resistance [m]
  double bound;           ///< N s | N m s: maximum impulse (friction)
  double impact_impulse;  ///< N s: normal impulse that the impact has already given to the contact
  std::uint64_t key;      ///< identifies the block from step to step, for warm starts
  double B[6];            ///< Y Y^T, entries 00 11 22 01 02 12; contacts: 00 with the compliance
  double inverse[6];      ///< inverse of B, same entries (contact, roll)
  double size;            ///< square root of the maximum diagonal entry of B
  double lever;           ///< roll: radius [m] that converts angular velocity to surface velocity; other kinds: 1
  double solved_motion;   ///< sum of motion_ of its systems when the block was last solved
  double change;          ///< m/s: change of its velocity in the last sweep
};

}  // namespace ugoki::contact
