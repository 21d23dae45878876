#include "ugoki/dynamics/integrators.h"

#include <algorithm>
#include <cmath>

#include "ugoki/base/check.h"
#include "ugoki/dynamics/step_events.h"
#include "ugoki/dynamics/step_method.h"
#include "ugoki/mechanism/state.h"
#include "ugoki/spatial/elementary.h"

namespace ugoki::dynamics {
namespace {

constexpr double epsilon = std::numeric_limits<double>::epsilon();

bool has_error_estimate(IntegrationMethod method) {
  return method == IntegrationMethod::dormand_prince_54 || method == IntegrationMethod::radau_iia_5;
}

IntegratorOptions in_range(IntegratorOptions o) {
  o.adaptive = o.adaptive && has_error_estimate(o.method);
  if (!(o.step > 0) || !std::isfinite(o.step)) o.step = o.adaptive ? 0 : 1e-3;
  if (!(o.min_step > 0)) o.min_step = 1e-12;
  if (!(o.max_step >= o.min_step)) o.max_step = o.min_step;
  if (!(o.relative_tolerance >= 1e-14)) o.relative_tolerance = 1e-14;
  if (!(o.absolute_tolerance >= 1e-300)) o.absolute_tolerance = 1e-300;
  if (!(o.event_tolerance > 0)) o.event_tolerance = 1e-10;
  o.event_samples = std::max(o.event_samples, 1);
  if (o.method == IntegrationMethod::radau_iia_5 && o.adaptive) {
    // The error estimate has order 3 but the result has order 5. The estimate is therefore compared with this wider tolerance, as in the
    // program RADAU5 by Hairer and Wanner.
    const double inner = 0.1 * pow(o.relative_tolerance, 2.0 / 3);
    o.absolute_tolerance *= inner / o.relative_tolerance;
    o.relative_tolerance = inner;
  }
  return o;
}

std::unique_ptr<StepMethod> make_method(IntegrationMethod method, std::size_t n) {
  switch (method) {
    case IntegrationMethod::semi_implicit_euler: return make_semi_implicit_euler(n);
    case IntegrationMethod::runge_kutta_4: return make_runge_kutta_4(n);
    case IntegrationMethod::gauss_legendre_6: return make_gauss_legendre_6(n);
    case IntegrationMethod::radau_iia_5: return make_radau_iia_5(n);
    case IntegrationMethod::dormand_prince_54: break;
  }
  return make_dormand_prince_54(n);
}

}  // namespace

std::string_view name_of(IntegrationStatus status) {
  constexpr std::string_view names[] = {"reached",        "event",          "singular",      "not finite",
                                        "step too small", "too many steps", "not converged", "projection failed"};
  return names[static_cast<std::size_t>(status)];
}

struct Integrator::Implementation final : StepEvents::Trajectory {
  Implementation(MotionSystem& s, const IntegratorOptions& o)
      : system(s),
        options(in_range(o)),
        n(static_cast<std::size_t>(s.mechanism().nv())),
        equation(s, options, statistics),
        method(make_method(options.method, n)),
        result(n),
        dense(result.dense),
        events(s),
        q(s.mechanism().neutral()),
        q_base(q),
        q_new(q),
        q_probe(q),
        v(n),
        v_base(n),
        v_new(n),
        v_probe(n),
        a(n),
        u(n) {}

  // Evaluates the continuous solution of the last accepted step. s is the fraction of the step, 0 to 1.
  void state_at(double s, std::span<double> q_out, std::span<double> v_out) override {
    solution_at(s, u, v_out);
    integrate(system.mechanism(), q_base, u, 1.0, q_out);
  }
  double time_at(double s) const override { return t_base + s * h_base; }
  void solution_at(double s, std::span<double> u_out, std::span<double> v_out) const {
    const std::size_t n2 = 2 * n;
    const std::vector<double>& d = dense;
    for (std::size_t i = 0; i < n; ++i) {
      const std::size_t k = n + i;
      u_out[i] = s * (d[i] + s * (d[n2 + i] + s * (d[2 * n2 + i] + s * d[3 * n2 + i])));
      v_out[i] = v_base[i] + s * (d[k] + s * (d[n2 + k] + s * (d[2 * n2 + k] + s * d[3 * n2 + k])));
    }
  }

  void start(double time, std::span<const double> q_in, std::span<const double> v_in) {
    t = t_base = time;
    h_base = 0;
    std::copy(q_in.begin(), q_in.end(), q.begin());
    std::copy(v_in.begin(), v_in.end(), v.begin());
    q_base = q;
    v_base = v;
    std::fill(dense.begin(), dense.end(), 0.0);
    has_a = has_g = false;
    restarted = true;
    h_next = options.step;
    events.clear_pending();
  }

  IntegrationReport report(IntegrationStatus status, int dof = -1, int event = -1) const {
    return {status, t, dof, dof >= 0 ? system.mechanism().link_of_dof(dof) : -1, event};
  }
  IntegrationReport report(const StepFailure& failure) const { return report(failure.status, failure.dof); }

  bool done(double t_end) const { return !(t_end - t > 8 * epsilon * std::max(std::fabs(t), std::fabs(t_end))); }

