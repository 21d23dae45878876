#include "ugoki/store/library_schema.h"

#include <string>

#include "ugoki/base/sha256.h"
#include "ugoki/store/library.h"
#include "ugoki/store/library_rows.h"
#include "ugoki/store/stamp.h"
#include "ugoki/store/words.h"

namespace ugoki::store {
namespace {

/// The schema of both databases. Words in braces differ between the databases; see spelled(). docs/design/databases.md explains the tables.
constexpr const char* tables = R"(
CREATE TABLE blob (
  hash  {text} PRIMARY KEY NOT NULL,   -- SHA-256 of the bytes
  size  {integer} NOT NULL,
  bytes {bytes} NOT NULL
){strict};
CREATE TABLE entry (
  no          {serial},
  id          {text} NOT NULL UNIQUE,
  kind        {text} NOT NULL,
  name        {text} NOT NULL CHECK (length(name) > 0),
  name_key    {text} NOT NULL,         -- folded words of the name; sort key of lists
  summary     {text} NOT NULL,         -- JSON object
  note        {text} NOT NULL,
  words       {text} NOT NULL,         -- all words that a search can find
  duration_ms {integer} NOT NULL,      -- 0: no duration
  version     {integer} NOT NULL,      -- number of the newest version; its columns are copied here from table `version`
  content     {text} NOT NULL,
  data        {text} NOT NULL REFERENCES blob (hash),
  size        {integer} NOT NULL,
  author      {text} NOT NULL,         -- of the newest version
  thumbnail   {text} REFERENCES blob (hash),
  created     {text} NOT NULL,
  changed     {text} NOT NULL,
  removed     {text},                  -- when the entry was moved to the trash; null: not in the trash
  removed_by  {text}
){strict};
CREATE INDEX entry_by_kind ON entry (kind, removed) WHERE removed IS NULL;  -- covers counting
CREATE INDEX entry_by_name ON entry (kind, name_key, id) WHERE removed IS NULL;
CREATE INDEX entry_by_change ON entry (kind, changed, id) WHERE removed IS NULL;
CREATE INDEX entry_by_duration ON entry (kind, duration_ms, id) WHERE removed IS NULL;
CREATE INDEX entry_removed ON entry (removed) WHERE removed IS NOT NULL;
CREATE INDEX entry_by_data ON entry (data);
CREATE INDEX entry_by_thumbnail ON entry (thumbnail) WHERE thumbnail IS NOT NULL;
CREATE TABLE version (
  entry   {integer} NOT NULL REFERENCES entry (no) ON DELETE CASCADE,
  version {integer} NOT NULL,
  name    {text} NOT NULL,
  summary {text} NOT NULL,
  note    {text} NOT NULL,
  content {text} NOT NULL,             -- content id: letter of the kind and hash of the data
  data    {text} NOT NULL REFERENCES blob (hash),
  size    {integer} NOT NULL,
  author  {text} NOT NULL,
  saved   {text} NOT NULL,
  PRIMARY KEY (entry, version)
){strict};
CREATE INDEX version_by_content ON version (content);
CREATE INDEX version_by_data ON version (data);
CREATE TABLE tag (
  entry {integer} NOT NULL REFERENCES entry (no) ON DELETE CASCADE,
  tag   {text} NOT NULL CHECK (length(tag) > 0),
  kind  {text} NOT NULL,               -- kind of the entry, for counting; empty: the entry is in the trash
  PRIMARY KEY (entry, tag)
){strict};
CREATE INDEX tag_by_kind ON tag (kind, tag);
)";
constexpr const char* sqlite_text =
    "CREATE VIRTUAL TABLE entry_text USING fts5 (name, other, marks, tokenize = 'ascii', prefix = '1 2 3');";
constexpr const char* postgres_text = R"(
CREATE TABLE entry_text (
  entry bigint PRIMARY KEY REFERENCES entry (no) ON DELETE CASCADE,
  terms tsvector NOT NULL
);
CREATE TABLE entry_order (              -- sort keys; a search reads the rows of all matches, so the rows are small
  entry       bigint PRIMARY KEY REFERENCES entry (no) ON DELETE CASCADE,
  duration_ms bigint NOT NULL,
  id          {text} NOT NULL,
  name_key    {text} NOT NULL,
  changed     {text} NOT NULL
);
)";
/// The search index on PostgreSQL maps words to the small rows of entry_order. terms_of() may be declared IMMUTABLE although it reads a
/// table, because words are never updated in place: refresh_words() deletes and inserts both rows, entry_text first. fastupdate is off
/// because otherwise every search would also read the list of pending index entries.
constexpr const char* postgres_index = R"(
CREATE FUNCTION ugoki.terms_of(no bigint) RETURNS tsvector LANGUAGE sql IMMUTABLE AS
  'SELECT terms FROM ugoki.entry_text WHERE entry = no';
