#include "ugoki/circuit/flatten.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <set>

#include "ugoki/base/number.h"

namespace ugoki::circuit {
namespace {

// Limits for circuits that grow without bound when nested circuits are expanded. A circuit beyond these limits is refused.
constexpr std::size_t max_items = 200000;      // number of LSIs and circuits after expansion
constexpr std::size_t max_searches = 1000000;  // number of inputs visited while wires are followed into nested circuits
constexpr std::uint32_t max_every = 1000000;   // ticks; products of nested `every` are clamped to this value

/// The class of the placeholder LSI for an input of the outermost circuit: it has one output and no functions.
const LsiClass& input_class(PinTypeId type) {
  static const std::vector<LsiClass> classes = [] {
    std::vector<LsiClass> all;
    for (const PinType& t : pin_types()) {
      LsiClass c;
      c.name = "circuit input";
      OutputPin pin;
      pin.name = "value";
      pin.type = t.id;
      c.outputs.push_back(pin);
      all.push_back(std::move(c));
    }
    return all;
  }();
  return classes[static_cast<std::size_t>(type) - 1];
}

struct Level;
struct Item {
  int lsi = -1;
  std::unique_ptr<Level> level;  ///< the nested circuit; null: the item is an LSI
};
/// One use of a circuit: the outermost one, or one nested in `outer`.
struct Level {
  const Circuit* circuit = nullptr;
  const Level* outer = nullptr;
  std::string prefix;  ///< prefix of the ids of this circuit's LSIs: "arm/"
  std::string location;
  std::map<std::string, Item, std::less<>> items;
};

struct Sink {
  int lsi, pin;
};

/// A parameter value that is set either at the LSI itself or at a circuit that contains the LSI.
struct Override {
  std::string end;  ///< the parameter that the value sets, "id.parameter"
  Value value;
  std::string location;  ///< JSON path of the value
};

std::pair<std::string_view, std::string_view> split(std::string_view end) {
  const auto dot = end.find('.');
  return {end.substr(0, dot), end.substr(dot + 1)};
}

const char* words(ParameterKind kind) {
  switch (kind) {
    case ParameterKind::number: return "a number";
    case ParameterKind::integer: return "a whole number";
    case ParameterKind::boolean: return "true or false";
    case ParameterKind::text: return "a string";
    case ParameterKind::choice: return "one of its words";
    case ParameterKind::vector: return "a list of three numbers";
  }
  return "";
}

class Flattener {
 public:
  Flattener(const Library& library, Error& problems) : library_(library), problems_(problems) {}

  FlatCircuit flatten(const Circuit& circuit) {
    Level top;
    top.circuit = &circuit;
    top.location = "circuit";
    expand(top, 1, {});
    std::vector<int> ports;
    for (std::size_t i = 0; i < circuit.inputs.size(); ++i)
      ports.push_back(add_port(circuit.inputs[i], "circuit/inputs/" + std::to_string(i)));
    if (expanded_ > max_items) return std::move(flat_);
    connect(top);
    for (std::size_t i = 0; i < circuit.inputs.size(); ++i) connect_port(top, i, ports[i]);
    for (std::size_t i = 0; i < circuit.outputs.size(); ++i) {
      const Source source = boundary_source(top, circuit.outputs[i], top.location + "/outputs/" + std::to_string(i));
      flat_.outputs.push_back({circuit.outputs[i].name, source});
    }
    check_inputs();
    if (problems_.empty()) sort_by_id();
    return std::move(flat_);
  }

 private:
  static constexpr std::size_t max_problems = 1000;

  void problem(ErrorCode code, std::string location, std::string message, std::string remedy) {
    if (problems_.problems.size() < max_problems) problems_.add(code, std::move(location), std::move(message), std::move(remedy));
  }

  const Circuit* find_circuit(const Level& level, std::string_view name) const {
    for (const Level* l = &level; l; l = l->outer)
      for (const Circuit& c : l->circuit->circuits)
        if (c.name == name) return &c;
    return nullptr;
  }

