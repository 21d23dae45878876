#include "ugoki/store/file_watch.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <filesystem>
#include <map>
#include <mutex>
#include <thread>

#include "ugoki/base/hash.h"

namespace ugoki::store {
namespace {

constexpr std::array<const char*, 3> suffixes = {"", "-wal", "-shm"};

/// Range of bytes, far behind the bytes that SQLite locks. A lock on one of them marks a name under which the library file is open.
constexpr off_t first_name_byte = off_t{1} << 41, name_bytes = off_t{1} << 30;

/// True if an open descriptor other than `file` has a lock in the range.
bool is_locked(int file, off_t begin, off_t size) {
  if (size == 0) return false;
  struct flock range{};
  range.l_type = F_WRLCK;
  range.l_whence = SEEK_SET;
  range.l_start = begin;
  range.l_len = size;
  return ::fcntl(file, F_OFD_GETLK, &range) == 0 && range.l_type != F_UNLCK;
}

/// Offset of the byte whose lock marks that the library file is open under the name `path`.
off_t name_byte(const std::string& path) {
  Hash64 hash;
  hash.add_bytes(path.data(), path.size());
  return first_name_byte + static_cast<off_t>(std::stoull(hash.hex(), nullptr, 16) % static_cast<std::uint64_t>(name_bytes));
}

/// Sets or removes the lock of one byte. @return false: the file system has no such locks
bool lock_byte(int file, off_t byte, short type) {
  struct flock range{};
  range.l_type = type;
  range.l_whence = SEEK_SET;
  range.l_start = byte;
  range.l_len = 1;
  return ::fcntl(file, F_OFD_SETLK, &range) == 0;
}

}  // namespace

/// An object of this class marks that this process has a file open under a name.
class FileWatch::NameMark {
 public:
  /// @param file descriptor of the file
  NameMark(int file, off_t byte) : file_(file), byte_(byte) {}
  NameMark(const NameMark&) = delete;
  NameMark& operator=(const NameMark&) = delete;
  ~NameMark() { lock_byte(file_, byte_, F_UNLCK); }
  /// Sets the mark. @return false if another name of the file is marked
  [[nodiscard]] bool set() const {
    if (!lock_byte(file_, byte_, F_RDLCK)) return true;
    return !is_locked(file_, first_name_byte, byte_ - first_name_byte) &&
           !is_locked(file_, byte_ + 1, first_name_byte + name_bytes - byte_ - 1);
  }
  [[nodiscard]] int file() const { return file_; }

