// The LSI "link dynamics" for open and closed link systems: agreement of its methods, loops that open and close while the circuit runs,
// saved states, robots with closed loops. (examples/lsi/closed compares a four-bar with its single equation of motion.)

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "allocation_count.h"
#include "closed_world.h"
#include "ugoki/dynamics/closed_reference.h"
#include "ugoki/files/files.h"
#include "ugoki/robot_formats/robot_file.h"

namespace ugoki::lsi {
namespace {

/// A circuit in which "link dynamics" moves the character `who`. The circuit's input `closed` is wired to the LSI.
Result<circuit::Interpreter> build(const World& world, const std::string& who, const std::string& parameters = "", double dt = 0.002) {
  const auto c = circuit::read_circuit(
      R"({"version": 1, "name": "t", "inputs": [{"name": "closed", "type": "scalar", "to": "it.closed"}],
          "lsis": [{"id": "now", "type": "status"}, {"id": "it", "type": "link dynamics", "parameters": {"character": ")" +
      who + "\"" + parameters + R"(}}], "wires": [{"from": "now.state", "to": "it.state"}, {"from": "it.next", "to": "now.next"}]})");
  if (!c) return fail(c.error());
  return circuit::Interpreter::build(*c, standard_library(), &world, {.dt = dt, .check_finite = true});
}

void set_closed(circuit::Interpreter& i, double closed) { std::memcpy(i.find_circuit_input("closed").data(), &closed, sizeof closed); }
double value(const circuit::Interpreter& i, const char* pin) { return i.find_output(pin)->numbers()[0]; }

TEST(LinkDynamics, MethodsAgreeAndConserveEnergy) {
  const ClosedWorld w;
  std::vector<double> angles;
  for (const char* method : {"Runge-Kutta 4", "Dormand-Prince 5(4)", "Gauss-Legendre 6", "Radau IIA 5"}) {
    auto i = build(*w.world, "four-bar", R"(, "method": ")" + std::string(method) + R"(", "tolerance": 1e-10)");
    ASSERT_TRUE(i) << i.error().text();
    set_closed(*i, 1);
    ASSERT_TRUE(i->tick());
    const double energy = value(*i, "it.energy");
    for (int k = 1; k < 500; ++k) {
      const long allocated = allocations_so_far();
      ASSERT_TRUE(i->tick()) << i->stopped()->text();
      EXPECT_EQ(allocations_so_far(), allocated) << method;
      ASSERT_LT(value(*i, "it.gap"), 1e-12) << method;
    }
    EXPECT_NEAR(value(*i, "it.energy"), energy, 1e-7) << method;
    angles.push_back(value(*i, "now.state"));
  }
  for (const double a : angles) EXPECT_NEAR(a, -4.256552387, 1e-6);  // rad; from integrating the single equation of motion of the crank
}

TEST(LinkDynamics, OpeningLoopKeepsEnergyAndClosingLoopLosesEnergy) {
  const ClosedWorld w;
  auto i = build(*w.world, "four-bar", R"(, "loop": "pin")");
  ASSERT_TRUE(i) << i.error().text();
  set_closed(*i, 1);
  i->run(50);
  const double energy = value(*i, "it.energy");
  const auto forces = i->find_output("it.loop forces")->numbers();
  EXPECT_TRUE(std::ranges::any_of(forces, [](double f) { return std::fabs(f) > 1; })) << "the pin carries no load";
  set_closed(*i, 0);
  i->run(5);
  EXPECT_NEAR(value(*i, "it.energy"), energy, 1e-6) << "opening a loop must not change the energy";
  for (const double f : i->find_output("it.loop forces")->numbers()) EXPECT_EQ(f, 0);
  set_closed(*i, 1);
  ASSERT_TRUE(i->tick());
  EXPECT_LT(value(*i, "it.energy"), energy) << "closing a loop must not add energy";
  EXPECT_LT(value(*i, "it.gap"), 1e-12);
}

TEST(LinkDynamics, RestoreAndResetGiveSameBits) {
  const ClosedWorld w;
  auto a = build(*w.world, "four-bar"), b = build(*w.world, "four-bar");
  ASSERT_TRUE(a && b);
  set_closed(*a, 1);
  a->run(300);
  std::vector<std::byte> saved, of_a, of_b;
  a->save(saved);
  a->run(300);
  ASSERT_TRUE(b->restore(saved));
  b->run(300);
  a->save(of_a);
  b->save(of_b);
  EXPECT_EQ(of_a, of_b);
  a->reset();
  set_closed(*a, 1);
  a->run(300);
  a->save(of_a);
  EXPECT_EQ(of_a, saved) << "a reset run must equal a new run";
}

/// General-purpose dynamics with closed loops. The crank turns through all its positions, including dead points.
TEST(LinkDynamics, GeneralDynamicsOfClosedLoopsGivesSameBitsFromEverySavedState) {
  const ClosedWorld w;
  const auto c = circuit::read_circuit(
      R"({"version": 1, "name": "t", "lsis": [{"id": "now", "type": "status"}, {"id": "touch", "type": "collision analysis"},
          {"id": "it", "type": "dynamics"}], "wires": [{"from": "now.state", "to": "touch.state"}, {"from": "now.state", "to": "it.state"},
          {"from": "touch.contacts", "to": "it.contacts"}, {"from": "it.next", "to": "now.next"}]})");
  ASSERT_TRUE(c) << c.error().text();
  const auto make = [&] { return circuit::Interpreter::build(*c, standard_library(), w.world.get(), {.dt = 0.002, .check_finite = true}); };
  auto a = make(), b = make();
  ASSERT_TRUE(a && b) << a.error().text();
  std::vector<std::vector<std::byte>> saved(60);
  double minimum = 1e9, maximum = -1e9;
  for (std::vector<std::byte>& s : saved) {
    for (int k = 0; k < 23; ++k, minimum = std::min(minimum, value(*a, "now.state")), maximum = std::max(maximum, value(*a, "now.state")))
      ASSERT_TRUE(a->tick()) << a->stopped()->text();
    a->save(s);
  }
  EXPECT_GT(maximum - minimum, 3.2) << "the crank must pass the dead points, where bars are in line";
  std::vector<std::byte> repeated;
  for (std::size_t i = saved.size() - 1; i-- > 0;) {  // backwards: state kept from later times would change the bits
    ASSERT_TRUE(b->restore(saved[i]));
    b->run(23);
    b->save(repeated);
    EXPECT_EQ(repeated, saved[i + 1]) << i;
  }
}

TEST(LinkDynamics, OtherCharactersAreUnchangedAndWrongParametersRefused) {
  const ClosedWorld w;
  auto i = build(*w.world, "four-bar");
  ASSERT_TRUE(i);
  i->run(10);
  const Character& ball = w.world->characters()[1];
  const auto q = q_of(ball, i->find_output("now.state")->numbers().data());
  EXPECT_TRUE(std::ranges::equal(q, ball.q0));
  const auto wrong = build(*w.world, "four-bar", R"(, "loop": "nobody")");
  ASSERT_FALSE(wrong);
  EXPECT_NE(wrong.error().text().find("Use one of: pin"), std::string::npos) << wrong.error().text();
}

/// A mechanism without loops.
TEST(LinkDynamics, OpenSystemFalls) {
  const ClosedWorld w;
  auto i = build(*w.world, "ball");
  ASSERT_TRUE(i) << i.error().text();
  i->run(500);
  const auto q = q_of(w.world->characters()[1], i->find_output("now.state")->numbers().data());
  EXPECT_NEAR(q[1], -0.5 * 9.81, 1e-9);
}

TEST(LinkDynamics, SharedClosedRobotsSwingWithClosedLoops) {
  const std::string folder = std::string(UGOKI_SHARED_DATA) + "/mechanism/closed_loop";
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << "the shared data are missing (" << folder << ")";
  int count = 0;
  for (const auto& e : std::filesystem::recursive_directory_iterator(folder + "/example-parallel-robots")) {
    const std::string path = e.path().string();
    const std::string yaml = std::filesystem::path(path).replace_extension(".yaml").string();
    if (e.path().extension() != ".urdf" || !std::filesystem::exists(yaml)) continue;
    robot_formats::RobotOptions options;
    options.read_asset = [](const std::string& asset) { return files::read_file(asset); };
    options.loops = robot_formats::SideFile{yaml, files::read_file(yaml).value_or("")};
    const auto robot = robot_formats::read_robot_file(files::read_file(path).value_or(""), path, options);
    ASSERT_TRUE(robot) << path;
    CharacterSpec spec;
    spec.id = "robot";
    spec.mechanism = robot->mechanism;
    spec.q0 = robot->mechanism->neutral();
    dynamics::ClosedWorkspace cw(*spec.mechanism);
    if (!spec.mechanism->has_loops() || !assemble(*spec.mechanism, spec.q0, cw).closed) continue;
    const World world({spec}, {}, {0, 0, -9.81}, collision::Ground{});
    auto i = build(world, "robot", "", 0.001);
    ASSERT_TRUE(i) << path << i.error().text();
    set_closed(*i, 1);
    double gap = 0;
    for (int k = 0; k < 300; ++k) {
      ASSERT_TRUE(i->tick()) << path << ": " << i->stopped()->text();
      gap = std::max(gap, value(*i, "it.gap"));
    }
    EXPECT_LT(gap, 1e-9) << path;
    ++count;
  }
  EXPECT_GE(count, 5);
}

}  // namespace
}  // namespace ugoki::lsi
