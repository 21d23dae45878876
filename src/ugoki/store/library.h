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

/// `set`: a list of other entries; its data are a JSON array of their ids.
enum class EntryKind : std::uint8_t { mechanism, motion, measured, circuit, set };
inline constexpr EntryKind entry_kinds[] = {EntryKind::mechanism, EntryKind::motion, EntryKind::measured, EntryKind::circuit,
                                            EntryKind::set};
[[nodiscard]] std::string_view name_of(EntryKind kind);
/// The kind of this name; a problem otherwise.
[[nodiscard]] Result<EntryKind> entry_kind_named(std::string_view name);

/// One entry without its data, as its newest version has it.
struct LibraryEntry {
  std::string id;  ///< through all its versions: made from the first data that it had. "m-...", "n-...", "d-...", "c-...", "s-..."
  EntryKind kind = EntryKind::motion;
  std::string name;
  std::string summary = "{}";     ///< JSON object: what lists show (frames, mass, source ...)
  std::vector<std::string> tags;  ///< sorted
  std::string created;            ///< UTC, "2026-03-01T12:00:00.123Z"
  std::size_t size = 0;           ///< bytes of the data
  int version = 1;
  std::string content;  ///< id of exactly the data of this version
  std::string note;     ///< free text
  std::string author;   ///< who saved this version
  std::string changed;  ///< UTC, when this version was saved
  std::string removed;  ///< UTC, when it was thrown into the trash; empty: it was not
  std::string removed_by;
  bool thumbnail = false;
};

/// One version of an entry. Versions are never changed.
struct LibraryVersion {
  int version = 1;
  std::string name, summary, note, content, author, saved;
  std::size_t size = 0;
};

/// What is put in.
struct LibraryItem {
  EntryKind kind = EntryKind::motion;
  std::string name = {};
  std::string summary = "{}";
  std::vector<std::string> tags = {};
  std::vector<std::byte> data = {};
  std::string note = {};
};

/// A new version of an entry: what is absent stays as it was.
struct LibrarySave {
  std::string id = {};
  int base = 0;  ///< the version that was changed
  std::optional<std::string> name = {}, summary = {}, note = {};
  std::optional<std::vector<std::byte>> data = {};
};

enum class LibraryOrder : std::uint8_t {
  relevance,  ///< names that begin with the text, names that hold it, the others; each by name. Without text: by name
  name,
  newest,  ///< last saved first
  oldest,
  longest,  ///< by the summary's "duration"
  shortest,
};
[[nodiscard]] Result<LibraryOrder> library_order_named(std::string_view name);

struct LibraryQuery {
  std::string text = {};  ///< words (or their beginnings) of name, tags, note, kind or summary; all must be found. "in quotes": in a row
  std::vector<std::string> kinds = {};  ///< names of kinds; empty: all
  std::vector<std::string> tags = {};   ///< all of them
  std::size_t limit = 10'000;
  LibraryOrder order = LibraryOrder::name;
  std::string after = {};  ///< `next` of the page before, with otherwise the same query
  bool removed = false;    ///< the trash instead
};

struct LibraryPage {
  std::vector<LibraryEntry> entries;
  std::string next;  ///< empty: nothing follows
  std::size_t total =
      0;  ///< entries that fit: at most counted_at_most where words or tags are asked for; without them told with the first page only
  bool total_exact = true;
};
inline constexpr std::size_t counted_at_most = 10'000;

/// What `check` found out.
struct LibraryCheck {
  std::size_t entries = 0, versions = 0, blobs = 0;
  std::uint64_t bytes = 0;
  Error problems;  ///< empty: all is well
};

struct LibraryBody;

/// One connection, used by one thread at a time. Several programs and people may use the same library at once.
class Library {
 public:
  /// Opens what `place` names, a file or "postgresql://user:password@host:port/database": makes it if it does not exist, brings an
  /// older version up to date. What is no library, is damaged, or is of a newer version is refused and left as it is.
  [[nodiscard]] static Result<Library> open(const std::string& place);
  /// Opens an existing library without ever writing to it.
  [[nodiscard]] static Result<Library> open_read_only(const std::string& place);

  /// $UGOKI_LIBRARY, or else ~/.local/share/ugoki/library.db ($XDG_DATA_HOME honoured).
  [[nodiscard]] static std::string default_path();
  /// False for a file that does not exist; a server is always worth asking.
  [[nodiscard]] static bool exists(const std::string& place);
  /// Folder for files that go with a library: the file's own, or the one of the default library where it is on a server.
  [[nodiscard]] static std::string folder_of(const std::string& place);

  Library(Library&&) noexcept;
  Library& operator=(Library&&) noexcept;
  ~Library();

