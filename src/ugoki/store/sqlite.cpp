#include "ugoki/store/sqlite.h"

#include <fcntl.h>
#include <sqlite3.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <utility>

#include "ugoki/base/check.h"

namespace ugoki::store {
namespace {

constexpr int busy_timeout_ms = 2000;  // time for which SQLite retries while another connection holds a lock

/// The problem for a SQLite error code, with a message for users.
/// @param system errno of the failed system call; 0 if there is none
/// @param action as in Database::last_error()
Problem problem_of(int code, const char* message, int system, const std::string& path, std::string_view action) {
  const std::string subject = action.empty() ? std::string("The database") : std::string(action) + ": the database";
  std::error_code ignored;
  if (std::filesystem::is_directory(path, ignored))
    return {ErrorCode::io, path, "This is a folder, not a database file.", "Name a file inside it."};
  // SQLite may close or roll back before it reads errno, which is then lost. A write that fails while the system limits the file size is
  // therefore attributed to this limit.
  const int base = code & 0xff;
  rlimit limit{};
  const bool limited = ::getrlimit(RLIMIT_FSIZE, &limit) == 0 && limit.rlim_cur != RLIM_INFINITY;
  const bool write_failed = code == SQLITE_IOERR_WRITE || code == SQLITE_IOERR_SHMSIZE || code == SQLITE_IOERR_TRUNCATE;
  if ((system == EFBIG && (base == SQLITE_IOERR || base == SQLITE_FULL)) || (limited && write_failed))
    return {ErrorCode::io, path, subject + " cannot grow: the file would be larger than the system allows (" + std::strerror(EFBIG) + ").",
            "Raise the limit of the file size (`ulimit -f`) and try again; nothing was changed."};
  switch (code & 0xff) {
    case SQLITE_BUSY:
    case SQLITE_LOCKED:
      return {ErrorCode::conflict, path, subject + " is locked by another program.",
              "Close the other program or wait until it has finished, then try again."};
    case SQLITE_CORRUPT:
    case SQLITE_NOTADB:
      return {ErrorCode::syntax, path, subject + " is damaged or is not a database (" + message + ").",
              "Restore it from a backup; the file was not changed."};
    case SQLITE_FULL:
      return {ErrorCode::io, path, subject + " cannot grow: the disk is full.", "Free some space and try again; nothing was changed."};
    case SQLITE_READONLY:
      return {ErrorCode::io, path, subject + " cannot be written.", "Check the permissions of the file and of its folder."};
    case SQLITE_CANTOPEN:
      return {ErrorCode::io, path, subject + " cannot be opened.", "Check that the folder exists and that you may read and write it."};
    case SQLITE_PERM:
    case SQLITE_AUTH:
      return {ErrorCode::io, path, subject + " may not be accessed.", "Check the permissions of the file and of its folder."};
    case SQLITE_NOMEM:
      return {ErrorCode::io, path, subject + " needs more memory than is available.", "Close other programs and try again."};
    case SQLITE_TOOBIG: return {ErrorCode::range, path, subject + " cannot store an entry of this size.", "Entries may have up to 1 GB."};
    default:
      return {ErrorCode::io, path, subject + " failed: " + message + ".", "Check the disk and the file's permissions, then try again."};
  }
}

/// URI of a file that SQLite opens without locks and without its write-ahead log.
std::string immutable_uri(const std::string& path) {
  std::string uri = "file:";
  for (const char c : path) {
    if (c == '%' || c == '?' || c == '#') {
      constexpr const char* digits = "0123456789abcdef";
      const auto byte = static_cast<unsigned char>(c);
      uri += {'%', digits[byte >> 4], digits[byte & 15]};
    } else {
      uri += c;
    }
  }
  return uri + "?immutable=1";
}

/// Creates an empty file that only its owner may read and write. SQLite gives the same mode to the -wal and -shm files. No effect if the
/// file exists; a failure is reported when SQLite opens the file.
void create_private_file(const std::string& path) {
  const int descriptor = ::open(path.c_str(), O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, 0600);
  if (descriptor >= 0) ::close(descriptor);
}

}  // namespace

Result<Database> Database::open(const std::string& path, OpenMode mode) {
  if (mode == OpenMode::main_file_only) return connect(immutable_uri(path), path, SQLITE_OPEN_READONLY | SQLITE_OPEN_URI);
  if (mode == OpenMode::read_write) return connect(path, path, SQLITE_OPEN_READWRITE);
  if (mode == OpenMode::create) {
    if (path != ":memory:") create_private_file(path);
    return connect(path, path, SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE);
  }
  // A read-only connection creates -wal and -shm files but does not remove them. A database without a log is therefore opened for
  // writing, so that these two files are removed; `query_only` protects the database itself.
  std::error_code unresolved;
  const std::filesystem::path real = std::filesystem::canonical(path, unresolved);  // SQLite resolves symbolic links too
  const auto log_size = std::filesystem::file_size(real.string() + "-wal", unresolved);
  const bool has_log = !unresolved && log_size > 0;
  Result<Database> database = connect(path, path, has_log ? SQLITE_OPEN_READONLY : SQLITE_OPEN_READWRITE);
  if (!database) return database;
  if (!has_log)
    if (Result<void> done = database->run("PRAGMA query_only = ON"); !done) return fail(std::move(done.error()));
  // Reading in write-ahead-log mode needs a -shm file next to the database. If the -shm file cannot be created, no other program can be
  // writing, so the database is opened as immutable.
  if (const auto tables = database->integer("SELECT count(*) FROM sqlite_schema"); !tables) {
    const int failed = sqlite3_errcode(database->handle_) & 0xff;
    const bool no_side_file = failed == SQLITE_CANTOPEN || failed == SQLITE_READONLY || (failed == SQLITE_IOERR && !has_log);
    if (!no_side_file) return fail(tables.error());
    Result<Database> immutable = open(path, OpenMode::main_file_only);
    if (!immutable) return fail(tables.error());
    return immutable;
  }
  return database;
}

Result<Database> Database::connect(const std::string& name, const std::string& path, int flags) {
  sqlite3* handle = nullptr;
  const int code = sqlite3_open_v2(name.c_str(), &handle, flags | SQLITE_OPEN_EXRESCODE, nullptr);
  if (code != SQLITE_OK) {
    const Problem problem =
        problem_of(code, handle ? sqlite3_errmsg(handle) : "no memory", handle ? sqlite3_system_errno(handle) : 0, path, "");
    sqlite3_close(handle);
    return fail(problem);
  }
  Database database(handle, path);
  sqlite3_busy_timeout(handle, busy_timeout_ms);
  sqlite3_limit(handle, SQLITE_LIMIT_ATTACHED, 2);
  sqlite3_db_config(handle, SQLITE_DBCONFIG_DEFENSIVE, 1, nullptr);       // forbids SQL that can corrupt the file
  sqlite3_db_config(handle, SQLITE_DBCONFIG_TRUSTED_SCHEMA, 0, nullptr);  // views of a hostile file cannot call functions
  return database;
}

Database::Database(Database&& other) noexcept : handle_(std::exchange(other.handle_, nullptr)), path_(std::move(other.path_)) {}
Database& Database::operator=(Database&& other) noexcept {
  std::swap(handle_, other.handle_);
  std::swap(path_, other.path_);
  return *this;
}
Database::~Database() { sqlite3_close_v2(handle_); }

Error Database::last_error(std::string_view action) const {
  return problem_of(sqlite3_extended_errcode(handle_), sqlite3_errmsg(handle_), sqlite3_system_errno(handle_), path_, action);
}

Result<void> Database::run(const std::string& sql) {
  if (sqlite3_exec(handle_, sql.c_str(), nullptr, nullptr, nullptr) != SQLITE_OK) return fail(last_error(""));
  return {};
}

Result<Statement> Database::prepare(std::string_view sql) {
  sqlite3_stmt* statement = nullptr;
  if (sqlite3_prepare_v2(handle_, sql.data(), static_cast<int>(sql.size()), &statement, nullptr) != SQLITE_OK) return fail(last_error(""));
  return Statement(*this, statement);
}

Result<std::int64_t> Database::integer(const std::string& sql) {
  Result<Statement> statement = prepare(sql);
  if (!statement) return fail(std::move(statement.error()));
  const Result<bool> row = statement->step();
  if (!row) return fail(row.error());
  return *row ? statement->integer(0) : 0;
}

Result<std::string> Database::text(const std::string& sql) {
  Result<Statement> statement = prepare(sql);
  if (!statement) return fail(std::move(statement.error()));
  const Result<bool> row = statement->step();
  if (!row) return fail(row.error());
  return *row ? statement->text(0) : std::string();
}

Result<void> Database::check_structure() {
  const Result<std::string> answer = text("PRAGMA quick_check(1)");
  if (!answer) return fail(answer.error());
  if (*answer != "ok")
    return fail(ErrorCode::syntax, path_, "The database is damaged (" + *answer + ").",
                "Restore it from a backup; the file was not changed.");
  return {};
}

Result<std::vector<std::byte>> Database::raw(std::int64_t offset, std::size_t size) {
  if (offset < 0) return std::vector<std::byte>();  // a damaged file may refer to the invalid page number 0
  sqlite3_file* file = nullptr;
  if (sqlite3_file_control(handle_, "main", SQLITE_FCNTL_FILE_POINTER, static_cast<void*>(&file)) != SQLITE_OK || file == nullptr ||
      file->pMethods == nullptr)
    return fail(ErrorCode::io, path_, "The database file is not open.", "Close the file and open it again.");
  sqlite3_int64 end = 0;
  int code = file->pMethods->xFileSize(file, &end);
  if (code == SQLITE_OK) {
    std::vector<std::byte> bytes(offset < end ? std::min(size, static_cast<std::size_t>(end - offset)) : 0);
    code = bytes.empty() ? SQLITE_OK : file->pMethods->xRead(file, bytes.data(), static_cast<int>(bytes.size()), offset);
    if (code == SQLITE_OK) return bytes;
  }
  return fail(problem_of(code, sqlite3_errstr(code), 0, path_, ""));
}

Result<Database> Database::copy_to_memory() {
  Result<Database> memory = connect(":memory:", path_, SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE);
  if (!memory) return memory;
  sqlite3_backup* backup = sqlite3_backup_init(memory->handle_, "main", handle_, "main");
  if (backup == nullptr) return fail(memory->last_error(""));
  sqlite3_backup_step(backup, -1);
  if (sqlite3_backup_finish(backup) != SQLITE_OK) return fail(memory->last_error(""));
  return memory;
}

bool Database::has_moved() {
  int moved = 0;
  return sqlite3_file_control(handle_, "main", SQLITE_FCNTL_HAS_MOVED, &moved) == SQLITE_OK && moved != 0;
}

void Database::keep_log_when_closed() { sqlite3_db_config(handle_, SQLITE_DBCONFIG_NO_CKPT_ON_CLOSE, 1, nullptr); }

Statement::Statement(Statement&& other) noexcept : path_(std::move(other.path_)), handle_(std::exchange(other.handle_, nullptr)) {}
Statement& Statement::operator=(Statement&& other) noexcept {
  std::swap(path_, other.path_);
  std::swap(handle_, other.handle_);
  return *this;
}
Statement::~Statement() { sqlite3_finalize(handle_); }

Statement& Statement::bind(int index, std::int64_t value) {
  UGOKI_CHECK(sqlite3_bind_int64(handle_, index, value) == SQLITE_OK);
  return *this;
}
Statement& Statement::bind(int index, std::string_view value) {
  // If the text is too large for SQLite, the parameter stays null, and the NOT NULL constraint of the column reports an error.
  sqlite3_bind_text64(handle_, index, value.data() ? value.data() : "", value.size(), SQLITE_TRANSIENT, SQLITE_UTF8);
  return *this;
}
Statement& Statement::bind_blob(int index, std::span<const std::byte> value) {
  if (value.empty())
    sqlite3_bind_zeroblob(handle_, index, 0);
  else
    sqlite3_bind_blob64(handle_, index, value.data(), value.size(), SQLITE_TRANSIENT);
  return *this;
}

Statement& Statement::bind_null(int index) {
  UGOKI_CHECK(sqlite3_bind_null(handle_, index) == SQLITE_OK);
  return *this;
}

Result<bool> Statement::step() {
  const int code = sqlite3_step(handle_);
  if (code == SQLITE_ROW) return true;
  if (code == SQLITE_DONE) return false;
  sqlite3* database = sqlite3_db_handle(handle_);
  return fail(problem_of(code, sqlite3_errmsg(database), sqlite3_system_errno(database), path_, ""));
}

Result<void> Statement::run() {
  for (;;) {
    Result<bool> row = step();
    if (!row) {
      sqlite3_reset(handle_);
      return fail(std::move(row.error()));
    }
    if (!*row) break;
  }
  sqlite3_reset(handle_);
  return {};
}

void Statement::reset() { sqlite3_reset(handle_); }

std::int64_t Statement::integer(int column) const { return sqlite3_column_int64(handle_, column); }
std::string Statement::text(int column) const {
  const auto* p = sqlite3_column_text(handle_, column);
  const auto n = static_cast<std::size_t>(sqlite3_column_bytes(handle_, column));
  return p ? std::string(reinterpret_cast<const char*>(p), n) : std::string();
}
std::vector<std::byte> Statement::blob(int column) const {
  const auto* p = static_cast<const std::byte*>(sqlite3_column_blob(handle_, column));
  const auto n = static_cast<std::size_t>(sqlite3_column_bytes(handle_, column));
  return p ? std::vector<std::byte>(p, p + n) : std::vector<std::byte>();
}
bool Statement::is_null(int column) const { return sqlite3_column_type(handle_, column) == SQLITE_NULL; }
int Statement::columns() const { return sqlite3_column_count(handle_); }

Result<Transaction> Transaction::begin(Database& database) {
  Result<void> begun = database.run("BEGIN IMMEDIATE");
  if (!begun) return fail(std::move(begun.error()));
  return Transaction(database);
}

Transaction::~Transaction() {
  if (database_) (void)database_->run("ROLLBACK");
}

Result<void> Transaction::commit() {
  UGOKI_CHECK(database_ != nullptr);
  Result<void> done = database_->run("COMMIT");
  if (done) database_ = nullptr;  // committed: the destructor must not roll back
  return done;
}

}  // namespace ugoki::store
