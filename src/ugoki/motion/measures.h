#pragma once
// Quality measures of motions, updated frame by frame from the links' poses: sliding of standing feet, and penetration of the ground.
// No allocation after construction.

#include <cstdint>
#include <span>
#include <vector>

#include "ugoki/motion/contact_labels.h"

namespace ugoki {

/// Measures the horizontal sliding of a foot's lowest point while the foot is labelled as standing.
class FootSkate {
 public:
  /// @param links the feet, for example find_feet(mechanism)
  FootSkate(const Mechanism& mechanism, std::span<const int> links);

  /// Adds a frame.
  /// @param X_WB [links of the mechanism] poses
  /// @param on   [feet] nonzero while the foot is labelled as standing
  /// @param dt   s since the previous frame; not used in the first frame
  void add(std::span<const Pose> X_WB, std::span<const std::uint8_t> on, double dt);
  void reset();

  /// Mean over all stances of the horizontal path length [cm] of the foot's lowest point; 0 before the first stance.
  [[nodiscard]] double mean_per_stance_cm() const;
  /// Longest path [cm] of the lowest point in one stance so far.
  [[nodiscard]] double worst_stance_cm() const { return 100 * worst_; }
  /// Root mean square of the sliding speed over all stance time [m/s].
  [[nodiscard]] double rms_speed() const;
  [[nodiscard]] int stances() const { return stances_; }

  /// Internal state as an array of doubles, for saving and restoring. @param out, in [memory_size()]
  [[nodiscard]] std::size_t memory_size() const { return 5 + feet_.size() * 14; }
  void save(std::span<double> out) const;
  void restore(std::span<const double> in);

 private:
  struct Foot {
    int link = 0;
    int first = 0, count = 0;  ///< range of the foot's points in points_
    bool stood = false;        ///< true: the foot was standing in the previous frame
    double path = 0;           ///< m: path of the lowest point in the present stance
    Pose before;               ///< pose of the link in the previous frame
  };
  std::vector<Foot> feet_;
  std::vector<SupportPoint> points_;
  int stances_ = 0;
  double path_ = 0, worst_ = 0, square_ = 0, time_ = 0;
};

/// Measures the depth of colliding shapes below the ground.
class GroundPenetration {
 public:
  explicit GroundPenetration(const Mechanism& mechanism, double ground = 0);

  /// Adds a frame. @param X_WB [links] poses @return maximum depth in this frame, m
  double add(std::span<const Pose> X_WB);
  void reset();

  [[nodiscard]] double worst_mm() const { return 1000 * worst_; }
  /// Root mean square [mm] over all frames of the maximum depth in each frame.
  [[nodiscard]] double rms_mm() const;
  /// Index of the link with the maximum depth so far; -1: no link was below the ground.
  [[nodiscard]] int worst_link() const { return worst_link_; }

  /// Internal state as an array of doubles, for saving and restoring. @param out, in [memory_size()]
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
