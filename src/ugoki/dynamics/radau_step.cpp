// Radau IIA collocation with three stages, order 5, stiffly accurate and L-stable.
//
// The stage equations Z = h (A x I) F(z0 + Z) are solved by simplified Newton iteration in the eigenvectors of A^-1 (one real eigenvalue,
// one complex pair). A is the method's matrix, x the Kronecker product, Z the changes of the state z at the stages, F the
// rates there. Each linear system (g - [0 1; J_q J_v]) (du, dv) = (r_u, r_v) is reduced to nv rows:
//   (g^2 - g J_v - J_q) du = r_v + (g - J_v) r_u,   dv = g du - r_u
// Here z = (u, v), g is an eigenvalue of A^-1 divided by h, and J_q, J_v are the derivatives of the acceleration.
// Source: Hairer, Wanner, Solving ordinary differential equations II (1996), IV.8; the reduction is standard for second-order systems.

#include <algorithm>
#include <cmath>

#include "ugoki/dynamics/step_method.h"
#include "ugoki/spatial/elementary.h"

namespace ugoki::dynamics {
namespace {

struct Complex {
  double re = 0, im = 0;
  friend Complex operator-(const Complex& a, const Complex& b) { return {a.re - b.re, a.im - b.im}; }
  friend Complex operator*(const Complex& a, const Complex& b) { return {a.re * b.re - a.im * b.im, a.re * b.im + a.im * b.re}; }
  friend double size_of(const Complex& a) { return std::fabs(a.re) + std::fabs(a.im); }
  friend Complex reciprocal(const Complex& a) {
    const double d = a.re * a.re + a.im * a.im;
    return {a.re / d, -a.im / d};
  }
};
double size_of(double a) { return std::fabs(a); }
double reciprocal(double a) { return 1 / a; }

/// LU factorisation A = P^-1 L U in place, with row pivoting. @param A [n * n] row-major @return false if A is singular or not finite
template <class T>
bool lu_factor(std::size_t n, T* A, std::size_t* pivots) {
  for (std::size_t k = 0; k < n; ++k) {
    std::size_t best = k;
    for (std::size_t r = k + 1; r < n; ++r)
      if (size_of(A[r * n + k]) > size_of(A[best * n + k])) best = r;
    pivots[k] = best;
    if (!(size_of(A[best * n + k]) > 0) || !std::isfinite(size_of(A[best * n + k]))) return false;
    if (best != k) std::swap_ranges(A + k * n, A + (k + 1) * n, A + best * n);
    const T inverse_pivot = reciprocal(A[k * n + k]);
    for (std::size_t r = k + 1; r < n; ++r) {
      const T factor = A[r * n + k] * inverse_pivot;
      A[r * n + k] = factor;
      for (std::size_t c = k + 1; c < n; ++c) A[r * n + c] = A[r * n + c] - factor * A[k * n + c];
    }
  }
  return true;
}

/// Solves A x = b in place with the result of lu_factor(). @param x [n] in: b, out: x
template <class T>
void lu_solve(std::size_t n, const T* A, const std::size_t* pivots, T* x) {
  for (std::size_t k = 0; k < n; ++k) {
    if (pivots[k] != k) std::swap(x[k], x[pivots[k]]);
    for (std::size_t r = k + 1; r < n; ++r) x[r] = x[r] - A[r * n + k] * x[k];
  }
  for (std::size_t k = n; k-- > 0;) {
    for (std::size_t c = k + 1; c < n; ++c) x[k] = x[k] - A[k * n + c] * x[c];
    x[k] = x[k] * reciprocal(A[k * n + k]);
  }
}

constexpr double root6 = 2.449489742783178;
constexpr double c[3] = {(4 - root6) / 10, (4 + root6) / 10, 1};
// Weights of the stages in the error estimate of finish(), which contains the term sum_i dd[i] Z_i / h.
constexpr double dd[3] = {-(13 + 7 * root6) / 3, (-13 + 7 * root6) / 3, -1.0 / 3};
// Eigenvalues of A^-1: gamma and alpha +- i beta, the roots of x^3 - 9 x^2 + 36 x - 60. T^-1 A^-1 T is block diagonal:
// [gamma] and [[alpha, -beta], [beta, alpha]].
constexpr double gamma_real = 3.6378342527444957;
constexpr double alpha = 2.6810828736277521, beta = 3.0504301992474105;
constexpr double T[3][3] = {{9.1232394870892942792e-2, -0.14125529502095420843, -3.0029194105147424492e-2},
                            {0.24171793270710701896, 0.20412935229379993199, 0.38294211275726193779},
                            {0.96604818261509293619, 1, 0}};
constexpr double T_inverse[3][3] = {{4.3255798900631553510, 0.33919925181580986954, 0.54177053993587487119},
                                    {-4.1787185915519047273, -0.32768282076106238708, 0.47662355450055045196},
                                    {-0.50287263494578687595, 2.5719269498556054292, -0.59603920482822492497}};
constexpr int max_iterations = 8;  // Newton iterations per step attempt

/// y[i] = sum over j of M[i][j] x[j], where x and y are three stage vectors of length n2, one after another.
void transform(const double (&M)[3][3], std::size_t n2, const double* x, double* y) {
  for (std::size_t i = 0; i < n2; ++i) {
    const double x0 = x[i], x1 = x[n2 + i], x2 = x[2 * n2 + i];
    for (std::size_t s = 0; s < 3; ++s) y[s * n2 + i] = M[s][0] * x0 + M[s][1] * x1 + M[s][2] * x2;
  }
}

class RadauIIA final : public StepMethod {
 public:
  explicit RadauIIA(std::size_t n)
      : J_q_(n * n),
        J_v_(n * n),
        real_(n * n),
        pair_(n * n),
        real_pivots_(n),
        pair_pivots_(n),
        real_x_(n),
        pair_x_(n),
        Z_(3 * 2 * n),
        W_(3 * 2 * n),
        F_(3 * 2 * n),
        G_(3 * 2 * n),
        z_(2 * n),
        error_(2 * n),
        old_(3 * 2 * n),
        polynomial_(3 * 2 * n) {}

