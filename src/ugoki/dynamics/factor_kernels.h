#pragma once
// The recursions of ArticulatedFactor. They are compiled for the baseline processor and, on x86, for AVX2; the width is chosen at run time
// (kernels.h). Each value is computed by the same operations in the same order for every width, so that the bits are equal. Internal to
// dynamics/.

#include <cstddef>

#include "ugoki/spatial/spatial.h"

namespace ugoki::dynamics {

/// A spatial vector, angular part first, or a row of an inertia: six elements and two zeros, for SIMD lanes.
struct alignas(32) Eight {
  double x[8] = {};
};

/// A DOF of the factor; symbols: articulated_factor.h.
struct FactorDof {
  Eight S, U;
  double pivot, inverse, root;  // D, 1 / D, D^-1/2
  int parent;                   // parent DOF; -1: base
  int depth;                    // number of ancestors
  int inertia;                  // index of the articulated-body inertia that the DOF uses
  bool leaf;                    // no DOF has this one as its parent
  bool last_child;              // no DOF behind this one has the same parent
};

/// The recursions over n DOFs, parents before children.
struct FactorKernels {
  /// Eliminates the DOFs from the tips to the base.
  /// @param S [n] columns of the motion subspace @param armature [n] @param extra [n] added to the diagonal, or null
  /// @param inertias [inertias][6] rows of the articulated-body inertias; in: those of the links
  /// @return index of the first DOF whose pivot is not positive, or -1
  int (*eliminate)(FactorDof* dofs, std::size_t n, const Vec6* S, const double* armature, const double* extra, Eight* inertias);
  /// x <- M'^-1 x. @param scratch [n] @param x [n, in and out]
  void (*solve)(const FactorDof* dofs, std::size_t n, Eight* scratch, double* x);
  /// See ArticulatedFactor::whiten_wrenches().
  void (*whiten_wrenches)(const FactorDof* dofs, int last, const Vec6* f, double* y);
  /// v += L^-1 D^-1/2 w. @param scratch [n] @param w [n] @param v [n, in and out]
  void (*add_whitened)(const FactorDof* dofs, std::size_t n, Eight* scratch, const double* w, double* v);
};

/// The kernels of the instruction set that kernels() uses; for AVX-512 those of AVX2.
const FactorKernels& factor_kernels();

}  // namespace ugoki::dynamics
