#include "ugoki/store/rescue.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <ctime>
#include <filesystem>

#include "ugoki/store/library.h"

namespace ugoki::store {
namespace {

namespace fs = std::filesystem;

/// Creates an empty file that did not exist. @return its path
Result<std::string> create_empty(const fs::path& folder, const std::string& name, const std::string& extension) {
  std::error_code ignored;
  fs::create_directories(folder, ignored);
  constexpr int max_copies = 1000;
  for (int n = 1; n <= max_copies; ++n) {
    const std::string file = (folder / (name + (n == 1 ? "" : " " + std::to_string(n)) + extension)).string();
    const int descriptor = ::open(file.c_str(), O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, 0600);
    if (descriptor >= 0) {
      ::close(descriptor);
      return file;
    }
    if (errno != EEXIST) break;
  }
  return fail(ErrorCode::io, folder.string(), "No file can be created in the folder (" + std::string(std::strerror(errno)) + ").",
              "Check the folder's permissions and the disk.");
}

}  // namespace

Result<std::string> make_rescue_copy(const std::string& path, const std::function<Result<void>(const std::string& file)>& make) {
  const std::time_t now = std::time(nullptr);
  std::tm local{};
  ::localtime_r(&now, &local);
  char date[32];
  std::strftime(date, sizeof date, "%Y-%m-%d %H-%M-%S", &local);
  const std::string name = fs::path(path).stem().string() + " (rescued " + date + ")";
  std::error_code ignored;
  const fs::path beside = fs::path(path).parent_path();
  Result<std::string> made = fail(ErrorCode::io, path, "No rescue copy was made.");
  for (const fs::path& folder :
       {beside.empty() ? fs::path(".") : beside, fs::path(Library::folder_of(Library::default_path())), fs::temp_directory_path(ignored)}) {
    made = create_empty(folder, name, fs::path(path).extension().string());
    if (!made) continue;
    const Result<void> done = make(*made);
    if (done) return made;
    for (const char* suffix : {"", "-wal", "-shm"}) fs::remove(*made + suffix, ignored);
    made = fail(done.error());
  }
  return made;
}

}  // namespace ugoki::store
