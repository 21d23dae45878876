#include "ugoki/project/project_file.h"

#include <sys/stat.h>
#include <unistd.h>

#include <ctime>
#include <filesystem>
#include <fstream>

#include "ugoki/base/hash.h"
#include "ugoki/store/log_damage.h"

namespace ugoki::project {
namespace {

constexpr std::array<const char*, 3> suffixes = {"", "-wal", "-shm"};

/// True if the header begins as that of a write-ahead log: 0x377f0682 or 0x377f0683, the most significant byte first.
bool is_log(const std::array<unsigned char, 32>& header) {
  return header[0] == 0x37 && header[1] == 0x7f && header[2] == 0x06 && (header[3] == 0x82 || header[3] == 0x83);
}

constexpr const char* tables = R"(
CREATE TABLE property (
  name  TEXT PRIMARY KEY NOT NULL,
  value TEXT NOT NULL
) STRICT, WITHOUT ROWID;
CREATE TABLE resource (
  id       TEXT PRIMARY KEY NOT NULL,
  kind     TEXT NOT NULL CHECK (kind IN ('mechanism', 'motion')),
  name     TEXT NOT NULL,
  checksum TEXT NOT NULL,
  data     BLOB NOT NULL
) STRICT;
CREATE TABLE history (
  number   INTEGER PRIMARY KEY NOT NULL,
  label    TEXT NOT NULL,
  command  TEXT NOT NULL,
  forward  TEXT NOT NULL,
  backward TEXT NOT NULL,
  time     INTEGER NOT NULL
) STRICT;
)";

std::string checksum_of(std::span<const std::byte> data) {
  Hash64 hash;
  hash.add_bytes(data.data(), data.size());
  return hash.hex();
}

Result<void> check(store::Database& database) {
  const std::string& path = database.path();
  const Result<std::int64_t> application = database.integer("PRAGMA application_id");
  if (!application) return fail(application.error());
  const Result<std::int64_t> version = database.integer("PRAGMA user_version");
  if (!version) return fail(version.error());
  if (*application != project_application_id)
    return fail(ErrorCode::syntax, path, "This file is not a project of Ugoki.", "Open a *.ugoki file, or create one with `ugoki new`.");
  if (*version > project_version)
    return fail(ErrorCode::unsupported, path,
                "The project was saved by a newer Ugoki (version " + std::to_string(*version) + "; this program reads up to version " +
                    std::to_string(project_version) + ").",
                "Open it with a newer Ugoki; the file was not changed.");
  if (*version < 1)
    return fail(ErrorCode::syntax, path, "The project has the invalid version " + std::to_string(*version) + ".",
                "Restore the project from a backup; the file was not changed.");
  if (Result<void> good = database.check_structure(); !good) return good;
  const Result<std::int64_t> others = database.integer(
      "SELECT count(*) FROM sqlite_schema WHERE type IN ('trigger', 'view') OR (type = 'table' AND name NOT IN ('property', 'resource', "
      "'history', 'stamp'))");
  if (!others) return fail(others.error());
  if (*others != 0)
    return fail(ErrorCode::structure, path, "The project contains tables, views or triggers that Ugoki did not create.",
                "Do not trust the file; restore it from a backup.");
  return {};
}

/// Adds the table `stamp` to a file of version 1.
Result<void> upgrade(store::Database& database) {
  const Result<std::int64_t> version = database.integer("PRAGMA user_version");
  if (!version) return fail(version.error());
  if (*version >= project_version) return {};
  // Without a write-ahead log the change is in the file itself, so a log with stamps never belongs to a file without stamps.
  for (const char* sql : {"PRAGMA journal_mode = DELETE", "PRAGMA synchronous = FULL"})
    if (Result<void> done = database.run(sql); !done) return done;
  Result<store::Transaction> transaction = store::Transaction::begin(database);
  if (!transaction) return fail(std::move(transaction.error()));
  if (Result<void> done = database.run(store::stamp_table); !done) return done;
  if (Result<void> done = store::advance_stamp(database); !done) return done;
  if (Result<void> done = database.run("PRAGMA user_version = " + std::to_string(project_version)); !done) return done;
  return transaction->commit();
}

}  // namespace

