#pragma once
// Unpacks buffers of glTF files that the extension EXT_meshopt_compression packs.

#include <cstddef>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

namespace ugoki::scene_formats {

/// See formats::GltfUnpack. Safe for damaged data.
[[nodiscard]] std::optional<std::vector<std::byte>> unpack_meshopt(std::span<const std::byte> packed, std::size_t count, std::size_t stride,
                                                                   std::string_view filter);

}  // namespace ugoki::scene_formats
