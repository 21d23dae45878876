#pragma once
// The library: mechanisms, motions, measured data, circuits and sets, with all their versions, in one SQLite file or in a PostgreSQL
// database.

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "ugoki/base/result.h"

namespace ugoki::store {

/// Kind of an entry. measured: data of a motion capture system. set: a list of other entries; its data are a JSON array of their ids.
enum class EntryKind : std::uint8_t { mechanism, motion, measured, circuit, set };
inline constexpr EntryKind entry_kinds[] = {EntryKind::mechanism, EntryKind::motion, EntryKind::measured, EntryKind::circuit,
                                            EntryKind::set};
/// Name of a kind: "mechanism", "motion", "measured", "circuit" or "set".
[[nodiscard]] std::string_view name_of(EntryKind kind);
/// The kind with this name; error `unknown` if there is none.
[[nodiscard]] Result<EntryKind> entry_kind_named(std::string_view name);

/// One entry in its newest version, without its data.
struct LibraryEntry {
  /// Id, the same for all versions. Made from the data of the first version: "m-...", "n-...", "d-...", "c-..." or "s-..." by kind
  std::string id;
  EntryKind kind = EntryKind::motion;
  std::string name;
  std::string summary = "{}";     ///< JSON object with properties for display in lists (frames, mass, source ...)
  std::vector<std::string> tags;  ///< tags of the entry, sorted
  std::string created;            ///< time of creation, UTC: "2026-03-01T12:00:00.123Z"
  std::size_t size = 0;           ///< size of the data, bytes
  int version = 1;
  std::string content;  ///< content id: hash of the data of this version (see entry_id())
  std::string note;     ///< free text
  std::string author;   ///< name of the person who saved this version
  std::string changed;  ///< time at which this version was saved, UTC
  std::string removed;  ///< time at which the entry was moved to the trash, UTC; empty: not in the trash
  std::string removed_by;
  bool thumbnail = false;  ///< true: the entry has a thumbnail
};

/// One version of an entry. Versions are immutable. The time `saved` is UTC.
struct LibraryVersion {
  int version = 1;
  std::string name, summary, note, content, author, saved;
  std::size_t size = 0;
};

/// Maximum length of the name of an entry, in characters: longer than the names of files (at most 255 bytes) and takes in use, short enough
/// for lists.
inline constexpr std::size_t max_name_length = 200;

/// Data of a new entry for Library::put().
struct LibraryItem {
  EntryKind kind = EntryKind::motion;
  std::string name = {};
  std::string summary = "{}";
  std::vector<std::string> tags = {};
  std::vector<std::byte> data = {};
  std::string note = {};
};

/// A new version of an entry for Library::save(). Absent fields keep their value.
struct LibrarySave {
  std::string id = {};
  int base = 0;  ///< version on which the change is based; must be the newest
  std::optional<std::string> name = {}, summary = {}, note = {};
  std::optional<std::vector<std::byte>> data = {};
};

enum class LibraryOrder : std::uint8_t {
  relevance,  ///< names that begin with the text, then names that contain it, then others; each group (no text: all) sorted by name
  name,
  newest,  ///< sorted by the time of the last save, newest first
  oldest,
  longest,  ///< sorted by the field "duration" of the summary, longest first
  shortest,
};
/// The order with this name ("relevance", "name", "newest" ...); error `range` if there is none.
[[nodiscard]] Result<LibraryOrder> library_order_named(std::string_view name);

struct LibraryQuery {
  /// Words, or beginnings of words. Each must occur in the entry's name, tags, note, kind or summary. Words in double quotes must be
  /// adjacent.
  std::string text = {};
  std::vector<std::string> kinds = {};  ///< names of the kinds to search; empty: all kinds
  std::vector<std::string> tags = {};   ///< tags that an entry must have, all of them
  std::size_t limit = 10'000;           ///< maximum number of entries on the page
  LibraryOrder order = LibraryOrder::name;
  std::string after = {};  ///< LibraryPage::next of the previous page of the same query; empty: first page
  bool removed = false;    ///< true: search the trash instead
};

struct LibraryPage {
  std::vector<LibraryEntry> entries;
  std::string next;  ///< value for LibraryQuery::after of the next page; empty: this is the last page
  /// Count of matching entries. With text or tags: at most max_counted. Without text and tags: only on the first page, otherwise 0.
  std::size_t total = 0;
  bool total_exact = true;  ///< true: `total` is the exact count; false: more entries may match
};
inline constexpr std::size_t max_counted = 10'000;

/// Result of Library::check().
struct LibraryCheck {
  std::size_t entries = 0, versions = 0, blobs = 0;  ///< numbers of checked entries, versions and blobs (data, thumbnails)
  std::uint64_t bytes = 0;                           ///< total size of the blobs, bytes
  Error problems;                                    ///< problems found; empty: none
};

struct LibraryBody;

/// One connection to a library; used by one thread at a time. Several programs and users may use the same library at the same time.
/// If another program replaces, removes or overwrites the file of a library that is open for writing, the next call fails with `conflict`;
/// calls after it use the file that is then at the path. A change that was acknowledged is in the file that was at the path at that time.
class Library {
 public:
  /// Opens the library at `location`: a file path or "postgresql://user:password@host:port/database". Creates the library if it does not
  /// exist, and upgrades an older version. A file that is not a library, is damaged, or has a newer version is refused and not changed.
  [[nodiscard]] static Result<Library> open(const std::string& location);
  /// Opens an existing library read-only and never writes to it. Of a SQLite file of schema version 1, an upgraded copy in memory is read.
  [[nodiscard]] static Result<Library> open_read_only(const std::string& location);

