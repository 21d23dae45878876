// Nested scenarios on the command line: a run and an export of a nested project have the bits of the project that is flattened by hand.

#include <fstream>

#include "cli_fixture.h"

namespace ugoki::cli {
namespace {

constexpr const char* steps = "400";

/// A ball that is thrown, as an item of a scenario.
Json ball(const std::string& id, double x, double y) {
  return {
      {"id", id}, {"name", "Ball"}, {"mechanism", "ball"}, {"place", {{"x", x}, {"y", y}, {"z", 1}}}, {"control", {{"mode", "passive"}}}};
}
Json thrown(const std::string& id, const std::string& character, double time, double x, double y, const Json& velocity) {
  return {{"id", id}, {"type", "throw"}, {"time", time}, {"character", character}, {"from", {x, y, 1}}, {"velocity", velocity}};
}

class NestedCliTest : public CliTest {
 protected:
  /// Makes a project from a scenario. @return its path
  std::string project(const std::string& name, Json scenario) {
    scenario["duration"] = 2;
    scenario["name"] = "balls";
    const Json content = {{"scenario", std::move(scenario)}};
    does({"new", path(name + ".ugoki"), "--from", write(name + ".json", content.dump())});
    return path(name + ".ugoki");
  }
};

TEST_F(NestedCliTest, RunsAndExportsHaveTheBitsOfTheFlattenedProject) {
  const Json place = {{"x", 0.5}, {"y", -1}, {"z", 0}, {"heading", 0}};
  const std::string nested =
      project("nested", {{"version", 2},
                         {"characters", Json::array()},
                         {"scenarios",
                          {{{"id", "toss"},
                            {"name", "Toss"},
                            {"duration", 1},
                            {"characters", {ball("a", 0, 0), ball("b", 0.25, 0)}},
                            {"events", {thrown("e1", "a", 0.1, 0, 0, {0.7, 0.1, 2}), thrown("e2", "b", 0.1, 0.25, 0, {-0.6, 0, 2})}}}}},
                         {"instances",
                          {{{"id", "toss.1"}, {"name", "First"}, {"scenario", "toss"}, {"start", 0}},
                           {{"id", "toss.2"}, {"name", "Second"}, {"scenario", "toss"}, {"start", 0.25}, {"place", place}}}}});
  const std::string flat =
      project("flat", {{"version", 1},
                       {"characters", {ball("p", 0, 0), ball("q", 0.25, 0), ball("r", 0.5, -1), ball("s", 0.75, -1)}},
                       {"events",
                        {thrown("e1", "p", 0.1, 0, 0, {0.7, 0.1, 2}), thrown("e2", "q", 0.1, 0.25, 0, {-0.6, 0, 2}),
                         thrown("e3", "r", 0.35, 0.5, -1, {0.7, 0.1, 2}), thrown("e4", "s", 0.35, 0.75, -1, {-0.6, 0, 2})}}});
  const Json expected = json({"run", flat, "--steps", steps});
  EXPECT_EQ(json({"run", nested, "--steps", steps})["state_hash"], expected["state_hash"]);
  does({"export", nested, "--ugx", path("nested.ugx")});
  const Json exported = json({"run", path("nested.ugx"), "--steps", steps});
  EXPECT_EQ(exported["state_hash"], expected["state_hash"]);
  EXPECT_NE(json({"run", flat, "--steps", "200"})["state_hash"], expected["state_hash"]) << "the balls move";
}

TEST_F(NestedCliTest, ScenariosThatContainThemselvesAreRefused) {
  const Json content = {{"scenario",
                         {{"version", 2},
                          {"characters", Json::array()},
                          {"instances", {{{"id", "a"}, {"scenario", "loop"}}}},
                          {"scenarios", {{{"id", "loop"}, {"name", "Loop"}, {"instances", {{{"id", "b"}, {"scenario", "loop"}}}}}}}}}};
  fails({"new", path("loop.ugoki"), "--from", write("loop.json", content.dump())}, "Loop > Loop");
}

}  // namespace
}  // namespace ugoki::cli
