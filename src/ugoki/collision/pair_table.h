#pragma once
// Hash table of the warm starts of pairs of shapes. Internal to collision/.

#include <cstdint>
#include <vector>

#include "ugoki/collision/gilbert.h"

namespace ugoki::collision {

/// Map from the key of a pair of shapes to its GilbertCache. Open addressing; grows when half full; pairs are never removed one by one.
/// Looking up a known pair does not allocate.
class PairTable {
 public:
  /// Returns the cache of a pair. It is empty at the first call with this key, and at the first call after forget(). The reference is valid
  /// until the next call.
  /// @param key not 0
  [[nodiscard]] GilbertCache& at(std::uint64_t key) {
    if (2 * (used_ + 1) > slots_.size()) grow();
    Slot& slot = slots_[slot_of(key)];
    if (slot.key == 0) {
      slot.key = key;
      ++used_;
    }
    if (slot.round != round_) {
      slot.cache = {};
      slot.round = round_;
    }
    return slot.cache;
  }
  /// Resets all caches and keeps the pairs and the memory. O(1): a cache of an earlier round is reset when its pair is next looked up.
  void forget() { ++round_; }
  /// Removes all pairs and releases their slots.
  void clear() {
    slots_.clear();
    used_ = 0;
  }

 private:
  struct Slot {
    std::uint64_t key = 0;
    std::uint64_t round = 0;  // the round to which `cache` belongs
    GilbertCache cache;
  };
  [[nodiscard]] std::size_t slot_of(std::uint64_t key) const {
    std::uint64_t h = key * 0x9e3779b97f4a7c15ULL;
    h ^= h >> 32;
    std::size_t i = static_cast<std::size_t>(h) & (slots_.size() - 1);
    while (slots_[i].key != 0 && slots_[i].key != key) i = (i + 1) & (slots_.size() - 1);
    return i;
  }
  void grow() {
    std::vector<Slot> old(slots_.empty() ? 64 : 2 * slots_.size());
    old.swap(slots_);
    for (const Slot& slot : old)
      if (slot.key != 0) slots_[slot_of(slot.key)] = slot;
  }

  std::vector<Slot> slots_;
  std::size_t used_ = 0;
  std::uint64_t round_ = 0;  // number of calls of forget()
};

}  // namespace ugoki::collision