Result<ProjectFile> ProjectFile::create(const std::string& path) {
  std::error_code ignored;
  if (std::filesystem::exists(path, ignored))
    return fail(ErrorCode::conflict, path, "The file exists already.", "Choose another name, or remove it first.");
  Result<store::Database> database = store::Database::open(path, store::OpenMode::create);
  if (!database) return fail(std::move(database.error()));
  const std::string pragmas =
      "PRAGMA application_id = " + std::to_string(project_application_id) + "; PRAGMA user_version = " + std::to_string(project_version);
  for (const std::string& sql : {std::string("PRAGMA journal_mode = WAL"), std::string("PRAGMA synchronous = FULL"),
                                 std::string("BEGIN IMMEDIATE;") + tables + store::stamp_table + pragmas + ";COMMIT"})
    if (Result<void> done = database->run(sql); !done) return fail(std::move(done.error()));
  return ProjectFile(std::move(*database));
}

Result<ProjectFile> ProjectFile::open(const std::string& path, bool read_only) {
  std::error_code ignored;
  if (!std::filesystem::exists(path, ignored))
    return fail(ErrorCode::io, path, "The file does not exist.", "Check its name, or create a project with `ugoki new`.");
  if (std::filesystem::is_directory(path, ignored))
    return fail(ErrorCode::io, path, "This is a folder, not a project file.", "Name a *.ugoki file.");
  if (!std::filesystem::is_regular_file(path, ignored)) return fail(ErrorCode::io, path, "This is not a file.", "Name a *.ugoki file.");
  if (Result<void> good = store::check_log(std::filesystem::weakly_canonical(path, ignored).string()); !good)
    return fail(std::move(good.error()));
  Result<std::optional<Problem>> warning = store::check_log_damage(std::filesystem::weakly_canonical(path, ignored).string(),
                                                                   read_only ? store::DamagedLog::report : store::DamagedLog::keep_copy);
  if (!warning) return fail(std::move(warning.error()));
  {
    Result<store::Database> look = store::Database::open(path, store::OpenMode::read_only);
    if (!look) return fail(std::move(look.error()));
    if (Result<void> good = check(*look); !good) return fail(std::move(good.error()));
    if (read_only) {
      ProjectFile file(std::move(*look));
      file.warning_ = std::move(*warning);
      return file;
    }
  }
  Result<store::Database> database = store::Database::open(path, store::OpenMode::read_write);
  if (!database) return fail(std::move(database.error()));
  if (Result<void> done = upgrade(*database); !done) return fail(std::move(done.error()));
  for (const char* sql : {"PRAGMA journal_mode = WAL", "PRAGMA synchronous = FULL"})
    if (Result<void> done = database->run(sql); !done) return fail(std::move(done.error()));
  if (Result<void> done = store::ensure_stamp(*database); !done) return fail(std::move(done.error()));
  ProjectFile file(std::move(*database));
  file.warning_ = std::move(*warning);
  if (Result<void> done = file.remember(); !done) return fail(std::move(done.error()));
  return file;
}

ProjectFile::Identity ProjectFile::identity_of(const std::string& path) {
  struct stat info{};
  if (::stat(path.c_str(), &info) != 0) return {};
  return {info.st_dev, info.st_ino};
}

Result<void> ProjectFile::remember() {
  const auto read = [&](std::int64_t& value, const char* sql) -> Result<void> {
    const Result<std::int64_t> found = database_.integer(sql);
    if (!found) return fail(found.error());
    value = *found;
    return {};
  };
  if (Result<void> done = read(page_size_, "PRAGMA page_size"); !done) return done;
  if (Result<void> done = read(stamp_page_, "SELECT rootpage FROM sqlite_schema WHERE name = 'stamp'"); !done) return done;
  Result<std::optional<store::StampRow>> stamp = store::read_stamp(database_);  // reading the stamp also opens the -wal and -shm files
  if (!stamp) return fail(std::move(stamp.error()));
  stamp_ = *stamp;
  Result<std::optional<store::StampRow>> merged = stamp_in_file();
  if (!merged) return fail(std::move(merged.error()));
  merged_stamp_ = *merged;
  std::error_code unresolved;
  const std::filesystem::path real = std::filesystem::canonical(path(), unresolved);
  real_path_ = unresolved ? path() : real.string();
  for (std::size_t i = 0; i < suffixes.size(); ++i) identities_[i] = identity_of(real_path_ + suffixes[i]);
  log_ = log_begin();
  if (database_.has_moved() || !merged_stamp_ || !stamp_)
    return fail(ErrorCode::conflict, path(), "Another program changed the file while it was opened.", "Open it again.");
  return {};
}

