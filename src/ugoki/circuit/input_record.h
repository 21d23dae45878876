#pragma once
// Record of all inputs that a circuit received while it ran. Replaying it repeats the run bit for bit, for example for a bug report.

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "ugoki/base/result.h"

namespace ugoki::circuit {

/// A new value of an input, a device or a parameter, set before tick `tick` is computed.
struct InputChange {
  std::uint64_t tick = 0;
  std::string name;              ///< input of the circuit, "id.pin" of a device, or "id.parameter"
  int component = -1;            ///< parameter: index of the component; input or device: -1
  std::vector<std::byte> bytes;  ///< parameter: one double; input or device: the complete payload
  friend bool operator==(const InputChange&, const InputChange&) = default;
};

struct InputRecord {
  std::uint64_t layout = 0;          ///< hash of the circuit that was recorded
  double dt = 0;                     ///< time between two ticks, s
  std::uint64_t ticks = 0;           ///< number of ticks computed when the recording ended
  std::vector<InputChange> changes;  ///< all recorded changes, sorted by tick
  friend bool operator==(const InputRecord&, const InputRecord&) = default;
};

/// Writes the record as JSON text, one change per line. Numbers read back to the same bits. Payloads of up to 7 finite numbers are written
/// as numbers, all others as hexadecimal bytes.
[[nodiscard]] std::string write_input_record(const InputRecord& record);
[[nodiscard]] Result<InputRecord> read_input_record(std::string_view text, std::string_view location = "record");

}  // namespace ugoki::circuit
