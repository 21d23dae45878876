// Naturalness: all measures of module naturalness for one character of a simulation.

#include <algorithm>
#include <cmath>

#include "ugoki/lsi/declare.h"
#include "ugoki/lsi/track_sampler.h"
#include "ugoki/mechanism/state.h"
#include "ugoki/naturalness/meter.h"

namespace ugoki::lsi {
namespace {

using naturalness::MeasureId;

enum Input : std::size_t { in_state, in_reference, in_report, in_contacts, in_forces, in_applied };

/// m: a contact up to this far above the ground counts as touching.
constexpr double touching = 0.005;

/// Sums since the start of the run. Plain data.
struct Sums {
  double tracking = 0, tracking_count = 0;  // rad^2, sum of squared angles; number of summed joints
  double assist = 0, assist_force = 0;      // (body weights)^2, sums: squared root assist; square of its force alone
  double assist_count = 0;                  // number of summed samples of the root assist
  double assist_max = 0;                    // body weights
  double fell = 0;                          // 1: the character has fallen
  double release_time = -1;                 // s; -1: not released
  double last_time = -1;                    // s, time of the last sample; -1: none
};

struct Naturalness {
  const World* world;
  const Character* character;
  ReferenceLayout layout;
  naturalness::Meter meter;
  bool forces = false;                        // contact forces are wired
  bool applied = false;                       // drive forces are wired
  std::size_t dof_offset = 0;                 // index of the character's first number in the drive forces
  dynamics::KnownKinematics own;              // kinematics that no other LSI has left
  std::vector<Pose> reference_poses;          // [links]
  std::vector<std::uint8_t> stance;           // [feet] 1: the foot stands in the reference
  std::vector<std::uint8_t> stands, touches;  // [legs] 1: the foot stands in the reference; touches something
  std::vector<Vec3> leg_forces;               // [legs] N
  std::vector<double> error;                  // [nv] rad | m: difference between present position and reference
  std::vector<int> foot_of_link;              // [links] index of the foot (toes and heel are one foot); -1: none
  std::vector<std::uint8_t> bears;            // [feet] 1: the foot touches the ground now
  int foot_count = 0;
  /// m: height of the root above the lowest link in the neutral position; half of the height of all links if the root is on the floor
  double upright = 0;
};

/// Returns the sum [rad^2], over all joints that can rotate, of the squared angle between joint and reference. A floating root is left out.
/// @param count [in, out]  increased by the number of these joints
double squared_angles(const Mechanism& m, std::span<const double> error, double& count) {
  double sum = 0;
  for (const Link& link : m.links()) {
    const auto* e = error.data() + link.v_index;
    switch (link.joint.type) {
      case JointType::revolute:
      case JointType::helical:
      case JointType::cylindrical: sum += e[0] * e[0]; break;
      case JointType::universal: sum += e[0] * e[0] + e[1] * e[1]; break;
      case JointType::spherical: sum += e[0] * e[0] + e[1] * e[1] + e[2] * e[2]; break;
      case JointType::planar: sum += e[2] * e[2]; break;
      default: continue;
    }
    count += 1;
  }
  return sum;
}

/// Counts the feet that touch the ground; -1 if the character has no feet. A contact up to 5 mm above the ground counts as touching.
int count_feet(Naturalness& self, const void* contacts) {
  if (self.foot_count == 0) return -1;
  for (std::uint8_t& b : self.bears) b = 0;
  int feet = 0;
  for (const ContactRecord& c : records<ContactRecord>(contacts)) {
    if (c.point.system_a != self.character->index && c.point.system_b != self.character->index) continue;
    const collision::ContactPoint point = self.world->on_ground(c.point, self.character->index);
    if (point.system_a != self.character->index || point.system_b >= 0 || point.distance > touching) continue;
    const int foot = self.foot_of_link[static_cast<std::size_t>(point.link_a)];
    if (foot < 0 || self.bears[static_cast<std::size_t>(foot)]) continue;
    self.bears[static_cast<std::size_t>(foot)] = 1;
    ++feet;
  }
  return feet;
}

/// Contacts of the feet and of other links, and the forces on the feet. @return true: a link that is no foot touches something
bool read_contacts(Naturalness& self, const void* contacts) {
  std::ranges::fill(self.touches, std::uint8_t{0});
  std::ranges::fill(self.leg_forces, Vec3{});
  bool other = false;
  for (const ContactRecord& c : records<ContactRecord>(contacts)) {
    for (const bool first : {true, false}) {
      if ((first ? c.point.system_a : c.point.system_b) != self.character->index) continue;
      if (c.point.system_a == c.point.system_b) continue;  // two links of the character
      const bool touches = self.forces ? dot(c.force, c.force) > 0 : c.point.distance <= touching;
      if (!touches) continue;
      const int leg = self.meter.body().leg_of_link[static_cast<std::size_t>(first ? c.point.link_a : c.point.link_b)];
      if (leg < 0) {
        other = true;
        continue;
      }
      self.touches[static_cast<std::size_t>(leg)] = 1;
      self.leg_forces[static_cast<std::size_t>(leg)] += first ? c.force : -c.force;
    }
  }
  return other;
}

std::int32_t advance(const Call* call) {
  auto& self = object_of<Naturalness>(call);
  auto& sums = *static_cast<Sums*>(call->state);
  const Mechanism& m = *self.character->mechanism;
  const double* reference = circuit::input(call, in_reference);
  const double* report = circuit::input(call, in_report);
  const std::span<const double> q = q_of(*self.character, circuit::input(call, in_state));
  const std::span<const double> reference_q{reference, self.layout.nq};
  const bool released = report[report_released] > 0;
  const std::span<const double> v = v_of(*self.character, circuit::input(call, in_state));
  const dynamics::KnownKinematics* known = &self.world->kinematics().at(call->tick->index, self.character->index);
  if (known->find(q, v) == nullptr) {
    self.own.update(m, q, v);
    known = &self.own;
  }
  calc_poses(m, reference_q, self.reference_poses);
  difference(m, q, reference_q, self.error);
  double angles = 0, joints = 0;  // rad^2, sum of squared angles now; number of summed joints
  if (!released) {
    angles = squared_angles(m, self.error, joints);
    sums.tracking += angles;
    sums.tracking_count += joints;
    sums.assist += report[report_size] * report[report_size];
    sums.assist_force += report[report_force_size] * report[report_force_size];
    sums.assist_count += 1;
    sums.assist_max = std::max(sums.assist_max, report[report_size]);
  } else if (sums.release_time < 0) {
    sums.release_time = call->tick->time;
  }
  for (std::size_t k = 0; k < self.layout.feet; ++k) self.stance[k] = !released && reference[self.layout.stance() + k] > 0 ? 1 : 0;
  const std::vector<naturalness::Leg>& legs = self.meter.body().legs;
  for (std::size_t k = 0; k < legs.size(); ++k) {
    self.stands[k] = 0;
    for (const std::size_t slot : legs[k].foot_slots) self.stands[k] = self.stands[k] || self.stance[slot] ? 1 : 0;
  }
  naturalness::Sample s;
  s.dt = sums.last_time >= 0 ? call->tick->time - sums.last_time : 0;
  sums.last_time = call->tick->time;
  s.q = q;
  s.v = v;
  s.known = known;
  s.X_WB = known->values().X_WB;
  if (!released) s.reference = self.reference_poses;
  s.stance = self.stance;
  s.stands = self.stands;
  s.other_contact = read_contacts(self, call->in[self.forces ? in_forces : in_contacts]);
  s.touches = self.touches;
  if (self.forces) s.forces = self.leg_forces;
  if (self.applied) s.torque = {circuit::input(call, in_applied) + self.dof_offset, self.layout.nv};
  if (!released) {
    s.has_missing = true;
    const Vec3 force{report[report_force], report[report_force + 1], report[report_force + 2]};
    const Vec3 moment{report[report_moment], report[report_moment + 1], report[report_moment + 2]};
    s.missing_force = force;
    s.missing_moment = moment + cross(s.X_WB[0].p - centre_of_mass(m, s.X_WB), force);
  }
  self.meter.add(s);
  if (m.link(0).joint.type == JointType::floating) {
    // Fallen: the root is below its reference by more than 35 % of the standing height, or tilted from the reference by more than 1 rad.
    const double below = reference[2] - q[2];                                           // m, in the axes of the root joint
    const double tilt = self.error[0] * self.error[0] + self.error[1] * self.error[1];  // rad^2
    if (below > 0.35 * self.upright || tilt > 1.0) sums.fell = 1;
    self.meter.set(MeasureId::fall, sums.fell);
  }
  constexpr double degrees = 180 / pi;
  const auto root_mean = [](double sum, double count) { return count > 0 ? std::sqrt(sum / count) : 0.0; };
  const double tracking = degrees * root_mean(angles, joints), assist = released ? 0 : report[report_size];
  self.meter.set(MeasureId::tracking, tracking, joints);
  self.meter.set(MeasureId::assist, assist, released ? 0 : 1);

  double* out = circuit::output(call, 0);
  out[measure_tracking] = degrees * root_mean(sums.tracking, sums.tracking_count);
  out[measure_assist] = root_mean(sums.assist, sums.assist_count);
  out[measure_assist_force] = root_mean(sums.assist_force, sums.assist_count);
  out[measure_assist_max] = sums.assist_max;
  out[measure_skate] = self.meter.slip().mean_cm();
  out[measure_skate_worst] = self.meter.slip().worst_cm();
  out[measure_penetration] = self.meter.penetration().worst_mm();
  out[measure_penetration_rms] = self.meter.penetration().rms_mm();
  out[measure_fell] = sums.fell;
  out[measure_release_time] = sums.release_time;
  out[measure_feet] = count_feet(self, call->in[in_contacts]);
  out[measure_tracking_now] = tracking;
  out[measure_assist_now] = assist;
  out[measure_slip_now] = self.meter.slip().now_cm();
  out[measure_depth_now] = std::max(0.0, self.meter.now(MeasureId::penetration));
  for (std::size_t k = 0; k < naturalness::measure_count; ++k) {
    out[measure_totals + k] = self.meter.total(static_cast<MeasureId>(k));
    out[measure_values + k] = self.meter.now(static_cast<MeasureId>(k));
  }
  return 0;
}

naturalness::MeterOptions options_of(const World& world) {
  naturalness::MeterOptions options;
  options.gravity = norm(world.gravity());
  options.ground = world.ground().height;
  options.simulated = true;
  return options;
}

void* make(Setup& s) {
  const Character& c = *character_of(s);
  const World& world = *world_of(s);
  const Mechanism& m = *c.mechanism;
  auto* self = new Naturalness{&world,
                               &c,
                               reference_layout(m, c.feet.size()),
                               naturalness::Meter(m, options_of(world)),
                               false,
                               false,
                               0,
                               dynamics::KnownKinematics(m),
                               {},
                               {},
                               {},
                               {},
                               {},
                               {},
                               {},
                               {},
                               0,
                               0};
  self->forces = s.wires(in_forces) > 0;
  self->applied = s.wires(in_applied) > 0;
  for (const Character& other : world.characters())
    if (other.index < c.index) self->dof_offset += static_cast<std::size_t>(other.mechanism->nv());
  self->reference_poses.resize(static_cast<std::size_t>(m.link_count()));
  self->stance.resize(c.feet.size());
  self->stands.resize(self->meter.body().legs.size());
  self->touches = self->stands;
  self->leg_forces.resize(self->stands.size());
  self->error.resize(static_cast<std::size_t>(m.nv()));
  self->foot_of_link.assign(self->reference_poses.size(), -1);
  for (const int link : c.feet) {
    const int parent = m.link(link).parent;
    const int of_parent = parent < 0 ? -1 : self->foot_of_link[static_cast<std::size_t>(parent)];
    self->foot_of_link[static_cast<std::size_t>(link)] = of_parent >= 0 ? of_parent : self->foot_count++;
  }
  self->bears.resize(static_cast<std::size_t>(self->foot_count));
  calc_poses(m, m.neutral(), self->reference_poses);
  double low = self->reference_poses[0].p.z, high = low;
  for (const Pose& pose : self->reference_poses) {
    low = std::min(low, pose.p.z);
    high = std::max(high, pose.p.z);
  }
  self->upright = std::max(0.05, self->reference_poses[0].p.z - low);
  if (self->upright < 0.25 * (high - low)) self->upright = 0.5 * (high - low);  // rigs can have their root on the floor
  return self;
}

/// Returns the memory of the meter in the state, which follows the sums.
std::span<double> memory_of(const Call* call, const Naturalness& self) {
  return {reinterpret_cast<double*>(static_cast<std::byte*>(call->state) + sizeof(Sums)), self.meter.memory_size()};
}

void store(const Call* call) {
  const auto& self = object_of<Naturalness>(call);
  self.meter.save(memory_of(call, self));
}

void recall(const Call* call) {
  auto& self = object_of<Naturalness>(call);
  self.meter.restore(memory_of(call, self));
}

std::int32_t init(const Call* call) {
  auto& self = object_of<Naturalness>(call);
  *static_cast<Sums*>(call->state) = Sums{};
  self.meter.reset();
  double* out = circuit::output(call, 0);
  out[measure_release_time] = -1;
  out[measure_feet] = self.foot_count == 0 ? -1 : 0;
  for (std::size_t k = 0; k < naturalness::measure_count; ++k) out[measure_totals + k] = out[measure_values + k] = naturalness::no_value;
  return 0;
}

}  // namespace

void add_naturalness(circuit::Library& library) {
  circuit::LsiClass c;
  c.name = "naturalness";
  c.doc =
      "Measures of naturalness since the start and of the present instant: tracking error, root assist, sliding of standing feet, depth in "
      "the ground, falls, and all others of docs/naturalness.md. Set \"every\" so that it runs at about 120 Hz.";
  c.inputs = {input_pin("state", PinTypeId::state, "", "Positions and velocities now."),
              input_pin("reference", PinTypeId::motion, "", "Reference motion of the character at this tick."),
              input_pin("report", PinTypeId::joint_values, "", "Report of the character's motion control."),
              input_pin("contacts", PinTypeId::contacts, "", "Contact points now."),
              input_pin("forces", PinTypeId::contacts, "", "Contact points with forces, from dynamics; without: forces are not measured."),
              input_pin("applied", PinTypeId::joint_values, "N m, N",
                        "Drive forces of all characters, from dynamics; without: torques and work are not measured.")};
  c.inputs[in_forces].required = c.inputs[in_applied].required = false;
  for (circuit::InputPin& pin : c.inputs) pin.direct = false;
  c.outputs = {
      output_pin("measures", PinTypeId::joint_values, "", "Measures of the run and of the present instant; docs/circuit.md lists them.")};
  c.outputs[0].delayed = true;
  c.parameters = {character_parameter()};
  c.configure = [](Setup& s) {
    const Character* character = character_of(s);
    if (!character) return;
    check_subject(s, in_reference, "reference", *character);
    check_subject(s, in_report, "report", *character);
    s.set_out(0, measure_count, character->index);
    const World* world = world_of(s);
    if (!world) return;
    std::size_t dofs = 0;
    for (const Character& c : world->characters()) dofs += static_cast<std::size_t>(c.mechanism->nv());
    const std::uint32_t applied = s.in(in_applied).count;  // 0: not known yet
    if (applied != 0 && applied != World::payload_count(dofs))
      s.fail(ErrorCode::structure,
             "The wire into '" + s.id() + ".applied' has " + std::to_string(applied) + " numbers; it must have " + std::to_string(dofs) +
                 ", one for each degree of freedom of all characters.",
             "Wire the output `applied` of a dynamics LSI.");
    s.set_state(sizeof(Sums) + naturalness::Meter(*character->mechanism, options_of(*world)).memory_size() * sizeof(double));
  };
  c.make = make;
  c.destroy = destroy<Naturalness>;
  c.init = init;
  c.advance = advance;
  c.store = store;
  c.recall = recall;
  library.add(std::move(c));
}

}  // namespace ugoki::lsi
