#include "ugoki/store/copy.h"

#include <fcntl.h>
#include <signal.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <filesystem>
#include <map>
#include <set>

#include "ugoki/base/number.h"
#include "ugoki/json/json.h"
#include "ugoki/store/copied_entry.h"
#include "ugoki/store/library_body.h"

namespace ugoki::store {
namespace {

namespace fs = std::filesystem;

/// Appends all strings inside a JSON value, at any depth, to `out`.
void collect_texts(const json::Json& value, std::vector<std::string>& out) {
  if (value.is_string())
    out.push_back(value.get<std::string>());
  else if (value.is_structured())
    for (const json::Json& inner : value) collect_texts(inner, out);
}

/// True if `text` has the form of an entry id: letter of a kind, '-', 16 hexadecimal digits.
bool looks_like_id(const std::string& text) {
  return text.size() == 18 && text[1] == '-' && std::string_view("mndcs").contains(text[0]) &&
         text.find_first_not_of("0123456789abcdef", 2) == std::string::npos;
}

/// One copy operation from library `from` to library `to`.
class Copy {
 public:
  Copy(const Library& from, Library& to, const CopyOptions& options) : from_(body_of(from)), to_(body_of(to)), options_(options) {}

  Result<CopyReport> run() {
    const Result<Rows> count = from_.connection->query("SELECT count(*), coalesce(max(no), 0) FROM entry");
    if (!count) return fail(count.error());
    const std::size_t all = options_.entries.empty() ? static_cast<std::size_t>(count->integer(0, 0)) : options_.entries.size();
    std::int64_t no = 0;
    for (std::size_t done = 0; done < all || options_.entries.empty();) {
      if (options_.stop && options_.stop())
        return fail(ErrorCode::cancelled, to_.location(), "The copy was stopped.", "Run it again to continue from here.");
      Result<std::vector<EntryRow>> some = options_.entries.empty() ? next_entries(no) : named_entries(done);
      if (!some) return fail(std::move(some.error()));
      if (some->empty()) break;
      const CopyReport before = report_;
      const Result<bool> copied = to_.in_transaction([&]() -> Result<bool> {
        report_ = before;  // restart the counts here if the transaction is repeated after a conflict
        for (const EntryRow& entry : *some)
          if (Result<void> one = copy_entry(entry); !one) return fail(std::move(one.error()));
        return true;
      });
      if (!copied) return fail(copied.error());
      no = some->back().no;
      done += some->size();
      if (options_.progress && all > 0) options_.progress(static_cast<double>(done) / static_cast<double>(all));
    }
    if (Result<void> tidy = to_.connection->tidy(); !tidy) return fail(std::move(tidy.error()));
    return report_;
  }

 private:
  static constexpr std::size_t at_once = 200;  // number of entries copied in one transaction

  Result<std::vector<EntryRow>> next_entries(std::int64_t no) const { return read_entries(*from_.connection, "e.no > ?1", no, at_once); }
  Result<std::vector<EntryRow>> named_entries(std::size_t done) const {
    std::vector<EntryRow> out;
    for (std::size_t i = done; i < std::min(options_.entries.size(), done + at_once); ++i) {
      Result<EntryRow> entry = find_entry(from_, options_.entries[i], Trash::no);
      if (!entry) return fail(std::move(entry.error()));
      out.push_back(std::move(*entry));
    }
    return out;
  }

  Result<void> put_new(const std::string& hash, std::span<const std::byte> bytes) {
    const Result<bool> there = has_blob(*to_.connection, hash);
    if (!there) return fail(there.error());
    if (*there) return {};
    ++report_.blobs;
    return put_blob(*to_.connection, hash, bytes);
  }

  Result<void> copy_thumbnail(const EntryRow& entry) {
    if (entry.thumbnail.empty()) return {};
    const Result<std::vector<std::byte>> bytes = read_blob(*from_.connection, entry.thumbnail, "thumbnail of entry " + entry.id);
    if (!bytes) return fail(bytes.error());
    if (Result<void> good = check_copied_thumbnail(from_, entry, *bytes); !good) return good;
    return put_new(entry.thumbnail, *bytes);
  }

  /// Copies the data of these versions to the target. Data that the target already contains are checked, but not written.
  Result<void> copy_data(const EntryRow& entry, std::span<const VersionRow> versions) {
    for (const VersionRow& v : versions) {
      const Result<std::vector<std::byte>> bytes = read_blob(*from_.connection, v.data, "entry " + entry.id + " '" + v.name + "'");
      if (!bytes) return fail(bytes.error());
      if (Result<void> good = check_copied_data(from_, entry, v, *bytes); !good) return good;
      if (Result<void> done = put_new(v.data, *bytes); !done) return done;
    }
    return {};
  }

  Result<void> add_versions(std::int64_t no, std::span<const VersionRow> versions) {
    for (const VersionRow& v : versions) {
      if (Result<void> done = insert_version(*to_.connection, no, v); !done) return done;
      ++report_.versions;
    }
    return {};
  }