  /// Location of the default library: $UGOKI_LIBRARY, or else $XDG_DATA_HOME/ugoki/library.db, or else
  /// ~/.local/share/ugoki/library.db.
  [[nodiscard]] static std::string default_path();
  /// False if `location` is a file that does not exist. Always true for a server, which is not contacted.
  [[nodiscard]] static bool exists(const std::string& location);
  /// Folder for files that belong to a library: the folder of the library file, or for a server the folder of the default library file.
  [[nodiscard]] static std::string folder_of(const std::string& location);

  Library(Library&&) noexcept;
  Library& operator=(Library&&) noexcept;
  ~Library();

  /// Sets the author's name, which is stored with every saved version. Default: $UGOKI_AUTHOR, or else the user's login name.
  void set_author(std::string author);
  [[nodiscard]] const std::string& author() const;
  /// Path of the file, or address of the server without the password.
  [[nodiscard]] const std::string& path() const;

  /// A warning for the user: the file could be opened, but its damaged log contains changes that could not be read. A library that is open
  /// for writing has kept a copy of file and log; the warning names it.
  [[nodiscard]] const std::optional<Problem>& warning() const;

  /// True if another connection, of this or another program, changed the library since the previous call, or may have changed it. The first
  /// call begins to observe the changes and returns false. Reconnects to a server if the connection was lost. Takes a few microseconds.
  [[nodiscard]] Result<bool> changed_elsewhere();

  /// One page of the entries that match the query. The text search ignores case and diacritics.
  [[nodiscard]] Result<LibraryPage> find(const LibraryQuery& query = {}) const;
  /// Tags of entries that are not in the trash, each with the count of its entries; the most frequent first.
  /// @param kinds names of the kinds to include; empty: all kinds
  [[nodiscard]] Result<std::vector<std::pair<std::string, std::size_t>>> tags(std::span<const std::string> kinds = {},
                                                                              std::size_t limit = 1000) const;
  /// Count of the entries of a kind, without the trash.
  [[nodiscard]] Result<std::size_t> count(EntryKind kind) const;
  /// The entry with this id; not found if it is in the trash. @param id id of the entry, or content id of any of its versions
  [[nodiscard]] Result<LibraryEntry> get(std::string_view id) const;
  /// The entry with this id in the trash. @param id as in get()
  [[nodiscard]] Result<LibraryEntry> get_removed(std::string_view id) const;
  /// The entry whose id or name is `text`, or whose id begins with `text` (at least 4 characters). Error `unknown` if there is none,
  /// `duplicate` if there are several. @param kind name of a kind; empty: all kinds @param removed true: search the trash instead
  [[nodiscard]] Result<LibraryEntry> resolve(std::string_view text, std::string_view kind = {}, bool removed = false) const;
  /// All versions of an entry, newest first; also of an entry in the trash.
  [[nodiscard]] Result<std::vector<LibraryVersion>> history(std::string_view id) const;

