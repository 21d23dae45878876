#pragma once
// Dynamics of many instances of one mechanism, a register of them at a time: the throughput for learning, optimisation, crowds.
//
// The results are those of the functions of one instance (dynamics.h) to rounding, and the same bits whatever the width of the
// processor's registers. What one instance holds, NaN included, never touches another. Nothing here allocates but the constructor.

#include <span>
#include <vector>

#include "ugoki/dynamics/workspace.h"

namespace ugoki::dynamics {

/// States of B instances and scratch; caller-owned, one a thread. Real: double or float.
///
/// Instances stand in blocks of `lanes`; within a block, number i of all its instances is one cache line:
///   x[(block * count + i) * lanes + lane],  instance = block * lanes + lane.
/// The last block is filled up with instances in neutral position, which are computed and not used.
template <class Real>
class BatchWorkspace {
 public:
  static constexpr int lanes = 64 / static_cast<int>(sizeof(Real));  ///< 8 doubles, 16 floats

  BatchWorkspace(const Mechanism& m, int instances);

  [[nodiscard]] int instances() const { return instances_; }
  [[nodiscard]] int blocks() const { return blocks_; }

  /// Copies one instance's state in. @param q_in [nq] @param v_in [nv]
  void set_state(int instance, std::span<const double> q_in, std::span<const double> v_in);
  void get_state(int instance, std::span<double> q_out, std::span<double> v_out) const;
  /// One instance's numbers in or out of an array below. @param x [count]
  void set(std::vector<Real>& array, int instance, std::span<const double> x) const;
  void get(const std::vector<Real>& array, int instance, std::span<double> x) const;

  std::vector<Real> q;         ///< [blocks][nq][lanes]
  std::vector<Real> v;         ///< [blocks][nv][lanes]
  std::vector<Real> tau;       ///< [blocks][nv][lanes]
  std::vector<Real> vdot;      ///< [blocks][nv][lanes]
  std::vector<Real> external;  ///< empty, or after use_external() [blocks][links * 6][lanes]: wrenches as in dynamics.h
  std::vector<char> singular;  ///< [blocks * lanes] set by forward dynamics where an articulated inertia is singular
  void use_external();         ///< sizes `external`, zeros. Allocates

  struct Access;

 private:
  int instances_, blocks_, nq_, nv_;
  LinkProgram program_;
  std::vector<NodeConstants<Real>> constants_;
  std::vector<CacheLine> scratch_;
};

/// tau from q, v, vdot, external.
template <class Real>
void calc_inverse_dynamics(BatchWorkspace<Real>& batch, const Vec3& gravity);

/// vdot from q, v, tau, external. @return how many instances are singular (flagged in `singular`; their vdot is not to be used)
template <class Real>
int calc_forward_dynamics(BatchWorkspace<Real>& batch, const Vec3& gravity);

/// Semi-implicit Euler step: v += dt vdot, then q along the new v. Singular instances stay as they are, and are counted.
template <class Real>
int step_semi_implicit(BatchWorkspace<Real>& batch, const Vec3& gravity, double dt);

}  // namespace ugoki::dynamics