  /// Reports two entries of one list that have the same name, because the name would not identify an entry.
  template <class Parts>
  void check_names(const std::string& location, const char* field, const Parts& parts) {
    std::set<std::string_view> names;
    for (std::size_t i = 0; i < parts.size(); ++i)
      if (!names.insert(parts[i].name).second)
        problem(ErrorCode::duplicate, location + "/" + field + "/" + std::to_string(i) + "/name",
                std::string("Two ") + field + " are called '" + parts[i].name + "'.", "Rename one.");
  }

  /// Adds the LSIs and nested circuits of a level to the flat circuit.
  void expand(Level& level, std::uint32_t every, const std::vector<Override>& overrides) {
    const Circuit& circuit = *level.circuit;
    check_names(level.location, "inputs", circuit.inputs);
    check_names(level.location, "outputs", circuit.outputs);
    check_names(level.location, "parameters", circuit.parameters);
    check_names(level.location, "circuits", circuit.circuits);
    std::vector<std::vector<Override>> given(circuit.lsis.size());
    for (std::size_t i = 0; i < circuit.lsis.size(); ++i) {
      const std::string location = level.location + "/lsis/" + std::to_string(i);
      const Instance& lsi = circuit.lsis[i];
      for (std::size_t k = 0; k < lsi.parameters.size(); ++k)
        given[i].push_back(
            {lsi.id + "." + lsi.parameters[k].first, lsi.parameters[k].second, location + "/parameters/" + lsi.parameters[k].first});
    }
    std::map<std::string_view, std::size_t> index;
    for (std::size_t i = 0; i < circuit.lsis.size(); ++i) index.emplace(circuit.lsis[i].id, i);
    for (const Override& o : overrides) {
      const auto found = index.find(split(o.end).first);
      if (found == index.end()) {
        problem(ErrorCode::unknown, o.location,
                "The parameter sets '" + o.end + "', but there is no LSI '" + std::string(split(o.end).first) + "'.", "Correct the id.");
      } else {
        given[found->second].push_back(o);
      }
    }
    for (std::size_t i = 0; i < circuit.lsis.size() && expanded_ <= max_items; ++i) add_item(level, i, every, given[i]);
  }

  void add_item(Level& level, std::size_t i, std::uint32_t every, const std::vector<Override>& given) {
    const Instance& lsi = level.circuit->lsis[i];
    const std::string location = level.location + "/lsis/" + std::to_string(i);
    const std::string id = level.prefix + lsi.id;
    if (expanded_ >= max_items) {
      if (expanded_++ == max_items)
        problem(ErrorCode::range, location, "The circuit expands to more than " + std::to_string(max_items) + " LSIs.",
                "Use fewer nested circuits.");
      return;
    }
    ++expanded_;
    if (level.items.contains(lsi.id)) {
      problem(ErrorCode::duplicate, location + "/id", "Two LSIs have the id '" + id + "'.", "Give one of them another id.");
      return;
    }
    const std::uint64_t product = static_cast<std::uint64_t>(every) * lsi.every;
    const auto own_every = static_cast<std::uint32_t>(std::min<std::uint64_t>(product, max_every));
    if (const Circuit* inner = find_circuit(level, lsi.type)) {
      for (const Level* l = &level; l; l = l->outer) {
        if (l->circuit != inner) continue;
        problem(ErrorCode::structure, location + "/type", "The circuit '" + lsi.type + "' contains itself.", "Remove '" + id + "'.");
        return;
      }
      Item& item = level.items[lsi.id];
      item.level = std::make_unique<Level>();
      item.level->circuit = inner;
      item.level->outer = &level;
      item.level->prefix = id + "/";
      item.level->location = location + "(" + lsi.type + ")";
      expand(*item.level, own_every, pass_on(*inner, given, id));
      for (const NamedValue& v : lsi.values)
        problem(ErrorCode::unsupported, location + "/values/" + v.first,
                "The input '" + v.first + "' of a nested circuit cannot have a fixed value.",
                "Wire a constant to '" + id + "." + v.first + "'.");
      return;
    }
    const LsiClass* found = library_.find(lsi.type);
    if (!found) {
      missing(lsi.type.substr(0, 200), id, location + "/type");
      return;
    }
    FlatLsi flat;
    flat.id = id;
    flat.lsi_class = found;
    flat.location = location;
    flat.every = own_every;
    flat.inputs.resize(found->inputs.size());
    set_parameters(flat, given);
    set_values(flat, lsi, location);
    level.items[lsi.id].lsi = static_cast<int>(flat_.lsis.size());
    flat_.lsis.push_back(std::move(flat));
  }