  int control_order() const override { return 4; }

  void compute_step(StepEquation& f, std::span<const double> a0, double h, bool restarted, StepResult& out) override {
    if (restarted) has_jacobian_ = false;
    out.failure = prepare(f, a0, h);
    if (out.failure.failed()) return;
    predict(h, restarted);
    out.failure = iterate(f, h);
    if (out.failure.failed()) {
      // Repeat the step with a new Jacobian if the iteration failed with a Jacobian from an earlier step.
      if (jacobian_is_old_ && out.failure.status == IntegrationStatus::not_converged) {
        has_jacobian_ = false;
        compute_step(f, a0, h, restarted, out);
      }
      return;
    }
    finish(f, a0, h, restarted, out);
  }

  void accept() override {
    // Keep the Jacobian for the next step if the iteration converged quickly (rate of at most 1e-3 per iteration)
    jacobian_is_old_ = true;
    if (rate_of_convergence_ > 1e-3) has_jacobian_ = false;
    last_h_ = h_;
    std::swap(old_, polynomial_);
  }

 private:
  /// Recomputes the Jacobian and the factors of the two linear systems, where they are not valid for step size h.
  StepFailure prepare(StepEquation& f, std::span<const double> a0, double h) {
    const std::size_t n = f.n();
    if (!has_jacobian_) {
      if (const StepFailure bad = f.calc_jacobian(a0, J_q_, J_v_); bad.failed()) return bad;
      has_jacobian_ = true;
      jacobian_is_old_ = false;
      factored_h_ = 0;
    }
    h_ = h;
    if (h == factored_h_) return {};
    ++f.statistics().factorizations;
    const double g = gamma_real / h;
    const Complex gc{alpha / h, beta / h}, gc2 = gc * gc;
    for (std::size_t i = 0; i < n; ++i)
      for (std::size_t j = 0; j < n; ++j) {
        const std::size_t at = i * n + j;
        const double unit = i == j ? 1 : 0;
        real_[at] = unit * g * g - g * J_v_[at] - J_q_[at];
        pair_[at] = {unit * gc2.re - gc.re * J_v_[at] - J_q_[at], unit * gc2.im - gc.im * J_v_[at]};
      }
    if (!lu_factor(n, real_.data(), real_pivots_.data()) || !lu_factor(n, pair_.data(), pair_pivots_.data())) {
      factored_h_ = 0;
      return {IntegrationStatus::not_converged, -1};
    }
    factored_h_ = h;
    return {};
  }

