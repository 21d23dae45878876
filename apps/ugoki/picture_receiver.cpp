#include "picture_receiver.h"

#include <chrono>
#include <optional>
#include <utility>
#include <vector>

#include "packed_picture.h"
#include "ugoki/base/number.h"
#include "ugoki/studio/security.h"

namespace ugoki::cli {

PictureReceiver::PictureReceiver(HostedPlayer hosted, json::Json settings, std::string converter, int pages, std::size_t raw_size,
                                 std::size_t packed_row)
    : settings_(std::move(settings)),
      converter_(std::move(converter)),
      pages_(pages),
      raw_size_(raw_size),
      packed_row_(packed_row),
      run_(std::move(hosted), pages, [this](std::string failure) { set_failure(std::move(failure)); }) {}

void PictureReceiver::answer_by(studio::Outbox& outbox) {
  outbox_ = &outbox;
  run_.start(outbox);
}

void PictureReceiver::on_api(studio::ApiRequest request, std::function<void(studio::ApiReply)> answer) {
  if (request.path == "/api/pictures") {
    json::Json settings = settings_;
    settings["first"] = next_page_++ % pages_;
    settings["stride"] = pages_;
    return answer({200, json::to_text(settings)});
  }
  if (request.path == "/api/converter") return answer({200, converter_, "application/wasm"});
  if (request.path == "/api/picture") {
    const std::optional<long> number = parse_long(studio::query_value(request.query, "number").value_or(""));
    if (!number) return answer({400, "{}"});
    {
      const std::lock_guard lock(mutex_);
      arrived_[static_cast<int>(*number)].png = std::move(request.body);
      answers_.emplace(static_cast<int>(*number), std::move(answer));
    }
    return changed_.notify_all();
  }
  if (request.path == "/api/failed") {
    set_failure(request.body.substr(0, 2000));
    return answer({200, "{}"});
  }
  answer({404, "{}"});
}

void PictureReceiver::on_message(studio::ClientId client, std::string text, std::function<void()> done) {
  constexpr std::string_view frame = "frame ";
  if (text.starts_with(frame)) {
    if (const std::optional<long> step = parse_long(text.substr(frame.size())); step && *step >= 0)
      run_.request(client, static_cast<std::uint64_t>(*step));
  } else if (const std::size_t space = text.find(' '); space != std::string::npos) {
    const std::optional<long> number = parse_long(text.substr(0, space)), size = parse_long(text.substr(space + 1));
    const std::size_t largest = raw_size_ + raw_size_ / 100'000 + 16;  // of ugoki_pack()
    if (!number || !size || *size <= 0 || static_cast<std::size_t>(*size) > largest) {
      set_failure("The page has sent a picture of another size.");
    } else {
      const std::lock_guard lock(mutex_);
      Pixels& pixels = arriving_[client] = {static_cast<int>(*number), static_cast<std::size_t>(*size), {}};
      pixels.bytes.reserve(pixels.size);
    }
  }
  done();
}

void PictureReceiver::on_bytes(studio::ClientId client, std::string bytes, std::function<void()> done) {
  {
    const std::lock_guard lock(mutex_);
    Pixels& pixels = arriving_[client];
    pixels.bytes += bytes;
    if (pixels.bytes.size() >= pixels.size) {
      std::string raw = packed_row_ > 0 ? unpacked_picture(pixels.bytes, packed_row_, raw_size_) : std::move(pixels.bytes);
      if (raw.size() != raw_size_) failure_ = "The page has sent a picture of another size.";
      arrived_[pixels.number].raw = std::move(raw);
      senders_[pixels.number] = client;
      arriving_.erase(client);
    }
  }
  changed_.notify_all();
  done();
}

bool PictureReceiver::wait(int number, bool png, bool raw, double seconds, Picture& out) {
  std::unique_lock lock(mutex_);
  const auto complete = [&] {
    const auto found = arrived_.find(number);
    return !failure_.empty() || (found != arrived_.end() && (!png || !found->second.png.empty()) && (!raw || !found->second.raw.empty()));
  };
  if (!changed_.wait_for(lock, std::chrono::duration<double>(seconds), complete) || !failure_.empty()) return false;
  out = std::move(arrived_[number]);
  arrived_.erase(number);
  return true;
}

void PictureReceiver::done(int number) {
  std::vector<std::function<void(studio::ApiReply)>> answers;
  std::optional<studio::ClientId> sender;
  {
    const std::lock_guard lock(mutex_);
    if (const auto found = senders_.find(number); found != senders_.end()) {
      sender = found->second;
      senders_.erase(found);
    }
    const auto [begin, end] = answers_.equal_range(number);
    for (auto i = begin; i != end; ++i) answers.push_back(std::move(i->second));
    answers_.erase(begin, end);
  }
  for (const auto& answer : answers) answer({200, "{}"});
  if (sender) outbox_->send(*sender, std::to_string(number));
}

std::string PictureReceiver::failure() {
  const std::lock_guard lock(mutex_);
  return failure_;
}

void PictureReceiver::set_failure(std::string failure) {
  {
    const std::lock_guard lock(mutex_);
    failure_ = std::move(failure);
  }
  changed_.notify_all();
}

}  // namespace ugoki::cli
