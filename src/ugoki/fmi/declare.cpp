#include "ugoki/fmi/declare.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <set>

#include "ugoki/base/number.h"

namespace ugoki::fmi {
namespace {

using circuit::LsiClass;

constexpr std::size_t max_inside = 1000;    // local variables that become outputs; if an FMU has more, none does and a note is added
constexpr std::uint64_t max_elements = 64;  // maximum number of elements of an array that becomes parameters, one per element
constexpr std::size_t max_named = 8;        // maximum number of variables that a note lists by name

bool is_number(VariableType type) { return type != VariableType::string && type != VariableType::binary && type != VariableType::clock; }

/// True for the types of integers and enumerations.
bool is_whole(VariableType type) {
  return type != VariableType::float64 && type != VariableType::float32 && type != VariableType::boolean && is_number(type);
}

/// Name of element `i` of an array, with indices from 1: "A[2,1]". `i` counts the elements row by row, from 0.
std::string element_name(const Variable& v, std::uint64_t i) {
  std::vector<std::uint64_t> at(v.extent.size());
  for (std::size_t d = v.extent.size(); d-- > 0; i /= v.extent[d]) at[d] = i % v.extent[d] + 1;
  std::string out = v.name + "[";
  for (std::size_t d = 0; d < at.size(); ++d) out += (d ? "," : "") + std::to_string(at[d]);
  return out + "]";
}

/// Start value of element i; 0 if the variable has none.
double start_of(const Variable& v, std::size_t i) { return v.start.empty() ? 0.0 : v.start.size() == 1 ? v.start[0] : v.start[i]; }

/// Makes names of pins or parameters unique by appended apostrophes.
class Names {
 public:
  std::string take(std::string_view variable) {
    std::string name = pin_name(variable);
    while (!taken_.insert(name).second) name += "'";
    return name;
  }

 private:
  std::set<std::string, std::less<>> taken_;
};

/// Collects the variables of one note: "'a', 'b' and 3 more are ...".
class Listed {
 public:
  void add(const std::string& name) {
    if (count_++ < max_named) text_ += (text_.empty() ? "'" : ", '") + name + "'";
  }
  void note(std::vector<std::string>& notes, const std::string& rest) const {
    if (count_ > max_named)
      notes.push_back(text_ + " and " + std::to_string(count_ - max_named) + " more " + rest);
    else if (count_ > 0)
      notes.push_back(text_ + " " + rest);
  }

 private:
  std::string text_;
  std::size_t count_ = 0;
};

/// Declares the LSIs of one FMU from its model description.
class Declarer {
 public:
  explicit Declarer(const ModelDescription& d) : d_(d) {}

  Declarations declare() {
    Declarations out;
    Declaration plain = head();
    std::size_t inside = 0;  // number of local variables and calculated parameters that could be outputs
    for (const Variable& v : d_.variables) {
      switch (v.causality) {
        case Causality::input: add_input(plain, v); break;
        case Causality::output: add_output(plain, v); break;
        case Causality::parameter: add_parameter(plain, v); break;
        case Causality::structural_parameter: sizes_.add(v.name); break;
        case Causality::local:
        case Causality::calculated_parameter: inside += is_number(v.type) && v.count() > 0; break;
        case Causality::independent: break;
      }
    }
    if (!plain_parameters_.contains("logging")) {
      circuit::Parameter p;
      p.name = "logging";
      p.kind = circuit::ParameterKind::boolean;
      p.initial = false;
      p.doc = "Show all log messages of the FMU, not only warnings and errors.";
      p.live = false;
      plain.lsi_class.parameters.push_back(std::move(p));
      plain.logging = static_cast<int>(numbers_);
    }
    out.classes.push_back(plain);
    if (inside > 0 && inside <= max_inside) {
      Declaration full = plain;
      full.lsi_class.name += ", all variables";
      full.lsi_class.doc += " Its local variables are outputs too.";
      for (const Variable& v : d_.variables)
        if (v.causality == Causality::local || v.causality == Causality::calculated_parameter) add_output(full, v);
      out.classes.push_back(std::move(full));
    }
    out.notes = d_.notes;
    texts_.note(out.notes, "are strings, for which there is no pin type; they are left out.");
    binaries_.note(out.notes, "are binary values or clocks, for which there is no pin type; they are left out.");
    sizes_.note(out.notes, "set the sizes of arrays and keep their start values.");
    arrays_.note(out.notes, "are arrays that cannot be parameters of an LSI; they keep their start values.");
    empty_.note(out.notes, "have no elements; they are left out.");
    if (inside > max_inside)
      out.notes.push_back("Its " + std::to_string(inside) + " local variables are too many to be outputs (at most " +
                          std::to_string(max_inside) + "); export the FMU with the needed ones as outputs.");
    if (!d_.saves_state) out.notes.push_back(cannot_save());
    if (d_.needs_execution_tool) out.notes.push_back("It needs the tool that exported it to be installed on this machine.");
    return out;
  }

