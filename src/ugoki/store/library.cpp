#include "ugoki/store/library.h"

#include <pwd.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>

#include "ugoki/base/hash.h"
#include "ugoki/store/library_body.h"
#include "ugoki/store/library_schema.h"
#include "ugoki/store/log_damage.h"
#include "ugoki/store/stamp.h"
#include "ugoki/store/words.h"

namespace ugoki::store {
namespace {

namespace fs = std::filesystem;

std::string environment(const char* name) {
  const char* value = std::getenv(name);
  return value != nullptr ? value : "";
}

std::string user_name() {
  if (std::string author = clean_text(environment("UGOKI_AUTHOR")); !author.empty()) return author;
  if (const passwd* user = ::getpwuid(::getuid()); user != nullptr && user->pw_name != nullptr) return clean_text(user->pw_name);
  const std::string user = clean_text(environment("USER"));
  return user.empty() ? "user " + std::to_string(::getuid()) : user;
}

std::string default_file() {
  if (const std::string data = environment("XDG_DATA_HOME"); !data.empty()) return data + "/ugoki/library.db";
  const std::string home = environment("HOME");
  return (home.empty() ? "." : home) + "/.local/share/ugoki/library.db";
}

Result<std::unique_ptr<LibraryBody>> body_on(std::unique_ptr<Connection> connection) {
  auto body = std::make_unique<LibraryBody>();
  body->connection = std::move(connection);
  body->author = user_name();
  return body;
}

/// Error `conflict` if the -wal file beside the library belongs to another file.
Result<void> check_log_of(const std::string& path) {
  std::error_code ignored;
  return check_log(fs::weakly_canonical(path, ignored).string());
}

/// A warning if the -wal file beside the library is damaged; see check_log_damage().
Result<std::optional<Problem>> check_log_damage_of(const std::string& path, DamagedLog handling) {
  std::error_code ignored;
  return check_log_damage(fs::weakly_canonical(path, ignored).string(), handling);
}

/// Opens a file for writing after it was checked without writing: a file that is refused must not be changed.
/// @param mode how to open the file: read_write or create
Result<Database> open_for_writing(const std::string& path, OpenMode mode) {
  std::error_code ignored;
  if (fs::exists(path, ignored) && fs::file_size(path, ignored) > 0) {
    if (Result<void> good = check_log_of(path); !good) return fail(std::move(good.error()));
    Result<Database> look = Database::open(path, OpenMode::read_only);
    if (!look) return look;
    if (Result<void> good = check_library(*look); !good) return fail(std::move(good.error()));
  }
  Result<Database> database = Database::open(path, mode);
  if (!database) return database;
  // busy_timeout [ms]: another program may write for several seconds. cache_size [-KiB]: 128 MiB hold the pages that a search over
  // 100,000 entries reads.
  for (const char* pragma : {"PRAGMA busy_timeout = 10000", "PRAGMA journal_mode = WAL", "PRAGMA synchronous = FULL",
                             "PRAGMA foreign_keys = ON", "PRAGMA cache_size = -131072"})
    if (Result<void> done = database->run(pragma); !done) return fail(std::move(done.error()));
  return database;
}

/// Opens the file that is now at the path of a library whose own file was lost.
Result<Database> reopen_file(const std::string& path) {
  std::error_code ignored;
  if (!fs::exists(path, ignored))
    return fail(ErrorCode::io, path, "The library file was removed or renamed while it was open.",
                "Restore the file, or restart the program to begin a new library.");
  Result<Database> database = open_for_writing(path, OpenMode::read_write);
  if (!database) return database;
  const Result<std::int64_t> version = database->integer("PRAGMA user_version");
  if (!version) return fail(version.error());
  if (*version != library_version)
    return fail(ErrorCode::conflict, path, "The library file was replaced by a library of another version.", "Restart the program.");
  return database;
}

Result<std::unique_ptr<LibraryBody>> open_file(const std::string& path) {
  std::error_code ignored;
  const fs::path file(path);
  if (file.has_parent_path()) fs::create_directories(file.parent_path(), ignored);  // if this failed, Database::open() reports it
  Result<std::optional<Problem>> warning = check_log_damage_of(path, DamagedLog::keep_copy);
  if (!warning) return fail(std::move(warning.error()));
  Result<Database> database = open_for_writing(path, OpenMode::create);
  if (!database) return fail(std::move(database.error()));
  if (path == ":memory:") {
    std::unique_ptr<Connection> connection = sqlite_connection(std::move(*database));
    if (Result<void> done = migrate_library(*connection); !done) return fail(std::move(done.error()));
    return body_on(std::move(connection));
  }
  const Result<std::int64_t> version = database->integer("PRAGMA user_version");
  if (!version) return fail(version.error());
  if (*version != library_version) {
    {
      const std::unique_ptr<Connection> upgrade = sqlite_connection(std::move(*database));
      if (Result<void> done = migrate_library(*upgrade); !done) return fail(std::move(done.error()));
    }  // closes the file, which merges the upgrade into it
    database = open_for_writing(path, OpenMode::read_write);
    if (!database) return fail(std::move(database.error()));
  }
  if (Result<void> done = ensure_stamp(*database); !done) return fail(std::move(done.error()));
  Result<std::unique_ptr<Connection>> connection = watched_sqlite_connection(std::move(*database), [path] { return reopen_file(path); });
  if (!connection) return fail(std::move(connection.error()));
  Result<std::unique_ptr<LibraryBody>> body = body_on(std::move(*connection));
  if (body) (*body)->warning = std::move(*warning);
  return body;
}

Result<std::unique_ptr<LibraryBody>> open_file_read_only(const std::string& path) {
  std::error_code ignored;
  if (!fs::exists(path, ignored))
    return fail(ErrorCode::io, path, "The library does not exist.", "Check the path, or create the library with `ugoki import`.");
  if (Result<void> good = check_log_of(path); !good) return fail(std::move(good.error()));
  Result<std::optional<Problem>> warning = check_log_damage_of(path, DamagedLog::report);
  if (!warning) return fail(std::move(warning.error()));
  Result<Database> database = Database::open(path, OpenMode::read_only);
  if (!database) return fail(std::move(database.error()));
  if (Result<void> good = check_library(*database); !good) return fail(std::move(good.error()));
  const Result<std::int64_t> version = database->integer("PRAGMA user_version");
  if (!version) return fail(version.error());
  if (*version == 0) return fail(ErrorCode::unknown, path, "The file does not contain a library yet.", "Add entries with `ugoki import`.");
  if (*version < first_readable_version) {
    // The file is not changed: its copy in memory is upgraded.
    Result<Database> copy = database->copy_to_memory();
    if (!copy) return fail(std::move(copy.error()));
    std::unique_ptr<Connection> connection = sqlite_connection(std::move(*copy));
    if (Result<void> done = migrate_library(*connection); !done) return fail(std::move(done.error()));
    if (Result<void> done = connection->script("PRAGMA query_only = ON"); !done) return fail(std::move(done.error()));
    return body_on(std::move(connection));
  }
  for (const char* pragma : {"PRAGMA busy_timeout = 10000", "PRAGMA cache_size = -131072"})
    if (Result<void> done = database->run(pragma); !done) return fail(std::move(done.error()));
  Result<std::unique_ptr<LibraryBody>> body = body_on(sqlite_connection(std::move(*database)));
  if (body) (*body)->warning = std::move(*warning);
  return body;
}

Result<std::unique_ptr<LibraryBody>> open_server(const std::string& address, bool read_only) {
  Result<std::unique_ptr<Connection>> connection = postgres_connection(address, read_only);
  if (!connection) return fail(std::move(connection.error()));
  if (Result<void> ready = prepare_postgres(**connection, read_only); !ready) return fail(std::move(ready.error()));
  return body_on(std::move(*connection));
}

}  // namespace

std::string_view name_of(EntryKind kind) {
  switch (kind) {
    case EntryKind::mechanism: return "mechanism";
    case EntryKind::motion: return "motion";
    case EntryKind::measured: return "measured";
    case EntryKind::circuit: return "circuit";
    case EntryKind::set: return "set";
  }
  return "";
}

Result<EntryKind> entry_kind_named(std::string_view name) {
  for (const EntryKind kind : entry_kinds)
    if (name_of(kind) == name) return kind;
  return fail(ErrorCode::unknown, "kind", "There is no entry kind '" + std::string(name) + "'.",
              "Use mechanism, motion, measured, circuit or set.");
}

Result<LibraryOrder> library_order_named(std::string_view name) {
  constexpr std::pair<std::string_view, LibraryOrder> orders[] = {
      {"relevance", LibraryOrder::relevance}, {"name", LibraryOrder::name},       {"newest", LibraryOrder::newest},
      {"oldest", LibraryOrder::oldest},       {"longest", LibraryOrder::longest}, {"shortest", LibraryOrder::shortest}};
  for (const auto& [known, order] : orders)
    if (known == name) return order;
  return fail(ErrorCode::range, "order", "There is no order '" + std::string(name) + "'.",
              "Use relevance, name, newest, oldest, longest or shortest.");
}

std::string entry_id(EntryKind kind, std::span<const std::byte> data) {
  Hash64 hash;
  hash.add_bytes(data.data(), data.size());
  const char* prefix = "";
  switch (kind) {
    case EntryKind::mechanism: prefix = "m-"; break;
    case EntryKind::motion: prefix = "n-"; break;
    case EntryKind::measured: prefix = "d-"; break;
    case EntryKind::circuit: prefix = "c-"; break;
    case EntryKind::set: prefix = "s-"; break;
  }
  return prefix + hash.hex();
}

std::string Library::default_path() {
  const std::string location = environment("UGOKI_LIBRARY");
  return location.empty() ? default_file() : location;
}

bool Library::exists(const std::string& location) {
  std::error_code ignored;
  return is_postgres(location) || fs::exists(location, ignored);
}

std::string Library::folder_of(const std::string& location) {
  return fs::path(is_postgres(location) ? default_file() : location).parent_path().string();
}

Library::Library(std::unique_ptr<LibraryBody> body) : body_(std::move(body)) {}
Library::Library(Library&&) noexcept = default;
Library& Library::operator=(Library&&) noexcept = default;
Library::~Library() = default;

LibraryBody& body_of(const Library& library) { return *library.body_; }

Result<Library> Library::open(const std::string& location) {
  Result<std::unique_ptr<LibraryBody>> body = is_postgres(location) ? open_server(location, false) : open_file(location);
  if (!body) return fail(std::move(body.error()));
  return Library(std::move(*body));
}

Result<Library> Library::open_read_only(const std::string& location) {
  Result<std::unique_ptr<LibraryBody>> body = is_postgres(location) ? open_server(location, true) : open_file_read_only(location);
  if (!body) return fail(std::move(body.error()));
  return Library(std::move(*body));
}

void Library::set_author(std::string author) {
  if (std::string clean = clean_text(author); !clean.empty()) body_->author = std::move(clean);
}
const std::string& Library::author() const { return body_->author; }
const std::optional<Problem>& Library::warning() const { return body_->warning; }
const std::string& Library::path() const { return body_->location(); }
Result<bool> Library::changed_elsewhere() { return body_->connection->changed_elsewhere(); }

}  // namespace ugoki::store
