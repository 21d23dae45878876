// The only file that includes Boost.Beast (half a minute of compile time), by websocket_client.h.
#include "ugoki/studio/server.h"

#include <fcntl.h>
#include <sys/socket.h>

#include <boost/asio/read.hpp>
#include <optional>

#include "ugoki/json/json.h"
#include "ugoki/studio/error_json.h"
#include "ugoki/studio/session_key.h"
#include "ugoki/studio/static_files.h"
#include "ugoki/studio/websocket_client.h"

namespace ugoki::studio {
namespace {

constexpr std::uint32_t max_header_bytes = 16 * 1024;
constexpr std::size_t max_small_body = std::size_t{256} * 1024;  // maximum body of a request other than an import, bytes
constexpr std::size_t max_open_body = 1024;                      // maximum body of a request without the token, bytes
constexpr std::size_t large_body = std::size_t{512} * 1024;      // from this size, a body is read by read_large_body(), bytes
constexpr std::size_t largest_read = std::size_t{4} << 20;       // maximum number of bytes of one call
constexpr std::chrono::seconds drain_time{2};                    // the rest of a refused request is read for at most this time

}  // namespace

class HttpConnection : public std::enable_shared_from_this<HttpConnection> {
 public:
  HttpConnection(tcp::socket socket, Server::Impl& server) : slot_(server.connections), stream_(std::move(socket)), server_(server) {}
  ~HttpConnection() { leave_lists(); }
  HttpConnection(const HttpConnection&) = delete;
  HttpConnection& operator=(const HttpConnection&) = delete;

  /// Closes the connection before its request is complete, and frees its place among the open connections.
  void drop() {
    leave_lists();
    slot_.release();
    close();
  }
  /// Time since the body of the request began.
  [[nodiscard]] std::chrono::steady_clock::duration upload_time() const { return std::chrono::steady_clock::now() - upload_began_; }

  void read_header() {
    parser_.emplace();
    parser_->header_limit(max_header_bytes);
    parser_->body_limit(server_.options.max_import_bytes);
    set_admitted(false);
    stream_.expires_after(server_.options.header_time);
    http::async_read_header(stream_, buffer_, *parser_, [self = shared_from_this()](error_code ec, std::size_t) { self->on_header(ec); });
  }

 private:
  using Response = http::response<http::string_body>;

  void on_header(error_code ec) {
    if (ec) return on_read_error(ec);
    const auto& request = parser_->get();
    const std::optional<Target> target = parse_target(view(request.target()));
    if (!target) {
      return refuse(
          400, {ErrorCode::syntax, "request", "The requested address is not an absolute path.", "Request an address of the form /path."});
    }
    target_ = *target;
    const Admission admission = admit(request);
    if (!check_admission(admission)) return;
    const bool granted = admission == Admission::granted;
    set_admitted(granted);

    const http::verb method = request.method();
    if (method != http::verb::get && method != http::verb::head && method != http::verb::post) {
      return refuse(405, {ErrorCode::unsupported, target_.path, "The studio answers only GET, HEAD and POST.", ""});
    }
    if (target_.path == "/ws") return upgrade();
    const std::size_t limit = !granted                                                                    ? max_open_body
                              : !server_.options.page.empty()                                             ? server_.options.max_import_bytes
                              : target_.path == "/api/import" || target_.path.starts_with("/api/import/") ? server_.options.max_import_bytes
                                                                                                          : max_small_body;
    if (parser_->content_length().value_or(0) > limit) return refuse_size(limit);
    if (granted && !body_arrived() && !begin_upload()) {
      return refuse(503, {ErrorCode::conflict, target_.path,
                          "The studio receives " + std::to_string(server_.options.max_uploads) + " other requests at the moment.",
                          "Send the request again in a few seconds."});
    }
    body_limit_ = limit;
    parser_->body_limit(limit);
    stream_.expires_after(granted ? server_.options.body_time : server_.options.request_time);
    if (const std::uint64_t length = parser_->content_length().value_or(0); granted && length >= large_body)
      return read_large_body(static_cast<std::size_t>(length));
    http::async_read(stream_, buffer_, *parser_, [self = shared_from_this()](error_code error, std::size_t) { self->on_body(error); });
  }

