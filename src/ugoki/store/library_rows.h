#pragma once
// Rows of a library and the statements that write them, for saving, importing, copying and migrating alike. Internal to store.
// Everything here runs inside a transaction of the caller.

#include <string>
#include <string_view>
#include <vector>

#include "ugoki/store/connection.h"

namespace ugoki::store {

/// One version of an entry.
struct VersionRow {
  std::int64_t version = 1;
  std::string name, summary = "{}", note;
  std::string content;  ///< id of the data
  std::string data;     ///< SHA-256 of the data
  std::int64_t size = 0;
  std::string author;
  std::string saved;  ///< UTC

  bool operator==(const VersionRow&) const = default;
};

struct EntryRow {
  std::int64_t no = 0;  ///< in its own database
  std::string id, kind;
  VersionRow newest;
  std::string created, changed;
  std::string removed, removed_by;  ///< empty: not in the trash
  std::string thumbnail;            ///< SHA-256; empty: none
  std::vector<std::string> tags;    ///< sorted
};

/// Columns of `entry e` that entry_of() reads.
inline constexpr const char* entry_columns =
    "e.no, e.id, e.kind, e.version, e.name, e.summary, e.note, e.content, e.data, e.size, e.author, e.created, e.changed, e.removed, "
    "e.removed_by, e.thumbnail";
inline constexpr std::size_t entry_column_count = 16;
[[nodiscard]] EntryRow entry_of(const Rows& rows, std::size_t row);
/// Columns of `version v` that version_of() reads.
inline constexpr const char* version_columns = "v.version, v.name, v.summary, v.note, v.content, v.data, v.size, v.author, v.saved";
[[nodiscard]] VersionRow version_of(const Rows& rows, std::size_t row, std::size_t first_column = 0);

/// Fills in the tags of all these entries with one statement.
[[nodiscard]] Result<void> read_tags(Connection& connection, std::vector<EntryRow>& entries);
/// Oldest first.
[[nodiscard]] Result<std::vector<VersionRow>> read_versions(Connection& connection, std::int64_t no);

/// @param condition of `entry e`, with parameter ?1. Nothing where no entry fits
[[nodiscard]] Result<std::vector<EntryRow>> read_entries(Connection& connection, std::string_view condition, const Value& parameter,
                                                         std::size_t limit = 10);

[[nodiscard]] Result<void> put_blob(Connection& connection, const std::string& hash, std::span<const std::byte> bytes);
[[nodiscard]] Result<bool> has_blob(Connection& connection, const std::string& hash);
/// The bytes, checked against their name. @param what "entry n-..., version 3", for the problem
[[nodiscard]] Result<std::vector<std::byte>> read_blob(Connection& connection, const std::string& hash, const std::string& what);

/// A new entry with its tags and words, without its versions. @return its number, or 0 if there is one of this id already
[[nodiscard]] Result<std::int64_t> insert_entry(Connection& connection, const EntryRow& entry);
[[nodiscard]] Result<void> insert_version(Connection& connection, std::int64_t no, const VersionRow& version);
[[nodiscard]] Result<void> insert_tag(Connection& connection, std::int64_t no, const std::string& tag);
/// Makes the words of an entry anew from what stands in its row and its tags. Entries in the trash are not found by words.
[[nodiscard]] Result<void> refresh_words(Connection& connection, std::int64_t no);

/// All texts among the values of a summary, with blanks between.
[[nodiscard]] std::string texts_of(const std::string& summary);

}  // namespace ugoki::store
