#include "ugoki/lsi/execution_circuit.h"

#include <algorithm>
#include <cmath>
#include <set>

namespace ugoki::lsi {
namespace {

using circuit::BoundaryPin;
using circuit::Circuit;
using circuit::Instance;
using circuit::NamedValue;
using circuit::PinTypeId;

constexpr double measure_rate = 120;  // Hz, rate of naturalness measurements
/// rad/s: gain of motion control for characters that follow their track as exactly as possible. A recorded physical walk is followed within
/// 0.06 degrees rms and with 0.3 % of the body weight as root assist; with 20 rad/s within 0.23 degrees, with 150 rad/s no better than with
/// 90. Test: torque_motion_test.cpp.
constexpr double path_frequency = 90;
constexpr double column = 240;              // spacing of LSIs in the editor, px
constexpr double row = 200, tall_row = 220;  // outermost level; inside the circuit of a character

/// Converts a character's id to the id of its circuit: replaces characters that separate the parts of names, shortens the id, and makes it
/// unique.
std::string id_part(const std::string& id, std::set<std::string>& used) {
  std::string part = id.substr(0, 40);
  for (char& c : part)
    if (c == '.' || c == '/') c = '_';
  if (part.starts_with("rule-") || part.starts_with("variable-")) part = "character-" + part;  // ids of generated LSIs
  const std::string base = part;
  for (int n = 2; !used.insert(part).second; ++n) part = base + "-" + std::to_string(n);
  return part;
}

/// Adds LSIs and wires to a circuit.
class Board {
 public:
  explicit Board(Circuit& circuit) : c_(circuit) {}
  Instance& add(std::string id, std::string type, double x, double y) {
    Instance lsi;
    lsi.id = std::move(id);
    lsi.type = std::move(type);
    lsi.at = {x, y};
    c_.lsis.push_back(std::move(lsi));
    return c_.lsis.back();
  }
  void wire(std::string from, std::string to) { c_.wires.push_back({std::move(from), std::move(to)}); }

