#include "probe_log.h"

#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cstring>

namespace ugoki::cli {
namespace {

constexpr std::size_t max_bytes = std::size_t{1} << 30;  // maximum size of the log, as for Interpreter::set_probes

std::size_t row_bytes(std::uint64_t width) { return sizeof(std::uint64_t) + width * sizeof(double); }

}  // namespace

ProbeLog::~ProbeLog() {
  unmap();
  if (file_ >= 0) ::close(file_);
}

Result<void> ProbeLog::open() {
  file_ = ::memfd_create("ugoki-probes", MFD_CLOEXEC);
  if (file_ < 0) return fail(ErrorCode::io, "--probe", "No memory can be shared for the probes.", "Close other programs.");
  return {};
}

Result<void> ProbeLog::begin(std::size_t width) {
  unmap();
  const std::size_t rows = std::clamp<std::size_t>(max_bytes / row_bytes(width), 1, max_rows),
                    bytes = sizeof(Header) + rows * row_bytes(width);
  if (::ftruncate(file_, 0) != 0 || ::ftruncate(file_, static_cast<off_t>(bytes)) != 0 || !map(bytes))
    return fail(ErrorCode::io, "--probe", "There is not enough memory for the probes.", "Probe fewer pins.");
  *header_ = {width, rows, 0};
  return {};
}

void ProbeLog::add(std::uint64_t tick, std::span<const double> numbers) {
  std::byte* to = row_at(header_->written);
  std::memcpy(to, &tick, sizeof tick);
  std::memcpy(to + sizeof tick, numbers.data(), header_->width * sizeof(double));
  // Count the row only after it was written, so that a crash never leaves a counted row without data.
  __atomic_store_n(&header_->written, header_->written + 1, __ATOMIC_RELEASE);
}

bool ProbeLog::attach() {
  unmap();
  struct stat info{};
  if (file_ < 0 || ::fstat(file_, &info) != 0 || static_cast<std::size_t>(info.st_size) < sizeof(Header)) return false;
  const auto bytes = static_cast<std::size_t>(info.st_size);
  // The other process may have damaged the header before it crashed.
  if (map(bytes) && header_->rows > 0 && header_->width < bytes && header_->rows <= bytes / row_bytes(header_->width) &&
      sizeof(Header) + header_->rows * row_bytes(header_->width) == bytes)
    return true;
  unmap();
  return false;
}

std::size_t ProbeLog::size() const { return header_ ? static_cast<std::size_t>(std::min(header_->written, header_->rows)) : 0; }

std::uint64_t ProbeLog::tick(std::size_t row) const {
  std::uint64_t out;
  std::memcpy(&out, row_at(header_->written - size() + row), sizeof out);
  return out;
}

std::span<const double> ProbeLog::numbers(std::size_t row) const {
  return {reinterpret_cast<const double*>(row_at(header_->written - size() + row) + sizeof(std::uint64_t)),
          static_cast<std::size_t>(header_->width)};
}

std::byte* ProbeLog::row_at(std::uint64_t index) const {
  return reinterpret_cast<std::byte*>(header_ + 1) + index % header_->rows * row_bytes(header_->width);
}

bool ProbeLog::map(std::size_t bytes) {
  void* at = ::mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_SHARED, file_, 0);
  if (at == MAP_FAILED) return false;
  header_ = static_cast<Header*>(at);
  bytes_ = bytes;
  return true;
}

void ProbeLog::unmap() {
  if (header_) ::munmap(header_, bytes_);
  header_ = nullptr;
  bytes_ = 0;
}

}  // namespace ugoki::cli
