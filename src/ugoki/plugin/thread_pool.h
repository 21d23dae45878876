#pragma once
// Threads that an interpreter may use (circuit/executor.h).

#include <memory>

#include "ugoki/circuit/executor.h"

namespace ugoki::plugin {

class ThreadPool final : public circuit::Executor {
 public:
  /// @param workers at least 1; the calling thread is the first of them
  explicit ThreadPool(int workers);
  ~ThreadPool() override;
  [[nodiscard]] int workers() const override;
  void run(void (*work)(void* context, int worker), void* context) override;

 private:
  struct Shared;
  std::unique_ptr<Shared> shared_;
};

}  // namespace ugoki::plugin
