#pragma once
// Slip of standing feet: the distance that a foot slides over the ground in one stance.

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "ugoki/motion/contact_labels.h"

namespace ugoki {

/// Measures the net slip of each stance, updated frame by frame from the links' poses. In each frame the lowest material point of the foot
/// is displaced since the previous frame; the slip of a stance is the horizontal length of the sum of these displacements. A foot that
/// rolls from heel to toe has no slip, because its lowest point rests. The noise of a capture cancels out, because displacements are added
/// as vectors; a path length would instead grow with noise and frame rate. The first and the last 0.06 s of a stance do not count, because
/// contact labels are only that accurate, and a foot moves at up to 0.6 m/s there. The toes belong to their foot. No allocation after
/// construction.
class FootSlip {
 public:
  /// @param links the feet, for example find_feet(mechanism)
  FootSlip(const Mechanism& mechanism, std::span<const int> links);

  /// Adds a frame.
  /// @param X_WB [links of the mechanism] poses
  /// @param on   [links of the constructor] nonzero while the link is labelled as standing
  /// @param dt   s since the previous frame; not used in the first frame
  void add(std::span<const Pose> X_WB, std::span<const std::uint8_t> on, double dt);
  void reset();

  [[nodiscard]] int stances() const { return stances_; }           ///< number of ended stances of more than 0.12 s
  [[nodiscard]] double mean_cm() const;                            ///< mean slip of a stance, cm; includes stances that have not ended
  [[nodiscard]] double worst_cm() const;                           ///< maximum slip of a stance, cm; includes stances that have not ended
  [[nodiscard]] double now_cm() const;                             ///< maximum slip of the present stances, cm; 0 if no foot stands
  [[nodiscard]] double worst_time() const { return worst_time_; }  ///< s after the first frame: end of the stance with the maximum slip

  /// Internal state as an array of doubles, for saving and restoring. @param out, in [memory_size()]
  [[nodiscard]] std::size_t memory_size() const { return 5 + feet_.size() * (6 + 3 * recent) + links_.size() * 12; }
  void save(std::span<double> out) const;
  void restore(std::span<const double> in);

 private:
  static constexpr int recent = 32;  ///< maximum number of stored displacements; each is stored until it is 0.06 s old
  struct Foot {
    int first = 0, count = 0;  ///< range of the foot's points in points_
    bool stood = false;
    double age = 0;  ///< s: duration of the present stance
    Vec3 slide;      ///< m: sum of the displacements, without those in the margins of the stance
    int head = 0, held = 0;
    std::array<Vec3, recent> steps;  ///< m, m, s: ring buffer of the last displacements (x, y) and their durations (z)
  };
  struct Point {
    int slot;  ///< index in links_
    SupportPoint at;
  };
  void finish(Foot& foot);

  std::vector<int> links_, foot_of_;
  std::vector<Pose> before_;  ///< [links_] poses in the previous frame
  std::vector<Foot> feet_;
  std::vector<Point> points_;
  int stances_ = 0;
  double sum_ = 0, worst_ = 0, time_ = 0, worst_time_ = 0;
};

}  // namespace ugoki
