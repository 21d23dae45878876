// The binary of FMUs of signal LSIs alone.

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
  if (!bytes.empty()) why = "The FMU has content, but not the binary that runs it.";
  return nullptr;
}

}  // namespace ugoki::fmu
