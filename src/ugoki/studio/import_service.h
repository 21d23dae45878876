#pragma once
// Imports in two steps: a file is read and shown first, and stored when somebody has looked at it.

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "ugoki/base/result.h"
#include "ugoki/formats/asf.h"
#include "ugoki/intake/intake.h"

namespace ugoki::studio {

/// How the user takes a file; empty texts and zeros: as the reader does.
struct ImportSettings {
  double unit = 0;          ///< m per unit of length of the file
  std::string up, forward;  ///< "x", "-x" ... of the file's space; both or none
  double rate = 0;          ///< frames a second
};

/// Has a connection of its own to the library; one thread at a time.
class ImportService {
 public:
  explicit ImportService(std::string library_path) : path_(std::move(library_path)) {}

  /// Takes a file that others need: a skeleton (ASF), a mesh, a buffer of a .gltf. @return "{}"
  [[nodiscard]] Result<std::string> companion(std::string_view file_name, std::string bytes);
  /// Reads a file. Nothing is stored. @return what docs/studio-protocol.md says of /api/import/stage
  [[nodiscard]] Result<std::string> stage(std::string_view file_name, std::string bytes, const ImportSettings& settings);
  /// Reads it again with other settings; the stage keeps what it was where that fails.
  [[nodiscard]] Result<std::string> stage_again(std::string_view id, const ImportSettings& settings);
  /// Puts all entries of a stage into the library, or none, and ends the stage.
  /// @param name of the entries; empty: as shown @return {"entries": [{"id", "kind", "name"}]}
  [[nodiscard]] Result<std::string> store(std::string_view id, std::string_view name, const std::vector<std::string>& tags);
  /// Ends a stage; one that is not there is no error.
  void drop(std::string_view id) { stages_.erase(std::string(id)); }

 private:
  struct Stage {
    std::uint64_t number = 0;
    std::string file, bytes;
    intake::Intake intake;
  };
  [[nodiscard]] Result<intake::Intake> read(const std::string& file, const std::string& bytes, const ImportSettings& settings) const;
  [[nodiscard]] Result<const formats::Asf*> skeleton_for(const std::string& file) const;
  [[nodiscard]] Result<Stage*> find(std::string_view id);
  void make_room(std::size_t bytes);

  std::string path_;
  std::uint64_t next_ = 1;
  std::map<std::string, Stage, std::less<>> stages_;
  std::map<std::string, formats::Asf, std::less<>> skeletons_;  ///< by file name in lower case
  std::string last_skeleton_;
  std::map<std::string, std::string, std::less<>> companions_;  ///< bytes by file name in lower case, without folders
};

/// A human of `height` [m] who stands at ease on the origin and looks along X, as GET /api/mechanism/ID would answer: the
/// measure beside what is imported.
[[nodiscard]] Result<std::string> reference_figure_json(double height);

}  // namespace ugoki::studio
