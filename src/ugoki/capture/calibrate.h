#pragma once
// Lengths of a subject and places of the markers on it, from the recording itself. Internal to capture.

#include "ugoki/capture/pose_solver.h"

namespace ugoki::capture {

/// How many times the model's size the subject is: the median over pairs of markers on neighbouring segments of the measured distance
/// against the model's. 0 where no pair was ever seen together.
[[nodiscard]] double estimate_size(const MarkerSet& set, const std::vector<int>& match, const MarkerMotion& motion);

/// Frames in which most markers are seen, spread over the recording. At most `count`.
[[nodiscard]] std::vector<int> choose_frames(const MarkerMotion& motion, const Subject& subject, int count);

/// A pose from nothing: the best of several headings and of arms held out or hanging. @return its cost
double find_first_pose(PoseSolver& solver, const Subject& subject, const MeasuredFrame& frame, ModelPose& pose);

/// Fits the lengths of the segments (the same on both sides) and the places of the markers to all `frames` at once, together with
/// their poses: Gauss-Newton with the poses eliminated (Schur complement), priors from the marker set's sigmas.
/// @param poses [frames] start and result
/// @return root mean square of the marker errors, m
double calibrate(Subject& subject, const std::vector<MeasuredFrame>& frames, std::vector<ModelPose>& poses);

}  // namespace ugoki::capture
