#pragma once
// Exports a circuit as an FMU, for Simulink, Modelica and other tools. No compiler is needed: every FMU contains the same binary
// (apps/fmu), which reads the circuit from the FMU's resources.

#include <string>
#include <string_view>
#include <vector>

#include "ugoki/base/result.h"
#include "ugoki/circuit/circuit.h"
#include "ugoki/circuit/library.h"
#include "ugoki/circuit/resources.h"

namespace ugoki::fmi {

/// Settings for exporting a circuit as an FMU.
struct ExportRequest {
  int version = 3;    ///< version of FMI: 2 or 3
  double dt = 0.001;  ///< time between two ticks of the circuit, s
  // Bytes of the shared objects that run circuits (apps/fmu), for this system. The smaller one that has the circuit's LSIs is packed.
  std::string_view signal_binary;  ///< bytes of ugoki_fmu, which has the signal LSIs only
  std::string_view full_binary;    ///< bytes of ugoki_fmu_content, which has all built-in LSIs
  /// Bytes of the content (*.ugx) whose mechanisms and motions the LSIs use; `resources` must be set too. Empty: no LSI uses content.
  std::string_view content = {};
  const circuit::Resources* resources = nullptr;  ///< objects of the same content, which LSIs request; null: no content
};

/// An exported FMU: its file and the names of its variables.
struct Exported {
  std::string bytes;                                     ///< bytes of the file *.fmu
  std::string identifier;                                ///< modelIdentifier of the FMU
  std::vector<std::string> inputs, outputs, parameters;  ///< names of the FMU's variables
  std::vector<std::string> notes;                        ///< sentences for the user about pins and parameters that are left out
};

/// Exports a circuit of built-in LSIs and nested circuits. The request must give content if an LSI uses it. Equal arguments give equal
/// bytes.
/// Errors: the circuit cannot be built; an LSI needs content and none is given; an LSI is of an installed library, whose native code is not
/// packed. @param library the program's own LSIs @param installed declarations of the installed LSIs, for error messages
[[nodiscard]] Result<Exported> export_fmu(const circuit::Circuit& circuit, const circuit::Library& library,
                                          const std::vector<circuit::LsiClass>& installed, const ExportRequest& request);

/// Names of the files in the FMU's folder resources.
inline constexpr std::string_view circuit_file = "circuit.json";
inline constexpr std::string_view content_file = "content.ugx";  ///< the content; only in FMUs with content
inline constexpr std::string_view run_file = "run.json";         ///< step and token as JSON: {"dt": s, "token": "{...}"}

}  // namespace ugoki::fmi
