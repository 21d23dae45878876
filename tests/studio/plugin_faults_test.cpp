// Tests of faulty LSI libraries in the studio with its interpreter process. Each fault must give a message with the LSI, the pin and the
// time. The studio must continue, and the project must keep its unsaved edits and their undo.

#include <gtest/gtest.h>
#include <stdlib.h>
#include <unistd.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <thread>

#include "../content/fixture.h"
#include "../plugin/misbehaving.h"
#include "page.h"
#include "ugoki/plugin/build.h"
#include "ugoki/plugin/shelf.h"
#include "ugoki/studio/studio.h"

namespace ugoki::studio {
namespace {

using nlohmann::json;
using test::Page;
namespace fs = std::filesystem;

const char* const faulty = R"(#include <math.h>
/// @library faulty
int quotient(double t, int b) { return t > 0.1 ? 7 / b : 7; }
double null(double t) { return t > 0.1 ? *(volatile double*)0 : t; }
double forever(double t) { while (t > 0.1) { __asm__ volatile(""); } return t; }
double invalid(double t) { return t > 0.1 ? NAN : t; }
double good(double t) { return 2 * t; }
)";
const char* const repaired = R"(/// @library faulty
double null(double t) { return 3 * t; }
)";

class PluginFaultsTest : public testing::Test {
 protected:
  void SetUp() override {
    std::string name = (fs::temp_directory_path() / "ugoki-faults-XXXXXX").string();
    ASSERT_NE(::mkdtemp(name.data()), nullptr);
    folder_ = name;
    shelf_ = folder_ + "/lsi";
    ASSERT_EQ(::setenv("UGOKI_LSI", shelf_.c_str(), 1), 0);
  }
  void TearDown() override {
    studio_.reset();
    ::unsetenv("UGOKI_LSI");
    fs::remove_all(folder_);
  }
  void start() {
    auto project = project::Project::create(folder_ + "/park.ugoki", content::testing::make_scenario(), content::testing::make_resources());
    ASSERT_TRUE(project) << project.error().text();
    StudioOptions options;
    options.library_path = folder_ + "/library.db";
    options.interpreter = {"/proc/self/exe", {"interpret"}};
    Result<std::unique_ptr<Studio>> started = Studio::start(options, std::move(*project));
    ASSERT_TRUE(started) << started.error().text();
    studio_ = std::move(*started);
  }
  void install(const std::string& text) const {
    std::ofstream(folder_ + "/faulty.c") << text;
    const auto built = plugin::build_library({folder_ + "/faulty.c", {}, {}, {}});
    ASSERT_TRUE(built) << built.error().text();
    const auto described = plugin::describe_library(built->output);
    ASSERT_TRUE(described) << described.error().text();
    const auto put = plugin::put_on_shelf(shelf_, built->output, *described);
    ASSERT_TRUE(put) << put.error().text();
  }
  /// Command that adds a clock and the LSI `faulty/TYPE` with the id x; the clock's time is the input of x.
  static json use(const std::string& type) {
    return {{"op", "command"},
            {"command",
             {{"type", "circuit.edit"},
              {"label", "Add " + type},
              {"changes",
               {{{"list", "lsis"}, {"put", {{"id", "clock"}, {"type", "clock"}}}},
                {{"list", "lsis"}, {"put", {{"id", "x"}, {"type", "faulty/" + type}, {"values", json::object()}}}},
                {{"list", "wires"}, {"put", {{"from", "clock.time"}, {"to", "x.t"}}}}}}}}};
  }
  /// Plays the content with the LSI until it stops. @return the event `stopped`
  json play_until_stopped(Page& p, json edit) {
    EXPECT_EQ(p.ask({{"op", "hello"}})["ok"], true);
    if (edit["command"]["changes"][1]["put"]["type"] == "faulty/quotient") edit["command"]["changes"][1]["put"]["values"] = {{"b", 0}};
    EXPECT_EQ(p.ask(edit)["ok"], true);
    EXPECT_EQ(p.ask({{"op", "mode"}, {"mode", "simulate"}})["ok"], true);
    EXPECT_EQ(p.ask({{"op", "play"}})["ok"], true);
    return p.event("stopped");
  }
  /// Plays `faulty/LSI` and expects the event `stopped` with `text` in its message.
  void expect_fault(const std::string& lsi, const std::string& text, const std::string& location = "x") {
    install(faulty);
    start();
    Page p = page();
    const json stopped = play_until_stopped(p, use(lsi));
    ASSERT_TRUE(stopped.contains("problems")) << stopped;
    const json& problem = stopped["problems"][0];
    EXPECT_EQ(problem["location"], location) << stopped;
    const std::string message = problem["message"];
    EXPECT_NE(message.find("'x'"), std::string::npos) << message;
    EXPECT_NE(message.find("of library 'faulty'"), std::string::npos) << message;
    EXPECT_NE(message.find(text), std::string::npos) << message;
    EXPECT_NE(message.find(" at 0.10"), std::string::npos) << message;
    EXPECT_NE(message.find("Its inputs were 't' = 0.10"), std::string::npos) << message;
    expect_intact(p, "Add " + lsi);
  }
  /// Checks that the project still has the unsaved edit, that it can be undone and redone, and that the content runs without the LSI.
  void expect_intact(Page& p, const std::string& label) {
    const json hello = p.ask({{"op", "hello"}});
    EXPECT_EQ(hello["unsaved"], true);
    EXPECT_EQ(hello["undo_label"], label);
    ASSERT_EQ(hello["document"]["circuit"]["lsis"].back()["id"], "x");
    EXPECT_FALSE(hello["stopped"]["problems"].empty()) << "hello must contain the last stopped event";
    EXPECT_EQ(p.ask({{"op", "save"}})["ok"], true);
    EXPECT_EQ(p.ask({{"op", "undo"}})["label"], label);
    EXPECT_TRUE(p.ask({{"op", "hello"}})["document"]["circuit"].is_null());
    EXPECT_EQ(p.ask({{"op", "mode"}, {"mode", "simulate"}})["ok"], true);
    EXPECT_EQ(p.ask({{"op", "restart"}})["ok"], true);
    EXPECT_EQ(p.ask({{"op", "play"}})["ok"], true);
    EXPECT_FALSE(p.event("transport", [](const json& e) { return e["playing"] == true && e["simulated"] > 0.3; }).is_null());
    EXPECT_FALSE(p.ask({{"op", "hello"}}).contains("stopped"));
    EXPECT_EQ(p.ask({{"op", "pause"}})["ok"], true);
    EXPECT_EQ(p.ask({{"op", "redo"}})["label"], label);
    EXPECT_EQ(p.ask({{"op", "hello"}})["document"]["circuit"]["lsis"].back()["id"], "x");
  }
  Page page() { return {studio_->port(), studio_->token()}; }

