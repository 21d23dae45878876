#include "ugoki/circuit/flatten.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <set>

#include "ugoki/base/number.h"

namespace ugoki::circuit {
namespace {

constexpr std::size_t max_items = 200000;      // LSIs and circuits, opened
constexpr std::size_t max_searches = 1000000;  // pins looked up behind wires
constexpr std::uint32_t max_every = 1000000;

/// The class that stands for an input of the outermost circuit: one output, nothing to do.
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
  std::unique_ptr<Level> level;  ///< set where the item is a circuit
};
struct Level {
  const Circuit* circuit = nullptr;
  const Level* outer = nullptr;
  std::string prefix;  ///< "arm/"
  std::string place;
  std::map<std::string, Item, std::less<>> items;
};

struct Sink {
  int lsi, pin;
};

/// A parameter set from outside: "id.parameter" and its value.
struct Override {
  std::string end;
  Value value;
  std::string place;
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
    case ParameterKind::text: return "a text";
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
    top.place = "circuit";
    open(top, 1, {});
    std::vector<int> ports;
    for (std::size_t i = 0; i < circuit.inputs.size(); ++i)
      ports.push_back(add_port(circuit.inputs[i], "circuit/inputs/" + std::to_string(i)));
    if (opened_ > max_items) return std::move(flat_);
    connect(top);
    for (std::size_t i = 0; i < circuit.inputs.size(); ++i) connect_port(top, i, ports[i]);
    for (std::size_t i = 0; i < circuit.outputs.size(); ++i) {
      const Source source = boundary_source(top, circuit.outputs[i], top.place + "/outputs/" + std::to_string(i));
      flat_.outputs.push_back({circuit.outputs[i].name, source});
    }
    check_inputs();
    if (problems_.empty()) sort_by_id();
    return std::move(flat_);
  }

 private:
  static constexpr std::size_t max_problems = 1000;

  void problem(ErrorCode code, std::string place, std::string message, std::string remedy) {
    if (problems_.problems.size() < max_problems) problems_.add(code, std::move(place), std::move(message), std::move(remedy));
  }

  const Circuit* find_circuit(const Level& level, std::string_view name) const {
    for (const Level* l = &level; l; l = l->outer)
      for (const Circuit& c : l->circuit->circuits)
        if (c.name == name) return &c;
    return nullptr;
  }

  /// Names by which others refer to the parts of a circuit.
  template <class Parts>
  void check_names(const std::string& place, const char* field, const Parts& parts) {
    std::set<std::string_view> names;
    for (std::size_t i = 0; i < parts.size(); ++i)
      if (!names.insert(parts[i].name).second)
        problem(ErrorCode::duplicate, place + "/" + field + "/" + std::to_string(i) + "/name",
                std::string("Two ") + field + " are called '" + parts[i].name + "'.", "Rename one.");
  }

  void open(Level& level, std::uint32_t every, const std::vector<Override>& overrides) {
    const Circuit& circuit = *level.circuit;
    check_names(level.place, "inputs", circuit.inputs);
    check_names(level.place, "outputs", circuit.outputs);
    check_names(level.place, "parameters", circuit.parameters);
    check_names(level.place, "circuits", circuit.circuits);
    std::vector<std::vector<Override>> given(circuit.lsis.size());
    for (std::size_t i = 0; i < circuit.lsis.size(); ++i) {
      const std::string place = level.place + "/lsis/" + std::to_string(i);
      const Instance& lsi = circuit.lsis[i];
      for (std::size_t k = 0; k < lsi.parameters.size(); ++k)
        given[i].push_back(
            {lsi.id + "." + lsi.parameters[k].first, lsi.parameters[k].second, place + "/parameters/" + lsi.parameters[k].first});
    }
    std::map<std::string_view, std::size_t> index;
    for (std::size_t i = 0; i < circuit.lsis.size(); ++i) index.emplace(circuit.lsis[i].id, i);
    for (const Override& o : overrides) {
      const auto found = index.find(split(o.end).first);
      if (found == index.end()) {
        problem(ErrorCode::unknown, o.place,
                "The parameter leads to '" + o.end + "', but there is no LSI '" + std::string(split(o.end).first) + "'.",
                "Correct the id.");
      } else {
        given[found->second].push_back(o);
      }
    }
    for (std::size_t i = 0; i < circuit.lsis.size() && opened_ <= max_items; ++i) add_item(level, i, every, given[i]);
  }

