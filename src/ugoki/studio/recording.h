#pragma once
// What simulate mode remembers: display frames, checkpoints of the whole state, live inputs, feet on the ground.

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "ugoki/spatial/vec3.h"
#include "ugoki/studio/simulation.h"

namespace ugoki::studio {

/// Something that a user did while it ran, before step `step`.
struct LiveInput {
  enum class Type : std::uint8_t { push, grab, drag, release, hold };
  std::int64_t step = 0;
  Type type = Type::push;
  int character = 0, link = 0;
  Vec3 a;                                            ///< force (push), point in the link's frame (grab), target (drag)
  Vec3 b;                                            ///< target (grab)
  double duration = 0;                               ///< s (push)
  std::shared_ptr<const circuit::DeviceState> held;  ///< keyboard, mouse and gamepads (hold)
};

/// A stretch of time with the same number of feet on the ground.
struct ContactStretch {
  int character = 0;
  double from = 0, to = 0;  ///< s
  int feet = 0;
};

class Recording {
 public:
  /// @param step s @param frame_rate display frames a second; frames are kept at the multiple of it nearest to 60 a second
  Recording(double step, double frame_rate, int characters);

  /// Frames a second that are kept: a multiple of the display frame rate.
  [[nodiscard]] double rate() const { return rate_; }
  /// The step whose state is frame n.
  [[nodiscard]] std::int64_t step_of_frame(std::size_t n) const;
  [[nodiscard]] std::int64_t next_frame_step() const { return step_of_frame(frames_.size()); }
  [[nodiscard]] std::size_t frame_count() const { return frames_.size(); }
  /// The kept frame nearest to `time`, clamped to what there is; there is at least one.
  [[nodiscard]] std::size_t frame_near(double time) const;
  [[nodiscard]] std::span<const std::byte> frame(std::size_t n) const { return frames_[n]; }
  /// @param feet [characters]
  void add_frame(std::span<const std::byte> frame, std::span<const std::uint8_t> feet);
  [[nodiscard]] bool full() const { return bytes_ > max_bytes; }

  [[nodiscard]] bool checkpoint_due(std::int64_t step) const;
  std::vector<std::byte>& add_checkpoint(std::int64_t step);

  struct Checkpoint {
    std::int64_t step = 0;
    std::vector<std::byte> state;
  };
  /// The newest checkpoint at or before `step`; there is one at 0.
  [[nodiscard]] const Checkpoint& checkpoint_before(std::int64_t step) const;

  /// Forgets all checkpoints but these: the first state, and the one after `step` steps.
  void replace_checkpoints(std::vector<std::byte> first, std::int64_t step, std::vector<std::byte> head);

  void add_input(const LiveInput& input) { inputs_.push_back(input); }
  [[nodiscard]] const std::vector<LiveInput>& inputs() const { return inputs_; }
  /// Index of the first input at or after `step`.
  [[nodiscard]] std::size_t first_input(std::int64_t step) const;

  /// Forgets frames and checkpoints after `step`, and inputs at or after it.
  void truncate(std::int64_t step);

  /// The contact bar so far.
  [[nodiscard]] std::vector<ContactStretch> contacts() const;

 private:
  static constexpr std::size_t max_bytes = std::size_t{1} << 30;
  double step_, rate_;
  std::int64_t checkpoint_steps_;
  std::size_t characters_;
  std::vector<std::vector<std::byte>> frames_;
  std::vector<std::uint8_t> feet_;  ///< [frames][characters]
  std::vector<Checkpoint> checkpoints_;
  std::vector<LiveInput> inputs_;
  std::size_t bytes_ = 0;
};

}  // namespace ugoki::studio
