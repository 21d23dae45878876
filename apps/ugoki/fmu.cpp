#include "fmu.h"

#include <filesystem>
#include <memory>
#include <optional>

#include "fmu_binary.h"
#include "output_files.h"
#include "ugoki/circuit/class_json.h"
#include "ugoki/content/player.h"
#include "ugoki/files/files.h"
#include "ugoki/fmi/export.h"
#include "ugoki/fmi/load.h"
#include "ugoki/lsi/standard_library.h"
#include "ugoki/plugin/shelf.h"
#include "verb.h"

namespace ugoki::cli {
namespace {

struct Options {
  std::string circuit, output, shelf, content;
  double dt = 0;
  int version = 3;
  bool json = false;
};

int run_export(const Options& o) {
  if (Result<void> may = check_outputs({{"the circuit", o.circuit}, {"--content", o.content}}, {{"the output", o.output}}); !may)
    return print_error(may.error(), o.json);
  const Result<std::string> text = files::read_file(o.circuit);
  if (!text) return print_error(text.error(), o.json);
  const Result<circuit::Circuit> circuit = circuit::read_circuit(*text, o.circuit + ":");
  if (!circuit) return print_error(circuit.error(), o.json);
  std::vector<circuit::LsiClass> installed;
  for (const plugin::ShelfEntry& e : plugin::read_shelf(o.shelf.empty() ? plugin::default_shelf() : o.shelf))
    installed.insert(installed.end(), e.classes.begin(), e.classes.end());
  fmi::ExportRequest request{
      .version = o.version, .dt = o.dt > 0 ? o.dt : 0.001, .signal_binary = fmu_binary(false), .full_binary = fmu_binary(true)};
  std::string bytes;
  std::optional<lsi::World> world;
  if (!o.content.empty()) {
    Result<std::string> read = files::read_file(o.content);
    if (!read) return print_error(read.error(), o.json);
    bytes = std::move(*read);
    const Result<content::Executable> content = content::read_executable(std::as_bytes(std::span(bytes)), o.content);
    if (!content) return print_error(content.error(), o.json);
    request.resources = &world.emplace(content::make_world(*content));
    request.content = bytes;
    if (!(o.dt > 0)) request.dt = content->step;
  }
  const Result<fmi::Exported> out = fmi::export_fmu(*circuit, lsi::standard_library(), installed, request);
  if (!out) return print_error(out.error(), o.json);
  if (Result<void> done = files::write_file(o.output, std::string_view(out->bytes)); !done) return print_error(done.error(), o.json);
  if (o.json) {
    print_json({{"output", o.output},
                {"fmi", o.version},
                {"model_identifier", out->identifier},
                {"bytes", out->bytes.size()},
                {"step_s", request.dt},
                {"inputs", out->inputs},
                {"outputs", out->outputs},
                {"parameters", out->parameters},
                {"notes", out->notes}});
    return 0;
  }
  for (const std::string& note : out->notes) print_line("note: " + note);
  print_line("Wrote " + o.output + " (FMI " + std::to_string(o.version) + ".0, " + std::to_string(out->inputs.size()) + " inputs, " +
             std::to_string(out->outputs.size()) + " outputs, " + std::to_string(out->parameters.size()) + " parameters).");
  return 0;
}

template <class T>
void add_number(Json& json, const char* name, const std::optional<T>& x) {
  if (x) json[name] = *x;
}

const char* word_of(fmi::Causality c) {
  constexpr const char* words[] = {"parameter", "calculated parameter", "structural parameter", "input", "output", "local", "independent"};
  return words[static_cast<std::size_t>(c)];
}

}  // namespace

Result<Json> fmu_info(const std::string& path) {
  Result<std::string> bytes = files::read_file(path);
  if (!bytes) return fail(std::move(bytes.error()));
  const Result<fmi::FmuInfo> info = fmi::read_fmu_info(path, std::move(*bytes));
  if (!info) return fail(info.error());
  const fmi::ModelDescription& d = info->description;
  Json out = {{"kind", "FMU"},
              {"name", d.name},
              {"fmi", d.written},
              {"model_identifier", d.identifier},
              {"systems", info->systems},
              {"runs_here", info->runs_here},
              {"saves_state", d.saves_state}};
  if (!d.description.empty()) out["description"] = d.description;
  if (!d.tool.empty()) out["made_by"] = d.tool;
  add_number(out, "start_s", d.experiment.start);
  add_number(out, "stop_s", d.experiment.stop);
  add_number(out, "step_s", d.experiment.step);
  add_number(out, "internal_step_s", d.internal_step);
  if (!info->notes.empty()) out["notes"] = info->notes;
  Json variables = Json::array();
  for (const fmi::Variable& v : d.variables) {
    if (v.causality == fmi::Causality::local || v.causality == fmi::Causality::independent) continue;
    std::string type(fmi::name_of(v.type, d.version));
    for (const std::uint64_t n : v.extent) type += "[" + std::to_string(n) + "]";
    variables.push_back({{"variable", v.name}, {"is", word_of(v.causality)}, {"type", type}, {"unit", v.unit}});
  }
  out["variables"] = std::move(variables);
  return out;
}

void add_export_fmu(Verb circuit_verb, Action& action) {
  auto options = std::make_shared<Options>();
  Verb sub = circuit_verb.add_subcommand("export-fmu", "Write a circuit as an FMU, for Simulink, Modelica and other tools.");
  sub.add_option("circuit", options->circuit, "The circuit, *.json").required();
  sub.add_option("output", options->output, "The FMU to write, *.fmu").required();
  sub.add_option("--fmi", options->version, "Version of the standard").check(one_of({2, 3})).capture_default_str();
  sub.add_option("--dt", options->dt, "Seconds between ticks of the circuit (default: the content's step, or 0.001)")
      .check(number_from(1e-9, 1e6));
  sub.add_option("--content", options->content, "Executable data (*.ugx), if LSIs of the circuit use mechanisms and motions");
  sub.add_option("--shelf", options->shelf, "Folder of installed libraries (default: $UGOKI_LSI or ~/.local/share/ugoki/lsi)");
  sub.add_flag("--json", options->json, "Print one JSON object");
  sub.footer("Example:\n  ugoki circuit export-fmu pendulum.json pendulum.fmu --fmi 2 --dt 0.002");
  sub.callback([options, &action] { action = [options] { return run_export(*options); }; });
}

}  // namespace ugoki::cli
