#include "ugoki/fmi/interface.h"

#include <algorithm>
#include <map>
#include <set>

#include "ugoki/circuit/flatten.h"

namespace ugoki::fmi {
namespace {

using circuit::BoundaryParameter;
using circuit::BoundaryPin;
using circuit::Circuit;
using circuit::FlatCircuit;
using circuit::FlatLsi;
using circuit::Instance;
using circuit::Source;
using circuit::Value;

/// Splits "id.pin" into id and pin.
std::pair<std::string_view, std::string_view> split(std::string_view end) {
  const auto dot = end.find('.');
  return {end.substr(0, dot), dot == std::string_view::npos ? std::string_view{} : end.substr(dot + 1)};
}

/// Makes the FMU variables of one circuit.
class Maker {
 public:
  Maker(const Circuit& c, const circuit::Library& library, circuit::Interpreter& running)
      : circuit_(c), running_(running), flat_(circuit::flatten(c, library, problems_)) {}

  Interface make() {
    add_time();
    for (std::size_t i = 0; i < circuit_.inputs.size(); ++i) add_input(i);
    for (const circuit::DeviceSlot& d : running_.devices()) add_device(d);
    for (std::size_t i = 0; i < circuit_.outputs.size(); ++i) add_output(i);
    for (const BoundaryParameter& p : circuit_.parameters) add_parameter(p);
    return std::move(out_);
  }

 private:
  /// A name that no other variable has: `name` without control characters, if necessary with " (role)" and apostrophes.
  std::string unique(std::string name, const std::string& role) {
    for (char& c : name)
      if (static_cast<unsigned char>(c) < ' ') c = ' ';
    if (!names_.contains(name)) return *names_.insert(name).first;
    name += " (" + role + ")";
    while (!names_.insert(name).second) name += "'";
    return name;
  }

  /// Adds a variable with the next value reference.
  InterfaceVariable& add(InterfaceVariable v) {
    v.reference = next_;
    next_ += std::max(1u, v.count);
    out_.variables.push_back(std::move(v));
    return out_.variables.back();
  }

  void add_time() {
    InterfaceVariable v;
    v.name = unique("time", "time");
    v.doc = "Simulation time";
    v.unit = "s";
    v.role = InterfaceRole::time;
    v.start = {0};
    add(std::move(v));
  }

  /// Sets size and start values of a variable. @return false, with a note, if the pin type is not numeric
  bool size_pin(InterfaceVariable& v, circuit::PinTypeId type, std::size_t numbers, const std::string& role) {
    if (!circuit::pin_type(type).numeric) {
      out_.notes.push_back("The " + role + " '" + v.target + "' (" + std::string(circuit::pin_type(type).name) +
                           ") has no numeric values and is left out.");
      return false;
    }
    v.count = static_cast<std::uint32_t>(numbers);
    v.array = type != circuit::PinTypeId::scalar;
    v.start.assign(numbers, 0.0);
    if (type == circuit::PinTypeId::rotation) v.start[0] = 1;
    if (type == circuit::PinTypeId::pose) v.start[3] = 1;
    return true;
  }

  /// Copies the range of a pin to the variable, unless the start value of an input is outside the range, which the standard forbids.
  template <class Pin>
  static void set_range(InterfaceVariable& v, const Pin& pin) {
    if (pin.minimum == pin.maximum || v.minimum) return;
    const bool starts_inside = std::all_of(v.start.begin(), v.start.end(), [&](double x) { return x >= pin.minimum && x <= pin.maximum; });
    if (!starts_inside && v.role != InterfaceRole::output) return;
    v.minimum = pin.minimum;
    v.maximum = pin.maximum;
  }

  void add_input(std::size_t i) {
    const BoundaryPin& pin = circuit_.inputs[i];
    InterfaceVariable v;
    v.role = InterfaceRole::input;
    v.target = pin.name;
    if (!size_pin(v, pin.type, running_.find_circuit_input(pin.name).size() / sizeof(double), "input")) return;
    v.name = unique(pin.name, "input");
    v.doc = pin.doc;
    v.unit = pin.unit;
    for (const FlatLsi& lsi : flat_.lsis)
      for (std::size_t k = 0; k < lsi.inputs.size(); ++k) {
        const auto& sources = lsi.inputs[k].sources;
        if (std::find(sources.begin(), sources.end(), flat_.inputs[i].source) == sources.end()) continue;
        const circuit::InputPin& inner = lsi.lsi_class->inputs[k];
        if (v.unit.empty()) v.unit = inner.unit;
        if (v.doc.empty()) v.doc = inner.doc;
        set_range(v, inner);
      }
    by_source_[flat_.inputs[i].source.lsi].push_back(static_cast<std::uint32_t>(out_.variables.size()));
    add(std::move(v));
  }

