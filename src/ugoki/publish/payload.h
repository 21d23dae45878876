#pragma once
// The payload of a native program: page and content, appended to the program's file. docs/files.md describes the layout.
//
//   the program (ELF), zeros up to a multiple of 64 bytes
//   page        HTML, UTF-8; zeros up to a multiple of 64 bytes
//   content     executable data (*.ugx); zeros up to a multiple of 64 bytes
//   libraries   files of the libraries of LSIs that the program carries; zeros up to a multiple of 64 bytes after each
//   table       128 bytes for each library, little-endian: u64 offset, u64 size, file name (112 bytes, zeros at the end)
//   trailer     64 bytes, little-endian: magic "UGOKIEXE", u32 version (2), u32 number of libraries, u64 offset and u64 size of the page,
//               u64 offset and u64 size of the content, u64 Hash64 of page, content, and name and bytes of each library, u64 offset of
//               the table

#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "ugoki/base/result.h"

namespace ugoki::publish {

inline constexpr std::uint32_t payload_version = 2;

/// The file of a library of LSIs (native code) inside a program.
struct CarriedLibrary {
  std::string name;  ///< file name: letters, digits and ._+- only, at most 111 bytes
  std::span<const std::byte> bytes;
};

/// Returns the bytes of a file: the program, followed by the payload.
[[nodiscard]] std::vector<std::byte> append_payload(std::span<const std::byte> program, std::string_view page,
                                                    std::span<const std::byte> ugx, std::span<const CarriedLibrary> libraries = {});

/// Views into the file that read_payload() was given.
struct Payload {
  std::string_view page;
  std::span<const std::byte> ugx;
  std::vector<CarriedLibrary> libraries;
};

/// Reads the payload of a program. @param file all bytes of the program's file; must outlive the result @param name for messages
/// Errors: the file has no payload; the payload is damaged; the payload has another version.
[[nodiscard]] Result<Payload> read_payload(std::span<const std::byte> file, std::string_view name);

}  // namespace ugoki::publish