  /// x <- (g - J)^-1 x for the real eigenvalue g of A^-1 / h; J = [0 1; J_q J_v]. @param x [2 * nv]
  void solve_real(std::size_t n, double h, double* x) {
    const double g = gamma_real / h;
    for (std::size_t i = 0; i < n; ++i) {
      double sum = x[n + i] + g * x[i];
      for (std::size_t j = 0; j < n; ++j) sum -= J_v_[i * n + j] * x[j];
      real_x_[i] = sum;
    }
    lu_solve(n, real_.data(), real_pivots_.data(), real_x_.data());
    for (std::size_t i = 0; i < n; ++i) {
      x[n + i] = g * real_x_[i] - x[i];
      x[i] = real_x_[i];
    }
  }

  /// x + i y <- (g - J)^-1 (x + i y) for a complex eigenvalue g of A^-1 / h; J = [0 1; J_q J_v]. @param x, y [2 * nv]
  void solve_pair(std::size_t n, double h, double* x, double* y) {
    const Complex g{alpha / h, beta / h};
    for (std::size_t i = 0; i < n; ++i) {
      const Complex scaled = g * Complex{x[i], y[i]};
      Complex sum{x[n + i] + scaled.re, y[n + i] + scaled.im};
      for (std::size_t j = 0; j < n; ++j) sum = sum - Complex{J_v_[i * n + j] * x[j], J_v_[i * n + j] * y[j]};
      pair_x_[i] = sum;
    }
    lu_solve(n, pair_.data(), pair_pivots_.data(), pair_x_.data());
    for (std::size_t i = 0; i < n; ++i) {
      const Complex dv = g * pair_x_[i] - Complex{x[i], y[i]};
      x[n + i] = dv.re;
      y[n + i] = dv.im;
      x[i] = pair_x_[i].re;
      y[i] = pair_x_[i].im;
    }
  }

  /// Sets the initial values of the stages: extrapolated from the polynomial of the last accepted step, or zero after a restart.
  void predict(double h, bool restarted) {
    const std::size_t n2 = z_.size();
    if (restarted || !(last_h_ > 0)) {
      for (double& x : Z_) x = 0;
      for (double& x : W_) x = 0;
      return;
    }
    const double ratio = h / last_h_;
    const auto value = [&](std::size_t i, double x) { return x * (old_[i] + x * (old_[n2 + i] + x * old_[2 * n2 + i])); };
    for (std::size_t s = 0; s < 3; ++s)
      for (std::size_t i = 0; i < n2; ++i) Z_[s * n2 + i] = value(i, 1 + c[s] * ratio) - value(i, 1);
    transform(T_inverse, n2, Z_.data(), W_.data());
  }

  /// Simplified Newton iteration for the stages Z_.
  StepFailure iterate(StepEquation& f, double h) {
    const std::size_t n2 = z_.size(), n = n2 / 2;
    const std::span<const double> v0 = f.start_velocity();
    const double rtol = f.options().relative_tolerance;
    const double newton_tolerance = std::max(2.3e-15 / rtol, std::min(0.03, std::sqrt(rtol)));
    double last_size = 0;
    slowness_ = slowness_ > 0 ? pow(std::max(slowness_, 2.3e-16), 0.8) : 1;
    rate_of_convergence_ = 0;  // convergence in one iteration counts as fast
    for (int k = 0; k < max_iterations; ++k) {
      ++f.statistics().iterations;
      for (std::size_t s = 0; s < 3; ++s) {
        for (std::size_t i = 0; i < n2; ++i) z_[i] = Z_[s * n2 + i] + (i < n ? 0.0 : v0[i - n]);
        if (const StepFailure bad = f.calc_rate(f.start_time() + c[s] * h, z_.data(), F_.data() + s * n2); bad.failed())
          return k == 0 ? bad : StepFailure{IntegrationStatus::not_converged, -1};
      }
      transform(T_inverse, n2, F_.data(), G_.data());
      for (std::size_t i = 0; i < n2; ++i) {
        const double w1 = W_[n2 + i], w2 = W_[2 * n2 + i];
        G_[i] -= gamma_real / h * W_[i];
        G_[n2 + i] -= (alpha * w1 - beta * w2) / h;
        G_[2 * n2 + i] -= (alpha * w2 + beta * w1) / h;
      }
      solve_real(n, h, G_.data());
      solve_pair(n, h, G_.data() + n2, G_.data() + 2 * n2);
      double sum = 0;
      for (std::size_t s = 0; s < 3; ++s) {
        const double size = f.norm(z_.data(), G_.data() + s * n2);
        sum += size * size;
      }
      for (std::size_t i = 0; i < W_.size(); ++i) W_[i] += G_[i];
      transform(T, n2, W_.data(), Z_.data());
      const double size = std::sqrt(sum / 3);
      if (!std::isfinite(size)) return {IntegrationStatus::not_converged, -1};
      if (k > 0) {
        rate_of_convergence_ = size / last_size;
        if (rate_of_convergence_ >= 0.99 && size > 1e-3 * newton_tolerance) return {IntegrationStatus::not_converged, -1};
        slowness_ = rate_of_convergence_ / (1 - std::min(rate_of_convergence_, 0.99));
      }
      if (slowness_ * size <= newton_tolerance || size == 0) return {};
      last_size = size;
    }
    return {IntegrationStatus::not_converged, -1};
  }

