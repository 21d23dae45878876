#pragma once
// Threads on which an interpreter runs LSIs of a circuit in parallel (circuit/executor.h).

#include <memory>

#include "ugoki/circuit/executor.h"

namespace ugoki::plugin {

/// A fixed number of threads that run the work of each call of `run` and wait between calls.
class ThreadPool final : public circuit::Executor {
 public:
  /// @param workers at least 1; the thread that calls `run` is worker 0, so workers - 1 threads are started
  explicit ThreadPool(int workers);
  ~ThreadPool() override;
  [[nodiscard]] int workers() const override;
  void run(void (*work)(void* context, int worker), void* context) override;

 private:
  struct Shared;
  std::unique_ptr<Shared> shared_;
};

}  // namespace ugoki::plugin
