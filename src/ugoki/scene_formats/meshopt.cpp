#include "ugoki/scene_formats/meshopt.h"

#include <meshoptimizer.h>

namespace ugoki::scene_formats {

std::optional<std::vector<std::byte>> unpack_meshopt(std::span<const std::byte> packed, std::size_t count, std::size_t stride,
                                                     std::string_view filter) {
  if (stride == 0 || stride > 256 || stride % 4 != 0) return std::nullopt;
  std::vector<std::byte> out(count * stride);
  if (count == 0) return out;
  const auto* bytes = reinterpret_cast<const unsigned char*>(packed.data());
  if (meshopt_decodeVertexBuffer(out.data(), count, stride, bytes, packed.size()) != 0) return std::nullopt;
  if (filter == "NONE") return out;
  if (filter == "EXPONENTIAL") {
    meshopt_decodeFilterExp(out.data(), count, stride);
  } else if (filter == "QUATERNION" && stride == 8) {
    meshopt_decodeFilterQuat(out.data(), count, stride);
  } else if (filter == "OCTAHEDRAL" && (stride == 4 || stride == 8)) {
    meshopt_decodeFilterOct(out.data(), count, stride);
  } else {
    return std::nullopt;
  }
  return out;
}

}  // namespace ugoki::scene_formats