  std::string folder_, shelf_;
  std::unique_ptr<Studio> studio_;
};

TEST_F(PluginFaultsTest, IntegerDivisionByZero) { expect_fault("quotient", "divided an integer by zero"); }
TEST_F(PluginFaultsTest, NullPointer) { expect_fault("null", "used a null pointer"); }
TEST_F(PluginFaultsTest, InfiniteLoop) { expect_fault("forever", "did not return within 3.0 s and was stopped"); }
TEST_F(PluginFaultsTest, NotANumberNamesThePin) { expect_fault("invalid", "of its output 'out' is not finite", "x.out"); }

// A process that the LSI starts in a session of its own is ended together with the interpreter.
TEST_F(PluginFaultsTest, ProcessInItsOwnSessionIsEnded) {
  const std::string number = folder_ + "/pid";
  install(
      "#include <stdio.h>\n#include <stdlib.h>\n#include <unistd.h>\n/// @library faulty\n"
      "static void leave(void) {\n  if (fork() != 0) return;\n  setsid();\n  if (fork() != 0) _exit(0);\n"
      "  FILE* f = fopen(\"" +
      number +
      ".new\", \"w\");\n  fprintf(f, \"%d\\n\", (int)getpid());\n  fclose(f);\n"
      "  rename(\"" +
      number + ".new\", \"" + number +
      "\");\n  sleep(1000);\n  _exit(0);\n}\n"
      "double stray(double t) {\n  static int n = 0;\n  if (++n == 1) leave();\n  if (t > 0.1 && access(\"" +
      number +
      "\", F_OK) == 0) _exit(0);\n"
      "  return t;\n}\n");
  start();
  Page p = page();
  const json stopped = play_until_stopped(p, use("stray"));
  ASSERT_TRUE(stopped.contains("problems")) << stopped;
  pid_t pid = 0;
  std::ifstream(number) >> pid;
  ASSERT_GT(pid, 1);
  // The signal was sent before the event `stopped`; the process ends soon after. Without a waiting parent it stays in /proc as a zombie.
  std::string line;
  for (int i = 0; i < 1000; ++i) {
    line.clear();
    std::ifstream file("/proc/" + std::to_string(pid) + "/stat");
    std::getline(file, line);
    if (line.empty() || line.find(") Z ") != std::string::npos) return;
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  FAIL() << "the process is still alive: " << line;
}

TEST_F(PluginFaultsTest, OtherInterfaceVersionIsRejectedAndNamed) {
  install(faulty);
  // A library that was built for another version of the interface (77), with a correct hash in the manifest.
  const std::string manifest = shelf_ + "/faulty.json";
  json entry = json::parse(std::ifstream(manifest));
  const std::string file = shelf_ + "/" + entry["file"].get<std::string>();
  std::ofstream(folder_ + "/old.c") << "#include <ugoki/lsi.h>\nstatic const ugoki_library l = {sizeof l, 77u, \"faulty\", \"1\"};\n"
                                       "const ugoki_library* ugoki_lsi_library(void) { return &l; }\n";
  ASSERT_EQ(std::system(("clang-19 -shared -fPIC -I" UGOKI_INCLUDE " -o " + file + " " + folder_ + "/old.c").c_str()), 0);
  ASSERT_EQ(std::system(("sha256sum " + file + " > " + folder_ + "/sum").c_str()), 0);
  std::string sum;
  std::ifstream(folder_ + "/sum") >> sum;
  entry["sha256"] = sum;
  std::ofstream(manifest) << entry.dump();

  start();
  Page p = page();
  (void)p.ask({{"op", "hello"}});
  ASSERT_EQ(p.ask(use("good"))["ok"], true) << "a circuit with an unusable LSI must be accepted as an edit";
  const json received = p.event("circuit");
  ASSERT_FALSE(received.is_null());
  const std::string message = received["problems"][0]["message"];
  EXPECT_NE(message.find("'good' of the library 'faulty' (used as 'x')"), std::string::npos) << message;
  EXPECT_NE(message.find("built for version 77 of the LSI interface"), std::string::npos) << message;
  EXPECT_EQ(p.ask({{"op", "mode"}, {"mode", "simulate"}})["ok"], false);
  EXPECT_EQ(p.ask({{"op", "hello"}})["document"]["circuit"]["lsis"].back()["type"], "faulty/good");

  install(faulty);  // a compatible build: it runs without a restart of the studio
  EXPECT_TRUE(p.event("circuit")["problems"].empty());
  EXPECT_EQ(p.ask({{"op", "mode"}, {"mode", "simulate"}})["ok"], true);
}

TEST_F(PluginFaultsTest, RebuiltLibraryReplacesRunningLsi) {
  install(faulty);
  start();
  Page p = page();
  (void)p.ask({{"op", "hello"}});
  ASSERT_EQ(p.ask(use("good"))["ok"], true);
  ASSERT_EQ(p.ask({{"op", "watch"}, {"pins", {"x.out"}}, {"probes", {"clock.time"}}, {"timing", true}})["ok"], true);
  ASSERT_EQ(p.ask({{"op", "mode"}, {"mode", "simulate"}})["ok"], true);
  ASSERT_EQ(p.ask({{"op", "play"}, {"speed", 0.2}})["ok"], true);
  const auto factor = [](const json& e) { return e["pins"][0][2][0].get<double>() / e["time"].get<double>(); };
  const json before = p.event("values", [](const json& e) { return e["time"] > 0.1; });
  ASSERT_FALSE(before.is_null());
  EXPECT_NEAR(factor(before), 2, 0.1);
  install("/// @library faulty\ndouble good(double t) { return -10 * t; }\n");
  const json after = p.event("values", [&](const json& e) { return factor(e) < -9; });
  ASSERT_FALSE(after.is_null());
  EXPECT_NEAR(factor(after), -10, 0.2);
  EXPECT_GT(after["time"], before["time"]) << "the content must continue at its time";
  const json timed = p.event("values", [](const json& e) { return e.contains("times") && e.contains("probes"); });
  ASSERT_FALSE(timed.is_null());
  EXPECT_GT(timed["tick_us"], 0) << "the watched outputs must still be reported";
}

TEST_F(PluginFaultsTest, InstalledAndRepairedLibrariesLoadWithoutRestart) {
  start();
  Page p = page();
  (void)p.ask({{"op", "hello"}});
  const auto has = [](const std::string& name) {
    return [name](const json& e) {
      for (const json& c : e["classes"])
        if (c["name"] == name) return true;
      return false;
    };
  };
  install(faulty);
  ASSERT_FALSE(p.event("lsis", has("faulty/good")).is_null());
  const json stopped = play_until_stopped(p, use("null"));
  ASSERT_FALSE(stopped.is_null());
  install(repaired);
  EXPECT_FALSE(p.event("lsis", has("faulty/null")).is_null()) << "the list of LSIs must be updated without a play request";
  (void)p.ask({{"op", "watch"}, {"pins", {"x.out"}}, {"probes", json::array()}, {"timing", false}});
  EXPECT_EQ(p.ask({{"op", "play"}})["ok"], true);
  const json values = p.event("values", [](const json& e) { return e["time"] > 0.3; });
  ASSERT_FALSE(values.is_null());
  EXPECT_NEAR(values["pins"][0][2][0].get<double>(), 3 * values["time"].get<double>(), 0.02);
}

TEST_F(PluginFaultsTest, RestartGivesGlobalVariablesTheirInitialValues) {
  install("/// @library faulty\nstatic double sum;\ndouble good(double t) { sum += 1; return sum + 0 * t; }\n");
  start();
  Page p = page();
  (void)p.ask({{"op", "hello"}});
  ASSERT_EQ(p.ask(use("good"))["ok"], true);
  ASSERT_EQ(p.ask({{"op", "watch"}, {"pins", {"x.out"}}, {"probes", json::array()}, {"timing", false}})["ok"], true);
  ASSERT_EQ(p.ask({{"op", "mode"}, {"mode", "simulate"}})["ok"], true);
  std::vector<double> first;  // calls of the LSI before the first tick of each round
  for (int round = 0; round < 3; ++round) {
    ASSERT_EQ(p.ask({{"op", "restart"}})["ok"], true);
    ASSERT_EQ(p.ask({{"op", "play"}})["ok"], true);
    const json values = p.event("values", [](const json& e) { return e["time"] > 0.05 && e["time"] < 5; });
    ASSERT_FALSE(values.is_null());
    constexpr double step = 0.002;  // s, time of one tick
    first.push_back(values["pins"][0][2][0].get<double>() - values["time"].get<double>() / step);
    ASSERT_EQ(p.ask({{"op", "pause"}})["ok"], true);
  }
  EXPECT_NEAR(first[1], first[0], 1.5);
  EXPECT_NEAR(first[2], first[0], 1.5);
}

// The LSIs of tests/plugin/misbehaving.h: each is named, the studio and its project stay alive.
class Slow_MisbehavingStudioTest : public PluginFaultsTest {
 protected:
  void install_rogue(const plugin::Misbehaving& m) const {
    const std::string source = folder_ + (m.cpp ? "/rogue.cpp" : "/rogue.c");
    std::ofstream(source) << plugin::rogue_source(m);
    const auto built = plugin::build_library({source, {}, {}, {}});
    ASSERT_TRUE(built) << m.name << built.error().text();
    const auto described = plugin::describe_library(built->output);
    ASSERT_TRUE(described) << described.error().text();
    const auto put = plugin::put_on_shelf(shelf_, built->output, *described);
    ASSERT_TRUE(put) << put.error().text();
  }
};

TEST_F(Slow_MisbehavingStudioTest, EachIsNamedAndTheStudioStaysAlive) {
  install_rogue(plugin::misbehaving[0]);
  start();
  Page p = page();
  ASSERT_EQ(p.ask({{"op", "hello"}})["ok"], true);
  ASSERT_EQ(p.ask({{"op", "command"},
                   {"command",
                    {{"type", "circuit.edit"},
                     {"label", "Add rogue"},
                     {"changes",
                      {{{"list", "lsis"}, {"put", {{"id", "clock"}, {"type", "clock"}}}},
                       {{"list", "lsis"}, {"put", {{"id", "x"}, {"type", "rogue/f"}}}},
                       {{"list", "wires"}, {"put", {{"from", "clock.time"}, {"to", "x.t"}}}}}}}}})["ok"],
            true);
  for (const plugin::Misbehaving& m : plugin::misbehaving) {
    install_rogue(m);
    if (&m != plugin::misbehaving.data()) ASSERT_FALSE(p.event("lsis").is_null()) << m.name;  // the new library is loaded
    ASSERT_EQ(p.ask({{"op", "mode"}, {"mode", "edit"}})["ok"], true) << m.name;
    (void)p.ask({{"op", "restart"}});
    ASSERT_EQ(p.ask({{"op", "mode"}, {"mode", "simulate"}})["ok"], true) << m.name;
    EXPECT_EQ(p.ask({{"op", "play"}})["ok"], true) << m.name;
    const json stopped = p.event("stopped");
    ASSERT_TRUE(stopped.contains("problems")) << m.name;
    const std::string message = stopped["problems"][0]["message"];
    EXPECT_NE(message.find("rogue"), std::string::npos) << m.name << ": " << message;
    EXPECT_NE(message.find(m.report), std::string::npos) << m.name << ": " << message;
    EXPECT_EQ(p.ask({{"op", "hello"}})["unsaved"], true) << m.name;
  }
  EXPECT_EQ(p.ask({{"op", "undo"}})["label"], "Add rogue");
}

}  // namespace
}  // namespace ugoki::studio
