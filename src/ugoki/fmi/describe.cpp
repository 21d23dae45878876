#include "ugoki/fmi/describe.h"

#include <array>
#include <cmath>
#include <optional>
#include <pugixml.hpp>
#include <set>
#include <sstream>

#include "ugoki/base/number.h"

namespace ugoki::fmi {
namespace {

// Base units of the FMI standard, in the order of the standard's attributes.
constexpr std::array<const char*, 8> bases{"kg", "m", "s", "A", "K", "mol", "cd", "rad"};

/// A unit as a product of powers of `bases` and a factor to SI.
struct BaseUnit {
  std::array<int, 8> powers{};
  double factor = 1;
};

struct KnownUnit {
  const char* name;
  BaseUnit base;
};
//                                     kg m  s  A  K mol cd rad
constexpr KnownUnit known_units[] = {{"kg", {{1}, 1}},
                                     {"g", {{1}, 1e-3}},
                                     {"m", {{0, 1}, 1}},
                                     {"cm", {{0, 1}, 1e-2}},
                                     {"mm", {{0, 1}, 1e-3}},
                                     {"s", {{0, 0, 1}, 1}},
                                     {"ms", {{0, 0, 1}, 1e-3}},
                                     {"A", {{0, 0, 0, 1}, 1}},
                                     {"K", {{0, 0, 0, 0, 1}, 1}},
                                     {"rad", {{0, 0, 0, 0, 0, 0, 0, 1}, 1}},
                                     {"deg", {{0, 0, 0, 0, 0, 0, 0, 1}, 0.017453292519943295}},
                                     {"Hz", {{0, 0, -1}, 1}},
                                     {"N", {{1, 1, -2}, 1}},
                                     {"Pa", {{1, -1, -2}, 1}},
                                     {"J", {{1, 2, -2}, 1}},
                                     {"W", {{1, 2, -3}, 1}},
                                     {"V", {{1, 2, -3, -1}, 1}},
                                     {"%", {{}, 1e-2}},
                                     {"1", {{}, 1}}};

/// Reads a unit: "kg m^2/s", "m/s2", "1/s". Every factor after '/' is in the denominator. Returns nullopt if a factor is unknown.
std::optional<BaseUnit> parse_unit(std::string_view text) {
  BaseUnit out;
  int sign = 1;
  bool any = false;
  while (!text.empty()) {
    if (text[0] == ' ' || text[0] == '*' || text[0] == '/') {
      if (text[0] == '/') sign = -1;
      text.remove_prefix(1);
      continue;
    }
    std::size_t end = text.find_first_of(" */");
    if (end == std::string_view::npos) end = text.size();
    std::string_view word = text.substr(0, end);
    text.remove_prefix(end);
    int power = 1;
    if (word.size() > 1 && word != "1") {
      const std::size_t digits = word.find_last_not_of("0123456789-^") + 1;
      if (digits < word.size() && digits > 0) {
        std::string_view number = word.substr(digits);
        if (number.starts_with('^')) number.remove_prefix(1);
        const std::optional<long> p = parse_long(number);
        if (!p || *p < -9 || *p > 9) return std::nullopt;
        power = static_cast<int>(*p);
        word = word.substr(0, digits);
      }
    }
    const KnownUnit* found = nullptr;
    for (const KnownUnit& u : known_units)
      if (word == u.name) found = &u;
    if (!found) return std::nullopt;
    for (std::size_t i = 0; i < bases.size(); ++i) out.powers[i] += sign * power * found->base.powers[i];
    for (int i = 0; i < std::abs(power); ++i) out.factor *= sign * power > 0 ? found->base.factor : 1 / found->base.factor;
    any = true;
  }
  return any ? std::optional(out) : std::nullopt;
}

/// Writes the document modelDescription.xml.
class Writer {
 public:
  Writer(const circuit::Circuit& c, const Interface& i, const DescribeRequest& r)
      : circuit_(c), interface_(i), request_(r), two_(r.version == 2) {}

