#pragma once
// Writer of the binary part of a GLB file (glTF 2.0, section "GLB File Format Specification").

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "ugoki/json/json.h"
#include "ugoki/spatial/rotation.h"

namespace ugoki::formats {

/// The binary chunk with its buffer views and accessors, filled value by value.
class GlbChunk {
 public:
  /// Appends values, aligned to 4 bytes. @return index of the accessor of these values
  /// @param components count of numbers in an element, for example 3
  /// @param type       glTF type of an element, for example "VEC3"
  /// @param kind       glTF component type: 5126 float, 5125 unsigned int, 5123 unsigned short
  /// @param target     glTF target of the buffer view (34962: vertex attributes, 34963: vertex indices); 0: none
  template <class T>
  int add(const std::vector<T>& values, std::size_t components, const char* type, int kind, int target = 0) {
    return add(values.data(), values.size() * sizeof(T), values.size() / components, type, kind, target);
  }
  int floats(const std::vector<float>& values, std::size_t components, const char* type, int target = 0) {
    return add(values, components, type, 5126, target);
  }
  /// Appends the bytes of a picture. @return index of the buffer view
  int picture(std::span<const std::byte> data);
  /// Sets the minimum and maximum of each component, which glTF requires for positions and key times.
  void bound(int accessor, const std::vector<float>& values, std::size_t components);

  /// Returns the GLB file. @param root the JSON part without buffers, buffer views and accessors
  [[nodiscard]] std::vector<std::byte> finish(json::Json root);

 private:
  int add(const void* data, std::size_t size, std::size_t count, const char* type, int kind, int target);

  std::vector<std::byte> bytes_;
  json::Json views_ = json::Json::array(), accessors_ = json::Json::array();
};

/// Returns the rotation as x, y, z, w, normalised after rounding to single precision: validators check the norm of the stored values.
[[nodiscard]] std::array<float, 4> glb_rotation(const Quat& q);

}  // namespace ugoki::formats
