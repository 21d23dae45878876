// Reading entries, versions, data and tags of a library. Searching is in library_search.cpp.

#include "ugoki/json/json.h"
#include "ugoki/store/library_body.h"
#include "ugoki/store/words.h"

namespace ugoki::store {
namespace {

/// SQL condition, to be appended to a WHERE clause, that selects the entries (`entry e`) in the trash, outside of it, or both.
const char* condition_of(Trash trash) {
  switch (trash) {
    case Trash::no: return " AND e.removed IS NULL";
    case Trash::yes: return " AND e.removed IS NOT NULL";
    case Trash::both: return "";
  }
  return "";
}

}  // namespace

std::unexpected<Error> no_entry(const LibraryBody& body, std::string_view id) {
  return fail(ErrorCode::unknown, body.location(), "The library has no entry '" + std::string(id) + "'.",
              "List the entries with `ugoki db list`.");
}

Result<void> check_item(const LibraryBody& body, std::string_view id, const std::string& name, const std::string& summary) {
  if (name.empty()) return fail(ErrorCode::structure, body.location(id), "An entry of the library needs a name.", "Give the entry a name.");
  const Result<json::Json> parsed = json::parse_json(summary, "summary");
  if (!parsed || !parsed->is_object())
    return fail(ErrorCode::syntax, body.location(id), "The summary of '" + name + "' is not a JSON object.",
                "Give an object, for example {}.");
  return {};
}

Result<LibraryEntry> public_entry(const EntryRow& row) {
  LibraryEntry e;
  const Result<EntryKind> kind = entry_kind_named(row.kind);
  if (!kind) return fail(kind.error());
  e.kind = *kind;
  e.id = row.id;
  e.name = row.newest.name;
  e.summary = row.newest.summary;
  e.tags = row.tags;
  e.created = row.created;
  e.size = static_cast<std::size_t>(row.newest.size);
  e.version = static_cast<int>(row.newest.version);
  e.content = row.newest.content;
  e.note = row.newest.note;
  e.author = row.newest.author;
  e.changed = row.changed;
  e.removed = row.removed;
  e.removed_by = row.removed_by;
  e.thumbnail = !row.thumbnail.empty();
  return e;
}

Result<EntryRow> find_entry(const LibraryBody& body, std::string_view id, Trash trash) {
  Result<std::vector<EntryRow>> found = read_entries(*body.connection, "e.id = ?1", id);
  if (found && found->empty())
    found = read_entries(*body.connection,
                         "e.no IN (SELECT v.entry FROM version v WHERE v.content = ?1)" + std::string(condition_of(trash)), id);
  if (!found) return fail(std::move(found.error()));
  if (found->empty()) return no_entry(body, id);
  EntryRow& entry = found->front();
  if (trash == Trash::no && !entry.removed.empty())
    return fail(ErrorCode::unknown, body.location(id), "'" + entry.newest.name + "' has been in the trash since " + entry.removed + ".",
                "Restore it with `ugoki db undelete " + entry.id + "`.");
  if (trash == Trash::yes && entry.removed.empty())
    return fail(ErrorCode::unknown, body.location(id), "'" + entry.newest.name + "' is not in the trash.",
                "List the trash with `ugoki db list --removed`.");
  return std::move(entry);
}

Result<LibraryEntry> Library::get(std::string_view id) const {
  const Result<EntryRow> row = find_entry(*body_, id, Trash::no);
  if (!row) return fail(row.error());
  return public_entry(*row);
}

Result<LibraryEntry> Library::get_removed(std::string_view id) const {
  const Result<EntryRow> row = find_entry(*body_, id, Trash::yes);
  if (!row) return fail(row.error());
  return public_entry(*row);
}

Result<LibraryEntry> Library::resolve(std::string_view given, std::string_view kind, bool removed) const {
  const std::string text = clean_text(given), key = name_key(text);
  const std::string trash = condition_of(removed ? Trash::yes : Trash::no);
  std::string kinds;
  for (const EntryKind k : entry_kinds)
    if (kind.empty() || name_of(k) == kind) kinds += (kinds.empty() ? "'" : ",'") + std::string(name_of(k)) + "'";
  if (kinds.empty()) return fail(entry_kind_named(kind).error());
  const std::string of_kind = " AND e.kind IN (" + kinds + ")" + trash;
  constexpr std::size_t max_candidates = 100;  // entries whose id begins with the text; a message lists only 8
  Result<std::vector<EntryRow>> found = read_entries(*body_->connection, "e.id = ?1" + of_kind, text);
  if (found && found->empty()) {
    found = read_entries(*body_->connection, "e.name_key = ?1" + of_kind, key, 10'000);
    if (found) std::erase_if(*found, [&](const EntryRow& e) { return e.newest.name != text; });
  }
  if (found && found->empty() && text.size() >= 4)
    found = read_entries(*body_->connection, "e.id >= ?1 AND substr(e.id, 1, " + std::to_string(text.size()) + ") = ?1" + of_kind, text,
                         max_candidates);
  if (!found) return fail(std::move(found.error()));
  if (found->empty()) return no_entry(*body_, text);
  if (found->size() == 1) return public_entry(found->front());
  std::string ids;
  for (std::size_t i = 0; i < found->size() && i < 8; ++i) ids += (i ? ", " : "") + (*found)[i].id + " (" + (*found)[i].kind + ")";
  if (found->size() > 8) ids += " ...";
  return fail(ErrorCode::duplicate, path(), "'" + text + "' matches " + std::to_string(found->size()) + " entries: " + ids + ".",
              "Give the id of one of them.");
}

Result<std::vector<LibraryVersion>> Library::history(std::string_view id) const {
  const Result<EntryRow> entry = find_entry(*body_, id, Trash::both);
  if (!entry) return fail(entry.error());
  const Result<std::vector<VersionRow>> rows = read_versions(*body_->connection, entry->no);
  if (!rows) return fail(rows.error());
  std::vector<LibraryVersion> out;
  for (auto v = rows->rbegin(); v != rows->rend(); ++v)
    out.push_back(
        {static_cast<int>(v->version), v->name, v->summary, v->note, v->content, v->author, v->saved, static_cast<std::size_t>(v->size)});
  return out;
}

Result<std::vector<std::byte>> Library::data(std::string_view id, int version) const {
  const Result<EntryRow> entry = find_entry(*body_, id, Trash::no);
  if (!entry) return fail(entry.error());
  const std::string description = "entry " + entry->id + " '" + entry->newest.name + "'";
  if (version == 0 || version == entry->newest.version) return read_blob(*body_->connection, entry->newest.data, description);
  const Result<Rows> row =
      body_->connection->query("SELECT v.data FROM version v WHERE v.entry = ?1 AND v.version = ?2", {entry->no, std::int64_t{version}});
  if (!row) return fail(row.error());
  if (row->empty())
    return fail(ErrorCode::unknown, body_->location(entry->id),
                "'" + entry->newest.name + "' has no version " + std::to_string(version) + ".",
                "List its versions with `ugoki db history " + entry->id + "`.");
  return read_blob(*body_->connection, row->text(0, 0), description + ", version " + std::to_string(version));
}

Result<std::vector<std::byte>> Library::content(std::string_view content) const {
  const Result<Rows> row =
      body_->connection->query("SELECT v.data FROM version v WHERE v.content = ?1 ORDER BY v.entry, v.version LIMIT 1", {content});
  if (!row) return fail(row.error());
  if (!row->empty()) return read_blob(*body_->connection, row->text(0, 0), "content " + std::string(content));
  return fail(ErrorCode::unknown, path(), "The library has no data with the content id '" + std::string(content) + "'.",
              "Import the original file again.");
}

Result<std::vector<std::byte>> Library::thumbnail(std::string_view id) const {
  const Result<EntryRow> entry = find_entry(*body_, id, Trash::both);
  if (!entry) return fail(entry.error());
  if (entry->thumbnail.empty()) return std::vector<std::byte>();
  return read_blob(*body_->connection, entry->thumbnail, "thumbnail of entry " + entry->id);
}

Result<std::vector<std::pair<std::string, std::size_t>>> Library::tags(std::span<const std::string> kinds, std::size_t limit) const {
  std::string wanted;
  for (const std::string& name : kinds) {
    if (const Result<EntryKind> known = entry_kind_named(name); !known) return fail(known.error());
    wanted += (wanted.empty() ? "'" : ", '") + name + "'";
  }
  for (const EntryKind kind : entry_kinds)
    if (kinds.empty()) wanted += (wanted.empty() ? "'" : ", '") + std::string(name_of(kind)) + "'";
  const Result<Rows> rows =
      body_->connection->query("SELECT tag, sum(n) FROM (SELECT kind, tag, count(*) AS n FROM tag WHERE kind IN (" + wanted +
                               ") GROUP BY kind, tag) x GROUP BY tag ORDER BY sum(n) DESC, tag LIMIT " + std::to_string(limit));
  if (!rows) return fail(rows.error());
  std::vector<std::pair<std::string, std::size_t>> out;
  for (std::size_t r = 0; r < rows->size(); ++r) out.emplace_back(rows->text(r, 0), static_cast<std::size_t>(rows->integer(r, 1)));
  return out;
}

Result<std::size_t> Library::count(EntryKind kind) const {
  const Result<Rows> rows =
      body_->connection->query("SELECT count(*) FROM entry e WHERE e.kind = ?1 AND e.removed IS NULL", {name_of(kind)});
  if (!rows) return fail(rows.error());
  return static_cast<std::size_t>(rows->integer(0, 0));
}

}  // namespace ugoki::store
