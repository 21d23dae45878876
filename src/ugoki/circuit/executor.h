#pragma once
// Threads that the host may lend to an interpreter. The runtime itself knows none.

namespace ugoki::circuit {

class Executor {
 public:
  virtual ~Executor() = default;
  /// At least 1. Stays the same.
  [[nodiscard]] virtual int workers() const = 0;
  /// Calls work(context, 0) ... work(context, workers() - 1), each on its own thread, and returns when all have returned; what
  /// one call of `run` wrote is seen by the next. Allocates nothing.
  virtual void run(void (*work)(void* context, int worker), void* context) = 0;
};

}  // namespace ugoki::circuit