  /// Reads the body with few system calls. Beast reads at most 64 KiB a call, which takes most of the time of a picture of a video.
  void read_large_body(std::size_t length) {
    body_.resize(length);
    const std::size_t arrived = net::buffer_copy(net::buffer(body_), buffer_.data());
    buffer_.consume(arrived);
    const auto at_most = [](error_code error, std::size_t) { return error ? std::size_t{0} : largest_read; };
    net::async_read(stream_, net::buffer(body_) + arrived, at_most, [self = shared_from_this()](error_code error, std::size_t) {
      self->parser_->eager(true);
      if (!error) self->parser_->put(net::buffer(self->body_), error);
      self->on_body(error);
    });
  }

  Admission admit(const http::request<http::string_body>& request) const {
    Credentials c;
    c.host_count = request.count(http::field::host);
    c.host = view(request[http::field::host]);
    c.origin_count = request.count(http::field::origin);
    if (c.origin_count != 0) c.origin = view(request[http::field::origin]);
    c.authorization = view(request[http::field::authorization]);
    c.subprotocols = view(request[http::field::sec_websocket_protocol]);
    c.path = target_.path;
    return server_.gate.admit(c);
  }

  bool check_admission(Admission admission) {
    switch (admission) {
      case Admission::open:
      case Admission::granted: return true;
      case Admission::bad_host:
        refuse(403, {ErrorCode::conflict, "Host", "This studio answers only at " + server_.gate.origin() + ".",
                     "Open the address that `ugoki studio` printed."});
        return false;
      case Admission::bad_origin:
        refuse(403, {ErrorCode::conflict, "Origin", "Pages of other sites may not use this studio.",
                     "Open the address that `ugoki studio` printed."});
        return false;
      case Admission::no_token:
        refuse(401, {ErrorCode::conflict, "token", "The studio's token is missing.",
                     "Open the complete address that `ugoki studio` printed, or send the header \"Authorization: Bearer TOKEN\"."});
        return false;
      case Admission::wrong_token:
        refuse(401, {ErrorCode::conflict, "token", "The token does not belong to this studio.",
                     "Open the address that `ugoki studio` printed last."});
        return false;
    }
    return false;
  }

  void on_body(error_code ec) {
    end_upload();
    if (ec) return on_read_error(ec);
    if (target_.path == "/api/session") return open_session();
    if (target_.path.starts_with("/api/")) return call_api();
    if (parser_->get().method() == http::verb::post) {
      return refuse(405, {ErrorCode::unsupported, target_.path, "This address does not accept POST requests.", ""});
    }
    if (!server_.options.page.empty() && target_.path == "/") {
      Response response = make_response(http::status::ok, content_type_of(".html"));
      response.set(http::field::cache_control, "no-store");
      response.body() = server_.options.page;
      return write(std::move(response));
    }
    Result<StaticFile> file = read_static_file(server_.options.web, target_.path);
    if (!file) return refuse(404, file.error());
    Response response = make_response(http::status::ok, file->content_type);
    response.set(http::field::cache_control, file->immutable ? "max-age=31536000, immutable" : "no-store");
    response.body() = std::move(file->bytes);
    write(std::move(response));
  }

  /// Answers a page that sends the code of its address with the token.
  void open_session() {
    if (parser_->get().method() != http::verb::post) {
      return refuse(405, {ErrorCode::unsupported, target_.path, "This address accepts only POST requests.", ""});
    }
    const Result<json::Json> body = json::parse_json(parser_->get().body(), "body");
    if (!body) return refuse(400, body.error());
    const auto code = body->is_object() ? body->find("code") : body->end();
    if (code == body->end() || !code->is_string()) {
      return refuse(
          400, {ErrorCode::syntax, "code", "The request has no code.", "Send {\"code\": CODE}, with the code of the studio's address."});
    }
    if (!equal_secret(code->get<std::string>(), server_.gate.code)) {
      return refuse(401, {ErrorCode::conflict, "code", "The code does not belong to this studio; the studio was probably restarted.",
                          "Open the address that `ugoki studio` printed last."});
    }
    answer({200, json::to_text({{"token", server_.gate.token}})});
  }

