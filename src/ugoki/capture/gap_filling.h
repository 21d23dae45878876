#pragma once
// Fills positions of unseen markers from the pose of the subject that wears them. Internal to capture.

#include <functional>

#include "ugoki/capture/pose_solver.h"

namespace ugoki::capture {

/// Solves the poses of all frames: forwards from frame `from` to the end, then backwards from `from` to 0. Each frame starts from
/// its neighbour's pose.
/// @param first initial pose of the iteration in frame `from`
/// @param cancelled called before each frame, may be empty; true ends the work
/// @param visit called after each frame as visit(frame, solver, pose)
template <class Visit>
void solve_frames(const MarkerMotion& markers, const Subject& subject, const ModelPose& first, int from,
                  const std::function<bool()>& cancelled, const Visit& visit) {
  PoseSolver solver;
  for (const int step : {1, -1}) {
    ModelPose pose = first;
    for (int f = step > 0 ? from : from - 1; f >= 0 && f < markers.frames; f += step) {
      if (cancelled && cancelled()) return;
      const ModelPose near = pose;
      PoseOptions options;
      if (f != from) {
        options.near = &near;
        options.step_sigma = 30 / markers.rate;  // rad, a weak prior: it has an effect only on DOFs that no seen marker determines
      }
      solver.solve(subject, measured_frame(markers, subject, f), options, pose);
      visit(f, solver, pose);
    }
  }
}

/// True if at least a third of the subject's markers are seen in the frame. If fewer are seen, the priors dominate the pose.
[[nodiscard]] bool enough_markers_seen(const MarkerMotion& markers, const Subject& subject, int frame);

/// Fills every gap of the subject's markers from the pose of the marker's segment, which the other markers determine. At each end of the
/// gap this position differs from the recorded one; the two differences are interpolated over the gap, so that the path has no jump. Frames
/// in which enough_markers_seen() is false are not filled.
/// @param first, from, cancelled as in solve_frames; after a cancellation the markers are unchanged @return number of filled positions
int fill_gaps_by_body(MarkerMotion& markers, const Subject& subject, const ModelPose& first, int from,
                      const std::function<bool()>& cancelled);

/// Gives markers that are seen in no frame of `seen` the mirrored offset of their partner on the other side of the body.
void mirror_unseen_offsets(Subject& subject, const std::vector<MeasuredFrame>& seen);

}  // namespace ugoki::capture
