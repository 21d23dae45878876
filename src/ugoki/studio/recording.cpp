#include "ugoki/studio/recording.h"

#include <algorithm>
#include <cmath>

#include "ugoki/base/check.h"

namespace ugoki::studio {

namespace {
constexpr double checkpoint_seconds = 0.5;  // simulated time between checkpoints, s; seeking back recomputes at most this much
}

Recording::Recording(double step, double frame_rate, int characters)
    : step_(step),
      rate_(frame_rate * std::max(1.0, std::floor(60 / frame_rate))),
      checkpoint_steps_(std::max<std::int64_t>(1, std::llround(checkpoint_seconds / step))),
      characters_(static_cast<std::size_t>(characters)) {}

std::int64_t Recording::step_of_frame(std::size_t n) const { return std::llround(static_cast<double>(n) / (rate_ * step_)); }

std::size_t Recording::frame_near(double time) const {
  UGOKI_CHECK(!frames_.empty());
  const double n = std::round(time * rate_);
  if (!(n > 0)) return 0;
  return n < static_cast<double>(frames_.size()) ? static_cast<std::size_t>(n) : frames_.size() - 1;
}

void Recording::add_frame(std::span<const std::byte> frame, std::span<const std::uint8_t> feet, std::span<const MomentMeasures> measures) {
  UGOKI_CHECK(feet.size() == characters_ && measures.size() == characters_);
  frames_.emplace_back(frame.begin(), frame.end());
  feet_.insert(feet_.end(), feet.begin(), feet.end());
  measures_.insert(measures_.end(), measures.begin(), measures.end());
  bytes_ += frame.size();
}

bool Recording::checkpoint_due(std::int64_t step) const {
  return step % checkpoint_steps_ == 0 && (checkpoints_.empty() || checkpoints_.back().step < step);
}

std::vector<std::byte>& Recording::add_checkpoint(std::int64_t step) {
  if (!checkpoints_.empty()) bytes_ += checkpoints_.back().state.size();
  checkpoints_.push_back({step, {}});
  return checkpoints_.back().state;
}

void Recording::replace_checkpoints(std::vector<std::byte> first, std::int64_t step, std::vector<std::byte> head) {
  for (std::size_t i = 0; i + 1 < checkpoints_.size(); ++i) bytes_ -= checkpoints_[i].state.size();
  checkpoints_.clear();
  checkpoints_.push_back({0, std::move(first)});
  if (step == 0) return;
  bytes_ += checkpoints_.back().state.size();
  checkpoints_.push_back({step, std::move(head)});
}

const Recording::Checkpoint& Recording::checkpoint_before(std::int64_t step) const {
  const auto after = std::ranges::upper_bound(checkpoints_, step, {}, &Checkpoint::step);
  UGOKI_CHECK(after != checkpoints_.begin());
  return *(after - 1);
}

void Recording::remove_inputs(const std::vector<std::size_t>& indices) {
  for (auto i = indices.rbegin(); i != indices.rend(); ++i) inputs_.erase(inputs_.begin() + static_cast<std::ptrdiff_t>(*i));
}

std::size_t Recording::first_input(std::int64_t step) const {
  return static_cast<std::size_t>(std::ranges::lower_bound(inputs_, step, {}, &LiveInput::step) - inputs_.begin());
}

void Recording::truncate(std::int64_t step) {
  while (!frames_.empty() && step_of_frame(frames_.size() - 1) > step) {
    bytes_ -= frames_.back().size();
    frames_.pop_back();
  }
  feet_.resize(frames_.size() * characters_);
  measures_.resize(frames_.size() * characters_);
  while (!checkpoints_.empty() && checkpoints_.back().step > step) {
    checkpoints_.pop_back();
    if (!checkpoints_.empty()) bytes_ -= checkpoints_.back().state.size();
  }
  inputs_.resize(first_input(step));
}

std::vector<ContactStretch> Recording::contacts() const {
  std::vector<ContactStretch> out;
  for (std::size_t c = 0; c < characters_; ++c) {
    const std::size_t begin = out.size();
    for (std::size_t n = 0; n < frames_.size(); ++n) {
      const std::uint8_t feet = feet_[n * characters_ + c];
      if (feet == 255) continue;
      const double from = static_cast<double>(n) / rate_, to = static_cast<double>(n + 1) / rate_;
      if (out.size() > begin && out.back().feet == feet) {
        out.back().to = to;
      } else {
        out.push_back({static_cast<int>(c), from, to, feet});
      }
    }
  }
  return out;
}

}  // namespace ugoki::studio
