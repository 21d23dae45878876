// Tests of the service for the wiring editor: LSI classes, values of the running circuit, invalid circuits, breakpoints. The interpreter's
// process runs the real player.

#include <gtest/gtest.h>
#include <unistd.h>

#include <csignal>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "../content/fixture.h"
#include "page.h"
#include "ugoki/circuit/circuit.h"
#include "ugoki/circuit/signal_lsis.h"
#include "ugoki/studio/circuit_watch.h"
#include "ugoki/studio/studio.h"

namespace ugoki::studio {
namespace {

using nlohmann::json;
using test::Page;

/// A circuit with a clock whose time is multiplied by a gain of 3; 100 ticks a second.
circuit::Interpreter small_circuit(const circuit::Library& library) {
  const Result<circuit::Circuit> c = circuit::read_circuit(R"({"version": 1, "name": "small",
    "lsis": [{"id": "t", "type": "clock"}, {"id": "g", "type": "gain", "parameters": {"gain": 3}}], "wires": [{"from": "t.time", "to": "g.in"}]})");
  Result<circuit::Interpreter> built = circuit::Interpreter::build(*c, library, nullptr, {.dt = 0.01});
  EXPECT_TRUE(built);
  return std::move(*built);
}

const circuit::Library& signal_library() {
  static const circuit::Library library = [] {
    circuit::Library all;
    circuit::add_signal_lsis(all);
    return all;
  }();
  return library;
}

TEST(CircuitWatch, ReportsValuesCurvesAndTimesOfWatchedOutputs) {
  circuit::Interpreter i = small_circuit(signal_library());
  CircuitWatch watch;
  watch.attach(&i);
  EXPECT_FALSE(watch.dirty()) << "no output is watched";
  watch.set({{"g.out", "nobody.out"}, {"t.time"}, true});
  EXPECT_TRUE(watch.dirty());
  (void)watch.report(1);
  EXPECT_FALSE(watch.dirty());
  for (int k = 0; k < 5; ++k) {
    ASSERT_TRUE(i.tick());
    watch.stepped();
  }
  const json event = json::parse(watch.report(1.05));
  EXPECT_EQ(event["event"], "values");
  EXPECT_NEAR(event["time"], 0.05, 1e-9);
  ASSERT_EQ(event["pins"].size(), 1u) << event.dump();
  EXPECT_EQ(event["pins"][0][0], "g.out");
  EXPECT_NEAR(event["pins"][0][2][0], 3 * 0.04, 1e-6);  // value after the last tick, whose time is 0.04 s
  ASSERT_EQ(event["probes"].size(), 1u);
  EXPECT_EQ(event["probes"][0][1].size(), 5u);
  EXPECT_NEAR(event["probes"][0][2][0][4], 0.04, 1e-6);
  ASSERT_EQ(event["times"].size(), 2u);
  double sum = 0;
  for (const json& t : event["times"]) sum += t[1].get<double>();
  EXPECT_NEAR(sum, event["tick_us"].get<double>(), 1e-3 * (1 + sum));
  EXPECT_FALSE(json::parse(watch.report(1.1)).contains("probes")) << "each sample must be received once";
}

TEST(CircuitWatch, DetachedCircuitIsNotReported) {
  CircuitWatch watch;
  {
    circuit::Interpreter i = small_circuit(signal_library());
    watch.attach(&i);
    watch.set({{"g.out"}, {}, true});
    watch.attach(nullptr);
  }
  watch.changed();
  EXPECT_FALSE(watch.dirty());
}

class CircuitStudioTest : public testing::Test {
 protected:
  void SetUp() override {
    std::string name = (std::filesystem::temp_directory_path() / "ugoki-circuit-XXXXXX").string();
    ASSERT_NE(::mkdtemp(name.data()), nullptr);
    folder_ = name;
    start(project::Project::create(folder_ + "/park.ugoki", content::testing::make_scenario(), content::testing::make_resources()));
  }
  void restart(const std::string& name) {
    studio_.reset();
    start(project::Project::open(folder_ + name));
  }
  void start(Result<project::Project> project) {
    ASSERT_TRUE(project) << project.error().text();
    StudioOptions options;
    options.library_path = folder_ + "/library.db";
    options.interpreter = {"/proc/self/exe", {"interpret"}};
    Result<std::unique_ptr<Studio>> started = Studio::start(options, std::move(*project));
    ASSERT_TRUE(started) << started.error().text();
    studio_ = std::move(*started);
  }
  void TearDown() override {
    studio_.reset();
    std::filesystem::remove_all(folder_);
  }
  Page page() { return {studio_->port(), studio_->token()}; }
  static json edit(const json& changes) {
    return {{"op", "command"}, {"command", {{"type", "circuit.edit"}, {"label", "Edit"}, {"changes", changes}}}};
  }
  static json put(const std::string& list, json item) { return {{"list", list}, {"put", std::move(item)}}; }
  /// Changes that add a clock `k` and a gain `g` whose input is the time of the clock.
  static json clock_and_gain() {
    return json::array({put("lsis", {{"id", "k"}, {"type", "clock"}}), put("lsis", {{"id", "g"}, {"type", "gain"}}),
                        put("wires", {{"from", "k.time"}, {"to", "g.in"}})});
  }