  std::string write() {
    pugi::xml_node declaration = document_.append_child(pugi::node_declaration);
    set(declaration, "version", "1.0");
    set(declaration, "encoding", "UTF-8");
    pugi::xml_node root = document_.append_child("fmiModelDescription");
    set(root, "fmiVersion", two_ ? "2.0" : "3.0");
    set(root, "modelName", circuit_.name.empty() ? request_.identifier : circuit_.name);
    set(root, two_ ? "guid" : "instantiationToken", request_.token);
    if (!circuit_.doc.empty()) set(root, "description", circuit_.doc);
    set(root, "generationTool", "Ugoki 0.1.0");
    if (two_) set(root, "variableNamingConvention", "flat");
    if (two_) set(root, "numberOfEventIndicators", "0");
    write_unit(root.append_child("CoSimulation"));
    write_units(root);
    write_types(root);
    write_categories(root);
    pugi::xml_node experiment = root.append_child("DefaultExperiment");
    set(experiment, "startTime", "0");
    set(experiment, "stepSize", to_text(request_.dt));
    pugi::xml_node variables = root.append_child("ModelVariables");
    for (const InterfaceVariable& v : interface_.variables) write_variable(variables, v);
    write_structure(root.append_child("ModelStructure"));
    std::ostringstream out;
    document_.save(out, "  ");
    return out.str();
  }

 private:
  static void set(pugi::xml_node node, const char* attribute, const std::string& value) {
    node.append_attribute(attribute).set_value(value.c_str());
  }

  void write_unit(pugi::xml_node node) {
    set(node, "modelIdentifier", request_.identifier);
    set(node, "canHandleVariableCommunicationStepSize", "true");
    if (two_) set(node, "canNotUseMemoryManagementFunctions", "true");
    set(node, two_ ? "canGetAndSetFMUstate" : "canGetAndSetFMUState", "true");
    set(node, two_ ? "canSerializeFMUstate" : "canSerializeFMUState", "true");
    if (!two_) set(node, "fixedInternalStepSize", to_text(request_.dt));
  }

  void write_units(pugi::xml_node root) {
    std::set<std::string> units;
    for (const InterfaceVariable& v : interface_.variables)
      if (!v.unit.empty() && v.type == InterfaceType::real) units.insert(v.unit);
    if (units.empty()) return;
    pugi::xml_node list = root.append_child("UnitDefinitions");
    for (const std::string& unit : units) {
      pugi::xml_node node = list.append_child("Unit");
      set(node, "name", unit);
      const std::optional<BaseUnit> base = parse_unit(unit);
      if (!base) continue;
      pugi::xml_node b = node.append_child("BaseUnit");
      for (std::size_t i = 0; i < bases.size(); ++i)
        if (base->powers[i] != 0) set(b, bases[i], std::to_string(base->powers[i]));
      if (base->factor != 1) set(b, "factor", to_text(base->factor));
    }
  }

  [[nodiscard]] static std::string type_name(const InterfaceVariable& v) { return "choice of " + v.name; }

  void write_types(pugi::xml_node root) {
    pugi::xml_node list;
    for (const InterfaceVariable& v : interface_.variables) {
      if (v.type != InterfaceType::choice) continue;
      if (!list) list = root.append_child("TypeDefinitions");
      pugi::xml_node type = list.append_child(two_ ? "SimpleType" : "EnumerationType");
      set(type, "name", type_name(v));
      pugi::xml_node items = two_ ? type.append_child("Enumeration") : type;
      for (std::size_t i = 0; i < v.words.size(); ++i) {
        pugi::xml_node item = items.append_child("Item");
        set(item, "name", v.words[i]);
        set(item, "value", std::to_string(i + 1));
      }
    }
  }

  static void write_categories(pugi::xml_node root) {
    pugi::xml_node list = root.append_child("LogCategories");
    for (const auto& [name, text] : {std::pair{"logStatusError", "Errors that stop the circuit, with the name of the LSI and the time"},
                                     std::pair{"logStatusWarning", "Warnings"}}) {
      pugi::xml_node category = list.append_child("Category");
      set(category, "name", name);
      set(category, "description", text);
    }
  }

  [[nodiscard]] const char* type_of(const InterfaceVariable& v) const {
    switch (v.type) {
      case InterfaceType::real: return two_ ? "Real" : "Float64";
      case InterfaceType::whole: return two_ ? "Integer" : "Int64";
      case InterfaceType::boolean: return "Boolean";
      case InterfaceType::text: return "String";
      case InterfaceType::choice: return "Enumeration";
    }
    return "";
  }

  [[nodiscard]] static std::string number(const InterfaceVariable& v, double x) {
    if (v.type == InterfaceType::boolean) return x != 0 ? "true" : "false";
    if (v.type == InterfaceType::real) return to_text(x);
    return to_fixed(x, 0);
  }

