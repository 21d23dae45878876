#include "ugoki/files/files.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <utility>
#include <vector>

namespace ugoki::files {
namespace {

/// Owns a file descriptor; the destructor closes it.
class Descriptor {
 public:
  explicit Descriptor(int fd) : fd_(fd) {}
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  ~Descriptor() {
    if (fd_ >= 0) ::close(fd_);
  }
  [[nodiscard]] int get() const { return fd_; }
  /// Closes the descriptor. Returns false if the system reports that written data was lost.
  bool close() {
    const int fd = fd_;
    fd_ = -1;
    return ::close(fd) == 0;
  }

 private:
  int fd_;
};

/// The system error `error` (errno) as an error result: `sentence` without its full stop, the system's text, and a remedy.
std::unexpected<Error> failed(const std::string& path, const std::string& sentence, int error) {
  std::string remedy = "Check the disk and try again.";
  switch (error) {
    case ENOENT: remedy = "Check the name and the folder."; break;
    case ENOTDIR: remedy = "A part of the path is a file, not a folder; check the path."; break;
    case EISDIR: remedy = "Name a file inside it."; break;
    case EACCES:
    case EPERM: remedy = "Ask for the permission, or choose another folder."; break;
    case EROFS: remedy = "The disk is read-only; choose another folder."; break;
    case ENOSPC:
    case EDQUOT: remedy = "Free some space on the disk, or choose another folder."; break;
    case EFBIG: remedy = "Raise the limit of the file size (`ulimit -f`), or write less data."; break;
    case ENAMETOOLONG: remedy = "Choose a shorter name."; break;
    case ELOOP: remedy = "The symbolic links of the path form a cycle; check them."; break;
    case EMFILE:
    case ENFILE: remedy = "Too many files are open; close some programs."; break;
    default: break;
  }
  return fail(ErrorCode::io, path, sentence + " (" + std::strerror(error) + ").", remedy);
}

/// Returns an error unless the path is a regular file or a pipe. @param mode file mode from stat()
Result<void> check_kind(const std::string& path, mode_t mode) {
  if (S_ISREG(mode) || S_ISFIFO(mode)) return {};
  if (S_ISDIR(mode)) return fail(ErrorCode::io, path, "This is a folder, not a file.", "Name a file inside it.");
  return fail(ErrorCode::io, path, S_ISSOCK(mode) ? "This is a socket, not a file." : "This is a device, not a file.",
              "Name a file or a pipe.");
}

bool write_all(int fd, std::span<const std::byte> bytes) {
  while (!bytes.empty()) {
    const ssize_t n = ::write(fd, bytes.data(), std::min(bytes.size(), std::size_t{1} << 30));
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) return false;
    bytes = bytes.subspan(static_cast<std::size_t>(n));
  }
  return true;
}

}  // namespace

Result<void> check_readable(const std::string& path) {
  struct stat info{};
  if (::stat(path.c_str(), &info) != 0)
    return failed(path, errno == ENOENT ? "The file does not exist" : "The file's status cannot be read", errno);
  return check_kind(path, info.st_mode);
}

namespace {

/// Reads all bytes of the file. @param pipes false: pipes are refused too
Result<std::string> read(const std::string& path, std::size_t max_size, bool pipes) {
  // The kind is checked before opening, because opening a device may block or have effects, and again after it: the path may have changed.
  if (Result<void> readable = check_readable(path); !readable) return fail(std::move(readable.error()));
  // With O_NONBLOCK a pipe is opened at once, although nobody writes into it. The flag has no effect on regular files.
  Descriptor file(::open(path.c_str(), O_RDONLY | O_CLOEXEC | (pipes ? 0 : O_NONBLOCK)));
  if (file.get() < 0) return failed(path, errno == ENOENT ? "The file does not exist" : "The file cannot be opened", errno);
  struct stat info{};
  if (::fstat(file.get(), &info) != 0) return failed(path, "The file's status cannot be read", errno);
  if (Result<void> readable = check_kind(path, info.st_mode); !readable) return fail(std::move(readable.error()));
  if (!pipes && S_ISFIFO(info.st_mode)) return fail(ErrorCode::io, path, "This is a pipe, not a file.", "Name a file.");
  const auto too_large = [&] {
    return fail(ErrorCode::range, path, "The file is larger than " + std::to_string(max_size) + " bytes.",
                "Check that it is the right file, or split it.");
  };
  const std::size_t size = info.st_size > 0 ? static_cast<std::size_t>(info.st_size) : 0;
  if (size > max_size) return too_large();
  std::string text;
  text.reserve(size);
  std::vector<char> buffer(std::size_t{1} << 18);
  for (;;) {
    const ssize_t n = ::read(file.get(), buffer.data(), buffer.size());
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) return failed(path, "The file cannot be read", errno);
    if (n == 0) return text;
    if (text.size() + static_cast<std::size_t>(n) > max_size) return too_large();
    text.append(buffer.data(), static_cast<std::size_t>(n));
  }
}

/// Writes into an existing pipe or character device.
Result<void> write_into(const std::string& path, std::span<const std::byte> bytes) {
  Descriptor file(::open(path.c_str(), O_WRONLY | O_CLOEXEC | O_NOCTTY));
  if (file.get() < 0) return failed(path, "The file cannot be opened for writing", errno);
  if (!write_all(file.get(), bytes) || !file.close()) return failed(path, "The file cannot be written", errno);
  return {};
}

}  // namespace