CREATE INDEX entry_order_terms ON entry_order USING gin (terms_of(entry)) WITH (fastupdate = off);
)";
constexpr const char* postgres_version = "CREATE TABLE library (version bigint NOT NULL); INSERT INTO library VALUES (4);";
/// Upgrade to version 4. In version 2, the table entry_text had only the words; in version 3 also the sort keys. Neither version had
/// pairs of words (words.h).
constexpr const char* postgres_before_4 =
    "CREATE TEMP TABLE old_text ON COMMIT DROP AS SELECT entry, terms FROM entry_text; DROP TABLE entry_text;";
constexpr const char* postgres_after_3 = R"(
INSERT INTO entry_text (entry, terms)
  SELECT o.entry, o.terms || coalesce((
    SELECT array_to_tsvector(array_agg(DISTINCT pair.mark)) FROM (
      SELECT E'\uE001' || side.mark || word || ' ' || next AS mark
        FROM (VALUES ('p', btrim(e.words)), ('q', e.name_key)) side (mark, words),
             LATERAL (SELECT word, lead(word) OVER (ORDER BY place) AS next
                        FROM unnest(string_to_array(side.words, ' ')) WITH ORDINALITY part (word, place)) two
        WHERE next IS NOT NULL AND word <> E'\uE000' AND next <> E'\uE000') pair), ''::tsvector)
  FROM old_text o JOIN entry e ON e.no = o.entry ORDER BY o.entry;
INSERT INTO entry_order (entry, duration_ms, id, name_key, changed)
  SELECT e.no, e.duration_ms, e.id, e.name_key, e.changed FROM entry_text t JOIN entry e ON e.no = t.entry ORDER BY e.no;
UPDATE library SET version = 4;
)";

/// The schema `text` with the words in braces replaced for one of the databases.
std::string spelled(std::string text, bool postgres) {
  const std::pair<std::string_view, std::string_view> words[] = {
      {"{text}", postgres ? "text COLLATE \"C\"" : "TEXT"},  // COLLATE "C": texts are sorted by bytes, as in SQLite
      {"{integer}", postgres ? "bigint" : "INTEGER"},
      {"{bytes}", postgres ? "bytea" : "BLOB"},
      {"{serial}", postgres ? "bigint GENERATED ALWAYS AS IDENTITY PRIMARY KEY" : "INTEGER PRIMARY KEY"},
      {"{strict}", postgres ? "" : " STRICT"},
  };
  for (const auto& [word, spelling] : words)
    for (std::size_t at = text.find(word); at != std::string::npos; at = text.find(word, at + spelling.size()))
      text.replace(at, word.size(), spelling);
  return text;
}

std::unexpected<Error> newer(const std::string& location, std::int64_t version, std::int64_t known) {
  return fail(ErrorCode::unsupported, location,
              "The library was made by a newer Ugoki (version " + std::to_string(version) + "; this program reads up to version " +
                  std::to_string(known) + ").",
              "Use a newer Ugoki, or choose another library with --library.");
}