  void call_api() {
    const std::uint64_t waiting_id = ++server_.last_id;
    server_.waiting[waiting_id] = shared_from_this();
    stream_.expires_never();
    ApiRequest request{std::string(view(parser_->get().method_string())), target_.path, target_.query, std::move(parser_->get().body())};
    server_.events.on_api(std::move(request), [id = waiting_id, server = server_.weak_from_this()](ApiReply reply) {
      const std::shared_ptr<Server::Impl> impl = server.lock();
      if (!impl) return;
      net::post(impl->io, [id, raw = impl.get(), answer = std::move(reply)]() mutable {
        const auto found = raw->waiting.find(id);
        if (found == raw->waiting.end()) return;
        const std::shared_ptr<HttpConnection> self = std::move(found->second);
        raw->waiting.erase(found);
        self->answer(std::move(answer));
      });
    });
  }

  void answer(ApiReply reply) {
    Response response = make_response(static_cast<http::status>(reply.status), reply.type);
    response.set(http::field::cache_control, "no-store");
    response.body() = std::move(reply.body);
    write(std::move(response));
  }

  void upgrade() {
    if (!websocket::is_upgrade(parser_->get())) {
      return refuse(400, {ErrorCode::syntax, "/ws", "This address accepts only WebSocket connections.", "Open the studio's page."});
    }
    stream_.expires_never();
    const ClientId id = ++server_.last_id;
    auto client = std::make_shared<WebSocketClient>(std::move(stream_), std::move(slot_), server_, id);
    server_.clients[id] = client;
    client->start(parser_->release());
  }

  void on_read_error(error_code ec) {
    if (ec == http::error::body_limit) return refuse_size(body_limit_);
    if (ec == http::error::header_limit) {
      return refuse(431, {ErrorCode::range, "request", "The request's header is too long.", "Send a header of at most 16 KiB."});
    }
    if (ec == http::error::end_of_stream || ec == http::error::partial_message ||
        ec.category() != http::make_error_code(http::error::bad_method).category()) {
      return close();
    }
    refuse(400, {ErrorCode::syntax, "request", "This is not a valid HTTP request: " + ec.message() + ".",
                 "Open the studio's page in a browser."});
  }

  void refuse_size(std::size_t limit) {
    refuse(413, {ErrorCode::range, target_.path, "The request's body is larger than " + std::to_string(limit >> 10) + " KiB.",
                 "Import large files with `ugoki import FILE` from the command line."});
  }

  void refuse(int status, const Error& error) {
    const bool as_page = view(parser_->get()[http::field::accept]).find("text/html") != std::string_view::npos;
    Response response = make_response(static_cast<http::status>(status), as_page ? "text/html; charset=utf-8" : "application/json");
    response.set(http::field::cache_control, "no-store");
    if (status == 503) response.set(http::field::retry_after, std::to_string(server_.options.upload_time.count()));
    response.body() = as_page ? error_page(error) : error_body(error);
    if (!parser_->is_done()) {
      drain_ = true;
      response.keep_alive(false);
    }
    write(std::move(response));
  }

  Response make_response(http::status status, std::string_view content_type) const {
    Response response{status, parser_->get().version() == 10 ? 10u : 11u};
    response.keep_alive(parser_->is_done() && parser_->get().keep_alive());
    response.set(http::field::server, "Ugoki");
    response.set(http::field::content_type, beast::string_view(content_type.data(), content_type.size()));
    response.set(http::field::x_frame_options, "DENY");
    response.set("X-Content-Type-Options", "nosniff");
    response.set("Referrer-Policy", "no-referrer");
    response.set("Cross-Origin-Opener-Policy", "same-origin");
    response.set("Cross-Origin-Resource-Policy", "same-origin");
    response.set("Content-Security-Policy", std::string("default-src 'self'; script-src 'self' 'wasm-unsafe-eval'") +
                                                (server_.options.page.empty() ? "" : " 'unsafe-inline'") +
                                                "; style-src 'self' 'unsafe-inline'; img-src 'self' data: blob:; "
                                                "font-src 'self' data:; connect-src 'self' ws://" +
                                                server_.gate.host() +
                                                "; worker-src 'self' blob:; object-src 'none'; "
                                                "base-uri 'none'; form-action 'none'; frame-ancestors 'none'");
    return response;
  }

