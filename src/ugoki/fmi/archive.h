#pragma once
// Reads and writes zip files, the format of FMUs (Functional Mock-up Units). Reads them from memory, with limits against hostile files.
// Equal contents are written as equal bytes.

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "ugoki/base/result.h"

namespace ugoki::fmi {

/// True if the bytes begin like a zip file.
[[nodiscard]] bool is_zip(std::string_view bytes);

/// Name and size of a file in a zip.
struct ArchiveEntry {
  std::string name;         ///< relative path without "..": "binaries/linux64/ball.so"
  std::uint64_t bytes = 0;  ///< unpacked size
};

/// A zip file in memory, opened for reading.
class Archive {
 public:
  /// Opens a zip and keeps its bytes. Errors (location: `location`): it is not a zip, is damaged or encrypted; a name leads out of the
  /// folder into which the zip is unpacked; an entry is a link; there are more than 100,000 entries or 2 GiB of unpacked data; an entry
  /// above 32 MiB unpacks to more than 100 times its packed size (a zip bomb).
  [[nodiscard]] static Result<Archive> open(std::string bytes, std::string_view location);
  Archive(Archive&&) noexcept;
  Archive& operator=(Archive&&) noexcept;
  ~Archive();

  [[nodiscard]] const std::vector<ArchiveEntry>& entries() const;  ///< the files in the zip (no folders), sorted by name
  [[nodiscard]] bool has(std::string_view name) const;
  /// The unpacked bytes of a file. Errors: no such file; its size or checksum is wrong.
  [[nodiscard]] Result<std::string> read(std::string_view name) const;

 private:
  struct Body;
  explicit Archive(std::unique_ptr<Body> body);
  std::unique_ptr<Body> body_;
};

/// Returns the bytes of a zip with these files, in this order. All files get the same date.
/// @param files pairs of name and bytes @param location for messages
[[nodiscard]] Result<std::string> write_archive(const std::vector<std::pair<std::string, std::string>>& files, std::string_view location);

}  // namespace ugoki::fmi