/// Reads the integer value of the SQLite pragma `name`.
Result<std::int64_t> pragma(Connection& connection, const char* name) {
  const Result<Rows> rows = connection.query(std::string("PRAGMA ") + name);
  if (!rows) return fail(rows.error());
  return rows->empty() ? 0 : rows->integer(0, 0);
}

/// Upgrades a library of schema version 1, which had no versions, no trash and no blobs. Renames the old tables, copies each entry as the
/// first version of a new entry, and drops the old tables.
Result<void> upgrade_version_1(Connection& connection) {
  if (Result<void> done =
          connection.script("ALTER TABLE entry RENAME TO old_entry; ALTER TABLE tag RENAME TO old_tag;"
                            "ALTER TABLE data RENAME TO old_data; DROP INDEX entry_by_name; DROP TABLE IF EXISTS entry_text");
      !done)
    return done;
  if (Result<void> done = connection.script(spelled(tables, false) + sqlite_text); !done) return done;
  std::string id;
  for (;;) {
    const Result<Rows> rows =
        connection.query("SELECT id, kind, name, summary, created FROM old_entry WHERE id > ?1 ORDER BY id LIMIT 100", {id});
    if (!rows) return fail(rows.error());
    if (rows->empty()) break;
    for (std::size_t r = 0; r < rows->size(); ++r) {
      id = rows->text(r, 0);
      const Value name(id);
      Result<std::optional<std::vector<std::byte>>> data = connection.bytes("SELECT bytes FROM old_data WHERE entry = ?1", {&name, 1});
      const Result<Rows> tags = connection.query("SELECT tag FROM old_tag WHERE entry = ?1 ORDER BY tag", {id});
      if (!data) return fail(std::move(data.error()));
      if (!tags) return fail(tags.error());
      EntryRow entry;
      entry.id = id;
      entry.kind = rows->text(r, 1);
      entry.created = entry.changed = rows->text(r, 4);
      for (std::size_t t = 0; t < tags->size(); ++t) entry.tags.push_back(clean_text(tags->text(t, 0)));
      const std::vector<std::byte> bytes = *data ? std::move(**data) : std::vector<std::byte>();
      entry.newest.name = clean_text(rows->text(r, 2));
      if (entry.newest.name.empty()) entry.newest.name = id;
      entry.newest.summary = rows->text(r, 3);
      entry.newest.content = id;
      // Data that are already damaged get a hash that does not match them, so that reading them fails.
      const Result<EntryKind> kind = entry_kind_named(entry.kind);
      entry.newest.data = kind && entry_id(*kind, bytes) == id ? sha256(bytes) : sha256("damaged " + id);
      entry.newest.size = static_cast<std::int64_t>(bytes.size());
      entry.newest.saved = entry.created;
      if (Result<void> done = put_blob(connection, entry.newest.data, bytes); !done) return done;
      const Result<std::int64_t> no = insert_entry(connection, entry);
      if (!no) return fail(no.error());
      if (Result<void> done = insert_version(connection, *no, entry.newest); !done) return done;
    }
  }
  return connection.script("DROP TABLE old_data; DROP TABLE old_tag; DROP TABLE old_entry");
}

}  // namespace

Result<void> check_library(Database& database) {
  const Result<std::int64_t> count = database.integer("SELECT count(*) FROM sqlite_schema");
  if (!count) return fail(count.error());
  const Result<std::int64_t> application = database.integer("PRAGMA application_id");
  if (!application) return fail(application.error());
  const Result<std::int64_t> version = database.integer("PRAGMA user_version");
  if (!version) return fail(version.error());
  if (*count == 0 && *application == 0 && *version == 0) return {};
  if (*application != library_application_id)
    return fail(ErrorCode::syntax, database.path(), "This database is not a library of Ugoki.",
                "Choose another file with --library or $UGOKI_LIBRARY.");
  if (*version > library_version) return newer(database.path(), *version, library_version);
  if (*version < 1)
    return fail(ErrorCode::syntax, database.path(), "The library has the invalid version " + std::to_string(*version) + ".",
                "Restore it from a backup; the file was not changed.");
  const Result<std::int64_t> others = database.integer("SELECT count(*) FROM sqlite_schema WHERE type IN ('trigger', 'view')");
  if (!others) return fail(others.error());
  if (*others != 0)
    return fail(ErrorCode::structure, database.path(), "The library contains triggers or views that Ugoki did not create.",
                "Do not trust the file; restore it from a backup.");
  return {};
}

