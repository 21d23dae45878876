#pragma once
// The file format of executable data (`*.ugx`): a table followed by named sections, each with its own checksum.
//
// Layout, little-endian. Every section starts at a multiple of 64 bytes, so that arrays of numbers can be used without copying.
//
//   offset size  content
//   0      8     magic "UGOKIUGX"
//   8      4     u32 version (1)
//   12     4     u32 number of sections N
//   16     8     u64 size of the file, bytes
//   24     8     u64 Hash64 of the section table
//   32     32    zeros
//   64     64 N  section table: 32 bytes name (UTF-8, zero-padded), u64 offset, u64 size, u64 Hash64 of its bytes, u64 0
//   ...          sections
//
// Sections of version 1:
//
//   scenario       JSON: the scenario document in its canonical form (docs/scenario.md), `circuit` null
//   circuit        JSON: the circuit that the player runs (docs/circuit.md)
//   placements     f64: for every character in order, for every clip in order of start: x, y, z [m], heading [rad]. This is the planar
//                  pose of the motion's origin in the world; world root pose = placement * the motion's root pose
//   mechanism/ID   JSON of a mechanism (formats/mechanism_json.h), one section for each mechanism of the scenario
//   motion/ID      binary of a motion (formats/motion_binary.h), one section for each motion of the tracks
//   head           JSON: {"generator": "ugoki 0.1.0", "project": name}; may be absent

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "ugoki/base/result.h"

namespace ugoki::content {

inline constexpr std::uint32_t ugx_version = 1;

struct UgxSection {
  std::string name;
  std::span<const std::byte> bytes;  ///< view into the memory given to read_ugx()

  [[nodiscard]] std::string_view text() const { return {reinterpret_cast<const char*>(bytes.data()), bytes.size()}; }
};

/// The sections of executable data. Refers to the memory given to read_ugx(), which must outlive this object.
class Ugx {
 public:
  [[nodiscard]] std::span<const UgxSection> sections() const { return sections_; }
  /// Returns the section of this name, or null.
  [[nodiscard]] const UgxSection* find(std::string_view name) const;

 private:
  friend Result<Ugx> read_ugx(std::span<const std::byte> file);
  std::vector<UgxSection> sections_;
};

/// Reads the sections. Checks magic, version, sizes, table and all checksums. Errors name the damaged section.
[[nodiscard]] Result<Ugx> read_ugx(std::span<const std::byte> file);

/// Writes sections into one file, in the order in which they were added.
class UgxWriter {
 public:
  /// Adds a section. @param name 1 ... 31 bytes, unique in the file
  void add(std::string name, std::vector<std::byte> bytes);
  void add(std::string name, std::string_view text);
  /// Returns the bytes of the file.
  [[nodiscard]] std::vector<std::byte> finish() const;

 private:
  struct Entry {
    std::string name;
    std::vector<std::byte> bytes;
  };
  std::vector<Entry> entries_;
};

}  // namespace ugoki::content
