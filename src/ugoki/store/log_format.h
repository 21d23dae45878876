#pragma once
// Reader of SQLite's write-ahead log, https://www.sqlite.org/fileformat2.html#the_write_ahead_log. Internal to store.

#include <cstddef>
#include <cstdint>
#include <iosfwd>
#include <optional>
#include <span>
#include <vector>

namespace ugoki::store {

constexpr std::size_t log_header_size = 32, log_frame_header_size = 24;  // bytes
constexpr std::uint32_t min_page_size = 512, max_page_size = 65536;      // bytes

/// One frame of a log: a page of the database as a transaction left it.
struct LogFrame {
  std::uint32_t page_number = 0;  ///< counted from 1
  std::uint32_t salt = 0;         ///< first salt
  bool ends_transaction = false;
  bool of_this_log = false;  ///< false: the salts differ from the header's, so the frame was left over from before the log began again
  bool is_zero = false;      ///< all bytes of the frame's header are 0
};

/// Reads a log from its beginning, as SQLite does.
class LogReader {
 public:
  /// Reads the header. Empty optional if it is missing or its checksum is wrong. `file` must outlive the reader.
  [[nodiscard]] static std::optional<LogReader> begin(std::istream& file);
  /// The next frame; empty optional if the log ends, or if salts or checksum of the frame are wrong. offset() stays before that frame.
  [[nodiscard]] std::optional<LogFrame> next();
  /// The next complete frame, whether it is valid or not; after that, next() must not be called.
  [[nodiscard]] std::optional<LogFrame> next_unchecked();
  /// The page of the last frame that was read.
  [[nodiscard]] std::span<const std::byte> page() const { return page_; }
  /// Byte of the file behind the last frame that was returned.
  [[nodiscard]] std::uint64_t offset() const { return offset_; }
  [[nodiscard]] std::uint32_t page_size() const { return static_cast<std::uint32_t>(page_.size()); }
  /// First salt of the header.
  [[nodiscard]] std::uint32_t salt() const { return salts_[0]; }

 private:
  /// Checksum of the log, https://www.sqlite.org/fileformat2.html#checksum_algorithm
  struct Checksum {
    bool big_endian = false;
    std::uint32_t s0 = 0, s1 = 0;
    void add(std::span<const std::byte> bytes);
  };
  explicit LogReader(std::istream& file) : file_(&file) {}
  bool read(std::span<std::byte> bytes);
  /// Reads a frame at offset_ into header_ and page_.
  std::optional<LogFrame> read_frame();

  std::istream* file_;
  Checksum sum_;
  std::uint32_t salts_[2] = {};
  std::uint64_t offset_ = log_header_size;
  std::byte header_[log_frame_header_size] = {};
  std::vector<std::byte> page_;
};

}  // namespace ugoki::store
