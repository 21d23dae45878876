#pragma once
// The memory that contains all payloads and states of a circuit. On Linux an inaccessible guard page precedes and follows it: an LSI that
// writes far outside its own memory causes a fault instead of overwriting other data of the process.

#include <cstddef>
#include <cstdint>
#include <vector>

namespace ugoki::circuit {

class Arena {
 public:
  Arena() = default;
  /// Allocates `words` words of 8 bytes each, all zero.
  explicit Arena(std::size_t words);
  ~Arena();
  Arena(Arena&&) noexcept;
  Arena& operator=(Arena&&) noexcept;

  [[nodiscard]] std::uint64_t* data() { return data_; }
  [[nodiscard]] const std::uint64_t* data() const { return data_; }
  [[nodiscard]] std::size_t size() const { return size_; }  ///< size of the memory in words of 8 bytes

 private:
  std::uint64_t* data_ = nullptr;
  std::size_t size_ = 0;
  void* mapped_ = nullptr;  ///< mapping including the guard pages; null: the memory is `own_`
  std::size_t mapped_bytes_ = 0;
  std::vector<std::uint64_t> own_;
};

}  // namespace ugoki::circuit
