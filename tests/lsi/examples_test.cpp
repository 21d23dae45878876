// Runs the examples in examples/lsi/spatial, world, closed and motion: one circuit for each LSI of mathematics, rotations, mechanics,
// distances and motions. The circuit documents and tests the LSI. Other tests check impulses, and distances after a restore.

#include <cmath>
#include <filesystem>
#include <fstream>
#include <set>

#include "closed_world.h"
#include "ugoki/circuit/example.h"
#include "ugoki/lsi/payload.h"
#include "walker.h"

namespace ugoki::lsi {
namespace {

namespace fs = std::filesystem;

TEST(LsiExamples, EveryLsiHasAPassingExample) {
  const SmallWorld small;
  const ClosedWorld closed;
  const Walker walker;
  std::set<std::string> shown;
  for (const auto& [folder, world] : {std::pair{"spatial", small.world.get()}, std::pair{"world", small.world.get()},
                                      std::pair{"closed", closed.world.get()}, std::pair{"motion", walker.world.get()}}) {
    for (const fs::directory_entry& e : fs::directory_iterator(std::string(UGOKI_SOURCE_DIR) + "/examples/lsi/" + folder)) {
      const std::string location = e.path().filename().string();
      std::ifstream in(e.path());
      const Result<circuit::Example> example = circuit::read_example(std::string((std::istreambuf_iterator<char>(in)), {}), location);
      ASSERT_TRUE(example) << example.error().text();
      EXPECT_FALSE(example->doc.empty()) << location;
      const Result<void> checked = circuit::check_example(*example, standard_library(), location, world);
      EXPECT_TRUE(checked) << checked.error().text();
      for (const circuit::Instance& lsi : example->circuit.lsis)
        if (lsi.type == example->circuit.name) shown.insert(lsi.type);
    }
  }
  const std::set<std::string> groups = {"maths", "rotations and poses", "joint values", "mechanics", "collision", "motion"};
  for (const circuit::LsiClass& c : standard_library().classes())
    if (groups.contains(c.group)) EXPECT_TRUE(shown.contains(c.name)) << "no example shows '" << c.name << "'";
}

/// An event that sets the position and velocity of the ball at `time` [s].
ScheduledEvent put_ball(double time, const Vec3& p, const Vec3& v) {
  ScheduledEvent e;
  e.time = time;
  e.record.kind = EventKind::throwing;
  e.record.character = 1;
  e.record.a = p;
  e.record.b = v;
  return e;
}

/// A circuit without dynamics: only events change the state "now.state". `lsis` and `wires` are added to it.
circuit::Interpreter build(const SmallWorld& small, const std::string& lsis, const std::string& wires) {
  const auto c = circuit::read_circuit(
      R"({"version": 1, "name": "t", "inputs": [{"name": "live", "type": "event", "to": "event.live"}],
          "lsis": [{"id": "event", "type": "event"}, {"id": "now", "type": "status"}, )" +
      lsis + R"(], "wires": [{"from": "now.state", "to": "now.next"}, {"from": "event.events", "to": "now.events"}, )" + wires + "]}");
  EXPECT_TRUE(c) << (c ? "" : c.error().text());
  auto i = circuit::Interpreter::build(*c, standard_library(), small.world.get(), {.dt = 0.002});
  EXPECT_TRUE(i) << (i ? "" : i.error().text());
  return std::move(*i);
}

TEST(LsiExamples, ImpulseEqualsChangeOfMomentumWithRestitution) {
  const Vec3 v{0.7, 0, -2.5};
  const SmallWorld small({put_ball(0, {3, 0, 0.11}, v)});
  circuit::Interpreter i = build(small, R"({"id": "found", "type": "collision analysis"}, {"id": "it", "type": "collision force"})",
                                 R"({"from": "now.state", "to": "found.state"}, {"from": "now.state", "to": "it.state"},
                                    {"from": "found.contacts", "to": "it.contacts"})");
  for (int t = 0; t < 3; ++t) ASSERT_TRUE(i.tick());
  const Character& ball = small.world->characters()[1];
  const auto before = v_of(ball, i.find_output("now.state")->numbers().data());
  ASSERT_EQ(before[5], v.z) << "the throw did not set the velocity";
  Vec3 impulse;
  double restitution = -1;
  for (const ContactRecord& r : records<ContactRecord>(i.find_output("it.contacts")->bytes.data())) {
    if (r.point.system_a != 1) continue;
    impulse += 0.002 * r.force;
    restitution = r.point.restitution;
  }
  ASSERT_GE(restitution, 0) << "the ball does not touch the ground";
  const auto next = v_of(ball, i.find_output("it.next")->numbers().data());
  const double mass = small.ball->link(0).inertia.mass;
  EXPECT_NEAR(next[5], -restitution * v.z, 1e-12);
  EXPECT_NEAR(next[3], v.x, 1e-12) << "friction changed the tangential velocity";
  EXPECT_NEAR(impulse.z, mass * (next[5] - v.z), 1e-12);
  EXPECT_NEAR(impulse.x, 0, 1e-12);
}

TEST(LsiExamples, DistanceAfterRestoreHasSameBits) {
  std::vector<ScheduledEvent> path;
  for (int t = 0; t < 90; ++t) path.push_back(put_ball(0.002 * t, {3 * std::cos(0.05 * t), 3 * std::sin(0.05 * t), 0.5 + 0.01 * t}, {}));
  const SmallWorld small(path);
  for (const char* lsi : {R"({"id": "it", "type": "successive Gilbert",
                              "parameters": {"character": "character", "link": "foot left", "other": "ball.1", "other link": "ball"}})",
                          R"({"id": "it", "type": "closest pair", "parameters": {"character": "character", "other": "ball.1"}})"}) {
    const char* wire = R"({"from": "now.state", "to": "it.state"})";
    const auto run = [](circuit::Interpreter& on, int ticks) {
      EXPECT_EQ(on.run(static_cast<std::uint64_t>(ticks)), static_cast<std::uint64_t>(ticks));
      std::vector<double> all;
      for (const char* pin : {"it.distance", "it.a", "it.b"}) {
        const auto n = on.find_output(pin)->numbers();
        all.insert(all.end(), n.begin(), n.end());
      }
      return all;
    };
    circuit::Interpreter first = build(small, lsi, wire);
    const std::vector<double> early = run(first, 37);
    std::vector<std::byte> saved;
    first.save(saved);
    const std::vector<double> late = run(first, 50);
    EXPECT_NE(late, early) << "the distance does not change";
    circuit::Interpreter other = build(small, lsi, wire);
    ASSERT_TRUE(other.restore(saved));
    EXPECT_EQ(run(other, 50), late) << lsi;
  }
}

}  // namespace
}  // namespace ugoki::lsi
