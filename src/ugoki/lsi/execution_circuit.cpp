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
constexpr double column = 240, row = 320;  // spacing of LSIs in the editor, px

/// Converts a character's id to a part of LSI ids, which must not contain '.': replaces '.', shortens the id, and makes it unique.
std::string id_part(const std::string& id, std::set<std::string>& used) {
  std::string part = id.substr(0, 40);
  std::replace(part.begin(), part.end(), '.', '_');
  const std::string base = part;
  for (int n = 2; !used.insert(part).second; ++n) part = base + "-" + std::to_string(n);
  return part;
}

class Maker {
 public:
  /// @param followers  number of characters that follow a track
  Maker(std::size_t followers, double step)
      : every_(static_cast<std::uint32_t>(std::max(1.0, std::floor(1 / (measure_rate * step) + 0.5)))) {
    const double middle = followers > 1 ? row * static_cast<double>(followers - 1) / 2 : 0;
    add("event", "event", 0, middle);
    add("status", "status", 1, middle);
    add("collision", "collision analysis", 1, middle + 140);
    add("dynamics", "dynamics", 6, middle);
    add("display", "display", 7, middle).every = 0;
    wire("event.events", "dynamics.events");
    wire("event.events", "status.events");
    wire("status.state", "collision.state");
    wire("status.state", "dynamics.state");
    wire("collision.contacts", "dynamics.contacts");
    wire("dynamics.next", "status.next");
    wire("status.state", "display.state");
    c_.name = "execution";
    c_.doc = "One tick: events, reference motion of each character, control torques, contacts, dynamics, new state.";
    c_.inputs = {pin("live", PinTypeId::event, "Events of the user.", "event.live")};
    c_.outputs = {pin("state", PinTypeId::state, "Positions and velocities.", "status.state"),
                  pin("contacts", PinTypeId::contacts, "Contact points with forces.", "dynamics.contacts"),
                  pin("events", PinTypeId::event, "Events that act now.", "event.events"),
                  pin("poses", PinTypeId::pose, "Poses of all links.", "display.poses"),
                  pin("characters", PinTypeId::joint_values, "Values of each character that viewers show.", "display.characters"),
                  pin("measures", PinTypeId::joint_values, "Measures of naturalness.", "display.measures")};
  }

  void add_character(const CircuitCharacter& who, std::size_t index) {
    const std::string part = id_part(who.id, taken_);
    const double y = row * static_cast<double>(index);
    const NamedValue character{"character", who.id};
    Instance& naturalness = add("naturalness-" + part, "naturalness", 5, y + 70);
    naturalness.parameters = {character};
    naturalness.every = every_;
    if (who.drive == CircuitCharacter::Drive::control && who.assist_limit == 0) {  // no root assist: the character balances itself
      Instance& control = add("control-" + part, "balance control", 4, y - 70);
      control.parameters = {character};
      if (who.swing > 0) control.parameters.emplace_back("swing", who.swing);
      wire("status.state", "control-" + part + ".state");
      wire("collision.contacts", "control-" + part + ".contacts");
      if (who.grips) wire_grips(part);
      wire("status.state", "naturalness-" + part + ".state");
      wire("control-" + part + ".reference", "naturalness-" + part + ".reference");
      wire("collision.contacts", "naturalness-" + part + ".contacts");
      wire_outputs(part);
      return;
    }
    const std::string source = (who.has_moves ? "choice-" : "retrieval-") + part;
    Instance& reference = add(source, who.has_moves ? "motion choice" : "motion retrieval", 2, y - 140);
    reference.parameters = {character};
    if (who.drive != CircuitCharacter::Drive::control && !who.has_moves) reference.parameters.emplace_back("smooth", false);
    add("interpolation-" + part, "interpolation", 3, y - 140).parameters = {character};
    for (const char* name : {"current", "previous", "blend"}) wire(source + "." + name, "interpolation-" + part + "." + name);
    if (who.drive == CircuitCharacter::Drive::path) {
      add("control-" + part, "motion control", 4, y - 70).parameters = {
          character, {"assist limit", 10.0}, {"joint frequency", path_frequency}, {"root frequency", path_frequency}, {"patience", 100.0}};
    } else if (who.drive == CircuitCharacter::Drive::torque) {
      add("control-" + part, "motion torques", 4, y - 70).parameters = {character};
    } else {
      add("control-" + part, "motion control", 4, y - 70).parameters = {
          character, {"tracking", who.tracking}, {"balance", who.balance}, {"assist limit", who.assist_limit}};
    }
    for (const char* to : {"control-", "naturalness-"}) {
      if (who.drive == CircuitCharacter::Drive::torque && std::string_view(to) == "control-") continue;
      wire("status.state", to + part + ".state");
      wire("interpolation-" + part + ".reference", to + part + ".reference");
      wire("collision.contacts", to + part + ".contacts");
    }
    wire_outputs(part);
  }

  Circuit take() { return std::move(c_); }

 private:
  /// Balance control gets the grips of the last tick.
  void wire_grips(const std::string& part) {
    if (!has_grips_) {
      has_grips_ = true;
      add("grips", "delay event", 3, -180);
      wire("dynamics.grips", "grips.in");
    }
    wire("grips.out", "control-" + part + ".grips");
  }
  void wire_outputs(const std::string& part) {
    wire("control-" + part + ".report", "naturalness-" + part + ".report");
    wire("control-" + part + ".torque", "dynamics.torque");
    wire("control-" + part + ".report", "display.reports");
    wire("dynamics.contacts", "naturalness-" + part + ".forces");
    wire("dynamics.applied", "naturalness-" + part + ".applied");
    wire("naturalness-" + part + ".measures", "display.measures");
  }
  static BoundaryPin pin(std::string name, PinTypeId type, std::string doc, std::string end) {
    return {std::move(name), type, "", std::move(doc), {std::move(end)}};
  }
  Instance& add(std::string id, std::string type, int at_column, double y) {
    Instance lsi;
    lsi.id = std::move(id);
    lsi.type = std::move(type);
    lsi.at = {column * at_column, y};
    c_.lsis.push_back(std::move(lsi));
    return c_.lsis.back();
  }
  void wire(std::string from, std::string to) { c_.wires.push_back({std::move(from), std::move(to)}); }

  Circuit c_;
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
