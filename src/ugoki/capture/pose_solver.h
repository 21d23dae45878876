#pragma once
// The pose that brings a subject's markers to where they were measured. Internal to capture.

#include <span>
#include <vector>

#include "ugoki/capture/model.h"

namespace ugoki::capture {

/// What was measured in one frame: places of the used markers, and which were seen.
struct MeasuredFrame {
  std::vector<Vec3> places;  ///< [used] m
  std::vector<char> seen;    ///< [used]
  int count = 0;             ///< of the seen ones
};
[[nodiscard]] MeasuredFrame measured_frame(const MarkerMotion& motion, const Subject& subject, int frame);

struct PoseOptions {
  double marker_sigma = 0.01;       ///< m: noise of a marker on moving skin
  double outlier = 0.05;            ///< m: beyond this a marker pulls with a constant force (Huber's loss)
  double step_sigma = 0;            ///< rad | dm: how far freedoms usually move from `near`; 0: they are free
  const ModelPose* near = nullptr;  ///< the frame before
  int max_iterations = 30;
};

/// Weight [1/m^2] with which a marker at this distance from its place enters the normal equations.
[[nodiscard]] double marker_weight(const PoseOptions& options, double noise, double distance);

/// Least squares of marker errors, departure from rest by the joints' stiffness, and departure from `near`, by
/// Levenberg-Marquardt; joint limits by projection.
class PoseSolver {
 public:
  /// @param pose start and result
  /// @return the cost, 1/2 sum of squares in units of the sigmas
  double solve(const Subject& subject, const MeasuredFrame& frame, const PoseOptions& options, ModelPose& pose);

  /// Normal equations at the last solution: H [freedoms^2] (lower triangle valid) without damping.
  [[nodiscard]] std::span<const double> normal_matrix() const { return H_; }
  [[nodiscard]] const Kinematics& kinematics() const { return k_; }
  /// Column of the Jacobian of used marker m for freedom f at the last solution; zero for freedoms it does not hang on.
  [[nodiscard]] Vec3 jacobian(const Subject& subject, std::size_t used, std::size_t freedom) const;

 private:
  double cost(const Subject& subject, const MeasuredFrame& frame, const PoseOptions& options, const ModelPose& pose);
  void linearize(const Subject& subject, const MeasuredFrame& frame, const PoseOptions& options, const ModelPose& pose);

  Kinematics k_;
  std::vector<double> H_, g_, L_, step_;
  std::vector<int> chain_;
};

}  // namespace ugoki::capture
