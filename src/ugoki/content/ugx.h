#pragma once
// The container of executable data (*.ugx): named sections with checksums, readable in place. Layout: docs/files.md.

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "ugoki/base/result.h"

namespace ugoki::content {

inline constexpr std::uint32_t ugx_version = 1;

/// Collects sections and lays them out, each at a multiple of 64 bytes.
class UgxWriter {
 public:
  /// @param name 1 ... 39 characters, used once
  void add(std::string_view name, std::span<const std::byte> data);
  void add_text(std::string_view name, std::string_view text);
  void add_doubles(std::string_view name, std::span<const double> values);
  [[nodiscard]] std::vector<std::byte> finish() const;

 private:
  struct Section {
    std::string name;
    std::vector<std::byte> data;
  };
  std::vector<Section> sections_;
};

/// Looks into the bytes of a container; owns nothing, so the bytes must outlive it.
class UgxReader {
 public:
  /// Checks magic, version, size, the table and every section's checksum.
  /// @param name for messages, usually the file's name
  [[nodiscard]] static Result<UgxReader> open(std::span<const std::byte> bytes, std::string_view name);

  struct Entry {
    std::string name;
    std::uint64_t offset = 0, size = 0;
  };
  [[nodiscard]] std::span<const Entry> sections() const { return sections_; }
  [[nodiscard]] bool has(std::string_view name) const;
  /// The section's bytes, or a problem that names it.
  [[nodiscard]] Result<std::span<const std::byte>> bytes(std::string_view name) const;
  [[nodiscard]] Result<std::string_view> text(std::string_view name) const;
  /// Copies; so the container itself needs no alignment.
  [[nodiscard]] Result<std::vector<double>> doubles(std::string_view name) const;
  [[nodiscard]] const std::string& name() const { return name_; }

 private:
  std::string name_;
  std::span<const std::byte> data_;
  std::vector<Entry> sections_;
};

}  // namespace ugoki::content
