// Semi-implicit Euler method, and explicit Runge-Kutta methods defined by a Butcher tableau.

#include "ugoki/dynamics/step_method.h"

namespace ugoki::dynamics {
namespace {

class SemiImplicitEuler final : public StepMethod {
 public:
  void compute_step(StepEquation& f, std::span<const double> a0, double h, bool /*restarted*/, StepResult& out) override {
    const std::size_t n = f.n();
    const std::span<const double> v0 = f.start_velocity();
    for (double& x : out.dense) x = 0;
    for (std::size_t i = 0; i < n; ++i) {
      const double dv = h * a0[i];
      out.z1[n + i] = v0[i] + dv;
      out.z1[i] = h * out.z1[n + i];
      out.dense[i] = out.z1[i];
      out.dense[n + i] = dv;
    }
    out.has_a1 = false;
    out.error = 0;
  }
};

/// Butcher tableau of a first-same-as-last method. Row `stages - 1` of `a` contains the weights of the result, so the last stage is the
/// state at the step's end. The rate of this stage is the first rate of the next step.
struct Tableau {
  int stages;
  const double* c;       // [stages] times of the stages, as fractions of the step
  const double (*a)[6];  // [stages] rows of the tableau
  const double* error;   // [stages] weights of the result minus the embedded result; null: no error estimate
  const double* dense;   // [stages] weights of the quartic term of the continuous solution; null: cubic
  int control_order;     // see StepMethod::control_order()
};

class ExplicitRungeKutta final : public StepMethod {
 public:
  ExplicitRungeKutta(const Tableau& tableau, std::size_t n)
      : tableau_(tableau), k_(static_cast<std::size_t>(tableau.stages) * 2 * n), error_(2 * n) {}

  int control_order() const override { return tableau_.control_order; }

  void compute_step(StepEquation& f, std::span<const double> a0, double h, bool /*restarted*/, StepResult& out) override {
    const std::size_t n = f.n(), n2 = 2 * n;
    const std::span<const double> v0 = f.start_velocity();
    for (std::size_t i = 0; i < n; ++i) {
      k_[i] = v0[i];
      k_[n + i] = a0[i];
    }
    for (int s = 1; s < tableau_.stages; ++s) {
      const double* a = tableau_.a[s];
      for (std::size_t i = 0; i < n2; ++i) {
        double sum = 0;
        for (int j = 0; j < s; ++j) sum += a[j] * k_[static_cast<std::size_t>(j) * n2 + i];
        out.z1[i] = h * sum + (i < n ? 0.0 : v0[i - n]);
      }
      out.failure = f.calc_rate(f.start_time() + tableau_.c[s] * h, out.z1.data(), k_.data() + static_cast<std::size_t>(s) * n2);
      if (out.failure.failed()) return;
    }
    const double* last = k_.data() + static_cast<std::size_t>(tableau_.stages - 1) * n2;
    for (std::size_t i = 0; i < n; ++i) out.a1[i] = last[n + i];
    out.has_a1 = true;
    interpolate(h, v0, last, out);
    out.error = 0;
    if (tableau_.error) {
      calc_weighted_sum(tableau_.error, h);
      out.error = f.norm(out.z1.data(), error_.data());
    }
  }

 private:
  /// error_ = h times the weighted sum of the stage rates.
  void calc_weighted_sum(const double* weights, double h) {
    const std::size_t n2 = error_.size();
    for (std::size_t i = 0; i < n2; ++i) {
      double sum = 0;
      for (int j = 0; j < tableau_.stages; ++j) sum += weights[j] * k_[static_cast<std::size_t>(j) * n2 + i];
      error_[i] = h * sum;
    }
  }

  /// Continuous solution: the cubic Hermite interpolant of the step's two ends, plus s^2 (1 - s)^2 times the tableau's quartic term. s is
  /// the fraction of the step, 0 to 1.
  void interpolate(double h, std::span<const double> v0, const double* last, StepResult& out) {
    const std::size_t n2 = error_.size(), n = n2 / 2;
    if (tableau_.dense)
      calc_weighted_sum(tableau_.dense, h);
    else
      for (double& x : error_) x = 0;
    for (std::size_t i = 0; i < n2; ++i) {
      const double change = out.z1[i] - (i < n ? 0.0 : v0[i - n]);
      const double at_start = h * k_[i] - change, at_end = change - h * last[i] - at_start, quartic = error_[i];
      out.dense[i] = change + at_start;
      out.dense[n2 + i] = -at_start + at_end + quartic;
      out.dense[2 * n2 + i] = -at_end - 2 * quartic;
      out.dense[3 * n2 + i] = quartic;
    }
  }

  const Tableau& tableau_;
  std::vector<double> k_;      // [stages][2 * nv] rates of the stages
  std::vector<double> error_;  // [2 * nv] result of calc_weighted_sum(): first the error estimate, then the quartic term
};

constexpr double rk4_c[] = {0, 0.5, 0.5, 1, 1};
constexpr double rk4_a[][6] = {{}, {0.5}, {0, 0.5}, {0, 0, 1}, {1.0 / 6, 1.0 / 3, 1.0 / 3, 1.0 / 6}};
constexpr Tableau runge_kutta_4{5, rk4_c, rk4_a, nullptr, nullptr, 0};

constexpr double dp_c[] = {0, 1.0 / 5, 3.0 / 10, 4.0 / 5, 8.0 / 9, 1, 1};
constexpr double dp_a[][6] = {{},
                              {1.0 / 5},
                              {3.0 / 40, 9.0 / 40},
                              {44.0 / 45, -56.0 / 15, 32.0 / 9},
                              {19372.0 / 6561, -25360.0 / 2187, 64448.0 / 6561, -212.0 / 729},
                              {9017.0 / 3168, -355.0 / 33, 46732.0 / 5247, 49.0 / 176, -5103.0 / 18656},
                              {35.0 / 384, 0, 500.0 / 1113, 125.0 / 192, -2187.0 / 6784, 11.0 / 84}};
constexpr double dp_error[] = {71.0 / 57600, 0, -71.0 / 16695, 71.0 / 1920, -17253.0 / 339200, 22.0 / 525, -1.0 / 40};
// Quartic term of the continuous solution by Shampine (Hairer, Norsett, Wanner I, II.6)
constexpr double dp_dense[] = {-12715105075.0 / 11282082432,  0,
                               87487479700.0 / 32700410799,   -10690763975.0 / 1880347072,
                               701980252875.0 / 199316789632, -1453857185.0 / 822651844,
                               69997945.0 / 29380423};
constexpr Tableau dormand_prince_54{7, dp_c, dp_a, dp_error, dp_dense, 5};

}  // namespace

std::unique_ptr<StepMethod> make_semi_implicit_euler(std::size_t /*n*/) { return std::make_unique<SemiImplicitEuler>(); }
std::unique_ptr<StepMethod> make_runge_kutta_4(std::size_t n) { return std::make_unique<ExplicitRungeKutta>(runge_kutta_4, n); }
std::unique_ptr<StepMethod> make_dormand_prince_54(std::size_t n) { return std::make_unique<ExplicitRungeKutta>(dormand_prince_54, n); }

}  // namespace ugoki::dynamics