  /// Reports an LSI class that is neither built in nor installed, and how to install it.
  void missing(const std::string& type, const std::string& id, std::string location) {
    const auto slash = type.find('/');
    if (slash == std::string::npos)
      return problem(
          ErrorCode::unknown, std::move(location),
          "The LSI '" + type + "' (used as '" + id + "') is missing: it is not a circuit defined here, and not in exactly one library.",
          "Install it, or replace '" + id + "'; the circuit keeps it until then.");
    const std::string library = type.substr(0, slash);
    if (const std::string* refused = library_.find_refusal(library))
      return problem(ErrorCode::unknown, std::move(location),
                     "The LSI '" + type.substr(slash + 1) + "' of the library '" + library + "' (used as '" + id +
                         "') is missing because the installed library was refused: " + *refused,
                     "Build the library again and install it, or replace '" + id + "'; the circuit keeps it until then.");
    const bool is_installed =
        std::any_of(library_.classes().begin(), library_.classes().end(), [&](const LsiClass& c) { return c.from == library; });
    problem(ErrorCode::unknown, std::move(location),
            "The LSI '" + type.substr(slash + 1) + "' of the library '" + library + "' (used as '" + id +
                "') is missing: " + (is_installed ? "the installed '" + library + "' does not have it." : "the library is not installed."),
            "Install it with `ugoki lsi install " + library + ".so` (or .fmu), or replace '" + id + "'; the circuit keeps it until then.");
  }

  /// Converts values given to parameters of a nested circuit to values for the inner parameters that these parameters set.
  std::vector<Override> pass_on(const Circuit& inner, const std::vector<Override>& given, const std::string& id) {
    std::vector<Override> out;
    for (const Override& o : given) {
      const std::string_view name = split(o.end).second;
      const auto found =
          std::find_if(inner.parameters.begin(), inner.parameters.end(), [&](const BoundaryParameter& p) { return p.name == name; });
      if (found == inner.parameters.end()) {
        problem(ErrorCode::unknown, o.location, "'" + id + "' has no parameter '" + std::string(name) + "'.",
                "Remove it, or correct its spelling.");
        continue;
      }
      for (const std::string& end : found->ends) out.push_back({end, o.value, o.location});
    }
    return out;
  }

  void set_parameters(FlatLsi& flat, const std::vector<Override>& given) {
    for (const Parameter& p : flat.lsi_class->parameters) flat.parameters.push_back(p.initial);
    for (const Override& o : given) {
      const std::string_view name = split(o.end).second;
      const int k = flat.lsi_class->find_parameter(name);
      if (k < 0) {
        std::string all;
        for (const Parameter& p : flat.lsi_class->parameters) all += (all.empty() ? "" : ", ") + p.name;
        problem(ErrorCode::unknown, o.location, "'" + flat.id + "' has no parameter '" + std::string(name) + "'.",
                all.empty() ? "Remove it: this LSI has no parameters." : "Use one of: " + all + ".");
        continue;
      }
      const Parameter& p = flat.lsi_class->parameters[static_cast<std::size_t>(k)];
      if (fits(p, o.value)) {
        flat.parameters[static_cast<std::size_t>(k)] = o.value;
      } else {
        std::string remedy = "Give " + std::string(words(p.kind));
        if (p.kind == ParameterKind::choice) {
          remedy += ":";
          for (const std::string& c : p.choices) remedy += " " + c;
        } else if (p.kind != ParameterKind::text && p.kind != ParameterKind::boolean) {
          if (p.minimum > -1e300) remedy += " from " + to_text(p.minimum);
          if (p.maximum < 1e300) remedy += " to " + to_text(p.maximum);
        }
        problem(ErrorCode::range, o.location, "The value of the parameter '" + flat.id + "." + p.name + "' is not allowed.", remedy + ".");
      }
    }
  }

