#pragma once
// glTF files with buffer views that the extension EXT_meshopt_compression packs.

#include <optional>

#include "ugoki/formats/gltf.h"

namespace ugoki::formats {

/// Unpacks one buffer view. Returns the count * stride bytes, or std::nullopt if the data are damaged.
/// @param stride bytes of an element: a multiple of 4, at most 256  @param filter "NONE", "OCTAHEDRAL", "QUATERNION" or "EXPONENTIAL"
using GltfUnpack = std::function<std::optional<std::vector<std::byte>>(std::span<const std::byte> packed, std::size_t count,
                                                                       std::size_t stride, std::string_view filter)>;

/// Like read_gltf(bytes, file_name, options, notes), but also reads files with packed buffer views. @param unpack null: they are refused
[[nodiscard]] Result<std::vector<MeasuredMotion>> read_gltf(std::span<const std::byte> bytes, std::string_view file_name,
                                                            const GltfOptions& options, const GltfUnpack& unpack,
                                                            ReadNotes* notes = nullptr);

}  // namespace ugoki::formats
