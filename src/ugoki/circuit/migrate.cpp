#include "ugoki/circuit/migrate.h"

#include "ugoki/circuit/circuit.h"

namespace ugoki::circuit {

std::span<const Migration> migrations() {
  static_assert(circuit_version == 1, "add the step from the version before");
  return {};
}

void migrate(json::Json& circuit, std::int64_t version, std::span<const Migration> steps) {
  for (std::size_t k = static_cast<std::size_t>(version - 1); k < steps.size(); ++k) steps[k](circuit);
  circuit["version"] = steps.size() + 1;
}

}  // namespace ugoki::circuit
