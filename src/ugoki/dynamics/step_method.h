#pragma once
// Inside the integrators: one step of a method in the chart of its start.

#include <memory>
#include <vector>

#include "ugoki/dynamics/integrators.h"

namespace ugoki::dynamics {

/// Why a stage or a step has no result.
struct StepFailure {
  IntegrationStatus status = IntegrationStatus::reached;
  int freedom = -1;
  [[nodiscard]] bool failed() const { return status != IntegrationStatus::reached; }
};

/// The differential equation z' = f(t, z) of z = (u, v) in the chart at q0, and the weights of its error norm.
class StepEquation {
 public:
  StepEquation(MotionSystem& system, const IntegratorOptions& options, IntegrationStatistics& statistics);

  /// Chart of a step that starts at (t, q0, v0); the spans must stay valid.
  void begin(double t, std::span<const double> q0, std::span<const double> v0);

  /// z' at time t. @param z, rate [2 nv]
  [[nodiscard]] StepFailure calc_rate(double t, const double* z, double* rate);
  /// Acceleration alone, at an ordinary state.
  [[nodiscard]] StepFailure calc_acceleration(double t, std::span<const double> q, std::span<const double> v, std::span<double> a);

  /// Root mean square of x over the tolerances. @param z1 [2 nv] the other end of the step @param x [2 nv]
  [[nodiscard]] double norm(const double* z1, const double* x) const;
  /// d a / d u and d a / d v at the step's start. @param a0 [nv]
  [[nodiscard]] StepFailure calc_jacobian(std::span<const double> a0, std::span<double> da_du, std::span<double> da_dv);

  /// q0 (+) u
  void place(const double* u, std::span<double> q) const;

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
  std::vector<double> q_;           // [nq] of a stage
  std::vector<double> size_;        // [nv] size of the coordinate that belongs to each freedom
  std::vector<double> z_, column_;  // [2 nv], [nv] for differences
};

/// Result of a step: its end and its continuous solution u, v (s) = (0, v0) + sum_p dense[p] s^(p+1), s in [0, 1].
struct StepResult {
  explicit StepResult(std::size_t n) : z1(2 * n), a1(n), dense(4 * 2 * n) {}
  std::vector<double> z1;     // [2 nv]
  std::vector<double> a1;     // [nv] acceleration at the end, if has_a1
  std::vector<double> dense;  // [4][2 nv]
  bool has_a1 = false;
  double error = 0;  // estimate over the tolerance; 0 where the method has none
  StepFailure failure;
};

class StepMethod {
 public:
  virtual ~StepMethod() = default;
  /// Order of the error estimate plus one, the exponent of step control; 0: a method of fixed step.
  [[nodiscard]] virtual int control_order() const { return 0; }
  /// @param afresh the state was set anew: nothing may be extrapolated from the step before
  virtual void take(StepEquation& f, std::span<const double> a0, double h, bool afresh, StepResult& out) = 0;
  /// The last step was accepted.
  virtual void accept() {}
};

[[nodiscard]] std::unique_ptr<StepMethod> make_semi_implicit_euler(std::size_t n);
[[nodiscard]] std::unique_ptr<StepMethod> make_runge_kutta_4(std::size_t n);
[[nodiscard]] std::unique_ptr<StepMethod> make_dormand_prince_54(std::size_t n);
[[nodiscard]] std::unique_ptr<StepMethod> make_gauss_legendre_6(std::size_t n);
[[nodiscard]] std::unique_ptr<StepMethod> make_radau_iia_5(std::size_t n);

}  // namespace ugoki::dynamics
