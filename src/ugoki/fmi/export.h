#pragma once
// A circuit as an FMU, for Simulink, Modelica and other tools. Needs no compiler: the binary is the same for all circuits.

#include <string>
#include <string_view>
#include <vector>

#include "ugoki/base/result.h"
#include "ugoki/circuit/circuit.h"
#include "ugoki/circuit/library.h"
#include "ugoki/circuit/resources.h"

namespace ugoki::fmi {

struct ExportRequest {
  int version = 3;          ///< 2 or 3
  double dt = 0.001;        ///< s, between ticks of the circuit
  std::string_view binary;  ///< bytes of the shared object that runs circuits (apps/fmu), for this system
  /// Bytes of the content (*.ugx) whose mechanisms and motions the LSIs work on, and what its characters are to them; empty and null: there
  /// is none, and only signal LSIs may be used. `binary` must be that for content then.
  std::string_view content = {};
  const circuit::Resources* resources = nullptr;
};

struct Exported {
  std::string bytes;                                     ///< the *.fmu
  std::string identifier;                                ///< its modelIdentifier
  std::vector<std::string> inputs, outputs, parameters;  ///< names of its variables
  std::vector<std::string> notes;                        ///< pins that are left out
};

/// Made of signal LSIs, those that work on the given content, and nested circuits. Errors: what keeps the circuit from running; LSIs that
/// need content where there is none; LSIs of installed libraries, whose native code is not packed.
/// @param library the program's own LSIs @param installed declarations of those that the user has installed
[[nodiscard]] Result<Exported> export_fmu(const circuit::Circuit& circuit, const circuit::Library& library,
                                          const std::vector<circuit::LsiClass>& installed, const ExportRequest& request);

/// Files inside of the FMU.
inline constexpr std::string_view circuit_file = "circuit.json";
inline constexpr std::string_view content_file = "content.ugx";  ///< of FMUs with content
inline constexpr std::string_view run_file = "run.json";         ///< {"dt": s, "token": "{...}"}

}  // namespace ugoki::fmi
