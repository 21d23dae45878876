#pragma once
// HTTP and WebSocket server on 127.0.0.1: transport and access control only; independent of the content of messages.

#include <chrono>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>

#include "ugoki/base/result.h"
#include "ugoki/studio/outbox.h"

namespace ugoki::studio {

/// A request to /api/... that passed the access control.
struct ApiRequest {
  std::string method;  ///< "GET" or "POST"
  std::string path;    ///< decoded path, begins with "/api/"
  std::string query;   ///< undecoded query; read it with query_value (security.h)
  std::string body;
};

struct ApiReply {
  int status = 200;
  std::string body;
  std::string type = "application/json";
};

/// Callbacks of the server. They are called on the server's thread and must not block.
class ServerEvents {
 public:
  virtual ~ServerEvents() = default;
  /// A request to /api/... @param answer to be called once, from any thread
  virtual void on_api(ApiRequest request, std::function<void(ApiReply)> answer) = 0;
  /// A message from a page. The page's next message is read only after `done` was called (once, from any thread).
  virtual void on_message(ClientId client, std::string text, std::function<void()> done) = 0;
  /// A binary message from a page, if ServerOptions::binary_messages allows them; otherwise as on_message().
  virtual void on_bytes(ClientId, std::string /*bytes*/, std::function<void()> done) { done(); }
  virtual void on_close(ClientId client) = 0;
};

struct ServerOptions {
  std::uint16_t port = 0;                                 ///< port on 127.0.0.1; 0: any free port
  std::string key;                                        ///< the token is derived from key and port; empty: a new random key
  std::filesystem::path web;                              ///< folder of the page, with index.html; empty: no page
  std::string page;                                       ///< if not empty: the only page, complete with its scripts, instead of `web`
  std::size_t max_import_bytes = std::size_t{256} << 20;  ///< maximum size of the body of an import request
  std::size_t max_message_bytes = std::size_t{8} << 20;   ///< maximum size of a WebSocket message from a page
  bool binary_messages = false;                           ///< false: a page that sends a binary message is disconnected
  std::size_t max_waiting_bytes = std::size_t{64} << 20;  ///< texts queued for one page; a page that exceeds this is disconnected
  std::size_t max_connections = 128;                      ///< a further connection closes the oldest one that has no admitted request
  std::chrono::seconds header_time{5};                    ///< timeout for a request's header; also ends an idle connection
  std::chrono::seconds request_time{15};                  ///< timeout for a reply, and for the body of a request without the token
  std::chrono::seconds body_time{120};                    ///< timeout for the body of a request with the token
  std::size_t max_uploads = 32;                           ///< requests with the token whose bodies arrive at the same time
  std::chrono::seconds upload_time{10};                   ///< beyond max_uploads, a new body replaces the oldest one that takes longer
};

/// The HTTP and WebSocket server. Runs on its own thread from listen() to the destructor.
class Server final : public Outbox {
 public:
  /// Opens the port and starts to answer requests. Errors: the port is in use or not permitted.
  /// @param events must outlive the server
  [[nodiscard]] static Result<std::unique_ptr<Server>> listen(ServerOptions options, ServerEvents& events);
  ~Server() override;  ///< closes every connection and ends the thread

  [[nodiscard]] std::uint16_t port() const;
  [[nodiscard]] const std::string& token() const;  ///< secret for the header "Authorization: Bearer TOKEN"
  /// Address of the page: "http://127.0.0.1:PORT/#code=CODE". Browsers do not send the part after '#'. The code is valid until this server
  /// ends.
  [[nodiscard]] std::string address() const;

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
