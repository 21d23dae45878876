// Balance control: drive torques that make a character follow its track on its own feet, without root assist.

#include <algorithm>
#include <limits>
#include <new>
#include <optional>
#include <utility>
#include <vector>

#include "ugoki/control/balance_control.h"
#include "ugoki/control/fall_control.h"
#include "ugoki/control/motion_control.h"
#include "ugoki/control/return_motion.h"
#include "ugoki/lsi/declare.h"
#include "ugoki/lsi/track_sampler.h"
#include "ugoki/mechanism/state.h"
#include "ugoki/spatial/elementary.h"

namespace ugoki::lsi {
namespace {

/// The track of a character as the reference motion of a controller. Does not allocate. Used by only one LSI (function block).
class TrackReference final : public control::ReferenceMotion {
 public:
  explicit TrackReference(const Character& character)
      : mechanism_(character.mechanism),
        track_(character.track),
        feet_(character.feet),
        current_(track_->layout().size()),
        previous_(current_.size()),
        blended_(current_.size()) {}

  void sample(double t, std::span<double> q, std::span<double> v, std::span<double> a) const override {
    const ReferenceLayout& at = track_->layout();
    const std::span<const double> found = payload(t);
    std::ranges::copy(found.first(at.nq), q.begin());
    std::ranges::copy(found.subspan(at.v(), at.nv), v.begin());
    std::ranges::copy(found.subspan(at.a(), at.nv), a.begin());
  }
  [[nodiscard]] double end() const override {
    double end = 0;
    for (const TrackClip& clip : track_->clips()) end = std::max(end, clip.clip.end());
    return end;
  }
  [[nodiscard]] bool contacts(double t, std::span<std::uint8_t> on) const override {
    const TrackMoment now = track_->moment(t);
    if (now.previous != now.current || !track_->knows_stances(now.current)) return false;
    track_->sample_clip(now.current, t, current_);
    std::ranges::fill(on, std::uint8_t{0});
    for (std::size_t k = 0; k < feet_.size(); ++k)
      on[static_cast<std::size_t>(feet_[k])] = current_[track_->layout().stance() + k] != 0 ? 1 : 0;
    return true;
  }
  /// Returns the reference payload at time t [s]; valid until the next call.
  [[nodiscard]] std::span<const double> payload(double t) const {
    const TrackMoment now = track_->moment(t);
    track_->sample_clip(now.current, t, current_);
    if (now.previous == now.current) return current_;
    track_->sample_clip(now.previous, t, previous_);
    blend_references(*mechanism_, track_->layout(), previous_, current_, now.blend, blended_);
    return blended_;
  }