  void write_limits(pugi::xml_node node, const InterfaceVariable& v) const {
    if (v.type == InterfaceType::choice) set(node, "declaredType", type_name(v));
    if (v.type == InterfaceType::real && !v.unit.empty()) set(node, "unit", v.unit);
    if (v.type != InterfaceType::real && v.type != InterfaceType::whole) return;
    // Largest limit that is written for an integer variable. FMI 2.0 stores integers as int32. FMI 3.0 uses Int64, but the limits here are
    // doubles, which represent all integers exactly only up to 2^53.
    const double top = two_ ? 2147483647.0 : 9007199254740992.0;
    const bool whole = v.type == InterfaceType::whole;
    if (v.minimum && (!whole || *v.minimum >= -top)) set(node, "min", number(v, *v.minimum));
    if (v.maximum && (!whole || *v.maximum <= top)) set(node, "max", number(v, *v.maximum));
  }

  void write_head(pugi::xml_node node, const InterfaceVariable& v, std::uint32_t element) const {
    set(node, "name", two_ && v.array ? v.name + "[" + std::to_string(element + 1) + "]" : v.name);
    set(node, "valueReference", std::to_string(v.reference + element));
    if (!v.doc.empty()) set(node, "description", v.doc);
    switch (v.role) {
      case InterfaceRole::time:
        set(node, "causality", "independent");
        set(node, "variability", "continuous");
        break;
      case InterfaceRole::input:
      case InterfaceRole::device:
        set(node, "causality", "input");
        set(node, "variability", "continuous");
        break;
      case InterfaceRole::output:
        set(node, "causality", "output");
        set(node, "variability", "continuous");
        set(node, "initial", "calculated");
        break;
      case InterfaceRole::parameter:
        set(node, "causality", "parameter");
        set(node, "variability", v.tunable ? "tunable" : "fixed");
        set(node, "initial", "exact");
        break;
    }
  }

  void write_variable(pugi::xml_node list, const InterfaceVariable& v) {
    const bool has_start = v.role != InterfaceRole::time && v.role != InterfaceRole::output;
    if (two_) {
      for (std::uint32_t k = 0; k < v.count; ++k) {
        pugi::xml_node outer = list.append_child("ScalarVariable");
        write_head(outer, v, k);
        pugi::xml_node inner = outer.append_child(type_of(v));
        write_limits(inner, v);
        if (has_start) set(inner, "start", v.type == InterfaceType::text ? v.text : number(v, v.start[k]));
      }
      return;
    }
    pugi::xml_node node = list.append_child(type_of(v));
    write_head(node, v, 0);
    write_limits(node, v);
    if (has_start && v.type == InterfaceType::text) {
      set(node.append_child("Start"), "value", v.text);
    } else if (has_start) {
      std::string starts;
      for (const double x : v.start) starts += (starts.empty() ? "" : " ") + number(v, x);
      set(node, "start", starts);
    }
    if (v.array) set(node.append_child("Dimension"), "start", std::to_string(v.count));
  }

  /// Writes the ModelStructure. FMI 2.0 refers to scalar variables by their index from 1, FMI 3.0 by value reference.
  void write_structure(pugi::xml_node node) {
    std::vector<std::uint32_t> first;
    std::uint32_t next = 1;
    for (const InterfaceVariable& v : interface_.variables) {
      first.push_back(next);
      next += v.count;
    }
    for (const bool initially : {false, true}) {
      pugi::xml_node list;
      for (std::size_t i = 0; i < interface_.variables.size(); ++i) {
        const InterfaceVariable& v = interface_.variables[i];
        if (v.role != InterfaceRole::output) continue;
        if (two_ && !list) list = node.append_child(initially ? "InitialUnknowns" : "Outputs");
        for (std::uint32_t k = 0; k < (two_ ? v.count : 1u); ++k) {
          pugi::xml_node unknown = two_ ? list.append_child("Unknown") : node.append_child(initially ? "InitialUnknown" : "Output");
          set(unknown, two_ ? "index" : "valueReference", std::to_string(two_ ? first[i] + k : v.reference));
          if (initially) continue;  // without the attribute `dependencies`, the FMI standard assumes all
          std::string dependencies;
          for (const std::uint32_t d : v.depends)
            for (std::uint32_t n = 0; n < (two_ ? interface_.variables[d].count : 1u); ++n)
              dependencies += (dependencies.empty() ? "" : " ") + std::to_string(two_ ? first[d] + n : interface_.variables[d].reference);
          set(unknown, "dependencies", dependencies);
        }
      }
    }
  }

  const circuit::Circuit& circuit_;
  const Interface& interface_;
  const DescribeRequest& request_;
  bool two_;
  pugi::xml_document document_;
};

}  // namespace

std::string write_model_description(const circuit::Circuit& circuit, const Interface& interface, const DescribeRequest& request) {
  return Writer(circuit, interface, request).write();
}

}  // namespace ugoki::fmi
