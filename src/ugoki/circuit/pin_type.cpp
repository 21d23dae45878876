#include "ugoki/circuit/pin_type.h"

#include "ugoki/base/check.h"

namespace ugoki::circuit {
namespace {

constexpr PinType types[] = {
    {PinTypeId::scalar, "scalar", "#7dd3fc", 0, 8, 1, true, "One number."},
    {PinTypeId::vector, "vector", "#a7f3d0", 0, 24, 1, true, "x, y, z."},
    {PinTypeId::rotation, "rotation", "#f0abfc", 0, 32, 1, true, "Unit quaternion w, x, y, z."},
    {PinTypeId::pose, "pose", "#e9d5ff", 0, 56, 1, true, "Position x, y, z and unit quaternion w, x, y, z."},
    {PinTypeId::joint_values, "joint values", "#fcd34d", 0, 8, 0, true,
     "One number for each coordinate or degree of freedom of a mechanism."},
    {PinTypeId::state, "state", "#fda4af", 0, 8, 0, true, "Positions and velocities of every mechanism of the world."},
    {PinTypeId::contacts, "contacts", "#fdba74", 8, 128, 0, false, "Points at which links touch each other or the ground, with forces."},
    {PinTypeId::motion, "motion", "#c4b5fd", 0, 8, 0, true,
     "Reference motion of a mechanism: positions, velocities, accelerations, stance."},
    {PinTypeId::event, "event", "#f87171", 8, 128, 32, false, "Events of this tick: pushes, grabs, throws."},
};

}  // namespace

std::span<const PinType> pin_types() { return types; }

const PinType& pin_type(PinTypeId id) {
  const auto i = static_cast<std::size_t>(id) - 1;
  UGOKI_CHECK(i < std::size(types));
  return types[i];
}

const PinType* find_pin_type(std::string_view name) {
  for (const PinType& t : types)
    if (t.name == name) return &t;
  return nullptr;
}

std::size_t payload_bytes(const PinType& type, std::uint32_t count) {
  const std::size_t bytes = type.header_bytes + static_cast<std::size_t>(type.element_bytes) * count;
  return (bytes + 7) / 8 * 8;
}

}  // namespace ugoki::circuit
