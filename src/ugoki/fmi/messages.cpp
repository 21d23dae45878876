#include "ugoki/fmi/messages.h"

#include <mutex>
#include <utility>

namespace ugoki::fmi {
namespace {

constexpr std::size_t max_messages = 1000;  // waiting messages; bounds the memory if nobody reads them

struct Queue {
  std::mutex mutex;
  std::vector<std::string> texts;
  std::size_t dropped = 0;
};
Queue& queue() {
  static Queue q;
  return q;
}

}  // namespace

void post_message(std::string text) {
  Queue& q = queue();
  const std::lock_guard lock(q.mutex);
  if (q.texts.size() < max_messages)
    q.texts.push_back(std::move(text));
  else
    ++q.dropped;
}

std::vector<std::string> take_messages() {
  Queue& q = queue();
  const std::lock_guard lock(q.mutex);
  std::vector<std::string> out = std::exchange(q.texts, {});
  if (const std::size_t dropped = std::exchange(q.dropped, 0))
    out.push_back("FMUs sent " + std::to_string(dropped) + " more messages, which are not shown.");
  return out;
}

}  // namespace ugoki::fmi
