#include "ugoki/studio/session_key.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <optional>

#include "ugoki/base/sha256.h"
#include "ugoki/studio/security.h"

namespace ugoki::studio {
namespace {

constexpr std::size_t key_size = 43;  // number of characters of a key, as from make_token

std::unexpected<Error> failure(const std::string& path, const std::string& message) {
  return fail(ErrorCode::io, path, message + ": " + std::strerror(errno) + ".",
              "Make the folder writable, or set XDG_STATE_HOME to a folder that is.");
}

/// The key in a file that only this user can read; nullopt if the file does not exist, is damaged or is readable by others.
std::optional<std::string> read_key(const std::string& path) {
  const int fd = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK);
  if (fd < 0) return std::nullopt;
  std::string key(key_size, '\0');
  struct stat status{};
  const bool is_private =
      ::fstat(fd, &status) == 0 && S_ISREG(status.st_mode) && status.st_uid == ::geteuid() && (status.st_mode & 077) == 0;
  const bool complete = is_private && status.st_size == static_cast<off_t>(key_size) &&
                        ::read(fd, key.data(), key.size()) == static_cast<ssize_t>(key.size());
  ::close(fd);
  if (!complete) return std::nullopt;
  return key;
}

std::string hash_bytes(std::string_view text) {
  const std::string digits = sha256(text);
  const auto value = [](char c) { return c <= '9' ? c - '0' : c - 'a' + 10; };
  std::string bytes;
  for (std::size_t i = 0; i < digits.size(); i += 2) bytes.push_back(static_cast<char>(value(digits[i]) * 16 + value(digits[i + 1])));
  return bytes;
}

}  // namespace

std::string default_key_file() {
  const char* state = std::getenv("XDG_STATE_HOME");
  if (state != nullptr && *state == '/') return std::string(state) + "/ugoki/studio.key";
  const char* home = std::getenv("HOME");
  return home != nullptr && *home == '/' ? std::string(home) + "/.local/state/ugoki/studio.key" : std::string();
}

Result<std::string> read_or_make_key(const std::string& path) {
  if (std::optional<std::string> key = read_key(path)) return std::move(*key);
  std::error_code ignored;
  std::filesystem::create_directories(std::filesystem::path(path).parent_path(), ignored);  // if this failed, mkostemp reports it
  std::string draft = path + ".XXXXXX";
  const int fd = ::mkostemp(draft.data(), O_CLOEXEC);  // creates the file with permissions 0600
  if (fd < 0) return failure(path, "The studio's key cannot be stored");
  const std::string key = make_token();
  const bool written = ::write(fd, key.data(), key.size()) == static_cast<ssize_t>(key.size());
  const bool closed = ::close(fd) == 0;
  if (!written || !closed || ::rename(draft.c_str(), path.c_str()) != 0) {
    const std::unexpected<Error> error = failure(path, "The studio's key cannot be stored");
    ::unlink(draft.c_str());
    return error;
  }
  // If two studios made a key at the same time, both use the key that was stored last.
  return read_key(path).value_or(key);
}

std::string hmac_sha256(std::string_view key, std::string_view text) {
  constexpr std::size_t block = 64;  // block size of SHA-256, bytes
  std::string padded = key.size() > block ? hash_bytes(key) : std::string(key);
  padded.resize(block, '\0');
  std::string inner = padded, outer = padded;
  for (char& c : inner) c = static_cast<char>(c ^ 0x36);
  for (char& c : outer) c = static_cast<char>(c ^ 0x5c);
  return sha256(outer + hash_bytes(inner + std::string(text)));
}

std::string derive_token(std::string_view key, std::uint16_t port) {
  return hmac_sha256(key, "ugoki studio 127.0.0.1:" + std::to_string(port));
}

}  // namespace ugoki::studio
