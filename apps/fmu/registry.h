#pragma once
// Which instances and saved states are alive, so that a call with another pointer is refused instead of obeyed.

#include <algorithm>
#include <memory>
#include <mutex>
#include <vector>

namespace ugoki::fmu {

template <class T>
class Registry {
 public:
  void* add(std::unique_ptr<T> thing) {
    const std::lock_guard lock(mutex_);
    things_.push_back(std::move(thing));
    return things_.back().get();
  }
  /// Null: there is no such thing (any more).
  [[nodiscard]] T* find(const void* pointer) {
    const std::lock_guard lock(mutex_);
    const auto found = std::find_if(things_.begin(), things_.end(), [&](const auto& t) { return t.get() == pointer; });
    return found == things_.end() ? nullptr : found->get();
  }
  void remove(const void* pointer) {
    std::unique_ptr<T> last;  // ends outside of the lock
    const std::lock_guard lock(mutex_);
    const auto found = std::find_if(things_.begin(), things_.end(), [&](const auto& t) { return t.get() == pointer; });
    if (found == things_.end()) return;
    last = std::move(*found);
    things_.erase(found);
  }

 private:
  std::mutex mutex_;
  std::vector<std::unique_ptr<T>> things_;
};

}  // namespace ugoki::fmu
