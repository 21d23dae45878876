#pragma once
// A thread that does tasks in order, and one thing regularly.

#include <chrono>
#include <condition_variable>
#include <deque>
#include <functional>
#include <mutex>
#include <thread>

namespace ugoki::studio {

class TaskQueue {
 public:
  /// @param regularly called about every `period`, between tasks; may be empty
  explicit TaskQueue(std::chrono::milliseconds period = std::chrono::milliseconds(250), std::function<void()> regularly = {});
  ~TaskQueue() { close(); }
  TaskQueue(const TaskQueue&) = delete;
  TaskQueue& operator=(const TaskQueue&) = delete;

  void post(std::function<void()> task);
  /// Finishes the tasks that are there; what is posted from now on is dropped. From one thread, not its own.
  void close();

 private:
  void run();
  std::chrono::milliseconds period_;
  std::function<void()> regularly_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<std::function<void()>> tasks_;
  bool ending_ = false, ended_ = false;
  std::thread thread_;
};

}  // namespace ugoki::studio
