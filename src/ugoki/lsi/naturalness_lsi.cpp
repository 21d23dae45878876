// Naturalness: tracking error of a character, root assist that the character needs, sliding and penetration of the feet.

#include <cmath>

#include "ugoki/lsi/declare.h"
#include "ugoki/lsi/track_sampler.h"
#include "ugoki/mechanism/state.h"
#include "ugoki/motion/foot_slip.h"
#include "ugoki/motion/measures.h"

namespace ugoki::lsi {
namespace {

enum Input : std::size_t { in_state, in_reference, in_report, in_contacts };

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
  const Character* character;
  ReferenceLayout layout;
  FootSlip skate;
  GroundPenetration penetration;
  std::vector<Pose> poses;           // [links] present poses
  std::vector<std::uint8_t> stance;  // [feet] 1: the foot stands in the reference
  std::vector<double> error;         // [nv] rad | m: difference between present position and reference
  std::vector<int> foot_of_link;     // [links] index of the foot (toes and heel are one foot); -1: none
  std::vector<std::uint8_t> bears;   // [feet] 1: the foot touches the ground now
  int foot_count = 0;
  double upright = 0;  // m: height of the root above the lowest link in the neutral position
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
    if (c.point.system_a != self.character->index || c.point.system_b >= 0 || c.point.distance > 0.005) continue;
    const int foot = self.foot_of_link[static_cast<std::size_t>(c.point.link_a)];
    if (foot < 0 || self.bears[static_cast<std::size_t>(foot)]) continue;
    self.bears[static_cast<std::size_t>(foot)] = 1;
    ++feet;
  }
  return feet;
}

std::int32_t advance(const Call* call) {
  auto& self = object_of<Naturalness>(call);
  auto& sums = *static_cast<Sums*>(call->state);
  const Mechanism& m = *self.character->mechanism;
  const double* reference = circuit::input(call, in_reference);
  const double* report = circuit::input(call, in_report);
  const std::span<const double> q = q_of(*self.character, circuit::input(call, in_state));
  const bool released = report[report_released] > 0;
  calc_poses(m, q, self.poses);
  difference(m, q, {reference, self.layout.nq}, self.error);
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
  const double dt = sums.last_time >= 0 ? call->tick->time - sums.last_time : 0;
  sums.last_time = call->tick->time;
  self.skate.add(self.poses, self.stance, dt);
  const double depth = self.penetration.add(self.poses);  // m
  if (m.link(0).joint.type == JointType::floating) {
    // Fallen: the root is below its reference by more than 35 % of the standing height, or tilted from the reference by more than 1 rad.
    const double below = reference[2] - q[2];                                           // m, in the axes of the root joint
    const double tilt = self.error[0] * self.error[0] + self.error[1] * self.error[1];  // rad^2
    if (below > 0.35 * self.upright || tilt > 1.0) sums.fell = 1;
  }

  double* out = circuit::output(call, 0);
  constexpr double degrees = 180 / pi;
  const auto root_mean = [](double sum, double count) { return count > 0 ? std::sqrt(sum / count) : 0.0; };
  out[measure_tracking] = degrees * root_mean(sums.tracking, sums.tracking_count);
  out[measure_assist] = root_mean(sums.assist, sums.assist_count);
  out[measure_assist_force] = root_mean(sums.assist_force, sums.assist_count);
  out[measure_assist_max] = sums.assist_max;
  out[measure_skate] = self.skate.mean_cm();
  out[measure_skate_worst] = self.skate.worst_cm();
  out[measure_penetration] = self.penetration.worst_mm();
  out[measure_penetration_rms] = self.penetration.rms_mm();
  out[measure_fell] = sums.fell;
  out[measure_release_time] = sums.release_time;
  out[measure_feet] = count_feet(self, call->in[in_contacts]);
  out[measure_tracking_now] = degrees * root_mean(angles, joints);
  out[measure_assist_now] = released ? 0 : report[report_size];
  out[measure_slip_now] = self.skate.now_cm();
  out[measure_depth_now] = 1000 * depth;
  return 0;
}

