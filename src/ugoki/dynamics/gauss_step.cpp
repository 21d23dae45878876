// Gauss-Legendre collocation with three stages, order 6. The method is symmetric, so the energy of conservative motion does not drift.
// The stages are solved to rounding by fixed-point iteration (Hairer, McLachlan, Razakarivony 2008).

#include <algorithm>
#include <cmath>

#include "ugoki/dynamics/step_method.h"

namespace ugoki::dynamics {
namespace {

constexpr double root15 = 3.872983346207417;
constexpr double c[3] = {0.5 - root15 / 10, 0.5, 0.5 + root15 / 10};
constexpr double a[3][3] = {{5.0 / 36, 2.0 / 9 - root15 / 15, 5.0 / 36 - root15 / 30},
                            {5.0 / 36 + root15 / 24, 2.0 / 9, 5.0 / 36 - root15 / 24},
                            {5.0 / 36 + root15 / 30, 2.0 / 9 + root15 / 15, 5.0 / 36}};
constexpr double b[3] = {5.0 / 18, 4.0 / 9, 5.0 / 18};
/// Row i: coefficients (constant, linear, quadratic) of the Lagrange basis polynomial that is 1 at c[i] and 0 at the other two c.
constexpr double basis[3][3] = {
    {c[1] * c[2] / ((c[0] - c[1]) * (c[0] - c[2])), -(c[1] + c[2]) / ((c[0] - c[1]) * (c[0] - c[2])), 1 / ((c[0] - c[1]) * (c[0] - c[2]))},
    {c[0] * c[2] / ((c[1] - c[0]) * (c[1] - c[2])), -(c[0] + c[2]) / ((c[1] - c[0]) * (c[1] - c[2])), 1 / ((c[1] - c[0]) * (c[1] - c[2]))},
    {c[0] * c[1] / ((c[2] - c[0]) * (c[2] - c[1])), -(c[0] + c[1]) / ((c[2] - c[0]) * (c[2] - c[1])), 1 / ((c[2] - c[0]) * (c[2] - c[1]))}};
constexpr int max_iterations = 60;
constexpr double noise = 1e-7;  // a stalled iteration is accepted if its last change is below this fraction of h times the rates

class GaussLegendre final : public StepMethod {
 public:
  explicit GaussLegendre(std::size_t n) : z_(2 * n), rates_(3 * 2 * n), next_(3 * 2 * n) {}

  void compute_step(StepEquation& f, std::span<const double> a0, double h, bool restarted, StepResult& out) override {
    predict(f, a0, restarted ? 0 : h / last_h_);
    out.failure = iterate(f, h);
    if (out.failure.failed() && !restarted) {  // extrapolation from the previous step may be a bad guess: retry with constant rates
      predict(f, a0, 0);
      out.failure = iterate(f, h);
    }
    if (out.failure.failed()) return;
    last_h_ = h;
    const std::size_t n2 = z_.size(), n = n2 / 2;
    const std::span<const double> v0 = f.start_velocity();
    for (std::size_t i = 0; i < n2; ++i) {
      const double r0 = rates_[i], r1 = rates_[n2 + i], r2 = rates_[2 * n2 + i];
      out.z1[i] = h * (b[0] * r0 + b[1] * r1 + b[2] * r2) + (i < n ? 0.0 : v0[i - n]);
      for (std::size_t p = 0; p < 3; ++p)
        out.dense[p * n2 + i] = h * (basis[0][p] * r0 + basis[1][p] * r1 + basis[2][p] * r2) / static_cast<double>(p + 1);
      out.dense[3 * n2 + i] = 0;
    }
    out.has_a1 = false;
    out.error = 0;
  }

 private:
  /// Initial guess of the stage rates: extrapolated from the previous step's polynomial, or constant.
  /// @param ratio size of this step divided by that of the previous step; 0: constant
  void predict(const StepEquation& f, std::span<const double> a0, double ratio) {
    const std::size_t n2 = z_.size(), n = n2 / 2;
    const std::span<const double> v0 = f.start_velocity();
    for (std::size_t i = 0; i < n2; ++i) {
      const double r0 = rates_[i], r1 = rates_[n2 + i], r2 = rates_[2 * n2 + i];
      for (std::size_t s = 0; s < 3; ++s) {
        const double x = 1 + c[s] * ratio;
        double rate = i < n ? v0[i] : a0[i - n];
        if (ratio > 0) {
          rate = 0;
          for (std::size_t p = 3; p-- > 0;) rate = rate * x + basis[0][p] * r0 + basis[1][p] * r1 + basis[2][p] * r2;
        }
        next_[s * n2 + i] = rate;
      }
    }
    std::swap(rates_, next_);
  }

  /// Fixed-point iteration of the stage rates. Returns status not_converged if the changes of the rates stay above the bound `noise`.
  StepFailure iterate(StepEquation& f, double h) {
    const std::size_t n2 = z_.size(), n = n2 / 2;
    const std::span<const double> v0 = f.start_velocity();
    double last_change = 0;
    bool settled = false;
    int stalls = 0;
    for (int k = 0; k < max_iterations; ++k) {
      ++f.statistics().iterations;
      double change = 0, moved = 0;
      for (std::size_t s = 0; s < 3; ++s) {
        for (std::size_t i = 0; i < n2; ++i)
          z_[i] = h * (a[s][0] * rates_[i] + a[s][1] * rates_[n2 + i] + a[s][2] * rates_[2 * n2 + i]) + (i < n ? 0.0 : v0[i - n]);
        if (const StepFailure bad = f.calc_rate(f.start_time() + c[s] * h, z_.data(), next_.data() + s * n2); bad.failed())
          return k == 0 ? bad : StepFailure{IntegrationStatus::not_converged, -1};
        for (std::size_t i = 0; i < n2; ++i) {
          const double size = i < n ? 1.0 : 1.0 + std::fabs(v0[i - n]);
          change = std::max(change, h * std::fabs(next_[s * n2 + i] - rates_[s * n2 + i]) / size);
          moved = std::max(moved, h * std::fabs(next_[s * n2 + i]) / size);
        }
      }
      std::swap(rates_, next_);
      // The change of the rates stops decreasing when it has the size of the rounding errors of the accelerations.
      if (k > 0 && change >= last_change) ++stalls;
      if (change == 0 || (stalls > 0 && change < 1e-13) || (stalls > 2 && change <= noise * moved)) return {};
      if (k > 4 && change > 2 * last_change && change > noise * moved) break;
      last_change = change;
      settled = change <= noise * moved;
    }
    return settled ? StepFailure{} : StepFailure{IntegrationStatus::not_converged, -1};
  }

  double last_h_ = 0;
  std::vector<double> z_;             // [2 * nv] state (u, v) of a stage
  std::vector<double> rates_, next_;  // [3][2 * nv] stage rates: current and next iterate
};

}  // namespace

std::unique_ptr<StepMethod> make_gauss_legendre_6(std::size_t n) { return std::make_unique<GaussLegendre>(n); }

}  // namespace ugoki::dynamics
