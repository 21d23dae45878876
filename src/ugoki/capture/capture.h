#pragma once
// From markers to a skeleton that moves: lengths, places of the markers, and the joints of every frame by least squares.

#include <string>
#include <vector>

#include "ugoki/base/result.h"
#include "ugoki/motion/markers.h"
#include "ugoki/motion/skeleton.h"

namespace ugoki::capture {

struct CaptureOptions {
  int calibration_frames = 40;  ///< frames from which lengths and places of markers are found
  double longest_gap = 0.2;     ///< s: shorter gaps of a marker are filled by a spline; longer ones are left to its neighbours
  double cutoff = 0;            ///< Hz of the low-pass filter over the markers; 0: chosen by residual analysis, negative: none
};

struct MarkerResidual {
  std::string label, segment;
  double rms = 0, greatest = 0;  ///< m
  int worst_frame = 0;
  double seen = 0;  ///< share of the frames, 0 ... 1
};

struct Capture {
  MeasuredMotion measured;                ///< the skeleton, and its joints over time
  std::string marker_set;                 ///< for people
  double size = 1;                        ///< times the model's own size
  double rms = 0;                         ///< m, over all seen markers and frames, against the positions as recorded
  std::vector<MarkerResidual> residuals;  ///< of the markers that were used
  std::vector<double> frame_rms;          ///< [frames] m
  std::vector<std::string> unused;        ///< labels that the marker set does not know
  std::vector<std::string> report;        ///< sentences for people
};

/// A recording without gaps.
struct FilledMarkers {
  MarkerMotion markers;             ///< as recorded where they were seen; filled places have a residual of 0
  std::vector<std::string> report;  ///< sentences for people
};

/// Closes the gaps of a recording: short ones by splines; longer ones by the body that the other markers tell, a marker that is never seen
/// at the mirrored place of the one on the other side; markers that no set knows, and recordings in which no body is found, by markers
/// that move with them as one rigid body. What none of these can fill stays unseen, and is told.
[[nodiscard]] FilledMarkers fill_markers(const MarkerMotion& motion, const CaptureOptions& options = {});

/// Chooses the marker set whose labels fit best, fits it to the recording, and solves every frame.
/// Errors: no marker set knows enough of the labels (the remedy names those missing), or too few markers are ever seen together.
/// O(frames * (markers + freedoms^3)).
[[nodiscard]] Result<Capture> solve_markers(const MarkerMotion& motion, const CaptureOptions& options = {});

}  // namespace ugoki::capture
