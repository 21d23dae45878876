#pragma once
// Reference motion of a character that has got up: from the squat at the end of the way up to standing, and on into its track.

#include <memory>
#include <span>

#include "ugoki/control/foot_schedule.h"
#include "ugoki/control/get_up_plan.h"
#include "ugoki/motion/clip.h"
#include "ugoki/motion/smooth_motion.h"

namespace ugoki::control {

/// The times are those of the track:
///   begin() ... stands()   the character stands up from the squat
///   stands() ... joins()   it begins to move: posture, speed and turning of the track grow from nothing to their full measure
///   after joins()          the track itself
/// The placement of the motion is that of the track at joins(). Balance control moves it to the place of the character.
class ReturnMotion final : public ReferenceMotion {
 public:
  /// @param track kept @param time s: time of the track at which the character fell; the motion joins the track later
  /// @param floor m: height of the floor of the track
  ReturnMotion(MechanismPtr mechanism, std::shared_ptr<const ReferenceMotion> track, const GetUpPlan& plan, double time, double floor);

  void sample(double t, std::span<double> q, std::span<double> v, std::span<double> a) const override;
  [[nodiscard]] double end() const override;
  [[nodiscard]] bool contacts(double t, std::span<std::uint8_t> on) const override { return t >= joins_ && track_->contacts(t, on); }
  /// Displacement that puts the motion at begin() to the place and the heading of a character: the middle of its soles.
  /// @param q [nq] the character @param feet its feet (feet_of)
  [[nodiscard]] Placement placement_at(std::span<const double> q, std::span<const Foot> feet) const;
  [[nodiscard]] double begin() const { return begin_; }    ///< s
  [[nodiscard]] double stands() const { return stands_; }  ///< s
  [[nodiscard]] double joins() const { return joins_; }    ///< s

 private:
  MechanismPtr mechanism_;
  std::shared_ptr<const ReferenceMotion> track_;
  double begin_ = 0, stands_ = 0, joins_ = 0;
  std::unique_ptr<SmoothMotion> rise_, start_;
};

}  // namespace ugoki::control