 private:
  static std::string cannot_save() {
    return "It cannot save its state: when a circuit goes back in time, this FMU starts from its initial state.";
  }

  /// The declaration of the LSI, still without pins and parameters.
  Declaration head() const {
    Declaration out;
    LsiClass& c = out.lsi_class;
    c.name = d_.identifier + "/" + d_.identifier;
    c.from = d_.identifier;
    c.group = "FMU";
    c.doc = d_.description.empty() ? d_.name : d_.description;
    if (!c.doc.empty() && c.doc.back() != '.') c.doc += '.';
    c.doc += " An FMU (FMI " + d_.written + " co-simulation).";
    if (!d_.saves_state) c.doc += " " + cannot_save();
    return out;
  }

  static std::string doc_of(const Variable& v) {
    std::string doc = v.description;
    if (!v.display_unit.empty() && v.display_unit != v.unit)
      doc += (doc.empty() ? "Often shown in " : " (often shown in ") + v.display_unit + (doc.empty() ? "." : ")");
    return doc;
  }

  /// False if no pin type fits the variable; the variable is then added to a note.
  bool can_be_pin(const Variable& v) {
    if (v.type == VariableType::string) return texts_.add(v.name), false;
    if (!is_number(v.type)) return binaries_.add(v.name), false;
    if (v.count() == 0) return empty_.add(v.name), false;
    return true;
  }

  /// Sets type, unit, description and range of a pin.
  template <class Pin>
  void fill(Pin& pin, const Variable& v) const {
    const std::uint64_t count = v.count();
    pin.unit = v.unit;
    pin.doc = doc_of(v);
    if (v.is_array() && count == 3) {
      pin.type = circuit::PinTypeId::vector;
    } else if (v.is_array() && count != 1) {
      pin.type = circuit::PinTypeId::joint_values;
      pin.count = static_cast<std::uint32_t>(count);
    }
    if (v.type == VariableType::boolean) {
      pin.minimum = 0;
      pin.maximum = 1;
    } else if (v.minimum || v.maximum) {
      pin.minimum = v.minimum.value_or(-std::numeric_limits<double>::max());
      pin.maximum = v.maximum.value_or(std::numeric_limits<double>::max());
    }
  }
  [[nodiscard]] PinBinding bind(const Variable& v, std::size_t pin) const {
    return {storage_of(v.type, d_.version), v.reference, static_cast<std::uint32_t>(pin), static_cast<std::uint32_t>(v.count()),
            v.variability != Variability::continuous};
  }

  void add_input(Declaration& out, const Variable& v) {
    if (!can_be_pin(v)) return;
    circuit::InputPin pin;
    fill(pin, v);
    pin.name = input_names_.take(v.name);
    pin.direct = false;
    pin.value = start_of(v, 0);
    // An input without wire has the same value in all elements; if the start values differ, it needs a wire.
    pin.required = !std::all_of(v.start.begin(), v.start.end(), [&](double x) { return x == pin.value; });
    out.inputs.push_back(bind(v, out.lsi_class.inputs.size()));
    out.lsi_class.inputs.push_back(std::move(pin));
  }

  void add_output(Declaration& out, const Variable& v) {
    if (!can_be_pin(v)) return;
    circuit::OutputPin pin;
    fill(pin, v);
    pin.name = output_names_.take(v.name);
    pin.delayed = true;
    out.outputs.push_back(bind(v, out.lsi_class.outputs.size()));
    out.lsi_class.outputs.push_back(std::move(pin));
  }

  void add_parameter(Declaration& out, const Variable& v) {
    if (v.type == VariableType::string) {
      if (v.is_array()) return arrays_.add(v.name);
      return add_text(out, v);
    }
    if (!is_number(v.type)) return binaries_.add(v.name);
    if (!v.is_array()) return add_number(out, v, v.name, 0);
    const std::uint64_t count = v.count();
    if (count == 0) return empty_.add(v.name);
    if (count > max_elements || v.type == VariableType::boolean || v.type == VariableType::enumeration) return arrays_.add(v.name);
    // Each element is a parameter of the LSI. The FMU sets the array as a whole, so that all elements share one binding.
    const std::size_t first = out.lsi_class.parameters.size();
    for (std::uint64_t i = 0; i < count; ++i) add_number(out, v, element_name(v, i), i);
    ParameterBinding all = out.parameters[out.parameters.size() - count];
    all.count = static_cast<std::uint32_t>(count);
    all.start.clear();
    if (!v.start.empty())
      for (std::size_t i = 0; i < count; ++i) all.start.push_back(start_of(v, i));
    all.name = out.lsi_class.parameters[first].name;
    out.parameters.resize(out.parameters.size() - count);
    out.parameters.push_back(std::move(all));
  }

