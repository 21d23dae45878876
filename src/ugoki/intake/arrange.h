#pragma once
// Reduces the joints of a file to those of one character, so that bodies do not depend on other objects in the file.

#include <span>
#include <string>
#include <vector>

#include "ugoki/body/recognise.h"
#include "ugoki/motion/markers.h"
#include "ugoki/motion/skeleton.h"

namespace ugoki::intake {

/// Reduces the motions to their character:
///   - joints that carry the character's pelvis and no other part of the character (scene roots, "reference", "armature") are removed, and
///     the pelvis becomes the root. If the spine branches off above the joint that carries the legs, that joint becomes the root.
///   - joints outside the character (cameras, lights, footsteps, targets, other characters) are removed.
/// World positions of the remaining joints do not change. If no character is recognised, only roots that carry a single joint are removed
/// (remove_carrier_roots).
/// @param motions all on the same skeleton
/// @param report receives sentences about what was removed
/// @param mapping corrects the recognised anatomy; null: none
/// @param mesh_ends true: the end sites were estimated from a mesh (GltfOptions::mesh_ends). They are used only if no character is
///   recognised without them, and removed otherwise
/// @return the character, with the indices of the remaining joints
[[nodiscard]] body::Character arrange(std::span<MeasuredMotion> motions, std::vector<std::string>& report,
                                      const body::AnatomyMapping* mapping = nullptr, bool mesh_ends = false);

/// Attaches joints that shift relative to their parent to the ancestor with which they move rigidly. (In 3ds Max Biped, thighs are children
/// of the spine and collar bones of the neck, although they move with pelvis and chest.) World poses do not change.
/// @param motions all on the same skeleton
/// @return names of the joints with a new parent
std::vector<std::string> attach_to_rigid_ancestors(std::span<MeasuredMotion> motions);

/// Gives joints that shift far relative to their parent to another joint to which they are rigid. (Game rigs hang feet and hands that
/// inverse kinematics drives into the root, although ankles stay at the ends of the shanks.) World poses do not change.
/// @param motions all on the same skeleton
/// @return names of the joints with a new parent
std::vector<std::string> attach_to_rigid_joints(std::span<MeasuredMotion> motions);

/// Gives the fore limbs of an animal, or the arms of a person, to the child of their joint that carries the head, if the hind limbs have
/// the same joint. (Some rigs of games hang trunk, neck and all limbs into one joint.) Limbs are found by their names. World poses do not
/// change.
/// @param motions all on the same skeleton
/// @return names of the joints with a new parent
std::vector<std::string> attach_fore_limbs_to_spine(std::span<MeasuredMotion> motions);

/// Cuts a motion to its longest part without a jump of the whole character (clips appended in one file, a rest pose at the end). A jump
/// between the first two frames stays: make_body handles such calibration poses.
/// @return sentence about the cut; empty if there is no jump
[[nodiscard]] std::string cut_at_jumps(const body::Character& character, MeasuredMotion& motion);

/// Cuts a motion at poses that the file holds exactly, for at least 0.25 s, between frames in which the character moves fast (gaps between
/// the recordings in files of motion libraries), and keeps the longest part. A character that comes to rest is left alone.
/// @return a sentence about it; empty if there is no such pose
[[nodiscard]] std::string cut_at_holds(const body::Character& character, MeasuredMotion& motion);

/// Cuts a recording to its longest part in which the markers do not jump together (a calibration pose before the motion).
/// @return sentence about the cut; empty if there is no jump
[[nodiscard]] std::string cut_markers_at_jumps(MarkerMotion& markers);

/// Merges joints that have children, are at the place of their parent and do not turn relative to it in any frame, with the parent. (ASF
/// files have such a bone for each child of a joint with several children.) World poses of the other joints do not change.
/// @param motions all on the same skeleton
/// @return names of the merged joints
std::vector<std::string> merge_rigid_joints(std::span<MeasuredMotion> motions);

/// Makes joint `root` the root of the motion: the chain of joints from the present root to `root` is reversed. Each reversed joint moves to
/// the position of its former child, about which it turns. World poses of all other joints do not change, nor do joints that are not below
/// the present root.
void make_root(MeasuredMotion& motion, int root);

/// Removes joints; the others keep their world poses. @param keep [joints] 1: the joint stays; its nearest kept ancestor becomes its parent
void keep_joints(MeasuredMotion& motion, std::span<const char> keep);

}  // namespace ugoki::intake