  void write(Response response) {
    const bool head = parser_->get().method() == http::verb::head;
    response.prepare_payload();
    if (head) {
      const std::size_t size = response.body().size();
      response.body().clear();
      response.content_length(size);
    }
    response_.emplace(std::move(response));
    stream_.expires_after(server_.options.request_time);
    http::async_write(stream_, *response_, [self = shared_from_this()](error_code ec, std::size_t) {
      if (ec) return self->close();
      const bool keep_alive = self->response_->keep_alive();
      self->response_.reset();
      if (keep_alive) return self->read_header();
      error_code ignored;
      self->stream_.socket().shutdown(tcp::socket::shutdown_send, ignored);
      if (!self->drain_) return self->close();
      self->set_admitted(false);
      self->stream_.expires_after(drain_time);
      self->drain();
    });
  }

  /// Reads and discards the rest of the request until the stream expires. Closing the connection with unread data would reset it, and the
  /// client could lose the answer.
  void drain() {
    drained_.resize(std::size_t{64} * 1024);
    stream_.async_read_some(net::buffer(drained_), [self = shared_from_this()](error_code ec, std::size_t size) {
      self->drained_bytes_ += size;
      if (ec || self->drained_bytes_ > self->server_.options.max_import_bytes) return self->close();
      self->drain();
    });
  }

  /// True if the whole body of the request is in the buffer already, or the request has none.
  [[nodiscard]] bool body_arrived() const {
    const auto length = parser_->content_length();
    return parser_->is_done() || (length && *length <= buffer_.size());
  }
  /// Counts this connection as an upload. Returns false if there are too many.
  bool begin_upload() {
    if (server_.uploads.size() >= server_.options.max_uploads && !server_.close_slow_upload()) return false;
    upload_id_ = ++server_.last_id;
    upload_began_ = std::chrono::steady_clock::now();
    server_.uploads[upload_id_] = this;
    return true;
  }
  void end_upload() {
    if (upload_id_ != 0) server_.uploads.erase(upload_id_);
    upload_id_ = 0;
  }
  void leave_lists() {
    set_admitted(true);
    end_upload();
  }

  /// @param admitted false: the connection may be closed in favour of a new one (Impl::close_oldest)
  void set_admitted(bool admitted) {
    if (unadmitted_id_ != 0) server_.unadmitted.erase(unadmitted_id_);
    unadmitted_id_ = admitted ? 0 : ++server_.last_id;
    if (!admitted) server_.unadmitted[unadmitted_id_] = this;
  }

  void close() {
    error_code ignored;
    stream_.socket().shutdown(tcp::socket::shutdown_both, ignored);
    stream_.close();
  }

  ConnectionSlot slot_;
  beast::tcp_stream stream_;
  Server::Impl& server_;
  beast::flat_buffer buffer_;
  std::optional<http::request_parser<http::string_body>> parser_;
  std::optional<Response> response_;
  std::string body_;  // being read (read_large_body); its memory is used again
  Target target_;
  std::size_t body_limit_ = 0;       // maximum size of the request's body, bytes
  std::uint64_t unadmitted_id_ = 0;  ///< key of this connection in Impl::unadmitted; 0: not in the map
  std::uint64_t upload_id_ = 0;      ///< key of this connection in Impl::uploads; 0: not in the map
  std::chrono::steady_clock::time_point upload_began_;
  bool drain_ = false;
  std::vector<char> drained_;
  std::size_t drained_bytes_ = 0;
};

Result<void> Server::Impl::listen() {
  const tcp::endpoint endpoint(net::ip::address_v4::loopback(), options.port);
  error_code ec;
  // Asio opens sockets without CLOEXEC: a child process would keep the port in use.
  const int fd = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, IPPROTO_TCP);
  if (fd < 0)
    ec.assign(errno, boost::system::system_category());
  else
    acceptor.assign(endpoint.protocol(), fd, ec);
  if (!ec) acceptor.set_option(net::socket_base::reuse_address(true), ec);
  if (!ec) acceptor.bind(endpoint, ec);
  if (!ec) acceptor.listen(net::socket_base::max_listen_connections, ec);
  if (ec) {
    return fail(ErrorCode::io, "127.0.0.1:" + std::to_string(options.port), "The studio cannot listen here: " + ec.message() + ".",
                "Choose another port with --port, or leave it out to get a free one.");
  }
  gate.port = acceptor.local_endpoint().port();
  gate.code = make_token();
  gate.token = derive_token(options.key.empty() ? make_token() : options.key, gate.port);
  accept();
  thread = std::thread([this] { run(); });
  return {};
}