  static bool in_range(const Parameter& p, double x) { return std::isfinite(x) && x >= p.minimum && x <= p.maximum; }
  static bool fits(const Parameter& p, const Value& v) {
    switch (p.kind) {
      case ParameterKind::number:
      case ParameterKind::integer: {
        const auto* x = std::get_if<double>(&v);
        return x && in_range(p, *x) && (p.kind == ParameterKind::number || std::floor(*x) == *x);
      }
      case ParameterKind::boolean: return std::holds_alternative<bool>(v);
      case ParameterKind::text: return std::holds_alternative<std::string>(v);
      case ParameterKind::choice: {
        const auto* word = std::get_if<std::string>(&v);
        return word && std::find(p.choices.begin(), p.choices.end(), *word) != p.choices.end();
      }
      case ParameterKind::vector: {
        const auto* x = std::get_if<std::vector<double>>(&v);
        return x && x->size() == 3 && std::all_of(x->begin(), x->end(), [&](double c) { return in_range(p, c); });
      }
    }
    return false;
  }

  void set_values(FlatLsi& flat, const Instance& lsi, const std::string& location) {
    for (const NamedValue& v : lsi.values) {
      const std::string at = location + "/values/" + v.first;
      const int k = flat.lsi_class->find_input(v.first);
      if (k < 0) {
        problem(ErrorCode::unknown, at, "'" + flat.id + "' has no input '" + v.first + "'.", "Remove the value, or correct the spelling.");
        continue;
      }
      const InputPin& pin = flat.lsi_class->inputs[static_cast<std::size_t>(k)];
      const PinType& type = pin_type(pin.type);
      const std::uint32_t count = pin.count ? pin.count : type.default_count;
      std::vector<double> numbers;
      if (const auto* one = std::get_if<double>(&v.second)) numbers = {*one};
      if (const auto* many = std::get_if<std::vector<double>>(&v.second)) numbers = *many;
      const std::size_t wanted = count * type.element_bytes / sizeof(double);
      const bool finite = std::all_of(numbers.begin(), numbers.end(), [](double x) { return std::isfinite(x); });
      if (!type.numeric || count == 0 || pin.multiple) {
        problem(ErrorCode::unsupported, at, "'" + flat.id + "." + pin.name + "' cannot have a fixed value.", "Wire an output to it.");
      } else if (numbers.size() != wanted || !finite) {
        problem(ErrorCode::range, at, "'" + flat.id + "." + pin.name + "' needs " + std::to_string(wanted) + " finite numbers.",
                "Give a list of " + std::to_string(wanted) + " finite numbers.");
      } else if (pin.minimum < pin.maximum &&
                 !std::all_of(numbers.begin(), numbers.end(), [&](double x) { return x >= pin.minimum && x <= pin.maximum; })) {
        problem(ErrorCode::range, at,
                "'" + flat.id + "." + pin.name + "' accepts values from " + to_text(pin.minimum) + " to " + to_text(pin.maximum) + ".",
                "Give a value in this range.");
      } else {
        flat.inputs[static_cast<std::size_t>(k)].value = std::move(numbers);
      }
    }
  }

  int add_port(const BoundaryPin& pin, const std::string& location) {
    FlatLsi flat;
    flat.id = "input:" + pin.name;
    flat.lsi_class = &input_class(pin.type);
    flat.location = "circuit/inputs";
    if (pin_type(pin.type).default_count == 0)
      problem(ErrorCode::unsupported, location,
              "An input of the outermost circuit cannot be of the type '" + std::string(pin_type(pin.type).name) + "'.",
              "Use a type of fixed size, such as scalar or vector.");
    const int i = static_cast<int>(flat_.lsis.size());
    flat_.inputs.push_back({pin.name, {i, 0}});
    flat_.lsis.push_back(std::move(flat));
    return i;
  }

