#pragma once
// Imports files in two steps. First a file is read and shown to the user; the file and its result are called a stage. When the user
// confirms, the stage is stored in the library.

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "ugoki/base/result.h"
#include "ugoki/formats/asf.h"
#include "ugoki/intake/intake.h"

namespace ugoki::studio {

/// The user's settings for reading a file. An empty text or zero means: use what the file's reader specifies or guesses.
struct ImportSettings {
  double unit = 0;             ///< length of the file's unit, m
  std::string up, forward;     ///< axes of the file's coordinates: "x", "-x", "y" ...; set both or neither
  double rate = 0;             ///< frame rate, 1/s
  std::string mapping = {};    ///< JSON of an anatomy mapping that corrects the recognised limbs
  std::string character = {};  ///< selects one of several characters in the file: number from 1, or name of the root joint
  std::string take = {};       ///< selects one of several motions in the file: number from 1, or name
  bool travel = false;         ///< true: add the travel, computed from the feet, to a character that walks in place
};

/// Reads files and keeps them as stages until they are stored or dropped. To be used by one thread at a time.
class ImportService {
 public:
  /// Keeps a file to which later imports refer: a skeleton (ASF), a mesh or a buffer of a .gltf. @return "{}"
  [[nodiscard]] Result<std::string> companion(std::string_view file_name, std::string bytes);
  /// Reads a file and keeps it as a stage; the library is not changed. @return the answer of /api/import/stage (docs/studio-protocol.md)
  [[nodiscard]] Result<std::string> stage(std::string_view file_name, std::string bytes, const ImportSettings& settings);
  /// Reads a stage's file again with other settings. On failure the stage is unchanged.
  [[nodiscard]] Result<std::string> restage(std::string_view id, const ImportSettings& settings);
  /// Returns the entries of a stage for store(). The stage is kept until drop().
  /// @param name replaces the name of the first entry and of all entries with the same name; empty: the names of the stage are kept
  [[nodiscard]] Result<intake::Intake> prepare(std::string_view id, std::string_view name, const std::vector<std::string>& tags);
  /// Stores all entries in the library, or none after an error. Thread-safe. @return {"entries": [{"id", "kind", "name"}]}
  [[nodiscard]] static Result<std::string> store(const intake::Intake& intake, store::Library& library);
  /// Removes a stage; does nothing if it does not exist.
  void drop(std::string_view id) { stages_.erase(std::string(id)); }

 private:
  struct Stage {
    std::uint64_t number = 0;  ///< order of creation; the oldest stage is dropped first
    std::string file, bytes;
    intake::Intake intake;
  };
  [[nodiscard]] Result<intake::Intake> read(const std::string& file, const std::string& bytes, const ImportSettings& settings) const;
  [[nodiscard]] Result<const formats::Asf*> skeleton_for(const std::string& file) const;
  [[nodiscard]] Result<Stage*> find(std::string_view id);
  /// Drops all companion files, then the oldest stages, until `bytes` more bytes fit into the memory limit.
  void make_room(std::size_t bytes);

  std::uint64_t next_ = 1;
  std::map<std::string, Stage, std::less<>> stages_;
  std::map<std::string, formats::Asf, std::less<>> skeletons_;  ///< ASF skeletons, by file name in lower case
  std::string last_skeleton_;
  std::map<std::string, std::string, std::less<>> companions_;  ///< bytes of companion files, by file name in lower case without folders
};

/// JSON, as from mechanism_json, of a relaxed standing human of `height` [m] at the origin, facing +X. The page shows this human next to
/// an imported mechanism so that the user can check the scale.
[[nodiscard]] Result<std::string> reference_character_json(double height);

}  // namespace ugoki::studio
