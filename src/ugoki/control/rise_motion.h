#pragma once
// Reference motion from the squat at the end of the way up to standing.

#include "ugoki/control/foot_schedule.h"
#include "ugoki/control/get_up_plan.h"
#include "ugoki/motion/smooth_motion.h"

namespace ugoki::control {

class RiseMotion final : public ReferenceMotion {
 public:
  RiseMotion(MechanismPtr mechanism, const GetUpPlan& plan);
  void sample(double t, std::span<double> q, std::span<double> v, std::span<double> a) const override {
    motion_.sample(*mechanism_, t, q, v, a);
  }
  [[nodiscard]] double end() const override { return motion_.duration(); }

 private:
  MechanismPtr mechanism_;
  SmoothMotion motion_;
};

}  // namespace ugoki::control
