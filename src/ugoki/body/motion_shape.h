#pragma once
// Shape of a skeleton, measured from its motion: positions of joints in sampled frames, and lengths that do not depend on the rest pose.
// Internal to body.

#include <vector>

#include "ugoki/motion/skeleton.h"

namespace ugoki::body {

/// Sampled world poses and lengths of a motion.
class MotionShape {
 public:
  /// Samples at most `max_frames` frames, evenly spread.
  explicit MotionShape(const MeasuredMotion& motion, int max_frames = 240);

  [[nodiscard]] int frames() const { return static_cast<int>(X_.size()); }
  /// Pose of joint `i` in sampled frame `f`, world.
  [[nodiscard]] const Pose& pose(int f, int i) const { return X_[static_cast<std::size_t>(f)][static_cast<std::size_t>(i)]; }
  [[nodiscard]] const Vec3& p(int f, int i) const { return pose(f, i).p; }
  /// Farthest end site of joint `i` in sampled frame `f` (the joint itself without end sites), world, m.
  [[nodiscard]] Vec3 tip(int f, int i) const;
  [[nodiscard]] const std::vector<int>& children(int i) const { return children_[static_cast<std::size_t>(i)]; }
  /// Median distance [m] of joint `i` from its parent; 0 for roots.
  [[nodiscard]] double bone_length(int i) const { return length_[static_cast<std::size_t>(i)]; }
  /// True if joint `i` moves far relative to its parent, so that no bone connects them (a character in a scene). Roots are free.
  [[nodiscard]] bool is_free(int i) const { return free_[static_cast<std::size_t>(i)] != 0; }

  /// Mean and standard deviation [m] of the distance of two joints over the frames.
  struct Distance {
    double mean = 0, spread = 0;
  };
  [[nodiscard]] Distance distance(int i, int j) const;

 private:
  const MeasuredMotion& m_;
  std::vector<std::vector<Pose>> X_;
  std::vector<std::vector<int>> children_;
  std::vector<double> length_;
  std::vector<char> free_;
};

}  // namespace ugoki::body
