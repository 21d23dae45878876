#include "ugoki/fmi/model_description.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <map>
#include <pugixml.hpp>
#include <set>
#include <tuple>

#include "ugoki/base/number.h"

namespace ugoki::fmi {
namespace {

// Bounds on memory and time, against hostile files.
constexpr std::size_t max_text = std::size_t{128} << 20;  // maximum size of the XML, bytes
constexpr std::uint64_t max_elements = 1'000'000;         // elements of one array; all arrays together: 16 times as many
constexpr std::size_t max_variables = 1'000'000;
constexpr std::size_t max_problems = 20;  // maximum number of problems that are reported
constexpr std::size_t max_notes = 20;

/// Names of a type in FMI 2.0 (null: none) and 3.0.
struct TypeName {
  const char* fmi2;
  const char* fmi3;
};
constexpr std::array<TypeName, 15> type_names{{{"Real", "Float64"},
                                               {nullptr, "Float32"},
                                               {nullptr, "Int8"},
                                               {nullptr, "UInt8"},
                                               {nullptr, "Int16"},
                                               {nullptr, "UInt16"},
                                               {"Integer", "Int32"},
                                               {nullptr, "UInt32"},
                                               {nullptr, "Int64"},
                                               {nullptr, "UInt64"},
                                               {"Boolean", "Boolean"},
                                               {"Enumeration", "Enumeration"},
                                               {"String", "String"},
                                               {nullptr, "Binary"},
                                               {nullptr, "Clock"}}};

std::optional<VariableType> find_type(std::string_view name, int version) {
  for (std::size_t i = 0; i < type_names.size(); ++i) {
    const char* known = version == 2 ? type_names[i].fmi2 : type_names[i].fmi3;
    if (known && name == known) return static_cast<VariableType>(i);
  }
  return std::nullopt;
}

constexpr bool is_space(char c) { return c == ' ' || c == '\t' || c == '\n' || c == '\r'; }
std::string_view trim(std::string_view text) {
  while (!text.empty() && is_space(text.front())) text.remove_prefix(1);
  while (!text.empty() && is_space(text.back())) text.remove_suffix(1);
  return text;
}

/// Attributes that a variable inherits from its declared type (TypeDefinitions).
struct DeclaredType {
  std::string unit, display_unit;
  std::optional<double> minimum, maximum;
  int enumeration = -1;
};

/// True if `b` repeats the declaration of `a` at another line.
bool is_repeated(const Variable& a, const Variable& b) {
  const auto fields = [](const Variable& v) {
    return std::tie(v.name, v.description, v.unit, v.display_unit, v.reference, v.type, v.causality, v.variability, v.minimum, v.maximum,
                    v.start, v.texts, v.extent, v.enumeration);
  };
  return fields(a) == fields(b);
}

/// True for C identifiers of 1 to 64 characters.
bool is_identifier(std::string_view text) {
  const auto letter = [](char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_'; };
  return !text.empty() && text.size() <= 64 && letter(text[0]) &&
         std::all_of(text.begin(), text.end(), [&](char c) { return letter(c) || (c >= '0' && c <= '9'); });
}

/// Reads one modelDescription.xml.
class Reader {
 public:
  Reader(std::string_view text, std::string_view location) : text_(text), location_(location) {}

  Result<ModelDescription> read() {
    if (text_.size() > max_text)
      return fail(ErrorCode::range, location_, "The model description is larger than 128 MB.", "Export a smaller model.");
    const pugi::xml_parse_result parsed = document_.load_buffer(text_.data(), text_.size());
    if (!parsed) {
      const ErrorCode code = parsed.status == pugi::status_end_element_mismatch ? ErrorCode::truncated : ErrorCode::syntax;
      return fail(code, location_at(parsed.offset), std::string("The model description is not valid XML: ") + parsed.description() + ".",
                  "Export the FMU again.");
    }
    const pugi::xml_node root = document_.child("fmiModelDescription");
    if (!root)
      return fail(ErrorCode::syntax, location_, "The root element <fmiModelDescription> is missing.", "Choose an FMU of FMI 2.0 or 3.0.");
    if (!read_head(root)) return fail(std::move(problems_));
    read_types(root);
    read_rest(root);
    read_variables(root.child("ModelVariables"));
    check_variables();
    if (!problems_.empty()) return fail(std::move(problems_));
    return std::move(out_);
  }

 private:
  /// Line number, from 1, of the byte at `offset` in the text.
  int line_at(std::ptrdiff_t offset) {
    if (lines_.empty()) {
      lines_.push_back(0);
      for (std::size_t i = 0; i < text_.size(); ++i)
        if (text_[i] == '\n') lines_.push_back(static_cast<std::ptrdiff_t>(i) + 1);
    }
    return static_cast<int>(std::upper_bound(lines_.begin(), lines_.end(), std::max<std::ptrdiff_t>(offset, 0)) - lines_.begin());
  }
  std::string location_at(std::ptrdiff_t offset) { return location_ + ":" + std::to_string(line_at(offset)); }
  void problem(pugi::xml_node node, ErrorCode code, std::string message, std::string remedy = "Export the FMU again.") {
    if (problems_.problems.size() < max_problems)
      problems_.add(code, location_at(node.offset_debug()), std::move(message), std::move(remedy));
  }

  /// Value of a numeric attribute; nullopt if it is missing, infinite or not a number. Text that is not a number is reported as a problem.
  std::optional<double> number(pugi::xml_node node, const char* attribute) {
    const pugi::xml_attribute a = node.attribute(attribute);
    if (!a) return std::nullopt;
    const std::string_view text = trim(a.value());
    if (text == "INF" || text == "+INF" || text == "-INF") return std::nullopt;  // infinite: no bound
    const std::optional<double> x = parse_double(text);
    if (!x)
      problem(node, ErrorCode::syntax,
              std::string("'") + attribute + "' of <" + node.name() + "> is not a number: '" + std::string(text.substr(0, 40)) + "'.");
    return x;
  }
  /// Value of a boolean attribute; false if the attribute is missing.
  bool flag(pugi::xml_node node, const char* attribute) {
    const std::string_view text = trim(node.attribute(attribute).value());
    if (text.empty() || text == "false" || text == "0") return false;
    if (text == "true" || text == "1") return true;
    problem(node, ErrorCode::syntax, std::string("'") + attribute + "' of <" + node.name() + "> is neither true nor false.");
    return false;
  }

  bool read_head(pugi::xml_node root) {
    out_.written = root.attribute("fmiVersion").value();
    const bool draft = out_.written.find('-') != std::string::npos;
    if (out_.written.starts_with("2.") && !draft) {
      out_.version = 2;
    } else if (out_.written.starts_with("3.") && !draft) {
      out_.version = 3;
    } else {
      problem(root, ErrorCode::unsupported,
              "This is an FMU of FMI '" + out_.written.substr(0, 40) + "'; only FMI 2.0 and 3.0 are supported.",
              "Export it again for FMI 2.0 or 3.0.");
      return false;
    }
    out_.name = root.attribute("modelName").value();
    out_.token = root.attribute(out_.version == 2 ? "guid" : "instantiationToken").value();
    out_.description = root.attribute("description").value();
    out_.model_version = root.attribute("version").value();
    out_.tool = root.attribute("generationTool").value();
    if (out_.name.empty()) problem(root, ErrorCode::structure, "The model has no name (modelName).");
    if (!root.attribute(out_.version == 2 ? "guid" : "instantiationToken"))
      problem(root, ErrorCode::structure, out_.version == 2 ? "The model has no guid." : "The model has no instantiationToken.");
    const pugi::xml_node unit = root.child("CoSimulation");
    if (!unit) {
      problem(root, ErrorCode::unsupported,
              root.child("ModelExchange")        ? "This FMU is for model exchange only: it has no solver of its own."
              : root.child("ScheduledExecution") ? "This FMU is for scheduled execution only."
                                                 : "This FMU has no co-simulation.",
              "Export it again for co-simulation.");
      return false;
    }
    out_.identifier = unit.attribute("modelIdentifier").value();
    if (!is_identifier(out_.identifier))
      problem(unit, ErrorCode::structure, "The modelIdentifier is not a C identifier of 1 to 64 characters.");
    const bool three = out_.version == 3;
    out_.needs_execution_tool = flag(unit, "needsExecutionTool");
    out_.only_once_per_process = flag(unit, "canBeInstantiatedOnlyOncePerProcess");
    out_.variable_step = flag(unit, "canHandleVariableCommunicationStepSize");
    out_.saves_state = flag(unit, three ? "canGetAndSetFMUState" : "canGetAndSetFMUstate");
    out_.serializes_state = out_.saves_state && flag(unit, three ? "canSerializeFMUState" : "canSerializeFMUstate");
    if (three) {
      out_.event_mode = flag(unit, "hasEventMode");
      out_.internal_step = number(unit, "fixedInternalStepSize");
      if (out_.internal_step && !(*out_.internal_step > 0)) {
        problem(unit, ErrorCode::range, "'fixedInternalStepSize' is not a positive time.");
        out_.internal_step.reset();
      }
    }
    return true;
  }

  void read_rest(pugi::xml_node root) {
    for (const pugi::xml_node category : root.child("LogCategories").children("Category"))
      if (out_.log_categories.size() < 1000) out_.log_categories.emplace_back(category.attribute("name").value());
    const pugi::xml_node experiment = root.child("DefaultExperiment");
    out_.experiment = {number(experiment, "startTime"), number(experiment, "stopTime"), number(experiment, "tolerance"),
                       number(experiment, "stepSize")};
  }

  void read_items(pugi::xml_node node, DeclaredType& type, const std::string& name) {
    EnumerationType e;
    e.name = name;
    std::set<std::string> names;
    for (const pugi::xml_node item : node.children("Item")) {
      const std::optional<std::int64_t> value = whole<std::int64_t>(item.attribute("value").value());
      const std::string word = item.attribute("name").value();
      if (value && std::ranges::find(e.items, std::pair(word, *value)) != e.items.end()) {
        note_repeated("item '" + word + "' of the enumeration '" + name + "'", line_at(item.offset_debug()));
        continue;
      }
      if (!value || word.empty() || !names.insert(word).second)
        problem(item, ErrorCode::structure, "An <Item> of the enumeration '" + name + "' needs a unique name and an integer value.");
      else
        e.items.emplace_back(word, *value);
    }
    type.enumeration = static_cast<int>(out_.enumerations.size());
    out_.enumerations.push_back(std::move(e));
  }

  /// True if two declarations of a type have the same content.
  [[nodiscard]] bool is_same(const DeclaredType& a, const DeclaredType& b) const {
    const auto fields = [](const DeclaredType& t) { return std::tie(t.unit, t.display_unit, t.minimum, t.maximum); };
    if (fields(a) != fields(b) || (a.enumeration < 0) != (b.enumeration < 0)) return false;
    return a.enumeration < 0 || out_.enumerations[static_cast<std::size_t>(a.enumeration)].items ==
                                    out_.enumerations[static_cast<std::size_t>(b.enumeration)].items;
  }

  void read_types(pugi::xml_node root) {
    for (const pugi::xml_node outer : root.child("TypeDefinitions").children()) {
      pugi::xml_node inner = outer;
      if (out_.version == 2) inner = outer.first_child();
      DeclaredType type;
      const std::string name = outer.attribute("name").value();
      type.unit = inner.attribute("unit").value();
      type.display_unit = inner.attribute("displayUnit").value();
      type.minimum = number(inner, "min");
      type.maximum = number(inner, "max");
      if (std::string_view(inner.name()).starts_with("Enumeration")) read_items(inner, type, name);
      const auto [known, is_new] = types_.try_emplace(name, type);
      if (is_new) continue;
      if (is_same(known->second, type))
        note_repeated("type '" + name + "'", line_at(outer.offset_debug()));
      else
        problem(outer, ErrorCode::duplicate, "Two types are called '" + name + "' and differ.");
    }
  }

  /// Reads an integer; nullopt if the text is not an integer or is out of the range of T.
  template <class T>
  static std::optional<T> whole(std::string_view text) {
    text = trim(text);
    if (!text.empty() && text.front() == '+') text.remove_prefix(1);
    T x{};
    const auto end = std::from_chars(text.data(), text.data() + text.size(), x);
    if (text.empty() || end.ec != std::errc{} || end.ptr != text.data() + text.size()) return std::nullopt;
    return x;
  }

  /// Reads the start values of a variable from its attribute or child elements.
  void read_start(pugi::xml_node node, Variable& v) {
    const pugi::xml_attribute a = node.attribute("start");
    if (v.type == VariableType::string && out_.version == 3) {
      for (const pugi::xml_node start : node.children("Start")) v.texts.emplace_back(start.attribute("value").value());
      return;
    }
    if (!a) return;
    if (v.type == VariableType::string) {
      v.texts.emplace_back(a.value());
      return;
    }
    for (std::string_view rest = trim(a.value()); !rest.empty();) {
      std::size_t end = 0;
      while (end < rest.size() && !is_space(rest[end])) ++end;
      const std::string_view word = rest.substr(0, end);
      std::optional<double> x;
      if (v.type == VariableType::boolean)
        x = word == "true" || word == "1" ? std::optional(1.0) : word == "false" || word == "0" ? std::optional(0.0) : std::nullopt;
      else
        x = parse_double(word.starts_with('+') ? word.substr(1) : word);
      if (!x) {
        problem(node, ErrorCode::syntax,
                "The start value of '" + v.name + "' is not valid for its type: '" + std::string(word.substr(0, 40)) + "'.");
        return;
      }
      if (v.start.size() >= max_elements || ++elements_ > 4 * max_elements) {
        problem(node, ErrorCode::range, "'" + v.name + "' has more than a million start values, or the model has more than four million.",
                "Export a smaller model.");
        return;
      }
      v.start.push_back(*x);
      rest = trim(rest.substr(end));
    }
  }

  /// Reads causality and variability, with the defaults of the standard.
  void read_causality(pugi::xml_node node, Variable& v) {
    static constexpr std::pair<std::string_view, Causality> causalities[] = {{"parameter", Causality::parameter},
                                                                             {"calculatedParameter", Causality::calculated_parameter},
                                                                             {"structuralParameter", Causality::structural_parameter},
                                                                             {"input", Causality::input},
                                                                             {"output", Causality::output},
                                                                             {"local", Causality::local},
                                                                             {"independent", Causality::independent}};
    static constexpr std::pair<std::string_view, Variability> variabilities[] = {{"constant", Variability::constant},
                                                                                 {"fixed", Variability::fixed},
                                                                                 {"tunable", Variability::tunable},
                                                                                 {"discrete", Variability::discrete},
                                                                                 {"continuous", Variability::continuous}};
    const std::string_view causality = node.attribute("causality").value(), variability = node.attribute("variability").value();
    bool known = causality.empty();
    for (const auto& [name, value] : causalities)
      if (name == causality) {
        v.causality = value;
        known = true;
      }
    if (!known)
      problem(node, ErrorCode::unknown, "'" + v.name + "' has an unknown causality, '" + std::string(causality.substr(0, 40)) + "'.");
    const bool parameter = v.causality == Causality::parameter || v.causality == Causality::calculated_parameter ||
                           v.causality == Causality::structural_parameter;
    const bool real = v.type == VariableType::float64 || v.type == VariableType::float32;
    v.variability = parameter ? Variability::fixed : real ? Variability::continuous : Variability::discrete;
    if (out_.version == 2 && !parameter) v.variability = Variability::continuous;
    known = variability.empty();
    for (const auto& [name, value] : variabilities)
      if (name == variability) {
        v.variability = value;
        known = true;
      }
    if (!known)
      problem(node, ErrorCode::unknown, "'" + v.name + "' has an unknown variability, '" + std::string(variability.substr(0, 40)) + "'.");
  }

  void read_variables(pugi::xml_node list) {
    for (const pugi::xml_node outer : list.children()) {
      if (outer.type() != pugi::node_element) continue;
      if (problems_.problems.size() >= max_problems) return;
      if (out_.variables.size() >= max_variables) {
        problem(outer, ErrorCode::range, "There are more than a million variables.", "Export fewer variables.");
        return;
      }
      pugi::xml_node inner = outer;
      if (out_.version == 2) {
        if (std::string_view(outer.name()) != "ScalarVariable") continue;
        for (const pugi::xml_node child : outer.children())
          if (find_type(child.name(), 2)) inner = child;
      }
      const std::optional<VariableType> type = find_type(inner.name(), out_.version);
      Variable v;
      v.name = outer.attribute("name").value();
      v.line = line_at(outer.offset_debug());
      if (!type) {
        problem(outer, ErrorCode::unknown, "The variable '" + v.name + "' has no type of the FMI standard.");
        continue;
      }
      v.type = *type;
      v.description = outer.attribute("description").value();
      const std::optional<ValueReference> reference = whole<ValueReference>(outer.attribute("valueReference").value());
      if (v.name.empty()) problem(outer, ErrorCode::structure, "A variable has no name.");
      if (!reference) {
        const std::string text = outer.attribute("valueReference").value();
        problem(outer, ErrorCode::structure,
                text.empty() ? "The variable '" + v.name + "' has no value reference."
                             : "The value reference '" + text.substr(0, 40) + "' of the variable '" + v.name +
                                   "' is not a whole number from 0 to 4294967295.");
      }
      v.reference = reference.value_or(0);
      read_causality(outer, v);
      const std::string declared = inner.attribute("declaredType").value();
      if (const auto found = types_.find(declared); found != types_.end()) {
        v.unit = found->second.unit;
        v.display_unit = found->second.display_unit;
        v.minimum = found->second.minimum;
        v.maximum = found->second.maximum;
        v.enumeration = found->second.enumeration;
      } else if (!declared.empty()) {
        problem(outer, ErrorCode::unknown,
                "The variable '" + v.name + "' is of the type '" + declared.substr(0, 100) + "', which is not declared.");
      }
      if (const auto a = inner.attribute("unit")) v.unit = a.value();
      if (const auto a = inner.attribute("displayUnit")) v.display_unit = a.value();
      if (const auto x = number(inner, "min")) v.minimum = x;
      if (const auto x = number(inner, "max")) v.maximum = x;
      read_start(inner, v);
      for (const pugi::xml_node d : inner.children("Dimension")) read_dimension(d, v);
      out_.variables.push_back(std::move(v));
    }
  }

  /// Reads a dimension of an array. Its size is fixed, or is the value of a structural parameter, which check_variables() looks up.
  void read_dimension(pugi::xml_node node, Variable& v) {
    if (v.extent.size() >= 32) return problem(node, ErrorCode::range, "'" + v.name + "' has more than 32 dimensions.");
    if (const auto fixed = whole<std::uint64_t>(node.attribute("start").value())) {
      v.extent.push_back(*fixed);
    } else if (const auto reference = whole<ValueReference>(node.attribute("valueReference").value())) {
      v.extent.push_back(0);
      open_.push_back({out_.variables.size(), v.extent.size() - 1, *reference});
    } else {
      problem(node, ErrorCode::structure, "A dimension of '" + v.name + "' has neither a start nor a value reference.");
    }
  }

  /// Removes variables that repeat an earlier one completely.
  void remove_repeated() {
    std::map<std::string_view, std::size_t> first;  // name -> index of the first variable with this name
    std::vector<Variable> kept;
    kept.reserve(out_.variables.size());  // no reallocation, because `first` has views of the names in `kept`
    for (Variable& v : out_.variables) {
      if (const auto known = first.find(v.name); known != first.end() && is_repeated(kept[known->second], v)) {
        note_repeated("variable '" + v.name + "'", v.line);
        continue;
      }
      kept.push_back(std::move(v));
      first.try_emplace(kept.back().name, kept.size() - 1);
    }
    out_.variables = std::move(kept);
  }
  void note_repeated(const std::string& what, int line) {
    if (out_.notes.size() < max_notes)
      out_.notes.push_back("The model description repeats its " + what + " in line " + std::to_string(line) + "; it is read once.");
  }

  /// Sets array sizes from structural parameters. Checks that names and value references are unique. Checks ranges and the numbers of start
  /// values.
  void check_variables() {
    std::map<ValueReference, const Variable*> structural;
    for (const Variable& v : out_.variables)
      if (v.causality == Causality::structural_parameter && v.start.size() == 1) structural[v.reference] = &v;
    for (const auto& [variable, dimension, reference] : open_) {
      const auto found = structural.find(reference);
      Variable& v = out_.variables[variable];
      if (found != structural.end() && found->second->start[0] >= 0 && found->second->start[0] <= 1e9)
        v.extent[dimension] = static_cast<std::uint64_t>(found->second->start[0]);
      else
        wrong(v, ErrorCode::unknown, "A dimension of '" + v.name + "' does not refer to a structural parameter with a valid size.");
    }
    remove_repeated();
    std::set<std::string_view> names;
    std::set<ValueReference> references;
    std::uint64_t all = 0;
    for (const Variable& v : out_.variables) {
      if (v.type == VariableType::clock && v.causality == Causality::input)
        wrong(v, ErrorCode::unsupported, "The input '" + v.name + "' is a clock that the importing tool must tick, which is not supported.",
              "Export it again with clocks that are outputs or local, or without clocks.");
      if (!names.insert(v.name).second) wrong(v, ErrorCode::duplicate, "Two variables are called '" + v.name + "' and differ.");
      if (out_.version == 3 && !references.insert(v.reference).second)
        wrong(v, ErrorCode::duplicate, "Two variables have the value reference " + std::to_string(v.reference) + ".");
      if (v.minimum && v.maximum && *v.minimum > *v.maximum)
        wrong(v, ErrorCode::range, "The minimum of '" + v.name + "' is above its maximum.");
      const std::uint64_t count = v.count();
      all += std::min(count, max_elements + 1);
      if (count > max_elements || all > 16 * max_elements)
        wrong(v, ErrorCode::range, "The array '" + v.name + "' makes the model too large.");
      else if (v.start.size() > 1 && v.start.size() != count)
        wrong(v, ErrorCode::structure,
              "'" + v.name + "' has " + std::to_string(v.start.size()) + " start values for " + std::to_string(count) + " elements.");
    }
  }
  void wrong(const Variable& v, ErrorCode code, std::string message, std::string remedy = "Export the FMU again.") {
    if (problems_.problems.size() < max_problems)
      problems_.add(code, location_ + ":" + std::to_string(v.line), std::move(message), std::move(remedy));
  }

  /// A dimension whose size is the start value of the structural parameter `reference`.
  struct OpenDimension {
    std::size_t variable, dimension;
    ValueReference reference;
  };

  std::string_view text_;
  std::string location_;
  pugi::xml_document document_;
  std::vector<std::ptrdiff_t> lines_;  // offset of the first byte of each line; filled at the first use
  Error problems_;
  ModelDescription out_;
  std::map<std::string, DeclaredType> types_;
  std::vector<OpenDimension> open_;
  std::uint64_t elements_ = 0;  // number of start values read so far
};

}  // namespace

std::uint64_t Variable::count() const {
  std::uint64_t n = 1;
  for (const std::uint64_t e : extent) {
    if (e != 0 && n > (std::uint64_t{1} << 40) / e) return std::uint64_t{1} << 40;  // avoids an overflow; 2^40 is far above every limit
    n *= e;
  }
  return n;
}

std::string_view name_of(VariableType type, int version) {
  const TypeName& names = type_names[static_cast<std::size_t>(type)];
  return version == 2 && names.fmi2 ? names.fmi2 : names.fmi3;
}

Result<ModelDescription> read_model_description(std::string_view xml, std::string_view location) { return Reader(xml, location).read(); }

}  // namespace ugoki::fmi