Result<std::string> read_file(const std::string& path, std::size_t max_size) { return read(path, max_size, true); }
Result<std::string> read_regular_file(const std::string& path, std::size_t max_size) { return read(path, max_size, false); }

namespace {

/// A new file beside the file that it will replace. The destructor removes the new file if it was not put into place.
class StagedFile {
 public:
  StagedFile() = default;
  StagedFile(StagedFile&& other) noexcept
      : path_(std::move(other.path_)),
        target_(std::move(other.target_)),
        folder_(std::move(other.folder_)),
        temporary_(std::exchange(other.temporary_, {})) {}
  StagedFile& operator=(StagedFile&&) = delete;
  ~StagedFile() {
    if (!temporary_.empty()) ::unlink(temporary_.c_str());
  }

  /// Writes the new file and flushes it to the disk. The path must not be a pipe or a device.
  static Result<StagedFile> write(const std::string& path, std::span<const std::byte> bytes) {
    StagedFile staged;
    staged.path_ = path;
    // If the path is a symbolic link, its target is replaced, not the link.
    std::error_code link_error;
    const std::filesystem::path resolved = std::filesystem::weakly_canonical(path, link_error);
    staged.target_ = link_error || path.empty() ? path : resolved.string();
    const std::filesystem::path parent = std::filesystem::path(staged.target_).parent_path();
    const std::string folder = parent.empty() ? "." : parent.string();
    staged.folder_ = folder;

    struct stat info{};
    if (::stat(folder.c_str(), &info) != 0)
      return failed(path, errno == ENOENT ? "The folder " + folder + " does not exist" : "The folder " + folder + " cannot be used", errno);
    if (!S_ISDIR(info.st_mode)) return failed(path, "The path " + folder + " is not a folder", ENOTDIR);
    mode_t mode = 0;
    if (::stat(staged.target_.c_str(), &info) == 0) {
      if (S_ISDIR(info.st_mode)) return failed(path, "This is a folder, not a file", EISDIR);
      mode = info.st_mode & 07777;
    } else {
      const mode_t mask = ::umask(0);
      ::umask(mask);
      mode = 0666 & ~mask;
    }

    std::string temporary = folder + "/.ugoki-XXXXXX";
    Descriptor file(::mkstemp(temporary.data()));
    if (file.get() < 0) return failed(path, "No file can be created in the folder " + folder, errno);
    staged.temporary_ = temporary;
    int error = 0;
    if (!write_all(file.get(), bytes) || ::fchmod(file.get(), mode) != 0 || ::fsync(file.get()) != 0) error = errno;
    if (!file.close() && error == 0) error = errno;
    if (error != 0) return failed(path, "The file cannot be written", error);
    return staged;
  }

  /// Replaces the old file.
  Result<void> put_into_place() {
    if (::rename(temporary_.c_str(), target_.c_str()) != 0) return failed(path_, "The file cannot be written", errno);
    temporary_.clear();
    // The directory entry must reach the disk too. Some file systems do not support fsync() of a folder, so its failure is ignored.
    if (const Descriptor directory(::open(folder_.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC)); directory.get() >= 0)
      ::fsync(directory.get());
    return {};
  }

 private:
  std::string path_, target_, folder_, temporary_;  // temporary_: path of the new file; empty: none
};

/// Whether bytes must be written into the existing file instead of replacing it. Error: the path is a block device or a socket.
Result<bool> is_written_into(const std::string& path) {
  struct stat existing{};
  if (::stat(path.c_str(), &existing) != 0) return false;
  if (S_ISBLK(existing.st_mode) || S_ISSOCK(existing.st_mode))
    return fail(ErrorCode::io, path, S_ISBLK(existing.st_mode) ? "This is a device, not a file." : "This is a socket, not a file.",
                "Name another file.");
  return S_ISFIFO(existing.st_mode) || S_ISCHR(existing.st_mode);
}

}  // namespace

Result<void> write_file(const std::string& path, std::span<const std::byte> bytes) {
  const Result<bool> into = is_written_into(path);
  if (!into) return fail(into.error());
  if (*into) return write_into(path, bytes);
  Result<StagedFile> staged = StagedFile::write(path, bytes);
  if (!staged) return fail(std::move(staged.error()));
  return staged->put_into_place();
}

Result<void> write_files(std::span<const FileText> files) {
  std::vector<StagedFile> staged;
  std::vector<const FileText*> written_into;
  for (const FileText& f : files) {
    const Result<bool> into = is_written_into(f.path);
    if (!into) return fail(into.error());
    if (*into) {
      written_into.push_back(&f);
      continue;
    }
    Result<StagedFile> one = StagedFile::write(f.path, std::as_bytes(std::span(f.text)));
    if (!one) return fail(std::move(one.error()));
    staged.push_back(std::move(*one));
  }
  for (StagedFile& one : staged)
    if (Result<void> done = one.put_into_place(); !done) return done;
  for (const FileText* f : written_into)
    if (Result<void> done = write_into(f->path, std::as_bytes(std::span(f->text))); !done) return done;
  return {};
}

Result<void> write_file(const std::string& path, std::string_view text) { return write_file(path, std::as_bytes(std::span(text))); }

}  // namespace ugoki::files
