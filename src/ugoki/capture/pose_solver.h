#pragma once
// Finds the pose in which a subject's markers are closest to their measured positions. Internal to capture.

#include <span>
#include <vector>

#include "ugoki/capture/model.h"

namespace ugoki::capture {

/// Measured positions of the used markers in one frame.
struct MeasuredFrame {
  std::vector<Vec3> positions;  ///< [used markers] m
  std::vector<char> seen;       ///< [used markers] 1: seen
  int count = 0;                ///< number of seen markers
};
/// Returns the measured positions of the subject's markers in one frame of a recording.
[[nodiscard]] MeasuredFrame measured_frame(const MarkerMotion& motion, const Subject& subject, int frame);

/// Weights of PoseSolver::solve.
struct PoseOptions {
  double marker_sigma = 0.01;       ///< m, standard deviation of a marker on moving skin
  double outlier = 0.05;            ///< m, Huber limit: the cost of larger errors is linear
  double step_sigma = 0;            ///< rad, standard deviation of joint rotations from `near`; 0: no such prior
  const ModelPose* near = nullptr;  ///< pose of the neighbouring frame; null: none
  int max_iterations = 30;
};

/// Weight [1/m^2] of a marker in the normal equations. @param noise ModelMarker::noise @param distance m, marker to its measured position
[[nodiscard]] double marker_weight(const PoseOptions& options, double noise, double distance);

/// Minimises marker errors, deviation from rest (weighted by stiffness_sigma) and deviation from `near` by the Levenberg-Marquardt method.
/// Joint limits are kept by projection.
class PoseSolver {
 public:
  /// @param pose [in and out] initial pose and solution
  /// @return the cost: half the sum of squared deviations, each divided by its standard deviation (Huber loss for markers)
  double solve(const Subject& subject, const MeasuredFrame& frame, const PoseOptions& options, ModelPose& pose);

  /// Matrix of the normal equations at the last solution, [DOFs][DOFs], without damping. Only its lower triangle is valid.
  [[nodiscard]] std::span<const double> normal_matrix() const { return H_; }
  [[nodiscard]] const Kinematics& kinematics() const { return k_; }
  /// Derivative (m per m or rad) of the used marker's world position with respect to a DOF at the last solution; zero without effect and
  /// for angles that their limits hold.
  [[nodiscard]] Vec3 jacobian(const Subject& subject, std::size_t used, std::size_t dof) const;

  /// Number of iterations of all calls of solve() so far.
  [[nodiscard]] std::size_t iterations() const { return iterations_; }

 private:
  double cost(const Subject& subject, const MeasuredFrame& frame, const PoseOptions& options, const ModelPose& pose);
  void linearize(const Subject& subject, const MeasuredFrame& frame, const PoseOptions& options, const ModelPose& pose);

  /// Removes the DOFs at a limit that the gradient pushes further out from the normal equations.
  void pin_angles_at_limits(const Subject& subject, const ModelPose& pose);

  Kinematics k_;
  std::vector<char> pinned_;  // [DOFs] 1: at a limit
  std::vector<double> H_, g_, L_, step_;
  std::vector<int> chain_;
  std::size_t iterations_ = 0;
};

}  // namespace ugoki::capture
