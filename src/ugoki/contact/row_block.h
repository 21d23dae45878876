#pragma once
// Blocks of whitened constraint rows, the unknowns of the velocity solver (velocity_solver.h defines whitened rows).

#include <cstdint>

namespace ugoki::contact {

/// Kinds of row blocks; contact_law.h states the law of each.
enum class RowKind : unsigned char { contact, limit, friction, roll, grip };

/// One entry of up to three rows side by side; unused lanes are zero. Lanes do not affect each other, so any register width gives the same
/// bits.
typedef double RowLanes __attribute__((vector_size(32), aligned(8), may_alias));

/// The whitened rows of a block on one system: `length` entries of four lanes, one lane a row. They begin at index `offset` of
/// VelocitySolver::rows_.
struct RowSegment {
  int system;
  int first;         ///< index in the solver's w of the system's first DOF
  const int* index;  ///< [length] DOF of the system for each entry (the chain of a link); null: 0 ... length - 1
  int length;
  int offset;
};

/// Rows that are solved together: one contact, limit, friction or rolling resistance.
struct RowBlock {
  RowKind kind;
  int rows;               ///< 3 for contact, roll and grip, 1 for the others
  int row;                ///< index of the block's first row in the solver's targets and impulses
  int first_segment;      ///< index of the first segment
  int segments;           ///< number of segments, 1 or 2: one for each movable side of the block
  int contact;            ///< index into the step's contacts; -1: none
  int contact_block;      ///< roll: index of the block of the contact that is rolling
  double softness;        ///< contact: compliance as a fraction of the inverse inertia without it
  double compliance;      ///< contact: compliance as a fraction of B[0], which includes it
  double mu;              ///< Coulomb coefficient; roll: lever of rolling resistance [m]
  double bound;           ///< N s | N m s: maximum impulse (friction)
  double impact_impulse;  ///< N s: normal impulse that the impact has already given to the contact
  std::uint64_t key;      ///< identifies the block from step to step, for warm starts
  double B[6];            ///< inverse inertia Y Y^T, entries 00 11 22 01 02 12; entry 00 of a contact includes the compliance
  double inverse[6];      ///< inverse of B, same entries (blocks of 3 rows)
  double inverse_normal;  ///< 1 / B[0]
  double friction_step;   ///< contact: 1 / (maximum eigenvalue of B of the two tangents); roll: 1 / (maximum diagonal entry of B)
  double size;            ///< square root of the maximum diagonal entry of B
  double lever;           ///< roll: radius [m] that converts angular velocity to surface velocity; other kinds: 1
  double solved_motion;   ///< sum of VelocitySolver::motion_ over the block's systems when the block was last solved
  double change;          ///< m/s: change of the block's velocity in the last sweep
};

/// Completes a block whose B is that of the rows alone: adds the compliance of a contact, and sets size and the inverse values.
/// @param softness minimum of RowBlock::softness for contacts
void finish_block(RowBlock& b, double softness);

/// Entry e of the rows of a segment. @param y [length][4]
inline const RowLanes& row_lanes(const double* y, int e) { return *reinterpret_cast<const RowLanes*>(y + 4 * e); }
inline RowLanes& row_lanes(double* y, int e) { return *reinterpret_cast<RowLanes*>(y + 4 * e); }

}  // namespace ugoki::contact
