// Emptying the trash, deletion of unused data, and the check of a library.

#include "ugoki/base/sha256.h"
#include "ugoki/store/library_body.h"

namespace ugoki::store {
namespace {

constexpr const char* unused_blob =
    "NOT EXISTS (SELECT 1 FROM version v WHERE v.data = b.hash) AND NOT EXISTS (SELECT 1 FROM entry e WHERE e.data = b.hash) AND "
    "NOT EXISTS (SELECT 1 FROM entry e WHERE e.thumbnail = b.hash)";

/// A consistency rule of the tables.
struct Rule {
  const char* find;      ///< SELECT that returns the id, content id or tag of each row that violates the rule
  const char* sentence;  ///< message; {} is replaced by the selected text
};
constexpr Rule rules[] = {
    {"SELECT e.id FROM entry e WHERE NOT EXISTS (SELECT 1 FROM version v WHERE v.entry = e.no AND v.version = e.version AND v.data = "
     "e.data AND "
     "v.name = e.name AND v.content = e.content)",
     "The newest version of entry {} is missing or differs from the entry."},
    {"SELECT e.id FROM entry e WHERE NOT EXISTS (SELECT 1 FROM blob b WHERE b.hash = e.data)", "The data of entry {} are missing."},
    {"SELECT e.id FROM entry e WHERE e.thumbnail IS NOT NULL AND NOT EXISTS (SELECT 1 FROM blob b WHERE b.hash = e.thumbnail)",
     "The thumbnail of entry {} is missing."},
    {"SELECT v.content FROM version v WHERE NOT EXISTS (SELECT 1 FROM blob b WHERE b.hash = v.data)",
     "The data {} of an old version are missing."},
    {"SELECT v.content FROM version v WHERE NOT EXISTS (SELECT 1 FROM entry e WHERE e.no = v.entry)",
     "The version with the data {} has no entry."},
    {"SELECT t.tag FROM tag t WHERE NOT EXISTS (SELECT 1 FROM entry e WHERE e.no = t.entry)", "The tag '{}' belongs to no entry."},
};

Result<void> check_rules(Connection& connection, Error& problems) {
  for (const Rule& rule : rules) {
    const Result<Rows> broken = connection.query(std::string(rule.find) + " LIMIT 20");
    if (!broken) return fail(broken.error());
    for (std::size_t r = 0; r < broken->size(); ++r) {
      std::string sentence = rule.sentence;
      sentence.replace(sentence.find("{}"), 2, broken->text(r, 0));
      problems.add(ErrorCode::structure, connection.location(), sentence,
                   "Restore the library from a backup, or remove the entry and import it again.");
    }
  }
  return {};
}

/// Checks the size and the hash of every blob. The list of blobs is read in chunks of 500 rows.
Result<void> check_blobs(Connection& connection, LibraryCheck& out, const std::function<void(double)>& progress) {
  std::string after;
  for (std::size_t done = 0;;) {
    const Result<Rows> names = connection.query("SELECT b.hash, b.size FROM blob b WHERE b.hash > ?1 ORDER BY b.hash LIMIT 500", {after});
    if (!names) return fail(names.error());
    if (names->empty()) return {};
    for (std::size_t r = 0; r < names->size(); ++r, ++done) {
      after = names->text(r, 0);
      const Value name(after);
      const Result<std::optional<std::vector<std::byte>>> bytes =
          connection.bytes("SELECT b.bytes FROM blob b WHERE b.hash = ?1", {&name, 1});
      if (bytes && *bytes && sha256(**bytes) == after && static_cast<std::int64_t>((*bytes)->size()) == names->integer(r, 1)) continue;
      if (bytes && !*bytes) continue;  // another program has deleted the blob since the list was read
      const Result<Rows> users =
          connection.query("SELECT DISTINCT e.id FROM entry e JOIN version v ON v.entry = e.no WHERE v.data = ?1 LIMIT 5", {after});
      std::string ids;
      for (std::size_t u = 0; users && u < users->size(); ++u) ids += (u ? ", " : "") + users->text(u, 0);
      out.problems.add(ErrorCode::syntax, connection.location(),
                       "The data " + after.substr(0, 16) + " of " + (ids.empty() ? "no entry" : ids) + " are damaged.",
                       "Restore an older version of the entry, or remove it and import it again.");
    }
    if (progress && out.blobs > 0) progress(static_cast<double>(done) / static_cast<double>(out.blobs));
  }
}

/// Rebuilds the search words of all entries, 500 entries per transaction.
Result<void> repair_words(const LibraryBody& body) {
  std::int64_t no = 0;
  for (;;) {
    const auto some = [&]() -> Result<bool> {
      const Result<Rows> rows = body.connection->query("SELECT e.no FROM entry e WHERE e.no > ?1 ORDER BY e.no LIMIT 500", {no});
      if (!rows) return fail(rows.error());
      std::int64_t last = no;
      for (std::size_t r = 0; r < rows->size(); ++r) {
        last = rows->integer(r, 0);
        if (Result<void> done = refresh_words(*body.connection, last); !done) return fail(std::move(done.error()));
      }
      no = last;
      return !rows->empty();
    };
    const Result<bool> more = body.in_transaction(some);
    if (!more) return fail(more.error());
    if (!*more) return {};
  }
}

/// True if `text` is a date, or a date and a prefix of a time, in the form in which entries store times.
bool is_day_or_time(std::string_view text) {
  constexpr std::string_view pattern = "dddd-dd-ddTdd:dd:dd.ddd";
  if (text.ends_with('Z')) text.remove_suffix(1);
  if (text.size() < 10 || text.size() > pattern.size()) return false;
  for (std::size_t i = 0; i < text.size(); ++i)
    if (pattern[i] == 'd' ? text[i] < '0' || text[i] > '9' : text[i] != pattern[i]) return false;
  const int month = 10 * (text[5] - '0') + text[6] - '0', day = 10 * (text[8] - '0') + text[9] - '0';
  return month >= 1 && month <= 12 && day >= 1 && day <= 31;
}

}  // namespace

Result<std::size_t> Library::empty_trash(std::string_view before) {
  if (!before.empty() && !is_day_or_time(before))
    return fail(ErrorCode::syntax, path(), "'" + std::string(before) + "' is not a valid date or time; nothing was removed.",
                "Write it as 2026-01-31 or 2026-01-31T18:00 (UTC).");
  return body_->in_transaction([&]() -> Result<std::size_t> {
    const std::string until = before.empty() ? "9999" : std::string(before);
    const Result<Rows> gone =
        body_->connection->query("DELETE FROM entry WHERE removed IS NOT NULL AND removed < ?1 RETURNING no", {until});
    if (!gone) return fail(gone.error());
    return gone->size();
  });
}

Result<std::uint64_t> Library::collect_garbage() {
  return body_->in_transaction([&]() -> Result<std::uint64_t> {
    const Result<Rows> gone = body_->connection->query(std::string("DELETE FROM blob WHERE hash IN (SELECT b.hash FROM blob b WHERE ") +
                                                       unused_blob + ") RETURNING size");
    if (!gone) return fail(gone.error());
    std::uint64_t bytes = 0;
    for (std::size_t r = 0; r < gone->size(); ++r) bytes += static_cast<std::uint64_t>(gone->integer(r, 0));
    return bytes;
  });
}

Result<LibraryCheck> Library::check(bool repair, const std::function<void(double)>& progress) const {
  LibraryCheck out;
  Connection& connection = *body_->connection;
  if (repair)
    if (Result<void> done = repair_words(*body_); !done) return fail(std::move(done.error()));
  if (Result<void> done = connection.check(out.problems); !done) return fail(std::move(done.error()));
  const Result<Rows> counts = connection.query(
      "SELECT (SELECT count(*) FROM entry), (SELECT count(*) FROM version), (SELECT count(*) FROM blob), (SELECT coalesce(sum(size), 0) "
      "FROM blob)");
  if (!counts) return fail(counts.error());
  out.entries = static_cast<std::size_t>(counts->integer(0, 0));
  out.versions = static_cast<std::size_t>(counts->integer(0, 1));
  out.blobs = static_cast<std::size_t>(counts->integer(0, 2));
  out.bytes = static_cast<std::uint64_t>(counts->integer(0, 3));
  if (Result<void> done = check_rules(connection, out.problems); !done) return fail(std::move(done.error()));
  if (Result<void> done = check_blobs(connection, out, progress); !done) return fail(std::move(done.error()));
  const char* not_indexed =
      connection.dialect().postgres
          ? "SELECT e.id FROM entry e WHERE e.removed IS NULL AND NOT EXISTS (SELECT 1 FROM entry_order o JOIN entry_text t ON "
            "t.entry = o.entry WHERE o.entry = e.no AND (o.id, o.name_key, o.changed, o.duration_ms) = "
            "(e.id, e.name_key, e.changed, e.duration_ms)) LIMIT 20"
          : "SELECT e.id FROM entry e WHERE e.removed IS NULL AND NOT EXISTS (SELECT 1 FROM entry_text t WHERE t.rowid = e.no) LIMIT 20";
  const Result<Rows> rows = connection.query(not_indexed);
  if (!rows) return fail(rows.error());
  for (std::size_t r = 0; r < rows->size(); ++r)
    out.problems.add(ErrorCode::structure, path(),
                     "Entry " + rows->text(r, 0) + " is missing from the search index, or its index row is outdated.",
                     "Run `ugoki db check --repair`.");
  return out;
}

}  // namespace ugoki::store
