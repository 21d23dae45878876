#pragma once
// Calibration: segment lengths of a subject and positions of the markers on its segments, from the recording. Internal to capture.

#include "ugoki/capture/pose_solver.h"

namespace ugoki::capture {

/// Size of the subject relative to the model: median ratio of measured to model distance over all pairs of markers on the same or
/// adjacent segments. 0 if no such pair was ever seen together.
[[nodiscard]] double estimate_size(const MarkerSet& set, const std::vector<int>& match, const MarkerMotion& motion);

/// At most `count` frames spread over the recording: of each part the frame with the most markers seen, if more than half are seen.
[[nodiscard]] std::vector<int> choose_frames(const MarkerMotion& motion, const Subject& subject, int count);

/// Finds a pose without an initial guess: the best of eight headings, each with arms sideways and arms hanging.
/// @param pose out @return its cost (PoseSolver::solve)
double find_first_pose(PoseSolver& solver, const Subject& subject, const MeasuredFrame& frame, ModelPose& pose);

/// Fits segment lengths (equal on both sides), marker offsets and the poses of all `frames` simultaneously: Gauss-Newton with the poses
/// eliminated by the Schur complement; the marker set's sigmas are priors.
/// @param poses [frames, in and out] start and result
/// @return root mean square of the marker errors, m
double calibrate(Subject& subject, const std::vector<MeasuredFrame>& frames, std::vector<ModelPose>& poses);

}  // namespace ugoki::capture
