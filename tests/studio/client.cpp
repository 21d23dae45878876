#include "client.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <chrono>
#include <cstdlib>
#include <stdexcept>

namespace ugoki::studio::test {
namespace {

using Clock = std::chrono::steady_clock;

bool has_header(const std::vector<std::string>& headers, std::string_view name) {
  return std::ranges::any_of(headers, [&](const std::string& h) { return h.starts_with(name); });
}

}  // namespace

Socket::Socket(std::uint16_t port) : fd_(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
  sockaddr_in to{};
  to.sin_family = AF_INET;
  to.sin_port = htons(port);
  to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  if (::connect(fd_, reinterpret_cast<const sockaddr*>(&to), sizeof to) != 0) throw std::runtime_error("no connection");
}

Socket::~Socket() { ::close(fd_); }

bool Socket::send(std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t n = ::send(fd_, bytes.data(), bytes.size(), MSG_NOSIGNAL);
    if (n <= 0) return false;
    bytes.remove_prefix(static_cast<std::size_t>(n));
  }
  return true;
}

std::string Socket::receive(std::size_t size, double seconds) {
  pollfd p{fd_, POLLIN, 0};
  if (::poll(&p, 1, static_cast<int>(seconds * 1000)) <= 0) return {};
  std::string out(size, '\0');
  const ssize_t n = ::recv(fd_, out.data(), out.size(), 0);
  out.resize(n > 0 ? static_cast<std::size_t>(n) : 0);
  return out;
}

std::string Socket::receive_all(double seconds) {
  std::string out;
  while (true) {
    const std::string part = receive(65536, seconds);
    if (part.empty()) return out;
    out += part;
  }
}

Reply request(std::uint16_t port, const std::string& method, const std::string& target, const std::vector<std::string>& headers,
              const std::string& body) {
  Socket socket(port);
  std::string text = method + " " + target + " HTTP/1.1\r\n";
  if (!has_header(headers, "Host:")) text += "Host: 127.0.0.1:" + std::to_string(port) + "\r\n";
  for (const std::string& h : headers) text += h + "\r\n";
  if (!body.empty() && !has_header(headers, "Content-Length:")) text += "Content-Length: " + std::to_string(body.size()) + "\r\n";
  text += "Connection: close\r\n\r\n" + body;
  socket.send(text);
  const std::string answer = socket.receive_all();
  Reply reply;
  if (answer.size() < 12 || !answer.starts_with("HTTP/1.1 ")) return reply;
  reply.status = std::atoi(answer.c_str() + 9);
  const std::size_t end = answer.find("\r\n\r\n");
  std::size_t at = answer.find("\r\n") + 2;
  while (at < end) {
    const std::size_t stop = answer.find("\r\n", at);
    const std::string line = answer.substr(at, stop - at);
    const std::size_t colon = line.find(": ");
    std::string name = line.substr(0, colon);
    std::ranges::transform(name, name.begin(), [](char c) { return static_cast<char>(std::tolower(c)); });
    reply.headers[name] = line.substr(colon + 2);
    at = stop + 2;
  }
  reply.body = answer.substr(end + 4);
  return reply;
}

WebSocket::WebSocket(std::uint16_t port, const std::string& target, const std::vector<std::string>& headers) : socket_(port) {
  std::string text = "GET " + target + " HTTP/1.1\r\n";
  if (!has_header(headers, "Host:")) text += "Host: 127.0.0.1:" + std::to_string(port) + "\r\n";
  for (const std::string& h : headers) text += h + "\r\n";
  text += "Upgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\r\n";
  socket_.send(text);
  while (buffer_.find("\r\n\r\n") == std::string::npos) {
    const std::string part = socket_.receive(4096);
    if (part.empty()) return;
    buffer_ += part;
  }
  status_ = std::atoi(buffer_.c_str() + 9);
  buffer_.erase(0, buffer_.find("\r\n\r\n") + 4);
}

bool WebSocket::send_frame(int opcode, std::string_view payload, bool masked) {
  std::string out(1, static_cast<char>(0x80 | opcode));
  const int mask_bit = masked ? 0x80 : 0;
  if (payload.size() < 126) {
    out.push_back(static_cast<char>(mask_bit | static_cast<int>(payload.size())));
  } else if (payload.size() < 65536) {
    out.push_back(static_cast<char>(mask_bit | 126));
    out.push_back(static_cast<char>(payload.size() >> 8));
    out.push_back(static_cast<char>(payload.size() & 255));
  } else {
    out.push_back(static_cast<char>(mask_bit | 127));
    for (int i = 7; i >= 0; --i) out.push_back(static_cast<char>((payload.size() >> (8 * i)) & 255));
  }
  constexpr char mask[4] = {0x11, 0x22, 0x33, 0x44};
  if (masked) out.append(mask, 4);
  for (std::size_t i = 0; i < payload.size(); ++i) out.push_back(masked ? static_cast<char>(payload[i] ^ mask[i % 4]) : payload[i]);
  return socket_.send(out);
}

bool WebSocket::fill(std::size_t size, double seconds) {
  const auto end = Clock::now() + std::chrono::duration<double>(seconds);
  while (buffer_.size() < size) {
    const double left = std::chrono::duration<double>(end - Clock::now()).count();
    if (left <= 0) return false;
    const std::string part = socket_.receive(65536, left);
    if (part.empty()) return false;
    buffer_ += part;
  }
  return true;
}

std::optional<WebSocket::Message> WebSocket::receive(double seconds) {
  while (true) {
    if (!fill(2, seconds)) return std::nullopt;
    const int opcode = buffer_[0] & 15;
    std::size_t size = static_cast<unsigned char>(buffer_[1]) & 127, head = 2;
    if (size >= 126) {
      const std::size_t bytes = size == 126 ? 2 : 8;
      head += bytes;
      if (!fill(head, seconds)) return std::nullopt;
      size = 0;
      for (std::size_t i = 0; i < bytes; ++i) size = (size << 8) | static_cast<unsigned char>(buffer_[2 + i]);
    }
    if (!fill(head + size, seconds)) return std::nullopt;
    const bool last = (buffer_[0] & 0x80) != 0;
    Message message{opcode, buffer_.substr(head, size)};
    buffer_.erase(0, head + size);
    if (opcode == 9) {
      send_frame(10, message.data);
      continue;
    }
    while (!last) {  // the server's library splits large messages into several frames
      std::optional<Message> rest;
      if (!fill(2, seconds)) return std::nullopt;
      const bool end = (buffer_[0] & 0x80) != 0;
      buffer_[0] = static_cast<char>(0x80 | (buffer_[0] & 15));
      rest = receive(seconds);
      if (!rest) return std::nullopt;
      message.data += rest->data;
      if (end) break;
    }
    return message;
  }
}

std::optional<std::string> WebSocket::receive_text(const std::function<bool(const std::string&)>& fits, double seconds) {
  const auto end = Clock::now() + std::chrono::duration<double>(seconds);
  while (true) {
    const double left = std::chrono::duration<double>(end - Clock::now()).count();
    if (left <= 0) return std::nullopt;
    std::optional<Message> message = receive(left);
    if (!message || message->opcode == 8) return std::nullopt;
    if (message->opcode == 2) {
      if (on_frame) on_frame(message->data);
      continue;
    }
    if (on_text) on_text(message->data);
    if (fits(message->data)) return message->data;
  }
}

}  // namespace ugoki::studio::test
