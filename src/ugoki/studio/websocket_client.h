#pragma once
// Parts of the studio's server that only server.cpp includes: its state, and the connection of one page.

#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>
#include <deque>
#include <map>
#include <thread>
#include <utility>

#include "ugoki/studio/connection_slot.h"
#include "ugoki/studio/security.h"
#include "ugoki/studio/server.h"

namespace ugoki::studio {

namespace beast = boost::beast;
namespace http = beast::http;
namespace net = boost::asio;
namespace websocket = beast::websocket;
using tcp = net::ip::tcp;
using error_code = boost::system::error_code;

inline constexpr std::chrono::seconds page_silence{60};  // a page that answers no ping for this time is disconnected

inline std::string_view view(beast::string_view text) { return {text.data(), text.size()}; }

class HttpConnection;
class WebSocketClient;

class Server::Impl : public std::enable_shared_from_this<Server::Impl> {
 public:
  Impl(ServerOptions given, ServerEvents& listener) : options(std::move(given)), events(listener) {}

  Result<void> listen();
  void run();
  void shut();
  void accept();
  void remove(ClientId client);
  /// Closes the connection that waits longest without an admitted request, else the oldest slow upload. Returns false if there is neither.
  bool close_oldest();
  /// Closes the oldest upload if it has taken longer than options.upload_time. Returns false if there is none.
  bool close_slow_upload();
  void deliver(ClientId client, const std::shared_ptr<const std::string>& text);

  /// Connections without an admitted request, oldest first. Each one removes itself in its destructor, so the map must outlive `io`.
  std::map<std::uint64_t, HttpConnection*> unadmitted;
  std::map<std::uint64_t, HttpConnection*> uploads;  ///< connections with an admitted request whose body is incomplete; as `unadmitted`
  net::io_context io{1};
  ServerOptions options;
  ServerEvents& events;
  Gate gate;
  tcp::acceptor acceptor{io};
  net::steady_timer accept_retry{io};
  std::map<ClientId, std::shared_ptr<WebSocketClient>> clients;
  std::map<std::uint64_t, std::shared_ptr<HttpConnection>> waiting;  ///< connections whose request is being answered
  std::uint64_t last_id = 0;
  std::size_t connections = 0;
  std::thread thread;
};

/// The connection of one page: receives its messages, and sends texts in order and only the newest frame.
class WebSocketClient : public std::enable_shared_from_this<WebSocketClient> {
 public:
  WebSocketClient(beast::tcp_stream stream, ConnectionSlot slot, Server::Impl& server, ClientId id)
      : slot_(std::move(slot)), ws_(std::move(stream)), server_(server), id_(id) {}

  void start(http::request<http::string_body> request) {
    request_ = std::move(request);
    websocket::stream_base::timeout timeout{};
    timeout.handshake_timeout = server_.options.request_time;
    timeout.idle_timeout = page_silence;
    timeout.keep_alive_pings = true;
    ws_.set_option(timeout);
    ws_.set_option(websocket::stream_base::decorator(
        [offered = offers_subprotocol(view(request_[http::field::sec_websocket_protocol]))](websocket::response_type& r) {
          r.set(http::field::server, "Ugoki");
          if (offered) r.set(http::field::sec_websocket_protocol, beast::string_view(subprotocol.data(), subprotocol.size()));
        }));
    ws_.read_message_max(server_.options.max_message_bytes);
    ws_.async_accept(request_, [self = shared_from_this()](error_code ec) {
      if (ec) return self->end();
      self->open_ = true;
      self->request_ = {};
      self->read();
      self->pump();
    });
  }

  void send(std::shared_ptr<const std::string> text) {
    waiting_bytes_ += text->size();
    texts_.push_back(std::move(text));
    if (waiting_bytes_ > server_.options.max_waiting_bytes) return end();
    pump();
  }

  void send(FrameBytes frame) {
    frame_ = std::move(frame);
    pump();
  }

  void shut() {
    error_code ignored;
    beast::get_lowest_layer(ws_).socket().shutdown(tcp::socket::shutdown_both, ignored);
    beast::get_lowest_layer(ws_).close();
  }

 private:
  void read() {
    ws_.async_read(buffer_, [self = shared_from_this()](error_code ec, std::size_t) {
      if (ec) return self->end();
      if (self->ws_.got_text() || self->server_.options.binary_messages) {
        self->hand_over();
      } else {
        self->ws_.async_close({websocket::close_code::unknown_data, "The studio reads text messages only."},
                              [self](error_code) { self->end(); });
      }
    });
  }

  void hand_over() {
    std::string message = beast::buffers_to_string(buffer_.data());
    buffer_.clear();
    auto done = [weak = weak_from_this(), server = server_.weak_from_this()] {
      const std::shared_ptr<Server::Impl> impl = server.lock();
      if (!impl) return;
      net::post(impl->io, [weak] {
        const std::shared_ptr<WebSocketClient> self = weak.lock();
        if (self && !self->ended_) self->read();
      });
    };
    if (ws_.got_text())
      server_.events.on_message(id_, std::move(message), std::move(done));
    else
      server_.events.on_bytes(id_, std::move(message), std::move(done));
  }

  void pump() {
    if (!open_ || writing_ || ended_) return;
    if (!texts_.empty()) {
      writing_ = true;
      ws_.text(true);
      ws_.async_write(net::buffer(*texts_.front()), [self = shared_from_this()](error_code ec, std::size_t) {
        if (ec) return self->end();
        self->waiting_bytes_ -= self->texts_.front()->size();
        self->texts_.pop_front();
        self->writing_ = false;
        self->pump();
      });
    } else if (frame_) {
      writing_ = true;
      ws_.binary(true);
      written_frame_ = std::move(frame_);
      frame_.reset();
      ws_.async_write(net::buffer(written_frame_->data(), written_frame_->size()), [self = shared_from_this()](error_code ec, std::size_t) {
        if (ec) return self->end();
        self->writing_ = false;
        self->pump();
      });
    }
  }

  void end() {
    if (ended_) return;
    ended_ = true;
    shut();
    server_.remove(id_);
  }

  ConnectionSlot slot_;
  websocket::stream<beast::tcp_stream> ws_;
  Server::Impl& server_;
  ClientId id_;
  http::request<http::string_body> request_;
  beast::flat_buffer buffer_;
  std::deque<std::shared_ptr<const std::string>> texts_;
  FrameBytes frame_, written_frame_;
  std::size_t waiting_bytes_ = 0;
  bool open_ = false, writing_ = false, ended_ = false;
};

}  // namespace ugoki::studio
