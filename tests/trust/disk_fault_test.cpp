// Programs on a disk that is full, read-only, or returns input/output errors. A library for LD_PRELOAD injects the faults
// (faulty_disk.c). Nothing acknowledged may be lost, every file must open afterwards, and each error must be a clear message.

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <random>
#include <string>
#include <vector>

#include "../content/fixture.h"
#include "../store/on_both.h"
#include "ugoki/project/project.h"

namespace ugoki::trust {
namespace {

namespace fs = std::filesystem;

constexpr int max_refusals = 8;  // a worker ends after this number of refused changes
constexpr int max_changes = 60;  // or after this number of acknowledged changes

/// Writes one line to the parent process. "+ TEXT": the change was acknowledged; "- TEXT": the change was refused.
void report(const std::string& line) {
  if (::write(STDOUT_FILENO, (line + "\n").data(), line.size() + 1) < 0) ::_exit(1);
}
void report_refusal(const Error& error) {
  std::string text = error.text();
  std::replace(text.begin(), text.end(), '\n', ' ');
  const bool clear = !error.problems.empty() && !error.problems[0].remedy.empty();
  report((clear ? "- " : "? ") + text);
}

/// Saves versions of one library entry until one of the limits above is reached. Reports "+ N" when version N is saved.
void work_on_library(const std::string& path) {
  int refusals = 0, changes = 0;
  while (refusals < max_refusals && changes < max_changes) {
    Result<store::Library> library = store::Library::open(path);
    if (!library) {
      report_refusal(library.error());
      ++refusals;
      continue;
    }
    while (refusals < max_refusals && changes < max_changes) {
      const Result<store::LibraryEntry> now = library->resolve("entry 1");
      const std::string text(5000, static_cast<char>('a' + changes % 26));
      const Result<store::LibraryEntry> saved =
          now ? library->save({.id = now->id, .base = now->version, .data = store::bytes_of(text + std::to_string(now->version + 1))})
              : fail(now.error());
      if (saved) {
        ++changes;
        report("+ " + std::to_string(saved->version));
      } else {
        ++refusals;
        report_refusal(saved.error());
        if (refusals % 3 == 0) break;  // open the library again
      }
    }
  }
}

/// Renames the scenario until one of the limits above is reached. Reports "+ NAME" when the name is stored.
void work_on_project(const std::string& path) {
  int refusals = 0, changes = 0;
  while (refusals < max_refusals && changes < max_changes) {
    Result<project::Project> project = project::Project::open(path);
    if (!project) {
      report_refusal(project.error());
      ++refusals;
      continue;
    }
    while (refusals < max_refusals && changes < max_changes) {
      const std::string name = "name-" + std::to_string(changes) + "-" + std::to_string(refusals);
      const Result<project::Change> done = project->execute(R"({"type": "scenario.set", "name": ")" + name + "\"}");
      if (done && changes % 7 == 3)
        if (Result<void> saved = project->save(); !saved) report_refusal(saved.error());
      if (done) {
        ++changes;
        report("+ " + name);
      } else {
        ++refusals;
        report_refusal(done.error());
        if (refusals % 3 == 0) break;
      }
    }
  }
}

/// The worker process: this program, started again with UGOKI_FAULT_WORK = "library PATH" or "project PATH".
[[maybe_unused]] const bool is_worker = [] {
  const char* work = std::getenv("UGOKI_FAULT_WORK");
  if (work == nullptr) return false;
  const std::string text(work), kind = text.substr(0, text.find(' ')), path = text.substr(text.find(' ') + 1);
  kind == "library" ? work_on_library(path) : work_on_project(path);
  ::_exit(0);
}();

class DiskFaultTest : public ::testing::Test {
 protected:
  struct Ran {
    std::vector<std::string> acknowledged, refused, unclear;
    int status = 0;
  };
  /// Runs the worker on the faulty disk.
  Ran run_worker(const std::string& work, const std::string& kind, int after, int length) const {
    int ends[2];
    EXPECT_EQ(::pipe(ends), 0);
    const pid_t child = ::fork();
    if (child == 0) {
      ::dup2(ends[1], STDOUT_FILENO);
      ::close(ends[0]);
      ::setenv("UGOKI_FAULT_WORK", work.c_str(), 1);
      ::setenv("UGOKI_FAULT_FOLDER", folder_.path().c_str(), 1);
      ::setenv("UGOKI_FAULT_KIND", kind.c_str(), 1);
      ::setenv("UGOKI_FAULT_AFTER", std::to_string(after).c_str(), 1);
      ::setenv("UGOKI_FAULT_LENGTH", std::to_string(length).c_str(), 1);
      ::setenv("TMPDIR", folder_.path().c_str(), 1);  // rescue copies must also be on the faulty disk
      ::setenv("XDG_DATA_HOME", folder_.path().c_str(), 1);
      ::setenv("LD_PRELOAD", UGOKI_FAULTY_DISK, 1);
      ::execl("/proc/self/exe", "worker", static_cast<char*>(nullptr));
      ::_exit(126);
    }
    ::close(ends[1]);
    std::string text;
    char buffer[4096];
    for (ssize_t n; (n = ::read(ends[0], buffer, sizeof buffer)) > 0;) text.append(buffer, static_cast<std::size_t>(n));
    ::close(ends[0]);
    Ran ran;
    ::waitpid(child, &ran.status, 0);
    for (std::size_t end = text.find('\n'); end != std::string::npos; end = text.find('\n')) {
      const std::string line = text.substr(0, end);
      (line[0] == '+'   ? ran.acknowledged
       : line[0] == '-' ? ran.refused
                        : ran.unclear)
          .push_back(line.substr(std::min<std::size_t>(2, line.size())));
      text.erase(0, end + 1);
    }
    return ran;
  }
  void run(int rounds, unsigned seed) {
    std::mt19937 random(seed);
    std::size_t acknowledged = 0, refused = 0;
    for (int round = 0; round < rounds; ++round) {
      const char* kind = std::array{"full", "readonly", "io"}[static_cast<std::size_t>(round % 3)];
      const bool on_library = round % 2 == 0;
      const int after = static_cast<int>(random() % (round % 4 == 0 ? 60 : 400)),
                length = round % 5 < 2 ? 1 + static_cast<int>(random() % 20) : 0;
      const std::string path = folder_.path() + (on_library ? "/library.db" : "/park.ugoki");
      for (const auto& file : fs::directory_iterator(folder_.path())) fs::remove_all(file);
      if (on_library) {
        auto library = store::Library::open(path);
        ASSERT_TRUE(library && library->put(std::vector{store::make_item(store::EntryKind::motion, "entry 1", "data")}));
      } else {
        ASSERT_TRUE(project::Project::create(path, content::testing::make_scenario(), content::testing::make_resources()));
      }
      const Ran ran = run_worker((on_library ? "library " : "project ") + path, kind, after, length);
      const std::string what = std::string(kind) + " after " + std::to_string(after) + " calls for " + std::to_string(length) + ", " +
                               path + ", round " + std::to_string(round) + ", seed " + std::to_string(seed);
      EXPECT_EQ(ran.status, 0) << what;
      EXPECT_TRUE(ran.unclear.empty()) << what << ": " << (ran.unclear.empty() ? "" : ran.unclear[0]);
      if (on_library) {
        auto library = store::Library::open(path);
        ASSERT_TRUE(library) << what << library.error().text();
        const auto entry = library->resolve("entry 1");
        ASSERT_TRUE(entry) << what << entry.error().text();
        if (!ran.acknowledged.empty()) EXPECT_GE(entry->version, std::stoi(ran.acknowledged.back())) << what;
        for (int version = 1; version <= entry->version; ++version) {
          const auto data = library->data(entry->id, version);
          ASSERT_TRUE(data) << what << data.error().text();
          if (version > 1) EXPECT_EQ(data->size(), 5000u + std::to_string(version).size()) << what;
        }
        const auto check = library->check(false);
        EXPECT_TRUE(check && check->problems.empty()) << what;
      } else {
        const auto project = project::Project::open(path);
        ASSERT_TRUE(project) << what << project.error().text();
        if (!ran.acknowledged.empty()) expect_last(project->scenario().name, ran, what);
      }
      acknowledged += ran.acknowledged.size();
      refused += ran.refused.size();
      if (HasFailure()) return;
    }
    std::printf("%d runs, %zu changes acknowledged, %zu refused, seed %u\n", rounds, acknowledged, refused, seed);
  }
  /// Checks that the stored name is the last acknowledged name, or a later refused name. Names have the form "name-CHANGES-REFUSALS".
  static void expect_last(const std::string& name, const Ran& ran, const std::string& what) {
    if (name == ran.acknowledged.back()) return;
    const std::string number = name.substr(5, name.find('-', 5) - 5);
    EXPECT_EQ(number, std::to_string(ran.acknowledged.size())) << what << ": " << name << " instead of " << ran.acknowledged.back();
  }
  store::TemporaryFolder folder_;
};

TEST_F(DiskFaultTest, TwelveFaultsLoseNothing) { run(12, 20260506); }

class Slow_DiskFaultTest : public DiskFaultTest {};
TEST_F(Slow_DiskFaultTest, ThreeHundredFaultsLoseNothing) { run(300, 20260507); }

}  // namespace
}  // namespace ugoki::trust
