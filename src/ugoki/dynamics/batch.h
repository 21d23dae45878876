#pragma once
// Dynamics of many instances of one mechanism at once, one SIMD register of instances at a time. For learning, optimisation and crowds.
//
// Results agree with the one-instance functions (dynamics.h) to rounding, and are bit-identical for every SIMD width. Instances are
// independent: a NaN in one instance does not affect another. Only the constructor and use_external() allocate.

#include <span>
#include <vector>

#include "ugoki/dynamics/workspace.h"

namespace ugoki::dynamics {

/// States of many instances, and scratch memory. Owned by the caller; use one per thread. Real: double or float.
///
/// Instances are stored in blocks of `lanes`. In an array x below, element i of all instances of a block fills one cache line:
///   x[(block * count + i) * lanes + lane],  instance = block * lanes + lane,  count = elements per instance (nq, nv or links * 6).
/// The last block is padded with instances in neutral position; their results are computed but not used.
template <class Real>
class BatchWorkspace {
 public:
  static constexpr int lanes = 64 / static_cast<int>(sizeof(Real));  ///< 8 doubles, 16 floats

  BatchWorkspace(const Mechanism& m, int instances);

  [[nodiscard]] int instances() const { return instances_; }
  [[nodiscard]] int blocks() const { return blocks_; }

  /// Sets the state of one instance. @param q_in [nq] @param v_in [nv]
  void set_state(int instance, std::span<const double> q_in, std::span<const double> v_in);
  void get_state(int instance, std::span<double> q_out, std::span<double> v_out) const;
  /// set() copies x to the elements of one instance in an array below; get() copies them to x. @param x [nq], [nv] or [links * 6]
  void set(std::vector<Real>& array, int instance, std::span<const double> x) const;
  void get(const std::vector<Real>& array, int instance, std::span<double> x) const;

  std::vector<Real> q;         ///< [blocks][nq][lanes] coordinates
  std::vector<Real> v;         ///< [blocks][nv][lanes] velocities
  std::vector<Real> tau;       ///< [blocks][nv][lanes] joint forces
  std::vector<Real> vdot;      ///< [blocks][nv][lanes] accelerations
  std::vector<Real> external;  ///< [blocks][links * 6][lanes] external wrenches as in dynamics.h; empty before use_external()
  std::vector<char> singular;  ///< [blocks * lanes] 1 if forward dynamics found a singular articulated inertia in the instance
  void use_external();         ///< resizes `external` and fills it with zeros; allocates

  struct Access;

 private:
  int instances_, blocks_, nq_, nv_;
  LinkProgram program_;
  std::vector<NodeConstants<Real>> constants_;
  std::vector<CacheLine> scratch_;
};

/// Inverse dynamics of all instances: sets batch.tau from batch.q, v, vdot and external. @param gravity m/s^2, world axes
template <class Real>
void calc_inverse_dynamics(BatchWorkspace<Real>& batch, const Vec3& gravity);

/// Forward dynamics of all instances: sets batch.vdot from batch.q, v, tau and external.
/// @return number of singular instances; they are flagged in `singular`, and their vdot is not valid
template <class Real>
int calc_forward_dynamics(BatchWorkspace<Real>& batch, const Vec3& gravity);

/// Semi-implicit Euler step of all instances: v += dt vdot, then q is integrated with the new v. @param dt s
/// @return number of singular instances; their q and v do not change
template <class Real>
int step_semi_implicit(BatchWorkspace<Real>& batch, const Vec3& gravity, double dt);

}  // namespace ugoki::dynamics
