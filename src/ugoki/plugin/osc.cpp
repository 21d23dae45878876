#include "ugoki/plugin/osc.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <bit>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <utility>

namespace ugoki::plugin {
namespace {

constexpr int max_depth = 8;                // maximum nesting depth of bundles; bounds the recursion
constexpr std::size_t max_bytes = 65536;    // maximum size of a packet: UDP carries less than 64 KiB
constexpr int max_packets_per_poll = 1000;  // so that a flood of packets cannot stop the circuit

/// The unread bytes of a packet. Its functions read from the front and return false if too few bytes are left.
class Packet {
 public:
  explicit Packet(std::span<const std::byte> bytes) : left_(bytes) {}
  [[nodiscard]] bool empty() const { return left_.empty(); }
  /// Reads a big-endian integer of `size` bytes.
  bool word(std::uint64_t& value, std::size_t size) {
    if (left_.size() < size) return false;
    value = 0;
    for (std::size_t i = 0; i < size; ++i) value = value << 8 | static_cast<std::uint64_t>(left_[i]);
    left_ = left_.subspan(size);
    return true;
  }
  /// A zero-terminated text, padded to a multiple of 4 bytes.
  bool text(std::string_view& value) {
    const auto* begin = reinterpret_cast<const char*>(left_.data());
    const auto* end = left_.empty() ? nullptr : static_cast<const char*>(std::memchr(begin, 0, left_.size()));
    if (!end) return false;
    value = {begin, static_cast<std::size_t>(end - begin)};
    return skip((value.size() + 4) / 4 * 4);
  }
  bool skip(std::size_t size) {
    if (left_.size() < size) return false;
    left_ = left_.subspan(size);
    return true;
  }
  bool part(std::size_t size, std::span<const std::byte>& value) {
    value = left_.first(std::min(size, left_.size()));
    return skip(size);
  }

 private:
  std::span<const std::byte> left_;
};

using Visit = std::function<void(std::string_view, std::span<const double>)>;

/// Reads the arguments of a message. @param types type tags of OSC 1.0, with the leading ','
bool read_arguments(Packet& p, std::string_view types, std::vector<double>& numbers) {
  for (const char type : types.substr(1)) {
    std::uint64_t word = 0;
    std::string_view text;
    switch (type) {
      case 'f':
        if (!p.word(word, 4)) return false;
        numbers.push_back(static_cast<double>(std::bit_cast<float>(static_cast<std::uint32_t>(word))));
        break;
      case 'd':
        if (!p.word(word, 8)) return false;
        numbers.push_back(std::bit_cast<double>(word));
        break;
      case 'i':
        if (!p.word(word, 4)) return false;
        numbers.push_back(static_cast<double>(static_cast<std::int32_t>(static_cast<std::uint32_t>(word))));
        break;
      case 'h':
        if (!p.word(word, 8)) return false;
        numbers.push_back(static_cast<double>(static_cast<std::int64_t>(word)));
        break;
      case 'T': numbers.push_back(1); break;
      case 'F': numbers.push_back(0); break;
      case 'N':
      case 'I': break;
      case 's':
      case 'S':
        if (!p.text(text)) return false;
        break;
      case 'c':
      case 'r':
      case 'm':
        if (!p.skip(4)) return false;
        break;
      case 't':
        if (!p.skip(8)) return false;
        break;
      case 'b':
        if (!p.word(word, 4) || !p.skip((static_cast<std::size_t>(word) + 3) / 4 * 4)) return false;
        break;
      default: return false;
    }
    if (!numbers.empty() && !std::isfinite(numbers.back())) numbers.back() = 0;
  }
  return true;
}

/// Reads a message or a bundle that is nested in `depth` bundles.
bool read(std::span<const std::byte> bytes, const Visit& visit, int depth) {
  Packet p(bytes);
  std::string_view address, types;
  if (depth > max_depth || !p.text(address)) return false;
  if (address == "#bundle") {
    if (!p.skip(8)) return false;  // the time tag: messages are used when they arrive
    while (!p.empty()) {
      std::uint64_t size = 0;
      std::span<const std::byte> part;
      if (!p.word(size, 4) || !p.part(static_cast<std::size_t>(size), part) || !read(part, visit, depth + 1)) return false;
    }
    return true;
  }
  if (!address.starts_with("/") || !p.text(types) || !types.starts_with(",")) return false;
  std::vector<double> numbers;
  if (!read_arguments(p, types, numbers)) return false;
  visit(address, numbers);
  return true;
}

}  // namespace

bool read_osc(std::span<const std::byte> packet, const Visit& visit) { return read(packet, visit, 0); }

Result<OscReceiver> OscReceiver::open(std::uint16_t port) {
  const int socket = ::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(port);
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof address;
  if (socket < 0 || ::bind(socket, reinterpret_cast<const sockaddr*>(&address), size) != 0 ||
      ::getsockname(socket, reinterpret_cast<sockaddr*>(&address), &size) != 0) {
    const std::string why = std::strerror(errno);
    if (socket >= 0) ::close(socket);
    return fail(ErrorCode::io, "port " + std::to_string(port), "The port cannot be opened for OSC messages: " + why + ".",
                "Choose another port.");
  }
  return OscReceiver(socket, ntohs(address.sin_port));
}

OscReceiver::OscReceiver(OscReceiver&& other) noexcept : socket_(std::exchange(other.socket_, -1)), port_(other.port_) {}
OscReceiver::~OscReceiver() {
  if (socket_ >= 0) ::close(socket_);
}

void OscReceiver::poll(const Visit& visit) {
  std::byte buffer[max_bytes];
  for (int i = 0; i < max_packets_per_poll; ++i) {
    const ssize_t n = ::recv(socket_, buffer, sizeof buffer, 0);
    if (n < 0) return;
    (void)read_osc({buffer, static_cast<std::size_t>(n)}, visit);
  }
}

}  // namespace ugoki::plugin