  /// Finds the output of an LSI to which "id.pin" of this level refers, also inside nested circuits. If there is none, reports this and
  /// returns a Source with lsi -1.
  Source find_source(const Level& level, const std::string& end, const std::string& location) {
    const auto [id, pin] = split(end);
    const auto item = level.items.find(id);
    if (item == level.items.end()) {
      if (!is_missing(level, id))
        problem(ErrorCode::unknown, location, "There is no LSI '" + level.prefix + std::string(id) + "'.",
                "Correct the id, or remove the wire.");
      return {};
    }
    if (item->second.level) {
      const Level& inner = *item->second.level;
      for (std::size_t i = 0; i < inner.circuit->outputs.size(); ++i) {
        const BoundaryPin& boundary = inner.circuit->outputs[i];
        if (boundary.name == pin) return boundary_source(inner, boundary, inner.location + "/outputs/" + std::to_string(i));
      }
    } else {
      const int k = flat_.lsis[static_cast<std::size_t>(item->second.lsi)].lsi_class->find_output(pin);
      if (k >= 0) return {item->second.lsi, k};
    }
    problem(ErrorCode::unknown, location, "'" + level.prefix + std::string(id) + "' has no output '" + std::string(pin) + "'.",
            "Choose one of its outputs.");
    return {};
  }

  /// Finds the output of an LSI that feeds the output `boundary` of the circuit `level`.
  Source boundary_source(const Level& level, const BoundaryPin& boundary, const std::string& location) {
    if (boundary.ends.empty()) {
      problem(ErrorCode::structure, location + "/from", "Nothing is wired to the circuit's output '" + level.prefix + boundary.name + "'.",
              "Wire an output to it, or remove the pin.");
      return {};
    }
    const Source source = find_source(level, boundary.ends[0], location + "/from");
    if (source.lsi < 0) return source;
    const FlatLsi& lsi = flat_.lsis[static_cast<std::size_t>(source.lsi)];
    const OutputPin& pin = lsi.lsi_class->outputs[static_cast<std::size_t>(source.pin)];
    if (pin.type != boundary.type) wrong_type(location, boundary, lsi.id + "." + pin.name, pin.type);
    return source;
  }

  void wrong_type(const std::string& location, const BoundaryPin& boundary, const std::string& inside, PinTypeId type) {
    problem(ErrorCode::structure, location + "/type",
            "The circuit's pin '" + boundary.name + "' is declared as " + std::string(pin_type(boundary.type).name) + ", but '" + inside +
                "' inside is " + std::string(pin_type(type).name) + ".",
            "Declare it as " + std::string(pin_type(type).name) + ".");
  }

  /// Adds to `sinks` the inputs of LSIs to which "id.pin" of this level refers, also inside nested circuits.
  void find_sinks(const Level& level, const std::string& end, const std::string& location, std::vector<Sink>& sinks) {
    if (searched_ >= max_searches) {
      if (searched_++ == max_searches)
        problem(ErrorCode::range, location, "The wires of nested circuits end at more than " + std::to_string(max_searches) + " inputs.",
                "Use fewer nested circuits.");
      return;
    }
    ++searched_;
    const auto [id, pin] = split(end);
    const auto item = level.items.find(id);
    if (item == level.items.end()) {
      if (!is_missing(level, id))
        problem(ErrorCode::unknown, location, "There is no LSI '" + level.prefix + std::string(id) + "'.",
                "Correct the id, or remove the wire.");
      return;
    }
    if (item->second.level) {
      const Level& inner = *item->second.level;
      for (std::size_t i = 0; i < inner.circuit->inputs.size(); ++i) {
        const BoundaryPin& boundary = inner.circuit->inputs[i];
        if (boundary.name != pin) continue;
        const std::string at = inner.location + "/inputs/" + std::to_string(i);
        const std::size_t first = sinks.size();
        for (const std::string& e : boundary.ends) find_sinks(inner, e, at + "/to", sinks);
        for (std::size_t k = first; k < sinks.size(); ++k) {
          const FlatLsi& lsi = flat_.lsis[static_cast<std::size_t>(sinks[k].lsi)];
          const InputPin& in = lsi.lsi_class->inputs[static_cast<std::size_t>(sinks[k].pin)];
          if (in.type != boundary.type) wrong_type(at, boundary, lsi.id + "." + in.name, in.type);
        }
        return;
      }
    } else {
      const int k = flat_.lsis[static_cast<std::size_t>(item->second.lsi)].lsi_class->find_input(pin);
      if (k >= 0) {
        sinks.push_back({item->second.lsi, k});
        return;
      }
    }
    problem(ErrorCode::unknown, location, "'" + level.prefix + std::string(id) + "' has no input '" + std::string(pin) + "'.",
            "Choose one of its inputs.");
  }

