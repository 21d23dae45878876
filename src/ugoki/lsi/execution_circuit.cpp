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

constexpr double measure_rate = 120;       // Hz
constexpr double column = 240, row = 320;  // distance of LSIs in the editor

/// The character's id as part of an id in the circuit, where points separate pins.
std::string part_of_id(const std::string& id, std::set<std::string>& taken) {
  std::string part = id.substr(0, 40);
  std::replace(part.begin(), part.end(), '.', '_');
  const std::string base = part;
  for (int n = 2; !taken.insert(part).second; ++n) part = base + "-" + std::to_string(n);
  return part;
}

class Maker {
 public:
  Maker(std::size_t figures, double step) : every_(static_cast<std::uint32_t>(std::max(1.0, std::floor(1 / (measure_rate * step) + 0.5)))) {
    const double middle = figures > 1 ? row * static_cast<double>(figures - 1) / 2 : 0;
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
    c_.doc = "One tick: what happens, what each character shall do, torques, contact, dynamics, the new state.";
    c_.inputs = {pin("live", PinTypeId::event, "Inputs by hand.", "event.live")};
    c_.outputs = {pin("state", PinTypeId::state, "Positions and velocities.", "status.state"),
                  pin("contacts", PinTypeId::contacts, "With forces.", "dynamics.contacts"),
                  pin("events", PinTypeId::event, "What acts now.", "event.events"),
                  pin("poses", PinTypeId::pose, "Of all links.", "display.poses"),
                  pin("figures", PinTypeId::joint_values, "For viewers.", "display.figures"),
                  pin("measures", PinTypeId::joint_values, "Of naturalness.", "display.measures")};
  }

  void add_figure(const CircuitCharacter& who, std::size_t index) {
    const std::string part = part_of_id(who.id, taken_);
    const double y = row * static_cast<double>(index);
    const NamedValue character{"character", who.id};
    add("retrieval-" + part, "motion retrieval", 2, y - 140).parameters = {character};
    add("interpolation-" + part, "interpolation", 3, y - 140).parameters = {character};
    add("control-" + part, "motion control", 4, y - 70).parameters = {
        character, {"tracking", who.tracking}, {"balance", who.balance}, {"assist limit", who.assist_limit}};
    Instance& naturalness = add("naturalness-" + part, "naturalness", 5, y + 70);
    naturalness.parameters = {character};
    naturalness.every = every_;
    for (const char* name : {"current", "previous", "blend"}) wire("retrieval-" + part + "." + name, "interpolation-" + part + "." + name);
    for (const char* to : {"control-", "naturalness-"}) {
      wire("status.state", to + part + ".state");
      wire("interpolation-" + part + ".reference", to + part + ".reference");
      wire("collision.contacts", to + part + ".contacts");
    }
    wire("control-" + part + ".report", "naturalness-" + part + ".report");
    wire("control-" + part + ".torque", "dynamics.torque");
    wire("control-" + part + ".report", "display.reports");
    wire("naturalness-" + part + ".measures", "display.measures");
  }

  Circuit take() { return std::move(c_); }

 private:
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
  std::set<std::string> taken_;
};

}  // namespace

Circuit make_execution_circuit(const std::vector<CircuitCharacter>& characters, double step) {
  std::vector<const CircuitCharacter*> figures;
  for (const CircuitCharacter& c : characters)
    if (c.follows_track) figures.push_back(&c);
  Maker maker(figures.size(), step);
  for (std::size_t i = 0; i < figures.size(); ++i) maker.add_figure(*figures[i], i);
  return maker.take();
}

}  // namespace ugoki::lsi