  void add_device(const circuit::DeviceSlot& d) {
    InterfaceVariable v;
    v.role = InterfaceRole::device;
    v.target = d.id + "." + d.pin;
    v.name = unique(v.target, "device");
    v.doc = "The " + d.device + (d.address.empty() ? "" : " '" + d.address + "'");
    v.count = static_cast<std::uint32_t>(d.numbers.size());
    v.array = v.count != 1;
    v.start.assign(d.numbers.begin(), d.numbers.end());
    for (std::size_t i = 0; i < flat_.lsis.size(); ++i)
      if (flat_.lsis[i].id == d.id) by_source_[static_cast<int>(i)].push_back(static_cast<std::uint32_t>(out_.variables.size()));
    add(std::move(v));
  }

  void add_output(std::size_t i) {
    const BoundaryPin& pin = circuit_.outputs[i];
    const Source source = flat_.outputs[i].source;
    const FlatLsi& lsi = flat_.lsis[static_cast<std::size_t>(source.lsi)];
    const circuit::OutputPin& inner = lsi.lsi_class->outputs[static_cast<std::size_t>(source.pin)];
    InterfaceVariable v;
    v.role = InterfaceRole::output;
    v.target = pin.name;
    const auto view = running_.find_circuit_output(pin.name);
    if (!size_pin(v, pin.type, view ? view->bytes.size() / sizeof(double) : 0, "output")) return;
    v.name = unique(pin.name, "output");
    v.doc = pin.doc.empty() ? inner.doc : pin.doc;
    v.unit = pin.unit.empty() ? inner.unit : pin.unit;
    v.source = lsi.id + "." + inner.name;
    v.on_demand = lsi.every == 0;
    set_range(v, inner);
    std::set<std::uint32_t> depends;
    std::set<int> seen;
    if (!inner.delayed) collect(source.lsi, depends, seen);
    v.depends.assign(depends.begin(), depends.end());
    add(std::move(v));
  }

  /// Collects the inputs and devices that affect the feed-through outputs of the LSI `first` in the same tick.
  void collect(int first, std::set<std::uint32_t>& depends, std::set<int>& seen) const {
    std::vector<int> open{first};
    while (!open.empty()) {
      const int lsi = open.back();
      open.pop_back();
      if (!seen.insert(lsi).second) continue;
      if (const auto found = by_source_.find(lsi); found != by_source_.end()) depends.insert(found->second.begin(), found->second.end());
      const FlatLsi& flat = flat_.lsis[static_cast<std::size_t>(lsi)];
      for (std::size_t k = 0; k < flat.inputs.size(); ++k) {
        if (!flat.lsi_class->inputs[k].direct) continue;
        for (const Source& s : flat.inputs[k].sources)
          if (!flat_.lsis[static_cast<std::size_t>(s.lsi)].lsi_class->outputs[static_cast<std::size_t>(s.pin)].delayed)
            open.push_back(s.lsi);
      }
    }
  }

  /// Finds the parameters of LSIs that a circuit's parameter sets, through nested circuits.
  /// @param scope  enclosing circuits, innermost last
  /// @param prefix path of the innermost circuit, with a slash: "box/"; empty for the outermost circuit
  /// @param end    what the parameter sets in the innermost circuit: "id.parameter" of an LSI or of a nested circuit
  /// @param ends   [in, out] the parameters found are appended, with their paths: "box/noise.seed"
  void resolve(std::vector<const Circuit*>& scope, const std::string& prefix, std::string_view end, std::vector<std::string>& ends) const {
    const auto [id, parameter] = split(end);
    const auto& lsis = scope.back()->lsis;
    const auto instance = std::find_if(lsis.begin(), lsis.end(), [wanted = id](const Instance& i) { return i.id == wanted; });
    if (instance == lsis.end()) return;
    for (std::size_t level = scope.size(); level-- > 0;)
      for (const Circuit& inner : scope[level]->circuits) {
        if (inner.name != instance->type) continue;
        scope.push_back(&inner);
        for (const BoundaryParameter& p : inner.parameters)
          if (p.name == parameter)
            for (const std::string& e : p.ends) resolve(scope, prefix + instance->id + "/", e, ends);
        scope.pop_back();
        return;
      }
    ends.push_back(prefix + std::string(end));
  }

