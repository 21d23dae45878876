#pragma once
// Finds labels that are exchanged in a whole recording. Internal to capture.

#include <utility>
#include <vector>

#include "ugoki/capture/marker_set.h"
#include "ugoki/motion/markers.h"

namespace ugoki::capture {

/// Labels that are exchanged in all frames.
struct LabelCheck {
  bool mirrored = false;                   ///< left and right are exchanged on the whole body, after the exchange of the pairs
  std::vector<std::pair<int, int>> pairs;  ///< columns of the recording whose labels are exchanged with each other
};

/// Compares the distances between markers with those on the model, in up to 60 frames. Markers of one segment keep their distance, and the
/// distance of markers of adjacent segments has bounds. Exchanges of two labels, and of the sides of both arms, of both legs or of a part
/// of them, are tried, and the exchange that improves the distances most is made, as long as the improvement is clear. Left and right of
/// the whole body do not change distances: the best alignment of trunk and head with the model is then a reflection (Kabsch 1976).
/// @param match [columns] result of match_labels
[[nodiscard]] LabelCheck check_labels(const MarkerSet& set, const std::vector<int>& match, const MarkerMotion& motion);

/// Column of the marker at the mirrored place on the model; -1: none. @param match [columns] result of match_labels
[[nodiscard]] int opposite_column(const MarkerSet& set, const std::vector<int>& match, int column);

}  // namespace ugoki::capture
