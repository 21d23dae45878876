#pragma once
// Import of a file: from its bytes to library entries.

#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "ugoki/base/result.h"
#include "ugoki/body/body.h"
#include "ugoki/formats/asf.h"
#include "ugoki/formats/gltf.h"
#include "ugoki/formats/read_notes.h"
#include "ugoki/intake/conversion_report.h"
#include "ugoki/intake/correction.h"
#include "ugoki/intake/mesh_body.h"
#include "ugoki/motion/markers.h"
#include "ugoki/motion/motion.h"
#include "ugoki/motion/skeleton.h"
#include "ugoki/robot_formats/robot_model.h"
#include "ugoki/store/library.h"

namespace ugoki::intake {

/// Options of take_in; the defaults follow the file.
struct IntakeOptions {
  std::string name;                             ///< name of the entries; empty: the file's name without extension
  std::vector<std::string> tags;                ///< tags of the entries
  double height = 0;                            ///< m, height of the person; 0: estimated
  double mass = 0;                              ///< kg, mass of the person; 0: estimated
  double unit = 0;                              ///< m per unit of length of the file; 0: guessed (BVH) or as the format specifies (ASF)
  double rate = 120;                            ///< frames/s of AMC files, whose format does not specify it
  double frame_rate = 0;                        ///< frames/s, overrides the file; 0: as the file specifies
  std::string species;                          ///< of a four-legged animal; empty: as names in the file state it, "none": unknown
  std::optional<Orientation> axes;              ///< up and forward axes of the file's space; std::nullopt: as the reader assumes
  std::optional<body::AnatomyMapping> mapping;  ///< corrects the recognised anatomy
  std::string character;                        ///< of a file with several: its number from 1, or its root joint; empty: the first
  std::string take;                             ///< of a file with several motions: its number from 1, or its name; empty: all
  /// Give characters that walk in place (on a treadmill) the travel that their standing feet show, and lower hovering persons and animals
  /// to the floor.
  bool travel = false;
  bool motion_of_parts = false;  ///< keep the motion of a file that moves rigid parts, but no limbs; by default, such a file is a mesh
  bool correct_labels = false;   ///< exchange marker labels that are exchanged in the whole recording
  /// Bytes and name of the file that a motion needs in addition: .npz of the body model (SMPL), .osim (OpenSim), character (DeepMimic).
  std::string model, model_name;
  formats::GltfFiles files;           ///< reads external buffers of a .gltf file; null: such files are rejected
  robot_formats::RobotOptions robot;  ///< options for URDF, SDF, MJCF
  std::function<bool()> cancelled;    ///< called before each step and each motion; true ends the import with ErrorCode::cancelled
};

/// An imported file that is not stored yet.
struct Intake {
  std::string source;                              ///< the file's name
  std::optional<MarkerMotion> markers;             ///< C3D, TRC: as recorded
  std::optional<MeasuredMotion> measured;          ///< motion formats (the first motion of several)
  std::optional<body::Body> body;                  ///< motion formats (the first motion of several)
  std::optional<Motion> motion;                    ///< motion formats (the first motion of several)
  std::optional<robot_formats::RobotModel> robot;  ///< URDF, SDF, MJCF
  MechanismPtr mechanism;                          ///< mechanism of the body, or of the file
  std::optional<MeshBody> mesh;                    ///< files with a mesh and without a skeleton
  double metres_per_unit = 0;                      ///< m, unit of length that was used; 0: the file has none
  bool walks_in_place = false;  ///< a motion of the file is a walk on a treadmill; IntakeOptions::travel moves it over the floor
  bool unit_guessed = false;    ///< neither the file nor the caller specified the unit
  Orientation axes = usual_orientation(true);  ///< up and forward axes of the file's space that were used
  std::vector<std::string> characters;         ///< root joints of the characters in the file, if there are several
  std::vector<std::string> takes;              ///< names of the motions in the file, if there are several
  std::vector<std::string> report;             ///< sentences for display
  ConversionReport conversion;                 ///< the same sentences by category, and a description of the file's contents
  std::vector<store::LibraryItem> items;  ///< library entries: first the mechanism, then for each motion the measured and the converted one
  /// Library id of the first item of this kind; empty if there is none.
  [[nodiscard]] std::string id_of(store::EntryKind kind) const;
};

/// Kinds of files that can be imported.
enum class FileKind { bvh, amc, asf, c3d, trc, csv, gltf, scene, usd, mvnx, smpl, opensim, deepmimic, mechanism_json, robot, mesh };
/// Kind from the file name's extension, ignoring case; std::nullopt for other extensions.
[[nodiscard]] std::optional<FileKind> file_kind(std::string_view file_name);

/// Name of the skeleton file that belongs to an AMC file: "12_01.amc" -> "12.asf"; without underscore "x.amc" -> "x.asf".
[[nodiscard]] std::string skeleton_name_for(std::string_view amc_name);

/// Reads a file and makes its library entries.
/// @param file_name determines the kind and begins the location of every problem
/// @param asf the skeleton, required for AMC files; otherwise null
/// Errors: those of the reader and of make_body or solve_markers; unknown extension; invalid axes; cancelled.
[[nodiscard]] Result<Intake> take_in(std::string_view bytes, std::string_view file_name, const formats::Asf* asf = nullptr,
                                     const IntakeOptions& options = {});

/// Reads the markers of a C3D, TRC or CSV file, with the labels that options.mapping gives them.
/// Errors: those of the reader; another kind of file; the mapping renames labels that the file does not have, or two markers alike.
[[nodiscard]] Result<MarkerMotion> read_markers(std::string_view bytes, std::string_view file_name, const IntakeOptions& options,
                                                formats::ReadNotes& notes);

/// Stores all items or none.
/// @return ids in the order of the items
[[nodiscard]] Result<std::vector<std::string>> put(store::Library& library, const Intake& intake);

}  // namespace ugoki::intake
