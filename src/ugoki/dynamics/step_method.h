#pragma once
// Interface between Integrator and the methods that compute one step, in the chart at the step's start: q = q0 (+) u, where the
// displacement u is in the tangent space at q0 (see integrators.h). Internal to the integrators.

#include <memory>
#include <vector>

#include "ugoki/dynamics/integrators.h"

namespace ugoki::dynamics {

/// Reason why a stage or a step has no result.
struct StepFailure {
  IntegrationStatus status = IntegrationStatus::reached;  ///< reached: no failure
  int dof = -1;                                           ///< DOF at which the failure occurred; -1: unknown
  [[nodiscard]] bool failed() const { return status != IntegrationStatus::reached; }
};

/// The differential equation z' = f(t, z) of z = (u, v) in the chart at q0, and the weights of its error norm.
class StepEquation {
 public:
  StepEquation(MotionSystem& system, const IntegratorOptions& options, IntegrationStatistics& statistics);

  /// Sets the start (t, q0, v0) of a step and thereby its chart. The spans must stay valid during the step.
  void begin(double t, std::span<const double> q0, std::span<const double> v0);

  /// Rate z' at time t. @param z, rate [2 * nv] (u, v) and (u', v')
  [[nodiscard]] StepFailure calc_rate(double t, const double* z, double* rate);
  /// Acceleration at a state given as (q, v), instead of z. @param a [nv, out]
  [[nodiscard]] StepFailure calc_acceleration(double t, std::span<const double> q, std::span<const double> v, std::span<double> a);

  /// Weighted error norm: root mean square of the entries of x, each divided by its tolerance. @param x [2 * nv]
  /// @param z1 [2 * nv] end of the step; the tolerance of a velocity is relative to the larger of its magnitudes at start and end
  [[nodiscard]] double norm(const double* z1, const double* x) const;
  /// Derivatives d a / d u and d a / d v at the step's start, from the system or by finite differences.
  /// @param a0 [nv] acceleration at the start @param da_du, da_dv [nv * nv, out] row-major
  [[nodiscard]] StepFailure calc_jacobian(std::span<const double> a0, std::span<double> da_du, std::span<double> da_dv);

  /// q <- q0 (+) u. @param u [nv] @param q [nq, out]
  void calc_configuration(const double* u, std::span<double> q) const;

  [[nodiscard]] std::size_t n() const { return n_; }
  [[nodiscard]] double start_time() const { return t0_; }
  [[nodiscard]] std::span<const double> start_velocity() const { return v0_; }
  [[nodiscard]] IntegrationStatistics& statistics() { return statistics_; }
  [[nodiscard]] const IntegratorOptions& options() const { return options_; }

 private:
  MotionSystem& system_;
  const IntegratorOptions& options_;
  IntegrationStatistics& statistics_;
  std::size_t n_;
  double t0_ = 0;
  std::span<const double> q0_, v0_;
  std::vector<double> q_;           // [nq] configuration of a stage
  std::vector<double> size_;        // [nv] absolute value of each DOF's coordinate at the step's start; 1 rad for rotations by quaternion
  std::vector<double> z_, column_;  // [2 * nv] for finite differences
};

/// Result of a step: its end and its continuous solution (u, v)(s) = (0, v0) + sum_p dense[p] s^(p+1), s in [0, 1].
struct StepResult {
  explicit StepResult(std::size_t n) : z1(2 * n), a1(n), dense(4 * 2 * n) {}
  std::vector<double> z1;     // [2 * nv] (u, v) at the end
  std::vector<double> a1;     // [nv] acceleration at the end, if has_a1
  std::vector<double> dense;  // [4][2 * nv] coefficients of the continuous solution
  bool has_a1 = false;
  double error = 0;  // norm of the error estimate relative to the tolerance, accepted up to 1; 0 if the method has no estimate
  StepFailure failure;
};

/// An integration method: computes single steps; the Integrator accepts or rejects them.
class StepMethod {
 public:
  virtual ~StepMethod() = default;
  /// Order of the error estimate plus one; step size control uses it as exponent. 0: the method has a fixed step.
  [[nodiscard]] virtual int control_order() const { return 0; }
  /// Computes a step of size h from the start set in `f`. @param a0 [nv] acceleration at the start
  /// @param restarted the state does not continue the last accepted step, so that step must not be used for extrapolation
  virtual void compute_step(StepEquation& f, std::span<const double> a0, double h, bool restarted, StepResult& out) = 0;
  /// Called after the last computed step was accepted.
  virtual void accept() {}
};

[[nodiscard]] std::unique_ptr<StepMethod> make_semi_implicit_euler(std::size_t n);
[[nodiscard]] std::unique_ptr<StepMethod> make_runge_kutta_4(std::size_t n);
[[nodiscard]] std::unique_ptr<StepMethod> make_dormand_prince_54(std::size_t n);
[[nodiscard]] std::unique_ptr<StepMethod> make_gauss_legendre_6(std::size_t n);
[[nodiscard]] std::unique_ptr<StepMethod> make_radau_iia_5(std::size_t n);

}  // namespace ugoki::dynamics
