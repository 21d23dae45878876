#pragma once
// All that came from outside while a circuit ran: with it a run can be repeated bit by bit, for example for a bug report.

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "ugoki/base/result.h"

namespace ugoki::circuit {

/// A new value, there before tick `tick` is computed.
struct InputChange {
  std::uint64_t tick = 0;
  std::string name;              ///< input of the circuit, "id.pin" of a device, or "id.parameter"
  int component = -1;            ///< of a parameter; -1: it is an input
  std::vector<std::byte> bytes;  ///< the whole payload, or one double
  friend bool operator==(const InputChange&, const InputChange&) = default;
};

struct InputRecord {
  std::uint64_t layout = 0;          ///< hash of the circuit that was recorded
  double dt = 0;                     ///< s
  std::uint64_t ticks = 0;           ///< done when the record was taken
  std::vector<InputChange> changes;  ///< by tick
  friend bool operator==(const InputRecord&, const InputRecord&) = default;
};

/// JSON, one change a line; numbers read back to the same bits (payloads that are not numbers are hexadecimal).
[[nodiscard]] std::string write_input_record(const InputRecord& record);
[[nodiscard]] Result<InputRecord> read_input_record(std::string_view text, std::string_view place = "record");

}  // namespace ugoki::circuit
