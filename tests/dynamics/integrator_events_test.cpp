// Events, projections and failures of the integrators.

#include <gtest/gtest.h>

#include <cmath>

#include "allocation_count.h"
#include "integrator_scenes.h"

namespace ugoki::dynamics {
namespace {

using testing::adaptive;
using testing::all_methods;
using testing::fixed;
using Method = IntegrationMethod;
using Status = IntegrationStatus;

constexpr double g = 9.81;

/// Falling masses: event i occurs when mass i falls through height 0.
class Falling final : public OpenSystem {
 public:
  explicit Falling(int count) : OpenSystem(testing::sliders(count)) {}
  int event_count() const override { return mechanism().nv(); }
  EventDirection event_direction(int) const override { return EventDirection::falling; }
  void calc_events(double, std::span<const double> q, std::span<const double>, std::span<double> out) override {
    for (std::size_t i = 0; i < q.size(); ++i) out[i] = q[i];
  }
};

TEST(StepEvents, BouncingBallImpactTimesMatchClosedForm) {
  for (const Method method : all_methods) {
    Falling system(1);
    IntegratorOptions options = fixed(method, method == Method::semi_implicit_euler ? 1e-5 : 0.03);
    options.adaptive = true;
    options.event_tolerance = 1e-12;
    Integrator integrator(system, options);
    const double height[] = {1.0}, rest[] = {0.0};
    integrator.start(0, height, rest);
    const double e = 0.8, tolerance = method == Method::semi_implicit_euler ? 1e-3 : 1e-10;
    double expected = std::sqrt(2 / g), speed = g * expected;
    for (int bounce = 0; bounce < 12; ++bounce) {
      const IntegrationReport r = integrator.advance(100);
      ASSERT_EQ(r.status, Status::event) << static_cast<int>(method) << " bounce " << bounce;
      EXPECT_EQ(r.event, 0);
      EXPECT_NEAR(r.time, expected, tolerance) << static_cast<int>(method);
      EXPECT_LE(integrator.q()[0], 0);
      EXPECT_NEAR(integrator.q()[0], 0, tolerance);
      EXPECT_NEAR(integrator.v()[0], -speed, 20 * tolerance);
      const double q[] = {integrator.q()[0]}, v[] = {-e * integrator.v()[0]};
      integrator.start(r.time, q, v);
      speed *= e;
      expected += 2 * speed / g;
    }
  }
}

TEST(StepEvents, AdvanceAfterEventContinuesTheMotion) {
  Falling system(1);
  Integrator integrator(system, adaptive(Method::dormand_prince_54, 1e-10));
  const double height[] = {1.0}, rest[] = {0.0};
  integrator.start(0, height, rest);
  EXPECT_EQ(integrator.advance(2).status, Status::event);
  EXPECT_EQ(integrator.advance(2).status, Status::reached);
  EXPECT_NEAR(integrator.q()[0], 1 - 0.5 * g * 4, 1e-8);
  EXPECT_EQ(integrator.statistics().events, 1);
}

TEST(StepEvents, SimultaneousEventsAreAllReportedInTimeOrder) {
  Falling system(4);
  Integrator integrator(system, adaptive(Method::dormand_prince_54, 1e-10));
  const double height[] = {2.0, 1.0, 2.0, 0.5}, rest[] = {0, 0, 0, 0};
  integrator.start(0, height, rest);
  const int order[] = {3, 1, 0, 2};
  const double when[] = {std::sqrt(1.0 / g), std::sqrt(2.0 / g), std::sqrt(4.0 / g), std::sqrt(4.0 / g)};
  for (int i = 0; i < 4; ++i) {
    const IntegrationReport r = integrator.advance(3);
    ASSERT_EQ(r.status, Status::event);
    EXPECT_EQ(r.event, order[i]);
    EXPECT_NEAR(r.time, when[i], 1e-9);
  }
  EXPECT_EQ(integrator.advance(3).status, Status::reached);
}

TEST(StepEvents, StartOnEventIsNotReported) {
  Falling system(1);
  Integrator integrator(system, adaptive(Method::dormand_prince_54, 1e-10));
  const double ground[] = {0.0}, down[] = {-1.0};
  integrator.start(0, ground, down);
  EXPECT_EQ(integrator.advance(1).status, Status::reached);
}

TEST(StepEvents, NonFiniteEventFunctionStopsAtLastGoodState) {
  class Lost final : public OpenSystem {
   public:
    Lost() : OpenSystem(testing::sliders(1)) {}
    int event_count() const override { return 1; }
    void calc_events(double t, std::span<const double>, std::span<const double>, std::span<double> out) override {
      out[0] = t > 0.305 ? std::numeric_limits<double>::quiet_NaN() : 1.0;
    }
  } system;
  Integrator integrator(system, fixed(Method::runge_kutta_4, 0.01));
  const double q[] = {0.0}, v[] = {0.0};
  integrator.start(0, q, v);
  const IntegrationReport r = integrator.advance(1);
  EXPECT_EQ(r.status, Status::not_finite);
  EXPECT_EQ(r.event, 0);
  EXPECT_NEAR(r.time, 0.30, 1e-12);
  EXPECT_NEAR(integrator.q()[0], -0.5 * g * 0.09, 1e-12);
}

/// A mass rises above a height and falls below it again within one step. Both crossings are found, each by the event of its direction.
TEST(StepEvents, TwoCrossingsWithinOneStepAreFoundByDirection) {
  class Thrown final : public OpenSystem {
   public:
    Thrown() : OpenSystem(testing::sliders(1)) {}
    int event_count() const override { return 2; }
    EventDirection event_direction(int e) const override { return e == 0 ? EventDirection::rising : EventDirection::falling; }
    void calc_events(double, std::span<const double> q, std::span<const double>, std::span<double> out) override {
      out[0] = out[1] = q[0] - 1;
    }
  } system;
  Integrator integrator(system, fixed(Method::runge_kutta_4, 1.0));  // the whole flight in one step
  const double ground[] = {0.0}, up[] = {std::sqrt(2 * g * 1.1)};
  integrator.start(0, ground, up);
  const double root = std::sqrt(2 * 0.1 / g), top = up[0] / g;
  const IntegrationReport first = integrator.advance(1);
  ASSERT_EQ(first.status, Status::event);
  EXPECT_EQ(first.event, 0);
  EXPECT_NEAR(first.time, top - root, 1e-9);
  const IntegrationReport second = integrator.advance(1);
  ASSERT_EQ(second.status, Status::event);
  EXPECT_EQ(second.event, 1);
  EXPECT_NEAR(second.time, top + root, 1e-9);
  EXPECT_EQ(integrator.advance(1).status, Status::reached);
}

/// A mass in a plane on a circle of radius 1. The acceleration keeps it on the circle, and project() corrects the drift.
class OnCircle final : public MotionSystem {
 public:
  static MechanismPtr make_mechanism() {
    MechanismSpec spec;
    spec.name = "bead";
    LinkSpec l;
    l.name = "bead";
    l.joint.type = JointType::planar;
    l.inertia = Inertia::from_centre(1, {}, {1, 1, 1, 0, 0, 0});
    spec.links.push_back(l);
    return Mechanism::make(std::move(spec)).value();
  }
  explicit OnCircle(bool corrected) : MotionSystem(make_mechanism()), corrected_(corrected) {}
  int calc_acceleration(double, std::span<const double> q, std::span<const double> v, std::span<double> a) override {
    const double r2 = q[0] * q[0] + q[1] * q[1];
    const double pull = (v[0] * v[0] + v[1] * v[1] - g * q[1]) / r2;  // q . a = -v . v
    a[0] = -pull * q[0];
    a[1] = -pull * q[1] - g;
    a[2] = 0;
    return -1;
  }
  Projection project(double, std::span<double> q, std::span<double> v) override {
    if (fail) return Projection::failed;
    if (!corrected_) return Projection::kept;
    const double r = std::sqrt(q[0] * q[0] + q[1] * q[1]);
    q[0] /= r;
    q[1] /= r;
    const double out = q[0] * v[0] + q[1] * v[1];
    v[0] -= out * q[0];
    v[1] -= out * q[1];
    return Projection::moved;
  }
  bool fail = false;

