#include "ugoki/studio/task_queue.h"

#include <exception>
#include <utility>

namespace ugoki::studio {

TaskQueue::TaskQueue(std::chrono::milliseconds period, std::function<void()> periodic)
    : period_(period), periodic_(std::move(periodic)), thread_([this] { run(); }) {}

void TaskQueue::close() {
  {
    const std::scoped_lock lock(mutex_);
    ending_ = true;
  }
  changed_.notify_one();
  if (thread_.joinable()) thread_.join();
}

void TaskQueue::post(std::function<void()> task) {
  {
    const std::scoped_lock lock(mutex_);
    if (ended_) return;
    tasks_.push_back(std::move(task));
  }
  changed_.notify_one();
}

void TaskQueue::run() {
  auto next = std::chrono::steady_clock::now() + period_;
  std::unique_lock lock(mutex_);
  while (true) {
    changed_.wait_until(lock, next, [this] { return ending_ || !tasks_.empty(); });
    if (!tasks_.empty()) {
      std::function<void()> task = std::move(tasks_.front());
      tasks_.pop_front();
      lock.unlock();
      try {
        task();
      } catch (const std::exception&) {
        // An exception (for example out of memory) ends the task, not the thread.
      }
      task = {};
      lock.lock();
    } else if (ending_) {
      ended_ = true;
      return;
    }
    if (std::chrono::steady_clock::now() >= next) {
      if (periodic_ && !ending_) {
        lock.unlock();
        periodic_();
        lock.lock();
      }
      // The period begins when the periodic call has ended; otherwise a call longer than the period would run after every task.
      next = std::chrono::steady_clock::now() + period_;
    }
  }
}

}  // namespace ugoki::studio