  /// The name that stands at what is saved: $UGOKI_AUTHOR, or else the user's name on this computer.
  void set_author(std::string author);
  [[nodiscard]] const std::string& author() const;
  /// The file, or the server's address without password.
  [[nodiscard]] const std::string& path() const;

  /// Text is searched for without regard to case and diacritics.
  [[nodiscard]] Result<LibraryPage> find(const LibraryQuery& query = {}) const;
  /// Tags of entries that are not in the trash, with how many have each; the most frequent first.
  /// @param kinds names; empty: all
  [[nodiscard]] Result<std::vector<std::pair<std::string, std::size_t>>> tags(std::span<const std::string> kinds = {},
                                                                              std::size_t limit = 1000) const;
  /// How many entries of a kind there are, without the trash.
  [[nodiscard]] Result<std::size_t> count(EntryKind kind) const;
  /// @param id of an entry or of a version's data; a problem where there is none, or only one in the trash
  [[nodiscard]] Result<LibraryEntry> get(std::string_view id) const;
  [[nodiscard]] Result<LibraryEntry> get_removed(std::string_view id) const;
  /// The entry that `text` names: its id, its name, or the beginning of its id. A problem if there is none or several.
  [[nodiscard]] Result<LibraryEntry> resolve(std::string_view text, std::string_view kind = {}, bool removed = false) const;
  /// Newest first; also of an entry in the trash.
  [[nodiscard]] Result<std::vector<LibraryVersion>> history(std::string_view id) const;

  /// The data of the newest version (or of another), checked against their hash.
  [[nodiscard]] Result<std::vector<std::byte>> data(std::string_view id, int version = 0) const;
  /// Exactly these data, whatever happened to their entry since; the trash is looked through as well.
  /// @param content id of a version's data
  [[nodiscard]] Result<std::vector<std::byte>> content(std::string_view content) const;
  /// PNG or WebP; empty: there is none.
  [[nodiscard]] Result<std::vector<std::byte>> thumbnail(std::string_view id) const;

  /// Puts in all items or none. Data that the library has already stay as they are (and come back from the trash); new tags are added to
  /// them.
  /// @return ids in the order of the items
  [[nodiscard]] Result<std::vector<std::string>> put(std::span<const LibraryItem> items);
  /// Makes a new version. Error `conflict`: somebody saved another version since `base`; nothing is changed then.
  [[nodiscard]] Result<LibraryEntry> save(const LibrarySave& save);
  /// Saves what version `version` was as the newest one.
  [[nodiscard]] Result<LibraryEntry> restore(std::string_view id, int base, int version);
  /// A new entry with the same data, tags and thumbnail; its history begins anew.
  [[nodiscard]] Result<LibraryEntry> duplicate(std::string_view id, std::string_view name);
  /// A new version with another name, of whatever is the newest now.
  [[nodiscard]] Result<void> rename(std::string_view id, std::string_view name);
  [[nodiscard]] Result<void> set_tags(std::string_view id, std::span<const std::string> add, std::span<const std::string> remove);
  /// @param picture PNG or WebP of at most most_thumbnail bytes; empty: takes it away. A save of other data takes it away as well.
  [[nodiscard]] Result<void> set_thumbnail(std::string_view id, std::span<const std::byte> picture);
  static constexpr std::size_t most_thumbnail = 256 << 10;

  /// Into the trash, where it keeps everything but is not found.
  [[nodiscard]] Result<void> remove(std::string_view id);
  [[nodiscard]] Result<void> undelete(std::string_view id);
  /// Takes out of the trash for ever what was removed before `before` (UTC, YYYY-MM-DD or YYYY-MM-DDThh:mm...; empty: everything).
  /// @return how many. Errors: what is no day or time, before anything is removed
  [[nodiscard]] Result<std::size_t> empty_trash(std::string_view before = {});
  /// Removes data that no version and no thumbnail uses. @return how many bytes
  [[nodiscard]] Result<std::uint64_t> collect_garbage();
  /// Reads everything: structure, references, every blob against its hash, the index of the search against the entries.
  /// @param repair makes the index of the search anew
  /// @param progress gets 0 ... 1; may be empty
  [[nodiscard]] Result<LibraryCheck> check(bool repair, const std::function<void(double)>& progress = {}) const;

 private:
  friend LibraryBody& body_of(const Library& library);
  explicit Library(std::unique_ptr<LibraryBody> body);
  std::unique_ptr<LibraryBody> body_;
};

/// The id of these data: the kind's letter and 16 hexadecimal digits.
[[nodiscard]] std::string entry_id(EntryKind kind, std::span<const std::byte> data);

}  // namespace ugoki::store
