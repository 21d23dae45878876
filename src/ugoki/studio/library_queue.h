#pragma once
// The thread that uses the library, for the studio: the library's types are used on this thread only, so that a library that does not
// respond delays nothing else.

#include <atomic>
#include <chrono>
#include <functional>
#include <string>

#include "ugoki/base/result.h"
#include "ugoki/studio/task_queue.h"

namespace ugoki::studio {

class LibraryQueue {
 public:
  /// @param periodic called on the thread about every 2 s
  explicit LibraryQueue(std::function<void()> periodic) : queue_(period, std::move(periodic)) {}

  /// Queues work that uses the library. While the library does not respond, each piece of work ends only at a time limit of some seconds.
  /// Work that was queued before such a piece ended is therefore refused at once, and only later work tries again.
  /// @param work returns false if the library failed, for any reason
  /// @param refuse called instead of `work`, on the same thread
  void post(std::function<bool()> work, std::function<void(const Error&)> refuse);
  /// As TaskQueue::close().
  void close() { queue_.close(); }

  /// Work that fails after this time failed because the library does not respond. The time limits of store are longer.
  static constexpr std::chrono::milliseconds min_silence{1500};

 private:
  using Clock = std::chrono::steady_clock;
  static constexpr std::chrono::milliseconds period{2000};
  Clock::time_point silent_;  ///< end of the last work that failed after min_silence; used on the thread only
  TaskQueue queue_;
};

/// The error that the library does not respond.
[[nodiscard]] Error library_silent();

}  // namespace ugoki::studio
