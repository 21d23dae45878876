#include "ugoki/store/library_schema.h"

#include <array>

namespace ugoki::store {
namespace {

/// Entry i brings version i up to version i + 1.
constexpr std::array<const char*, library_version> migrations = {R"(
CREATE TABLE entry (
  id      TEXT PRIMARY KEY NOT NULL,
  kind    TEXT NOT NULL CHECK (kind IN ('mechanism', 'motion', 'measured')),
  name    TEXT NOT NULL CHECK (length(name) > 0),
  summary TEXT NOT NULL DEFAULT '{}',
  created TEXT NOT NULL,
  size    INTEGER NOT NULL
) STRICT;
CREATE INDEX entry_by_name ON entry (kind, name);
CREATE TABLE tag (
  entry TEXT NOT NULL REFERENCES entry (id) ON DELETE CASCADE,
  tag   TEXT NOT NULL CHECK (length(tag) > 0),
  PRIMARY KEY (entry, tag)
) STRICT, WITHOUT ROWID;
CREATE TABLE data (
  entry TEXT PRIMARY KEY NOT NULL REFERENCES entry (id) ON DELETE CASCADE,
  bytes BLOB NOT NULL
) STRICT;
)"};

}  // namespace

Result<void> check_library(Database& database) {
  const Result<std::int64_t> tables = database.integer("SELECT count(*) FROM sqlite_schema");
  if (!tables) return fail(tables.error());
  const Result<std::int64_t> application = database.integer("PRAGMA application_id");
  if (!application) return fail(application.error());
  const Result<std::int64_t> version = database.integer("PRAGMA user_version");
  if (!version) return fail(version.error());
  if (*tables == 0 && *application == 0 && *version == 0) return {};
  if (*application != library_application_id)
    return fail(ErrorCode::syntax, database.path(), "This database is not a library of Ugoki.",
                "Choose another file with --library or $UGOKI_LIBRARY.");
  if (*version > library_version)
    return fail(ErrorCode::unsupported, database.path(),
                "The library was made by a newer Ugoki (version " + std::to_string(*version) + "; this program knows " +
                    std::to_string(library_version) + ").",
                "Use a newer Ugoki, or choose another file with --library.");
  if (*version < 1)
    return fail(ErrorCode::syntax, database.path(), "The library has an impossible version.",
                "Restore it from a copy; it was left as it is.");
  return database.check_structure();
}

Result<void> migrate_library(Database& database) {
  Result<std::int64_t> version = database.integer("PRAGMA user_version");
  if (!version) return fail(std::move(version.error()));
  if (*version == library_version) return {};
  Result<Transaction> transaction = Transaction::begin(database);
  if (!transaction) return fail(std::move(transaction.error()));
  version = database.integer("PRAGMA user_version");  // another program may have been faster
  if (!version) return fail(std::move(version.error()));
  for (std::int64_t v = *version; v < library_version; ++v)
    if (Result<void> done = database.run(migrations[static_cast<std::size_t>(v)]); !done) return done;
  Result<void> marked = database.run("PRAGMA application_id = " + std::to_string(library_application_id) +
                                     "; PRAGMA user_version = " + std::to_string(library_version));
  if (!marked) return marked;
  return transaction->commit();
}

}  // namespace ugoki::store
