#pragma once
// Runs content for the page that the native player serves: the other side of web/src/player/remote_engine.ts.

#include <condition_variable>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <thread>

#include "ugoki/content/player.h"
#include "ugoki/studio/server.h"

namespace ugoki::player_native {

/// Handles the messages of a page. A message is a JSON text {"op": ..., "id": n}. The values of "op", with further fields:
///   hello                       answered by {"event": "scene", "scene", "devices"} and a frame
///   advance {seconds, budget}   runs `seconds` of content, within `budget` s of processor time; answered by a frame
///   step {count}, reset, push, grab, drag, release, input, schedule {inputs}, recorded, hash
/// A message with an id is answered by {"event": "done", "id", "result" or "error"}. A run that stops sends {"event": "stopped", "reason"}.
/// The player runs on a separate thread. Messages of all pages are handled in the order in which they arrive.
class PageSession final : public studio::ServerEvents {
 public:
  explicit PageSession(content::Player player);
  ~PageSession() override;

  /// Starts to answer. @param outbox must outlive the session
  void start(studio::Outbox& outbox);
  /// Ends the thread that runs the player.
  void stop();

  void on_api(studio::ApiRequest request, std::function<void(studio::ApiReply)> answer) override;
  void on_message(studio::ClientId client, std::string text, std::function<void()> done) override;
  void on_close(studio::ClientId client) override;

 private:
  struct Message {
    studio::ClientId client;
    std::string text;
    std::function<void()> done;
  };

  void run();
  void handle(const Message& message);
  void send_frame();
  void send_variables();
  void send_stopped(const Error& error);

  content::Player player_;
  content::DisplayFrame frame_;
  std::vector<double> variables_, sent_variables_;  // present values, and those that the pages have
  circuit::DeviceState held_;
  studio::Outbox* outbox_ = nullptr;
  std::mutex mutex_;
  std::condition_variable arrived_;
  std::deque<Message> messages_;  // guarded by mutex_
  bool ending_ = false;           // guarded by mutex_
  std::thread thread_;
};

}  // namespace ugoki::player_native
