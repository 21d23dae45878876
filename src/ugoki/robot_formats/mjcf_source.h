#pragma once
// One MJCF model as a source of bodies: its compiler settings, default classes and assets. Internal to robot_formats.

#include <array>
#include <memory>

#include "ugoki/robot_formats/mesh_shape.h"
#include "ugoki/robot_formats/mjcf_document.h"
#include "ugoki/robot_formats/mjcf_mesh.h"

namespace ugoki::robot_formats {

struct MjcfCompiler {
  enum class FromGeoms { where_needed, always, never };
  bool degrees = true;
  std::string eulerseq = "xyz";  ///< lower case: axes that turn along; upper case: axes that stay
  bool autolimits = true;
  std::string mesh_folder;
  bool strip_path = false;
  FromGeoms inertia_from_geoms = FromGeoms::where_needed;
  std::array<int, 2> inertia_groups = {0, 5};
  double least_mass = 0, least_inertia = 0;
  bool balance_inertia = false;
  double total_mass = 0;  ///< kg; 0: as it comes

  [[nodiscard]] double radians(double angle) const { return degrees ? angle * (pi / 180.0) : angle; }
};

/// A mesh asset. Its points are those of the file after refpos, refquat and scale.
struct MjcfMeshAsset {
  MjcfElement element;
  bool tried = false;        ///< load() was called
  std::string absent;        ///< why there are no points; empty if there are
  std::vector<Vec3> points;  ///< m
  std::vector<MeshTriangle> triangles;
  MeshInertia kind = MeshInertia::legacy;
  std::optional<Shape> shape;  ///< made from it when a geom collides
};

/// A height field asset. MuJoCo stretches its heights from 0 to the size that the asset gives.
struct MjcfHeightField {
  MjcfElement element;
  bool tried = false;
  std::string absent;  ///< a sentence: why there is no field
  HeightFieldPtr field;
};

/// The rotation that turns z into the unit vector `direction` the shortest way; half a turn about x where that is -z.
[[nodiscard]] Mat3 z_turned_to(const Vec3& direction);

class MjcfSource {
 public:
  /// @param path of the model's file, for messages and as the place to which other files are relative
  /// @param above files whose models lead to this one
  [[nodiscard]] bool load(std::string_view text, const std::string& path, MjcfFiles& files, std::vector<std::string> above = {});

  [[nodiscard]] const MjcfDocument& document() const { return document_; }
  [[nodiscard]] const MjcfCompiler& compiler() const { return compiler_; }
  [[nodiscard]] const MjcfDefaults& defaults() const { return defaults_; }
  /// The model asset of this name, or null.
  [[nodiscard]] MjcfSource* model(const std::string& name) const;
  /// The mesh asset of this name with its file read, or null. A file that is there but broken is a problem of the asset.
  [[nodiscard]] MjcfMeshAsset* mesh(const std::string& name);

  /// The same for a height field.
  [[nodiscard]] const MjcfHeightField* height_field(const std::string& name);

  /// From quat, or from what may be given in its stead: axisangle, xyaxes, zaxis, euler.
  [[nodiscard]] Mat3 orientation(const MjcfAttributes& a) const;
  [[nodiscard]] Pose pose(const MjcfAttributes& a) const { return {orientation(a), a.vec3("pos", {})}; }
  /// By `eulerseq`. @param angles in the unit of the file
  [[nodiscard]] Mat3 from_euler_angles(const Vec3& angles) const;

 private:
  void read_compiler();
  void read_assets();
  void load_mesh(MjcfMeshAsset& mesh) const;
  void load_height_field(MjcfHeightField& field) const;
  [[nodiscard]] std::string mesh_path(const std::string& file) const;

  MjcfDocument document_;
  MjcfCompiler compiler_;
  MjcfDefaults defaults_;
  MjcfFiles* files_ = nullptr;
  std::string folder_;
  std::vector<std::string> above_;
  std::map<std::string, MjcfMeshAsset, std::less<>> meshes_;
  std::map<std::string, MjcfHeightField, std::less<>> height_fields_;
  std::map<std::string, std::unique_ptr<MjcfSource>, std::less<>> models_;
};

}  // namespace ugoki::robot_formats