  Result<void> copy_entry(const EntryRow& entry) {
    Result<std::vector<VersionRow>> versions = read_versions(*from_.connection, entry.no);
    if (!versions) return fail(std::move(versions.error()));
    if (options_.latest_only && versions->size() > 1) versions->erase(versions->begin(), versions->end() - 1);
    if (Result<void> good = check_copied(from_, entry, *versions); !good) return good;
    const Result<std::vector<EntryRow>> known = read_entries(*to_.connection, "e.id = ?1", entry.id);
    if (!known) return fail(known.error());
    if (known->empty()) {
      // The row of an entry refers to its blobs, so these are inserted first.
      if (Result<void> done = copy_thumbnail(entry); !done) return done;
      if (Result<void> done = copy_data(entry, *versions); !done) return done;
      const Result<std::int64_t> no = insert_entry(*to_.connection, entry);
      if (!no) return fail(no.error());
      if (*no == 0)
        return fail(ErrorCode::conflict, to_.location(entry.id), "Another program is adding the same entry.", "Run the copy again.");
      ++report_.added;
      return add_versions(*no, *versions);
    }
    return merge(entry, *versions, known->front());
  }

  /// Merges an entry that the target already contains. If the target's newest version is in the source's history, the newer versions are
  /// added; otherwise the entry was changed in both libraries.
  /// @param here versions of the entry in the source @param there the entry in the target
  Result<void> merge(const EntryRow& entry, const std::vector<VersionRow>& here, const EntryRow& there) {
    if (Result<void> done = copy_thumbnail(entry); !done) return done;
    if (Result<void> done = merge_tags(entry, there); !done) return done;
    const Result<std::vector<VersionRow>> known = read_versions(*to_.connection, there.no);
    if (!known) return fail(known.error());
    const auto in = [](const std::vector<VersionRow>& list, const VersionRow& v) { return std::ranges::find(list, v) != list.end(); };
    const bool older_than_there = in(*known, here.back());
    if (older_than_there) {
      ++report_.equal;
      return {};
    }
    const auto last = std::ranges::find(here, known->back());
    if (last != here.end()) {
      ++report_.continued;
      const std::span<const VersionRow> newer(last + 1, here.end());
      if (Result<void> done = copy_data(entry, newer); !done) return done;
      if (Result<void> done = add_versions(there.no, newer); !done) return done;
      return set_newest(there, here.back(), entry.thumbnail);
    }
    if (!options_.save_differing) {
      const VersionRow &a = here.back(), &b = known->back();
      report_.differing.push_back(entry.id + " '" + entry.newest.name + "': version " + std::to_string(a.version) + " by " + a.author +
                                  " (" + a.saved + ") here, version " + std::to_string(b.version) + " by " + b.author + " (" + b.saved +
                                  ") there");
      return {};
    }
    VersionRow next = here.back();
    next.version = known->back().version + 1;
    // An earlier copy may already have added this version to the target.
    for (const VersionRow& v : *known)
      if (VersionRow same = v; same.version = next.version, same == next) {
        ++report_.equal;
        return {};
      }
    ++report_.saved;
    if (Result<void> done = copy_data(entry, {&next, 1}); !done) return done;
    if (Result<void> done = add_versions(there.no, {&next, 1}); !done) return done;
    return set_newest(there, next, entry.thumbnail);
  }

  Result<void> merge_tags(const EntryRow& entry, const EntryRow& there) {
    bool changed = false;
    for (const std::string& tag : entry.tags) {
      if (std::ranges::binary_search(there.tags, tag)) continue;
      if (Result<void> done = insert_tag(*to_.connection, there.no, tag); !done) return done;
      changed = true;
    }
    if (entry.thumbnail.empty() || !there.thumbnail.empty() || entry.newest.data != there.newest.data)
      return changed ? refresh_words(*to_.connection, there.no) : Result<void>{};
    const Result<Rows> set = to_.connection->query("UPDATE entry SET thumbnail = ?2 WHERE no = ?1", {there.no, entry.thumbnail});
    if (!set) return fail(set.error());
    return changed ? refresh_words(*to_.connection, there.no) : Result<void>{};
  }

  Result<void> set_newest(const EntryRow& there, const VersionRow& v, const std::string& thumbnail) {
    const Result<Rows> set = to_.connection->query(
        "UPDATE entry SET version = ?2, name = ?3, summary = ?4, note = ?5, content = ?6, data = ?7, size = ?8, author = ?9, changed = "
        "?10, "
        "thumbnail = ?11 WHERE no = ?1 AND version = ?12 RETURNING no",
        {there.no, v.version, v.name, v.summary, v.note, v.content, v.data, v.size, v.author, v.saved,
         thumbnail.empty() ? Value() : Value(thumbnail), there.newest.version});
    if (!set) return fail(set.error());
    if (set->empty())
      return fail(ErrorCode::conflict, to_.location(there.id), "Another program is saving the same entry.", "Run the copy again.");
    return refresh_words(*to_.connection, there.no);
  }

