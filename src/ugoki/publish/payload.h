#pragma once
// The payload of a native program: page and content, appended to the program's file. docs/files.md describes the layout.
//
//   the program (ELF), zeros up to a multiple of 64 bytes
//   page        HTML, UTF-8; zeros up to a multiple of 64 bytes
//   content     executable data (*.ugx)
//   trailer     64 bytes, little-endian: magic "UGOKIEXE", u32 version (1), u32 0, u64 offset and u64 size of the page,
//               u64 offset and u64 size of the content, u64 Hash64 of page and content, u64 0

#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "ugoki/base/result.h"

namespace ugoki::publish {

inline constexpr std::uint32_t payload_version = 1;

/// Returns the bytes of a file: the program, followed by the payload.
[[nodiscard]] std::vector<std::byte> append_payload(std::span<const std::byte> program, std::string_view page,
                                                    std::span<const std::byte> ugx);

/// Views into the file that read_payload() was given.
struct Payload {
  std::string_view page;
  std::span<const std::byte> ugx;
};

/// Reads the payload of a program. @param file all bytes of the program's file; must outlive the result @param name for messages
/// Errors: the file has no payload; the payload is damaged; the payload has another version.
[[nodiscard]] Result<Payload> read_payload(std::span<const std::byte> file, std::string_view name);

}  // namespace ugoki::publish
