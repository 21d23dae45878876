#include "ugoki/lsi/standard_library.h"

#include "ugoki/circuit/signal_lsis.h"
#include "ugoki/lsi/declare.h"
#include "ugoki/lsi/motion_lsi.h"

namespace ugoki::lsi {

const circuit::Library& standard_library() {
  static const circuit::Library library = [] {
    circuit::Library all;
    circuit::add_signal_lsis(all);
    add_event(all);
    add_retrieval(all);
    add_choice(all);
    add_rules(all);
    add_grip_rule(all);
    add_variables(all);
    add_interpolation(all);
    add_control(all);
    add_balance(all);
    add_motion_torques(all);
    add_grip(all);
    add_collision(all);
    add_dynamics(all);
    add_status(all);
    add_motion_operations(all);
    add_intermediate_motion(all);
    add_motion_retarget(all);
    add_naturalness(all);
    add_display(all);
    add_maths(all);
    add_rotations_and_poses(all);
    add_mechanics(all);
    add_link_dynamics(all);
    add_motor(all);
    add_distance(all);
    return all;
  }();
  return library;
}

}  // namespace ugoki::lsi