 private:
  Circuit& c_;
};

BoundaryPin pin(std::string name, PinTypeId type, std::string doc, std::vector<std::string> ends) {
  return {std::move(name), type, "", std::move(doc), std::move(ends)};
}

/// The nested circuit of a character that follows a track: reference motion, control torques and measures.
Circuit make_character(const CircuitCharacter& who, const std::string& name, std::uint32_t measure_every) {
  using Drive = CircuitCharacter::Drive;
  Circuit c;
  c.name = name;
  c.doc = "One character: the motion of its track, the torques that follow it, and measures of naturalness.";
  Board board(c);
  const NamedValue character{"character", who.id};
  const bool balances = who.drive == Drive::control && who.assist_limit == 0;  // no root assist: the character balances itself
  const bool torques = who.drive == Drive::torque;
  std::string reference = "control.reference";
  c.inputs_at = circuit::Position{-column, tall_row / 2};
  if (!balances) {
    const std::string source = who.has_moves ? "choice" : "retrieval";
    Instance& motion = board.add(source, who.has_moves ? "motion choice" : "motion retrieval", 0, 0);
    motion.parameters = {character};
    if (who.drive != Drive::control && !who.has_moves) motion.parameters.emplace_back("smooth", false);
    board.add("interpolation", "interpolation", column, 0).parameters = {character};
    for (const char* output : {"current", "previous", "blend"}) board.wire(source + "." + output, std::string("interpolation.") + output);
    reference = "interpolation.reference";
  }
  Instance& control =
      board.add("control", balances ? "balance control" : torques ? "motion torques" : "motion control", 2 * column, tall_row / 2);
  control.parameters = {character};
  const auto set = [&](const char* parameter, double value) { control.parameters.emplace_back(parameter, value); };
  if (balances) {
    if (who.swing > 0) set("swing", who.swing);
  } else if (who.drive == Drive::path) {
    set("assist limit", 10);
    set("joint frequency", path_frequency);
    set("root frequency", path_frequency);
    set("patience", 100);
  } else if (!torques) {
    set("tracking", who.tracking);
    set("balance", who.balance);
    set("assist limit", who.assist_limit);
    board.wire(reference, "control.reference");
  }
  if (who.drive == Drive::path) board.wire(reference, "control.reference");
  Instance& naturalness = board.add("naturalness", "naturalness", 3 * column, tall_row);
  naturalness.parameters = {character};
  naturalness.every = measure_every;
  board.wire(reference, "naturalness.reference");
  board.wire("control.report", "naturalness.report");

  std::vector<std::string> states = {"naturalness.state"}, contacts = {"naturalness.contacts"};
  if (!torques) {
    states.insert(states.begin(), "control.state");
    contacts.insert(contacts.begin(), "control.contacts");
  }
  c.inputs = {pin("state", PinTypeId::state, "Positions and velocities.", std::move(states)),
              pin("contacts", PinTypeId::contacts, "Contact points without forces.", std::move(contacts))};
  if (balances && who.grips) c.inputs.push_back(pin("grips", PinTypeId::event, "Grips of the last tick.", {"control.grips"}));
  if (!balances && who.has_moves)
    c.inputs.push_back(pin("choice", PinTypeId::scalar, "Number of the motion to play; 0: the track.", {"choice.choice"}));
  c.inputs.push_back(pin("forces", PinTypeId::contacts, "Contact points with forces.", {"naturalness.forces"}));
  c.inputs.push_back(pin("applied", PinTypeId::joint_values, "Joint forces that acted.", {"naturalness.applied"}));
  c.outputs = {pin("torque", PinTypeId::joint_values, "Joint forces and root assist.", {"control.torque"}),
               pin("report", PinTypeId::joint_values, "State of control, which viewers show.", {"control.report"}),
               pin("measures", PinTypeId::joint_values, "Measures of naturalness.", {"naturalness.measures"})};
  if (!balances && who.has_moves) {
    c.outputs.push_back(pin("now", PinTypeId::scalar, "Number of the motion that plays.", {"choice.now"}));
    c.outputs.push_back(pin("ended", PinTypeId::scalar, "1 if the motion has ended.", {"choice.ended"}));
  }
  c.outputs_at = circuit::Position{4 * column, tall_row / 2};
  return c;
}

class Maker {
 public:
  /// @param followers  number of characters that follow a track
  Maker(std::size_t followers, double step)
      : board_(c_), every_(static_cast<std::uint32_t>(std::max(1.0, std::floor(1 / (measure_rate * step) + 0.5)))) {
    const double middle = followers > 1 ? row * static_cast<double>(followers - 1) / 2 : 0;
    board_.add("event", "event", 0, middle);
    board_.add("status", "status", column, middle);
    board_.add("collision", "collision analysis", column, middle + 140);
    board_.add("dynamics", "dynamics", 4 * column, middle);
    board_.add("display", "display", 5 * column, middle).every = 0;
    for (const Instance& lsi : c_.lsis) taken_.insert(lsi.id);
    taken_.insert("grips");
    board_.wire("event.events", "dynamics.events");
    board_.wire("event.events", "status.events");
    board_.wire("status.state", "collision.state");
    board_.wire("status.state", "dynamics.state");
    board_.wire("collision.contacts", "dynamics.contacts");
    board_.wire("dynamics.next", "status.next");
    board_.wire("status.state", "display.state");
    c_.name = "execution";
    c_.doc = "One tick: events, reference motion and control torques of each character, contacts, dynamics, new state.";
    c_.inputs = {pin("live", PinTypeId::event, "Events of the user.", {"event.live"})};
    c_.outputs = {pin("state", PinTypeId::state, "Positions and velocities.", {"status.state"}),
                  pin("contacts", PinTypeId::contacts, "Contact points with forces.", {"dynamics.contacts"}),
                  pin("events", PinTypeId::event, "Events that act now.", {"event.events"}),
                  pin("poses", PinTypeId::pose, "Poses of all links.", {"display.poses"}),
                  pin("characters", PinTypeId::joint_values, "Values of each character that viewers show.", {"display.characters"}),
                  pin("measures", PinTypeId::joint_values, "Measures of naturalness.", {"display.measures"})};
  }

  void add_character(const CircuitCharacter& who, std::size_t index) {
    const std::string id = id_part(who.id, taken_);
    c_.circuits.push_back(make_character(who, "character " + id, every_));
    board_.add(id, c_.circuits.back().name, 2.5 * column, row * static_cast<double>(index));
    for (const BoundaryPin& input : c_.circuits.back().inputs) {
      if (input.name == "grips") add_grips();
      if (const std::string from = source_of(input.name); !from.empty()) board_.wire(from, id + "." + input.name);
    }
    board_.wire(id + ".torque", "dynamics.torque");
    board_.wire(id + ".report", "display.reports");
    board_.wire(id + ".measures", "display.measures");
  }

  Circuit take() { return std::move(c_); }

 private:
  /// The output that feeds an input of the circuits of characters; empty: rules feed it.
  static std::string source_of(std::string_view input) {
    if (input == "state") return "status.state";
    if (input == "contacts") return "collision.contacts";
    if (input == "forces") return "dynamics.contacts";
    if (input == "applied") return "dynamics.applied";
    if (input == "grips") return "grips.out";
    return {};
  }
  /// Balance control gets the grips of the last tick.
  void add_grips() {
    if (has_grips_) return;
    has_grips_ = true;
    board_.add("grips", "delay event", 2.5 * column, -row);
    board_.wire("dynamics.grips", "grips.in");
  }

  Circuit c_;
  Board board_;
  std::uint32_t every_;
  bool has_grips_ = false;
  std::set<std::string> taken_;
};

}  // namespace

Circuit make_execution_circuit(const std::vector<CircuitCharacter>& characters, double step) {
  std::vector<const CircuitCharacter*> followers;
  for (const CircuitCharacter& c : characters)
    if (c.follows_track) followers.push_back(&c);
  Maker maker(followers.size(), step);
  for (std::size_t i = 0; i < followers.size(); ++i) maker.add_character(*followers[i], i);
  return maker.take();
}

}  // namespace ugoki::lsi
