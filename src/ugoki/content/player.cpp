#include "ugoki/content/player.h"

#include <algorithm>
#include <cmath>

#include "ugoki/base/hash.h"
#include "ugoki/circuit/executor.h"
#include "ugoki/content/generate.h"
#include "ugoki/content/rule_circuit.h"
#include "ugoki/lsi/standard_library.h"
#include "ugoki/lsi/touch.h"
#include "ugoki/lsi/track_sampler.h"
#include "ugoki/mechanism/state.h"

namespace ugoki::content {

using circuit::PinTypeId;
using circuit::PinView;
using lsi::EventKind;
using lsi::EventRecord;

struct Player::Machine {
  Executable content;
  PlayerOptions options;
  circuit::Circuit circuit;
  std::unique_ptr<lsi::World> world;
  std::unique_ptr<circuit::Interpreter> interpreter;
  PinView state, contacts, events, poses, characters, measures;  // outputs of the circuit
  /// Outputs of a dynamics LSI that report how well its step was solved.
  struct StepPins {
    PinView not_converged, substeps, failures;
  };
  std::vector<PinView> touches;    // output `touches` of every dynamics LSI
  std::vector<StepPins> quality;   // report pins of every dynamics LSI
  std::vector<PinView> variables;  // values of content.variables
  std::span<std::byte> live;       // input `live` of the circuit: the user's events for the next step
  circuit::DeviceFeed devices;
  std::vector<PlayerInput> inputs;           // inputs applied since the start
  std::vector<PlayerInput> scheduled;        // sorted by step
  std::size_t next_scheduled = 0;            // index into `scheduled`
  bool displayed = false;                    // true: the display LSIs have run since the last step
  circuit::DeviceState at_step;              // the last hold() that the last step read
  circuit::DeviceState given;                // the last hold()
  std::optional<circuit::DeviceState> late;  // a hold() that acts one step later, because it ends a press that no step has read yet

