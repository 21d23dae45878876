#pragma once
// Interface to the host's threads. Modules that also build for WebAssembly create no thread; they run independent work on an executor.

namespace ugoki {

class Executor {
 public:
  virtual ~Executor() = default;
  /// Number of workers, at least 1; constant for the lifetime of the object.
  [[nodiscard]] virtual int workers() const = 0;
  /// Calls work(context, 0) ... work(context, workers() - 1), each on its own thread, and returns when all have returned. Memory that
  /// the workers wrote during one call of `run` is visible to all workers of the next. Allocates nothing. `work` must not call `run`.
  virtual void run(void (*work)(void* context, int worker), void* context) = 0;
};

}  // namespace ugoki
