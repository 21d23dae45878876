// Writers and servers are killed with SIGKILL at random times. No acknowledged change may be lost, and no change may be partly stored.

#include <sys/wait.h>

#include <csignal>
#include <map>
#include <random>
#include <sstream>
#include <thread>

#include "on_both.h"

namespace ugoki::store {
namespace {

/// Data of version `version` of entry `key`: 3000 bytes, so that versions fill several database pages, and different for each version.
std::string data_of(const std::string& key, int version) {
  std::string out = key + " version " + std::to_string(version) + " ";
  const std::string once = out;
  while (out.size() < 3000) out += once;
  return out;
}

/// Runs in the child process until it is killed: adds pairs of entries in one transaction, saves further versions, and sets tags.
/// Writes one line to the pipe after each change that the library acknowledged.
[[noreturn]] void write_until_killed(const std::string& location, int round, int pipe) {
  Result<Library> library = Library::open(location);
  const auto notify = [&](const std::string& line) {
    if (::write(pipe, line.data(), line.size()) != static_cast<ssize_t>(line.size())) ::_exit(1);
  };
  if (!library) {
    notify("! " + library.error().problems.front().message + "\n");
    ::_exit(1);
  }
  for (int i = 0;; ++i) {
    const std::string key = std::to_string(round) + "-" + std::to_string(i);
    const auto ids = library->put(std::vector{make_item(EntryKind::mechanism, "body " + key, data_of("body " + key, 1)),
                                              make_item(EntryKind::motion, "motion " + key, data_of("motion " + key, 1), {"pair"})});
    if (!ids) break;
    notify("put " + key + " " + (*ids)[0] + " " + (*ids)[1] + "\n");
    for (int version = 2; version <= 3; ++version) {
      if (!library->save({.id = (*ids)[1],
                          .base = version - 1,
                          .note = "note " + std::to_string(version),
                          .data = bytes_of(data_of("motion " + key, version))}))
        ::_exit(0);
      notify("save " + key + " " + (*ids)[1] + " " + std::to_string(version) + "\n");
    }
    if (!library->set_tags((*ids)[0], std::vector<std::string>{"tagged"}, {})) break;
    notify("tag " + key + " " + (*ids)[0] + "\n");
  }
  ::_exit(0);
}

/// The acknowledged changes, as read from the pipe.
struct Acknowledged {
  std::map<std::string, int> versions;      ///< entry id -> newest version
  std::map<std::string, std::string> keys;  ///< entry id -> name
  std::vector<std::string> tagged;          ///< ids of the tagged entries
  int steps = 0;                            ///< number of lines read from the pipe; the writer sends one line per acknowledged change
  std::string trouble;                      ///< line with an error of the child; empty: none

  void read(const std::string& line) {
    std::istringstream words(line);
    std::string action, key, a, b;
    words >> action >> key >> a >> b;
    if (action == "!") trouble = line;
    if (action == "put") {
      versions[a] = versions[b] = 1;
      keys[a] = "body " + key;
      keys[b] = "motion " + key;
    } else if (action == "save") {
      versions[a] = std::stoi(b);
    } else if (action == "tag") {
      tagged.push_back(a);
    }
    ++steps;
  }
};

class KillTest : public OnBoth {
 protected:
  Library open_again() const {
    for (int attempt = 0;; ++attempt) {  // a restarted server needs time to recover
      Result<Library> library = Library::open(location_);
      if (library) return std::move(*library);
      if (attempt > 300) {
        ADD_FAILURE() << library.error().text();
        std::abort();
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(100));
    }
  }

