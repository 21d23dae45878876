// `ugoki export --fmu`: the whole content as an FMU.

#include <algorithm>

#include "export.h"
#include "fmu_binary.h"
#include "ugoki/content/player.h"
#include "ugoki/fmi/export.h"
#include "ugoki/lsi/standard_library.h"
#include "ugoki/plugin/shelf.h"
#include "ugoki/publish/fmu_circuit.h"

namespace ugoki::cli {

Result<std::string> make_content_fmu(std::span<const std::byte> ugx, const std::string& name, int version,
                                     std::vector<std::string>& notes) {
  const Result<content::Executable> content = content::read_executable(ugx, name);
  if (!content) return fail(content.error());
  const Result<circuit::Circuit> circuit = publish::make_fmu_circuit(*content, name);
  if (!circuit) return fail(circuit.error());
  std::vector<circuit::LsiClass> installed;
  for (const plugin::ShelfEntry& e : plugin::read_shelf(plugin::default_shelf()))
    installed.insert(installed.end(), e.classes.begin(), e.classes.end());
  const lsi::World world = content::make_world(*content);
  const fmi::ExportRequest request{.version = version,
                                   .dt = content->step,
                                   .signal_binary = fmu_binary(false),
                                   .full_binary = fmu_binary(true),
                                   .content = {reinterpret_cast<const char*>(ugx.data()), ugx.size()},
                                   .resources = &world};
  Result<fmi::Exported> out = fmi::export_fmu(*circuit, lsi::standard_library(), installed, request);
  if (!out) return fail(std::move(out.error()));
  notes = std::move(out->notes);
  return std::move(out->bytes);
}

}  // namespace ugoki::cli
