#pragma once
// The zip file that an FMU is: read from memory with bounds, written so that equal contents give equal bytes.

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "ugoki/base/result.h"

namespace ugoki::fmi {

/// True for the first bytes of a zip.
[[nodiscard]] bool is_zip(std::string_view bytes);

struct ArchiveEntry {
  std::string name;         ///< "binaries/linux64/ball.so": no absolute path, no way upwards
  std::uint64_t bytes = 0;  ///< unpacked
};

class Archive {
 public:
  /// Keeps a copy of the bytes. Errors (place: `place`): no zip, damaged, encrypted, names that lead out of it, links, more than
  /// 100,000 entries, or contents of more than 2 GiB or, if large, a hundred times the packed size.
  [[nodiscard]] static Result<Archive> open(std::string bytes, std::string_view place);
  Archive(Archive&&) noexcept;
  Archive& operator=(Archive&&) noexcept;
  ~Archive();

  [[nodiscard]] const std::vector<ArchiveEntry>& entries() const;  ///< files only, by name
  [[nodiscard]] bool has(std::string_view name) const;
  /// The whole entry; damaged ones are refused by their checksum.
  [[nodiscard]] Result<std::string> read(std::string_view name) const;

 private:
  struct Body;
  explicit Archive(std::unique_ptr<Body> body);
  std::unique_ptr<Body> body_;
};

/// A zip of these files (name, bytes), in this order.
[[nodiscard]] Result<std::string> write_archive(const std::vector<std::pair<std::string, std::string>>& files, std::string_view place);

}  // namespace ugoki::fmi