  [[nodiscard]] bool is_link(int character, int link) const {
    return character >= 0 && character < static_cast<int>(world->characters().size()) && link >= 0 &&
           link < world->characters()[static_cast<std::size_t>(character)].mechanism->link_count();
  }
  Result<void> bind();
  [[nodiscard]] const circuit::Library& library() const { return options.library ? *options.library : lsi::standard_library(); }
  [[nodiscard]] circuit::BuildOptions build_options() const {
    return {.dt = content.step, .check_finite = true, .activity = options.activity};
  }
  void add_input(const EventRecord& record);
  void add_input(std::shared_ptr<const circuit::DeviceState> held);
  void add_scheduled_inputs();
  void refresh();
};

namespace {

constexpr std::size_t max_live = 32;  // maximum number of records in the payload of an event pin

/// Returns the circuit's output `name`. Reports a problem if it is missing or has another type or element count.
PinView find_pin(const circuit::Interpreter& interpreter, const char* name, PinTypeId type, std::uint32_t count, Error& problems) {
  const auto view = interpreter.find_circuit_output(name);
  if (view && view->type == type && view->count == count) return *view;
  const std::string wanted = "'" + std::string(name) + "' (" + std::string(circuit::pin_type(type).name) + ")";
  problems.add(ErrorCode::structure, "circuit/outputs",
               view ? "The circuit's output " + wanted + " does not have the type and size that the player needs."
                    : "The circuit has no output " + wanted + ".",
               "Add the outputs of the default circuit: see docs/circuit.md.");
  return {};
}

}  // namespace

lsi::World make_world(const Executable& content) {
  std::vector<lsi::CharacterSpec> characters;
  for (const ExecutableCharacter& c : content.characters) {
    lsi::CharacterSpec spec;
    spec.id = c.id;
    spec.mechanism = content.mechanism_of(c);
    spec.q0 = c.q0;
    if (c.control.mode != ControlMode::passive)
      for (const ExecutableClip& clip : c.track) spec.track.push_back({clip.clip, content.motions[static_cast<std::size_t>(clip.motion)]});
    spec.as_recorded = c.control.mode == ControlMode::path || c.control.mode == ControlMode::torque;
    if (c.control.mode == ControlMode::torque && !spec.track.empty()) spec.torques = spec.track.front().motion;
    for (const ExecutableClip& clip : c.moves) spec.moves.push_back({clip.clip, content.motions[static_cast<std::size_t>(clip.motion)]});
    characters.push_back(std::move(spec));
  }
  std::vector<lsi::ScheduledEvent> events;
  for (const ExecutableEvent& e : content.events) {
    lsi::ScheduledEvent event;
    event.record.character = static_cast<std::uint32_t>(e.character);
    event.record.link = e.link;
    event.time = e.time;
    event.duration = e.duration;
    if (e.type == EventType::push) {
      event.record.kind = EventKind::push;
      event.record.a = e.force;
      if (e.axes == PushAxes::body) event.record.flags = lsi::push_body_axes;
    } else if (e.type == EventType::pull) {
      event.record.kind = EventKind::grab;
      event.record.a = e.point;
      for (const PullTarget& t : e.path) event.path.push_back({t.time, t.at});
    } else if (e.type == EventType::release) {
      event.record.kind = EventKind::opening;
    } else if (e.type == EventType::grab) {
      event.record.kind = EventKind::gripping;
      event.record.a = e.grip.point;
      event.record.b = e.grip.at;
      const std::uint32_t flags = (e.grip.rigid ? lsi::grip_rigid : 0U) | (e.grip.has_at ? lsi::grip_has_target : 0U);
      event.record.c = {static_cast<double>(e.other), static_cast<double>(e.other_link), static_cast<double>(flags)};
      event.record.spare[0] = e.grip.limit;
      event.record.spare[1] = e.grip.reach;
    } else {
      event.record.kind = EventKind::throwing;
      event.record.a = e.from;
      event.record.b = e.velocity;
      event.record.c = e.spin;
    }
    events.push_back(event);
  }
  return lsi::World(std::move(characters), std::move(events), content.gravity,
                    {content.ground.height, content.ground.friction, content.ground.restitution});
}

Result<Player> Player::open(std::span<const std::byte> ugx, std::string_view name, PlayerOptions options) {
  Result<Executable> content = read_executable(ugx, name);
  if (!content) return fail(std::move(content.error()));
  auto machine = std::make_unique<Machine>();
  Machine& m = *machine;
  m.content = std::move(*content);
  m.options = std::move(options);
  Result<circuit::Circuit> circuit = circuit::read_circuit(m.content.circuit, std::string(name) + ", section circuit");
  if (!circuit) return fail(std::move(circuit.error()));
  m.circuit = std::move(*circuit);
  m.world = std::make_unique<lsi::World>(make_world(m.content));
  m.world->set_executor(m.options.executor);
  Result<circuit::Interpreter> interpreter = circuit::Interpreter::build(m.circuit, m.library(), m.world.get(), m.build_options());
  if (!interpreter) return fail(std::move(interpreter.error()));
  m.interpreter = std::make_unique<circuit::Interpreter>(std::move(*interpreter));
  m.interpreter->set_executor(m.options.executor);
  if (Result<void> bound = m.bind(); !bound) return fail(std::move(bound.error()));
  m.inputs.reserve(1024);
  return Player(std::move(machine));
}

/// Finds those inputs and outputs of the circuit that the player uses.
Result<void> Player::Machine::bind() {
  Machine& m = *this;
  Error problems;
  const std::size_t character_count = m.world->characters().size();
  const circuit::Interpreter& i = *m.interpreter;
  m.state = find_pin(i, "state", PinTypeId::state, m.world->state_count(), problems);
  m.contacts = find_pin(i, "contacts", PinTypeId::contacts, m.world->contact_capacity(), problems);
  m.events = find_pin(i, "events", PinTypeId::event, circuit::pin_type(PinTypeId::event).default_count, problems);
  m.poses = find_pin(i, "poses", PinTypeId::pose, lsi::World::payload_count(m.world->link_count()), problems);
  m.characters =
      find_pin(i, "characters", PinTypeId::joint_values, lsi::World::payload_count(character_count * lsi::character_entry_count), problems);
  m.measures = find_pin(i, "measures", PinTypeId::joint_values, lsi::World::payload_count(character_count * lsi::measure_count), problems);
  m.touches.clear();
  m.quality.clear();
  for (const circuit::Instance& lsi : m.circuit.lsis) {
    if (lsi.type != "dynamics") continue;
    const auto output = [&](const char* name) { return i.find_output(lsi.id + "." + name); };
    if (const auto pin = output("touches"); pin && pin->type == PinTypeId::event) m.touches.push_back(*pin);
    const auto a = output("not converged"), b = output("substeps"), c = output("failures");
    if (a && b && c) m.quality.push_back({*a, *b, *c});
  }
  m.variables.clear();
  std::erase_if(m.content.variables, [&](const ScenarioVariable& v) {
    const auto pin = i.find_output(variable_lsi(v.id) + ".value");
    const bool found = pin && pin->type == PinTypeId::scalar && pin->count == 1;
    if (found) m.variables.push_back(*pin);
    return !found;
  });
  m.devices = circuit::DeviceFeed(*m.interpreter);
  m.live = m.interpreter->find_circuit_input("live");
  if (m.live.size() != sizeof(std::uint64_t) + max_live * sizeof(EventRecord))
    problems.add(ErrorCode::structure, "circuit/inputs", "The circuit has no input 'live' (event).",
                 "Add the input of the default circuit: see docs/circuit.md.");
  if (!problems.empty()) return fail(std::move(problems));
  return {};
}

Result<circuit::Interpreter::Adoption> Player::change_library(std::shared_ptr<const circuit::Library> library) {
  Machine& m = *machine_;
  const circuit::Library& next = library ? *library : lsi::standard_library();
  Result<circuit::Interpreter> made = circuit::Interpreter::build(m.circuit, next, m.world.get(), m.build_options());
  if (!made) return fail(std::move(made.error()));
  circuit::Interpreter::Adoption report = made->adopt_report(*m.interpreter);
  const std::vector<std::byte> pending_events(m.live.begin(), m.live.end());
  made->set_executor(m.options.executor);
  *m.interpreter = std::move(*made);
  m.options.library = std::move(library);
  if (Result<void> bound = m.bind(); !bound) return fail(std::move(bound.error()));
  std::copy(pending_events.begin(), pending_events.end(), m.live.begin());
  m.displayed = false;
  return report;
}

Player::Player(std::unique_ptr<Machine> machine) : machine_(std::move(machine)) {}
Player::Player(Player&&) noexcept = default;
Player& Player::operator=(Player&&) noexcept = default;
Player::~Player() = default;

const Executable& Player::content() const { return machine_->content; }
const lsi::World& Player::world() const { return *machine_->world; }
double Player::step_size() const { return machine_->content.step; }
std::uint64_t Player::step_count() const { return machine_->interpreter->ticks(); }
double Player::time() const { return machine_->interpreter->time(); }
const std::vector<PlayerInput>& Player::inputs() const { return machine_->inputs; }
const circuit::Library& Player::library() const { return machine_->library(); }
circuit::Interpreter& Player::interpreter() { return *machine_->interpreter; }

void Player::Machine::add_input(const EventRecord& record) {
  const std::uint64_t step = interpreter->ticks();
  std::size_t count = lsi::records<EventRecord>(live.data()).size();
  EventRecord* records = lsi::record_room<EventRecord>(live.data());
  // If the target was dragged several times between two steps, only the last target has an effect.
  const bool replaces_drag = record.kind == EventKind::drag && count > 0 && records[count - 1].kind == EventKind::drag;
  if (replaces_drag) {
    --count;
    inputs.pop_back();
  }
  if (count == max_live) return;
  records[count] = record;
  lsi::set_count(live.data(), count + 1);
  inputs.push_back({step, record, nullptr});
}

void Player::Machine::add_input(std::shared_ptr<const circuit::DeviceState> held) {
  const std::uint64_t step = interpreter->ticks();
  devices.give(*held);
  // If several device states arrive between two steps, only the last one has an effect.
  if (!inputs.empty() && inputs.back().held && inputs.back().step == step) inputs.pop_back();
  inputs.push_back({step, {}, std::move(held)});
}

void Player::Machine::add_scheduled_inputs() {
  while (next_scheduled < scheduled.size() && scheduled[next_scheduled].step <= interpreter->ticks()) {
    const PlayerInput& input = scheduled[next_scheduled++];
    if (input.step != interpreter->ticks()) continue;
    if (input.held)
      add_input(input.held);
    else
      add_input(input.record);
  }
}

Result<void> Player::step() {
  Machine& m = *machine_;
  m.add_scheduled_inputs();
  const bool good = m.interpreter->tick();
  m.displayed = false;
  if (!good) {
    const circuit::Stop& stop = *m.interpreter->stopped();
    return fail(ErrorCode::range, stop.pin.empty() ? stop.lsi : stop.pin, stop.text(),
                stop.library.empty() ? "Return to an earlier time, or use a shorter step."
                                     : "Check its inputs, or correct the LSI and rebuild it.");
  }
  lsi::set_count(m.live.data(), 0);
  if (!(m.given == m.at_step)) m.at_step = m.given;
  if (m.late) {
    const circuit::DeviceState released = *m.late;
    hold(released);
  }
  return {};
}

void Player::touches(std::vector<PlayerTouch>& out) const {
  out.clear();
  for (const PinView& pin : machine_->touches) {
    for (const EventRecord& e : lsi::records<EventRecord>(pin.bytes.data())) {
      if (e.kind != EventKind::touch && e.kind != EventKind::parting && e.kind != EventKind::omitted) continue;
      PlayerTouch t;
      t.time = time();
      if (e.kind == EventKind::omitted) {
        t.omitted = static_cast<std::size_t>(e.a.x);
        t.words = lsi::describe_touch(*machine_->world, e);
        out.push_back(std::move(t));
        continue;
      }
      t.ended = e.kind == EventKind::parting;
      t.character_a = static_cast<int>(e.character);
      t.link_a = e.link;
      t.character_b = static_cast<int>(e.c.x);
      t.link_b = static_cast<int>(e.c.y);
      t.point = e.a;
      t.impulse = e.b;
      t.duration = e.duration;
      t.words = lsi::describe_touch(*machine_->world, e);
      out.push_back(std::move(t));
    }
  }
}

PlayerStepQuality& PlayerStepQuality::operator+=(const PlayerStepQuality& next) {
  not_converged += next.not_converged;
  split_steps += next.split_steps;
  substeps += next.substeps;
  failures += next.failures;
  return *this;
}

PlayerStepQuality Player::step_quality() const {
  PlayerStepQuality sum;
  const auto count = [](const PinView& pin) { return static_cast<std::uint64_t>(pin.numbers()[0]); };
  for (const Machine::StepPins& pins : machine_->quality) {
    const std::uint64_t substeps = count(pins.substeps);
    sum += {count(pins.not_converged), substeps > 1 ? 1u : 0u, substeps, count(pins.failures)};
  }
  return sum;
}

void Player::reset() {
  machine_->interpreter->reset();
  machine_->inputs.clear();
  machine_->next_scheduled = 0;
  machine_->displayed = false;
  machine_->at_step = machine_->given = {};
  machine_->late.reset();
}

void Player::push(int character, int link, const Vec3& force, double duration) {
  if (!machine_->is_link(character, link) || !is_finite(force) || !(duration > 0) || !std::isfinite(duration)) return;
  EventRecord e;
  e.kind = EventKind::push;
  e.character = static_cast<std::uint32_t>(character);
  e.link = link;
  e.a = force;
  e.duration = duration;
  machine_->add_input(e);
}

void Player::grab(int character, int link, const Vec3& point, const Vec3& target) {
  if (!machine_->is_link(character, link) || !is_finite(point) || !is_finite(target)) return;
  EventRecord e;
  e.kind = EventKind::grab;
  e.character = static_cast<std::uint32_t>(character);
  e.link = link;
  e.a = point;
  e.b = target;
  machine_->add_input(e);
}

void Player::drag(const Vec3& target) {
  if (!is_finite(target)) return;
  EventRecord e;
  e.kind = EventKind::drag;
  e.b = target;
  machine_->add_input(e);
}

void Player::release() {
  EventRecord e;
  e.kind = EventKind::release;
  machine_->add_input(e);
}

void Player::throw_from(int character, const Vec3& from, const Vec3& velocity, const Vec3& spin) {
  if (!machine_->is_link(character, 0) || !is_finite(from) || !is_finite(velocity) || !is_finite(spin)) return;
  EventRecord e;
  e.kind = EventKind::throwing;
  e.character = static_cast<std::uint32_t>(character);
  e.a = from;
  e.b = velocity;
  e.c = spin;
  machine_->add_input(e);
}

void Player::hold(const circuit::DeviceState& state) {
  Machine& m = *machine_;
  circuit::DeviceState now = state;
  // A tap can be shorter than a step, or than a picture during which no step runs. At least one step reads the press.
  if (circuit::keep_presses(m.at_step, m.given, now))
    m.late = state;
  else
    m.late.reset();
  if (!m.devices.has(now)) m.add_input(std::make_shared<const circuit::DeviceState>(now));
  m.given = std::move(now);
}

const circuit::DeviceFeed& Player::devices() const { return machine_->devices; }

void Player::schedule(std::vector<PlayerInput> inputs) {
  std::vector<std::pair<std::uint64_t, std::size_t>> order;  // (step, index): sorted by step; inputs of one step keep their order
  for (std::size_t i = 0; i < inputs.size(); ++i) {
    const EventRecord& e = inputs[i].record;
    const bool has_no_link = inputs[i].held || e.kind == EventKind::drag || e.kind == EventKind::release;
    if (has_no_link || machine_->is_link(static_cast<int>(e.character), e.link)) order.emplace_back(inputs[i].step, i);
  }
  std::sort(order.begin(), order.end());
  machine_->scheduled.clear();
  for (const auto& [step, i] : order) machine_->scheduled.push_back(inputs[i]);
  machine_->next_scheduled = 0;
}

std::uint64_t Player::state_hash() const {
  Hash64 hash;
  hash.add(machine_->state.numbers().first(machine_->world->state_size()));
  return hash.value();
}

std::span<const double> Player::q(int character) const {
  return lsi::q_of(machine_->world->characters()[static_cast<std::size_t>(character)], machine_->state.numbers().data());
}
std::span<const double> Player::v(int character) const {
  return lsi::v_of(machine_->world->characters()[static_cast<std::size_t>(character)], machine_->state.numbers().data());
}

void Player::save(std::vector<std::byte>& bytes) { machine_->interpreter->save(bytes); }

Result<void> Player::restore(std::span<const std::byte> bytes) {
  Machine& m = *machine_;
  if (Result<void> done = m.interpreter->restore(bytes); !done) return done;
  const std::uint64_t now = m.interpreter->ticks();
  // Inputs of this step may have arrived before or after the state was saved. A device state is kept only if it equals the restored one;
  // events are taken from the restored input `live` below.
  std::erase_if(m.inputs, [&](const PlayerInput& i) { return i.step >= now && !(i.step == now && i.held && m.devices.has(*i.held)); });
  for (const EventRecord& e : lsi::records<EventRecord>(m.live.data())) m.inputs.push_back({now, e, nullptr});
  m.next_scheduled = 0;
  m.displayed = false;
  m.at_step = m.given;
  m.late.reset();
  return {};
}

void Player::Machine::refresh() {
  if (displayed) return;
  interpreter->refresh();
  displayed = true;
}

void Player::variable_values(std::vector<double>& values) {
  Machine& m = *machine_;
  m.refresh();
  values.clear();
  for (const PinView& pin : m.variables) values.push_back(pin.numbers()[0]);
}

void Player::display_frame(DisplayFrame& frame) {
  Machine& m = *machine_;
  m.refresh();
  const double* x = m.poses.numbers().data();
  const double* values = m.characters.numbers().data();
  frame.time = time();
  frame.characters.resize(m.world->characters().size());
  for (std::size_t i = 0; i < frame.characters.size(); ++i, values += lsi::character_entry_count) {
    DisplayCharacter& c = frame.characters[i];
    c.state = static_cast<CharacterState>(static_cast<std::uint32_t>(values[lsi::character_state]));
    c.assist_force = {values[lsi::character_force], values[lsi::character_force + 1], values[lsi::character_force + 2]};
    c.assist_moment = {values[lsi::character_moment], values[lsi::character_moment + 1], values[lsi::character_moment + 2]};
    c.assist_ratio = values[lsi::character_ratio];
    c.weight = values[lsi::character_weight];
    c.centre_of_mass = {values[lsi::character_centre], values[lsi::character_centre + 1], values[lsi::character_centre + 2]};
    c.links.resize(static_cast<std::size_t>(m.world->characters()[i].mechanism->link_count()));
    for (DisplayPose& pose : c.links) {
      pose = {{x[0], x[1], x[2]}, {x[3], x[4], x[5], x[6]}};
      x += 7;
    }
  }
  frame.contacts.clear();
  for (const lsi::ContactRecord& c : lsi::records<lsi::ContactRecord>(m.contacts.bytes.data()))
    if (norm(c.force) > 1e-9)  // N: far below any visible force; smaller forces count as no force
      frame.contacts.push_back({c.point.p, c.force, c.point.n, c.point.system_a, c.point.link_a});
  frame.grabbed = false;
  for (const EventRecord& e : lsi::records<EventRecord>(m.events.bytes.data())) {
    if (e.kind != EventKind::grab) continue;
    const DisplayPose& link = frame.characters[e.character].links[static_cast<std::size_t>(e.link)];
    frame.grabbed = true;
    frame.grab_point = link.p + rotate(link.r, e.a);
    frame.grab_target = e.b;
  }
}

void Player::pose_at(double time, DisplayFrame& frame) const {
  const Machine& m = *machine_;
  frame.time = time;
  frame.grabbed = false;
  frame.contacts.clear();
  frame.characters.resize(m.world->characters().size());
  for (std::size_t i = 0; i < frame.characters.size(); ++i) {
    const lsi::Character& character = m.world->characters()[i];
    const Mechanism& mechanism = *character.mechanism;
    std::vector<double> q = character.q0;
    if (character.track) {
      std::vector<double> reference(character.track->layout().size());
      character.track->sample(time, reference);
      std::copy_n(reference.begin(), q.size(), q.begin());
    }
    std::vector<Pose> X(static_cast<std::size_t>(mechanism.link_count()));
    calc_poses(mechanism, q, X);
    DisplayCharacter& c = frame.characters[i];
    c = DisplayCharacter{};
    c.state = CharacterState::edit;
    c.weight = mechanism.mass() * norm(m.world->gravity());
    c.centre_of_mass = centre_of_mass(mechanism, X);
    for (const Pose& pose : X) c.links.push_back({pose.p, to_quat(pose.R)});
  }
}

PlayerMeasures Player::measures(int character) {
  PlayerMeasures out;
  machine_->refresh();
  const double* x = machine_->measures.numbers().data() + static_cast<std::size_t>(character) * lsi::measure_count;
  out.tracking_rms_deg = x[lsi::measure_tracking];
  out.assist_rms_bw = x[lsi::measure_assist];
  out.assist_force_rms_bw = x[lsi::measure_assist_force];
  out.assist_max_bw = x[lsi::measure_assist_max];
  out.foot_skate_cm = x[lsi::measure_skate];
  out.foot_skate_worst_cm = x[lsi::measure_skate_worst];
  out.penetration_mm = x[lsi::measure_penetration];
  out.penetration_rms_mm = x[lsi::measure_penetration_rms];
  out.fell = x[lsi::measure_fell] > 0;
  out.release_time = x[lsi::measure_release_time];
  out.feet_on_ground = static_cast<int>(x[lsi::measure_feet]);
  out.tracking_now_deg = x[lsi::measure_tracking_now];
  out.assist_now_bw = x[lsi::measure_assist_now];
  out.slip_now_cm = x[lsi::measure_slip_now];
  out.depth_now_mm = x[lsi::measure_depth_now];
  std::copy_n(x + lsi::measure_totals, out.totals.size(), out.totals.begin());
  std::copy_n(x + lsi::measure_values, out.now.size(), out.now.begin());
  return out;
}

int Player::find_link(int character, std::string_view name) const {
  return content::find_link(*machine_->world->characters()[static_cast<std::size_t>(character)].mechanism, name);
}

}  // namespace ugoki::content
