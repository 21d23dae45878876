#pragma once
// Interface to the host's threads. Modules that also build for WebAssembly create no thread; they run independent work on an executor.

#include <cstddef>

namespace ugoki {

class Executor {
 public:
  virtual ~Executor() = default;
  /// Number of workers, at least 1; constant for the lifetime of the object.
  [[nodiscard]] virtual int workers() const = 0;
  /// Calls work(context, 0) ... work(context, workers() - 1), each on its own thread, and returns when all have returned. Memory that the
  /// workers wrote during one call of `run` is visible to all workers of the next call. Allocates nothing. A call of `run` within `work`
  /// calls work(context, 0) ... work(context, workers() - 1) one after the other on the calling thread.
  virtual void run(void (*work)(void* context, int worker), void* context) = 0;
};

/// Calls body(k, worker) once for each k = 0 ... count - 1, on all workers; each worker takes the next k when it is free.
/// @param executor null: all calls are made on the calling thread, in order, with worker 0
template <class Body>
void parallel_for(Executor* executor, std::size_t count, const Body& body) {
  if (executor == nullptr) {
    for (std::size_t k = 0; k < count; ++k) body(k, 0);
    return;
  }
  struct Work {
    const Body* body;
    std::size_t count;
    std::size_t next;  // the next k that no worker has taken; changed by atomic operations only
  } work{&body, count, 0};
  executor->run(
      [](void* context, int worker) {
        Work& w = *static_cast<Work*>(context);
        const auto take = [&w] { return __atomic_fetch_add(&w.next, std::size_t{1}, __ATOMIC_RELAXED); };
        for (std::size_t k = take(); k < w.count; k = take()) (*w.body)(k, worker);
      },
      &work);
}

}  // namespace ugoki
