// Motion torques: the drive of torque-oriented motion data.

#include "ugoki/lsi/declare.h"
#include "ugoki/motion/torques.h"

namespace ugoki::lsi {
namespace {

struct Replay {
  const MotionTorques* torques;
  MotionPtr motion;  // owns the torques
};

std::int32_t step_torques(const Call* call) {
  const auto& self = object_of<Replay>(call);
  const std::size_t nv = self.torques->v0.size(), row = static_cast<std::size_t>(call->tick->index);
  const bool runs = row < self.torques->steps();
  double* const tau = circuit::output(call, 0);
  for (std::size_t i = 0; i < nv; ++i) tau[i] = runs ? self.torques->tau[row * nv + i] : 0;
  double* const report = circuit::output(call, 1);
  for (std::size_t i = 0; i < report_count; ++i) report[i] = 0;
  circuit::output(call, 2)[0] = runs ? 1 : 0;
  return 0;
}

void configure_torques(Setup& s) {
  const Character* const character = character_of(s);
  if (!character) return;
  if (!character->torques) {
    s.fail(ErrorCode::structure, "Character '" + character->id + "' of '" + s.id() + "' plays no torque-oriented motion.",
           "Set its control mode to \"torque\", or remove this LSI.");
    return;
  }
  s.set_out(0, static_cast<std::uint32_t>(character->mechanism->nv()), character->index);
  s.set_out(1, report_count, character->index);
}

}  // namespace

void add_motion_torques(circuit::Library& library) {
  circuit::LsiClass c;
  c.name = "motion torques";
  c.doc =
      "The torques of a character's torque-oriented motion, one row for each tick from time 0; zero after its last row. Together with the "
      "first state of the motion, they move the character without any control.";
  c.outputs = {output_pin("torque", PinTypeId::joint_values, "N m, N", "Forces on all degrees of freedom."),
               output_pin("report", PinTypeId::joint_values, "", "Ten zeros: the report of a drive without root assist."),
               output_pin("running", PinTypeId::scalar, "", "1 while the motion has torques, otherwise 0.")};
  c.parameters = {character_parameter()};
  c.configure = configure_torques;
  c.make = [](Setup& s) -> void* {
    const MotionPtr& motion = character_of(s)->torques;
    return new Replay{motion->torques.get(), motion};
  };
  c.destroy = destroy<Replay>;
  c.step = step_torques;
  library.add(std::move(c));
}

}  // namespace ugoki::lsi
