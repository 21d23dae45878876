#pragma once
// Counts the open connections of the server.

#include <cstddef>
#include <utility>

namespace ugoki::studio {

/// Increments the count of open connections while this object lives. The server limits the count (ServerOptions::max_connections).
class ConnectionSlot {
 public:
  explicit ConnectionSlot(std::size_t& count) : count_(&count) { ++count; }
  ConnectionSlot(ConnectionSlot&& other) noexcept : count_(std::exchange(other.count_, nullptr)) {}
  ConnectionSlot(const ConnectionSlot&) = delete;
  ConnectionSlot& operator=(const ConnectionSlot&) = delete;
  ConnectionSlot& operator=(ConnectionSlot&&) = delete;
  ~ConnectionSlot() { release(); }
  void release() {
    if (count_ != nullptr) --*count_;
    count_ = nullptr;
  }

 private:
  std::size_t* count_;
};

}  // namespace ugoki::studio
