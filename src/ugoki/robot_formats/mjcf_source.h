#pragma once
// One MJCF model: its compiler settings, default classes and assets. Internal to robot_formats.

#include <array>
#include <memory>

#include "ugoki/robot_formats/mesh_shape.h"
#include "ugoki/robot_formats/mjcf_document.h"
#include "ugoki/robot_formats/mjcf_mesh.h"

namespace ugoki::robot_formats {

/// Settings of <compiler>.
struct MjcfCompiler {
  enum class FromGeoms { where_needed, always, never };
  bool degrees = true;
  std::string eulerseq = "xyz";  ///< lower case: intrinsic rotations (moving axes); upper case: extrinsic (fixed axes)
  bool autolimits = true;
  std::string mesh_folder;  ///< meshdir or assetdir
  bool strip_path = false;  ///< use only the file name of a mesh path, without folders
  FromGeoms inertia_from_geoms = FromGeoms::where_needed;
  std::array<int, 2> inertia_groups = {0, 5};  ///< first and last geom group whose geoms contribute to mass
  double min_mass = 0, min_inertia = 0;        ///< kg, kg m^2: boundmass, boundinertia
  bool balance_inertia = false;
  double total_mass = 0;  ///< kg; 0: masses are not rescaled

  /// Converts an angle from the unit of the file to radians.
  [[nodiscard]] double radians(double angle) const { return degrees ? angle * (pi / 180.0) : angle; }
};

/// A mesh asset. Its points are the file's points after refpos, refquat and scale were applied.
struct MjcfMeshAsset {
  MjcfElement element;
  bool tried = false;        ///< an attempt was made to load the file
  std::string absent;        ///< reason why there are no points (without a final full stop); empty if the mesh was read
  std::vector<Vec3> points;  ///< m
  std::vector<MeshTriangle> triangles;
  MeshInertia kind = MeshInertia::legacy;
  std::optional<Shape> shape;  ///< collision shape; made when it is first needed
};

/// A height field asset. As in MuJoCo, the heights are scaled to the range from 0 to the maximum height in the asset's size.
struct MjcfHeightField {
  MjcfElement element;
  bool tried = false;
  std::string absent;  ///< sentence for the user: reason why the field is missing; empty if the field was read
  HeightFieldPtr field;
};

/// Returns the shortest rotation that maps z to the unit vector `direction`; half a turn about x if the direction is -z.
[[nodiscard]] Mat3 z_turned_to(const Vec3& direction);

/// Loads a model and provides its elements, defaults and assets.
class MjcfSource {
 public:
  /// @param path path of the model's file, used in messages; other files are relative to its folder
  /// @param ancestors paths of the models that attach this one, to detect a model that contains itself
  [[nodiscard]] bool load(std::string_view text, const std::string& path, MjcfFiles& files, std::vector<std::string> ancestors = {});

  [[nodiscard]] const MjcfDocument& document() const { return document_; }
  [[nodiscard]] const MjcfCompiler& compiler() const { return compiler_; }
  [[nodiscard]] const MjcfDefaults& defaults() const { return defaults_; }
  /// Returns the model asset of this name, or null.
  [[nodiscard]] MjcfSource* model(const std::string& name) const;
  /// Returns the mesh asset of this name, or null. The first call reads its file; a file that exists but is damaged adds a problem.
  [[nodiscard]] MjcfMeshAsset* mesh(const std::string& name);

  /// Returns the height field asset of this name, or null. The first call reads its file, if it exists.
  [[nodiscard]] const MjcfHeightField* height_field(const std::string& name);

  /// Returns the orientation of an element, from its attribute quat, axisangle, xyaxes, zaxis or euler.
  [[nodiscard]] Mat3 orientation(const MjcfAttributes& a) const;
  [[nodiscard]] Pose pose(const MjcfAttributes& a) const { return {orientation(a), a.vec3("pos", {})}; }
  /// Returns the rotation by Euler angles in the order `eulerseq`. @param angles in the file's unit
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
  std::vector<std::string> ancestors_;
  std::map<std::string, MjcfMeshAsset, std::less<>> meshes_;
  std::map<std::string, MjcfHeightField, std::less<>> height_fields_;
  std::map<std::string, std::unique_ptr<MjcfSource>, std::less<>> models_;
};

}  // namespace ugoki::robot_formats
