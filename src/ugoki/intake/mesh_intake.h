#pragma once
// Import of mesh files. Internal to intake.

#include <optional>
#include <span>
#include <string_view>

#include "ugoki/intake/intake.h"

namespace ugoki::intake {

/// True if a glTF, COLLADA or FBX file has neither skins nor animations, so that it is no character.
[[nodiscard]] bool is_still(std::string_view bytes);

/// Reads a mesh file and makes its library entry, from which props are made. Errors: those of read_mesh_scene() and make_mesh_body(), also
/// for a file without triangles, which can be a skeleton without a skin.
[[nodiscard]] Result<Intake> take_in_mesh(std::string_view bytes, std::string_view file_name, const IntakeOptions& options);

/// Imports a file of rigid parts that move, but have no joints, as a mesh. Empty if the file contains a body or no usable mesh,
/// or if options.motion_of_parts is set.
[[nodiscard]] std::optional<Intake> take_in_rigid_parts(std::string_view bytes, std::string_view file_name, const IntakeOptions& options,
                                                        std::span<const MeasuredMotion> motions);

}  // namespace ugoki::intake