  IntegrationReport advance(double t_end) {
    if (const int e = events.next_pending(); e >= 0) return report(IntegrationStatus::event, -1, e);
    for (long steps = 0; !done(t_end); ++steps) {
      if (steps >= options.max_steps) return report(IntegrationStatus::too_many_steps);
      if (const IntegrationReport r = step(t_end); r.status != IntegrationStatus::reached) return r;
    }
    return report(IntegrationStatus::reached);
  }

  /// Computes the acceleration and the event values at the current state if they are not cached.
  IntegrationReport prepare_start() {
    if (!has_a) {
      if (!is_finite(q) || !is_finite(v)) return report(IntegrationStatus::not_finite, bad_dof());
      if (const StepFailure bad = equation.calc_acceleration(t, q, v, a); bad.failed()) return report(bad);
      has_a = true;
    }
    if (!has_g && !events.none()) {
      if (const int bad = events.begin(system, t, q, v); bad >= 0) return report(IntegrationStatus::not_finite, -1, bad);
    }
    has_g = true;
    return report(IntegrationStatus::reached);
  }

  /// First DOF whose position or velocity is not finite, or -1.
  int bad_dof() const {
    for (const Link& link : system.mechanism().links())
      for (int k = 0; k < link.joint.nv(); ++k) {
        const bool q_bad = k < link.joint.nq() && !is_finite(std::span(q).subspan(static_cast<std::size_t>(link.q_index),
                                                                                  static_cast<std::size_t>(link.joint.nq())));
        if (q_bad || !std::isfinite(v[static_cast<std::size_t>(link.v_index + k)])) return link.v_index + k;
      }
    return -1;
  }

  /// Computes steps until one is accepted. The step ends at t_end at the latest. A rejected step is repeated with a smaller size.
  IntegrationReport step(double t_end) {
    if (const IntegrationReport r = prepare_start(); r.status != IntegrationStatus::reached) return r;
    equation.begin(t, q, v);
    if (h_next <= 0) h_next = first_step(t_end);
    bool shrunk = false;
    for (;;) {
      const double left = t_end - t;
      double h = std::min(h_next, options.max_step);
      const bool last = h * (1 + 1e-6) >= left;  // a step may be stretched by 1e-6 of its size to avoid a tiny last step
      if (last) h = left;
      result.failure = {};
      result.error = 0;
      method->compute_step(equation, a, h, restarted, result);
      const IntegrationReport assessed = assess(h, last, shrunk, t_end);
      if (assessed.status == IntegrationStatus::reached && accepted) return finish_step(h, last, t_end);
      if (assessed.status != IntegrationStatus::reached) return assessed;
      shrunk = true;
      ++statistics.rejected;
    }
  }

  /// Decides whether the computed step is accepted (sets `accepted`), and sets the next step size.
  /// @return status `reached` if the integration can go on, else the failure
  IntegrationReport assess(double h, bool last, bool shrunk, double t_end) {
    accepted = false;
    StepFailure failure = result.failure;
    if (!failure.failed()) {
      equation.calc_configuration(result.z1.data(), q_new);
      std::copy(result.z1.begin() + static_cast<std::ptrdiff_t>(n), result.z1.end(), v_new.begin());
      for (std::size_t i = 0; i < n && !failure.failed(); ++i)
        if (!std::isfinite(result.z1[i]) || !std::isfinite(result.z1[n + i]))
          failure = {IntegrationStatus::not_finite, static_cast<int>(i)};
    }
    if (!failure.failed() && (!options.adaptive || result.error <= 1)) {
      projected = system.project(t + h, q_new, v_new);
      if (projected == Projection::failed)
        failure = {IntegrationStatus::projection_failed, -1};
      else {
        accepted = true;
        if (options.adaptive) choose_next_step(h, last, shrunk);
        return report(IntegrationStatus::reached);
      }
    }
    if (!options.adaptive) return failure.failed() ? report(failure) : report(IntegrationStatus::reached);
    const double order = method->control_order();
    h_next = failure.failed() ? 0.25 * h : h * std::max(0.2, 0.9 * pow(result.error, -1 / order));
    if (h_next < std::max(options.min_step, 4 * epsilon * std::max(std::fabs(t), std::fabs(t_end))))
      return failure.failed() ? report(failure) : report(IntegrationStatus::step_too_small);
    return report(IntegrationStatus::reached);
  }

  /// Next step size of an adaptive method after an accepted step: proportional-integral control (Gustafsson 1991).
  void choose_next_step(double h, bool last, bool shrunk) {
    const double order = method->control_order();
    const double error = std::max(result.error, 1e-8);
    double factor = 0.9 * pow(error, -0.7 / order) * pow(last_error, 0.4 / order);
    factor = std::clamp(factor, 0.2, shrunk ? 1.0 : 8.0);
    last_error = std::max(error, 1e-4);
    if (options.method == IntegrationMethod::radau_iia_5 && factor >= 1 && factor <= 1.2) factor = 1;  // same h: keep the factored matrices
    const double next = std::min(h * factor, options.max_step);
    h_next = last ? std::max(next, shrunk ? 0.0 : h_next) : next;
  }

