#pragma once
// From a file's bytes to library entries.

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "ugoki/base/result.h"
#include "ugoki/body/body.h"
#include "ugoki/formats/asf.h"
#include "ugoki/formats/gltf.h"
#include "ugoki/intake/conversion_report.h"
#include "ugoki/intake/correction.h"
#include "ugoki/motion/markers.h"
#include "ugoki/motion/motion.h"
#include "ugoki/motion/skeleton.h"
#include "ugoki/robot_formats/robot_model.h"
#include "ugoki/store/library.h"

namespace ugoki::intake {

struct IntakeOptions {
  std::string name;  ///< of the entries; empty: the file's name without ending
  std::vector<std::string> tags;
  double height = 0;                  ///< m, of the person; 0: estimated
  double mass = 0;                    ///< kg, of the person; 0: estimated
  double unit = 0;                    ///< m per unit of length of the file; 0: guessed (BVH) or as the format says (ASF)
  double rate = 120;                  ///< frames a second of AMC files, which do not tell
  double frame_rate = 0;              ///< frames a second, whatever the file says; 0: as the file says
  std::optional<Orientation> axes;    ///< up and forward in the file's space; nothing: as its reader takes them
  formats::GltfFiles files;           ///< buffers beside a .gltf file; null: they are refused
  robot_formats::RobotOptions robot;  ///< URDF, SDF, MJCF
};

/// A file, taken in but not yet stored.
struct Intake {
  std::string source;                              ///< the file's name
  std::optional<MarkerMotion> markers;             ///< C3D, TRC: as recorded
  std::optional<MeasuredMotion> measured;          ///< BVH, AMC, C3D, TRC, glTF (the first of several)
  std::optional<body::Body> body;                  ///< BVH, AMC, C3D, TRC, glTF (the first of several)
  std::optional<Motion> motion;                    ///< BVH, AMC, C3D, TRC, glTF (the first of several)
  std::optional<robot_formats::RobotModel> robot;  ///< URDF, SDF, MJCF
  MechanismPtr mechanism;                          ///< the body's, or the file's
  double metres_per_unit = 0;                      ///< unit of length that was used; 0: the file has none
  bool unit_guessed = false;                       ///< neither the file nor the caller told the unit
  Orientation axes = usual_orientation(true);      ///< up and forward in the file's space, as taken
  std::vector<std::string> report;                 ///< sentences for people
  ConversionReport conversion;                     ///< the same in parts, and what the file holds
  std::vector<store::LibraryItem> items;           ///< what goes into the library: mechanism first, then measured, motion
  /// Id that the items will have. Empty if there is no item of this kind.
  [[nodiscard]] std::string id_of(store::EntryKind kind) const;
};

enum class FileKind { bvh, amc, asf, c3d, trc, csv, gltf, scene, mechanism_json, robot };
/// By the ending of the name, in any case.
[[nodiscard]] std::optional<FileKind> file_kind(std::string_view file_name);

/// Name of the skeleton file that goes with an AMC file: "12_01.amc" -> "12.asf"; without underscore "x.amc" -> "x.asf".
[[nodiscard]] std::string skeleton_name_for(std::string_view amc_name);

/// Reads the file and makes everything that will be stored.
/// @param file_name decides the kind and stands in the place of every problem
/// @param asf the skeleton, for AMC files; may be null otherwise
[[nodiscard]] Result<Intake> take_in(std::string_view bytes, std::string_view file_name, const formats::Asf* asf = nullptr,
                                     const IntakeOptions& options = {});

/// Puts all items in or none.
/// @return ids in the order of the items
[[nodiscard]] Result<std::vector<std::string>> put(store::Library& library, const Intake& intake);

}  // namespace ugoki::intake