 private:
  MechanismPtr mechanism_;
  std::shared_ptr<const TrackSampler> track_;
  std::vector<int> feet_;  // links
  mutable std::vector<double> current_, previous_, blended_;
};

struct Balance {
  const Character* character;
  ReferenceLayout layout;
  std::shared_ptr<const TrackReference> track;
  std::optional<control::BalanceControl> balance;  // characters with a floating root and feet
  std::optional<control::MotionControl> tracking;  // other characters, for example a robot on a fixed base
  std::optional<control::FallControl> fall;        // as balance
  control::BalanceOptions options;
  double floor = 0;                   // m: of the track
  double ground = 0;                  // m: of the world
  std::vector<MechanismPtr> systems;  // of the world
  // After getting up: the way back to the track, and balance control that follows it. They depend only on the time of the fall.
  std::shared_ptr<const control::ReturnMotion> way_back;
  std::optional<control::BalanceControl> returning;
  double return_time = -1;   // s: time of the fall from which `way_back` was made; -1: none
  std::vector<int> foot_of;  // [feet of the character] index in balance->feet()
  std::vector<collision::ContactPoint> contacts;
  const World* world = nullptr;
  std::vector<dynamics::Workspace> others;  // [characters] working memory for the links that grips join
  std::vector<control::HeldPoint> held;
};
struct BalanceMemory {
  control::BalanceState now, next;
  control::FallState fall_now, fall_next;
  double returned_now = -1, returned_next = -1;  // s, time of the track at the last fall from which the character got up; -1: none
  control::ControlState tracking_now, tracking_next;
};

bool can_balance(const Character& c) {
  const std::size_t feet = control::feet_of(*c.mechanism).size();
  return c.mechanism->link(0).joint.type == JointType::floating && feet > 0 && feet <= control::BalanceState::max_feet;
}

/// Prepares the way back to the track after a fall at the track's time `time` [s]. Allocates, once for each time that a character gets up.
void prepare_return(Balance& self, double time) {
  if (self.return_time == time) return;
  const Character& c = *self.character;
  const control::GetUpPlan* plan = self.fall->make_plan();
  self.way_back = std::make_shared<const control::ReturnMotion>(c.mechanism, self.track, *plan, time, self.floor);
  // A character that has just risen stands on its toes; it can stop only when its heels bear load, so they are pressed down wherever its
  // pressure is.
  control::BalanceOptions options = self.options;
  options.press_margin = std::numeric_limits<double>::infinity();
  self.returning.emplace(c.mechanism, self.way_back, options, self.floor, control::GroundMap(self.systems, c.index, self.ground));
  self.return_time = time;
}

/// Balance control of a character that may have got up.
control::BalanceControl& control_of(Balance& self, double returned) {
  if (returned < 0) return *self.balance;
  prepare_return(self, returned);
  return *self.returning;
}

/// State of balance control at the begin of the way back: the reference is placed at the feet of the character.
control::BalanceState begin_return(const Balance& self, std::span<const double> q) {
  control::BalanceState state;
  state.time = self.way_back->begin();
  const Placement place = self.way_back->placement_at(q, self.returning->feet());
  state.x = place.x;
  state.y = place.y;
  state.heading = place.heading;
  std::vector<Pose> X(static_cast<std::size_t>(self.character->mechanism->link_count()));
  calc_poses(*self.character->mechanism, q, X);
  const Vec3 root = X[0].p;
  const control::GroundMap::Point ground = control::GroundMap(self.systems, self.character->index, self.ground).below(root);
  state.z = ground.height - self.floor;
  for (int k = 0; k < 2; ++k) state.tilt[k] = -ground.normal[k] / ground.normal.z;
  state.ground[0] = root.x;
  state.ground[1] = root.y;
  return state;
}

/// True if the link hangs from a driven body by a joint without a drive, such as a stirrup on its strap: it moves by itself and carries
/// little.
bool hangs_freely(const Character& character, int link) {
  if (!character.track) return false;  // a passive object is carried as a whole
  const Mechanism& m = *character.mechanism;
  for (; link > 0; link = m.link(link).parent) {
    const Link& l = m.link(link);
    for (int k = 0; k < l.joint.nv(); ++k)
      if (l.joint.type != JointType::floating && m.dof(l.v_index + k).effort == 0) return true;
  }
  return false;
}

/// True if the grip joins links that hang freely: it is neither a support nor a load.
bool is_loose(const World& world, const EventRecord& e) {
  const auto hangs = [&](int character, int link) {
    return character >= 0 && hangs_freely(world.characters()[static_cast<std::size_t>(character)], link);
  };
  return hangs(static_cast<int>(e.character), e.link) || hangs(static_cast<int>(e.c.x), static_cast<int>(e.c.y));
}

/// Number of grips at a character that carry load.
double count_grips(const World& world, std::span<const EventRecord> grips, int character) {
  double count = 0;
  for (const EventRecord& e : grips)
    if (e.kind == EventKind::gripping && (static_cast<int>(e.character) == character || static_cast<int>(e.c.x) == character) &&
        !is_loose(world, e))
      count += 1;
  return std::max(1.0, count);
}

/// Collects the grips of the character, and those of others that hold it.
void collect_held(Balance& self, std::span<const EventRecord> grips, const double* state) {
  self.held.clear();
  const int own = self.character->index;
  for (const EventRecord& e : grips) {
    if (e.kind != EventKind::gripping || self.held.size() == control::BalanceInput::max_held) continue;
    const int gripping = static_cast<int>(e.character), gripped = static_cast<int>(e.c.x);
    if (gripping == gripped || (gripping != own && gripped != own) || is_loose(*self.world, e)) continue;
    const bool grips_itself = gripping == own;
    control::HeldPoint h;
    h.link = grips_itself ? e.link : static_cast<int>(e.c.y);
    h.p = e.b;
    h.rigid = (static_cast<std::uint32_t>(e.flags) & grip_rigid) != 0;
    const int other = grips_itself ? gripped : gripping, link = grips_itself ? static_cast<int>(e.c.y) : e.link;
    if (other >= 0) {
      const Character& c = self.world->characters()[static_cast<std::size_t>(other)];
      dynamics::Workspace& ws = self.others[static_cast<std::size_t>(other)];
      const bool anchored = ws.link_chain[static_cast<std::size_t>(link)] < 0;
      // Passive objects are carried. Of two characters with drives, the heavier one carries the other.
      h.fixed = anchored || (c.track && c.mechanism->mass() > self.character->mechanism->mass());
      if (!h.fixed) h.mass = c.mechanism->mass() / count_grips(*self.world, grips, other);
      if (!anchored) {
        dynamics::update_kinematics(*c.mechanism, q_of(c, state), v_of(c, state), ws);
        h.velocity = dynamics::point_velocity(ws, link, h.p);
        h.turning = ws.V[static_cast<std::size_t>(link)].w;
      }
    }
    self.held.push_back(h);
  }
}

/// s: time until the scenario has released all grips that carry the character; infinite: never, or not known.
double time_to_release(const Balance& self, double time) {
  constexpr double never = std::numeric_limits<double>::infinity();
  double last = 0;
  for (const control::HeldPoint& h : self.held) {
    if (!h.fixed) continue;
    double first = never;
    for (const ScheduledEvent& e : self.world->events())
      if (e.record.kind == EventKind::opening && static_cast<int>(e.record.character) == self.character->index && e.record.link == h.link &&
          e.time > time)
        first = std::min(first, e.time - time);
    last = std::max(last, first);
  }
  return last > 0 ? last : never;
}

std::int32_t step(const Call* call) {
  auto& self = object_of<Balance>(call);
  auto& memory = *static_cast<BalanceMemory*>(call->state);
  const double* state = circuit::input(call, 0);
  self.contacts.clear();
  for (const ContactRecord& c : records<ContactRecord>(call->in[1])) self.contacts.push_back(c.point);
  const std::size_t nv = self.layout.nv;
  double* drive = circuit::output(call, 0);
  double* report = circuit::output(call, 1);
  double* reference = circuit::output(call, 2);
  double* balance = circuit::output(call, 3);
  std::fill_n(drive, 3 * nv, 0.0);
  std::fill_n(report, std::size_t{report_count}, 0.0);
  std::fill_n(balance, 4, 0.0);
  double* recovery = circuit::output(call, 4);
  std::fill_n(recovery, 2, 0.0);
  const std::span<const double> q = q_of(*self.character, state), v = v_of(*self.character, state);
  if (self.tracking) {
    std::ranges::copy(self.track->payload(call->tick->time), reference);
    memory.tracking_next = memory.tracking_now;
    control::ControlInput in;
    in.q = q;
    in.v = v;
    in.q_ref = {reference, self.layout.nq};
    in.v_ref = {reference + self.layout.v(), nv};
    in.a_ref = {reference + self.layout.a(), nv};
    in.contacts = self.contacts;
    in.system = self.character->index;
    in.dt = call->tick->dt;
    in.known = &self.world->kinematics().at(call->tick->index, self.character->index);
    const control::ControlOutput out = self.tracking->step(in, memory.tracking_next, {drive, nv}, {drive + nv, nv}, {drive + 2 * nv, nv});
    report[report_ratio] = out.ratio;
    report[report_released] = out.released ? 1 : 0;
    return 0;
  }
  memory.next = memory.now;
  memory.fall_next = memory.fall_now;
  const double dt = call->tick->dt;
  const std::span<double> tau(drive, nv), gain(drive + nv, nv), velocity(drive + 2 * nv, nv);
  memory.returned_next = memory.returned_now;
  if (memory.fall_now.mode > static_cast<std::uint64_t>(control::FallMode::brace)) {  // the track waits where the character fell
    self.fall->step(q, v, self.contacts, self.character->index, dt, memory.fall_next, tau, gain, velocity);
    std::ranges::copy(self.track->payload(memory.now.time), reference);
    displace_root(*self.character->mechanism, {memory.now.x, memory.now.y, memory.now.z, memory.now.heading}, {reference, self.layout.nq});
    for (std::size_t k = 0; k < self.layout.feet; ++k) reference[self.layout.stance() + k] = 0;
    report[report_released] = 1;
    balance[2] = memory.now.time;
    recovery[0] = static_cast<double>(std::min(memory.fall_next.mode, static_cast<std::uint64_t>(control::FallMode::rise)));
    if (memory.fall_next.mode == static_cast<std::uint64_t>(control::FallMode::ready)) {  // the next tick stands up
      prepare_return(self, memory.now.time);
      memory.returned_next = memory.now.time;
      memory.next = begin_return(self, q);
      memory.fall_next = {};
    }
    return 0;
  }
  control::BalanceControl& control = control_of(self, memory.returned_now);
  collect_held(self, records<EventRecord>(call->in[2]), state);
  const control::BalanceOutput out =
      control.step({q, v, self.contacts, self.character->index, dt, self.held, time_to_release(self, call->tick->time)}, memory.next, tau);
  const bool airborne = out.hang == control::HangMode::hangs || out.hang == control::HangMode::drops;
  if (self.fall && !airborne) {
    recovery[1] = self.fall->check(q, v, control.reference(), out.dcm_error, dt, memory.fall_next);
    self.fall->brace(q, v, dt, memory.fall_next, tau, gain, velocity);
    recovery[0] = static_cast<double>(memory.fall_next.mode);
    // While it stands up, the character counts as getting up.
    if (memory.returned_now >= 0 && memory.fall_next.mode == 0 && memory.next.time < self.way_back->stands())
      recovery[0] = static_cast<double>(control::FallMode::rise);
  }
  std::ranges::copy(self.track->payload(memory.next.time), reference);
  std::ranges::copy(control.reference(), reference);  // overwrites q by the controller's reference, which is displaced in the plane
  for (std::size_t k = 0; k < self.layout.feet; ++k)
    if (!memory.next.feet[self.foot_of[k]].stands) reference[self.layout.stance() + k] = 0;
  balance[0] = out.dcm_error.x;
  balance[1] = out.dcm_error.y;
  balance[2] = memory.next.time;
  balance[3] = memory.next.rate;
  return 0;
}

/// Height of the floor on which the track's first clip was laid, m: a character may begin on a platform.
double floor_of_track(const Character& c, const World& world) {
  return c.track ? c.track->clips().front().clip.placement.z : world.ground().height;
}

void* make(Setup& s) {
  const Character* character = character_of(s);
  const World* world = world_of(s);
  auto* self = new Balance{character,
                           reference_layout(*character->mechanism, character->feet.size()),
                           std::make_shared<const TrackReference>(*character),
                           std::nullopt,
                           std::nullopt,
                           std::nullopt,
                           {},
                           floor_of_track(*character, *world),
                           world->ground().height,
                           {},
                           nullptr,
                           std::nullopt,
                           -1,
                           {},
                           {},
                           world,
                           {},
                           {}};
  for (const Character& c : world->characters()) self->others.emplace_back(*c.mechanism);
  self->held.reserve(control::BalanceInput::max_held);
  if (can_balance(*character)) {
    control::BalanceOptions& options = self->options;
    options.gravity = world->gravity();
    options.com_gain = s.number("balance gain");
    options.joint_frequency = s.number("joint frequency");
    options.leg_weight = s.number("leg weight");
    options.momentum_weight = s.number("momentum weight");
    options.shift_growth = s.number("step growth");
    options.swing = s.number("swing") * pi / 180;
    const std::vector<MechanismPtr> systems = world->mechanisms();
    self->systems = systems;
    self->balance.emplace(character->mechanism, self->track, options, floor_of_track(*character, *world),
                          control::GroundMap(systems, character->index, world->ground().height));
    if (static_cast<std::size_t>(character->mechanism->nq()) <= control::FallState::max_coordinates) {
      control::FallOptions protection;
      protection.gravity = world->gravity();
      protection.get_up = s.number("get up") >= 0.5;
      self->fall.emplace(character->mechanism, protection, control::GroundMap(systems, character->index, world->ground().height));
    }
    for (const int link : character->feet) {
      int found = 0;
      for (std::size_t f = 0; f < self->balance->feet().size(); ++f)
        if (std::ranges::find(self->balance->feet()[f].parts, link) != self->balance->feet()[f].parts.end()) found = static_cast<int>(f);
      self->foot_of.push_back(found);
    }
  } else {
    control::ControlOptions options;
    options.gravity = world->gravity();
    options.assist_limit = 0;
    options.joint_frequency = options.root_frequency = s.number("joint frequency");
    self->tracking.emplace(character->mechanism, options);
  }
  self->contacts.reserve(world->contact_capacity());
  return self;
}

}  // namespace

void add_balance(circuit::Library& library) {
  const control::BalanceOptions usual;
  circuit::LsiClass c;
  c.name = "balance control";
  c.doc =
      "Computes joint torques that make a character follow its track on its own feet, without any external force on the root. It plans "
      "steps: the time and the place where a foot lands follow from the balance of the character. A character that can no longer keep its "
      "balance falls with its hands first, and gets up again. A character without a floating root or "
      "without feet follows its track with the torques of its joints alone.";
  c.inputs = {input_pin("state", PinTypeId::state, "", "Positions and velocities now."),
              input_pin("contacts", PinTypeId::contacts, "", "Contact points; those of the feet with the ground support the character."),
              input_pin("grips", PinTypeId::event, "",
                        "Output `grips` of `dynamics` in the last tick. Grips at objects that cannot move carry the character.")};
  c.inputs[2].required = false;
  c.outputs = {
      output_pin("torque", PinTypeId::joint_values, "N m, N",
                 "For all degrees of freedom: forces (zero on the root), then servo gains, then servo velocities."),
      output_pin("report", PinTypeId::joint_values, "", "The report of a motion control LSI, with a root assist of zero."),
      output_pin("reference", PinTypeId::motion, "",
                 "The reference that the character follows: the track at the controller's own time, displaced to the standing foot."),
      output_pin("balance", PinTypeId::joint_values, "",
                 "Four numbers: error of the divergent component of motion, x and y in m; time of the reference, s; rate of that time."),
      output_pin("recovery", PinTypeId::joint_values, "",
                 "Two numbers: mode (0 follows its track, 1 braces for a fall, 2 falls, 3 lies on the ground, 4 gets up), and the distance "
                 "from the limits "
                 "of a fall (1: at the reference, 0: the character begins to fall).")};
  c.parameters = {
      character_parameter(),
      number_parameter("balance gain", usual.com_gain, 0, 20, "1/s", "Rate at which the error of balance decays."),
      number_parameter("joint frequency", usual.joint_frequency, 0, 100, "rad/s", "Rate at which the error of a joint decays."),
      number_parameter("leg weight", usual.leg_weight, 0.001, 100, "",
                       "Importance of the posture of the legs; 1 is the importance of the posture of the other joints."),
      number_parameter("momentum weight", usual.momentum_weight, 0.001, 100, "",
                       "Importance of the angular momentum; less lets the arms and the trunk swing more to keep the balance."),
      number_parameter("step growth", usual.shift_growth, 0, 6, "1/s",
                       "Growth of the error of balance that a step expects until its foot lands. More makes steps wider."),
      number_parameter("swing", 0, 0, 90, "deg",
                       "Amplitude to which the character swings with its legs while it hangs from its grips; 0: it only hangs."),
      number_parameter("get up", 1, 0, 1, "",
                       "1: a character that lies gets up and goes on with its track. Bodies without two arms and two legs stay on the "
                       "ground, and so does a character after six failed tries. 0: every character stays on the ground.")};
  c.configure = [](Setup& s) {
    const Character* character = character_of(s);
    if (!character) return;
    if (!character->track) {
      s.fail(ErrorCode::structure, "The character '" + character->id + "' has no track.", "Lay a clip on its track.");
      return;
    }
    s.set_out(0, 3 * static_cast<std::uint32_t>(character->mechanism->nv()), character->index);
    s.set_out(1, report_count, character->index);
    s.set_out(2, static_cast<std::uint32_t>(reference_layout(*character->mechanism, character->feet.size()).size()), character->index);
    s.set_out(3, 4, character->index);
    s.set_out(4, 2, character->index);
    s.set_state(sizeof(BalanceMemory));
  };
  c.make = make;
  c.destroy = destroy<Balance>;
  c.init = [](const Call* call) -> std::int32_t {
    new (call->state) BalanceMemory{};
    return 0;
  };
  c.step = step;
  c.advance = [](const Call* call) -> std::int32_t {
    auto& memory = *static_cast<BalanceMemory*>(call->state);
    memory.now = memory.next;
    memory.fall_now = memory.fall_next;
    memory.returned_now = memory.returned_next;
    memory.tracking_now = memory.tracking_next;
    return 0;
  };
  library.add(std::move(c));
}

}  // namespace ugoki::lsi
