// The shared robots without actuation: with a floating base they fall onto the ground, with a fixed base they swing.

#include <gtest/gtest.h>

#include <cmath>

#include "robot_data.h"
#include "ugoki/collision/scene.h"
#include "ugoki/contact/guarded_step.h"
#include "ugoki/dynamics/closed_reference.h"
#include "ugoki/dynamics/loop_closure.h"
#include "ugoki/mechanism/state.h"
#include "ugoki/robot_formats/robot_file.h"

namespace ugoki::robot_formats {
namespace {

/// Results of one simulation.
struct Fall {
  contact::StepStatus status = contact::StepStatus::ok;
  double rise = 0;  ///< maximum increase of the total energy, divided by the weight, m
  double gap = 0;   ///< maximum gap of the loops, m | rad
};

Fall fall(const MechanismPtr& m, double dt, double seconds) {
  const bool free = m->link(0).joint.type == JointType::floating;
  const collision::Scene scene({m}, {.height = free ? 0.0 : -1e9});
  collision::Workspace workspace(scene);
  contact::Stepper stepper({m}, {});
  contact::GuardedStep guard(scene, stepper);
  State s(*m);
  if (m->has_loops()) {
    dynamics::ClosedWorkspace cw(*m);
    (void)assemble(*m, s.q, cw);
  }
  std::vector<Pose> poses(static_cast<std::size_t>(m->link_count()));
  std::vector<collision::ContactPoint> contacts;
  const auto find = [&] {
    calc_poses(*m, s.q, poses);
    const std::span<const Pose> all[] = {poses};
    collision::find_contacts(scene, all, 0.02, workspace, contacts);
  };
  const auto of_ground = [](const collision::ContactPoint& c) { return c.system_a < 0 || c.system_b < 0; };
  for (find(); free && std::ranges::any_of(contacts, of_ground); find()) s.q[2] += 0.25;
  contact::StepSystem system{s.q, s.v, s.tau, s.external, {}, {}};
  dynamics::Workspace ws(*m);
  Fall out;
  double begin = 0;
  for (int i = 0; i * dt < seconds; ++i) {
    find();
    const contact::StepReport report = guard.step(std::span(&system, 1), contacts, dt);
    out.status = report.status;
    if (report.status != contact::StepStatus::ok) return out;
    out.gap = std::max(out.gap, report.loop_gap);
    dynamics::update_kinematics(*m, s.q, s.v, ws);
    const double energy = dynamics::kinetic_energy(*m, ws) + dynamics::potential_energy(*m, ws, {0, 0, -9.81});
    if (i == 0) begin = energy;
    out.rise = std::max(out.rise, (energy - begin) / (9.81 * m->mass()));
  }
  return out;
}

void check_all_robots(double seconds, double max_rise) {
  constexpr double dt = 0.002;
  int falls = 0;
  for (const char* ending : {".urdf", ".sdf", ".xml"})
    for (const std::string& path : robot_files(ending))
      for (const Base base : {Base::fixed, Base::floating}) {
        if (base == Base::fixed && !path.ends_with(".urdf")) continue;  // SDF and MJCF files specify the base themselves
        RobotOptions options = options_for(path);
        if (path.ends_with(".urdf")) options.base = base;
        const Result<RobotModel> model = read_robot_file(load_robot(path), path, options);
        if (!model) continue;  // skip files that only other files include, and files that readers refuse
        const Fall f = fall(model->mechanism, dt, seconds);
        const std::string which = path + (base == Base::fixed ? ", fixed base" : "");
        EXPECT_EQ(f.status, contact::StepStatus::ok) << which;
        EXPECT_LT(f.rise, max_rise) << which;
        EXPECT_LT(f.gap, 0.01) << which;
        ++falls;
      }
  EXPECT_GT(falls, 50);
}

// The neutral position of cassie_v2 is beyond the limits of its feet, which pass a dead point of their four-bar linkages while they recover.
TEST(FallingRobots, RecoveryFromLimitsAtDeadPointsAddsNoEnergyAtAnyStep) {
  NEEDS_ROBOT_DATA();
  const std::string path = robot_folder() + "closed_loop/cassie_sdf/cassie_v2.sdf";
  const Result<RobotModel> model = read_robot_file(load_robot(path), path, options_for(path));
  ASSERT_TRUE(model.has_value()) << path;
  for (const double dt : {0.0005, 0.0008, 0.0012, 0.0015, 0.0021}) {
    const Fall f = fall(model->mechanism, dt, 0.22);
    EXPECT_EQ(f.status, contact::StepStatus::ok) << dt;
    EXPECT_LT(f.rise, 0.002) << dt;
    EXPECT_LT(f.gap, 1e-6) << dt;
  }
}

TEST(FallingRobots, EnergyAndLoopGapsStayBounded) {
  NEEDS_ROBOT_DATA();
  check_all_robots(0.6, 0.03);
}
TEST(Slow_FallingRobots, EnergyAndLoopGapsStayBoundedForThreeSeconds) {
  NEEDS_ROBOT_DATA();
  check_all_robots(3, 0.03);
}

}  // namespace
}  // namespace ugoki::robot_formats
