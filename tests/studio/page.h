#pragma once
// A page of the studio, for tests: a WebSocket client that sends requests and collects replies, events and frames.

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <vector>

#include "client.h"
#include "fake_simulation.h"

namespace ugoki::studio::test {

class Page {
 public:
  Page(std::uint16_t port, const std::string& token) : Page(port, token, 101) {}
  /// @param status expected status of the handshake; 0: any
  Page(std::uint16_t port, const std::string& token, int status) : socket_(port, "/ws", {"Authorization: Bearer " + token}) {
    if (status != 0) EXPECT_EQ(socket_.status(), status);
    socket_.on_frame = [this](const std::string& bytes) {
      frames.push_back(parse_frame(std::as_bytes(std::span(bytes.data(), bytes.size()))));
      EXPECT_TRUE(frames.back().good);
    };
    socket_.on_text = [this](const std::string& text) {
      nlohmann::json message = nlohmann::json::parse(text);
      if (message.contains("event")) events.push_back(std::move(message));
    };
  }
  /// True if the handshake succeeded.
  [[nodiscard]] bool open() const { return socket_.status() == 101; }
  /// Sends a request and waits for its reply. Events and frames that arrive before the reply are kept in `events` and `frames`.
  nlohmann::json ask(nlohmann::json message) { return reply(post(std::move(message))); }
  /// Sends a request. @return its id
  int post(nlohmann::json message) {
    message["id"] = ++last_;
    socket_.send_text(message.dump());
    return last_;
  }
  /// Waits for the reply to the request `id`; null if none arrives.
  nlohmann::json reply(const nlohmann::json& id) {
    const auto text = socket_.receive_text([&](const std::string& t) {
      const nlohmann::json j = nlohmann::json::parse(t);
      return j.contains("reply") && j["reply"] == id;
    });
    return text ? nlohmann::json::parse(*text) : nlohmann::json();
  }
  /// Waits for the next event `name` for which `fits` is true; null if none arrives. Events received earlier are not considered.
  nlohmann::json event(
      const std::string& name, const std::function<bool(const nlohmann::json&)>& fits = [](const nlohmann::json&) { return true; }) {
    const auto text = socket_.receive_text([&](const std::string& t) {
      const nlohmann::json j = nlohmann::json::parse(t);
      return j.contains("event") && j["event"] == name && fits(j);
    });
    return text ? nlohmann::json::parse(*text) : nlohmann::json();
  }
  /// Reads until `fits` is true for one of the frames received since the last frames.clear().
  bool frame(const std::function<bool(const Frame&)>& fits) {
    for (int i = 0; i < 10'000; ++i) {
      if (std::ranges::any_of(frames, fits)) return true;
      const auto message = socket_.receive(20);
      if (!message) return false;
      if (message->opcode == 2) socket_.on_frame(message->data);
      if (message->opcode == 1) socket_.on_text(message->data);
    }
    return false;
  }
  WebSocket& socket() { return socket_; }

  std::vector<Frame> frames;
  std::vector<nlohmann::json> events;

 private:
  WebSocket socket_;
  int last_ = 0;
};

}  // namespace ugoki::studio::test
