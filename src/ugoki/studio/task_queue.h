#pragma once
// A thread that runs queued tasks one after the other, and calls a function periodically.

#include <chrono>
#include <condition_variable>
#include <deque>
#include <functional>
#include <mutex>
#include <thread>

namespace ugoki::studio {

class TaskQueue {
 public:
  /// @param periodic called about every `period`, between tasks; may be empty
  explicit TaskQueue(std::chrono::milliseconds period = std::chrono::milliseconds(250), std::function<void()> periodic = {});
  ~TaskQueue() { close(); }
  TaskQueue(const TaskQueue&) = delete;
  TaskQueue& operator=(const TaskQueue&) = delete;

  /// Queues a task. Thread-safe. Ignored after close().
  void post(std::function<void()> task);
  /// Runs the queued tasks, and the tasks that these post, then ends the thread. Later tasks are dropped. To be called from one thread,
  /// not from a task.
  void close();

 private:
  void run();
  std::chrono::milliseconds period_;
  std::function<void()> periodic_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<std::function<void()>> tasks_;
  bool ending_ = false, ended_ = false;
  std::thread thread_;
};

}  // namespace ugoki::studio
