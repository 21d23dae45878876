#include "ugoki/fmi/export.h"

#include <algorithm>

#include "ugoki/base/number.h"
#include "ugoki/base/sha256.h"
#include "ugoki/circuit/flatten.h"
#include "ugoki/circuit/setup.h"
#include "ugoki/circuit/signal_lsis.h"
#include "ugoki/fmi/archive.h"
#include "ugoki/fmi/describe.h"
#include "ugoki/fmi/interface.h"
#include "ugoki/json/json.h"

namespace ugoki::fmi {
namespace {

#if defined(__aarch64__)
constexpr const char* folder2 = "binaries/aarch64-linux/";
constexpr const char* folder3 = "binaries/aarch64-linux/";
#else
constexpr const char* folder2 = "binaries/linux64/";
constexpr const char* folder3 = "binaries/x86_64-linux/";
#endif

/// A C identifier of at most 60 characters, from the name of a circuit.
std::string identifier_of(const std::string& name) {
  std::string out;
  for (const char c : name) {
    const bool good = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9');
    if (good || (!out.empty() && out.back() != '_')) out += good ? c : '_';
  }
  while (!out.empty() && out.back() == '_') out.pop_back();
  if (out.empty()) out = "circuit";
  if (out[0] >= '0' && out[0] <= '9') out.insert(0, "c");
  return out.substr(0, 60);
}

/// Token in the form of a GUID: the first digits of a hash. @param content everything that determines the FMU's behaviour
std::string token_of(const std::string& content) {
  const std::string h = sha256(content);
  return "{" + h.substr(0, 8) + "-" + h.substr(8, 4) + "-" + h.substr(12, 4) + "-" + h.substr(16, 4) + "-" + h.substr(20, 12) + "}";
}

/// Stands in for content (mechanisms and motions) but has no objects. Records whether an LSI requested an object.
class NoContent : public circuit::Resources {
 public:
  const void* find(std::string_view, std::string_view) const override {
    requested = true;
    return nullptr;
  }
  mutable bool requested = false;
};

/// True if the LSI requests objects of content (mechanisms, motions). An LSI that uses content does so in `configure` or `make`.
bool uses_content(const circuit::FlatLsi& lsi, double dt) {
  const NoContent none;
  Error ignored;
  circuit::Setup setup(lsi.id, lsi.location, *lsi.lsi_class, lsi.parameters, &none, dt, ignored);
  if (lsi.lsi_class->configure) lsi.lsi_class->configure(setup);
  return none.requested;
}

/// Checks that all LSIs of the circuit are built in, and that there is content for those that use it.
/// @param only_signals [out] true if all LSIs are in `signals`
Result<void> check_lsis(const circuit::Circuit& circuit, const circuit::Library& library, const circuit::Library& signals,
                        const std::vector<circuit::LsiClass>& installed, const ExportRequest& request, bool& only_signals) {
  circuit::Library all = library;
  for (const circuit::LsiClass& c : installed)
    if (!all.has(c.name)) all.add(c);
  Error ignored, problems;
  for (const circuit::FlatLsi& lsi : circuit::flatten(circuit, all, ignored).lsis) {
    if (!lsi.lsi_class || lsi.id.starts_with("input:") || signals.has(lsi.lsi_class->name)) continue;
    only_signals = false;
    if (!lsi.lsi_class->from.empty())
      problems.add(ErrorCode::unsupported, lsi.location,
                   "'" + lsi.id + "' is of the installed library '" + lsi.lsi_class->from + "'. Its native code is not packed into an FMU.",
                   "Remove the LSI from the circuit and do its work in the other tool, or replace it by built-in LSIs.");
    else if (!request.resources && uses_content(lsi, request.dt))
      problems.add(
          ErrorCode::unsupported, lsi.location,
          "'" + lsi.id + "' (LSI '" + lsi.lsi_class->name + "') uses the mechanisms and motions of content, but no content was given.",
          "Give content with --content FILE.ugx; `ugoki run PROJECT --ugx FILE.ugx` writes it.");
  }
  if (!problems.empty()) return fail(std::move(problems));
  return {};
}

}  // namespace

Result<Exported> export_fmu(const circuit::Circuit& circuit, const circuit::Library& library,
                            const std::vector<circuit::LsiClass>& installed, const ExportRequest& request) {
  circuit::Library signals;
  circuit::add_signal_lsis(signals);
  bool only_signals = request.content.empty();
  if (Result<void> own = check_lsis(circuit, library, signals, installed, request, only_signals); !own) return fail(std::move(own.error()));
  const circuit::Library& packed = only_signals ? signals : library;
  Result<circuit::Interpreter> running = circuit::Interpreter::build(circuit, packed, request.resources, {.dt = request.dt});
  if (!running) return fail(std::move(running.error()));
  const Interface interface = make_interface(circuit, packed, *running);
  const std::string text = circuit::write_circuit(circuit);
  DescribeRequest description;
  description.version = request.version;
  description.dt = request.dt;
  description.identifier = identifier_of(circuit.name);
  description.token = token_of(text + to_text(request.dt) + std::to_string(request.version) + std::string(request.content));
  const std::string run = json::to_text(json::Json{{"dt", request.dt}, {"token", description.token}}, 1) + "\n";
  const std::string binary = (request.version == 2 ? folder2 : folder3) + description.identifier + ".so";
  std::vector<std::pair<std::string, std::string>> files = {
      {"modelDescription.xml", write_model_description(circuit, interface, description)},
      {binary, std::string(only_signals ? request.signal_binary : request.full_binary)},
      {"resources/" + std::string(circuit_file), text},
      {"resources/" + std::string(run_file), run}};
  if (request.resources) files.emplace_back("resources/" + std::string(content_file), request.content);
  Result<std::string> bytes = write_archive(files, circuit.name);
  if (!bytes) return fail(std::move(bytes.error()));
  Exported out;
  out.bytes = std::move(*bytes);
  out.identifier = description.identifier;
  out.notes = interface.notes;
  for (const InterfaceVariable& v : interface.variables) {
    if (v.role == InterfaceRole::input || v.role == InterfaceRole::device) out.inputs.push_back(v.name);
    if (v.role == InterfaceRole::output) out.outputs.push_back(v.name);
    if (v.role == InterfaceRole::parameter) out.parameters.push_back(v.name);
  }
  return out;
}

}  // namespace ugoki::fmi