  /// True if the circuit has an instance of this id that could not be added. The reason has been reported already.
  static bool is_missing(const Level& level, std::string_view id) {
    const auto& lsis = level.circuit->lsis;
    return std::any_of(lsis.begin(), lsis.end(), [&](const Instance& lsi) { return lsi.id == id; });
  }

  /// Checks each parameter of this level's circuit: the inner parameters that it sets must exist and be of one kind.
  void check_parameters(const Level& level) {
    for (std::size_t i = 0; i < level.circuit->parameters.size(); ++i) {
      const Parameter* first = nullptr;
      for (const std::string& end : level.circuit->parameters[i].ends) {
        const auto [id, name] = split(end);
        const std::string location = level.location + "/parameters/" + std::to_string(i) + "/to";
        const auto item = level.items.find(id);
        bool found = false;
        if (item == level.items.end()) {
          found = is_missing(level, id);
        } else if (item->second.level) {
          const auto& inner = item->second.level->circuit->parameters;
          found = std::any_of(inner.begin(), inner.end(), [n = name](const BoundaryParameter& p) { return p.name == n; });
        } else {
          const LsiClass& c = *flat_.lsis[static_cast<std::size_t>(item->second.lsi)].lsi_class;
          const int k = c.find_parameter(name);
          found = k >= 0;
          if (found) check_kind(location, level.circuit->parameters[i], c.parameters[static_cast<std::size_t>(k)], first);
        }
        if (!found)
          problem(ErrorCode::unknown, location,
                  "The circuit's parameter '" + level.circuit->parameters[i].name + "' sets '" + end + "', which does not exist.",
                  "Name a parameter inside the circuit as \"id.parameter\".");
      }
    }
  }

  /// Reports inner parameters of different kinds, because they all receive the same value.
  /// @param first [in, out] the previous inner parameter of the same circuit parameter, or null
  void check_kind(const std::string& location, const BoundaryParameter& parameter, const Parameter& inner, const Parameter*& first) {
    const auto is_number = [](const Parameter& p) { return p.kind == ParameterKind::number || p.kind == ParameterKind::integer; };
    if (first && first->kind != inner.kind && !(is_number(*first) && is_number(inner)))
      problem(ErrorCode::structure, location,
              "The circuit's parameter '" + parameter.name + "' sets '" + first->name + "', which is " + words(first->kind) + ", and '" +
                  inner.name + "', which is " + words(inner.kind) + ".",
              "Declare one parameter for each.");
    first = &inner;
  }

  void connect(const Level& level) {
    check_parameters(level);
    for (std::size_t i = 0; i < level.circuit->wires.size(); ++i) {
      const Wire& wire = level.circuit->wires[i];
      const std::string location = level.location + "/wires/" + std::to_string(i);
      const Source source = find_source(level, wire.from, location + "/from");
      std::vector<Sink> sinks;
      find_sinks(level, wire.to, location + "/to", sinks);
      if (source.lsi < 0) continue;
      for (const Sink& sink : sinks) join(source, sink, location);
    }
    for (const auto& [id, item] : level.items)
      if (item.level) connect(*item.level);
  }