 private:
  bool corrected_;
};

TEST(Projections, KeepAConstraintSatisfied) {
  const auto gap = [](bool corrected) {
    OnCircle system(corrected);
    Integrator integrator(system, fixed(Method::runge_kutta_4, 1e-2));
    const double q[] = {1, 0, 0}, v[] = {0, 0, 0};
    integrator.start(0, q, v);
    EXPECT_EQ(integrator.advance(20).status, Status::reached);
    // The acceleration at the end of a step is reused at the start of the next step only if project() did not move the state
    EXPECT_NEAR(static_cast<double>(integrator.statistics().accelerations), (corrected ? 5.0 : 4.0) * 2000, 1);
    return std::fabs(std::hypot(integrator.q()[0], integrator.q()[1]) - 1);
  };
  EXPECT_GT(gap(false), 1e-6);
  EXPECT_LT(gap(true), 1e-15);
}

TEST(Failures, FailedProjectionKeepsLastGoodState) {
  for (const Method method : {Method::runge_kutta_4, Method::dormand_prince_54}) {
    OnCircle system(true);
    IntegratorOptions options = adaptive(method, 1e-8);
    options.step = 1e-2;
    Integrator integrator(system, options);
    const double q[] = {1, 0, 0}, v[] = {0, 0, 0};
    integrator.start(0, q, v);
    ASSERT_EQ(integrator.advance(0.5).status, Status::reached);
    const std::vector<double> last(integrator.q().begin(), integrator.q().end());
    system.fail = true;
    const IntegrationReport r = integrator.advance(1);
    EXPECT_EQ(r.status, Status::projection_failed);
    EXPECT_EQ(r.time, 0.5);
    EXPECT_EQ(std::vector<double>(integrator.q().begin(), integrator.q().end()), last);
  }
}

/// A system whose drive becomes NaN, or whose inertia becomes singular, at t = 0.505 s.
class Failing final : public OpenSystem {
 public:
  Failing(bool singular) : OpenSystem(testing::pendulum({1, 1})), singular_(singular) {}
  int calc_acceleration(double t, std::span<const double> q, std::span<const double> v, std::span<double> a) override {
    if (t > 0.505 && singular_) return 1;
    return OpenSystem::calc_acceleration(t, q, v, a);
  }
  void calc_drive(double t, std::span<const double>, std::span<const double>, std::span<double> tau) override {
    tau[0] = 0;
    tau[1] = t > 0.505 ? std::numeric_limits<double>::quiet_NaN() : 0.0;
  }

