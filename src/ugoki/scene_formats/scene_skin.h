#pragma once
// The skin of the character in an FBX or COLLADA file.

#include "ugoki/formats/file_skin.h"
#include "ugoki/formats/gltf.h"
#include "ugoki/scene_formats/scene_file.h"

namespace ugoki::scene_formats {

/// Reads the meshes that follow the joints of read_scene() with the same options: those with bones, and those that are fixed to a joint.
/// The bones place the vertices where the file places them in the first frame of its first animation. Textures are PNG or JPEG, in the file
/// or beside it. The file is parsed in a child process, as by read_scene(). Without such meshes, the result is an empty skin.
/// @param files reads pictures beside the file, by the name that the file gives; null: they are left out
/// @param notes receives remarks about parts that are left out
[[nodiscard]] Result<formats::FileSkin> read_scene_skin(std::span<const std::byte> bytes, std::string_view file_name,
                                                        const SceneOptions& options, const formats::GltfFiles& files,
                                                        formats::ReadNotes& notes);

}  // namespace ugoki::scene_formats