Result<std::optional<store::StampRow>> ProjectFile::stamp_in_file() {
  const Result<std::vector<std::byte>> page = database_.raw((stamp_page_ - 1) * page_size_, static_cast<std::size_t>(page_size_));
  if (!page) return fail(page.error());
  return store::stamp_on_page(*page);
}

ProjectFile::LogBegin ProjectFile::log_begin() const {
  LogBegin out;
  std::error_code missing;
  const std::string log = real_path_ + suffixes[1];
  const std::uintmax_t size = std::filesystem::file_size(log, missing);
  out.size = missing ? 0 : size;
  std::ifstream file(log, std::ios::binary);
  file.read(reinterpret_cast<char*>(out.header.data()), static_cast<std::streamsize>(out.header.size()));
  if (file.gcount() < static_cast<std::streamsize>(out.header.size())) out.header = {};
  return out;
}

std::optional<Loss> ProjectFile::lost() {
  if (page_size_ == 0) return std::nullopt;  // the file is open read-only and not observed
  const Identity now = identity_of(path());
  if (now == Identity{}) return Loss{"The project file was removed or renamed while it was open"};
  if (now != identities_[0]) return Loss{"Another program replaced the project file while it was open"};
  for (std::size_t i = 1; i < suffixes.size(); ++i)
    if (const std::string side = real_path_ + suffixes[i]; identity_of(side) != identities_[i])
      return Loss{"Another program removed or replaced " + side + " while the project was open"};
  // Another program that merges the log (the sqlite3 shell, for example) leaves the stamp of the last transaction in the file.
  const Result<std::optional<store::StampRow>> stamp = stamp_in_file();
  if (!stamp) return std::nullopt;                      // the disk fails; this is not the work of another program
  if (*stamp && *stamp == stamp_) return std::nullopt;  // the file contains all transactions
  if (const LogBegin log = log_begin(); !log_.continues_in(log) || !is_log(log.header))
    return Loss{"Another program changed " + real_path_ + suffixes[1] + " while the project was open", false};
  if (*stamp && *stamp == merged_stamp_) return std::nullopt;
  return Loss{"Another program wrote to the project file while it was open", false};
}

void ProjectFile::abandon() {
  database_.keep_log_when_closed();
  for (std::size_t i = 1; i < suffixes.size(); ++i)
    if (const std::string side = real_path_ + suffixes[i]; identities_[i] != Identity{} && identity_of(side) == identities_[i])
      ::unlink(side.c_str());
}

Result<void> ProjectFile::write(const std::function<Result<void>()>& work) {
  Result<store::Transaction> transaction = store::Transaction::begin(database_);
  if (!transaction) return fail(std::move(transaction.error()));
  if (Result<void> done = work(); !done) return done;
  if (Result<void> done = store::advance_stamp(database_); !done) return done;
  Result<std::optional<store::StampRow>> stamp = store::read_stamp(database_);
  if (!stamp) return fail(std::move(stamp.error()));
  if (Result<void> done = transaction->commit(); !done) return done;
  stamp_ = *stamp;
  if (page_size_ == 0) return {};
  log_ = log_begin();
  // The commit may have merged the log, or a part of it if another program reads the file. Another stamp is not accepted: lost() reports
  // it.
  const Result<std::optional<store::StampRow>> merged = stamp_in_file();
  if (!merged || !*merged || *merged == merged_stamp_) return {};
  if (*merged != stamp_) {
    const store::LogStamps log = store::read_log(real_path_ + suffixes[1]);
    if (!log.has_transactions || !store::belongs(*merged, log)) return {};
  }
  merged_stamp_ = *merged;
  return {};
}

Result<std::optional<std::string>> ProjectFile::find_property(std::string_view name) {
  Result<store::Statement> row = database_.prepare("SELECT value FROM property WHERE name = ?1");
  if (!row) return fail(std::move(row.error()));
  const Result<bool> found = row->bind(1, name).step();
  if (!found) return fail(found.error());
  return *found ? std::optional(row->text(0)) : std::nullopt;
}

