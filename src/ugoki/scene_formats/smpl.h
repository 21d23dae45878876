#pragma once
// Reads motions of the SMPL body models: .npz files of AMASS and of programs that write the same arrays. docs/formats.md lists them.

#include <cstddef>
#include <span>
#include <string_view>

#include "ugoki/base/result.h"
#include "ugoki/formats/read_notes.h"
#include "ugoki/motion/skeleton.h"

namespace ugoki::scene_formats {

/// Body model (an .npz file with J_regressor, v_template, shapedirs) that belongs to a motion.
struct SmplModelFile {
  std::span<const std::byte> bytes;  ///< empty: no model
  std::string_view name;             ///< for the locations of problems
};

/// Reads `poses` (rotation vectors of SMPL, SMPL+H or SMPL-X), `trans` and the frame rate. With a body model, the joints at rest are those
/// of the model for the motion's `betas`. Without one, an adult of average proportions is assumed, whose size is fitted so that the lower
/// foot slides least. The up axis (Y or Z) is the one along which the pelvis points.
/// Errors: not npz, `poses` or `trans` missing or of the wrong shape; a model with fewer joints.
[[nodiscard]] Result<MeasuredMotion> read_smpl(std::span<const std::byte> bytes, std::string_view file_name,
                                               const SmplModelFile& model = {}, formats::ReadNotes* notes = nullptr);

}  // namespace ugoki::scene_formats
