#pragma once
// Converts marker recordings to a moving skeleton: segment lengths, marker offsets, and the joints of every frame by least squares.

#include <functional>
#include <string>
#include <vector>

#include "ugoki/base/result.h"
#include "ugoki/motion/markers.h"
#include "ugoki/motion/skeleton.h"

namespace ugoki::capture {

/// Options of solve_markers and fill_markers.
struct CaptureOptions {
  int calibration_frames = 40;           ///< number of frames from which segment lengths and marker offsets are calibrated
  double longest_gap = 0.2;              ///< s; shorter gaps are filled by splines, longer gaps from the other markers
  double cutoff = 0;                     ///< Hz, low-pass filter of the markers; 0: chosen by residual analysis, negative: none
  bool correct_labels = false;           ///< exchange labels that are exchanged in the whole recording; false: only report them
  std::function<bool()> cancelled = {};  ///< called before each frame; true ends the work: solve_markers fails with ErrorCode::cancelled
};

/// Fit of one marker: distances between recorded and reconstructed positions.
struct MarkerResidual {
  std::string label, segment;
  double rms = 0, maximum = 0;  ///< m
  int worst_frame = 0;
  double seen = 0;  ///< share of the frames in which the marker was seen, 0 ... 1
};

/// Result of solve_markers.
struct Capture {
  MeasuredMotion measured;                ///< the skeleton and its motion, both found from the markers
  std::string marker_set;                 ///< name of the chosen marker set, for display
  double size = 1;                        ///< size of the subject relative to the model
  double rms = 0;                         ///< m, root mean square distance to the recorded positions, over all seen markers and frames
  std::vector<MarkerResidual> residuals;  ///< one entry for each used marker
  std::vector<double> frame_rms;          ///< [frames] m, root mean square over the markers
  std::vector<std::string> unused;        ///< labels that the marker set does not contain
  std::vector<std::string> report;        ///< sentences for display
};

/// Result of fill_markers.
struct FilledMarkers {
  MarkerMotion markers;             ///< recorded positions unchanged; filled positions have residual 0, missing ones -1
  std::vector<std::string> report;  ///< sentences for display
};

/// Fills the gaps of a recording. Short gaps are filled by splines, longer ones from the body pose that the other markers determine. A
/// marker that is never seen gets the mirrored offset of its partner on the other side of the body. Markers unknown to the marker set are
/// filled from markers that move with them as one rigid body; if no body is recognised, this applies to all markers. Remaining gaps are
/// reported.
[[nodiscard]] FilledMarkers fill_markers(const MarkerMotion& motion, const CaptureOptions& options = {});

/// Chooses the marker set that contains most of the labels, fits it to the recording, and solves every frame.
/// Errors: no marker set contains enough of the labels (the remedy lists the missing ones); the markers are coplanar; too few markers are
/// ever seen together; cancelled.
/// O(frames * (markers + DOFs^3)).
[[nodiscard]] Result<Capture> solve_markers(const MarkerMotion& motion, const CaptureOptions& options = {});

}  // namespace ugoki::capture