void Server::Impl::run() {
  while (true) {
    try {
      io.run();
      return;
    } catch (const std::exception&) {
      // An exception (for example out of memory) ends the work for one connection, not the studio.
    }
  }
}

void Server::Impl::accept() {
  acceptor.async_accept([this](error_code ec, tcp::socket socket) {
    if (ec == net::error::operation_aborted || !acceptor.is_open()) return;
    if (ec) {  // most likely no file descriptor is free: wait until some are closed
      accept_retry.expires_after(std::chrono::milliseconds(200));
      accept_retry.async_wait([this](error_code cancelled) {
        if (!cancelled) accept();
      });
      return;
    }
    ::fcntl(socket.native_handle(), F_SETFD, FD_CLOEXEC);
    if (connections < options.max_connections || close_oldest()) {
      error_code ignored;
      socket.set_option(tcp::no_delay(true), ignored);
      std::make_shared<HttpConnection>(std::move(socket), *this)->read_header();
    }
    accept();
  });
}

void Server::Impl::shut() {
  error_code ignored;
  acceptor.close(ignored);
  accept_retry.cancel();
  for (auto& [id, client] : clients) client->shut();
  waiting.clear();
  io.stop();
}

bool Server::Impl::close_oldest() {
  if (unadmitted.empty()) return close_slow_upload();
  unadmitted.begin()->second->drop();
  return true;
}

bool Server::Impl::close_slow_upload() {
  if (uploads.empty() || uploads.begin()->second->upload_time() < options.upload_time) return false;
  uploads.begin()->second->drop();
  return true;
}

void Server::Impl::remove(ClientId client) {
  if (clients.erase(client) != 0) events.on_close(client);
}

void Server::Impl::deliver(ClientId client, const std::shared_ptr<const std::string>& text) {
  if (client != 0) {
    if (const auto found = clients.find(client); found != clients.end()) found->second->send(text);
    return;
  }
  for (auto it = clients.begin(); it != clients.end();) {
    const std::shared_ptr<WebSocketClient> to = it->second;
    ++it;  // before send(), which may remove the client from `clients`
    to->send(text);
  }
}

Server::Server(std::shared_ptr<Impl> impl) : impl_(std::move(impl)) {}

Result<std::unique_ptr<Server>> Server::listen(ServerOptions options, ServerEvents& events) {
  auto impl = std::make_shared<Impl>(std::move(options), events);
  if (Result<void> r = impl->listen(); !r) return fail(std::move(r.error()));
  return std::unique_ptr<Server>(new Server(std::move(impl)));
}

Server::~Server() {
  net::post(impl_->io, [impl = impl_.get()] { impl->shut(); });
  impl_->thread.join();
}

std::uint16_t Server::port() const { return impl_->gate.port; }
const std::string& Server::token() const { return impl_->gate.token; }
std::string Server::address() const { return impl_->gate.origin() + "/#code=" + impl_->gate.code; }

void Server::send(ClientId client, std::string text) {
  net::post(impl_->io,
            [impl = impl_.get(), client, shared = std::make_shared<const std::string>(std::move(text))] { impl->deliver(client, shared); });
}

void Server::broadcast(std::string text) { send(0, std::move(text)); }

void Server::broadcast_frame(FrameBytes frame) { send_frame(0, std::move(frame)); }

void Server::send_frame(ClientId client, FrameBytes frame) {
  net::post(impl_->io, [impl = impl_.get(), client, shared = std::move(frame)] {
    if (client != 0) {
      if (const auto found = impl->clients.find(client); found != impl->clients.end()) found->second->send(shared);
      return;
    }
    for (auto& [id, to] : impl->clients) to->send(shared);
  });
}

}  // namespace ugoki::studio
