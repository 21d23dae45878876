#pragma once
// Calibration: finds segment lengths of a subject and positions of the markers on its segments from a recording. Internal to capture.

#include <cstddef>
#include <functional>
#include <utility>
#include <vector>

#include "ugoki/capture/pose_solver.h"

namespace ugoki::capture {

/// Pairs of columns whose distance contains information about the subject's size: both markers are on landmarks (not in clusters) of the
/// same segment or of adjacent segments. @param match [columns] index of the marker in the set, or -1
[[nodiscard]] std::vector<std::pair<std::size_t, std::size_t>> pairs_for_size(const MarkerSet& set, const std::vector<int>& match);

/// Size of the subject relative to the model: the median, over pairs_for_size(), of the ratio of measured distance to model distance. 0 if
/// no such pair was ever seen together.
[[nodiscard]] double estimate_size(const MarkerSet& set, const std::vector<int>& match, const MarkerMotion& motion);

/// Returns the indices of at most `count` frames spread over the recording. The recording is divided into `count` parts of equal length. In
/// each part, the frame with the most seen markers is chosen, if more than half of the used markers are seen in this frame.
[[nodiscard]] std::vector<int> choose_frames(const MarkerMotion& motion, const Subject& subject, int count);

/// Finds a pose without an initial guess: fits from eight headings, each with the arms sideways and hanging, and keeps the best fit.
/// @param pose [out] the pose @return its cost (PoseSolver::solve)
double find_first_pose(PoseSolver& solver, const Subject& subject, const MeasuredFrame& frame, ModelPose& pose);

/// Turns upper arms about their long axes in all frames, by steps of 90 degrees, where this fits the markers better. Arms with few
/// markers have several poses of locally minimal cost, which differ by such a turn.
/// @param poses [frames, in and out] @return true if an arm was turned
bool turn_limbs(const Subject& subject, const std::vector<MeasuredFrame>& frames, std::vector<ModelPose>& poses);

/// Fits segment lengths (equal on both sides), marker offsets and the poses of all `frames` simultaneously: Gauss-Newton method with the
/// poses eliminated by the Schur complement. The marker set's standard deviations are the priors.
/// Ends early if the fit of a damaged recording does not converge.
/// @param poses [frames, in and out] initial and fitted poses
/// @param cancelled called before each pose is solved; true ends the work, and the result is then not a fit
/// @return root mean square of the marker errors, m
double calibrate(Subject& subject, const std::vector<MeasuredFrame>& frames, std::vector<ModelPose>& poses,
                 const std::function<bool()>& cancelled = {});

}  // namespace ugoki::capture
