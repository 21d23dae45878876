#pragma once
// Variables of an FMU that travel together, and numbers on their way between wires (doubles) and the types of the FMU. Internal to fmi.

#include <cstddef>
#include <cstdint>
#include <vector>

#include "ugoki/fmi/declare.h"

namespace ugoki::fmi {

/// False: the number does not fit. Whole types take the nearest whole number; true is what is above 0, as for all LSIs.
[[nodiscard]] bool write(Storage storage, double x, std::byte* to);
[[nodiscard]] double read(Storage storage, const std::byte* from);

/// Variables of one type, which travel together.
struct Group {
  Storage storage = Storage::f64;
  std::vector<ValueReference> references;
  std::vector<PinBinding> pins;
  std::vector<std::uint64_t> memory;  // 8-byte aligned
  std::vector<std::uint64_t> given;   // of discrete inputs: what the FMU has been given last
  std::size_t count = 0;              // numbers

  [[nodiscard]] std::byte* bytes() { return reinterpret_cast<std::byte*>(memory.data()); }
  [[nodiscard]] std::size_t size() const { return count * bytes_of(storage); }
};

[[nodiscard]] std::vector<Group> group(const std::vector<PinBinding>& pins);

}  // namespace ugoki::fmi
