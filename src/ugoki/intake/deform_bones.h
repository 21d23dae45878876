#pragma once
// Reduces rigs that contain mechanisms besides the bones of the character. Internal to intake.

#include <span>

#include "ugoki/body/recognise.h"
#include "ugoki/motion/skeleton.h"

namespace ugoki::intake {

/// True if trunk or limbs of a four-legged animal contain joints that do not deform the mesh of a rig of Rigify ("DEF-thigh.L"): joints of
/// its mechanisms, or of a file without such a rig.
[[nodiscard]] bool consists_of_mechanisms(const Skeleton& s, const body::Character& c);

/// Leaves only the bones that deform the mesh, if the rig names them as Rigify of Blender does ("DEF-thigh.L"). In these rigs the bones
/// hang on mechanisms: the spine on the root, the limbs on copies of its bones ("ORG-spine.005"). Each bone gets the deforming bone of the
/// same name as its closest ancestor that has one. Branches without such an ancestor are left out, except the largest. World poses of the
/// remaining joints do not change.
/// @param motions all on the same skeleton
/// @return true if the skeleton was reduced; false if it has fewer than eight such bones (then nothing was changed)
bool keep_deform_bones(std::span<MeasuredMotion> motions);

}  // namespace ugoki::intake
