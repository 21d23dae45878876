#pragma once
// The library: mechanisms, motions and measured data that were imported, in one SQLite file.

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "ugoki/base/result.h"
#include "ugoki/store/sqlite.h"

namespace ugoki::store {

enum class EntryKind { mechanism, motion, measured };
[[nodiscard]] std::string_view name_of(EntryKind kind);
/// The kind of this name; a problem otherwise.
[[nodiscard]] Result<EntryKind> entry_kind_named(std::string_view name);

/// One entry without its data.
struct LibraryEntry {
  std::string id;  ///< made from the data: equal data have equal ids. "m-...", "n-...", "d-..."
  EntryKind kind = EntryKind::motion;
  std::string name;
  std::string summary = "{}";     ///< JSON object: what lists show (frames, mass, source ...)
  std::vector<std::string> tags;  ///< sorted
  std::string created;            ///< UTC, "2026-03-01T12:00:00Z"
  std::size_t size = 0;           ///< bytes of the data
};

/// What is put in.
struct LibraryItem {
  EntryKind kind = EntryKind::motion;
  std::string name;
  std::string summary = "{}";
  std::vector<std::string> tags;
  std::vector<std::byte> data;
};

struct LibraryQuery {
  std::string text;                ///< words (or their beginnings) of name, tags or summary; all must be found
  std::vector<std::string> kinds;  ///< names of kinds; empty: all
  std::vector<std::string> tags;   ///< all of them
  std::size_t limit = 10'000;
};

class Library {
 public:
  /// Opens the file, makes it (and its folder) if it does not exist, brings an older version up to date. A file that is
  /// no library, is damaged, or is of a newer version is refused and left as it is.
  [[nodiscard]] static Result<Library> open(const std::string& path);
  /// Opens an existing library without ever writing to it.
  [[nodiscard]] static Result<Library> open_read_only(const std::string& path);

  /// $UGOKI_LIBRARY, or else ~/.local/share/ugoki/library.db ($XDG_DATA_HOME honoured).
  [[nodiscard]] static std::string default_path();

  /// By kind, then name. Text is searched for without regard to case.
  [[nodiscard]] Result<std::vector<LibraryEntry>> find(const LibraryQuery& query = {}) const;
  [[nodiscard]] Result<LibraryEntry> get(std::string_view id) const;
  /// The entry that `text` names: its id, the beginning of its id, or its name. A problem if there is none or several.
  [[nodiscard]] Result<LibraryEntry> resolve(std::string_view text, std::string_view kind = {}) const;
  /// The data, checked against the id.
  [[nodiscard]] Result<std::vector<std::byte>> data(std::string_view id) const;

  /// Puts in all items or none. Data that the library has already stay as they are; new tags are added to them.
  /// @return ids in the order of the items
  [[nodiscard]] Result<std::vector<std::string>> put(std::span<const LibraryItem> items);
  [[nodiscard]] Result<void> rename(std::string_view id, std::string_view name);
  [[nodiscard]] Result<void> set_tags(std::string_view id, std::span<const std::string> add, std::span<const std::string> remove);
  [[nodiscard]] Result<void> remove(std::string_view id);

  [[nodiscard]] const std::string& path() const { return database_.path(); }

 private:
  explicit Library(Database database) : database_(std::move(database)) {}
  Result<LibraryEntry> entry_of(Statement& row) const;
  Result<void> refresh_search(std::string_view id);
  mutable Database database_;
  bool full_text_ = false;
};

/// The id of these data: the kind's letter and 16 hexadecimal digits.
[[nodiscard]] std::string entry_id(EntryKind kind, std::span<const std::byte> data);

}  // namespace ugoki::store
