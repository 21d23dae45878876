#pragma once
// Pin types: the kinds of values that wires carry, and their memory layout.
//
// The payload of a pin (the value in memory) is `header_bytes` followed by `count` elements of `element_bytes`, 8-byte aligned. `count` is
// fixed by the type (1 for a scalar), or resolved for each pin when the circuit is built (for example for the joint values of a mechanism).

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

namespace ugoki::circuit {

/// Type of the values at a pin. The numbers are part of the binary interface of plug-ins: do not change them.
enum class PinTypeId : std::uint16_t {
  scalar = 1,        ///< one f64
  vector = 2,        ///< three f64: x, y, z
  rotation = 3,      ///< four f64: unit quaternion w, x, y, z
  pose = 4,          ///< f64 position x, y, z, unit quaternion w, x, y, z
  joint_values = 5,  ///< one f64 for each coordinate or DOF of one mechanism
  state = 6,         ///< f64 positions q and velocities v of every mechanism of the world
  contacts = 7,      ///< u64 number of records in use, then records of 128 bytes
  motion = 8,        ///< f64 reference motion of one mechanism: q, v, a and more (lsi/payload.h)
  event = 9,         ///< u64 number of records in use, then records of 128 bytes
};

struct PinType {
  PinTypeId id = PinTypeId::scalar;
  std::string_view name;   ///< name for users, for example "joint values"
  std::string_view color;  ///< colour in editors, "#rrggbb"
  std::uint32_t header_bytes = 0;
  std::uint32_t element_bytes = 8;
  std::uint32_t default_count = 1;  ///< number of elements of a pin that declares none; 0: resolved when the circuit is built
  bool numeric = true;              ///< true: f64 only, so that the payload can be plotted, checked to be finite, or given as fixed value
  std::string_view doc;
};

/// All pin types, in the order of their ids.
[[nodiscard]] std::span<const PinType> pin_types();
[[nodiscard]] const PinType& pin_type(PinTypeId id);
[[nodiscard]] const PinType* find_pin_type(std::string_view name);

/// Bytes of a payload of `count` elements, a multiple of 8.
[[nodiscard]] std::size_t payload_bytes(const PinType& type, std::uint32_t count);

}  // namespace ugoki::circuit