  circuit::Parameter parameter_of(const Variable& v, const std::string& name) {
    circuit::Parameter p;
    p.name = parameter_names_.take(name);
    plain_parameters_.insert(p.name);
    p.unit = v.unit;
    p.doc = doc_of(v);
    p.live = v.variability == Variability::tunable;
    return p;
  }

  void add_text(Declaration& out, const Variable& v) {
    circuit::Parameter p = parameter_of(v, v.name);
    p.kind = circuit::ParameterKind::text;
    p.initial = v.texts.empty() ? std::string() : v.texts[0];
    p.live = false;
    ParameterBinding b;
    b.reference = v.reference;
    b.text = true;
    b.name = p.name;
    out.parameters.push_back(std::move(b));
    out.lsi_class.parameters.push_back(std::move(p));
  }

  void add_number(Declaration& out, const Variable& v, const std::string& name, std::size_t element) {
    circuit::Parameter p = parameter_of(v, name);
    ParameterBinding b;
    b.storage = storage_of(v.type, d_.version);
    b.reference = v.reference;
    b.first = static_cast<std::uint32_t>(numbers_++);
    b.tunable = p.live;
    const double start = start_of(v, element);
    if (!v.start.empty()) b.start = {start};
    p.initial = start;
    if (v.type == VariableType::boolean) {
      p.kind = circuit::ParameterKind::boolean;
      p.initial = start != 0;
    } else if (is_whole(v.type)) {
      p.kind = circuit::ParameterKind::integer;
      set_range(p, v, start);
      set_choices(p, b, v, start);
    } else {
      set_range(p, v, start);
    }
    b.name = p.name;
    out.parameters.push_back(std::move(b));
    out.lsi_class.parameters.push_back(std::move(p));
  }

  /// Sets the range of a parameter, extended to contain the start value; otherwise the circuit would refuse the FMU's own default.
  static void set_range(circuit::Parameter& p, const Variable& v, double start) {
    p.minimum = std::min(v.minimum.value_or(p.minimum), start);
    p.maximum = std::max(v.maximum.value_or(p.maximum), start);
  }

  /// Makes an enumeration a choice of words, if its items are known and the start value is one of them.
  void set_choices(circuit::Parameter& p, ParameterBinding& b, const Variable& v, double start) const {
    if (v.type != VariableType::enumeration || v.enumeration < 0) return;
    const EnumerationType& e = d_.enumerations[static_cast<std::size_t>(v.enumeration)];
    const auto found =
        std::find_if(e.items.begin(), e.items.end(), [&](const auto& item) { return static_cast<double>(item.second) == start; });
    if (found == e.items.end()) return;
    p.kind = circuit::ParameterKind::choice;
    p.initial = found->first;
    b.start = {static_cast<double>(found - e.items.begin())};
    for (const auto& [word, value] : e.items) {
      p.choices.push_back(word);
      b.choices.push_back(value);
    }
  }

  const ModelDescription& d_;
  Names input_names_, output_names_, parameter_names_;
  std::set<std::string, std::less<>> plain_parameters_;
  std::size_t numbers_ = 0;  // number of values in Call::parameters so far
  Listed texts_, binaries_, sizes_, arrays_, empty_;
};

}  // namespace

std::size_t bytes_of(Storage storage) {
  constexpr std::array<std::size_t, 12> bytes{8, 4, 1, 1, 2, 2, 4, 4, 8, 8, 1, 4};
  return bytes[static_cast<std::size_t>(storage)];
}

Storage storage_of(VariableType type, int version) {
  switch (type) {
    case VariableType::float64: return Storage::f64;
    case VariableType::float32: return Storage::f32;
    case VariableType::int8: return Storage::i8;
    case VariableType::uint8: return Storage::u8;
    case VariableType::int16: return Storage::i16;
    case VariableType::uint16: return Storage::u16;
    case VariableType::int32: return Storage::i32;
    case VariableType::uint32: return Storage::u32;
    case VariableType::int64: return Storage::i64;
    case VariableType::uint64: return Storage::u64;
    case VariableType::boolean: return version == 2 ? Storage::b32 : Storage::b8;
    case VariableType::enumeration: return version == 2 ? Storage::i32 : Storage::i64;
    default: return Storage::f64;
  }
}

std::string pin_name(std::string_view variable) {
  std::string name(variable);
  std::replace(name.begin(), name.end(), '.', ':');
  return name;
}

Declarations declare(const ModelDescription& description) { return Declarer(description).declare(); }

}  // namespace ugoki::fmi
