#include "ugoki/store/library_rows.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "ugoki/base/sha256.h"
#include "ugoki/json/json.h"
#include "ugoki/store/words.h"

namespace ugoki::store {
namespace {

using json::Json;

/// Appends all strings inside a JSON value, at any depth, to `out`, each followed by a blank.
void add_texts(const Json& value, std::string& out) {
  if (value.is_string())
    out += value.get<std::string>() + " ";
  else if (value.is_structured())
    for (const Json& inner : value) add_texts(inner, out);
}

/// The summary as a JSON object; an empty object if it is invalid.
Json summary_of(const std::string& summary) {
  Result<Json> parsed = json::parse_json(summary, "summary");
  return parsed && parsed->is_object() ? std::move(*parsed) : Json::object();
}

/// The summary's "duration" [s] in ms; 0 if it is absent, negative or not below 1e12 s.
std::int64_t duration_ms(const std::string& summary) {
  const Json json = summary_of(summary);
  const auto found = json.find("duration");
  const double seconds = found != json.end() && found->is_number() ? found->get<double>() : 0;
  return seconds > 0 && seconds < 1e12 ? std::llround(1000 * seconds) : 0;
}

SearchText search_text(const EntryRow& entry) {
  SearchText text;
  text.name = words_of(entry.newest.name);
  text.add_other(entry.kind);
  for (const std::string& tag : entry.tags) text.add_other(tag);
  text.add_other(entry.newest.note);
  text.add_other(texts_of(entry.newest.summary));
  text.marks.push_back(kind_mark(entry.kind));
  for (const std::string& tag : entry.tags) text.marks.push_back(tag_mark(tag));
  for (const std::string& word : text.name) text.marks.push_back(name_mark(word));
  return text;
}

/// Success or the error of a statement whose result rows are not used.
Result<void> without_rows(Result<Rows> answer) {
  if (!answer) return fail(std::move(answer.error()));
  return {};
}

/// Inserts the rows of an entry into the search index.
Result<void> insert_words(Connection& connection, std::int64_t no, const SearchText& text) {
  if (!connection.dialect().postgres)
    return without_rows(connection.query("INSERT INTO entry_text (rowid, name, other, marks) VALUES (?1, ?2, ?3, ?4)",
                                         {no, text.name_words(), text.other_words(), text.mark_words()}));
  Result<void> done =
      without_rows(connection.query("INSERT INTO entry_text (entry, terms) VALUES (?1, ?2::text::tsvector)", {no, text.tsvector()}));
  if (!done) return done;
  return without_rows(
      connection.query("INSERT INTO entry_order (entry, duration_ms, id, name_key, changed) "
                       "SELECT e.no, e.duration_ms, e.id, e.name_key, e.changed FROM entry e WHERE e.no = ?1",
                       {no}));
}

/// The text as a parameter value; SQL NULL if the text is empty.
Value or_null(const std::string& text) { return text.empty() ? Value() : Value(text); }

}  // namespace

std::string texts_of(const std::string& summary) {
  std::string out;
  add_texts(summary_of(summary), out);
  return out;
}

EntryRow entry_of(const Rows& rows, std::size_t r) {
  EntryRow e;
  e.no = rows.integer(r, 0);
  e.id = rows.text(r, 1);
  e.kind = rows.text(r, 2);
  e.newest = {rows.integer(r, 3), rows.text(r, 4),    rows.text(r, 5),  rows.text(r, 6), rows.text(r, 7),
              rows.text(r, 8),    rows.integer(r, 9), rows.text(r, 10), rows.text(r, 12)};
  e.created = rows.text(r, 11);
  e.changed = rows.text(r, 12);
  e.removed = rows.text(r, 13);
  e.removed_by = rows.text(r, 14);
  e.thumbnail = rows.text(r, 15);
  return e;
}

VersionRow version_of(const Rows& rows, std::size_t r, std::size_t c) {
  return {rows.integer(r, c),  rows.text(r, c + 1),    rows.text(r, c + 2), rows.text(r, c + 3), rows.text(r, c + 4),
          rows.text(r, c + 5), rows.integer(r, c + 6), rows.text(r, c + 7), rows.text(r, c + 8)};
}

Result<void> read_tags(Connection& connection, std::vector<EntryRow>& entries) {
  constexpr std::size_t at_once = 500;  // number of entries read by one statement
  for (std::size_t from = 0; from < entries.size(); from += at_once) {
    std::map<std::int64_t, EntryRow*> by_no;
    std::string numbers;
    for (std::size_t i = from; i < std::min(entries.size(), from + at_once); ++i) {
      by_no.emplace(entries[i].no, &entries[i]);
      numbers += (numbers.empty() ? "" : ",") + std::to_string(entries[i].no);
    }
    // All entry numbers are passed in one text parameter, so the prepared statement is the same for any count.
    const Result<Rows> tags =
        connection.dialect().postgres
            ? connection.query("SELECT entry, tag FROM tag WHERE entry = ANY (string_to_array(?1, ',')::bigint[]) ORDER BY entry, tag",
                               {numbers})
            : connection.query(
                  "SELECT t.entry, t.tag FROM json_each('[' || ?1 || ']') n CROSS JOIN tag t ON t.entry = n.value ORDER BY 1, 2",
                  {numbers});
    if (!tags) return fail(tags.error());
    for (std::size_t r = 0; r < tags->size(); ++r)  // the row is checked, because a damaged file may return tags of other entries
      if (const auto entry = by_no.find(tags->integer(r, 0)); entry != by_no.end()) entry->second->tags.push_back(tags->text(r, 1));
  }
  return {};
}

Result<std::vector<VersionRow>> read_versions(Connection& connection, std::int64_t no) {
  const Result<Rows> rows =
      connection.query("SELECT " + std::string(version_columns) + " FROM version v WHERE v.entry = ?1 ORDER BY v.version", {no});
  if (!rows) return fail(rows.error());
  std::vector<VersionRow> out;
  for (std::size_t r = 0; r < rows->size(); ++r) out.push_back(version_of(*rows, r));
  return out;
}

Result<std::vector<EntryRow>> read_entries(Connection& connection, std::string_view condition, const Value& parameter, std::size_t limit) {
  const Result<Rows> rows = connection.query("SELECT " + std::string(entry_columns) + " FROM entry e WHERE " + std::string(condition) +
                                                 " ORDER BY e.no LIMIT " + std::to_string(limit),
                                             {parameter});
  if (!rows) return fail(rows.error());
  std::vector<EntryRow> out;
  for (std::size_t r = 0; r < rows->size(); ++r) out.push_back(entry_of(*rows, r));
  if (Result<void> done = read_tags(connection, out); !done) return fail(std::move(done.error()));
  return out;
}

Result<void> put_blob(Connection& connection, const std::string& hash, std::span<const std::byte> bytes) {
  constexpr std::size_t max_size = std::size_t{512} << 20;  // of a blob, bytes; SQLite and PostgreSQL limit a value to about 1 GB
  if (bytes.size() > max_size)
    return fail(ErrorCode::range, connection.location(), "The data of an entry are larger than 512 MB.",
                "Split them into several entries.");
  return without_rows(connection.query("INSERT INTO blob (hash, size, bytes) VALUES (?1, ?2, ?3) ON CONFLICT DO NOTHING",
                                       {hash, static_cast<std::int64_t>(bytes.size()), bytes}));
}

Result<bool> has_blob(Connection& connection, const std::string& hash) {
  const Result<Rows> rows = connection.query("SELECT size FROM blob WHERE hash = ?1", {hash});
  if (!rows) return fail(rows.error());
  return !rows->empty();
}

Result<std::vector<std::byte>> read_blob(Connection& connection, const std::string& hash, const std::string& description) {
  const Value name(hash);
  Result<std::optional<std::vector<std::byte>>> bytes = connection.bytes("SELECT bytes FROM blob WHERE hash = ?1", {&name, 1});
  if (!bytes) return fail(std::move(bytes.error()));
  if (!*bytes || sha256(**bytes) != hash)
    return fail(ErrorCode::syntax, connection.location() + ", " + description,
                "The data " + std::string(*bytes ? "are damaged" : "are missing") + " (" + hash.substr(0, 16) + ").",
                "Restore an older version of the entry, or remove the entry and import it again.");
  return std::move(**bytes);
}

Result<std::int64_t> insert_entry(Connection& connection, const EntryRow& e) {
  const SearchText text = search_text(e);
  const VersionRow& v = e.newest;
  const Result<Rows> made = connection.query(
      "INSERT INTO entry (id, kind, name, name_key, summary, note, words, duration_ms, version, content, data, size, author, thumbnail, "
      "created, "
      "changed, removed, removed_by) VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8, ?9, ?10, ?11, ?12, ?13, ?14, ?15, ?16, ?17, ?18) "
      "ON CONFLICT DO NOTHING RETURNING no",
      {e.id, e.kind, v.name, name_key(v.name), v.summary, v.note, text.all(), duration_ms(v.summary), v.version, v.content, v.data, v.size,
       v.author, or_null(e.thumbnail), e.created, e.changed, or_null(e.removed), or_null(e.removed_by)});
  if (!made) return fail(made.error());
  if (made->empty()) return 0;
  const std::int64_t no = made->integer(0, 0);
  for (const std::string& tag : e.tags)
    if (Result<void> done = insert_tag(connection, no, tag); !done) return fail(std::move(done.error()));
  if (e.removed.empty())
    if (Result<void> done = insert_words(connection, no, text); !done) return fail(std::move(done.error()));
  return no;
}

Result<void> insert_version(Connection& connection, std::int64_t no, const VersionRow& v) {
  return without_rows(
      connection.query("INSERT INTO version (entry, version, name, summary, note, content, data, size, author, saved) VALUES (?1, ?2, ?3, "
                       "?4, ?5, ?6, ?7, ?8, ?9, ?10)",
                       {no, v.version, v.name, v.summary, v.note, v.content, v.data, v.size, v.author, v.saved}));
}

Result<void> insert_tag(Connection& connection, std::int64_t no, const std::string& tag) {
  return without_rows(
      connection.query("INSERT INTO tag (entry, tag, kind) SELECT e.no, ?2, CASE WHEN e.removed IS NULL THEN e.kind ELSE '' END "
                       "FROM entry e WHERE e.no = ?1 ON CONFLICT DO NOTHING",
                       {no, tag}));
}

Result<void> refresh_words(Connection& connection, std::int64_t no) {
  const Result<std::vector<EntryRow>> found = read_entries(connection, "e.no = ?1", no);
  if (!found) return fail(found.error());
  if (found->empty()) return {};
  const EntryRow& e = found->front();
  const SearchText text = search_text(e);
  Result<void> done = without_rows(connection.query("UPDATE entry SET name_key = ?2, words = ?3, duration_ms = ?4 WHERE no = ?1",
                                                    {no, name_key(e.newest.name), text.all(), duration_ms(e.newest.summary)}));
  if (done)
    done = without_rows(
        connection.query("UPDATE tag SET kind = ?2 WHERE entry = ?1 AND kind <> ?2", {no, e.removed.empty() ? Value(e.kind) : Value("")}));
  if (done && connection.dialect().postgres) {
    done = without_rows(connection.query("DELETE FROM entry_order WHERE entry = ?1", {no}));
    if (done) done = without_rows(connection.query("DELETE FROM entry_text WHERE entry = ?1", {no}));
  } else if (done) {
    done = without_rows(connection.query("DELETE FROM entry_text WHERE rowid = ?1", {no}));
  }
  if (done && e.removed.empty()) done = insert_words(connection, no, text);
  return done;
}

}  // namespace ugoki::store
