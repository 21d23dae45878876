#pragma once
// Reading and writing whole files (native builds only).

#include <cstddef>
#include <span>
#include <string>
#include <string_view>

#include "ugoki/base/result.h"

namespace ugoki::files {

/// Default size limit in bytes (2 GiB): larger than any motion or mechanism file in use. Readers need a small multiple of the file size in
/// memory.
inline constexpr std::size_t default_max_size = std::size_t{1} << 31;

/// Returns an error unless the path is a regular file or a pipe. Devices are refused because some never end (/dev/zero).
/// Errors (their location is the path): the file does not exist, or is a folder, device or socket.
[[nodiscard]] Result<void> check_readable(const std::string& path);

/// Reads all bytes of the file; also works for pipes. Errors (their location is the path): the file does not exist, is not readable,
/// is a folder, device or socket, or is larger than `max_size` bytes; or the disk fails.
[[nodiscard]] Result<std::string> read_file(const std::string& path, std::size_t max_size = default_max_size);

/// Like read_file(), but a pipe is an error too. Does not wait for a program that writes into a pipe.
[[nodiscard]] Result<std::string> read_regular_file(const std::string& path, std::size_t max_size = default_max_size);

/// Replaces the file atomically: writes a temporary file in the same folder, flushes this file to the disk, then renames it.
/// After a failure or a power cut the old file is intact. Keeps the permissions of the replaced file, and follows symbolic links.
/// A named pipe or a character device (/dev/null, /dev/stdout) is not replaced: the bytes are written into it.
/// Errors (their location is the path): missing folder, no permission, no space; the path is a block device or a socket. The temporary file
/// is removed on failure.
[[nodiscard]] Result<void> write_file(const std::string& path, std::span<const std::byte> bytes);
[[nodiscard]] Result<void> write_file(const std::string& path, std::string_view text);

/// A file to write.
struct FileText {
  std::string path;
  std::string text;
};
/// Replaces several files as write_file() does. Nothing is replaced before all new files are on the disk, so that a full disk or a missing
/// permission leaves all old files intact. Pipes and devices are written last. A power cut can leave only some of the files replaced.
[[nodiscard]] Result<void> write_files(std::span<const FileText> files);

}  // namespace ugoki::files
