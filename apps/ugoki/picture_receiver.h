#pragma once
// Receives the pictures that pages draw.

#include <atomic>
#include <condition_variable>
#include <functional>
#include <map>
#include <mutex>
#include <string>

#include "picture_run.h"
#include "ugoki/json/json.h"
#include "ugoki/studio/server.h"

namespace ugoki::cli {

/// Answers the pages that draw. A page requests frames ("frame N": the frame after N steps) and sends pictures: PNG files as requests, and
/// pixels for videos as WebSocket messages. (A browser copies the body of each request into memory that is new each time.)
class PictureReceiver final : public studio::ServerEvents {
 public:
  struct Picture {
    std::string png, raw;
  };

  /// @param settings of all pages, JSON @param pages number of pages; page k draws the pictures k, k + pages, k + 2 pages ...
  /// @param raw_size number of bytes of the pixels of a picture
  /// @param packed_row number of bytes of a row if pages pack the pixels (packed_picture.h); 0: they do not
  /// @param converter bytes of ugoki_planar.wasm
  PictureReceiver(HostedPlayer hosted, json::Json settings, std::string converter, int pages, std::size_t raw_size, std::size_t packed_row);

  /// Sets where pages receive answers, and starts the run; to be called before a page connects. @param outbox must outlive the receiver
  void answer_by(studio::Outbox& outbox);

  void on_api(studio::ApiRequest request, std::function<void(studio::ApiReply)> answer) override;
  /// The request of a frame, or number and number of bytes of the picture whose pixels follow as binary messages.
  void on_message(studio::ClientId client, std::string text, std::function<void()> done) override;
  void on_bytes(studio::ClientId client, std::string bytes, std::function<void()> done) override;
  void on_close(studio::ClientId) override {}

  /// Waits for the picture `number` for at most `seconds`. @return whether it has arrived with all wanted forms
  bool wait(int number, bool png, bool raw, double seconds, Picture& out);
  /// Answers the page's requests with this picture, so that the page sends further pictures.
  void done(int number);
  /// Text of the error that has ended the drawing; empty: none.
  std::string failure();

 private:
  struct Pixels {
    int number = -1;
    std::size_t size = 0;  ///< bytes, when all have arrived
    std::string bytes;
  };

  void set_failure(std::string failure);

  const json::Json settings_;
  const std::string converter_;
  const int pages_;
  const std::size_t raw_size_, packed_row_;
  studio::Outbox* outbox_ = nullptr;
  std::atomic<int> next_page_ = 0;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::map<studio::ClientId, Pixels> arriving_;  // pictures of which a part has arrived
  std::map<int, Picture> arrived_;
  std::map<int, studio::ClientId> senders_;  // of pixels that have arrived
  std::multimap<int, std::function<void(studio::ApiReply)>> answers_;
  std::string failure_;
  PictureRun run_;  // last, because it calls set_failure()
};

}  // namespace ugoki::cli
