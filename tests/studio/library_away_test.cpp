// A studio whose library is on a PostgreSQL server that stops responding: all other functions continue, and nothing acknowledged is lost.

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <functional>
#include <future>
#include <nlohmann/json.hpp>
#include <vector>

#include "../content/fixture.h"
#include "../store/postgres_server.h"
#include "client.h"
#include "page.h"
#include "ugoki/formats/mechanism_json.h"
#include "ugoki/formats/motion_binary.h"
#include "ugoki/store/library.h"
#include "ugoki/studio/studio.h"

namespace ugoki::studio {
namespace {

using nlohmann::json;
using test::Page;
using test::Reply;

class LibraryAwayTest : public testing::Test {
 protected:
  void SetUp() override {
    server_ = store::PostgresServer::get();
    if (server_ == nullptr) GTEST_SKIP() << store::PostgresServer::unavailable_reason();
    location_ = server_->fresh_library();
    std::string name = (std::filesystem::temp_directory_path() / "ugoki-away-XXXXXX").string();
    ASSERT_NE(::mkdtemp(name.data()), nullptr);
    folder_ = name;
    const auto bytes = [](const std::string& text) {
      const auto* p = reinterpret_cast<const std::byte*>(text.data());
      return std::vector<std::byte>(p, p + text.size());
    };
    Result<store::Library> library = store::Library::open(location_);
    ASSERT_TRUE(library) << library.error().text();
    store::LibraryItem body{
        store::EntryKind::mechanism, "walker", "{}", {}, bytes(formats::write_mechanism(*content::testing::make_walker()))};
    const std::string body_id = store::entry_id(store::EntryKind::mechanism, body.data);
    store::LibraryItem motion{store::EntryKind::motion,
                              "run",
                              R"({"duration":1,"mechanism":")" + body_id + R"("})",
                              {},
                              formats::write_motion(content::testing::make_walk("run", 1, 3, 0, false))};
    const auto put = library->put(std::vector{body, motion});
    ASSERT_TRUE(put) << put.error().text();
    motion_ = (*put)[1];
    Result<project::Project> project =
        project::Project::create(folder_ + "/park.ugoki", content::testing::make_scenario(), content::testing::make_resources());
    ASSERT_TRUE(project) << project.error().text();
    StudioOptions options;
    options.library_path = location_;
    options.interpreter = {"/proc/self/exe", {"interpret-fake"}};
    Result<std::unique_ptr<Studio>> started = Studio::start(options, std::move(*project));
    ASSERT_TRUE(started) << started.error().text();
    studio_ = std::move(*started);
  }
  void TearDown() override {
    if (server_ != nullptr) server_->thaw();
    studio_.reset();
    if (!folder_.empty()) std::filesystem::remove_all(folder_);
  }
  Reply api(const std::string& method, const std::string& target, const std::string& body = "") const {
    return test::request(studio_->port(), method, target, {"Authorization: Bearer " + studio_->token()}, body);
  }
  json clip_add(double start) const {
    return {{"op", "command"}, {"command", {{"type", "clip.add"}, {"character", "human"}, {"motion", motion_}, {"start", start}}}};
  }

