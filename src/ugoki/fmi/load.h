#pragma once
// An FMU as a library of LSIs. Reading it runs none of its code; that is unpacked and started when a circuit first uses it.

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "ugoki/base/result.h"
#include "ugoki/circuit/lsi_class.h"
#include "ugoki/fmi/model_description.h"

namespace ugoki::fmi {

/// Told what foreign code is about to do ("The FMU 'ball.fmu' was being started"), and with an empty text that it has come back.
using Phase = void (*)(std::string_view what);

struct LoadedFmu {
  std::string name;                        ///< its model identifier
  std::string version;                     ///< of the model
  std::string doc;                         ///< with what could not become a pin or parameter
  std::vector<circuit::LsiClass> classes;  ///< "ball/ball", and "ball/ball, all variables" where there are some inside
  std::shared_ptr<void> code;              ///< the functions of `classes` work as long as this
};

/// Errors (place: the path): as those of Archive and read_model_description; no binary for this system.
/// @param hash of `bytes`: the code is read from `path` later and must still be the same @param phase may be null
[[nodiscard]] Result<LoadedFmu> load_fmu(const std::string& path, std::string bytes, std::string hash, Phase phase);

/// Runs its code once: instance, initialisation, end. For a process that may end.
[[nodiscard]] Result<void> try_fmu(const std::string& path, std::string bytes, std::string hash, Phase phase);

/// What is in the FMU, without running it.
struct FmuInfo {
  ModelDescription description;
  std::vector<std::string> notes;    ///< what has no place in an LSI, and what to know
  std::vector<std::string> systems;  ///< folders of its binaries
  bool runs_here = false;
};
[[nodiscard]] Result<FmuInfo> read_fmu_info(const std::string& path, std::string bytes);

}  // namespace ugoki::fmi