 private:
  bool singular_;
};

TEST(Failures, ReportTimeDofAndLinkAndKeepLastGoodState) {
  for (const bool singular : {false, true})
    for (const Method method : all_methods) {
      Failing system(singular);
      IntegratorOptions options = adaptive(method, 1e-6);
      options.step = 1e-2;
      options.min_step = 1e-6;
      Integrator integrator(system, options);
      const double q[] = {1, 1}, v[] = {0, 0};
      integrator.start(0, q, v);
      const IntegrationReport r = integrator.advance(1);
      EXPECT_EQ(r.status, singular ? Status::singular : Status::not_finite) << static_cast<int>(method) << " " << name_of(r.status);
      EXPECT_GE(r.dof, 0);
      EXPECT_EQ(r.link, r.dof);
      if (singular) {
        EXPECT_EQ(r.dof, 1);
      }
      EXPECT_GT(r.time, 0.47);
      EXPECT_LE(r.time, 0.52);
      EXPECT_EQ(r.time, integrator.time());
      EXPECT_TRUE(is_finite(integrator.q()) && is_finite(integrator.v()));
    }
}

// Accelerations with only nine accurate digits, as in nearly singular systems, do not make Newton's method fail.
TEST(Failures, NoisyAccelerationsDoNotStopImplicitMethods) {
  class Noisy final : public OpenSystem {
   public:
    Noisy() : OpenSystem(testing::pendulum({1, 1})) {}
    void calc_drive(double, std::span<const double> q, std::span<const double>, std::span<double> tau) override {
      for (std::size_t i = 0; i < tau.size(); ++i) tau[i] = 3e-9 * std::sin(1e14 * q[i]);
    }
  } system;
  const double q[] = {1, 1}, v[] = {0, 0};
  for (const Method method : {Method::gauss_legendre_6, Method::radau_iia_5}) {
    IntegratorOptions options = fixed(method, 1e-3);
    options.relative_tolerance = options.absolute_tolerance = 1e-8;
    Integrator integrator(system, options);
    integrator.start(0, q, v);
    const IntegrationReport r = integrator.advance(1);
    EXPECT_EQ(r.status, Status::reached) << static_cast<int>(method) << " at " << r.time;
  }
}

TEST(Failures, NonFiniteStartIsRejected) {
  OpenSystem system(testing::pendulum({1, 1}));
  const double q[] = {1, 1}, v[] = {0, std::numeric_limits<double>::infinity()};
  for (const Method method : all_methods) {
    Integrator integrator(system, adaptive(method, 1e-6));
    integrator.start(0, q, v);
    const IntegrationReport r = integrator.advance(1);
    EXPECT_EQ(r.status, Status::not_finite);
    EXPECT_EQ(r.dof, 1);
    EXPECT_EQ(r.time, 0);
  }
}

TEST(Failures, TooManyTooSmallAndTooLargeStepsAreReported) {
  OpenSystem system(testing::pendulum({1, 1}));
  const double q[] = {1, 1}, v[] = {0, 0};
  IntegratorOptions few = adaptive(Method::dormand_prince_54, 1e-10);
  few.max_steps = 10;
  Integrator counted(system, few);
  counted.start(0, q, v);
  EXPECT_EQ(counted.advance(10).status, Status::too_many_steps);
  EXPECT_GT(counted.time(), 0);
  EXPECT_EQ(counted.statistics().steps, 10);

  IntegratorOptions coarse = adaptive(Method::dormand_prince_54, 1e-13);
  coarse.min_step = coarse.step = 0.2;
  Integrator small(system, coarse);
  small.start(0, q, v);
  EXPECT_EQ(small.advance(10).status, Status::step_too_small);

  Integrator wide(system, fixed(Method::gauss_legendre_6, 3.0));
  wide.start(0, q, v);
  EXPECT_EQ(wide.advance(10).status, Status::not_converged);
  EXPECT_EQ(wide.time(), 0);
}

TEST(Integrators, AllocateNothingAfterConstruction) {
  for (const Method method : all_methods) {
    Falling system(3);
    Integrator integrator(system, adaptive(method, 1e-8));
    const double q[] = {1, 2, 3}, v[] = {0, 0, 0};
    const long before = allocations_so_far();
    integrator.start(0, q, v);
    for (int i = 0; i < 4; ++i) static_cast<void>(integrator.advance(2));
    EXPECT_EQ(allocations_so_far(), before) << static_cast<int>(method);
  }
}

}  // namespace
}  // namespace ugoki::dynamics
