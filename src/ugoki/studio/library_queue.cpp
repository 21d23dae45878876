#include "ugoki/studio/library_queue.h"

#include <exception>
#include <utility>

namespace ugoki::studio {
namespace {

using Clock = std::chrono::steady_clock;

}  // namespace

Error library_silent() {
  return {ErrorCode::io, "library", "The library does not respond.",
          "Check that its server runs, then try again. The open project is not affected."};
}

void LibraryQueue::post(std::function<bool()> work, std::function<void(const Error&)> refuse) {
  if (away_) return refuse(library_silent());
  queue_.post([this, run = std::move(work), decline = std::move(refuse)] {
    if (away_) return decline(library_silent());
    const Clock::time_point begun = Clock::now();
    bool done = false;
    try {
      done = run();
    } catch (const std::exception& e) {  // out of memory
      decline({ErrorCode::io, "studio", std::string("The studio could not do this: ") + e.what() + ".",
               "The project is safe. Try again, or continue working."});
    }
    if (!done && Clock::now() - begun >= min_silence) away_ = true;
  });
}

void LibraryQueue::call_poll(const std::function<bool(bool away)>& poll) {
  const Clock::time_point begun = Clock::now();
  if (poll(away_))
    away_ = false;
  else if (Clock::now() - begun >= min_silence)
    away_ = true;
}

}  // namespace ugoki::studio
