#pragma once
// Places of markers that were not seen, from the subject that carries them. Internal to capture.

#include "ugoki/capture/pose_solver.h"

namespace ugoki::capture {

/// Poses of all frames, each from the one before it: from `from` to the end, then back to the start.
/// @param first start of the iteration in frame `from`
/// @param visit called after each frame with the solver at its solution
template <class Visit>
void solve_frames(const MarkerMotion& markers, const Subject& subject, const ModelPose& first, int from, const Visit& visit) {
  PoseSolver solver;
  for (const int step : {1, -1}) {
    ModelPose pose = first;
    for (int f = step > 0 ? from : from - 1; f >= 0 && f < markers.frames; f += step) {
      const ModelPose near = pose;
      PoseOptions options;
      if (f != from) {
        options.near = &near;
        options.step_sigma = 30 / markers.rate;  // a weak hold: it decides only where no marker tells
      }
      solver.solve(subject, measured_frame(markers, subject, f), options, pose);
      visit(f, solver, pose);
    }
  }
}

/// Whether a third of the subject's markers is seen in this frame. Where fewer are, a pose is more invented than measured.
[[nodiscard]] bool knows_body(const MarkerMotion& markers, const Subject& subject, int frame);

/// Fills every gap of the subject's markers: the marker moves with its segment, whose pose the other markers tell; how far that is from
/// where the marker was seen before and after the gap goes over from one into the other, so that nothing jumps.
/// Frames in which the body is not known stay as they are.
/// @return how many places were filled
int fill_gaps_by_body(MarkerMotion& markers, const Subject& subject, const ModelPose& first, int from);

/// Markers that no frame of `seen` has sit as their partners on the other side do, mirrored.
void mirror_unseen_places(Subject& subject, const std::vector<MeasuredFrame>& seen);

}  // namespace ugoki::capture
