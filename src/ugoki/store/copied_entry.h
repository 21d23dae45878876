#pragma once
// Checks of entries from another library before they are copied. Internal to store.

#include <span>
#include <vector>

#include "ugoki/store/library_body.h"

namespace ugoki::store {

/// Checks that an entry and its versions obey all rules of this module, so that a hostile file cannot damage the library that receives
/// the copy. @param from source library @param versions all versions of the entry, oldest first
[[nodiscard]] Result<void> check_copied(const LibraryBody& from, const EntryRow& entry, const std::vector<VersionRow>& versions);
/// Checks that the size and the content id of a version match its data.
[[nodiscard]] Result<void> check_copied_data(const LibraryBody& from, const EntryRow& entry, const VersionRow& version,
                                             std::span<const std::byte> data);
/// Checks the size and the format of a thumbnail.
[[nodiscard]] Result<void> check_copied_thumbnail(const LibraryBody& from, const EntryRow& entry, std::span<const std::byte> picture);

}  // namespace ugoki::store