  /// Kills the writer in each round. On PostgreSQL, every tenth round also kills the server, and every tenth round (shifted by five) one
  /// of its backend processes.
  void run(int rounds, unsigned seed) {
    std::mt19937 random(seed);
    Acknowledged known;
    int server_kills = 0, unacknowledged = 0;
    for (int round = 0; round < rounds; ++round) {
      const bool kill_postmaster = on_postgres() && round % 10 == 9, kill_backend = on_postgres() && round % 10 == 4;
      int ends[2];
      ASSERT_EQ(::pipe(ends), 0);
      const pid_t child = ::fork();
      ASSERT_GE(child, 0);
      if (child == 0) {
        ::close(ends[0]);
        write_until_killed(location_, round, ends[1]);
      }
      ::close(ends[1]);
      const int before = known.steps;
      std::string text;
      char buffer[4096];
      const auto steps = static_cast<unsigned>(1 + random() % 6);
      const auto drain = [&](bool all) {
        while (all || static_cast<unsigned>(known.steps - before) < steps) {
          const ssize_t n = ::read(ends[0], buffer, sizeof buffer);
          if (n <= 0) return;
          text.append(buffer, static_cast<std::size_t>(n));
          for (std::size_t end = text.find('\n'); end != std::string::npos; end = text.find('\n')) {
            known.read(text.substr(0, end));
            text.erase(0, end + 1);
          }
        }
      };
      drain(false);
      std::this_thread::sleep_for(std::chrono::microseconds(random() % 40'000));
      if (kill_postmaster) {
        ::kill(PostgresServer::get()->pid(), SIGKILL);
        ++server_kills;
      }
      if (kill_backend) {
        const std::string pid = PostgresServer::get()->psql("SELECT pid FROM pg_stat_activity WHERE application_name = 'ugoki' LIMIT 1");
        if (!pid.empty()) ::kill(std::stoi(pid), SIGKILL);
        ++server_kills;
      }
      // Gives the writer time to notice the lost connection and to reconnect. The writer must not acknowledge a change that is not saved.
      if (kill_backend || kill_postmaster) std::this_thread::sleep_for(std::chrono::milliseconds(random() % 400));
      ::kill(child, SIGKILL);
      drain(true);
      ::close(ends[0]);
      ::waitpid(child, nullptr, 0);
      ASSERT_EQ(known.trouble, "") << "round " << round << ", seed " << seed;
      if (kill_postmaster) ASSERT_TRUE(PostgresServer::get()->start());
      if (on_postgres()) wait_for_the_writers_session();
      verify(known, round, unacknowledged);
      if (HasFatalFailure()) FAIL() << "round " << round << ", seed " << seed;
      if (round % 50 == 49 || round + 1 == rounds) check_all(known);
    }
    RecordProperty("acknowledged", known.steps);
    std::printf("%d kills (%d of the server), %d changes acknowledged, %d more saved without acknowledgement, seed %u\n", rounds,
                server_kills, known.steps, unacknowledged, seed);
  }

  /// Waits until the server has finished the last statement of the killed writer, which may save a change that was not acknowledged.
  static void wait_for_the_writers_session() {
    for (int attempt = 0; attempt < 300; ++attempt) {
      if (PostgresServer::get()->psql("SELECT count(*) FROM pg_stat_activity WHERE application_name = 'ugoki'") == "0") return;
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
    ADD_FAILURE() << "the session of a killed writer does not end";
  }

  /// After each round: all changes acknowledged in this round are stored, and all stored entries are complete.
  /// @param unacknowledged incremented for each stored version that was not acknowledged
  void verify(const Acknowledged& known, int round, int& unacknowledged) {
    Library library = open_again();
    const std::string prefix = std::to_string(round) + "-";
    const auto page = library.find({.text = "\"" + prefix + "\""});
    ASSERT_TRUE(page) << page.error().text();
    std::map<std::string, int> pairs;
    for (const LibraryEntry& e : page->entries) {
      const std::string key = e.name.substr(e.name.find(' ') + 1);
      if (!key.starts_with(prefix)) continue;
      ++pairs[key];
      for (int v = 1; v <= e.version; ++v) {
        const auto data = library.data(e.id, v);
        ASSERT_TRUE(data) << data.error().text();
        EXPECT_EQ(*data, bytes_of(data_of(e.name, v)));
      }
      EXPECT_EQ(library.history(e.id)->size(), static_cast<std::size_t>(e.version));
      const auto acknowledged = known.versions.find(e.id);
      const int minimum = acknowledged == known.versions.end() ? 0 : acknowledged->second;
      EXPECT_GE(e.version, minimum) << e.name;
      EXPECT_LE(e.version, minimum + 1) << e.name;
      if (e.version > minimum) ++unacknowledged;
    }
    for (const auto& [key, count] : pairs) EXPECT_EQ(count, 2) << "only one entry of pair " << key << " is stored";
    for (const auto& [id, version] : known.versions) {
      const std::string& name = known.keys.at(id);
      if (name.find(" " + prefix) == std::string::npos) continue;
      const auto entry = library.get(id);
      ASSERT_TRUE(entry) << "lost: " << name << ": " << entry.error().text();
      EXPECT_GE(entry->version, version) << "lost a version of " << name;
    }
  }

  /// Checks all changes acknowledged since the first round.
  void check_all(const Acknowledged& known) {
    Library library = open_again();
    for (const auto& [id, version] : known.versions) {
      const auto data = library.data(id, version);
      ASSERT_TRUE(data) << data.error().text();
      ASSERT_EQ(*data, bytes_of(data_of(known.keys.at(id), version)));
    }
    for (const std::string& id : known.tagged) ASSERT_EQ(library.get(id)->tags, std::vector<std::string>{"tagged"});
    const auto check = library.check(false);
    ASSERT_TRUE(check) << check.error().text();
    EXPECT_TRUE(check->problems.empty()) << check->problems.text();
    EXPECT_EQ(library.collect_garbage(), 0u) << "data without an entry were left behind";
  }
};

TEST_P(KillTest, FortyKillsLoseNothing) { run(on_postgres() ? 20 : 40, 20260501); }
UGOKI_ON_BOTH(KillTest);

class KillManyTest : public KillTest {};
TEST_P(KillManyTest, FiveHundredKillsLoseNothing) { run(500, 20260502); }
INSTANTIATE_TEST_SUITE_P(Slow_Databases, KillManyTest, ::testing::Values(DatabaseKind::sqlite, DatabaseKind::postgres), name_of_database);

}  // namespace
}  // namespace ugoki::store
