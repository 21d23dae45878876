#include "ugoki/publish/fmu_circuit.h"

#include <algorithm>
#include <set>

namespace ugoki::publish {
namespace {

using circuit::Circuit;
using circuit::Instance;
using circuit::PinTypeId;

constexpr double column = 240, row = 130;  // spacing of the added LSIs in the editor, px
constexpr double below = 1200;             // y of the first added LSI, px: below those of usual execution circuits

class Maker {
 public:
  Maker(Circuit circuit, const content::Executable& content, std::string name) : c_(std::move(circuit)), content_(content) {
    c_.name = std::move(name);
  }

  Result<Circuit> make(const std::string& location) {
    const std::string dynamics = only("dynamics"), status = only("status");
    if (dynamics.empty() || status.empty())
      return fail(ErrorCode::unsupported, location,
                  "The circuit does not have exactly one LSI 'dynamics' and one LSI 'status' at its outermost level.",
                  "Use the generated circuit, or export a circuit of your own with `ugoki circuit export-fmu`.");
    for (const Instance& lsi : c_.lsis) used_.insert(lsi.id);
    // the player's outputs: only the display needs them
    std::erase_if(c_.outputs, [](const auto& pin) {
      static const std::set<std::string> of_player = {"state", "contacts", "events", "poses", "characters", "measures"};
      return of_player.contains(pin.name) || pin.type == PinTypeId::contacts || pin.type == PinTypeId::event;
    });
    std::erase_if(c_.inputs, [](const auto& pin) { return pin.type == PinTypeId::event; });
    remove_displays();
    for (const content::ExecutableCharacter& who : content_.characters) add_character(who, dynamics, status);
    return std::move(c_);
  }

 private:
  /// Id of the only LSI of a class; empty if there is none or more than one.
  [[nodiscard]] std::string only(std::string_view type) const {
    std::string found;
    for (const Instance& lsi : c_.lsis) {
      if (lsi.type != type) continue;
      if (!found.empty()) return {};
      found = lsi.id;
    }
    return found;
  }
  void remove_displays() {
    for (std::string id = any("display"); !id.empty(); id = any("display")) {
      std::erase_if(c_.lsis, [&](const Instance& lsi) { return lsi.id == id; });
      std::erase_if(c_.wires, [&](const circuit::Wire& w) { return w.from.starts_with(id + ".") || w.to.starts_with(id + "."); });
    }
  }
  [[nodiscard]] std::string any(std::string_view type) const {
    const auto found = std::find_if(c_.lsis.begin(), c_.lsis.end(), [&](const Instance& lsi) { return lsi.type == type; });
    return found == c_.lsis.end() ? std::string() : found->id;
  }

  void add_character(const content::ExecutableCharacter& who, const std::string& dynamics, const std::string& status) {
    std::string id = who.id;
    std::replace(id.begin(), id.end(), '.', '_');
    std::replace(id.begin(), id.end(), '/', '_');  // of instances: "duet.1/human"
    const Mechanism& m = *content_.mechanisms[static_cast<std::size_t>(who.mechanism)];
    const std::string root = m.link(0).name, push = add("push-" + id, "push", 0), pose = add("pose-" + id, "link pose", 1),
                      split = add("split-" + id, "split pose", 2), centre = add("centre-" + id, "centre of mass", 1),
                      q = add("coordinates-" + id, "coordinates", 1);
    for (const std::string& lsi : {push, pose, centre, q}) find(lsi).parameters = {{"character", who.id}};
    find(pose).parameters.emplace_back("link", root);
    find(push).parameters.emplace_back("link", root);
    find(push).values = {{"when", 1.0}};
    const auto events = std::find_if(c_.wires.begin(), c_.wires.end(), [&](const circuit::Wire& w) { return w.to == dynamics + ".events"; });
    if (events == c_.wires.end()) {
      wire(push + ".events", dynamics + ".events");
    } else {
      const std::string before = events->from;
      events->from = push + ".events";
      wire(before, push + ".events");
    }
    for (const std::string& lsi : {pose, centre, q}) wire(status + ".state", lsi + ".state");
    wire(pose + ".pose", split + ".in");
    c_.inputs.push_back({id + ":push", PinTypeId::vector, "N", "Force on the centre of mass of the root link, world axes.", {push + ".force"}});
    output(id + ":position", PinTypeId::vector, "m", "Position of the root link, world axes.", split + ".position");
    output(id + ":rotation", PinTypeId::rotation, "", "Rotation of the root link, world axes: quaternion w x y z.", split + ".rotation");
    output(id + ":velocity", PinTypeId::vector, "m/s", "Velocity of the origin of the root link, world axes.", pose + ".velocity");
    output(id + ":centre of mass", PinTypeId::vector, "m", "Centre of mass, world axes.", centre + ".position");
    output(id + ":q", PinTypeId::joint_values, "", "Position coordinates of all joints.", q + ".q");
    output(id + ":v", PinTypeId::joint_values, "", "Velocities of all degrees of freedom.", q + ".v");
    if (const std::string measures = measures_of(c_, who.id); !measures.empty())
      output(id + ":measures", PinTypeId::joint_values, "", "Measures of naturalness (docs/circuit.md).", measures);
  }
  /// The output of `circuit` with the measures of a character, of an LSI or of a nested circuit; empty: there is none.
  std::string measures_of(const Circuit& circuit, const std::string& character) const {
    for (const Instance& lsi : circuit.lsis) {
      if (lsi.type == "naturalness" && has_character(lsi, character)) return lsi.id + ".measures";
      const auto inner = std::ranges::find(circuit.circuits, lsi.type, &Circuit::name);
      if (inner == circuit.circuits.end()) continue;
      const std::string inside = measures_of(*inner, character);
      for (const circuit::BoundaryPin& out : inner->outputs)
        if (!inside.empty() && out.ends == std::vector{inside}) return lsi.id + "." + out.name;
    }
    return {};
  }
  static bool has_character(const Instance& lsi, const std::string& id) {
    return std::any_of(lsi.parameters.begin(), lsi.parameters.end(),
                       [&](const auto& p) { return p.first == "character" && p.second == circuit::Value(id); });
  }
  void output(std::string name, PinTypeId type, std::string unit, std::string doc, std::string end) {
    c_.outputs.push_back({std::move(name), type, std::move(unit), std::move(doc), {std::move(end)}});
  }

  /// Adds an LSI. @return its id: `wanted`, with a number if the circuit has this id
  std::string add(const std::string& wanted, std::string type, int at_column) {
    Instance lsi;
    lsi.id = wanted;
    for (int n = 2; !used_.insert(lsi.id).second; ++n) lsi.id = wanted + "-" + std::to_string(n);
    lsi.type = std::move(type);
    lsi.at = {column * at_column, below + row * static_cast<double>(added_++)};
    c_.lsis.push_back(lsi);
    return lsi.id;
  }
  Instance& find(const std::string& id) {
    return *std::find_if(c_.lsis.begin(), c_.lsis.end(), [&](const Instance& lsi) { return lsi.id == id; });
  }
  void wire(std::string from, std::string to) { c_.wires.push_back({std::move(from), std::move(to)}); }

  Circuit c_;
  const content::Executable& content_;
  std::set<std::string> used_;
  int added_ = 0;
};

}  // namespace

Result<Circuit> make_fmu_circuit(const content::Executable& content, const std::string& name) {
  Result<Circuit> circuit = circuit::read_circuit(content.circuit, name + ", section circuit");
  if (!circuit) return circuit;
  return Maker(std::move(*circuit), content, name).make(name + ", section circuit");
}

}  // namespace ugoki::publish
