// Tests of the library's queue while the library does not respond. The posted work only waits.

#include "ugoki/studio/library_queue.h"

#include <gtest/gtest.h>

#include <atomic>
#include <future>
#include <memory>
#include <thread>

namespace ugoki::studio {
namespace {

void wait_as_for_a_silent_library() { std::this_thread::sleep_for(LibraryQueue::min_silence + std::chrono::milliseconds(50)); }

TEST(LibraryQueueTest, WorkBehindASilentLibraryIsRefusedUntilAPollFindsItBack) {
  std::atomic<bool> back = false;
  std::atomic<int> polls = 0;
  LibraryQueue queue([&](bool) {
    ++polls;
    if (!back) wait_as_for_a_silent_library();
    return back.load();
  });
  std::atomic<int> ran = 0, refused = 0;
  const auto post = [&] {
    auto answered = std::make_shared<std::promise<bool>>();
    queue.post(
        [&, answered] {
          ++ran;
          if (!back) wait_as_for_a_silent_library();
          answered->set_value(back);
          return back.load();
        },
        [&, answered](const Error& error) {
          ++refused;
          EXPECT_EQ(error.problems.front().message, "The library does not respond.");
          answered->set_value(false);
        });
    return answered->get_future();
  };
  std::vector<std::future<bool>> waiting;
  for (int i = 0; i < 20; ++i) waiting.push_back(post());
  for (std::future<bool>& answer : waiting) EXPECT_FALSE(answer.get());
  EXPECT_EQ(ran, 1);
  EXPECT_EQ(refused, 19);
  while (polls == 0) std::this_thread::yield();
  // A poll now waits for the library. A new request is refused at once, without waiting for the poll.
  EXPECT_EQ(post().wait_for(std::chrono::seconds(0)), std::future_status::ready);
  back = true;
  while (queue.away()) std::this_thread::yield();
  EXPECT_TRUE(post().get());
  queue.close();
}

TEST(LibraryQueueTest, QuickFailuresRefuseNothing) {
  LibraryQueue queue([](bool) { return true; });
  std::atomic<int> ran = 0;
  for (int i = 0; i < 5; ++i) queue.post([&] { return ++ran, false; }, [](const Error&) { ADD_FAILURE(); });
  queue.close();
  EXPECT_EQ(ran, 5);
}

}  // namespace
}  // namespace ugoki::studio
