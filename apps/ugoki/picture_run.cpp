#include "picture_run.h"

#include <cmath>
#include <memory>
#include <vector>

#include "ugoki/content/display_frame.h"

namespace ugoki::cli {

PictureRun::PictureRun(HostedPlayer hosted, int pages, std::function<void(std::string)> failed)
    : hosted_(std::move(hosted)), pages_(pages), failed_(std::move(failed)) {}

PictureRun::~PictureRun() {
  {
    const std::lock_guard lock(mutex_);
    ending_ = true;
  }
  changed_.notify_all();
  if (thread_.joinable()) thread_.join();
}

void PictureRun::start(studio::Outbox& outbox) {
  outbox_ = &outbox;
  thread_ = std::thread([this] { run(); });
}

void PictureRun::request(studio::ClientId page, std::uint64_t step) {
  {
    const std::lock_guard lock(mutex_);
    requests_.push_back({page, step});
  }
  changed_.notify_all();
}

void PictureRun::run() {
  for (;;) {
    Request request;
    {
      std::unique_lock lock(mutex_);
      changed_.wait(lock, [&] { return ending_ || !requests_.empty(); });
      if (ending_) return;
      request = requests_.front();
      requests_.pop_front();
    }
    Result<studio::FrameBytes> frame = frame_at(request.step);
    if (!frame) return failed_(frame.error().text());
    outbox_->send_frame(request.page, std::move(*frame));
  }
}

Result<studio::FrameBytes> PictureRun::frame_at(std::uint64_t step) {
  content::Player& player = hosted_.player;
  auto found = frames_.find(step);
  if (found == frames_.end()) {
    if (step < player.step_count())
      return fail(ErrorCode::range, "pictures", "A page has requested a frame that is over.", "Start the export again.");
    while (player.step_count() < step) {
      {
        const std::lock_guard lock(mutex_);
        if (ending_) return fail(ErrorCode::conflict, "pictures", "The export was cancelled.", "Start the export again.");
      }
      if (Result<void> good = player.step(); !good) return fail(std::move(good.error()));
    }
    content::DisplayFrame frame;
    player.display_frame(frame);
    auto bytes = std::make_shared<std::vector<std::byte>>();
    const auto number = static_cast<std::uint32_t>(std::llround(player.time() * player.content().frame_rate));
    content::encode_frame(frame, number, content::frame_simulate, *bytes);
    found = frames_.emplace(step, Kept{std::move(bytes), 0}).first;
  }
  studio::FrameBytes bytes = found->second.bytes;
  if (++found->second.answered == pages_) frames_.erase(found);
  return bytes;
}

}  // namespace ugoki::cli
