// Fuzz target of circuits: the text, the canonical form, and building with the signal LSIs.
#include <string_view>

#include "fuzz_targets.h"
#include "ugoki/base/check.h"
#include "ugoki/circuit/interpreter.h"
#include "ugoki/circuit/signal_lsis.h"

namespace ugoki {
namespace {

void check_error(const Error& e) {
  UGOKI_CHECK(!e.problems.empty());
  for (const Problem& p : e.problems) UGOKI_CHECK(!p.location.empty() && p.message.ends_with('.') && !p.remedy.empty());
}

}  // namespace

void fuzz_circuit(const std::uint8_t* data, std::size_t size) {
  static const circuit::Library library = [] {
    circuit::Library l;
    circuit::add_signal_lsis(l);
    return l;
  }();
  const auto read = circuit::read_circuit({reinterpret_cast<const char*>(data), size}, "fuzz.json");
  if (!read) return check_error(read.error());
  const std::string text = circuit::write_circuit(*read);
  const auto back = circuit::read_circuit(text, "again.json");
  UGOKI_CHECK(back.has_value() && *back == *read && circuit::write_circuit(*back) == text);
  auto built = circuit::Interpreter::build(*read, library, nullptr, {.dt = 0.01});
  if (!built) return check_error(built.error());
  for (int tick = 0; tick < 3 && built->tick(); ++tick) {
  }
}

}  // namespace ugoki
