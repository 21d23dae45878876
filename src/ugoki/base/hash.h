#pragma once
// 64-bit FNV-1a hash, for state hashes in determinism tests, checksums of file sections and cache keys. Not cryptographic.
// Source: Fowler, Noll, Vo; draft-eastlake-fnv.

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>

namespace ugoki {

/// Incremental hash of the bytes, doubles and integers added so far. The order of the additions matters.
class Hash64 {
 public:
  /// Adds `size` raw bytes.
  void add_bytes(const void* data, std::size_t size) {
    const auto* p = static_cast<const unsigned char*>(data);
    for (std::size_t i = 0; i < size; ++i) value_ = (value_ ^ p[i]) * 0x100000001b3ULL;
  }
  /// Adds the bit patterns of doubles, so -0 and +0 give different hashes.
  void add(std::span<const double> values) { add_bytes(values.data(), values.size_bytes()); }
  void add(double value) { add_bytes(&value, sizeof value); }
  void add(std::uint64_t value) { add_bytes(&value, sizeof value); }
  [[nodiscard]] std::uint64_t value() const { return value_; }
  /// The hash as 16 lower-case hexadecimal digits.
  [[nodiscard]] std::string hex() const {
    std::string out(16, '0');
    for (std::size_t i = 0; i < 16; ++i) out[i] = "0123456789abcdef"[(value_ >> (60 - 4 * i)) & 15];
    return out;
  }

 private:
  std::uint64_t value_ = 0xcbf29ce484222325ULL;
};

}  // namespace ugoki