  /// The data of a version, checked against their hash. @param version 0: the newest
  [[nodiscard]] Result<std::vector<std::byte>> data(std::string_view id, int version = 0) const;
  /// The data with this content id, even if they belong to an old version or to an entry in the trash.
  [[nodiscard]] Result<std::vector<std::byte>> content(std::string_view content) const;
  /// The thumbnail, PNG or WebP; empty if the entry has none.
  [[nodiscard]] Result<std::vector<std::byte>> thumbnail(std::string_view id) const;

  /// Adds all items or, after an error, none. If the library already contains the data of an item, the existing entry is kept, restored
  /// from the trash if necessary, and gets the item's tags in addition to its own.
  /// @return ids in the order of the items
  [[nodiscard]] Result<std::vector<std::string>> put(std::span<const LibraryItem> items);
  /// Adds a new version. Error `conflict`: `base` is not the newest version because another version was saved; nothing is changed then.
  [[nodiscard]] Result<LibraryEntry> save(const LibrarySave& save);
  /// Adds a new version with the name, summary, note and data of version `version`. @param base newest version, as in LibrarySave
  [[nodiscard]] Result<LibraryEntry> restore(std::string_view id, int base, int version);
  /// Adds a new entry with the same data, tags and thumbnail, and a new history.
  [[nodiscard]] Result<LibraryEntry> duplicate(std::string_view id, std::string_view name);
  /// Adds a new version with another name, based on the newest version.
  [[nodiscard]] Result<void> rename(std::string_view id, std::string_view name);
  /// Removes the tags `remove`, then adds the tags `add`. Tags are not part of the versions.
  [[nodiscard]] Result<void> set_tags(std::string_view id, std::span<const std::string> add, std::span<const std::string> remove);
  /// Sets the entry's thumbnail. If a new version with different data is saved later, the thumbnail is removed.
  /// @param picture PNG or WebP of at most max_thumbnail bytes; empty: removes the thumbnail
  [[nodiscard]] Result<void> set_thumbnail(std::string_view id, std::span<const std::byte> picture);
  static constexpr std::size_t max_thumbnail = 256 << 10;  ///< maximum size of a thumbnail, bytes

  /// Moves an entry to the trash. It keeps its data and versions, but searches do not find it.
  [[nodiscard]] Result<void> remove(std::string_view id);
  /// Moves an entry out of the trash.
  [[nodiscard]] Result<void> undelete(std::string_view id);
  /// Permanently deletes the entries that were moved to the trash before `before` (UTC, YYYY-MM-DD or YYYY-MM-DDThh:mm...; empty: all).
  /// @return count of deleted entries. Error `syntax`: `before` is not a valid date or time; nothing is deleted then
  [[nodiscard]] Result<std::size_t> empty_trash(std::string_view before = {});
  /// Deletes blobs to which no version and no thumbnail refers. @return bytes deleted
  [[nodiscard]] Result<std::uint64_t> collect_garbage();
  /// Checks the whole library: database structure, references, hashes of all blobs, and that the search index contains all entries.
  /// @param repair true: rebuild the search index first
  /// @param progress called with the completed fraction, 0 ... 1; may be empty
  [[nodiscard]] Result<LibraryCheck> check(bool repair, const std::function<void(double)>& progress = {}) const;

 private:
  friend LibraryBody& body_of(const Library& library);
  explicit Library(std::unique_ptr<LibraryBody> body);
  std::unique_ptr<LibraryBody> body_;
};

/// Content id of data: letter of the kind, '-' and 16 hexadecimal digits (Hash64 of the data).
[[nodiscard]] std::string entry_id(EntryKind kind, std::span<const std::byte> data);

}  // namespace ugoki::store