  store::PostgresServer* server_ = nullptr;
  std::string location_, folder_, motion_;
  std::unique_ptr<Studio> studio_;
};

TEST_F(LibraryAwayTest, OtherRequestsAreAnsweredAndTheLibraryComesBack) {
  ASSERT_EQ(api("GET", "/api/library").status, 200);
  Page page(studio_->port(), studio_->token());
  ASSERT_TRUE(page.ask({{"op", "hello"}})["ok"]);
  const Reply renamed = api("POST", "/api/entry/" + motion_, R"({"base": 1, "name": "run fast"})");
  ASSERT_EQ(renamed.status, 200) << renamed.body;

  server_->freeze();
  std::vector<std::future<Reply>> lists;
  for (int i = 0; i < 20; ++i) lists.push_back(std::async(std::launch::async, [this] { return api("GET", "/api/library"); }));
  std::future<Reply> save =
      std::async(std::launch::async, [this] { return api("POST", "/api/entry/" + motion_, R"({"base": 2, "name": "lost"})"); });
  const int add = page.post(clip_add(6.5));  // adding the clip needs the library
  // None of these requests waits for the library. After their answers, the requests for lists are still waiting.
  for (int i = 0; i < 5; ++i) {
    EXPECT_EQ(api("GET", "/api/reference-character").status, 200);
    EXPECT_EQ(api("GET", "/api/mechanism/m-walker").status, 200);
    EXPECT_EQ(api("GET", "/api/motion/n-walk").status, 200);
    EXPECT_TRUE(page.ask({{"op", "hello"}})["ok"]);
    EXPECT_TRUE(page.ask({{"op", "pause"}})["ok"]);
  }
  Page other(studio_->port(), studio_->token());
  EXPECT_TRUE(other.ask({{"op", "command"}, {"command", {{"type", "scenario.set"}, {"name", "edited"}}}})["ok"]);
  EXPECT_TRUE(lists.front().wait_for(std::chrono::seconds(0)) == std::future_status::timeout);
  // All twenty requests for lists are answered after one time limit, not one after another. From then on the studio treats the library as
  // unreachable: it refuses requests without a new attempt.
  for (std::future<Reply>& list : lists) {
    ASSERT_EQ(list.wait_for(std::chrono::seconds(30)), std::future_status::ready);
    const Reply reply = list.get();
    EXPECT_EQ(reply.status, 503) << reply.body;
    EXPECT_NE(reply.body.find("does not respond"), std::string::npos) << reply.body;
  }
  ASSERT_EQ(save.wait_for(std::chrono::seconds(30)), std::future_status::ready);
  EXPECT_EQ(save.get().status, 503);
  const json refused = page.reply(add);
  EXPECT_FALSE(refused["ok"]) << refused;
  EXPECT_NE(refused.dump().find("does not respond"), std::string::npos) << refused;

  for (int i = 0; i < 3; ++i) {
    std::future<Reply> list = std::async(std::launch::async, [this] { return api("GET", "/api/library"); });
    EXPECT_EQ(list.wait_for(std::chrono::seconds(2)), std::future_status::ready);  // an attempt to reach the library takes 3 s or more
    EXPECT_EQ(list.get().status, 503);
  }

  server_->thaw();
  EXPECT_FALSE(other.event("library").is_null()) << "pages are notified when the library is back";
  const Reply list = api("GET", "/api/library");
  ASSERT_EQ(list.status, 200) << list.body;
  EXPECT_NE(list.body.find("run fast"), std::string::npos) << "an acknowledged change is kept";
  EXPECT_EQ(list.body.find("lost"), std::string::npos) << "a refused change is not stored";
  EXPECT_TRUE(page.ask(clip_add(6.5))["ok"]);
}

TEST_F(LibraryAwayTest, ChangesOfOtherPeopleReachOpenPages) {
  Page page(studio_->port(), studio_->token());
  ASSERT_TRUE(page.ask({{"op", "hello"}})["ok"]);
  ASSERT_EQ(api("GET", "/api/library").status, 200);
  ::usleep(3'000'000);  // us; waits for the first poll, after which the studio notices changes of the library
  Result<store::Library> library = store::Library::open(location_);
  ASSERT_TRUE(library);
  ASSERT_TRUE(library->rename(motion_, "renamed elsewhere"));
  EXPECT_FALSE(page.event("library").is_null());
}

TEST_F(LibraryAwayTest, EditsOfAPageAreAppliedInOrder) {
  Page page(studio_->port(), studio_->token());
  ASSERT_TRUE(page.ask({{"op", "hello"}})["ok"]);
  const int add = page.post(clip_add(6.5)), undo = page.post({{"op", "undo"}});
  EXPECT_TRUE(page.reply(add)["ok"]);
  const json undone = page.reply(undo);
  EXPECT_TRUE(undone["ok"]) << undone;
}

/// The server stops for 60 s in the middle of work. Prints how long pages waited for answers.
class Slow_LibraryAwayTest : public LibraryAwayTest {};
TEST_F(Slow_LibraryAwayTest, SixtySecondsWithoutTheServer) {
  Page page(studio_->port(), studio_->token());
  ASSERT_TRUE(page.ask({{"op", "hello"}})["ok"]);
  ASSERT_EQ(api("GET", "/api/library").status, 200);
  using Clock = std::chrono::steady_clock;
  struct Times {
    std::vector<double> others, edits, lists;  // ms
  };
  Times before, away;        // with the server, without it
  std::future<Reply> first;  // is answered after the time limit
  const auto work = [&](Times& times, std::chrono::seconds duration) {
    const auto timed = [](std::vector<double>& list, const std::function<void()>& request) {
      const Clock::time_point begun = Clock::now();
      request();
      list.push_back(std::chrono::duration<double, std::milli>(Clock::now() - begun).count());
    };
    const Clock::time_point end = Clock::now() + duration;
    for (int i = 0; Clock::now() < end; ++i) {
      timed(times.others, [&] { EXPECT_EQ(api("GET", "/api/mechanism/m-walker").status, 200); });
      timed(times.others, [&] { EXPECT_TRUE(page.ask({{"op", "hello"}})["ok"]); });
      timed(times.edits, [&] {
        EXPECT_TRUE(page.ask({{"op", "command"}, {"command", {{"type", "scenario.set"}, {"name", "n" + std::to_string(i)}}}})["ok"]);
      });
      if (first.valid() && first.wait_for(std::chrono::seconds(0)) == std::future_status::ready) EXPECT_EQ(first.get().status, 503);
      if (!first.valid()) timed(times.lists, [&] { EXPECT_EQ(api("GET", "/api/library").status, &times == &away ? 503 : 200); });
      ::usleep(50'000);
    }
  };
  work(before, std::chrono::seconds(30));
  server_->freeze();
  first = std::async(std::launch::async, [this] { return api("GET", "/api/library"); });
  work(away, std::chrono::seconds(60));
  server_->thaw();
  const Clock::time_point thawed = Clock::now();
  EXPECT_FALSE(page.event("library").is_null());
  std::printf("back %.1f s after the server\n", std::chrono::duration<double>(Clock::now() - thawed).count());
  EXPECT_EQ(api("POST", "/api/entry/" + motion_, R"({"base": 1, "name": "after"})").status, 200);
  EXPECT_TRUE(page.ask(clip_add(6.5))["ok"]);
  for (auto& [name, times] : {std::pair{"with the server: requests without the library", &before.others},
                              {"with the server: edits (each is flushed to the disk)", &before.edits},
                              {"with the server: requests for the library", &before.lists},
                              {"without it: requests without the library", &away.others},
                              {"without it: edits", &away.edits},
                              {"without it: requests for the library", &away.lists}}) {
    ASSERT_FALSE(times->empty());
    std::ranges::sort(*times);
    std::printf("%s: %zu, median %.1f ms, maximum %.1f ms, %td above 100 ms\n", name, times->size(), (*times)[times->size() / 2],
                times->back(), times->end() - std::ranges::lower_bound(*times, 100.0));
  }
}

}  // namespace
}  // namespace ugoki::studio
