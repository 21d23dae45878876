#include "ugoki/studio/channel.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/time.h>
#include <unistd.h>

#include <cerrno>
#include <cstdint>
#include <cstring>

namespace ugoki::studio {
namespace {

constexpr std::uint32_t max_text = 64u << 20;  // maximum size, bytes; bounds the buffer that receive() allocates if the length is corrupt

class Fd {
 public:
  explicit Fd(int fd = -1) : fd_(fd) {}
  Fd(const Fd&) = delete;
  Fd& operator=(const Fd&) = delete;
  ~Fd() { reset(-1); }
  void reset(int fd) {
    if (fd_ >= 0) close(fd_);
    fd_ = fd;
  }
  [[nodiscard]] int get() const { return fd_; }

 private:
  int fd_;
};

bool write_all(int fd, const std::byte* data, std::size_t size) {
  while (size > 0) {
    const ssize_t n = ::write(fd, data, size);
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) return false;
    data += n;
    size -= static_cast<std::size_t>(n);
  }
  return true;
}

bool send_all(int fd, const char* data, std::size_t size) {
  while (size > 0) {
    const ssize_t n = ::send(fd, data, size, MSG_NOSIGNAL);
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) return false;
    data += n;
    size -= static_cast<std::size_t>(n);
  }
  return true;
}

bool receive_all(int fd, char* data, std::size_t size) {
  while (size > 0) {
    const ssize_t n = ::recv(fd, data, size, 0);
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) return false;
    data += n;
    size -= static_cast<std::size_t>(n);
  }
  return true;
}

/// Sends the text's size as four bytes. Attaches the file descriptor `attached` to them if it is >= 0 (SCM_RIGHTS).
bool send_head(int fd, std::uint32_t size, int attached) {
  iovec part{&size, sizeof size};
  msghdr message{};
  message.msg_iov = &part;
  message.msg_iovlen = 1;
  alignas(cmsghdr) char control[CMSG_SPACE(sizeof(int))] = {};
  if (attached >= 0) {
    message.msg_control = control;
    message.msg_controllen = sizeof control;
    cmsghdr* head = CMSG_FIRSTHDR(&message);
    head->cmsg_level = SOL_SOCKET;
    head->cmsg_type = SCM_RIGHTS;
    head->cmsg_len = CMSG_LEN(sizeof(int));
    std::memcpy(CMSG_DATA(head), &attached, sizeof attached);
  }
  while (true) {
    const ssize_t n = ::sendmsg(fd, &message, MSG_NOSIGNAL);
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) return false;
    return send_all(fd, reinterpret_cast<const char*>(&size) + n, sizeof size - static_cast<std::size_t>(n));
  }
}

bool receive_head(int fd, std::uint32_t& size, Fd& attached) {
  iovec part{&size, sizeof size};
  msghdr message{};
  message.msg_iov = &part;
  message.msg_iovlen = 1;
  alignas(cmsghdr) char control[CMSG_SPACE(sizeof(int))] = {};
  message.msg_control = control;
  message.msg_controllen = sizeof control;
  ssize_t n = 0;
  do {
    n = ::recvmsg(fd, &message, MSG_CMSG_CLOEXEC);
  } while (n < 0 && errno == EINTR);
  if (n <= 0) return false;
  for (cmsghdr* head = CMSG_FIRSTHDR(&message); head != nullptr; head = CMSG_NXTHDR(&message, head)) {
    if (head->cmsg_level != SOL_SOCKET || head->cmsg_type != SCM_RIGHTS) continue;
    int descriptor = -1;
    std::memcpy(&descriptor, CMSG_DATA(head), sizeof descriptor);
    attached.reset(descriptor);
  }
  return receive_all(fd, reinterpret_cast<char*>(&size) + n, sizeof size - static_cast<std::size_t>(n));
}

bool read_block(int fd, std::vector<std::byte>& block) {
  struct stat status{};
  if (fstat(fd, &status) != 0 || status.st_size < 0) return false;
  block.resize(static_cast<std::size_t>(status.st_size));
  std::size_t at = 0;
  while (at < block.size()) {
    const ssize_t n = ::pread(fd, block.data() + at, block.size() - at, static_cast<off_t>(at));
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) return false;
    at += static_cast<std::size_t>(n);
  }
  return true;
}

}  // namespace

Channel& Channel::operator=(Channel&& other) noexcept {
  if (this != &other) {
    if (fd_ >= 0) close(fd_);
    fd_ = std::exchange(other.fd_, -1);
  }
  return *this;
}

Channel::~Channel() {
  if (fd_ >= 0) close(fd_);
}

Result<std::pair<Channel, Channel>> Channel::make_pair() {
  int fds[2];
  if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, fds) != 0) {
    return fail(ErrorCode::io, "interpreter", std::string("A socket cannot be created: ") + std::strerror(errno) + ".",
                "Close some programs and try again.");
  }
  return std::pair<Channel, Channel>(Channel(fds[0]), Channel(fds[1]));
}

void Channel::set_send_limit(std::chrono::milliseconds time) {
  const timeval limit{time.count() / 1000, time.count() % 1000 * 1000};
  setsockopt(fd_, SOL_SOCKET, SO_SNDTIMEO, &limit, sizeof limit);
}

bool Channel::send(std::string_view text, std::span<const std::byte> block) {
  if (fd_ < 0 || text.size() > max_text) return false;
  Fd memory;
  if (!block.empty()) {
    memory.reset(memfd_create("ugoki-block", MFD_CLOEXEC));
    if (memory.get() < 0 || !write_all(memory.get(), block.data(), block.size())) return false;
  }
  return send_head(fd_, static_cast<std::uint32_t>(text.size()), memory.get()) && send_all(fd_, text.data(), text.size());
}

std::optional<ChannelMessage> Channel::receive() {
  std::uint32_t size = 0;
  Fd attached;
  if (fd_ < 0 || !receive_head(fd_, size, attached) || size > max_text) return std::nullopt;
  ChannelMessage message;
  message.text.resize(size);
  if (!receive_all(fd_, message.text.data(), size)) return std::nullopt;
  if (attached.get() >= 0 && !read_block(attached.get(), message.block)) return std::nullopt;
  return message;
}

bool Channel::other_end_closed() const {
  pollfd socket{fd_, 0, 0};
  return ::poll(&socket, 1, 0) > 0 && (socket.revents & POLLHUP) != 0;
}

void Channel::shut() {
  if (fd_ >= 0) ::shutdown(fd_, SHUT_RDWR);
}

}  // namespace ugoki::studio