void* make(Setup& s) {
  const Character& c = *character_of(s);
  const Mechanism& m = *c.mechanism;
  auto* self = new Naturalness{&c,
                               reference_layout(m, c.feet.size()),
                               FootSlip(m, c.feet),
                               GroundPenetration(m, world_of(s)->ground().height),
                               {},
                               {},
                               {},
                               {},
                               {},
                               0,
                               0};
  self->poses.resize(static_cast<std::size_t>(m.link_count()));
  self->stance.resize(c.feet.size());
  self->error.resize(static_cast<std::size_t>(m.nv()));
  self->foot_of_link.assign(self->poses.size(), -1);
  for (const int link : c.feet) {
    const int parent = m.link(link).parent;
    const int of_parent = parent < 0 ? -1 : self->foot_of_link[static_cast<std::size_t>(parent)];
    self->foot_of_link[static_cast<std::size_t>(link)] = of_parent >= 0 ? of_parent : self->foot_count++;
  }
  self->bears.resize(static_cast<std::size_t>(self->foot_count));
  calc_poses(m, m.neutral(), self->poses);
  double low = self->poses[0].p.z;
  for (const Pose& pose : self->poses) low = std::min(low, pose.p.z);
  self->upright = std::max(0.05, self->poses[0].p.z - low);
  return self;
}

/// Returns the address, in the state, of the memory of `skate` and `penetration`, which follows the sums.
double* memory_of(const Call* call) { return reinterpret_cast<double*>(static_cast<std::byte*>(call->state) + sizeof(Sums)); }

void store(const Call* call) {
  const auto& self = object_of<Naturalness>(call);
  const std::span<double> memory(memory_of(call), self.skate.memory_size() + self.penetration.memory_size());
  self.skate.save(memory.first(self.skate.memory_size()));
  self.penetration.save(memory.subspan(self.skate.memory_size()));
}

void recall(const Call* call) {
  auto& self = object_of<Naturalness>(call);
  const std::span<const double> memory(memory_of(call), self.skate.memory_size() + self.penetration.memory_size());
  self.skate.restore(memory.first(self.skate.memory_size()));
  self.penetration.restore(memory.subspan(self.skate.memory_size()));
}

std::int32_t init(const Call* call) {
  auto& self = object_of<Naturalness>(call);
  *static_cast<Sums*>(call->state) = Sums{};
  self.skate.reset();
  self.penetration.reset();
  double* out = circuit::output(call, 0);
  out[measure_release_time] = -1;
  out[measure_feet] = self.foot_count == 0 ? -1 : 0;
  return 0;
}

}  // namespace

void add_naturalness(circuit::Library& library) {
  circuit::LsiClass c;
  c.name = "naturalness";
  c.doc =
      "Measures since the start and of the present instant: tracking error, root assist, sliding of standing feet, depth in the ground, "
      "and "
      "whether the character fell. Set \"every\" so that it runs at about 120 Hz.";
  c.inputs = {input_pin("state", PinTypeId::state, "", "Positions and velocities now."),
              input_pin("reference", PinTypeId::motion, "", "Reference motion of the character at this tick."),
              input_pin("report", PinTypeId::joint_values, "", "Report of the character's motion control."),
              input_pin("contacts", PinTypeId::contacts, "", "Contact points now.")};
  for (circuit::InputPin& pin : c.inputs) pin.direct = false;
  c.outputs = {output_pin("measures", PinTypeId::joint_values, "", "Fifteen numbers; docs/circuit.md lists them.")};
  c.outputs[0].delayed = true;
  c.parameters = {character_parameter()};
  c.configure = [](Setup& s) {
    const Character* character = character_of(s);
    if (!character) return;
    check_subject(s, in_reference, "reference", *character);
    check_subject(s, in_report, "report", *character);
    s.set_out(0, measure_count, character->index);
    const FootSlip skate(*character->mechanism, character->feet);
    s.set_state(sizeof(Sums) + (skate.memory_size() + GroundPenetration(*character->mechanism).memory_size()) * sizeof(double));
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
