#pragma once
// Gives trajectories without a label to the markers that are missing at their place. Internal to capture.

#include <functional>
#include <string>
#include <vector>

#include "ugoki/capture/model.h"
#include "ugoki/motion/markers.h"

namespace ugoki::capture {

/// True for labels that capture systems give to points which nobody has labelled: "*12", "U7", "Unlabeled 3", "C_1004", "15".
[[nodiscard]] bool is_unlabelled(const std::string& label);

/// Copies unlabelled points into the gaps of the subject's markers: the points that are within 4 cm (for a body of the model's size) of the
/// marker's place on the body, which the other markers determine, for at least three successive frames. Each point is used once.
/// @param markers recording after the repair of short gaps @param first, from, cancelled as in solve_frames
/// @return sentences about the trajectories that were used
[[nodiscard]] std::vector<std::string> use_unlabelled(MarkerMotion& markers, const Subject& subject, const ModelPose& first, int from,
                                                      const std::function<bool()>& cancelled);

}  // namespace ugoki::capture
