#pragma once
// Entries from elsewhere, before they are taken over. Internal to store.

#include <span>
#include <vector>

#include "ugoki/store/library_body.h"

namespace ugoki::store {

/// A problem unless entry and versions are as this module makes them, so that a file of anybody's making cannot break the library that
/// takes them over. @param versions oldest first; the last is the newest. @param place of the library that they come from
[[nodiscard]] Result<void> check_copied(const LibraryBody& from, const EntryRow& entry, const std::vector<VersionRow>& versions);
/// The same for the data of a version: its size, and the id that is made from them.
[[nodiscard]] Result<void> check_copied_data(const LibraryBody& from, const EntryRow& entry, const VersionRow& version,
                                             std::span<const std::byte> data);
[[nodiscard]] Result<void> check_copied_thumbnail(const LibraryBody& from, const EntryRow& entry, std::span<const std::byte> picture);

}  // namespace ugoki::store
