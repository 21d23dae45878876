// Kills the studio with SIGKILL while a page edits the project and the library through the protocol. Afterwards every acknowledged change
// must be stored, and project and library must open.

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <random>

#include "../content/fixture.h"
#include "../store/on_both.h"
#include "page.h"
#include "ugoki/formats/mechanism_json.h"
#include "ugoki/formats/motion_binary.h"
#include "ugoki/studio/studio.h"

namespace ugoki::studio {
namespace {

using nlohmann::json;
using store::DatabaseKind;
using store::name_of_database;

class StudioKillTest : public store::OnBoth {
 protected:
  std::string project_path() const { return folder_.path() + "/park.ugoki"; }
  /// Stores a motion in the library and creates the project.
  void prepare() {
    Result<store::Library> library = store::Library::open(location_);
    ASSERT_TRUE(library) << library.error().text();
    store::LibraryItem body{
        store::EntryKind::mechanism, "walker", "{}", {}, store::bytes_of(formats::write_mechanism(*content::testing::make_walker()))};
    const std::string body_id = store::entry_id(store::EntryKind::mechanism, body.data);
    store::LibraryItem motion{store::EntryKind::motion,
                              "run",
                              R"({"duration":1,"mechanism":")" + body_id + R"("})",
                              {},
                              formats::write_motion(content::testing::make_walk("run", 1, 3, 0, false))};
    const auto put = library->put(std::vector{body, motion});
    ASSERT_TRUE(put) << put.error().text();
    motion_ = (*put)[1];
    const Result<project::Project> project =
        project::Project::create(project_path(), content::testing::make_scenario(), content::testing::make_resources());
    ASSERT_TRUE(project) << project.error().text();
  }
  /// Starts a studio in a child process. @return its process id; `port` and `token` of its server
  pid_t start_studio(std::uint16_t& port, std::string& token) const {
    int ends[2];
    EXPECT_EQ(::pipe(ends), 0);
    const pid_t child = ::fork();
    if (child == 0) {
      ::close(ends[0]);
      Result<project::Project> project = project::Project::open(project_path());
      StudioOptions options;
      options.library_path = location_;
      options.interpreter = {"/proc/self/exe", {"interpret-fake"}};
      Result<std::unique_ptr<Studio>> studio = project ? Studio::start(options, std::move(*project)) : fail(project.error());
      const std::string text = studio ? std::to_string((*studio)->port()) + " " + (*studio)->token() : "! " + studio.error().text();
      [[maybe_unused]] const ssize_t n = ::write(ends[1], text.data(), text.size());
      ::close(ends[1]);
      for (;;) ::pause();
    }
    ::close(ends[1]);
    std::string text;
    char buffer[4096];
    for (ssize_t n; (n = ::read(ends[0], buffer, sizeof buffer)) > 0;) text.append(buffer, static_cast<std::size_t>(n));
    ::close(ends[0]);
    EXPECT_FALSE(text.starts_with("!")) << text;
    port = static_cast<std::uint16_t>(std::atoi(text.c_str()));
    token = text.substr(text.find(' ') + 1);
    return child;
  }
  void run(int rounds, unsigned seed) {
    prepare();
    std::mt19937 random(seed);
    std::string name = "run", scenario_name;
    int acknowledged = 0, edit = 0;
    for (int round = 0; round < rounds; ++round) {
      std::uint16_t port = 0;
      std::string token;
      const pid_t studio = start_studio(port, token);
      ASSERT_NE(port, 0) << "round " << round << ", seed " << seed;
      // A timer process kills the studio while requests are under way.
      const auto delay = static_cast<useconds_t>(random() % 60'000);
      const pid_t killer = ::fork();
      if (killer == 0) {
        ::usleep(delay);
        ::kill(studio, SIGKILL);
        ::_exit(0);
      }
      std::string sent_name = name, sent_scenario = scenario_name;
      try {
        test::Page page(port, token, 0);
        for (bool alive = page.open(); alive; ++edit) {
          sent_scenario = "scenario " + std::to_string(edit);
          const json edited = page.ask({{"op", "command"}, {"command", {{"type", "scenario.set"}, {"name", sent_scenario}}}});
          alive = !edited.is_null();
          if (!alive) break;
          ASSERT_EQ(edited["ok"], true) << edited;
          scenario_name = sent_scenario;
          ++acknowledged;
          sent_name = "run " + std::to_string(edit);
          const test::Reply entry = test::request(port, "GET", "/api/entry/" + motion_, {"Authorization: Bearer " + token});
          if (entry.status != 200) break;
          const test::Reply renamed = test::request(port, "POST", "/api/entry/" + motion_, {"Authorization: Bearer " + token},
                                                    json{{"base", json::parse(entry.body)["version"]}, {"name", sent_name}}.dump());
          if (renamed.status == 0) break;
          ASSERT_EQ(renamed.status, 200) << renamed.body;
          name = sent_name;
          ++acknowledged;
        }
      } catch (const std::exception&) {
        // the studio was killed before the connection was made
      }
      ::waitpid(killer, nullptr, 0);
      ::waitpid(studio, nullptr, 0);
      if (on_postgres()) ::usleep(20'000);  // the server ends the session of the killed studio
      const Result<project::Project> project = project::Project::open(project_path());
      ASSERT_TRUE(project) << project.error().text() << "round " << round << ", seed " << seed;
      if (!scenario_name.empty())
        EXPECT_TRUE(project->scenario().name == scenario_name || project->scenario().name == sent_scenario)
            << project->scenario().name << " instead of " << scenario_name << ", round " << round << ", seed " << seed;
      scenario_name = project->scenario().name;
      Result<store::Library> library = store::Library::open(location_);
      ASSERT_TRUE(library) << library.error().text();
      const Result<store::LibraryEntry> entry = library->get(motion_);
      ASSERT_TRUE(entry) << entry.error().text();
      EXPECT_TRUE(entry->name == name || entry->name == sent_name)
          << entry->name << " instead of " << name << ", round " << round << ", seed " << seed;
      name = entry->name;
      if (HasFailure()) return;
    }
    std::printf("%d kills, %d changes acknowledged, seed %u\n", rounds, acknowledged, seed);
  }
  std::string motion_;
};

TEST_P(StudioKillTest, TenKillsLoseNothing) { run(10, 20260504); }
UGOKI_ON_BOTH(StudioKillTest);

class StudioKillManyTest : public StudioKillTest {};
TEST_P(StudioKillManyTest, FiveHundredKillsLoseNothing) { run(500, 20260505); }
INSTANTIATE_TEST_SUITE_P(Slow_Databases, StudioKillManyTest, ::testing::Values(DatabaseKind::sqlite, DatabaseKind::postgres),
                         name_of_database);

}  // namespace
}  // namespace ugoki::studio