Result<void> migrate_library(Connection& connection) {
  Result<std::int64_t> version = pragma(connection, "user_version");
  if (!version) return fail(std::move(version.error()));
  if (*version == library_version) return {};
  if (Result<void> begun = connection.begin(Connection::Access::write); !begun) return begun;
  const auto work = [&]() -> Result<void> {
    version = pragma(connection, "user_version");  // another program may have upgraded the file in the meantime
    if (!version) return fail(std::move(version.error()));
    if (*version == library_version) return {};
    if (*version > library_version) return newer(connection.location(), *version, library_version);
    if (*version == 1) {
      if (Result<void> done = upgrade_version_1(connection); !done) return done;
    } else if (*version == 0) {
      if (Result<void> done = connection.script(spelled(tables, false) + sqlite_text); !done) return done;
    }
    if (Result<void> done = connection.script(stamp_table); !done) return done;  // schema version 2 had no table `stamp`
    return connection.script("PRAGMA application_id = " + std::to_string(library_application_id) +
                             "; PRAGMA user_version = " + std::to_string(library_version));
  };
  if (Result<void> done = work(); !done) {
    connection.rollback();
    return done;
  }
  return connection.commit();
}

Result<void> prepare_postgres(Connection& connection, bool read_only) {
  const auto version = [&]() -> Result<std::int64_t> {
    const Result<Rows> there = connection.query("SELECT count(*) FROM pg_tables WHERE schemaname = 'ugoki' AND tablename = 'library'");
    if (!there) return fail(there.error());
    if (there->integer(0, 0) == 0) return 0;
    const Result<Rows> rows =
        connection.query("SELECT version FROM ugoki.library");  // an error about missing access rights then names the schema
    if (!rows) return fail(rows.error());
    return rows->empty() ? 0 : rows->integer(0, 0);
  };
  Result<std::int64_t> known = version();
  if (!known) return fail(std::move(known.error()));
  if (*known > server_version) return newer(connection.location(), *known, server_version);
  if (*known == server_version) return {};
  if (read_only && *known >= 2)
    return fail(ErrorCode::unsupported, connection.location(),
                "This library was made by an older Ugoki and cannot be upgraded, because it is opened read-only.",
                "Open it once for writing to upgrade it, for example with `ugoki db check`.");
  if (read_only)
    return fail(ErrorCode::unknown, connection.location(), "This database does not contain a library of Ugoki yet.",
                "Add entries with `ugoki import`, or copy a library to it with `ugoki db copy`.");
  if (Result<void> begun = connection.begin(Connection::Access::write); !begun) return begun;
  const auto work = [&]() -> Result<void> {
    // Another program that opens the database at the same time waits for this lock, and then finds the new tables.
    if (const Result<Rows> lock = connection.query("SELECT pg_advisory_xact_lock(1431786316)::text"); !lock) return fail(lock.error());
    known = version();
    if (!known) return fail(std::move(known.error()));
    if (*known == server_version) return {};
    if (*known >= 2) return connection.script(postgres_before_4 + spelled(postgres_text, true) + postgres_after_3 + postgres_index);
    if (Result<void> made = connection.script("CREATE SCHEMA IF NOT EXISTS ugoki"); !made) return made;
    return connection.script(spelled(tables, true) + spelled(postgres_text, true) + postgres_index + postgres_version);
  };
  if (Result<void> done = work(); !done) {
    connection.rollback();
    return done;
  }
  return connection.commit();
}

}  // namespace ugoki::store
