#pragma once
// The skin of the character in a glTF file.

#include "ugoki/formats/file_skin.h"
#include "ugoki/formats/gltf_unpack.h"

namespace ugoki::formats {

/// Reads the meshes that follow the joints of read_gltf() with the same options: those of skins, and those that are fixed to a joint. The
/// bones place the vertices where the file places them in the first frame of its first animation. Textures are PNG or JPEG. Without such
/// meshes, the result is an empty skin. Errors: the file is damaged, or the skin has values out of range (check_skin).
/// @param notes receives remarks about parts that are left out
[[nodiscard]] Result<FileSkin> read_gltf_skin(std::span<const std::byte> bytes, std::string_view file_name, const GltfOptions& options,
                                              const GltfUnpack& unpack, ReadNotes& notes);

}  // namespace ugoki::formats