  IntegrationReport finish_step(double h, bool last, double t_end) {
    ++statistics.steps;
    method->accept();
    std::swap(q, q_base);
    std::swap(v, v_base);
    std::swap(q, q_new);
    std::swap(v, v_new);
    std::swap(dense, result.dense);
    t_base = t;
    h_base = h;
    has_a = result.has_a1 && projected == Projection::kept;
    restarted = projected == Projection::moved;
    if (has_a) std::swap(a, result.a1);
    t = last ? t_end : t + h;
    if (events.none()) return report(IntegrationStatus::reached);
    return find_events();
  }

  IntegrationReport find_events() {
    has_g = false;
    const double s_tolerance = std::max(options.event_tolerance / h_base, 4 * epsilon);
    const StepEvents::SearchResult found = events.find(system, *this, options.event_samples, s_tolerance, q_probe, v_probe);
    if (found.outcome == StepEvents::Outcome::none) return report(IntegrationStatus::reached);
    if (found.outcome == StepEvents::Outcome::not_finite) {
      restore_step_start();
      return report(IntegrationStatus::not_finite, -1, found.event);
    }
    state_at(found.s, q, v);
    t = time_at(found.s);
    has_a = false;
    restarted = true;
    ++statistics.events;
    if (system.project(t, q, v) == Projection::failed) {
      restore_step_start();
      return report(IntegrationStatus::projection_failed);
    }
    return report(IntegrationStatus::event, -1, found.event);
  }

  void restore_step_start() {
    q = q_base;
    v = v_base;
    t = t_base;
    has_a = has_g = false;
    restarted = true;
    events.clear_pending();
  }

  /// First step size, estimated from the norms of the first two derivatives (Hairer, Norsett, Wanner I, II.4).
  double first_step(double t_end) {
    const double limit = std::min(options.max_step, t_end - t);
    std::vector<double>& z = result.z1;
    const auto norm_of = [&](std::span<const double> top, std::span<const double> bottom) {
      for (std::size_t i = 0; i < n; ++i) {
        z[i] = top[i];
        z[n + i] = bottom[i];
      }
      return equation.norm(z.data(), z.data());
    };
    const double slope = norm_of(v, a);
    double h = slope > 1e-10 ? std::min(1e-2 / slope, limit) : std::min(1e-6, limit);
    for (std::size_t i = 0; i < n; ++i) {
      z[i] = h * v[i];
      z[n + i] = v[i] + h * a[i];
    }
    double curvature = slope;
    if (!equation.calc_rate(t + h, z.data(), result.dense.data()).failed()) {
      for (std::size_t i = 0; i < n; ++i) {
        v_probe[i] = (result.dense[i] - v[i]) / h;
        u[i] = (result.dense[n + i] - a[i]) / h;
      }
      curvature = norm_of(v_probe, u);
    }
    const double maximum = std::max({slope, curvature, 1e-10});
    return std::clamp(std::min(pow(1e-2 / maximum, 1.0 / method->control_order()), 100 * h), options.min_step, limit);
  }

  MotionSystem& system;
  IntegratorOptions options;
  IntegrationStatistics statistics;
  std::size_t n;
  StepEquation equation;
  std::unique_ptr<StepMethod> method;
  StepResult result;
  std::vector<double> dense;  // continuous solution of the last accepted step
  StepEvents events;
  double t = 0, t_base = 0, h_base = 0, h_next = 0, last_error = 1e-4;
  bool has_a = false, has_g = false, restarted = true, accepted = false;
  Projection projected = Projection::kept;
  std::vector<double> q, q_base, q_new, q_probe;  // [nq] current, at the last step's start, candidate, scratch of event search
  std::vector<double> v, v_base, v_new, v_probe;  // [nv] velocities, in the order of the q arrays
  std::vector<double> a, u;                       // [nv] acceleration at the current state; scratch
};

Integrator::Integrator(MotionSystem& system, const IntegratorOptions& options) : self_(std::make_unique<Implementation>(system, options)) {}
Integrator::~Integrator() = default;

void Integrator::start(double t, std::span<const double> q, std::span<const double> v) {
  UGOKI_CHECK(q.size() == self_->q.size() && v.size() == self_->n);
  self_->start(t, q, v);
}

void Integrator::forget() {
  self_->has_a = self_->has_g = false;
  self_->restarted = true;
}

IntegrationReport Integrator::advance(double t_end) { return self_->advance(t_end); }
double Integrator::time() const { return self_->t; }
std::span<const double> Integrator::q() const { return self_->q; }
std::span<const double> Integrator::v() const { return self_->v; }
double Integrator::next_step() const { return self_->h_next; }
const IntegrationStatistics& Integrator::statistics() const { return self_->statistics; }

void Integrator::interpolate(double t, std::span<double> q, std::span<double> v) const {
  const double s = self_->h_base > 0 ? std::clamp((t - self_->t_base) / self_->h_base, 0.0, 1.0) : 0.0;
  self_->state_at(s, q, v);
}

}  // namespace ugoki::dynamics
