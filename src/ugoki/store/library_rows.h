#pragma once
// Rows of a library and the statements that read and write them; used by saving, importing, copying and migrating. Internal to store.
// The caller must have begun a transaction for all functions that write.

#include <string>
#include <string_view>
#include <vector>

#include "ugoki/store/connection.h"

namespace ugoki::store {

/// One version of an entry.
struct VersionRow {
  std::int64_t version = 1;
  std::string name, summary = "{}", note;
  std::string content;    ///< content id of the data (entry_id())
  std::string data;       ///< SHA-256 of the data: key of the blob
  std::int64_t size = 0;  ///< size of the data, bytes
  std::string author;
  std::string saved;  ///< time at which the version was saved, UTC

  bool operator==(const VersionRow&) const = default;
};

/// One entry with its newest version.
struct EntryRow {
  std::int64_t no = 0;  ///< primary key, local to one database
  std::string id, kind;
  VersionRow newest;
  std::string created, changed;     ///< times of the first and of the newest version, UTC
  std::string removed, removed_by;  ///< when (UTC) and by whom the entry was moved to the trash; empty: not in the trash
  std::string thumbnail;            ///< SHA-256 of the picture: key of the blob; empty: none
  std::vector<std::string> tags;    ///< tags of the entry, sorted
};

/// Columns of `entry e` in the order in which entry_of() reads them.
inline constexpr const char* entry_columns =
    "e.no, e.id, e.kind, e.version, e.name, e.summary, e.note, e.content, e.data, e.size, e.author, e.created, e.changed, e.removed, "
    "e.removed_by, e.thumbnail";
inline constexpr std::size_t entry_column_count = 16;
/// The entry in row `row`, without its tags.
[[nodiscard]] EntryRow entry_of(const Rows& rows, std::size_t row);
/// Columns of `version v` in the order in which version_of() reads them.
inline constexpr const char* version_columns = "v.version, v.name, v.summary, v.note, v.content, v.data, v.size, v.author, v.saved";
[[nodiscard]] VersionRow version_of(const Rows& rows, std::size_t row, std::size_t first_column = 0);

/// Reads the tags of all `entries` and stores them there. Runs one statement per 500 entries.
[[nodiscard]] Result<void> read_tags(Connection& connection, std::vector<EntryRow>& entries);
/// The versions of entry `no`, oldest first.
[[nodiscard]] Result<std::vector<VersionRow>> read_versions(Connection& connection, std::int64_t no);

/// The entries that fulfil a condition, with their tags, sorted by `no`; empty if there is none.
/// @param condition SQL condition on `entry e`, with parameter ?1 @param limit maximum count of entries
[[nodiscard]] Result<std::vector<EntryRow>> read_entries(Connection& connection, std::string_view condition, const Value& parameter,
                                                         std::size_t limit = 10);

/// Stores bytes under their SHA-256 `hash`. Has no effect if they are already stored. Error `range`: more than 512 MiB.
[[nodiscard]] Result<void> put_blob(Connection& connection, const std::string& hash, std::span<const std::byte> bytes);
[[nodiscard]] Result<bool> has_blob(Connection& connection, const std::string& hash);
/// The bytes stored under `hash`, checked against it. @param description names the data in error messages: "entry n-..., version 3"
[[nodiscard]] Result<std::vector<std::byte>> read_blob(Connection& connection, const std::string& hash, const std::string& description);

/// Inserts an entry with its tags and search words, without its versions. @return its `no`, or 0 if an entry has the same id already
[[nodiscard]] Result<std::int64_t> insert_entry(Connection& connection, const EntryRow& entry);
[[nodiscard]] Result<void> insert_version(Connection& connection, std::int64_t no, const VersionRow& version);
[[nodiscard]] Result<void> insert_tag(Connection& connection, std::int64_t no, const std::string& tag);
/// Rebuilds the search words of an entry from its row and its tags. An entry in the trash has no rows in the search index.
[[nodiscard]] Result<void> refresh_words(Connection& connection, std::int64_t no);

/// All strings among the values of a summary (JSON object), at any depth, each followed by a blank.
[[nodiscard]] std::string texts_of(const std::string& summary);

}  // namespace ugoki::store