  LibraryBody &from_, &to_;
  const CopyOptions& options_;
  CopyReport report_;
};

constexpr const char* part_mark = ".part-";  // between the name of an export and the id of the process that writes it

/// Removes a temporary SQLite file, and its -wal, -shm and -journal files, at the end of the scope.
struct Unfinished {
  std::string path;
  ~Unfinished() {
    std::error_code ignored;
    for (const char* end : {"", "-wal", "-shm", "-journal"}) fs::remove(path + end, ignored);
  }
};

/// Removes what killed exports to `path` have left: PATH.part-PROCESS and its side files, where PROCESS no longer exists.
void remove_abandoned_parts(const std::string& path) {
  const fs::path target(path);
  const std::string begin = target.filename().string() + part_mark;
  std::error_code ec;
  for (fs::directory_iterator i(target.has_parent_path() ? target.parent_path() : ".", ec), end; !ec && i != end; i.increment(ec)) {
    const std::string name = i->path().filename().string();
    if (!name.starts_with(begin)) continue;
    const std::optional<long> process =
        parse_long(std::string_view(name).substr(begin.size(), name.find('-', begin.size()) - begin.size()));
    if (!process || *process <= 1 || ::kill(static_cast<pid_t>(*process), 0) == 0 || errno != ESRCH) continue;
    std::error_code ignored;
    fs::remove(i->path(), ignored);
  }
}

/// Flushes a file, or the entries of a folder, to the disk. @param flags flags of open() @return false on failure
bool sync(const std::string& path, int flags) {
  const int fd = ::open(path.c_str(), flags | O_CLOEXEC);
  if (fd < 0) return false;
  const bool done = ::fsync(fd) == 0;
  ::close(fd);
  return done;
}

}  // namespace

Result<CopyReport> copy_entries(const Library& from, Library& to, const CopyOptions& options) { return Copy(from, to, options).run(); }

Result<std::vector<std::string>> with_references(const Library& library, const std::vector<std::string>& ids) {
  std::vector<std::string> out, open(ids.rbegin(), ids.rend());
  std::set<std::string> seen;
  while (!open.empty()) {
    const std::string id = open.back();
    open.pop_back();
    const Result<LibraryEntry> entry = library.get(id);
    if (!entry) {
      if (std::ranges::find(ids, id) == ids.end() && entry.error().problems.front().code == ErrorCode::unknown)
        continue;  // a reference to an entry that the library does not contain is skipped
      return fail(entry.error());
    }
    if (!seen.insert(entry->id).second) continue;
    out.push_back(entry->id);
    std::vector<std::string> texts;
    if (const auto summary = json::parse_json(entry->summary, "summary")) collect_texts(*summary, texts);
    if (entry->kind == EntryKind::set) {
      const Result<std::vector<std::byte>> list = library.data(entry->id);
      if (!list) return fail(list.error());
      const auto parsed = json::parse_json({reinterpret_cast<const char*>(list->data()), list->size()}, "set " + entry->name);
      if (!parsed) return fail(parsed.error());
      collect_texts(*parsed, texts);
    }
    for (std::string& text : texts)
      if (looks_like_id(text)) open.push_back(std::move(text));
  }
  return out;
}

Result<CopyReport> export_set(const Library& from, const std::vector<std::string>& ids, const std::string& path,
                              const CopyOptions& options) {
  Result<std::vector<std::string>> entries = with_references(from, ids);
  if (!entries) return fail(std::move(entries.error()));
  const std::string folder = fs::path(path).parent_path().string();
  std::error_code ignored;
  if (!folder.empty() && !fs::is_directory(folder, ignored))
    return fail(ErrorCode::io, path, "The folder " + folder + " does not exist.", "Create it first, or choose another folder.");
  remove_abandoned_parts(path);
  const Unfinished temporary{path + part_mark + std::to_string(::getpid())};
  CopyReport report;
  {
    Result<Library> to = Library::open(temporary.path);
    if (!to) return fail(std::move(to.error()));
    CopyOptions some = options;
    some.entries = std::move(*entries);
    if (!some.entries.empty()) {
      Result<CopyReport> copied = copy_entries(from, *to, some);
      if (!copied) return copied;
      report = std::move(*copied);
    }
    if (Result<void> one_file = body_of(*to).connection->script("PRAGMA journal_mode = DELETE"); !one_file)
      return fail(std::move(one_file.error()));
  }
  if (!sync(temporary.path, O_RDONLY) || ::rename(temporary.path.c_str(), path.c_str()) != 0)
    return fail(ErrorCode::io, path, "The file cannot be written.", "Check the folder, its permissions and the space on the disk.");
  (void)sync(folder.empty() ? "." : folder, O_RDONLY | O_DIRECTORY);
  return report;
}

}  // namespace ugoki::store
