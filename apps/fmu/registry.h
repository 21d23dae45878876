#pragma once
// Registry of objects whose pointers are given to the importing tool. A call with an unknown pointer, for example of a freed instance, is
// refused instead of causing undefined behaviour.

#include <algorithm>
#include <memory>
#include <mutex>
#include <vector>

namespace ugoki::fmu {

/// Owns objects and finds them by their address. Thread-safe.
template <class T>
class Registry {
 public:
  /// @return address of the object, valid until remove()
  void* add(std::unique_ptr<T> item) {
    const std::lock_guard lock(mutex_);
    items_.push_back(std::move(item));
    return items_.back().get();
  }
  /// The object at an address; null if there is none.
  [[nodiscard]] T* find(const void* pointer) {
    const std::lock_guard lock(mutex_);
    const auto found = std::find_if(items_.begin(), items_.end(), [&](const auto& t) { return t.get() == pointer; });
    return found == items_.end() ? nullptr : found->get();
  }
  /// Destroys the object; does nothing if there is none.
  void remove(const void* pointer) {
    std::unique_ptr<T> last;  // declared before the lock, so that the object is destroyed after the lock is released
    const std::lock_guard lock(mutex_);
    const auto found = std::find_if(items_.begin(), items_.end(), [&](const auto& t) { return t.get() == pointer; });
    if (found == items_.end()) return;
    last = std::move(*found);
    items_.erase(found);
  }

 private:
  std::mutex mutex_;
  std::vector<std::unique_ptr<T>> items_;
};

}  // namespace ugoki::fmu
