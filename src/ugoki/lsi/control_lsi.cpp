// Motion control: drive torques and root assist that make a character follow its reference.

#include "ugoki/control/motion_control.h"
#include "ugoki/lsi/declare.h"
#include "ugoki/lsi/track_sampler.h"

namespace ugoki::lsi {
namespace {

struct Control {
  const World* world;
  const Character* character;
  ReferenceLayout layout;
  control::MotionControl control;
  std::vector<collision::ContactPoint> contacts;
};
struct ControlMemory {
  control::ControlState now, next;
};

std::int32_t step(const Call* call) {
  auto& self = object_of<Control>(call);
  auto& memory = *static_cast<ControlMemory*>(call->state);
  const Mechanism& m = *self.character->mechanism;
  const double* state = circuit::input(call, 0);
  const double* reference = circuit::input(call, 1);
  self.contacts.clear();
  for (const ContactRecord& c : records<ContactRecord>(call->in[2]))
    if (c.point.system_a == self.character->index || c.point.system_b == self.character->index)
      self.contacts.push_back(self.world->on_ground(c.point, self.character->index));
  control::ControlInput in;
  in.q = q_of(*self.character, state);
  in.v = v_of(*self.character, state);
  in.q_ref = {reference, self.layout.nq};
  in.v_ref = {reference + self.layout.v(), self.layout.nv};
  in.a_ref = {reference + self.layout.a(), self.layout.nv};
  in.contacts = self.contacts;
  in.system = self.character->index;
  in.dt = call->tick->dt;
  in.known = &self.world->kinematics().at(call->tick->index, self.character->index);
  double* drive = circuit::output(call, 0);
  const std::size_t nv = self.layout.nv;
  const std::span<double> tau(drive, nv);
  memory.next = memory.now;
  const control::ControlOutput out = self.control.step(in, memory.next, tau, {drive + nv, nv}, {drive + 2 * nv, nv});

  const Joint& root = m.link(0).joint;
  if (root.type == JointType::floating) {
    // The assist as forces on the root's DOFs: the moment in the axes of the root link, the force in the axes of the root's joint.
    const Vec3 moment = transpose_times(root.X_PJ.R * joint_pose(root, in.q.data()).R, out.assist.w);
    const Vec3 force = transpose_times(root.X_PJ.R, out.assist.v);
    for (int k = 0; k < 3; ++k) {
      tau[static_cast<std::size_t>(k)] += moment[k];
      tau[static_cast<std::size_t>(k + 3)] += force[k];
    }
  }
  double* force = circuit::output(call, 1);
  double* moment = circuit::output(call, 2);
  double* report = circuit::output(call, 3);
  for (int k = 0; k < 3; ++k) {
    const auto i = static_cast<std::size_t>(k);
    force[i] = report[report_force + i] = out.assist.v[k];
    moment[i] = report[report_moment + i] = out.assist.w[k];
  }
  report[report_ratio] = out.ratio;
  report[report_size] = out.size_bw;
  report[report_released] = out.released ? 1 : 0;
  const double weight = m.mass() * norm(self.control.options().gravity);
  report[report_force_size] = weight > 0 ? norm(out.assist.v) / weight : 0;
  return 0;
}

void* make(Setup& s) {
  const Character* character = character_of(s);
  const World* world = world_of(s);
  control::ControlOptions options;
  options.tracking = s.number("tracking");
  options.balance = s.number("balance");
  options.assist_limit = s.number("assist limit");
  options.joint_frequency = s.number("joint frequency");
  options.root_frequency = s.number("root frequency");
  options.patience = s.number("patience");
  options.gravity = world->gravity();
  auto* self = new Control{world,
                           character,
                           reference_layout(*character->mechanism, character->feet.size()),
                           control::MotionControl(character->mechanism, options),
                           {}};
  self->contacts.reserve(world->contact_capacity());
  return self;
}

}  // namespace

void add_control(circuit::Library& library) {
  const control::ControlOptions usual;
  circuit::LsiClass c;
  c.name = "motion control";
  c.doc =
      "Computes joint torques that make a character follow its reference on its own feet, and the root assist (an external force on the "
      "root) for the rest. A character that has fallen or lost its reference is released and becomes a ragdoll.";
  c.inputs = {input_pin("state", PinTypeId::state, "", "Positions and velocities now."),
              input_pin("reference", PinTypeId::motion, "", "Reference motion of the character at this tick."),
              input_pin("contacts", PinTypeId::contacts, "", "Contact points; those of the character with the ground support it.")};
  c.outputs = {
      output_pin("torque", PinTypeId::joint_values, "N m, N",
                 "For all degrees of freedom: forces (on the root: the root assist), then servo gains, then servo velocities."),
      output_pin("assist force", PinTypeId::vector, "N", "Force of the root assist, in world axes."),
      output_pin("assist moment", PinTypeId::vector, "N m", "Moment of the root assist about the origin of the root link, in world axes."),
      output_pin("report", PinTypeId::joint_values, "",
                 "Ten numbers about the root assist: force (3), moment (3), wanted assist / limit, applied assist in body "
                 "weights, 1 if released, applied force in body weights.")};
  c.parameters = {character_parameter(),
                  number_parameter("tracking", usual.tracking, 0, 2, "", "Factor on the gains of the joints."),
                  number_parameter("balance", usual.balance, 0, 2, "", "Factor on the gains of the root."),
                  number_parameter("assist limit", usual.assist_limit, 0, 10, "body weights",
                                   "Maximum root assist; a character that needs more lags behind its reference."),
                  number_parameter("joint frequency", usual.joint_frequency, 0, 500, "rad/s",
                                   "Rate at which the error of a joint decays, for a person; of smaller characters, errors decay faster."),
                  number_parameter("root frequency", usual.root_frequency, 0, 500, "rad/s",
                                   "Rate at which the error of the root decays, for a person; also used for the joints that carry it."),
                  number_parameter("patience", usual.patience, 0.001, 100, "s",
                                   "Averaging time of the departure from the reference; a larger value delays the release.")};
  c.configure = [](Setup& s) {
    const Character* character = character_of(s);
    if (!character) return;
    check_subject(s, 1, "reference", *character);
    s.set_out(0, 3 * static_cast<std::uint32_t>(character->mechanism->nv()), character->index);
    s.set_out(1, 1, character->index);
    s.set_out(2, 1, character->index);
    s.set_out(3, report_count, character->index);
    s.set_state(sizeof(ControlMemory));
  };
  c.make = make;
  c.destroy = destroy<Control>;
  c.step = step;
  c.advance = [](const Call* call) -> std::int32_t {
    auto& memory = *static_cast<ControlMemory*>(call->state);
    memory.now = memory.next;
    return 0;
  };
  library.add(std::move(c));
}

}  // namespace ugoki::lsi
