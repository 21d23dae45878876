#pragma once
// Whole files to and from memory (native only).

#include <cstddef>
#include <span>
#include <string>
#include <string_view>

#include "ugoki/base/result.h"

namespace ugoki::files {

/// 2 GiB: more than any motion or mechanism file; readers need a small multiple of it.
inline constexpr std::size_t default_max_size = std::size_t{1} << 31;

/// All bytes of the file. Works for pipes too. Errors (place: the path): it does not exist, may not be read, is a folder,
/// is larger than `max_size`, or the disk fails.
[[nodiscard]] Result<std::string> read_file(const std::string& path, std::size_t max_size = default_max_size);

/// Replaces the file in one step: the bytes go to a new file in the same folder, to the disk, and only then take the name;
/// after a failure or a power cut the old file is whole. Keeps the permissions of a file that it replaces, and writes through
/// a symbolic link. Errors (place: the path): no such folder, no permission, no space; nothing is left behind then.
[[nodiscard]] Result<void> write_file(const std::string& path, std::span<const std::byte> bytes);
[[nodiscard]] Result<void> write_file(const std::string& path, std::string_view text);

}  // namespace ugoki::files
