#pragma once
// The studio's thread for the library. The types of the library are used on this thread only, so that a library that does not respond
// delays nothing else.

#include <atomic>
#include <chrono>
#include <functional>
#include <string>

#include "ugoki/base/result.h"
#include "ugoki/studio/task_queue.h"

namespace ugoki::studio {

class LibraryQueue {
 public:
  /// @param poll called on the thread about every 2 s, with the value of away(). Returns false if the library does not respond.
  explicit LibraryQueue(std::function<bool(bool away)> poll) : queue_(period, [this, ask = std::move(poll)] { call_poll(ask); }) {}

  /// Queues work that uses the library. If the library does not respond, the first work ends only at a time limit of some seconds; then
  /// the library counts as away. All other work, queued before or after, is refused at once until a poll finds that the library is back.
  /// @param work returns false if the library failed, for any reason
  /// @param refuse called instead of `work`: on the calling thread during post(), or on the library's thread; must not block
  void post(std::function<bool()> work, std::function<void(const Error&)> refuse);
  /// True after the library did not respond, until a poll finds that it responds again. Thread-safe.
  [[nodiscard]] bool away() const { return away_; }
  /// Ends the thread after the queued work; see TaskQueue::close().
  void close() { queue_.close(); }

  /// If work or a poll fails after at least this time, the library counts as not responding. The time limits in `store` are longer than
  /// this time.
  static constexpr std::chrono::milliseconds min_silence{1500};

 private:
  static constexpr std::chrono::milliseconds period{2000};
  void call_poll(const std::function<bool(bool away)>& poll);
  std::atomic<bool> away_ = false;
  TaskQueue queue_;
};

/// The error "the library does not respond".
[[nodiscard]] Error library_silent();

}  // namespace ugoki::studio
