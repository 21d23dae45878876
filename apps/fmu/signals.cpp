// LSIs of the binary ugoki_fmu: signal LSIs only.

#include "session.h"
#include "ugoki/circuit/signal_lsis.h"

namespace ugoki::fmu {

const circuit::Library& packed_library() {
  static const circuit::Library library = [] {
    circuit::Library all;
    circuit::add_signal_lsis(all);
    return all;
  }();
  return library;
}

std::unique_ptr<circuit::Resources> packed_content(std::string_view bytes, std::string& why) {
  if (!bytes.empty()) why = "The FMU has content, but its binary supports signal LSIs only. Export the FMU again.";
  return nullptr;
}

}  // namespace ugoki::fmu
