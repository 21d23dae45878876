#pragma once
// Warm start: the impulses of the last step, found by the key of their contact (ContactPoint::key) or joint row.

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace ugoki::contact {

/// Impulses of one row block.
struct Warm {
  std::uint64_t key = 0;
  double p[3] = {0, 0, 0};  ///< N s | N m s: of a contact in world axes, of other blocks the impulses of the one or three rows
};

/// Hash table of the last step's impulses.
class WarmStart {
 public:
  [[nodiscard]] std::span<const Warm> records() const { return records_; }
  void set(std::span<const Warm> records);

  /// The record of `key` in the last step; null: none. O(1)
  [[nodiscard]] const Warm* find(std::uint64_t key) const;

  void reserve(std::size_t records) { records_.reserve(records); }
  void clear() { records_.clear(); }
  void add(const Warm& record) { records_.push_back(record); }
  /// Builds the hash index; call it after the last add().
  void make_index();

 private:
  std::vector<Warm> records_;
  std::vector<std::int32_t> slots_;  // hash slots, open addressing, size a power of two: index in records_ or -1
};

}  // namespace ugoki::contact