  void connect_port(const Level& top, std::size_t index, int port) {
    const BoundaryPin& pin = top.circuit->inputs[index];
    const std::string location = "circuit/inputs/" + std::to_string(index) + "/to";
    std::vector<Sink> sinks;
    for (const std::string& end : pin.ends) find_sinks(top, end, location, sinks);
    for (const Sink& sink : sinks) join({port, 0}, sink, location);
  }

  void join(const Source& source, const Sink& sink, const std::string& location) {
    const FlatLsi& from = flat_.lsis[static_cast<std::size_t>(source.lsi)];
    FlatLsi& to = flat_.lsis[static_cast<std::size_t>(sink.lsi)];
    const OutputPin& out = from.lsi_class->outputs[static_cast<std::size_t>(source.pin)];
    const InputPin& in = to.lsi_class->inputs[static_cast<std::size_t>(sink.pin)];
    const std::string from_name = from.id + "." + out.name, to_name = to.id + "." + in.name;
    FlatInput& input = to.inputs[static_cast<std::size_t>(sink.pin)];
    if (out.type != in.type) {
      problem(ErrorCode::structure, location,
              "'" + from_name + "' (" + std::string(pin_type(out.type).name) + ") does not fit '" + to_name + "' (" +
                  std::string(pin_type(in.type).name) + ").",
              "Wire pins of the same type, or insert an LSI that converts.");
    } else if (!input.sources.empty() && !in.multiple) {
      const FlatLsi& first = flat_.lsis[static_cast<std::size_t>(input.sources[0].lsi)];
      problem(ErrorCode::structure, location,
              "Two wires end at '" + to_name + "': from '" + first.id + "." +
                  first.lsi_class->outputs[static_cast<std::size_t>(input.sources[0].pin)].name + "' and from '" + from_name + "'.",
              "Remove one wire, or combine the values with an LSI.");
    } else {
      input.sources.push_back(source);
    }
  }

  void check_inputs() {
    for (const FlatLsi& lsi : flat_.lsis)
      for (std::size_t i = 0; i < lsi.inputs.size(); ++i) {
        const InputPin& pin = lsi.lsi_class->inputs[i];
        if (pin.required && lsi.inputs[i].sources.empty() && lsi.inputs[i].value.empty())
          problem(ErrorCode::structure, lsi.location,
                  "Nothing is wired to '" + lsi.id + "." + pin.name + "' (" + std::string(pin_type(pin.type).name) + ").",
                  "Wire an output to it, or give it a fixed value.");
      }
  }

  void sort_by_id() {
    const std::size_t n = flat_.lsis.size();
    std::vector<int> order(n), rank(n);
    for (std::size_t i = 0; i < n; ++i) order[i] = static_cast<int>(i);
    std::sort(order.begin(), order.end(),
              [&](int a, int b) { return flat_.lsis[static_cast<std::size_t>(a)].id < flat_.lsis[static_cast<std::size_t>(b)].id; });
    std::vector<FlatLsi> sorted(n);
    for (std::size_t i = 0; i < n; ++i) {
      rank[static_cast<std::size_t>(order[i])] = static_cast<int>(i);
      sorted[i] = std::move(flat_.lsis[static_cast<std::size_t>(order[i])]);
    }
    const auto renumber = [&](Source& s) { s.lsi = rank[static_cast<std::size_t>(s.lsi)]; };
    for (FlatLsi& lsi : sorted)
      for (FlatInput& input : lsi.inputs) {
        for (Source& s : input.sources) renumber(s);
        std::sort(input.sources.begin(), input.sources.end(),
                  [](const Source& a, const Source& b) { return a.lsi != b.lsi ? a.lsi < b.lsi : a.pin < b.pin; });
      }
    for (FlatPort& port : flat_.inputs) renumber(port.source);
    for (FlatPort& port : flat_.outputs) renumber(port.source);
    flat_.lsis = std::move(sorted);
  }

  const Library& library_;
  Error& problems_;
  FlatCircuit flat_;
  std::size_t expanded_ = 0, searched_ = 0;
};

}  // namespace

FlatCircuit flatten(const Circuit& circuit, const Library& library, Error& problems) {
  return Flattener(library, problems).flatten(circuit);
}

}  // namespace ugoki::circuit
