// Motion control: drive torques and root assist that make a character follow its reference.

#include "ugoki/control/motion_control.h"
#include "ugoki/lsi/declare.h"
#include "ugoki/lsi/track_sampler.h"

namespace ugoki::lsi {
namespace {

struct Control {
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
  for (const ContactRecord& c : records<ContactRecord>(call->in[2])) self.contacts.push_back(c.point);
  control::ControlInput in;
  in.q = q_of(*self.character, state);
  in.v = v_of(*self.character, state);
  in.q_ref = {reference, self.layout.nq};
  in.v_ref = {reference + self.layout.v(), self.layout.nv};
  in.a_ref = {reference + self.layout.a(), self.layout.nv};
  in.contacts = self.contacts;
  in.system = self.character->index;
  in.dt = call->tick->dt;
  double* drive = circuit::output(call, 0);
  const std::size_t nv = self.layout.nv;
  const std::span<double> tau(drive, nv);
  memory.next = memory.now;
  const control::ControlOutput out = self.control.step(in, memory.next, tau, {drive + nv, nv}, {drive + 2 * nv, nv});

  const Joint& root = m.link(0).joint;
  if (root.type == JointType::floating) {
    // the assist as forces on the root's own freedoms: angular ones in the link's axes, linear ones in the joint's
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
  report[report_let_go] = out.let_go ? 1 : 0;
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
  auto* self = new Control{character,
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
      "Joint torques that make a character follow its reference on its own feet, and the root assist that is still missing. Beyond the "
      "assist's limit it lets go.";
  c.inputs = {input_pin("state", PinTypeId::state, "", "Positions and velocities now."),
              input_pin("reference", PinTypeId::motion, "", "What the character shall do now."),
              input_pin("contacts", PinTypeId::contacts, "", "Where it touches the ground.")};
  c.outputs = {output_pin("torque", PinTypeId::joint_values, "N m, N",
                          "For all freedoms: forces (on the root's freedoms: the root assist), then servo gains, then servo velocities."),
               output_pin("assist force", PinTypeId::vector, "N", "Force of the root assist, world axes."),
               output_pin("assist moment", PinTypeId::vector, "N m", "Its moment about the root link's origin."),
               output_pin("report", PinTypeId::joint_values, "",
                          "Root assist in ten numbers: force, moment, wanted/cap, size in body weights, let go, force in body weights.")};
  c.parameters = {
      character_parameter(),
      number_parameter("tracking", usual.tracking, 0, 2, "", "Factor on the joints' gains."),
      number_parameter("balance", usual.balance, 0, 2, "", "Factor on the root's gains."),
      number_parameter("assist limit", usual.assist_limit, 0, 10, "body weights",
                       "Cap of the root assist; beyond it the character lets go."),
      number_parameter("joint frequency", usual.joint_frequency, 0, 500, "rad/s", "How fast an error of a joint decays."),
      number_parameter("root frequency", usual.root_frequency, 0, 500, "rad/s", "The same for the root and for joints that bear it."),
      number_parameter("patience", usual.patience, 0.001, 100, "s", "How long too much assist is put up with.")};
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
