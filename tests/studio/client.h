#pragma once
// Blocking HTTP and WebSocket client on raw sockets, for tests. It does not use the server's library, so that it is an independent check.

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace ugoki::studio::test {

/// A TCP connection to 127.0.0.1; the destructor closes it.
class Socket {
 public:
  explicit Socket(std::uint16_t port);
  ~Socket();
  Socket(const Socket&) = delete;
  Socket& operator=(const Socket&) = delete;

  bool send(std::string_view bytes);
  /// Reads up to `size` bytes; empty after `seconds` or at the end of the stream.
  std::string receive(std::size_t size, double seconds = 20);
  /// Reads everything until the peer closes the connection.
  std::string receive_all(double seconds = 20);
  [[nodiscard]] int fd() const { return fd_; }

 private:
  int fd_ = -1;
};

struct Reply {
  int status = 0;
  std::map<std::string, std::string> headers;  ///< names in lower case
  std::string body;
};

/// Sends one request on a new connection. `headers`: complete lines without line ends; a Host header is added if there is none.
Reply request(std::uint16_t port, const std::string& method, const std::string& target, const std::vector<std::string>& headers = {},
              const std::string& body = {});

class WebSocket {
 public:
  WebSocket(std::uint16_t port, const std::string& target, const std::vector<std::string>& headers = {});

  [[nodiscard]] int status() const { return status_; }  ///< HTTP status of the handshake; 101: open
  [[nodiscard]] Socket& socket() { return socket_; }
  bool send_text(std::string_view text) { return send_frame(0x1, text); }
  bool send_frame(int opcode, std::string_view payload, bool masked = true);

  struct Message {
    int opcode = 0;  ///< 1 text, 2 binary, 8 close
    std::string data;
  };
  /// The next message; nothing after `seconds` or at the end of the stream. Pings are answered automatically.
  std::optional<Message> receive(double seconds = 20);
  /// The next text message for which `fits` is true. Other texts are passed to `on_text`, frames to `on_frame`.
  std::optional<std::string> receive_text(const std::function<bool(const std::string&)>& fits, double seconds = 20);
  std::function<void(const std::string&)> on_frame;
  std::function<void(const std::string&)> on_text;

 private:
  bool fill(std::size_t size, double seconds);
  Socket socket_;
  std::string buffer_;
  int status_ = 0;
};

}  // namespace ugoki::studio::test