  void add_item(Level& level, std::size_t i, std::uint32_t every, const std::vector<Override>& given) {
    const Instance& lsi = level.circuit->lsis[i];
    const std::string place = level.place + "/lsis/" + std::to_string(i);
    const std::string id = level.prefix + lsi.id;
    if (opened_ >= max_items) {
      if (opened_++ == max_items)
        problem(ErrorCode::range, place, "The circuit opens into more than " + std::to_string(max_items) + " LSIs.",
                "Use fewer nested circuits.");
      return;
    }
    ++opened_;
    if (level.items.contains(lsi.id)) {
      problem(ErrorCode::duplicate, place + "/id", "Two LSIs have the id '" + id + "'.", "Give one of them another id.");
      return;
    }
    const std::uint64_t product = static_cast<std::uint64_t>(every) * lsi.every;
    const auto own_every = static_cast<std::uint32_t>(std::min<std::uint64_t>(product, max_every));
    if (const Circuit* inner = find_circuit(level, lsi.type)) {
      for (const Level* l = &level; l; l = l->outer) {
        if (l->circuit != inner) continue;
        problem(ErrorCode::structure, place + "/type", "The circuit '" + lsi.type + "' contains itself.", "Take '" + id + "' out.");
        return;
      }
      Item& item = level.items[lsi.id];
      item.level = std::make_unique<Level>();
      item.level->circuit = inner;
      item.level->outer = &level;
      item.level->prefix = id + "/";
      item.level->place = place + "(" + lsi.type + ")";
      open(*item.level, own_every, pass_on(*inner, given, id));
      for (const NamedValue& v : lsi.values)
        problem(ErrorCode::unsupported, place + "/values/" + v.first, "A circuit's pin takes no value.",
                "Wire a constant to '" + id + "." + v.first + "'.");
      return;
    }
    const LsiClass* found = library_.find(lsi.type);
    if (!found) {
      missing(lsi.type.substr(0, 200), id, place + "/type");
      return;
    }
    FlatLsi flat;
    flat.id = id;
    flat.lsi_class = found;
    flat.place = place;
    flat.every = own_every;
    flat.inputs.resize(found->inputs.size());
    set_parameters(flat, given);
    set_values(flat, lsi, place);
    level.items[lsi.id].lsi = static_cast<int>(flat_.lsis.size());
    flat_.lsis.push_back(std::move(flat));
  }

  /// What is not installed, and how to get it.
  void missing(const std::string& type, const std::string& id, std::string place) {
    const auto slash = type.find('/');
    if (slash == std::string::npos)
      return problem(
          ErrorCode::unknown, std::move(place),
          "The LSI '" + type + "' (used as '" + id + "') is missing: neither a circuit here nor installed, or in several libraries.",
          "Install it, or replace '" + id + "'; the circuit keeps it until then.");
    const std::string library = type.substr(0, slash);
    if (const std::string* refused = library_.find_refusal(library))
      return problem(ErrorCode::unknown, std::move(place),
                     "The LSI '" + type.substr(slash + 1) + "' of the library '" + library + "' (used as '" + id +
                         "') is missing, for the installed library was refused: " + *refused,
                     "Build the library again and install it, or replace '" + id + "'; the circuit keeps it until then.");
    const bool other =
        std::any_of(library_.classes().begin(), library_.classes().end(), [&](const LsiClass& c) { return c.from == library; });
    problem(ErrorCode::unknown, std::move(place),
            "The LSI '" + type.substr(slash + 1) + "' of the library '" + library + "' (used as '" + id +
                "') is missing: " + (other ? "the installed '" + library + "' does not have it." : "the library is not installed."),
            "Install it with `ugoki lsi install " + library + ".so` (or .fmu), or replace '" + id + "'; the circuit keeps it until then.");
  }