 private:
  int file_;
  off_t byte_;
};

FileWatch::Identity FileWatch::identity_of(const std::string& path) {
  struct stat info{};
  if (::stat(path.c_str(), &info) != 0) return {};
  return {info.st_dev, info.st_ino};
}

Result<FileWatch> FileWatch::begin(Database& database) {
  FileWatch watch;
  watch.path_ = database.path();
  std::error_code unresolved;
  const std::filesystem::path real = std::filesystem::canonical(watch.path_, unresolved);
  watch.real_path_ = unresolved ? watch.path_ : real.string();
  for (auto& [value, sql] : {std::pair{&watch.page_size_, "PRAGMA page_size"},
                             {&watch.stamp_page_, "SELECT rootpage FROM sqlite_schema WHERE name = 'stamp'"},
                             {&watch.data_version_, "PRAGMA data_version"}}) {
    const Result<std::int64_t> found = database.integer(sql);
    if (!found) return fail(found.error());
    *value = *found;
  }
  Result<std::optional<StampRow>> stamp = read_stamp(database);  // reading the stamp also opens the -wal and -shm files
  if (!stamp) return fail(std::move(stamp.error()));
  watch.last_ = *stamp;
  Result<std::optional<StampRow>> in_file = watch.stamp_in_file(database);
  if (!in_file) return fail(std::move(in_file.error()));
  watch.in_file_ = *in_file;
  for (std::size_t i = 0; i < suffixes.size(); ++i) watch.identities_[i] = identity_of(watch.real_path_ + suffixes[i]);
  if (database.has_moved() || !watch.last_)
    return fail(ErrorCode::conflict, watch.path_, "Another program changed the file while it was opened.", "Open it again.");

  // Closing any descriptor of a file releases the POSIX locks of this process on the file, which SQLite uses. The descriptor of each file
  // is therefore kept until the program ends.
  struct OpenFile {
    int descriptor = -1;
    std::weak_ptr<const NameMark> mark;
  };
  static std::mutex mutex;
  static std::map<std::pair<Identity, std::string>, OpenFile> open_files;
  const std::scoped_lock lock(mutex);
  OpenFile& file = open_files[{watch.identities_[0], watch.real_path_}];
  watch.mark_ = file.mark.lock();
  if (watch.mark_) return watch;
  if (file.descriptor < 0) file.descriptor = ::open(watch.real_path_.c_str(), O_RDONLY | O_CLOEXEC);
  if (file.descriptor < 0) return watch;
  watch.mark_ = std::make_shared<const NameMark>(file.descriptor, name_byte(watch.real_path_));
  if (!watch.mark_->set())
    return fail(ErrorCode::conflict, watch.path_, "The library is already open under another name (hard link).",
                "Close it there first, or use the same name.");
  file.mark = watch.mark_;
  return watch;
}

Result<std::optional<StampRow>> FileWatch::stamp_in_file(Database& database) const {
  const Result<std::vector<std::byte>> page = database.raw((stamp_page_ - 1) * page_size_, static_cast<std::size_t>(page_size_));
  if (!page) return fail(page.error());
  return stamp_on_page(*page);
}

std::optional<FileLoss> FileWatch::moved() const {
  const Identity now = identity_of(path_);
  if (now != identities_[0]) {
    struct stat info{};
    const bool unlinked = mark_ && ::fstat(mark_->file(), &info) == 0 && info.st_nlink == 0;
    return FileLoss{now == Identity{} ? "The library file was removed or renamed while it was open"
                                      : "Another program replaced the library file while it was open",
                    true, unlinked};
  }
  for (std::size_t i = 1; i < suffixes.size(); ++i)
    if (const std::string side = real_path_ + suffixes[i]; identity_of(side) != identities_[i])
      return FileLoss{"Another program removed or replaced " + side + " while the library was open", true, false};
  return std::nullopt;
}

std::optional<FileLoss> FileWatch::overwritten(Database& database, const std::optional<StampRow>& committed) {
  if (committed) last_ = committed;
  // SQLite does not notice that a file was overwritten: it still returns the old `data_version`. The version changes only when another
  // connection commits; the last stamp is then read again.
  if (const Result<std::int64_t> version = database.integer("PRAGMA data_version"); version && *version != data_version_) {
    const Result<std::optional<StampRow>> stamp = read_stamp(database);
    if (stamp && *stamp) {
      last_ = *stamp;
      data_version_ = *version;
    }
  }
  // Between the two reads, another program may merge the log into the file or begin a new log. The comparison is then repeated.
  constexpr int max_attempts = 20;
  for (int attempt = 0; attempt < max_attempts; ++attempt) {
    const Result<std::optional<StampRow>> read = stamp_in_file(database);
    if (!read) return std::nullopt;  // the disk failed; no other program caused the error
    const std::optional<StampRow>& now = *read;
    if (now && (now == in_file_ || now == last_)) {
      in_file_ = now;
      return std::nullopt;
    }
    const LogStamps log = read_log(real_path_ + "-wal");
    if (log.has_transactions && belongs(now, log)) {
      in_file_ = now;
      return std::nullopt;
    }
    if (const Result<std::int64_t> page = database.integer("SELECT rootpage FROM sqlite_schema WHERE name = 'stamp'"); page)
      stamp_page_ = *page;  // a VACUUM by another program moves the table to another page
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  return FileLoss{"Another program overwrote the library file while it was open", false, false};
}

void FileWatch::remove_side_files() const {
  for (std::size_t i = 1; i < suffixes.size(); ++i)
    if (const std::string side = real_path_ + suffixes[i]; identities_[i] != Identity{} && identity_of(side) == identities_[i])
      ::unlink(side.c_str());
}

}  // namespace ugoki::store
