#include "ugoki/contact/system_order.h"

namespace ugoki::contact {

void SystemOrder::reserve(std::size_t systems, std::size_t pairs) {
  pairs_.reserve(pairs);
  neighbours_.reserve(2 * pairs);
  first_.resize(systems);
  end_.resize(systems);
  found_.resize(systems);
  queue_.resize(systems);
}

/// Appends all systems connected with `from` to queue_, beginning at index `head`. @return the end of the queue
std::size_t SystemOrder::search(int from, std::size_t head) {
  std::size_t tail = head;
  queue_[tail++] = from;
  found_[static_cast<std::size_t>(from)] = 1;
  while (head < tail) {
    const auto s = static_cast<std::size_t>(queue_[head++]);
    for (int k = first_[s]; k < end_[s]; ++k) {
      const int next = neighbours_[static_cast<std::size_t>(k)];
      if (found_[static_cast<std::size_t>(next)] != 0) continue;
      found_[static_cast<std::size_t>(next)] = 1;
      queue_[tail++] = next;
    }
  }
  return tail;
}

std::span<const int> SystemOrder::find(std::span<const int> members) {
  for (const int s : members) first_[static_cast<std::size_t>(s)] = found_[static_cast<std::size_t>(s)] = 0;
  for (const auto& [a, b] : pairs_) {
    ++first_[static_cast<std::size_t>(a)];
    ++first_[static_cast<std::size_t>(b)];
  }
  int total = 0;
  for (const int s : members) {
    total += first_[static_cast<std::size_t>(s)];
    first_[static_cast<std::size_t>(s)] = end_[static_cast<std::size_t>(s)] = total;  // the next loop fills the neighbours backwards
  }
  neighbours_.resize(static_cast<std::size_t>(total));
  for (std::size_t i = pairs_.size(); i-- > 0;) {
    const auto [a, b] = pairs_[i];
    neighbours_[static_cast<std::size_t>(--first_[static_cast<std::size_t>(a)])] = b;
    neighbours_[static_cast<std::size_t>(--first_[static_cast<std::size_t>(b)])] = a;
  }
  std::size_t ordered = 0;
  for (const int s : members) {
    if (found_[static_cast<std::size_t>(s)] != 0) continue;
    const std::size_t end = search(s, ordered);
    for (std::size_t k = ordered; k < end; ++k) found_[static_cast<std::size_t>(queue_[k])] = 0;
    ordered = search(queue_[end - 1], ordered);
  }
  return std::span(queue_).first(members.size());
}

}  // namespace ugoki::contact
