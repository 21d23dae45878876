#pragma once
// Functions that shorten the declarations of this module's LSIs (function blocks of a circuit).

#include <string>
#include <utility>

#include "ugoki/circuit/library.h"
#include "ugoki/circuit/setup.h"
#include "ugoki/lsi/world.h"

namespace ugoki::lsi {

using circuit::Call;
using circuit::PinTypeId;
using circuit::Setup;

[[nodiscard]] circuit::InputPin input_pin(std::string name, PinTypeId type, std::string unit, std::string doc);
[[nodiscard]] circuit::OutputPin output_pin(std::string name, PinTypeId type, std::string unit, std::string doc);
[[nodiscard]] circuit::Parameter number_parameter(std::string name, double initial, double minimum, double maximum, std::string unit,
                                                  std::string doc);
/// Returns the declaration of the parameter `character`: the id of the character that an LSI works on.
[[nodiscard]] circuit::Parameter character_parameter();

/// Returns the content's resource World. If there is none: reports a problem and returns null.
[[nodiscard]] const World* world_of(Setup& setup);
/// Returns the character that the parameter `character` names. If there is none: reports a problem and returns null.
[[nodiscard]] const Character* character_of(Setup& setup);
/// Reports a problem if the payload wired to input `pin` belongs to another character.
void check_subject(Setup& setup, std::size_t pin, const std::string& pin_name, const Character& character);

/// Implements LsiClass::destroy for an object of type T that was created with new.
template <class T>
void destroy(void* object) {
  delete static_cast<T*>(object);
}
/// Returns the object that `make` of the LSI created.
template <class T>
T& object_of(const Call* call) {
  return *static_cast<T*>(call->object);
}

void add_event(circuit::Library& library);
void add_retrieval(circuit::Library& library);
void add_choice(circuit::Library& library);
void add_rules(circuit::Library& library);
void add_grip_rule(circuit::Library& library);
void add_variables(circuit::Library& library);
void add_interpolation(circuit::Library& library);
void add_control(circuit::Library& library);
void add_grip(circuit::Library& library);
void add_motion_torques(circuit::Library& library);
void add_balance(circuit::Library& library);
void add_collision(circuit::Library& library);
void add_dynamics(circuit::Library& library);
void add_status(circuit::Library& library);
void add_naturalness(circuit::Library& library);
void add_display(circuit::Library& library);
void add_maths(circuit::Library& library);
void add_rotations_and_poses(circuit::Library& library);
void add_mechanics(circuit::Library& library);
void add_link_dynamics(circuit::Library& library);
void add_motor(circuit::Library& library);
void add_distance(circuit::Library& library);

}  // namespace ugoki::lsi
