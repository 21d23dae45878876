// The circuit of the FMU of a whole content, compared with the player.

#include "ugoki/publish/fmu_circuit.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>

#include "../content/fixture.h"
#include "ugoki/circuit/interpreter.h"
#include "ugoki/content/player.h"
#include "ugoki/lsi/standard_library.h"

namespace ugoki::publish {
namespace {

TEST(FmuCircuit, MovesAsThePlayerWithTheSamePush) {
  content::Scenario scenario = content::testing::make_scenario();
  scenario.characters[0].id = "hu.man";  // '.' separates LSI and pin
  for (auto& e : scenario.events)
    if (e.character == "human") e.character = "hu.man";
  scenario.camera.follow.clear();
  const auto bytes = content::generate(scenario, content::testing::make_resources());
  ASSERT_TRUE(bytes) << bytes.error().text();
  auto player = content::Player::open(*bytes, "park");
  ASSERT_TRUE(player);
  const auto content = content::read_executable(*bytes, "park");
  const auto circuit = make_fmu_circuit(*content, "park");
  ASSERT_TRUE(circuit) << circuit.error().text();
  const lsi::World world = content::make_world(*content);
  auto i = circuit::Interpreter::build(*circuit, lsi::standard_library(), &world, {.dt = content->step});
  ASSERT_TRUE(i) << i.error().text();
  const Vec3 force{40, -20, 10};
  const auto set_push = [&](const Vec3& f) {
    const auto bytes = i->find_circuit_input("hu_man:push");
    ASSERT_EQ(bytes.size(), sizeof f);
    std::memcpy(bytes.data(), &f, sizeof f);
  };
  for (int n = 0; n < 400; ++n) {
    if (n == 100) {
      player->push(0, 0, force, 50 * content->step);
      set_push(force);
    }
    if (n == 150) set_push({});
    ASSERT_TRUE(i->tick());  // its outputs have the state at the begin of the tick
    for (int c = 0; c < 2; ++c) {
      const auto q = i->find_circuit_output(c == 0 ? "hu_man:q" : "ball:q")->numbers();
      ASSERT_TRUE(std::equal(q.begin(), q.end(), player->q(c).begin())) << "step " << n << ", character " << c;
    }
    ASSERT_TRUE(player->step());
  }
  const auto position = i->find_circuit_output("ball:position")->numbers(), q = i->find_circuit_output("ball:q")->numbers();
  for (std::size_t k = 0; k < 3; ++k) EXPECT_EQ(position[k], q[k]);
  EXPECT_EQ(i->find_circuit_output("hu_man:measures")->numbers().size(), std::size_t{lsi::measure_count});
}

TEST(FmuCircuit, CircuitWithoutDynamicsIsRefused) {
  content::Scenario scenario = content::testing::make_scenario();
  const auto bytes = content::generate(scenario, content::testing::make_resources());
  auto content = content::read_executable(*bytes, "park");
  content->circuit = R"({"version": 2, "name": "x", "lsis": []})";
  const auto circuit = make_fmu_circuit(*content, "park");
  ASSERT_FALSE(circuit);
  EXPECT_NE(circuit.error().text().find("dynamics"), std::string::npos);
}

}  // namespace
}  // namespace ugoki::publish