Result<std::string> ProjectFile::property(std::string_view name) {
  Result<std::optional<std::string>> found = find_property(name);
  if (!found) return fail(std::move(found.error()));
  if (!*found)
    return fail(ErrorCode::structure, path(), "The property '" + std::string(name) + "' is missing from the project.",
                "Restore the project from a backup; the file was not changed.");
  return std::move(**found);
}

Result<void> ProjectFile::set_property(std::string_view name, std::string_view value) {
  Result<store::Statement> put =
      database_.prepare("INSERT INTO property (name, value) VALUES (?1, ?2) ON CONFLICT (name) DO UPDATE SET value = excluded.value");
  if (!put) return fail(std::move(put.error()));
  return put->bind(1, name).bind(2, value).run();
}

Result<std::vector<ResourceRow>> ProjectFile::resources() {
  Result<store::Statement> rows = database_.prepare("SELECT id, kind, data, checksum FROM resource ORDER BY id");
  if (!rows) return fail(std::move(rows.error()));
  std::vector<ResourceRow> out;
  Error problems;
  for (;;) {
    const Result<bool> next = rows->step();
    if (!next) return fail(next.error());
    if (!*next) break;
    out.push_back({rows->text(0), rows->text(1), rows->blob(2)});
    if (checksum_of(out.back().data) != rows->text(3))
      problems.add(ErrorCode::syntax, path() + ", " + out.back().kind + " " + out.back().id,
                   "The data of the resource are damaged (checksum mismatch).",
                   "Restore the project from a backup; the file was not changed.");
  }
  if (!problems.empty()) return fail(std::move(problems));
  return out;
}

Result<void> ProjectFile::put_resource(std::string_view id, std::string_view kind, std::string_view name, std::span<const std::byte> data) {
  Result<store::Statement> put = database_.prepare("INSERT INTO resource (id, kind, name, checksum, data) VALUES (?1, ?2, ?3, ?4, ?5)");
  if (!put) return fail(std::move(put.error()));
  return put->bind(1, id).bind(2, kind).bind(3, name).bind(4, checksum_of(data)).bind_blob(5, data).run();
}

Result<std::vector<Step>> ProjectFile::steps() {
  Result<store::Statement> rows = database_.prepare("SELECT number, label FROM history ORDER BY number");
  if (!rows) return fail(std::move(rows.error()));
  std::vector<Step> out;
  for (;;) {
    const Result<bool> next = rows->step();
    if (!next) return fail(next.error());
    if (!*next) return out;
    out.push_back({rows->integer(0), rows->text(1)});
  }
}

Result<StepData> ProjectFile::step(std::int64_t number) {
  Result<store::Statement> row = database_.prepare("SELECT label, command, forward, backward FROM history WHERE number = ?1");
  if (!row) return fail(std::move(row.error()));
  const Result<bool> found = row->bind(1, number).step();
  if (!found) return fail(found.error());
  if (!*found)
    return fail(ErrorCode::structure, path(), "Step " + std::to_string(number) + " of the history is missing.",
                "Undo and redo cannot continue past this step; the document is unchanged.");
  return StepData{row->text(0), row->text(1), row->text(2), row->text(3)};
}

Result<void> ProjectFile::add_step(std::int64_t position, const StepData& step, std::int64_t keep) {
  Result<store::Statement> remove = database_.prepare("DELETE FROM history WHERE number > ?1 OR number <= ?2");
  if (!remove) return fail(std::move(remove.error()));
  if (Result<void> done = remove->bind(1, position).bind(2, position + 1 - keep).run(); !done) return done;
  Result<store::Statement> add =
      database_.prepare("INSERT INTO history (number, label, command, forward, backward, time) VALUES (?1, ?2, ?3, ?4, ?5, ?6)");
  if (!add) return fail(std::move(add.error()));
  return add->bind(1, position + 1)
      .bind(2, step.label)
      .bind(3, step.command)
      .bind(4, step.forward)
      .bind(5, step.backward)
      .bind(6, static_cast<std::int64_t>(std::time(nullptr)))
      .run();
}

}  // namespace ugoki::project