  void add_parameter(const BoundaryParameter& p) {
    InterfaceVariable v;
    v.role = InterfaceRole::parameter;
    v.target = p.name;
    v.doc = p.doc;
    std::vector<const Circuit*> scope{&circuit_};
    for (const std::string& end : p.ends) resolve(scope, "", end, v.ends);
    v.tunable = true;
    bool known = false;
    for (const std::string& end : v.ends) {
      const auto [id, name] = split(end);
      const auto lsi = std::find_if(flat_.lsis.begin(), flat_.lsis.end(), [wanted = id](const FlatLsi& l) { return l.id == wanted; });
      const int k = lsi == flat_.lsis.end() ? -1 : lsi->lsi_class->find_parameter(name);
      if (k < 0) continue;
      const circuit::Parameter& inner = lsi->lsi_class->parameters[static_cast<std::size_t>(k)];
      v.tunable = v.tunable && inner.live && inner.kind != circuit::ParameterKind::text;
      if (known) continue;
      known = true;
      describe(v, inner, lsi->parameters[static_cast<std::size_t>(k)]);
    }
    if (!known) {
      out_.notes.push_back("The parameter '" + p.name + "' leads to no parameter of an LSI and is left out.");
      return;
    }
    v.name = unique(p.name, "parameter");
    add(std::move(v));
  }

  /// Sets the type, start value and range of the variable of a parameter.
  static void describe(InterfaceVariable& v, const circuit::Parameter& inner, const Value& value) {
    if (v.doc.empty()) v.doc = inner.doc;
    v.unit = inner.unit;
    v.start = {0};
    switch (inner.kind) {
      case circuit::ParameterKind::number:
      case circuit::ParameterKind::integer:
        v.type = inner.kind == circuit::ParameterKind::number ? InterfaceType::real : InterfaceType::whole;
        v.start[0] = std::get<double>(value);
        break;
      case circuit::ParameterKind::boolean:
        v.type = InterfaceType::boolean;
        v.start[0] = std::get<bool>(value) ? 1 : 0;
        break;
      case circuit::ParameterKind::text:
        v.type = InterfaceType::text;
        v.text = std::get<std::string>(value);
        break;
      case circuit::ParameterKind::choice:
        v.type = InterfaceType::choice;
        v.words = inner.choices;
        v.start[0] = static_cast<double>(std::find(v.words.begin(), v.words.end(), std::get<std::string>(value)) - v.words.begin()) + 1;
        break;
      case circuit::ParameterKind::vector:
        v.start = std::get<std::vector<double>>(value);
        v.count = 3;
        v.array = true;
        break;
    }
    if (v.type != InterfaceType::real && v.type != InterfaceType::whole) return;
    if (inner.minimum > -1e300) v.minimum = inner.minimum;
    if (inner.maximum < 1e300) v.maximum = inner.maximum;
  }

  const Circuit& circuit_;
  circuit::Interpreter& running_;
  Error problems_;
  FlatCircuit flat_;
  Interface out_;
  std::set<std::string> names_;
  std::map<int, std::vector<std::uint32_t>> by_source_;  // index of an LSI in the flattened circuit -> variables that set its outputs
  std::uint32_t next_ = 0;
};

}  // namespace

Interface make_interface(const Circuit& circuit, const circuit::Library& library, circuit::Interpreter& running) {
  return Maker(circuit, library, running).make();
}

void set_parameter(Circuit& circuit, std::string_view parameter, const Value& value) {
  for (const BoundaryParameter& p : circuit.parameters) {
    if (p.name != parameter) continue;
    for (const std::string& end : p.ends) {
      const auto [id, name] = split(end);
      for (Instance& lsi : circuit.lsis) {
        if (lsi.id != id) continue;
        const auto found =
            std::find_if(lsi.parameters.begin(), lsi.parameters.end(), [n = name](const circuit::NamedValue& v) { return v.first == n; });
        if (found != lsi.parameters.end())
          found->second = value;
        else
          lsi.parameters.emplace_back(std::string(name), value);
      }
    }
  }
}

}  // namespace ugoki::fmi
