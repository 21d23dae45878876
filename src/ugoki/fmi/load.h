#pragma once
// Loads an FMU (Functional Mock-up Unit: a simulation component in a zip file) as a library of LSIs. Its code is unpacked and started only
// when a circuit first uses the FMU.

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "ugoki/base/result.h"
#include "ugoki/circuit/lsi_class.h"
#include "ugoki/fmi/model_description.h"

namespace ugoki::fmi {

/// Callback that is called before foreign code runs, with a description ("The FMU 'ball.fmu' was being started"), and with an empty text
/// after it has returned. Crash reports use the description (plugin/guard.h).
using Phase = void (*)(std::string_view what);

/// An FMU loaded as a library of LSIs.
struct LoadedFmu {
  std::string name;                        ///< name of the library: the FMU's model identifier
  std::string version;                     ///< version of the model
  std::string doc;                         ///< description, and a line for each limitation of the import
  std::vector<circuit::LsiClass> classes;  ///< for an FMU named ball: "ball/ball"; with local variables also "ball/ball, all variables"
  std::shared_ptr<void> code;              ///< must outlive the use of the functions of `classes`
};

/// Reads an FMU. Errors (location: the path): those of Archive::open and read_model_description; an FMU without a binary for this system.
/// @param bytes the file's bytes @param hash SHA-256 of `bytes`; the code is read from `path` later, and must then have this hash
/// @param phase may be null
[[nodiscard]] Result<LoadedFmu> load_fmu(const std::string& path, std::string bytes, std::string hash, Phase phase);

/// Tests whether an FMU works: starts an instance, initialises it and ends it. Call it only in a process that may crash.
[[nodiscard]] Result<void> try_fmu(const std::string& path, std::string bytes, std::string hash, Phase phase);

/// Information about an FMU, read from its file without running its code.
struct FmuInfo {
  ModelDescription description;
  std::vector<std::string> notes;    ///< sentences for the user about variables without pin or parameter, and about other limitations
  std::vector<std::string> systems;  ///< names of the folders of its binaries: "x86_64-linux"
  bool runs_here = false;            ///< true: the FMU has a binary for this system
};
/// Reads an FMU without running its code. @param path for messages
[[nodiscard]] Result<FmuInfo> read_fmu_info(const std::string& path, std::string bytes);

}  // namespace ugoki::fmi
