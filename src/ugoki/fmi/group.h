#pragma once
// Conversion between the values of wires (double) and the types of an FMU, and groups of variables that one call sets or gets.
// Internal to fmi.

#include <cstddef>
#include <cstdint>
#include <vector>

#include "ugoki/fmi/declare.h"

namespace ugoki::fmi {

/// Writes x as a value of the storage type. Integers are rounded to the nearest one; for booleans, values above 0 are true, as in all LSIs.
/// @return false if x is out of the range of the type
[[nodiscard]] bool write(Storage storage, double x, std::byte* to);
/// Reads a value of the storage type; true is 1.
[[nodiscard]] double read(Storage storage, const std::byte* from);

/// Variables of one type, which one call of the FMU sets or gets.
struct Group {
  Storage storage = Storage::f64;
  std::vector<ValueReference> references;
  std::vector<PinBinding> pins;
  std::vector<std::uint64_t> memory;  ///< `count` values of the storage type, in the order of `references`; 8-byte aligned
  std::vector<std::uint64_t> given;   ///< discrete inputs: values that were last set in the FMU, laid out as `memory`
  std::size_t count = 0;              ///< number of values of all variables together

  [[nodiscard]] std::byte* bytes() { return reinterpret_cast<std::byte*>(memory.data()); }
  [[nodiscard]] std::size_t size() const { return count * bytes_of(storage); }  ///< size of all values, bytes
};

/// Sorts variables into groups by their storage type.
[[nodiscard]] std::vector<Group> group(const std::vector<PinBinding>& pins);

}  // namespace ugoki::fmi
