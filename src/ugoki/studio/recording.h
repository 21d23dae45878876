#pragma once
// The recording of simulate mode: display frames, checkpoints of the whole state, live inputs, feet on the ground, measures.

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "ugoki/spatial/vec3.h"
#include "ugoki/studio/simulation.h"

namespace ugoki::studio {

/// An input of a user during the simulation, applied before step `step`.
struct LiveInput {
  enum class Type : std::uint8_t { push, grab, drag, release, hold };
  std::int64_t step = 0;
  Type type = Type::push;
  int character = 0, link = 0;
  Vec3 a;                                            ///< push: force [N], world; grab: point [m], link frame; drag: target [m], world
  Vec3 b;                                            ///< grab: target [m], world
  double duration = 0;                               ///< push: duration of the force, s
  std::shared_ptr<const circuit::DeviceState> held;  ///< hold: state of keyboard, mouse and gamepads
};

/// A time interval with a constant number of feet on the ground.
struct ContactStretch {
  int character = 0;
  double from = 0, to = 0;  ///< begin and end of the interval, s
  int feet = 0;
};

class Recording {
 public:
  /// @param step step size, s @param frame_rate display frame rate, 1/s. Frames are recorded at the largest multiple of frame_rate up to
  /// 60 1/s, or at frame_rate itself if it is above 60 1/s
  Recording(double step, double frame_rate, int characters);

  /// Rate of recorded frames, 1/s: a multiple of the display frame rate.
  [[nodiscard]] double rate() const { return rate_; }
  /// The step after which frame n is recorded.
  [[nodiscard]] std::int64_t step_of_frame(std::size_t n) const;
  [[nodiscard]] std::int64_t next_frame_step() const { return step_of_frame(frames_.size()); }
  [[nodiscard]] std::size_t frame_count() const { return frames_.size(); }
  /// Index of the recorded frame closest to `time` [s], clamped to the recorded range. Requires at least one frame.
  [[nodiscard]] std::size_t frame_near(double time) const;
  [[nodiscard]] std::span<const std::byte> frame(std::size_t n) const { return frames_[n]; }
  /// Appends a frame. @param feet [characters] number of feet on the ground; 255: the character has none
  /// @param measures [characters] measures at the time of the frame
  void add_frame(std::span<const std::byte> frame, std::span<const std::uint8_t> feet, std::span<const MomentMeasures> measures);
  /// Measures at the time of frame `n`, for all characters.
  [[nodiscard]] std::span<const MomentMeasures> measures(std::size_t n) const {
    return std::span(measures_).subspan(n * characters_, characters_);
  }
  /// True if frames and checkpoints use more than 1 GiB.
  [[nodiscard]] bool full() const { return bytes_ > max_bytes; }

  /// True if a checkpoint is due at this step. Checkpoints are 0.5 s of simulated time apart.
  [[nodiscard]] bool checkpoint_due(std::int64_t step) const;
  /// Appends an empty checkpoint and returns its state, which the caller fills.
  std::vector<std::byte>& add_checkpoint(std::int64_t step);

  struct Checkpoint {
    std::int64_t step = 0;
    std::vector<std::byte> state;
  };
  /// The last checkpoint at or before `step`. There is always one at step 0.
  [[nodiscard]] const Checkpoint& checkpoint_before(std::int64_t step) const;

  /// Replaces all checkpoints by two: the state `first` at step 0 and the state `head` at `step`.
  void replace_checkpoints(std::vector<std::byte> first, std::int64_t step, std::vector<std::byte> head);

  void add_input(const LiveInput& input) { inputs_.push_back(input); }
  [[nodiscard]] const std::vector<LiveInput>& inputs() const { return inputs_; }
  /// Removes inputs. @param indices in ascending order
  void remove_inputs(const std::vector<std::size_t>& indices);
  /// Index of the first recorded input at or after `step`.
  [[nodiscard]] std::size_t first_input(std::int64_t step) const;

  /// Removes the frames and checkpoints after `step`, and the inputs at or after `step`.
  void truncate(std::int64_t step);

  /// Intervals with a constant number of feet on the ground, for all recorded frames; the page draws them as the contact bar.
  [[nodiscard]] std::vector<ContactStretch> contacts() const;

 private:
  static constexpr std::size_t max_bytes = std::size_t{1} << 30;
  double step_, rate_;
  std::int64_t checkpoint_steps_;
  std::size_t characters_;
  std::vector<std::vector<std::byte>> frames_;
  std::vector<std::uint8_t> feet_;        ///< number of feet on the ground: [frames][characters]
  std::vector<MomentMeasures> measures_;  ///< [frames][characters]
  std::vector<Checkpoint> checkpoints_;
  std::vector<LiveInput> inputs_;
  std::size_t bytes_ = 0;
};

}  // namespace ugoki::studio