  /// Computes end state, continuous solution and error estimate from the converged stages.
  void finish(StepEquation& f, std::span<const double> a0, double h, bool restarted, StepResult& out) {
    const std::size_t n2 = z_.size(), n = n2 / 2;
    const std::span<const double> v0 = f.start_velocity();
    for (std::size_t i = 0; i < n2; ++i) out.z1[i] = Z_[2 * n2 + i] + (i < n ? 0.0 : v0[i - n]);
    for (std::size_t i = 0; i < n2; ++i) {
      double p[3] = {};
      for (std::size_t s = 0; s < 3; ++s) {
        const double cj = c[(s + 1) % 3], ck = c[(s + 2) % 3];
        const double weight = Z_[s * n2 + i] / (c[s] * (c[s] - cj) * (c[s] - ck));
        p[0] += weight * cj * ck;
        p[1] -= weight * (cj + ck);
        p[2] += weight;
      }
      for (std::size_t k = 0; k < 3; ++k) polynomial_[k * n2 + i] = out.dense[k * n2 + i] = p[k];
      out.dense[3 * n2 + i] = 0;
    }
    out.has_a1 = false;
    if (!f.options().adaptive) {
      out.error = 0;
      return;
    }
    for (std::size_t i = 0; i < n2; ++i) {
      F_[i] = (dd[0] * Z_[i] + dd[1] * Z_[n2 + i] + dd[2] * Z_[2 * n2 + i]) / h;
      error_[i] = F_[i] + (i < n ? v0[i] : a0[i - n]);
    }
    solve_real(n, h, error_.data());
    out.error = f.norm(out.z1.data(), error_.data());
    if (out.error < 1 || !(restarted || rejected_last_)) {
      rejected_last_ = out.error > 1;
      return;
    }
    // Estimate the error again, with the rate at the step's start displaced by the first estimate. In stiff components the first estimate
    // is far too large; the second estimate damps these components.
    for (std::size_t i = 0; i < n2; ++i) z_[i] = error_[i] + (i < n ? 0.0 : v0[i - n]);
    if (f.calc_rate(f.start_time(), z_.data(), error_.data()).failed()) return;
    for (std::size_t i = 0; i < n2; ++i) error_[i] += F_[i];
    solve_real(n, h, error_.data());
    out.error = f.norm(out.z1.data(), error_.data());
    rejected_last_ = out.error > 1;
  }

  bool has_jacobian_ = false, jacobian_is_old_ = false, rejected_last_ = false;
  double factored_h_ = 0, h_ = 0, last_h_ = 0, rate_of_convergence_ = 1, slowness_ = 1;
  std::vector<double> J_q_, J_v_, real_;
  std::vector<Complex> pair_;
  std::vector<std::size_t> real_pivots_, pair_pivots_;
  std::vector<double> real_x_;
  std::vector<Complex> pair_x_;
  std::vector<double> Z_, W_, F_, G_;     // [3][2 * nv] Z, T^-1 Z, stage rates F, Newton corrections of T^-1 Z
  std::vector<double> z_, error_;         // [2 * nv] state of a stage; error estimate
  std::vector<double> old_, polynomial_;  // [3][2 * nv] continuous solution of the last accepted step and of the present one
};

}  // namespace

std::unique_ptr<StepMethod> make_radau_iia_5(std::size_t n) { return std::make_unique<RadauIIA>(n); }

}  // namespace ugoki::dynamics
