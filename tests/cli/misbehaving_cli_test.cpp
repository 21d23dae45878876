// Misbehaving LSIs (tests/plugin/misbehaving.h) in `ugoki lsi test` and `ugoki circuit run`: the message names each LSI, and the exit
// status is 1.

#include <signal.h>
#include <unistd.h>

#include <fstream>
#include <iterator>

#include "../plugin/misbehaving.h"
#include "shelf_test.h"

namespace ugoki::cli {
namespace {

namespace fs = std::filesystem;

class Slow_MisbehavingCliTest : public ShelfTest {
 protected:
  /// Expects exit status 1 and a message on stderr that names the library and contains `report`.
  void expect_named(const std::vector<std::string>& arguments, std::string_view name, std::string_view report) const {
    const Output o = ugoki(arguments);
    EXPECT_EQ(o.status, 1) << name << "\n" << o.out << o.err;
    EXPECT_NE(o.err.find("rogue"), std::string::npos) << name << "\n" << o.err;
    EXPECT_NE(o.err.find(report), std::string::npos) << name << "\n" << o.err;
  }
};

/// Ids of the processes whose command line contains `text`, except the test's own process.
std::vector<pid_t> processes_with(const std::string& text) {
  std::vector<pid_t> out;
  for (const auto& entry : fs::directory_iterator("/proc")) {
    const std::string name = entry.path().filename().string();
    if (name.find_first_not_of("0123456789") != std::string::npos || name == std::to_string(::getpid())) continue;
    std::ifstream file(entry.path() / "cmdline", std::ios::binary);
    if (std::string((std::istreambuf_iterator<char>(file)), {}).find(text) != std::string::npos) out.push_back(std::stoi(name));
  }
  return out;
}

// `circuit run` computes in a child process. A signal to the command alone must end the child too.
class SignalledCircuitTest : public ShelfTest {};

TEST_F(SignalledCircuitTest, SignalToTheCommandEndsItsChild) {
  const std::string circuit = write("endless.json", R"({"version": 1, "name": "t", "lsis": [{"id": "c", "type": "clock"}]})");
  for (const int number : {SIGINT, SIGTERM, SIGKILL}) {
    ::signal(number, SIG_DFL);
    const pid_t command = start_program({"circuit", "run", circuit, "--duration", "1e9"}, {"UGOKI_LSI=" + folder_ + "/shelf"});
    for (int i = 0; i < 1000 && processes_with(circuit).size() < 2; ++i) ::usleep(10'000);
    ASSERT_EQ(processes_with(circuit).size(), 2u);
    ::usleep(200'000);  // us, after which the child counts ticks; an earlier signal also ends it
    ::kill(command, number);
    const int status = wait_for(command);
    EXPECT_TRUE(status == 1 || status == 128 + number) << status;
    for (int i = 0; i < 1000 && !processes_with(circuit).empty(); ++i) ::usleep(10'000);
    EXPECT_TRUE(processes_with(circuit).empty()) << "signal " << number;
  }
}

// An LSI calls fork(), and both processes return from the LSI. Only the original process may print results.
TEST_F(SignalledCircuitTest, CopyOfTheProcessWritesNoResults) {
  const std::string source =
      write("copies.c", "#include <unistd.h>\n/// @library copies\ndouble f(double t) { if (t > 0.015 && t < 0.025) fork(); return t; }\n");
  const std::string circuit = write("copies.json", R"({"version": 1, "name": "t", "lsis": [{"id": "c", "type": "clock"},
      {"id": "it", "type": "copies/f"}], "wires": [{"from": "c.time", "to": "it.t"}]})");
  ASSERT_EQ(ugoki({"lsi", "build", source}).status, 0);
  const Output o = ugoki({"circuit", "run", circuit, "--lsi", folder_ + "/copies.so", "--dt", "0.01", "--duration", "0.05", "--json"});
  EXPECT_EQ(o.status, 0) << o.err;
  EXPECT_EQ(Json::parse(o.out)["ticks"], 5);  // the output is one JSON object; two objects would not parse
}

TEST_F(Slow_MisbehavingCliTest, EachIsNamedAndFails) {
  const std::string circuit =
      R"({"version": 1, "name": "t", "lsis": [{"id": "c", "type": "clock"}, {"id": "it", "type": "rogue/f"}], "wires": [{"from": "c.time", "to": "it.t"}]})";
  for (const plugin::Misbehaving& m : plugin::misbehaving) {
    const std::string folder = folder_ + "/rogue";
    fs::remove_all(folder);
    fs::create_directory(folder);
    write(m.cpp ? "rogue/rogue.cpp" : "rogue/rogue.c", plugin::rogue_source(m));
    write("rogue/rogue.test.json", R"({"doc": "", "dt": 0.01, "circuit": )" + circuit +
                                       R"(, "given": [], "expect": [{"tick": 5, "pin": "it.out", "value": 0.05, "tolerance": 1}]})");
    expect_named({"lsi", "test", folder}, m.name, m.report);
    expect_named({"circuit", "run", write("rogue.json", circuit), "--lsi", folder + "/rogue.so", "--dt", "0.01", "--duration", "0.1",
                  "--patience", "0.4"},
                 m.name, m.report);
  }
}

TEST_F(Slow_MisbehavingCliTest, LibrariesThatMisbehaveWhileLoadingAreNamed) {
  for (const plugin::MisbehavingLoad& m : plugin::misbehaving_while_loading) {
    const std::string source = write("rogue.c", std::string(m.source));
    expect_named({"lsi", "build", source}, m.name, m.report);
    ASSERT_TRUE(fs::exists(folder_ + "/rogue.so")) << m.name;
    expect_named({"lsi", "install", folder_ + "/rogue.so", "--yes"}, m.name, m.report);
  }
}

}  // namespace
}  // namespace ugoki::cli