  /// Parameters given to a circuit, as parameters of what is inside.
  std::vector<Override> pass_on(const Circuit& inner, const std::vector<Override>& given, const std::string& id) {
    std::vector<Override> out;
    for (const Override& o : given) {
      const std::string_view name = split(o.end).second;
      const auto found =
          std::find_if(inner.parameters.begin(), inner.parameters.end(), [&](const BoundaryParameter& p) { return p.name == name; });
      if (found == inner.parameters.end()) {
        problem(ErrorCode::unknown, o.place, "'" + id + "' has no parameter '" + std::string(name) + "'.",
                "Remove it, or mind the spelling.");
        continue;
      }
      for (const std::string& end : found->ends) out.push_back({end, o.value, o.place});
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
        problem(ErrorCode::unknown, o.place, "'" + flat.id + "' has no parameter '" + std::string(name) + "'.",
                all.empty() ? "It has none; remove it." : "It has: " + all + ".");
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
        problem(ErrorCode::range, o.place, "The parameter '" + flat.id + "." + p.name + "' cannot have this value.", remedy + ".");
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

  void set_values(FlatLsi& flat, const Instance& lsi, const std::string& place) {
    for (const NamedValue& v : lsi.values) {
      const std::string at = place + "/values/" + v.first;
      const int k = flat.lsi_class->find_input(v.first);
      if (k < 0) {
        problem(ErrorCode::unknown, at, "'" + flat.id + "' has no input '" + v.first + "'.", "Remove the value, or mind the spelling.");
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
        problem(ErrorCode::unsupported, at, "'" + flat.id + "." + pin.name + "' cannot have a fixed value.", "Wire something to it.");
      } else if (numbers.size() != wanted || !finite) {
        problem(ErrorCode::range, at, "'" + flat.id + "." + pin.name + "' needs " + std::to_string(wanted) + " finite numbers.",
                "Give a list of that many.");
      } else if (pin.minimum < pin.maximum &&
                 !std::all_of(numbers.begin(), numbers.end(), [&](double x) { return x >= pin.minimum && x <= pin.maximum; })) {
        problem(ErrorCode::range, at,
                "'" + flat.id + "." + pin.name + "' is meant for " + to_text(pin.minimum) + " to " + to_text(pin.maximum) + ".",
                "Give a value in that range.");
      } else {
        flat.inputs[static_cast<std::size_t>(k)].value = std::move(numbers);
      }
    }
  }

  int add_port(const BoundaryPin& pin, const std::string& place) {
    FlatLsi flat;
    flat.id = "input:" + pin.name;
    flat.lsi_class = &input_class(pin.type);
    flat.place = "circuit/inputs";
    if (pin_type(pin.type).default_count == 0)
      problem(ErrorCode::unsupported, place,
              "An input of the outermost circuit cannot be of the type '" + std::string(pin_type(pin.type).name) + "'.",
              "Use a type of fixed size.");
    const int i = static_cast<int>(flat_.lsis.size());
    flat_.inputs.push_back({pin.name, {i, 0}});
    flat_.lsis.push_back(std::move(flat));
    return i;
  }

  /// The output behind "id.pin" at this level; lsi -1 (and a problem) where there is none.
  Source find_source(const Level& level, const std::string& end, const std::string& place) {
    const auto [id, pin] = split(end);
    const auto item = level.items.find(id);
    if (item == level.items.end()) {
      if (!is_missing(level, id))
        problem(ErrorCode::unknown, place, "There is no LSI '" + level.prefix + std::string(id) + "'.",
                "Correct the id, or remove the wire.");
      return {};
    }
    if (item->second.level) {
      const Level& inner = *item->second.level;
      for (std::size_t i = 0; i < inner.circuit->outputs.size(); ++i) {
        const BoundaryPin& boundary = inner.circuit->outputs[i];
        if (boundary.name == pin) return boundary_source(inner, boundary, inner.place + "/outputs/" + std::to_string(i));
      }
    } else {
      const int k = flat_.lsis[static_cast<std::size_t>(item->second.lsi)].lsi_class->find_output(pin);
      if (k >= 0) return {item->second.lsi, k};
    }
    problem(ErrorCode::unknown, place, "'" + level.prefix + std::string(id) + "' has no output '" + std::string(pin) + "'.",
            "Choose one of its outputs.");
    return {};
  }

  /// What an output of a circuit comes from.
  Source boundary_source(const Level& level, const BoundaryPin& boundary, const std::string& place) {
    if (boundary.ends.empty()) {
      problem(ErrorCode::structure, place + "/from", "Nothing is wired to the circuit's output '" + level.prefix + boundary.name + "'.",
              "Wire it, or remove the pin.");
      return {};
    }
    const Source source = find_source(level, boundary.ends[0], place + "/from");
    if (source.lsi < 0) return source;
    const FlatLsi& lsi = flat_.lsis[static_cast<std::size_t>(source.lsi)];
    const OutputPin& pin = lsi.lsi_class->outputs[static_cast<std::size_t>(source.pin)];
    if (pin.type != boundary.type) wrong_type(place, boundary, lsi.id + "." + pin.name, pin.type);
    return source;
  }

  void wrong_type(const std::string& place, const BoundaryPin& boundary, const std::string& inside, PinTypeId type) {
    problem(ErrorCode::structure, place + "/type",
            "The circuit's pin '" + boundary.name + "' is declared as " + std::string(pin_type(boundary.type).name) + ", but '" + inside +
                "' inside is " + std::string(pin_type(type).name) + ".",
            "Declare it as " + std::string(pin_type(type).name) + ".");
  }

  /// The inputs behind "id.pin" at this level.
  void find_sinks(const Level& level, const std::string& end, const std::string& place, std::vector<Sink>& sinks) {
    if (searched_ >= max_searches) {
      if (searched_++ == max_searches)
        problem(ErrorCode::range, place, "The pins of nested circuits lead to too many places.", "Use fewer nested circuits.");
      return;
    }
    ++searched_;
    const auto [id, pin] = split(end);
    const auto item = level.items.find(id);
    if (item == level.items.end()) {
      if (!is_missing(level, id))
        problem(ErrorCode::unknown, place, "There is no LSI '" + level.prefix + std::string(id) + "'.",
                "Correct the id, or remove the wire.");
      return;
    }
    if (item->second.level) {
      const Level& inner = *item->second.level;
      for (std::size_t i = 0; i < inner.circuit->inputs.size(); ++i) {
        const BoundaryPin& boundary = inner.circuit->inputs[i];
        if (boundary.name != pin) continue;
        const std::string at = inner.place + "/inputs/" + std::to_string(i);
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
    problem(ErrorCode::unknown, place, "'" + level.prefix + std::string(id) + "' has no input '" + std::string(pin) + "'.",
            "Choose one of its inputs.");
  }

  /// True if the circuit has an instance of this id that could not be opened; its own problem is reported already.
  static bool is_missing(const Level& level, std::string_view id) {
    const auto& lsis = level.circuit->lsis;
    return std::any_of(lsis.begin(), lsis.end(), [&](const Instance& lsi) { return lsi.id == id; });
  }

  /// Parameters of a circuit lead to parameters inside.
  void check_parameters(const Level& level) {
    for (std::size_t i = 0; i < level.circuit->parameters.size(); ++i) {
      const Parameter* first = nullptr;
      for (const std::string& end : level.circuit->parameters[i].ends) {
        const auto [id, name] = split(end);
        const std::string place = level.place + "/parameters/" + std::to_string(i) + "/to";
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
          if (found) check_kind(place, level.circuit->parameters[i], c.parameters[static_cast<std::size_t>(k)], first);
        }
        if (!found)
          problem(ErrorCode::unknown, place,
                  "The circuit's parameter '" + level.circuit->parameters[i].name + "' leads to '" + end + "', which is not there.",
                  "Name a parameter inside as \"id.parameter\".");
      }
    }
  }

  /// One value goes to all that a parameter leads to. @param first of them, or null so far
  void check_kind(const std::string& place, const BoundaryParameter& parameter, const Parameter& inner, const Parameter*& first) {
    const auto is_number = [](const Parameter& p) { return p.kind == ParameterKind::number || p.kind == ParameterKind::integer; };
    if (first && first->kind != inner.kind && !(is_number(*first) && is_number(inner)))
      problem(ErrorCode::structure, place,
              "The circuit's parameter '" + parameter.name + "' leads to '" + first->name + "', which is " + words(first->kind) +
                  ", and to '" + inner.name + "', which is " + words(inner.kind) + ".",
              "Make a parameter for each.");
    first = &inner;
  }

  void connect(const Level& level) {
    check_parameters(level);
    for (std::size_t i = 0; i < level.circuit->wires.size(); ++i) {
      const Wire& wire = level.circuit->wires[i];
      const std::string place = level.place + "/wires/" + std::to_string(i);
      const Source source = find_source(level, wire.from, place + "/from");
      std::vector<Sink> sinks;
      find_sinks(level, wire.to, place + "/to", sinks);
      if (source.lsi < 0) continue;
      for (const Sink& sink : sinks) join(source, sink, place);
    }
    for (const auto& [id, item] : level.items)
      if (item.level) connect(*item.level);
  }

  void connect_port(const Level& top, std::size_t index, int port) {
    const BoundaryPin& pin = top.circuit->inputs[index];
    const std::string place = "circuit/inputs/" + std::to_string(index) + "/to";
    std::vector<Sink> sinks;
    for (const std::string& end : pin.ends) find_sinks(top, end, place, sinks);
    for (const Sink& sink : sinks) join({port, 0}, sink, place);
  }

  void join(const Source& source, const Sink& sink, const std::string& place) {
    const FlatLsi& from = flat_.lsis[static_cast<std::size_t>(source.lsi)];
    FlatLsi& to = flat_.lsis[static_cast<std::size_t>(sink.lsi)];
    const OutputPin& out = from.lsi_class->outputs[static_cast<std::size_t>(source.pin)];
    const InputPin& in = to.lsi_class->inputs[static_cast<std::size_t>(sink.pin)];
    const std::string from_name = from.id + "." + out.name, to_name = to.id + "." + in.name;
    FlatInput& input = to.inputs[static_cast<std::size_t>(sink.pin)];
    if (out.type != in.type) {
      problem(ErrorCode::structure, place,
              "'" + from_name + "' (" + std::string(pin_type(out.type).name) + ") does not fit '" + to_name + "' (" +
                  std::string(pin_type(in.type).name) + ").",
              "Wire pins of the same type, or put an LSI between that converts.");
    } else if (!input.sources.empty() && !in.multiple) {
      const FlatLsi& first = flat_.lsis[static_cast<std::size_t>(input.sources[0].lsi)];
      problem(ErrorCode::structure, place,
              "Two wires end at '" + to_name + "': from '" + first.id + "." +
                  first.lsi_class->outputs[static_cast<std::size_t>(input.sources[0].pin)].name + "' and from '" + from_name + "'.",
              "Remove one, or combine them with an LSI.");
    } else {
      input.sources.push_back(source);
    }
  }

  void check_inputs() {
    for (const FlatLsi& lsi : flat_.lsis)
      for (std::size_t i = 0; i < lsi.inputs.size(); ++i) {
        const InputPin& pin = lsi.lsi_class->inputs[i];
        if (pin.required && lsi.inputs[i].sources.empty() && lsi.inputs[i].value.empty())
          problem(ErrorCode::structure, lsi.place,
                  "Nothing is wired to '" + lsi.id + "." + pin.name + "' (" + std::string(pin_type(pin.type).name) + ").",
                  "Wire it, or give it a value.");
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
  std::size_t opened_ = 0, searched_ = 0;
};

}  // namespace

FlatCircuit flatten(const Circuit& circuit, const Library& library, Error& problems) {
  return Flattener(library, problems).flatten(circuit);
}

}  // namespace ugoki::circuit
