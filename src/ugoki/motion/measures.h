#pragma once
// Measures of naturalness, fed frame by frame with the links' poses: how far standing feet slide, how deep shapes sink
// into the ground. Nothing is allocated after construction.

#include <cstdint>
#include <span>
#include <vector>

#include "ugoki/motion/contact_labels.h"

namespace ugoki {

/// Horizontal sliding of the place that bears on the ground while a foot is labelled as standing.
class FootSkate {
 public:
  /// @param links the feet, for example find_feet(mechanism)
  FootSkate(const Mechanism& mechanism, std::span<const int> links);

  /// One more frame.
  /// @param X_WB [links of the mechanism] poses
  /// @param on   [feet] not 0 while the foot is meant to stand
  /// @param dt   s since the frame before; the first frame's is not used
  void add(std::span<const Pose> X_WB, std::span<const std::uint8_t> on, double dt);
  void reset();

  /// Mean horizontal path of the lowest sole point in one stance of one foot [cm]; 0 before any stance.
  [[nodiscard]] double mean_per_stance_cm() const;
  /// The worst stance so far. cm
  [[nodiscard]] double worst_stance_cm() const { return 100 * worst_; }
  /// Root mean square of the sliding speed over all stance time [m/s].
  [[nodiscard]] double rms_speed() const;
  [[nodiscard]] int stances() const { return stances_; }

  /// What it remembers, as numbers, for saving and restoring. @param out, in [memory_size()]
  [[nodiscard]] std::size_t memory_size() const { return 5 + feet_.size() * 14; }
  void save(std::span<double> out) const;
  void restore(std::span<const double> in);

 private:
  struct Foot {
    int link = 0;
    int first = 0, count = 0;  ///< its points in points_
    bool stood = false;
    double path = 0;  ///< m, in this stance
    Pose before;
  };
  std::vector<Foot> feet_;
  std::vector<SupportPoint> points_;
  int stances_ = 0;
  double path_ = 0, worst_ = 0, square_ = 0, time_ = 0;
};

/// Depth of colliding shapes below the ground.
class GroundPenetration {
 public:
  explicit GroundPenetration(const Mechanism& mechanism, double ground = 0);

  /// One more frame. @param X_WB [links]
  void add(std::span<const Pose> X_WB);
  void reset();

  [[nodiscard]] double worst_mm() const { return 1000 * worst_; }
  /// Root mean square over the frames of each frame's greatest depth.
  [[nodiscard]] double rms_mm() const;
  /// Link that was deepest, or -1.
  [[nodiscard]] int worst_link() const { return worst_link_; }

  /// What it remembers, as numbers, for saving and restoring. @param out, in [memory_size()]
  [[nodiscard]] std::size_t memory_size() const { return 4; }
  void save(std::span<double> out) const;
  void restore(std::span<const double> in);

 private:
  struct Point {
    int link;
    SupportPoint at;
  };
  std::vector<Point> points_;
  double ground_ = 0, worst_ = 0, square_ = 0;
  int frames_ = 0, worst_link_ = -1;
};

}  // namespace ugoki
