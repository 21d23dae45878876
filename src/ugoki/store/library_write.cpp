// Functions that change a library, except for emptying the trash.

#include <algorithm>
#include <random>

#include "ugoki/base/sha256.h"
#include "ugoki/store/library_body.h"
#include "ugoki/store/words.h"

namespace ugoki::store {
namespace {

/// The text after clean_text(), without blanks, tabs and line ends at its beginning and end.
std::string trimmed(std::string_view text) {
  std::string out = clean_text(text);
  const std::size_t from = out.find_first_not_of(" \t\n"), to = out.find_last_not_of(" \t\n");
  return from == std::string::npos ? "" : out.substr(from, to - from + 1);
}

/// Checks a new name, which trimmed() returned. Entries of older libraries may have longer names, and keep them.
Result<void> check_name(const LibraryBody& body, std::string_view id, const std::string& name) {
  const auto length =
      static_cast<std::size_t>(std::ranges::count_if(name, [](char c) { return (static_cast<unsigned char>(c) & 0xC0) != 0x80; }));
  if (length <= max_name_length) return {};
  return fail(ErrorCode::range, body.location(id),
              "The name '" + clean_text(name.substr(0, 40)) + "...' has " + std::to_string(length) + " characters; at most " +
                  std::to_string(max_name_length) + " are allowed.",
              "Give the entry a shorter name.");
}

/// Checks a new tag, which trimmed() returned. Entries of older libraries may have longer tags, and keep them.
Result<void> check_tag(const std::string& location, const std::string& tag) {
  constexpr std::size_t max_bytes = 200;  // far above any tag that fits into the list of tags
  if (tag.size() <= max_bytes) return {};
  return fail(ErrorCode::range, location,
              "The tag '" + clean_text(tag.substr(0, 40)) + "...' has " + std::to_string(tag.size()) + " bytes; at most " +
                  std::to_string(max_bytes) + " are allowed.",
              "Give a shorter tag.");
}

/// On PostgreSQL: locks the entry's row until the end of the transaction. SQLite allows only one writer, so no lock is needed.
Result<void> lock(const LibraryBody& body, std::int64_t no) {
  if (!body.connection->dialect().postgres) return {};
  const Result<Rows> rows =
      body.connection->query("SELECT e.no FROM entry e WHERE e.no = ?1" + body.connection->dialect().lock_suffix, {no});
  if (!rows) return fail(rows.error());
  return {};
}

/// Finds the entry as find_entry() does, and locks it.
Result<EntryRow> lock_entry(const LibraryBody& body, std::string_view id, Trash trash) {
  Result<EntryRow> entry = find_entry(body, id, trash);
  if (!entry) return entry;
  if (Result<void> locked = lock(body, entry->no); !locked) return fail(std::move(locked.error()));
  // On PostgreSQL the entry may have changed before it was locked, so it is read again.
  return body.connection->dialect().postgres ? find_entry(body, id, trash) : std::move(entry);
}

std::unexpected<Error> saved_by_another(const LibraryBody& body, const EntryRow& entry, int base) {
  const VersionRow& v = entry.newest;
  return fail(ErrorCode::conflict, body.location(entry.id),
              "'" + v.name + "' was saved by " + (v.author.empty() ? "somebody" : v.author) + " on " + v.saved + " (version " +
                  std::to_string(v.version) + ") after you had opened version " + std::to_string(base) + "; your change was not saved.",
              "Open version " + std::to_string(v.version) + ", apply your change and save again; both versions stay in the history.");
}

/// Adds `next` as the newest version of `entry`. Error `conflict` unless the newest version in the database is `next.version` - 1.
Result<void> add_version(const LibraryBody& body, const EntryRow& entry, const VersionRow& next) {
  Connection& connection = *body.connection;
  const Result<Rows> updated = connection.query(
      "UPDATE entry SET version = ?2, name = ?3, summary = ?4, note = ?5, content = ?6, data = ?7, size = ?8, author = ?9, changed = ?10, "
      "thumbnail = CASE WHEN data = ?7 THEN thumbnail END WHERE no = ?1 AND version = ?11 AND removed IS NULL RETURNING no",
      {entry.no, next.version, next.name, next.summary, next.note, next.content, next.data, next.size, next.author, next.saved,
       next.version - 1});
  if (!updated) return fail(updated.error());
  if (updated->empty()) {
    const Result<EntryRow> now = find_entry(body, entry.id, Trash::no);
    if (!now) return fail(now.error());
    return saved_by_another(body, *now, static_cast<int>(next.version - 1));
  }
  if (Result<void> done = insert_version(connection, entry.no, next); !done) return done;
  return refresh_words(connection, entry.no);
}

/// Adds one item; see Library::put(). @return its id
Result<std::string> put_item(const LibraryBody& body, const LibraryItem& item, const std::string& now) {
  Connection& connection = *body.connection;
  EntryRow entry;
  entry.id = entry_id(item.kind, item.data);
  entry.kind = name_of(item.kind);
  entry.created = entry.changed = now;
  entry.newest = {1,
                  trimmed(item.name),
                  item.summary,
                  clean_text(item.note),
                  entry.id,
                  sha256(item.data),
                  static_cast<std::int64_t>(item.data.size()),
                  body.author,
                  now};
  if (Result<void> good = check_item(body, entry.id, entry.newest.name, item.summary); !good) return fail(std::move(good.error()));
  if (Result<void> good = check_name(body, entry.id, entry.newest.name); !good) return fail(std::move(good.error()));
  for (const std::string& tag : item.tags)
    if (std::string clean = trimmed(tag); !clean.empty()) {
      if (Result<void> good = check_tag(body.location(entry.id), clean); !good) return fail(std::move(good.error()));
      entry.tags.push_back(std::move(clean));
    }
  std::ranges::sort(entry.tags);
  entry.tags.erase(std::ranges::unique(entry.tags).begin(), entry.tags.end());
  if (Result<void> done = put_blob(connection, entry.newest.data, item.data); !done) return fail(std::move(done.error()));
  const Result<std::int64_t> no = insert_entry(connection, entry);
  if (!no) return fail(no.error());
  if (*no != 0) {
    if (Result<void> done = insert_version(connection, *no, entry.newest); !done) return fail(std::move(done.error()));
    return entry.id;
  }
  const Result<EntryRow> known = lock_entry(body, entry.id, Trash::both);
  if (!known) return fail(known.error());
  const Result<Rows> same =
      connection.query("SELECT v.version FROM version v WHERE v.entry = ?1 AND v.data = ?2", {known->no, entry.newest.data});
  if (!same) return fail(same.error());
  if (same->empty())
    return fail(ErrorCode::conflict, body.location(entry.id), "Different data have the same id (hash collision).",
                "Change the data slightly and try again.");
  for (const std::string& tag : entry.tags)
    if (Result<void> done = insert_tag(connection, known->no, tag); !done) return fail(std::move(done.error()));
  if (!known->removed.empty()) {
    const Result<Rows> back = connection.query("UPDATE entry SET removed = NULL, removed_by = NULL WHERE no = ?1", {known->no});
    if (!back) return fail(back.error());
  }
  if (Result<void> done = refresh_words(connection, known->no); !done) return fail(std::move(done.error()));
  return entry.id;
}

}  // namespace

bool is_picture(std::span<const std::byte> bytes) {
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  return text.starts_with("\x89PNG\r\n\x1a\n") || (text.starts_with("RIFF") && text.size() > 12 && text.substr(8, 4) == "WEBP");
}

Result<std::vector<std::string>> Library::put(std::span<const LibraryItem> items) {
  return body_->in_transaction([&]() -> Result<std::vector<std::string>> {
    const Result<std::string> now = body_->now();
    if (!now) return fail(now.error());
    std::vector<std::string> ids;
    for (const LibraryItem& item : items) {
      Result<std::string> id = put_item(*body_, item, *now);
      if (!id) return fail(std::move(id.error()));
      ids.push_back(std::move(*id));
    }
    return ids;
  });
}

Result<LibraryEntry> Library::save(const LibrarySave& save) {
  return body_->in_transaction([&]() -> Result<LibraryEntry> {
    const Result<EntryRow> entry = lock_entry(*body_, save.id, Trash::no);
    if (!entry) return fail(entry.error());
    if (save.base != entry->newest.version) return saved_by_another(*body_, *entry, save.base);
    const Result<EntryKind> kind = entry_kind_named(entry->kind);
    const Result<std::string> now = body_->now();
    if (!kind || !now) return fail(kind ? now.error() : kind.error());
    VersionRow next = entry->newest;
    if (save.name) next.name = trimmed(*save.name);
    if (save.summary) next.summary = *save.summary;
    if (save.note) next.note = clean_text(*save.note);
    if (Result<void> good = check_item(*body_, save.id, next.name, next.summary); !good) return fail(std::move(good.error()));
    if (next.name != entry->newest.name)
      if (Result<void> good = check_name(*body_, save.id, next.name); !good) return fail(std::move(good.error()));
    if (save.data) {
      next.data = sha256(*save.data);
      next.content = entry_id(*kind, *save.data);
      next.size = static_cast<std::int64_t>(save.data->size());
      if (Result<void> done = put_blob(*body_->connection, next.data, *save.data); !done) return fail(std::move(done.error()));
    }
    if (next == entry->newest) return public_entry(*entry);  // equal to the newest version: nothing to save
    ++next.version;
    next.author = body_->author;
    next.saved = *now;
    if (Result<void> done = add_version(*body_, *entry, next); !done) return fail(std::move(done.error()));
    const Result<EntryRow> after = find_entry(*body_, entry->id, Trash::no);
    if (!after) return fail(after.error());
    return public_entry(*after);
  });
}

Result<LibraryEntry> Library::restore(std::string_view id, int base, int version) {
  Result<std::vector<LibraryVersion>> versions = history(id);
  if (!versions) return fail(std::move(versions.error()));
  const auto old = std::ranges::find(*versions, version, &LibraryVersion::version);
  Result<std::vector<std::byte>> bytes = data(id, version);  // returns an error if the version does not exist
  if (!bytes) return fail(std::move(bytes.error()));
  return save({std::string(id), base, old->name, old->summary, old->note, std::move(*bytes)});
}

Result<void> Library::rename(std::string_view id, std::string_view name) {
  const Result<LibraryEntry> entry = get(id);
  if (!entry) return fail(entry.error());
  const Result<LibraryEntry> saved = save({.id = entry->id, .base = entry->version, .name = std::string(name)});
  if (!saved) return fail(saved.error());
  return {};
}

Result<LibraryEntry> Library::duplicate(std::string_view id, std::string_view name) {
  return body_->in_transaction([&]() -> Result<LibraryEntry> {
    Result<EntryRow> entry = lock_entry(*body_, id, Trash::no);
    if (!entry) return fail(entry.error());
    const Result<std::string> now = body_->now();
    if (!now) return fail(now.error());
    std::random_device random;
    std::string digits;
    while (digits.size() < 16) digits += "0123456789abcdef"[random() % 16];
    entry->id = entry->id.substr(0, 2) + digits;
    entry->created = entry->changed = entry->newest.saved = *now;
    entry->newest.version = 1;
    entry->newest.author = body_->author;
    entry->newest.name = trimmed(name);
    if (Result<void> good = check_item(*body_, id, entry->newest.name, entry->newest.summary); !good) return fail(std::move(good.error()));
    if (Result<void> good = check_name(*body_, id, entry->newest.name); !good) return fail(std::move(good.error()));
    const Result<std::int64_t> no = insert_entry(*body_->connection, *entry);
    if (!no) return fail(no.error());
    if (*no == 0) return fail(ErrorCode::conflict, body_->location(entry->id), "The random id is already in use.", "Try again.");
    if (Result<void> done = insert_version(*body_->connection, *no, entry->newest); !done) return fail(std::move(done.error()));
    return public_entry(*entry);
  });
}

Result<void> Library::set_tags(std::string_view id, std::span<const std::string> add, std::span<const std::string> remove) {
  return body_->in_transaction([&]() -> Result<void> {
    const Result<EntryRow> entry = lock_entry(*body_, id, Trash::no);
    if (!entry) return fail(entry.error());
    for (const bool adding : {false, true}) {
      for (const std::string& tag : adding ? add : remove) {
        const std::string clean = trimmed(tag);
        if (clean.empty()) return fail(ErrorCode::structure, path(), "A tag cannot be empty.", "Give a tag of at least one character.");
        if (Result<void> good = check_tag(path(), clean); adding && !good) return good;
        if (adding) {
          if (Result<void> done = insert_tag(*body_->connection, entry->no, clean); !done) return done;
        } else if (const Result<Rows> gone = body_->connection->query("DELETE FROM tag WHERE entry = ?1 AND tag = ?2", {entry->no, clean});
                   !gone) {
          return fail(gone.error());
        }
      }
    }
    return refresh_words(*body_->connection, entry->no);
  });
}

Result<void> Library::set_thumbnail(std::string_view id, std::span<const std::byte> picture) {
  if (picture.size() > max_thumbnail)
    return fail(ErrorCode::range, body_->location(id), "The picture is larger than " + std::to_string(max_thumbnail >> 10) + " KB.",
                "Reduce its resolution or quality.");
  if (!picture.empty() && !is_picture(picture))
    return fail(ErrorCode::unsupported, body_->location(id), "The picture is neither PNG nor WebP.", "Give a PNG or WebP.");
  return body_->in_transaction([&]() -> Result<void> {
    const Result<EntryRow> entry = lock_entry(*body_, id, Trash::no);
    if (!entry) return fail(entry.error());
    const std::string hash = picture.empty() ? "" : sha256(picture);
    if (!picture.empty())
      if (Result<void> done = put_blob(*body_->connection, hash, picture); !done) return done;
    const Result<Rows> set =
        body_->connection->query("UPDATE entry SET thumbnail = ?2 WHERE no = ?1", {entry->no, hash.empty() ? Value() : Value(hash)});
    if (!set) return fail(set.error());
    return {};
  });
}

Result<void> Library::remove(std::string_view id) {
  return body_->in_transaction([&]() -> Result<void> {
    const Result<EntryRow> entry = lock_entry(*body_, id, Trash::no);
    if (!entry) return fail(entry.error());
    const Result<Rows> gone = body_->connection->query(
        "UPDATE entry SET removed = " + body_->connection->dialect().now + ", removed_by = ?2 WHERE no = ?1", {entry->no, body_->author});
    if (!gone) return fail(gone.error());
    return refresh_words(*body_->connection, entry->no);
  });
}

Result<void> Library::undelete(std::string_view id) {
  return body_->in_transaction([&]() -> Result<void> {
    const Result<EntryRow> entry = lock_entry(*body_, id, Trash::yes);
    if (!entry) return fail(entry.error());
    const Result<Rows> back = body_->connection->query("UPDATE entry SET removed = NULL, removed_by = NULL WHERE no = ?1", {entry->no});
    if (!back) return fail(back.error());
    return refresh_words(*body_->connection, entry->no);
  });
}

}  // namespace ugoki::store
