#include "ugoki/store/log_format.h"

#include <algorithm>
#include <array>
#include <istream>

namespace ugoki::store {
namespace {

/// Reads the big-endian u32 at the byte offset `at`.
std::uint32_t big32(std::span<const std::byte> bytes, std::size_t at) {
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < 4; ++i) value = value << 8 | static_cast<std::uint32_t>(bytes[at + i]);
  return value;
}

}  // namespace

void LogReader::Checksum::add(std::span<const std::byte> bytes) {
  for (std::size_t i = 0; i + 8 <= bytes.size(); i += 8) {
    std::uint32_t a = big32(bytes, i), b = big32(bytes, i + 4);
    if (!big_endian) a = __builtin_bswap32(a), b = __builtin_bswap32(b);
    s0 += a + s1;
    s1 += b + s0;
  }
}

bool LogReader::read(std::span<std::byte> bytes) {
  file_->read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  return file_->gcount() == static_cast<std::streamsize>(bytes.size());
}

std::optional<LogReader> LogReader::begin(std::istream& file) {
  LogReader reader(file);
  std::array<std::byte, log_header_size> header{};
  if (!reader.read(header)) return std::nullopt;
  const std::span<const std::byte> head(header);
  const std::uint32_t magic = big32(head, 0), page_size = big32(head, 8);
  if ((magic & ~1u) != 0x377f0682u || page_size < min_page_size || page_size > max_page_size) return std::nullopt;
  reader.sum_.big_endian = (magic & 1u) != 0;
  reader.sum_.add(head.first(24));
  if (reader.sum_.s0 != big32(head, 24) || reader.sum_.s1 != big32(head, 28)) return std::nullopt;
  reader.salts_[0] = big32(head, 16);
  reader.salts_[1] = big32(head, 20);
  reader.page_.resize(page_size);
  return reader;
}

std::optional<LogFrame> LogReader::read_frame() {
  if (!read(header_) || !read(page_)) return std::nullopt;
  const std::span<const std::byte> f(header_);
  return LogFrame{.page_number = big32(f, 0),
                  .salt = big32(f, 8),
                  .ends_transaction = big32(f, 4) != 0,  // size of the database, which only the last frame of a transaction contains
                  .of_this_log = big32(f, 8) == salts_[0] && big32(f, 12) == salts_[1],
                  .is_zero = std::all_of(f.begin(), f.end(), [](std::byte b) { return b == std::byte{0}; })};
}

std::optional<LogFrame> LogReader::next() {
  const std::optional<LogFrame> frame = read_frame();
  bool valid = frame && frame->of_this_log;
  if (valid) {
    const std::span<const std::byte> f(header_);
    sum_.add(f.first(8));
    sum_.add(page_);
    valid = sum_.s0 == big32(f, 16) && sum_.s1 == big32(f, 20);
  }
  if (!valid) {
    file_->clear();
    file_->seekg(static_cast<std::streamoff>(offset_));
    return std::nullopt;
  }
  offset_ += log_frame_header_size + page_.size();
  return frame;
}

std::optional<LogFrame> LogReader::next_unchecked() {
  const std::optional<LogFrame> frame = read_frame();
  if (frame) offset_ += log_frame_header_size + page_.size();
  return frame;
}

}  // namespace ugoki::store
