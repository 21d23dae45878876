#include "ugoki/store/library.h"

#include <algorithm>
#include <cstdlib>
#include <ctime>
#include <filesystem>

#include "ugoki/base/hash.h"
#include "ugoki/store/library_schema.h"

namespace ugoki::store {
namespace {

constexpr const char* columns = "SELECT id, kind, name, summary, created, size FROM entry";

std::string now_utc() {
  const std::time_t now = std::time(nullptr);
  std::tm utc{};
  gmtime_r(&now, &utc);
  char text[32];
  std::strftime(text, sizeof text, "%Y-%m-%dT%H:%M:%SZ", &utc);
  return text;
}

/// Words separated by blanks.
std::vector<std::string> words_of(std::string_view text) {
  std::vector<std::string> words;
  std::string word;
  for (const char c : text) {
    if (c == ' ' || c == '\t' || c == '\n' || c == '\r' || c == '\0') {
      if (!word.empty()) words.push_back(std::move(word));
      word.clear();
    } else {
      word += c;
    }
  }
  if (!word.empty()) words.push_back(std::move(word));
  return words;
}

/// True if there is a letter or digit for the full-text search to look for.
bool searchable(std::string_view word) {
  return std::any_of(word.begin(), word.end(), [](char c) {
    return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || static_cast<unsigned char>(c) >= 0x80;
  });
}

/// The word as a phrase of FTS5 that may go on: "word"*
std::string phrase_beginning(std::string_view word) {
  std::string out = "\"";
  for (const char c : word) out += c == '"' ? std::string("\"\"") : std::string(1, c);
  return out + "\"*";
}

/// Pattern of LIKE ... ESCAPE '\' that finds `word` anywhere.
std::string like_pattern(std::string_view word) {
  std::string out = "%";
  for (const char c : word) {
    if (c == '%' || c == '_' || c == '\\') out += '\\';
    out += c;
  }
  return out + "%";
}

std::unexpected<Error> no_entry(const std::string& path, std::string_view id) {
  return fail(ErrorCode::unknown, path, "The library has no entry '" + std::string(id) + "'.", "List the entries with `ugoki db list`.");
}

}  // namespace

std::string_view name_of(EntryKind kind) {
  switch (kind) {
    case EntryKind::mechanism: return "mechanism";
    case EntryKind::motion: return "motion";
    case EntryKind::measured: return "measured";
  }
  return "";
}

Result<EntryKind> entry_kind_named(std::string_view name) {
  for (const EntryKind kind : {EntryKind::mechanism, EntryKind::motion, EntryKind::measured})
    if (name_of(kind) == name) return kind;
  return fail(ErrorCode::unknown, "kind", "There is no kind of entry '" + std::string(name) + "'.", "Use mechanism, motion or measured.");
}

std::string entry_id(EntryKind kind, std::span<const std::byte> data) {
  Hash64 hash;
  hash.add_bytes(data.data(), data.size());
  const char* prefix = kind == EntryKind::mechanism ? "m-" : kind == EntryKind::motion ? "n-" : "d-";
  return prefix + hash.hex();
}

std::string Library::default_path() {
  if (const char* path = std::getenv("UGOKI_LIBRARY"); path && *path) return path;
  if (const char* data = std::getenv("XDG_DATA_HOME"); data && *data) return std::string(data) + "/ugoki/library.db";
  const char* home = std::getenv("HOME");
  return std::string(home && *home ? home : ".") + "/.local/share/ugoki/library.db";
}

Result<Library> Library::open(const std::string& path) {
  std::error_code ignored;
  const std::filesystem::path file(path);
  if (file.has_parent_path()) std::filesystem::create_directories(file.parent_path(), ignored);  // opening says it, if this failed
  if (std::filesystem::exists(file, ignored) && std::filesystem::file_size(file, ignored) > 0) {
    Result<Database> look = Database::open(path, OpenMode::read_only);  // a refused file must not be written to
    if (!look) return fail(std::move(look.error()));
    if (Result<void> good = check_library(*look); !good) return fail(std::move(good.error()));
  }
  Result<Database> database = Database::open(path, OpenMode::create);
  if (!database) return fail(std::move(database.error()));
  for (const char* pragma : {"PRAGMA journal_mode = WAL", "PRAGMA synchronous = FULL", "PRAGMA foreign_keys = ON"})
    if (Result<void> done = database->run(pragma); !done) return fail(std::move(done.error()));
  if (Result<void> done = migrate_library(*database); !done) return fail(std::move(done.error()));
  // Full-text search is a bonus of the SQLite at hand: without it, find() compares texts.
  (void)database->run("CREATE VIRTUAL TABLE IF NOT EXISTS entry_text USING fts5(id UNINDEXED, words, prefix='2 3')");
  Library library(std::move(*database));
  library.full_text_ = library.database_.integer("SELECT count(*) FROM entry_text WHERE entry_text MATCH 'a'").has_value();
  return library;
}

Result<Library> Library::open_read_only(const std::string& path) {
  Result<Database> database = Database::open(path, OpenMode::read_only);
  if (!database) return fail(std::move(database.error()));
  if (Result<void> good = check_library(*database); !good) return fail(std::move(good.error()));
  Library library(std::move(*database));
  library.full_text_ = library.database_.integer("SELECT count(*) FROM entry_text WHERE entry_text MATCH 'a'").has_value();
  return library;
}

Result<LibraryEntry> Library::entry_of(Statement& row) const {
  LibraryEntry entry;
  entry.id = row.text(0);
  Result<EntryKind> kind = entry_kind_named(row.text(1));
  if (!kind) return fail(std::move(kind.error()));
  entry.kind = *kind;
  entry.name = row.text(2);
  entry.summary = row.text(3);
  entry.created = row.text(4);
  entry.size = static_cast<std::size_t>(row.integer(5));
  Result<Statement> tags = database_.prepare("SELECT tag FROM tag WHERE entry = ?1 ORDER BY tag");
  if (!tags) return fail(std::move(tags.error()));
  tags->bind(1, entry.id);
  for (;;) {
    const Result<bool> next = tags->step();
    if (!next) return fail(next.error());
    if (!*next) break;
    entry.tags.push_back(tags->text(0));
  }
  return entry;
}

Result<std::vector<LibraryEntry>> Library::find(const LibraryQuery& query) const {
  std::string sql = std::string(columns) + " WHERE 1";
  std::vector<std::string> parameters;
  const auto parameter = [&](std::string value) {
    parameters.push_back(std::move(value));
    return "?" + std::to_string(parameters.size());
  };
  if (!query.kinds.empty()) {
    sql += " AND kind IN (";
    for (std::size_t i = 0; i < query.kinds.size(); ++i) {
      if (const Result<EntryKind> known = entry_kind_named(query.kinds[i]); !known) return fail(known.error());
      sql += (i ? ", " : "") + parameter(query.kinds[i]);
    }
    sql += ")";
  }
  for (const std::string& tag : query.tags) sql += " AND EXISTS (SELECT 1 FROM tag WHERE entry = id AND tag = " + parameter(tag) + ")";
  std::string match;
  for (const std::string& word : words_of(query.text)) {
    if (full_text_ && searchable(word)) {
      match += (match.empty() ? "" : " AND ") + phrase_beginning(word);
      continue;
    }
    const std::string p = parameter(like_pattern(word));
    sql += " AND (name LIKE " + p + " ESCAPE '\\' OR EXISTS (SELECT 1 FROM tag WHERE entry = id AND tag LIKE " + p +
           " ESCAPE '\\') OR EXISTS (SELECT 1 FROM json_tree(summary) WHERE type = 'text' AND value LIKE " + p + " ESCAPE '\\'))";
  }
  if (!match.empty()) sql += " AND id IN (SELECT id FROM entry_text WHERE entry_text MATCH " + parameter(match) + ")";
  sql += " ORDER BY kind, name COLLATE NOCASE, id LIMIT " + std::to_string(query.limit);

  Result<Statement> rows = database_.prepare(sql);
  if (!rows) return fail(std::move(rows.error()));
  for (std::size_t i = 0; i < parameters.size(); ++i) rows->bind(static_cast<int>(i + 1), parameters[i]);
  std::vector<LibraryEntry> out;
  for (;;) {
    const Result<bool> next = rows->step();
    if (!next) return fail(next.error());
    if (!*next) return out;
    Result<LibraryEntry> entry = entry_of(*rows);
    if (!entry) return fail(std::move(entry.error()));
    out.push_back(std::move(*entry));
  }
}

Result<LibraryEntry> Library::get(std::string_view id) const {
  Result<Statement> row = database_.prepare(std::string(columns) + " WHERE id = ?1");
  if (!row) return fail(std::move(row.error()));
  row->bind(1, id);
  const Result<bool> found = row->step();
  if (!found) return fail(found.error());
  if (!*found) return no_entry(path(), id);
  return entry_of(*row);
}

Result<LibraryEntry> Library::resolve(std::string_view text, std::string_view kind) const {
  LibraryQuery query;
  if (!kind.empty()) query.kinds.emplace_back(kind);
  Result<std::vector<LibraryEntry>> all = find(query);
  if (!all) return fail(std::move(all.error()));
  std::vector<const LibraryEntry*> found;
  const auto collect = [&](auto&& fits) {
    if (!found.empty()) return;
    for (const LibraryEntry& entry : *all)
      if (fits(entry)) found.push_back(&entry);
  };
  collect([&](const LibraryEntry& e) { return e.id == text; });
  collect([&](const LibraryEntry& e) { return e.name == text; });
  collect([&](const LibraryEntry& e) { return text.size() >= 4 && e.id.starts_with(text); });
  if (found.empty()) return no_entry(path(), text);
  if (found.size() == 1) return *found.front();
  std::string ids;
  for (std::size_t i = 0; i < found.size() && i < 8; ++i)
    ids += (i ? ", " : "") + found[i]->id + " (" + std::string(name_of(found[i]->kind)) + ")";
  return fail(ErrorCode::duplicate, path(), "'" + std::string(text) + "' names " + std::to_string(found.size()) + " entries: " + ids + ".",
              "Give the id of one of them.");
}

Result<std::vector<std::byte>> Library::data(std::string_view id) const {
  const Result<LibraryEntry> entry = get(id);
  if (!entry) return fail(entry.error());
  Result<Statement> row = database_.prepare("SELECT bytes FROM data WHERE entry = ?1");
  if (!row) return fail(std::move(row.error()));
  row->bind(1, id);
  const Result<bool> found = row->step();
  if (!found) return fail(found.error());
  std::vector<std::byte> bytes = *found ? row->blob(0) : std::vector<std::byte>();
  if (!*found || entry_id(entry->kind, bytes) != entry->id)
    return fail(ErrorCode::syntax, path() + ", entry " + std::string(id), "The data of '" + entry->name + "' are damaged.",
                "Remove the entry and import it again.");
  return bytes;
}

Result<void> Library::refresh_search(std::string_view id) {
  if (!full_text_) return {};
  for (const char* sql :
       {"DELETE FROM entry_text WHERE id = ?1",
        "INSERT INTO entry_text (id, words) SELECT id, name || ' ' || kind || ' ' || "
        "coalesce((SELECT group_concat(tag, ' ') FROM tag WHERE entry = id), '') || ' ' || "
        "coalesce((SELECT group_concat(value, ' ') FROM json_tree(summary) WHERE type = 'text'), '') FROM entry WHERE id = ?1"}) {
    Result<Statement> statement = database_.prepare(sql);
    if (!statement) return fail(std::move(statement.error()));
    if (Result<void> done = statement->bind(1, id).run(); !done) return done;
  }
  return {};
}

Result<std::vector<std::string>> Library::put(std::span<const LibraryItem> items) {
  std::vector<std::string> ids;
  Result<Transaction> transaction = Transaction::begin(database_);
  if (!transaction) return fail(std::move(transaction.error()));
  Result<Statement> has = database_.prepare("SELECT (SELECT bytes FROM data WHERE entry = id) = ?2 FROM entry WHERE id = ?1");
  Result<Statement> insert =
      database_.prepare("INSERT INTO entry (id, kind, name, summary, created, size) VALUES (?1, ?2, ?3, ?4, ?5, ?6)");
  Result<Statement> insert_data = database_.prepare("INSERT INTO data (entry, bytes) VALUES (?1, ?2)");
  Result<Statement> insert_tag = database_.prepare("INSERT OR IGNORE INTO tag (entry, tag) VALUES (?1, ?2)");
  Result<Statement> is_json = database_.prepare("SELECT json_valid(?1) AND json_type(?1) = 'object'");
  for (Result<Statement>* statement : {&has, &insert, &insert_data, &insert_tag, &is_json})
    if (!*statement) return fail(std::move(statement->error()));
  for (const LibraryItem& item : items) {
    if (item.name.empty()) return fail(ErrorCode::structure, path(), "An entry of the library needs a name.", "Give it one with --name.");
    const std::string id = entry_id(item.kind, item.data);
    const Result<bool> judged = is_json->bind(1, item.summary).step();
    if (!judged) return fail(judged.error());
    if (!*judged || is_json->integer(0) == 0)
      return fail(ErrorCode::syntax, path() + ", entry " + id, "The summary of '" + item.name + "' is no JSON object.",
                  "Give an object, for example {}.");
    is_json->reset();
    Result<bool> known = has->bind(1, id).bind_blob(2, item.data).step();
    if (!known) return fail(std::move(known.error()));
    const bool same = *known && has->integer(0) != 0;
    has->reset();
    if (*known && !same)
      return fail(ErrorCode::conflict, path() + ", entry " + id, "Other data have the same id.",
                  "Change the name of what you import a little and try again.");
    if (!*known) {
      if (Result<void> done = insert->bind(1, id)
                                  .bind(2, name_of(item.kind))
                                  .bind(3, item.name)
                                  .bind(4, item.summary)
                                  .bind(5, now_utc())
                                  .bind(6, static_cast<std::int64_t>(item.data.size()))
                                  .run();
          !done)
        return fail(std::move(done.error()));
      if (Result<void> done = insert_data->bind(1, id).bind_blob(2, item.data).run(); !done) return fail(std::move(done.error()));
    }
    for (const std::string& tag : item.tags)
      if (!tag.empty())
        if (Result<void> done = insert_tag->bind(1, id).bind(2, tag).run(); !done) return fail(std::move(done.error()));
    if (Result<void> done = refresh_search(id); !done) return fail(std::move(done.error()));
    ids.push_back(id);
  }
  if (Result<void> done = transaction->commit(); !done) return fail(std::move(done.error()));
  return ids;
}

Result<void> Library::rename(std::string_view id, std::string_view name) {
  if (name.empty()) return fail(ErrorCode::structure, path(), "An entry of the library needs a name.", "Give one.");
  Result<Transaction> transaction = Transaction::begin(database_);
  if (!transaction) return fail(std::move(transaction.error()));
  if (const Result<LibraryEntry> entry = get(id); !entry) return fail(entry.error());
  Result<Statement> update = database_.prepare("UPDATE entry SET name = ?2 WHERE id = ?1");
  if (!update) return fail(std::move(update.error()));
  if (Result<void> done = update->bind(1, id).bind(2, name).run(); !done) return done;
  if (Result<void> done = refresh_search(id); !done) return done;
  return transaction->commit();
}

Result<void> Library::set_tags(std::string_view id, std::span<const std::string> add, std::span<const std::string> remove) {
  Result<Transaction> transaction = Transaction::begin(database_);
  if (!transaction) return fail(std::move(transaction.error()));
  if (const Result<LibraryEntry> entry = get(id); !entry) return fail(entry.error());
  for (const bool adding : {false, true}) {
    Result<Statement> statement = database_.prepare(adding ? "INSERT OR IGNORE INTO tag (entry, tag) VALUES (?1, ?2)"
                                                           : "DELETE FROM tag WHERE entry = ?1 AND tag = ?2");
    if (!statement) return fail(std::move(statement.error()));
    for (const std::string& tag : adding ? add : remove) {
      if (tag.empty()) return fail(ErrorCode::structure, path(), "A tag cannot be empty.", "Give a word.");
      if (Result<void> done = statement->bind(1, id).bind(2, tag).run(); !done) return done;
    }
  }
  if (Result<void> done = refresh_search(id); !done) return done;
  return transaction->commit();
}

Result<void> Library::remove(std::string_view id) {
  Result<Transaction> transaction = Transaction::begin(database_);
  if (!transaction) return fail(std::move(transaction.error()));
  if (const Result<LibraryEntry> entry = get(id); !entry) return fail(entry.error());
  Result<Statement> statement = database_.prepare("DELETE FROM entry WHERE id = ?1");
  if (!statement) return fail(std::move(statement.error()));
  if (Result<void> done = statement->bind(1, id).run(); !done) return done;
  if (Result<void> done = refresh_search(id); !done) return done;
  return transaction->commit();
}

}  // namespace ugoki::store
