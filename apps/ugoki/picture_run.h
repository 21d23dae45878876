#pragma once
// Runs the content for the pages that draw its pictures.

#include <condition_variable>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <mutex>
#include <string>
#include <thread>

#include "simulate.h"
#include "ugoki/studio/outbox.h"

namespace ugoki::cli {

/// Sends frames to pages. The pages request the same steps, each in ascending order, so each frame is computed once. The player runs on a
/// thread of its own.
class PictureRun {
 public:
  /// @param pages number of pages @param failed called with the text of the error if the run stops, from the player's thread
  PictureRun(HostedPlayer hosted, int pages, std::function<void(std::string)> failed);
  ~PictureRun();
  PictureRun(const PictureRun&) = delete;
  PictureRun& operator=(const PictureRun&) = delete;

  /// Starts to answer. @param outbox must outlive the run
  void start(studio::Outbox& outbox);
  /// Requests the frame after `step` steps. The page receives it as content::encode_frame() writes it. Does not block.
  void request(studio::ClientId page, std::uint64_t step);

 private:
  struct Request {
    studio::ClientId page = 0;
    std::uint64_t step = 0;
  };
  struct Kept {
    studio::FrameBytes bytes;
    int answered = 0;  ///< number of pages that have received it
  };

  void run();
  [[nodiscard]] Result<studio::FrameBytes> frame_at(std::uint64_t step);

  HostedPlayer hosted_;
  const int pages_;
  const std::function<void(std::string)> failed_;
  studio::Outbox* outbox_ = nullptr;
  std::map<std::uint64_t, Kept> frames_;  // by step: frames that not all pages have received
  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<Request> requests_;  // guarded by mutex_
  bool ending_ = false;           // guarded by mutex_
  std::thread thread_;
};

}  // namespace ugoki::cli
