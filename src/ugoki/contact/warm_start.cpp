#include "ugoki/contact/warm_start.h"

#include <algorithm>
#include <bit>

namespace ugoki::contact {
namespace {

std::size_t slot_of(std::uint64_t key, std::size_t slots) {
  key *= 0x9E3779B97F4A7C15ULL;  // 2^64 / golden ratio
  return static_cast<std::size_t>(key >> 32) & (slots - 1);
}

}  // namespace

void WarmStart::set(std::span<const Warm> records) {
  records_.assign(records.begin(), records.end());
  make_index();
}

void WarmStart::make_index() {
  const std::size_t slots = std::bit_ceil(2 * records_.capacity() + 1);
  if (slots_.size() < slots) slots_.resize(slots);
  std::ranges::fill(slots_, -1);
  for (std::size_t i = 0; i < records_.size(); ++i) {
    std::size_t at = slot_of(records_[i].key, slots_.size());
    while (slots_[at] >= 0) at = (at + 1) & (slots_.size() - 1);
    slots_[at] = static_cast<std::int32_t>(i);
  }
}

const Warm* WarmStart::find(std::uint64_t key) const {
  if (records_.empty()) return nullptr;
  for (std::size_t at = slot_of(key, slots_.size()); slots_[at] >= 0; at = (at + 1) & (slots_.size() - 1)) {
    const Warm& w = records_[static_cast<std::size_t>(slots_[at])];
    if (w.key == key) return &w;
  }
  return nullptr;
}

}  // namespace ugoki::contact
