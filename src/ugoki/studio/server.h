#pragma once
// HTTP and WebSocket on 127.0.0.1: transport and its safety only, no knowledge of what is said.

#include <chrono>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>

#include "ugoki/base/result.h"
#include "ugoki/studio/outbox.h"

namespace ugoki::studio {

/// A request to /api/..., already admitted.
struct ApiRequest {
  std::string method;  ///< "GET" or "POST"
  std::string path;    ///< decoded, begins with "/api/"
  std::string query;   ///< see query_value in security.h
  std::string body;
};

struct ApiReply {
  int status = 200;
  std::string body;
  std::string type = "application/json";
};

/// Called on the server's thread: must return at once.
class ServerEvents {
 public:
  virtual ~ServerEvents() = default;
  /// @param answer to be called once, from any thread
  virtual void on_api(ApiRequest request, std::function<void(ApiReply)> answer) = 0;
  /// The next message of this page is read only when `done` was called (once, from any thread).
  virtual void on_message(ClientId client, std::string text, std::function<void()> done) = 0;
  virtual void on_close(ClientId client) = 0;
};

struct ServerOptions {
  std::uint16_t port = 0;                                 ///< 0: any free one
  std::string token;                                      ///< empty: a new one
  std::filesystem::path web;                              ///< folder with index.html; empty: no page
  std::size_t max_import_bytes = std::size_t{256} << 20;  ///< of a POST's body
  std::size_t max_message_bytes = std::size_t{8} << 20;   ///< of a WebSocket message from a page
  std::size_t max_waiting_bytes = std::size_t{64} << 20;  ///< texts that wait for one page before it is let go
  std::size_t max_connections = 128;
  std::chrono::seconds request_time{15};  ///< for a request's header; idle connections close after it
  std::chrono::seconds body_time{120};
};

/// One thread of its own from listen() to its end.
class Server final : public Outbox {
 public:
  /// Listens; requests are answered from now on. Errors: the port is taken or not allowed.
  /// @param events must outlive the server
  [[nodiscard]] static Result<std::unique_ptr<Server>> listen(ServerOptions options, ServerEvents& events);
  ~Server() override;  ///< closes every connection

  [[nodiscard]] std::uint16_t port() const;
  [[nodiscard]] const std::string& token() const;
  [[nodiscard]] std::string address() const;  ///< "http://127.0.0.1:PORT/?token=TOKEN"

  void send(ClientId client, std::string text) override;
  void broadcast(std::string text) override;
  void broadcast_frame(FrameBytes frame) override;
  void send_frame(ClientId client, FrameBytes frame) override;

  class Impl;

 private:
  explicit Server(std::shared_ptr<Impl> impl);
  std::shared_ptr<Impl> impl_;
};

}  // namespace ugoki::studio
