#pragma once
// The memory in which all payloads and states of a circuit lie. Where the system can, pages that nobody may touch lie on both sides, so
// that an LSI that writes far beyond its own stops there and destroys nothing else of the process.

#include <cstddef>
#include <cstdint>
#include <vector>

namespace ugoki::circuit {

class Arena {
 public:
  Arena() = default;
  /// @param words of 8 bytes, zero
  explicit Arena(std::size_t words);
  ~Arena();
  Arena(Arena&&) noexcept;
  Arena& operator=(Arena&&) noexcept;

  [[nodiscard]] std::uint64_t* data() { return data_; }
  [[nodiscard]] const std::uint64_t* data() const { return data_; }
  [[nodiscard]] std::size_t size() const { return size_; }

 private:
  std::uint64_t* data_ = nullptr;
  std::size_t size_ = 0;
  void* mapped_ = nullptr;  ///< with the pages around; null: `own_` holds it
  std::size_t mapped_bytes_ = 0;
  std::vector<std::uint64_t> own_;
};

}  // namespace ugoki::circuit
