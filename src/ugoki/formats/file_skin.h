#pragma once
// The skin of a character as a file gives it, before its bones are attached to the links of a body.

#include <span>
#include <string>
#include <vector>

#include "ugoki/mechanism/skin.h"

namespace ugoki::formats {

/// A vertex v is at A v + p [m] in the frame of a joint of the measured motion that was read from the same file.
struct FileBone {
  std::string joint;
  Mat3 A = Mat3::identity();
  Vec3 p;
};

struct FileSkin {
  Skin skin;                    ///< empty if the file has no surface that follows joints
  std::vector<FileBone> bones;  ///< of Skin::bones
};

/// Sets the four bones of the next vertex: the heaviest of `shares`, whose weights are scaled to a sum of 1. Weights that are not above 0
/// are ignored; without others the vertex follows the first bone.
/// @param shares bone and weight; changed
void add_weights(Skin& skin, std::vector<std::pair<std::uint16_t, double>>& shares);

/// Sets normals of the vertices from `first` on to the mean of the normals of their triangles, weighted with the areas.
/// @param first_index index in Skin::indices of the first corner of these triangles
void add_normals(Skin& skin, std::size_t first, std::size_t first_index);

/// Sets the colours of the vertices from `first` on. @param linear [vertices from first on][3] red, green and blue; clamped to 0 ... 1;
/// empty: white
void add_colors(Skin& skin, std::size_t first, std::span<const double> linear);

/// Removes vertices that no triangle uses, bones that no vertex uses, and textures that no part uses.
void remove_unused(FileSkin& skin);

}  // namespace ugoki::formats
