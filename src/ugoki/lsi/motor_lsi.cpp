// Motor: force and servo on one degree of freedom, for robots and mechanisms whose other joints are free.

#include <algorithm>

#include "ugoki/lsi/declare.h"

namespace ugoki::lsi {
namespace {

circuit::InputPin optional(std::string name, PinTypeId type, std::string unit, std::string doc) {
  circuit::InputPin pin = input_pin(std::move(name), type, std::move(unit), std::move(doc));
  pin.required = false;
  return pin;
}

/// Index in v of the degree of freedom that the parameters name; -1 after a problem was reported.
int dof_of(Setup& s, const Character& who) {
  const Mechanism& m = *who.mechanism;
  const int link = s.text("link").empty() ? 0 : m.find_link(s.text("link"));
  const int dof = static_cast<int>(s.number("dof"));
  if (link < 0) {
    s.fail(ErrorCode::unknown, "'" + who.id + "' has no link '" + s.text("link") + "'.", "Use the name of one of its links.");
    return -1;
  }
  if (dof >= m.link(link).joint.nv()) {
    s.fail(ErrorCode::range,
           "The joint of link '" + m.link(link).name + "' has " + std::to_string(m.link(link).joint.nv()) + " degrees of freedom.",
           "Set `dof` to a smaller number, from 0.");
    return -1;
  }
  return m.link(link).v_index + dof;
}

void configure_motor(Setup& s) {
  const Character* who = character_of(s);
  if (!who || dof_of(s, *who) < 0) return;
  const auto nv = static_cast<std::uint32_t>(who->mechanism->nv());
  check_subject(s, 3, "torque", *who);
  if (const std::uint32_t count = s.in(3).count; count != 0 && count != nv && count != 3 * nv)
    s.fail(
        ErrorCode::structure,
        "'" + who->id + "' has " + std::to_string(nv) + " degrees of freedom; the wired torque has " + std::to_string(count) + " numbers.",
        "Wire the torque of another LSI `motor` or of motion control.");
  s.set_out(0, 3 * nv, who->index);
}

struct Motor {
  std::size_t nv, dof;
};

/// The payload has three blocks of nv numbers: forces, servo gains, servo velocities. Servos on the same DOF add: their gains add, and
/// the velocity is the mean weighted by the gains.
std::int32_t step_motor(const Call* call) {
  const auto& self = object_of<Motor>(call);
  double* const out = circuit::output(call, 0);
  std::fill(out, out + 3 * self.nv, 0.0);
  if (const double* in = circuit::input(call, 3)) std::copy(in, in + std::min<std::size_t>(call->in_count[3], 3 * self.nv), out);
  const double force = *circuit::input(call, 0), gain = *circuit::input(call, 1), velocity = *circuit::input(call, 2);
  if (gain < 0) return circuit::stop(call, "The servo gain is negative.");
  out[self.dof] += force;
  double &sum = out[self.nv + self.dof], &mean = out[2 * self.nv + self.dof];
  if (gain > 0) mean = (sum * mean + gain * velocity) / (sum + gain);
  sum += gain;
  return 0;
}

}  // namespace

void add_motor(circuit::Library& library) {
  circuit::LsiClass c;
  c.group = "mechanics";
  c.name = "motor";
  c.doc =
      "Drives one degree of freedom: a force, and a servo that adds the force gain * (velocity - v'), with v' the velocity at the end of "
      "the "
      "step. Motors of the same character are chained by their pins `torque`; the last one is wired to `dynamics`.";
  c.inputs = {optional("force", PinTypeId::scalar, "N m | N", "Force on the degree of freedom."),
              optional("gain", PinTypeId::scalar, "N m s | N s/m", "Gain of the servo; 0: no servo."),
              optional("velocity", PinTypeId::scalar, "rad/s | m/s", "Velocity that the servo wants."),
              optional("torque", PinTypeId::joint_values, "N m | N", "Torque of another motor; this motor is added to it.")};
  c.outputs = {
      output_pin("torque", PinTypeId::joint_values, "N m | N", "Forces, servo gains and servo velocities of all degrees of freedom.")};
  circuit::Parameter link = character_parameter();
  link.name = "link";
  link.doc = "Name of the link whose joint is driven; empty: the root.";
  circuit::Parameter dof = number_parameter("dof", 0, 0, 5, "", "Index of the degree of freedom in the joint, from 0.");
  dof.kind = circuit::ParameterKind::integer;
  dof.live = false;
  c.parameters = {character_parameter(), link, dof};
  c.configure = configure_motor;
  c.make = [](Setup& s) -> void* {
    const Character* who = character_of(s);
    const int dof = who ? dof_of(s, *who) : -1;
    return dof < 0 ? nullptr : new Motor{static_cast<std::size_t>(who->mechanism->nv()), static_cast<std::size_t>(dof)};
  };
  c.destroy = destroy<Motor>;
  c.step = step_motor;
  library.add(std::move(c));
}

}  // namespace ugoki::lsi
