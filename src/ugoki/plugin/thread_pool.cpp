#include "ugoki/plugin/thread_pool.h"

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <mutex>
#include <thread>
#include <vector>

namespace ugoki::plugin {
namespace {

constexpr int spins =
    2000;  // polls before a thread sleeps: calls of `run` follow each other within microseconds, faster than a thread wakes up

}  // namespace

struct ThreadPool::Shared {
  std::mutex mutex;
  std::condition_variable begin;
  std::atomic<std::uint64_t> round{0};  // number of calls of `run` so far; an increase starts the threads
  std::atomic<int> left{0};             // number of threads that have not finished this round
  std::atomic<bool> busy{false};        // true: `run` is being executed
  bool end = false;                     // the threads shall exit; set before `round` is increased
  void (*work)(void*, int) = nullptr;
  void* context = nullptr;
  std::vector<std::thread> threads;

  /// Body of a thread: waits for each round and does its share of the work, until `end` is set.
  void serve(int worker) {
    std::uint64_t seen = 0;
    while (true) {
      for (int i = 0; i < spins && round.load(std::memory_order_acquire) == seen; ++i) std::this_thread::yield();
      if (round.load(std::memory_order_acquire) == seen) {
        std::unique_lock lock(mutex);
        begin.wait(lock, [&] { return round.load(std::memory_order_relaxed) != seen; });
      }
      ++seen;
      if (end) return;
      work(context, worker);
      left.fetch_sub(1, std::memory_order_release);
    }
  }
  void start_round() {
    {
      const std::scoped_lock lock(mutex);
      round.fetch_add(1, std::memory_order_release);
    }
    begin.notify_all();
  }
};

ThreadPool::ThreadPool(int workers) : shared_(std::make_unique<Shared>()) {
  for (int w = 1; w < workers; ++w) shared_->threads.emplace_back([s = shared_.get(), w] { s->serve(w); });
}

ThreadPool::~ThreadPool() {
  shared_->end = true;
  shared_->start_round();
  for (std::thread& t : shared_->threads) t.join();
}

int ThreadPool::workers() const { return static_cast<int>(shared_->threads.size()) + 1; }

void ThreadPool::run(void (*work)(void*, int), void* context) {
  Shared& s = *shared_;
  if (s.busy.exchange(true, std::memory_order_acquire)) {  // a worker called `run`, so the other threads are busy
    for (int w = 0; w < workers(); ++w) work(context, w);
    return;
  }
  s.work = work;
  s.context = context;
  s.left.store(static_cast<int>(s.threads.size()), std::memory_order_relaxed);
  s.start_round();
  work(context, 0);
  while (s.left.load(std::memory_order_acquire) > 0) std::this_thread::yield();
  s.busy.store(false, std::memory_order_release);
}

}  // namespace ugoki::plugin