  std::string folder_;
  std::unique_ptr<Studio> studio_;
};

TEST_F(CircuitStudioTest, HelloContainsGeneratedCircuitAndLsis) {
  Page p = page();
  json hello = p.ask({{"op", "hello"}});
  EXPECT_TRUE(hello["document"]["circuit"].is_null());
  EXPECT_EQ(hello["generated_circuit"]["name"], "execution");
  if (!hello.contains("lsis")) hello["lsis"] = p.event("lsis");
  bool dynamics = false;
  for (const json& c : hello["lsis"]["classes"]) dynamics = dynamics || (c["name"] == "dynamics" && c["inputs"].size() >= 4);
  EXPECT_TRUE(dynamics);
  EXPECT_EQ(hello["lsis"]["pin_types"][0]["name"], "scalar");
}

TEST_F(CircuitStudioTest, CircuitEditIsPlayedWatchedAndUndone) {
  Page p = page();
  (void)p.ask({{"op", "hello"}});
  ASSERT_EQ(p.ask(edit(clock_and_gain()))["ok"], true);
  ASSERT_EQ(p.ask({{"op", "watch"}, {"pins", {"g.out"}}, {"probes", {"k.time"}}, {"timing", true}})["ok"], true);
  ASSERT_EQ(p.ask({{"op", "mode"}, {"mode", "simulate"}})["ok"], true);
  ASSERT_EQ(p.ask({{"op", "play"}})["ok"], true);
  const json seen = p.event("values", [](const json& e) { return e["time"] > 0.2 && e.contains("probes") && e.contains("times"); });
  ASSERT_FALSE(seen.is_null());
  EXPECT_EQ(seen["pins"][0][0], "g.out");
  EXPECT_NEAR(seen["pins"][0][2][0].get<double>(), seen["time"].get<double>(), 0.01);
  (void)p.ask({{"op", "pause"}});
  const json undone = p.ask({{"op", "undo"}});
  EXPECT_EQ(undone["label"], "Edit");
  const json document = p.ask({{"op", "hello"}});
  EXPECT_TRUE(document["document"]["circuit"].is_null());
}

TEST_F(CircuitStudioTest, KeysReachTheCircuitAndAreReplayedAfterAnEdit) {
  Page p = page();
  const json hello = p.ask({{"op", "hello"}});
  json devices = hello.contains("devices") ? hello["devices"] : p.event("devices");
  EXPECT_TRUE(devices["keyboard"].empty());
  EXPECT_EQ(devices["mouse"], false);
  ASSERT_EQ(p.ask(edit(json::array({put("lsis", {{"id", "w"}, {"type", "keyboard"}, {"parameters", {{"key", "KeyW"}}}}),
                                    put("lsis", {{"id", "m"}, {"type", "mouse"}}), put("lsis", {{"id", "n"}, {"type", "counter"}}),
                                    put("wires", {{"from", "w.pressed"}, {"to", "n.in"}})})))["ok"],
            true);
  devices = p.event("devices");
  EXPECT_EQ(devices["keyboard"], json::array({"KeyW"}));
  EXPECT_EQ(devices["mouse"], true);
  EXPECT_EQ(p.ask({{"op", "hello"}})["devices"], devices);
  ASSERT_EQ(p.ask({{"op", "watch"}, {"pins", {"n.out", "w.pressed", "m.x"}}, {"probes", json::array()}, {"timing", false}})["ok"], true);
  ASSERT_EQ(p.ask({{"op", "mode"}, {"mode", "simulate"}})["ok"], true);
  ASSERT_EQ(p.ask({{"op", "play"}})["ok"], true);
  const auto pin = [](const json& e, std::size_t k) { return e["pins"][k][2][0].get<double>(); };
  const auto send = [&](const json& message) { p.socket().send_text(message.dump()); };
  send({{"op", "input"}, {"keyboard", {"KeyW", "KeyQ"}}, {"mouse", {{"x", 0.25}}}});
  ASSERT_FALSE(p.event("values", [&](const json& e) { return pin(e, 0) == 1 && pin(e, 1) == 1 && pin(e, 2) == 0.25; }).is_null());
  send({{"op", "input"}, {"keyboard", json::array()}});
  ASSERT_FALSE(p.event("values", [&](const json& e) { return pin(e, 0) == 1 && pin(e, 1) == 0; }).is_null());
  ASSERT_EQ(p.ask({{"op", "pause"}})["ok"], true);
  const double head = p.ask({{"op", "hello"}})["transport"]["simulated"].get<double>();
  // After an edit that does not affect the counter, the content is recomputed up to the shown time with the recorded key press.
  ASSERT_EQ(p.ask(edit(json::array({put("lsis", {{"id", "k"}, {"type", "clock"}})})))["ok"], true);
  const json again = p.event("values", [&](const json& e) { return e["time"].get<double>() > head - 0.01; });
  ASSERT_FALSE(again.is_null());
  EXPECT_EQ(pin(again, 0), 1);

  const json refused = p.ask({{"op", "input"}, {"keyboard", {"no key"}}});
  EXPECT_EQ(refused["ok"], false);
  EXPECT_EQ(refused["error"]["problems"][0]["location"], "input/keyboard/0");
}

TEST_F(CircuitStudioTest, KeysAreReleasedWhenThePageCloses) {
  Page p = page();
  (void)p.ask({{"op", "hello"}});
  ASSERT_EQ(p.ask(edit(json::array({put("lsis", {{"id", "w"}, {"type", "keyboard"}, {"parameters", {{"key", "KeyW"}}}})})))["ok"], true);
  ASSERT_EQ(p.ask({{"op", "watch"}, {"pins", {"w.pressed"}}, {"probes", json::array()}, {"timing", false}})["ok"], true);
  ASSERT_EQ(p.ask({{"op", "mode"}, {"mode", "simulate"}})["ok"], true);
  ASSERT_EQ(p.ask({{"op", "play"}})["ok"], true);
  const auto pressed = [](double x) { return [x](const json& e) { return e["pins"][0][2][0] == x; }; };
  {
    Page other = page();
    other.socket().send_text(json{{"op", "input"}, {"keyboard", {"KeyW"}}}.dump());
    ASSERT_FALSE(p.event("values", pressed(1)).is_null());
  }
  EXPECT_FALSE(p.event("values", pressed(0)).is_null());
}

TEST_F(CircuitStudioTest, CircuitEditSendsOnlyTheChanges) {
  Page p = page(), other = page();
  const json before = p.ask({{"op", "hello"}});
  (void)other.ask({{"op", "hello"}});
  ASSERT_EQ(p.ask(edit(clock_and_gain()))["ok"], true);
  const json received = other.event("edited");
  ASSERT_FALSE(received.is_null());
  EXPECT_EQ(received["from"], before["revision"]);
  EXPECT_GT(received["revision"], received["from"]);
  EXPECT_EQ(received["changes"], clock_and_gain());
  EXPECT_EQ(received["undo_label"], "Edit");
  EXPECT_FALSE(received.contains("document"));
  (void)p.ask({{"op", "undo"}});
  EXPECT_TRUE(other.event("document")["document"]["circuit"].is_null()) << "an undo sends the whole document";
}

TEST_F(CircuitStudioTest, InvalidCircuitReportsProblemsAndRejectsSimulate) {
  Page p = page();
  (void)p.ask({{"op", "hello"}});
  json changes = clock_and_gain();
  changes.push_back(put("lsis", {{"id", "sum"}, {"type", "add"}}));
  changes.push_back(put("wires", {{"from", "sum.out"}, {"to", "sum.a"}}));
  changes.push_back(put("wires", {{"from", "g.out"}, {"to", "sum.b"}}));
  ASSERT_EQ(p.ask(edit(changes))["ok"], true) << "an invalid circuit must be accepted as an edit";
  const json received = p.event("circuit");
  ASSERT_FALSE(received.is_null());
  EXPECT_NE(received["problems"][0]["message"].get<std::string>().find("sum.out -> sum.a"), std::string::npos) << received.dump();
  const json refused = p.ask({{"op", "mode"}, {"mode", "simulate"}});
  EXPECT_EQ(refused["ok"], false);
  EXPECT_EQ(refused["error"]["problems"], received["problems"]);
  EXPECT_EQ(p.ask({{"op", "hello"}})["circuit_problems"], received["problems"]);
  EXPECT_EQ(p.ask({{"op", "seek"}, {"time", 1}})["ok"], true) << "edit mode must still show the tracks";

  ASSERT_EQ(p.ask(edit(json::array({{{"list", "lsis"}, {"take", "sum"}},
                                    {{"list", "wires"}, {"take", {{"from", "sum.out"}, {"to", "sum.a"}}}},
                                    {{"list", "wires"}, {"take", {{"from", "g.out"}, {"to", "sum.b"}}}}})))["ok"],
            true);
  EXPECT_TRUE(p.event("circuit")["problems"].empty());
  EXPECT_EQ(p.ask({{"op", "mode"}, {"mode", "simulate"}})["ok"], true);
}

TEST_F(CircuitStudioTest, LateReplyAboutUndoneCircuitDoesNotPause) {
  Page p = page();
  (void)p.ask({{"op", "hello"}});
  ASSERT_EQ(p.ask(edit(clock_and_gain()))["ok"], true);
  ASSERT_EQ(p.ask({{"op", "mode"}, {"mode", "simulate"}})["ok"], true);
  ASSERT_EQ(::kill(studio_->interpreter_pid(), SIGSTOP), 0);  // the interpreter does not answer until SIGCONT
  const json invalid = edit(json::array({put("wires", {{"from", "g.out"}, {"to", "sum.b"}}), put("lsis", {{"id", "sum"}, {"type", "add"}}),
                                         put("wires", {{"from", "sum.out"}, {"to", "sum.a"}})}));
  ASSERT_EQ(p.ask(invalid)["ok"], true);
  ASSERT_EQ(p.ask({{"op", "undo"}})["ok"], true);
  const int play = p.post({{"op", "play"}});
  ASSERT_EQ(p.ask({{"op", "hello"}})["ok"], true) << "its reply shows that all requests were forwarded";
  ASSERT_EQ(::kill(studio_->interpreter_pid(), SIGCONT), 0);
  ASSERT_EQ(p.reply(play)["ok"], true);
  EXPECT_FALSE(p.event("transport", [](const json& e) { return e["playing"] == true && e["simulated"] > 0.3; }).is_null());
  for (const json& e : p.events)
    if (e["event"] == "circuit") EXPECT_TRUE(e["problems"].empty()) << "problems of the undone circuit: " << e.dump();
}

TEST_F(CircuitStudioTest, MovingAnLsiDoesNotRestartTheSimulation) {
  Page p = page();
  (void)p.ask({{"op", "hello"}});
  ASSERT_EQ(p.ask(edit(clock_and_gain()))["ok"], true);
  ASSERT_EQ(p.ask({{"op", "mode"}, {"mode", "simulate"}})["ok"], true);
  ASSERT_EQ(p.ask({{"op", "play"}})["ok"], true);
  ASSERT_FALSE(p.event("transport", [](const json& e) { return e["simulated"] > 0.1; }).is_null());
  (void)p.ask({{"op", "pause"}});
  ASSERT_EQ(p.ask(edit(json::array({put("lsis", {{"id", "g"}, {"type", "gain"}, {"note", "doubles"}, {"at", {300, 40}}}),
                                    put("notes", {{"id", "n"}, {"text", "hello"}, {"at", {0, 0}}})})))["ok"],
            true);
  (void)p.ask({{"op", "watch"}, {"pins", {"k.time"}}, {"probes", json::array()}, {"timing", false}});
  const json now = p.event("values");
  EXPECT_GT(now["time"].get<double>(), 0.05) << "the simulation must not start again at 0";
}

TEST_F(CircuitStudioTest, PlayStopsAtBreakpointAndContinues) {
  Page p = page(), other = page();
  const json hello = p.ask({{"op", "hello"}});
  EXPECT_EQ(hello["breakpoints"], json::array());
  const double dt = hello["document"]["step"];
  ASSERT_EQ(p.ask(edit(clock_and_gain()))["ok"], true);
  const auto set = [&](const json& list) { return p.ask({{"op", "breakpoints"}, {"list", list}}); };
  const json late = {{"condition", "k.time > 0.3"}};
  ASSERT_EQ(set({late, {{"condition", "g.out > 0.1"}, {"on", false}}})["ok"], true);
  const json received = other.event("breakpoints");
  ASSERT_EQ(received["list"].size(), 2u) << received.dump();
  EXPECT_EQ(received["list"][0], json({{"condition", "k.time > 0.3"}, {"pin", "k.time"}, {"component", 0}, {"on", true}}));
  EXPECT_EQ(received["list"][1]["on"], false);
  ASSERT_EQ(p.ask({{"op", "mode"}, {"mode", "simulate"}})["ok"], true);
  ASSERT_EQ(p.ask({{"op", "play"}})["ok"], true);

  const auto check = [&](const json& hit, double limit) {  // the hit must be the first tick whose time exceeds `limit` [s]
    ASSERT_FALSE(hit.is_null());
    const auto tick = static_cast<std::uint64_t>(limit / dt + 1e-6) + 1;
    EXPECT_EQ(hit["tick"], tick) << hit.dump();
    EXPECT_NEAR(hit["value"].get<double>(), static_cast<double>(tick) * dt, 1e-9);
    EXPECT_NEAR(hit["time"].get<double>(), static_cast<double>(tick + 1) * dt, 1e-9);
  };
  const json first = p.event("breakpoint");
  check(first, 0.3);
  EXPECT_EQ(first["condition"], "k.time > 0.3");
  EXPECT_EQ(first["pin"], "k.time");
  const auto transport = [&] { return p.ask({{"op", "hello"}})["transport"]; };
  EXPECT_EQ(transport()["playing"], false);
  EXPECT_EQ(transport()["time"], first["time"]);
  EXPECT_EQ(transport()["simulated"], first["time"]);

  ASSERT_EQ(p.ask({{"op", "play"}})["ok"], true) << "play must continue after a breakpoint";
  ASSERT_FALSE(p.event("transport", [&](const json& e) { return e["playing"] == true && e["time"] > 0.6; }).is_null());
  ASSERT_EQ(p.ask({{"op", "pause"}})["ok"], true);

  // Recorded steps are recomputed: a breakpoint that is set after the recording is met too.
  ASSERT_EQ(p.ask({{"op", "seek"}, {"time", 0.1}})["ok"], true);
  ASSERT_EQ(set({late, {{"condition", "g.out > 0.2"}}, {{"condition", "nobody.out > 1"}}})["ok"], true);
  EXPECT_FALSE(p.event("log", [](const json& e) {
                  return e["text"].get<std::string>().contains("'nobody.out > 1' does not fit the circuit");
                }).is_null());
  ASSERT_EQ(p.ask({{"op", "play"}})["ok"], true);
  check(p.event("breakpoint"), 0.2);

  // Single ticks continue from the breakpoint.
  const double at = transport()["time"];
  ASSERT_EQ(p.ask({{"op", "step"}, {"ticks", 1}})["ok"], true);
  EXPECT_NEAR(transport()["time"].get<double>(), at + dt, 1e-9);
  EXPECT_NEAR(transport()["simulated"].get<double>(), at + dt, 1e-9);

  // Without breakpoints, playing does not stop.
  ASSERT_EQ(set(json::array())["ok"], true);
  ASSERT_EQ(p.ask({{"op", "restart"}})["ok"], true);
  ASSERT_EQ(p.ask({{"op", "play"}})["ok"], true);
  EXPECT_FALSE(p.event("transport", [&](const json& e) { return e["playing"] == true && e["time"] > 0.6; }).is_null());
}

TEST_F(CircuitStudioTest, BreakpointsAreStoredWithTheProjectAndItsCopy) {
  const json list = {{{"condition", "k.time > 0.3"}}, {{"condition", "g.out[0] < 0"}, {"on", false}}};
  json received;
  {
    Page p = page();
    (void)p.ask({{"op", "hello"}});
    ASSERT_EQ(p.ask(edit(clock_and_gain()))["ok"], true);
    ASSERT_EQ(p.ask({{"op", "breakpoints"}, {"list", list}})["ok"], true);
    received = p.ask({{"op", "hello"}})["breakpoints"];
    ASSERT_EQ(received.size(), 2u);
    EXPECT_EQ(p.ask({{"op", "save"}, {"path", folder_ + "/copy.ugoki"}})["ok"], true);
  }
  for (const char* name : {"/park.ugoki", "/copy.ugoki"}) {
    restart(name);
    Page p = page();
    EXPECT_EQ(p.ask({{"op", "hello"}})["breakpoints"], received) << name;
    ASSERT_EQ(p.ask({{"op", "mode"}, {"mode", "simulate"}})["ok"], true);
    ASSERT_EQ(p.ask({{"op", "play"}})["ok"], true);
    EXPECT_EQ(p.event("breakpoint")["condition"], "k.time > 0.3");
    ASSERT_EQ(p.ask({{"op", "breakpoints"}, {"list", json::array()}})["ok"], true);
  }
  restart("/park.ugoki");
  EXPECT_EQ(page().ask({{"op", "hello"}})["breakpoints"], json::array());
}

TEST_F(CircuitStudioTest, InvalidStoredBreakpointsAreIgnored) {
  studio_.reset();
  for (const char* text : {"no list", "{}", R"([{"condition": "k.time ? 1"}])", "[1]"}) {
    {
      Result<project::Project> project = project::Project::open(folder_ + "/park.ugoki");
      ASSERT_TRUE(project);
      ASSERT_TRUE(project->keep("breakpoints", text));
      EXPECT_EQ(*project->kept("breakpoints"), text);
      EXPECT_FALSE(project->unsaved());
      EXPECT_FALSE(project->can_undo());
    }
    restart("/park.ugoki");
    EXPECT_EQ(page().ask({{"op", "hello"}})["breakpoints"], json::array()) << text;
    studio_.reset();
  }
}

TEST_F(CircuitStudioTest, ReplayedKeyMeetsBreakpointAtTheSameTick) {
  Page p = page();
  (void)p.ask({{"op", "hello"}});
  ASSERT_EQ(p.ask(edit(json::array({put("lsis", {{"id", "w"}, {"type", "keyboard"}, {"parameters", {{"key", "KeyW"}}}}),
                                    put("lsis", {{"id", "n"}, {"type", "counter"}}),
                                    put("wires", {{"from", "w.pressed"}, {"to", "n.in"}})})))["ok"],
            true);
  const json list = {{{"condition", "n.out becomes true"}}};
  ASSERT_EQ(p.ask({{"op", "breakpoints"}, {"list", list}})["ok"], true);
  ASSERT_EQ(p.ask({{"op", "mode"}, {"mode", "simulate"}})["ok"], true);
  ASSERT_EQ(p.ask({{"op", "play"}})["ok"], true);
  ASSERT_FALSE(p.event("transport", [](const json& e) { return e["time"] > 0.1; }).is_null());
  p.socket().send_text(json{{"op", "input"}, {"keyboard", {"KeyW"}}}.dump());
  const json first = p.event("breakpoint");
  ASSERT_FALSE(first.is_null());
  p.socket().send_text(json{{"op", "input"}, {"keyboard", json::array()}}.dump());  // released: only the recorded key can press it again
  ASSERT_EQ(p.ask({{"op", "seek"}, {"time", 0}})["ok"], true);
  ASSERT_EQ(p.ask({{"op", "play"}})["ok"], true);
  const json again = p.event("breakpoint");
  ASSERT_FALSE(again.is_null());
  EXPECT_EQ(again["tick"], first["tick"]);
}

TEST_F(CircuitStudioTest, ConditionTrueAtStartIsNoHitAfterRestartOrSeek) {
  Page p = page();
  (void)p.ask({{"op", "hello"}});
  ASSERT_EQ(p.ask(edit(clock_and_gain()))["ok"], true);
  const json list = {{{"condition", "k.time < 0.1"}}};
  ASSERT_EQ(p.ask({{"op", "breakpoints"}, {"list", list}})["ok"], true);
  ASSERT_EQ(p.ask({{"op", "mode"}, {"mode", "simulate"}})["ok"], true);
  for (const json& back : {json{{"op", "pause"}}, json{{"op", "restart"}}, json{{"op", "seek"}, {"time", 0}}}) {
    ASSERT_EQ(p.ask(back)["ok"], true);
    ASSERT_EQ(p.ask({{"op", "play"}})["ok"], true);
    const json moved =
        p.event("transport", [](const json& e) { return e["time"] > 0.2 || (e["playing"] == false && e["status"] == "paused"); });
    EXPECT_EQ(moved["playing"], true) << back.dump() << moved.dump();
    ASSERT_EQ(p.ask({{"op", "pause"}})["ok"], true);
  }
}

TEST_F(CircuitStudioTest, MalformedBreakpointsAndTicksAreRejectedWithRemedy) {
  Page p = page();
  (void)p.ask({{"op", "hello"}});
  const json item = {{"condition", "k.time > 3"}};
  for (const json& bad : {json{{"op", "breakpoints"}}, json{{"op", "breakpoints"}, {"list", 1}}, json{{"op", "breakpoints"}, {"list", {1}}},
                          json{{"op", "breakpoints"}, {"list", {{{"condition", "k.time"}}}}},
                          json{{"op", "breakpoints"}, {"list", {{{"condition", "k.time > 3"}, {"on", 1}}}}},
                          json{{"op", "breakpoints"}, {"list", json(101, item)}}, json{{"op", "step"}, {"ticks", 2}}}) {
    const json answer = p.ask(bad);
    EXPECT_EQ(answer["ok"], false) << bad.dump();
    EXPECT_FALSE(answer["error"]["problems"][0]["remedy"].get<std::string>().empty()) << answer.dump();
  }
  const json refused = p.ask({{"op", "step"}, {"ticks", 1}});
  EXPECT_EQ(refused["ok"], false);
  EXPECT_EQ(refused["error"]["problems"][0]["message"], "Single ticks are available in Simulate mode only.");
}

TEST_F(CircuitStudioTest, MalformedWatchRequestsAreRejected) {
  Page p = page();
  for (const json& bad : {json{{"op", "watch"}}, json{{"op", "watch"}, {"pins", "a"}, {"probes", json::array()}, {"timing", true}},
                          json{{"op", "watch"}, {"pins", json::array()}, {"probes", json::array()}, {"timing", 1}}})
    EXPECT_EQ(p.ask(bad)["ok"], false) << bad.dump();
  EXPECT_EQ(p.ask({{"op", "watch"}, {"pins", {1, nullptr, "no.pin"}}, {"probes", {"x"}}, {"timing", true}})["ok"], true);
}

}  // namespace
}  // namespace ugoki::studio
