// Reads and writes the JSON text of circuits. The type of every JSON value is checked before it is read, so that the JSON library
// never throws.

#include <initializer_list>
#include <nlohmann/json.hpp>

#include "ugoki/base/number.h"
#include "ugoki/circuit/circuit.h"
#include "ugoki/circuit/migrate.h"
#include "ugoki/json/json.h"

namespace ugoki::circuit {
namespace {

using json::Json;

constexpr int max_depth = 32;           // maximum nesting of circuits; bounds the recursion of the reader
constexpr std::size_t max_shown = 100;  // maximum number of bytes of a wrong name that a message prints

bool is_id(std::string_view text) {
  if (text.empty() || text.size() > 64) return false;
  for (const char c : text) {
    const bool good = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '-';
    if (!good) return false;
  }
  return true;
}

/// Whether the text is "id.pin" with a valid id and a non-empty pin name.
bool is_end(std::string_view text) {
  const auto dot = text.find('.');
  return dot != std::string_view::npos && is_id(text.substr(0, dot)) && dot + 1 < text.size();
}

class Reader {
 public:
  Error problems;

  Circuit read(const Json& json, const std::string& location, int depth, bool outermost) {
    Circuit c;
    if (!object(json, location)) return c;
    if (depth > max_depth) {
      problems.add(ErrorCode::range, location, "Circuits are nested more than " + std::to_string(max_depth) + " deep.",
                   "Flatten the innermost ones.");
      return c;
    }
    known_fields(json, location,
                 {"version", "name", "doc", "inputs_at", "outputs_at", "inputs", "outputs", "parameters", "lsis", "wires", "notes",
                  "probes", "circuits"});
    if (outermost) read_version(json, location);
    c.name = text(json, "name", location, !outermost);
    c.doc = text(json, "doc", location, false);
    if (json.contains("inputs_at")) c.inputs_at = position(json, "inputs_at", location);
    if (json.contains("outputs_at")) c.outputs_at = position(json, "outputs_at", location);
    each(json, "inputs", location, [&](const Json& j, const std::string& p) { c.inputs.push_back(read_pin(j, p, "to")); });
    each(json, "outputs", location, [&](const Json& j, const std::string& p) { c.outputs.push_back(read_pin(j, p, "from")); });
    each(json, "parameters", location, [&](const Json& j, const std::string& p) { c.parameters.push_back(read_parameter(j, p)); });
    each(json, "lsis", location, [&](const Json& j, const std::string& p) { c.lsis.push_back(read_instance(j, p)); });
    each(json, "wires", location, [&](const Json& j, const std::string& p) { c.wires.push_back(read_wire(j, p)); });
    each(json, "notes", location, [&](const Json& j, const std::string& p) { c.notes.push_back(read_note(j, p)); });
    each(json, "probes", location, [&](const Json& j, const std::string& p) { c.probes.push_back(read_probe(j, p)); });
    each(json, "circuits", location, [&](const Json& j, const std::string& p) { c.circuits.push_back(read(j, p, depth + 1, false)); });
    return c;
  }

 private:
  bool object(const Json& json, const std::string& location) {
    if (json.is_object()) return true;
    problems.add(ErrorCode::syntax, location, "An object { } is expected here.", "See docs/circuit.md for the format.");
    return false;
  }

  void known_fields(const Json& json, const std::string& location, std::initializer_list<std::string_view> names) {
    for (auto it = json.begin(); it != json.end(); ++it) {
      bool known = false;
      for (const std::string_view n : names) known = known || it.key() == n;
      if (!known)
        problems.add(ErrorCode::unknown, location + "/" + it.key(), "There is no field '" + it.key() + "' here.",
                     "Remove it, or correct its spelling; write comments into \"note\" or \"doc\".");
    }
  }

  void read_version(const Json& json, const std::string& location) {
    const auto it = json.find("version");
    if (it == json.end() || !it->is_number_integer()) {
      problems.add(ErrorCode::syntax, location + "/version", "The version of the circuit format is missing.",
                   "Write \"version\": " + std::to_string(circuit_version) + ".");
    } else if (it->get<std::int64_t>() != circuit_version) {
      problems.add(
          ErrorCode::unsupported, location + "/version",
          "This program reads circuits up to version " + std::to_string(circuit_version) + "; this circuit has version " + it->dump() + ".",
          "Use the program that wrote it, or a newer one.");
    }
  }

  template <class Visit>
  void each(const Json& json, const char* field, const std::string& location, Visit visit) {
    const auto it = json.find(field);
    if (it == json.end()) return;
    const std::string at = location + "/" + field;
    if (!it->is_array()) {
      problems.add(ErrorCode::syntax, at, "A list [ ] is expected here.", "See docs/circuit.md for the format.");
      return;
    }
    for (std::size_t i = 0; i < it->size(); ++i) visit((*it)[i], at + "/" + std::to_string(i));
  }

  std::string text(const Json& json, const char* field, const std::string& location, bool required) {
    const auto it = json.find(field);
    if (it == json.end()) {
      if (required) problems.add(ErrorCode::syntax, location, "The field '" + std::string(field) + "' is missing.", "Add it.");
      return {};
    }
    if (!it->is_string()) {
      problems.add(ErrorCode::syntax, location + "/" + field, "A string is expected here.", "Put it into double quotes.");
      return {};
    }
    return it->get<std::string>();
  }

  std::string end(const Json& json, const std::string& location) {
    if (json.is_string()) {
      auto value = json.get<std::string>();
      if (is_end(value)) return value;
    }
    problems.add(ErrorCode::syntax, location, "A pin is expected here.", "Write it as \"id.pin\".");
    return {};
  }

  std::vector<std::string> ends(const Json& json, const char* field, const std::string& location) {
    std::vector<std::string> out;
    const auto it = json.find(field);
    const std::string at = location + "/" + field;
    if (it == json.end()) {
      problems.add(ErrorCode::syntax, location, "The field '" + std::string(field) + "' is missing.",
                   "Name the pins inside the circuit as \"id.pin\".");
    } else if (it->is_array()) {
      for (std::size_t i = 0; i < it->size(); ++i) out.push_back(end((*it)[i], at + "/" + std::to_string(i)));
    } else {
      out.push_back(end(*it, at));
    }
    return out;
  }

  BoundaryPin read_pin(const Json& json, const std::string& location, const char* direction) {
    BoundaryPin pin;
    if (!object(json, location)) return pin;
    known_fields(json, location, {"name", "type", "unit", "doc", direction});
    pin.name = text(json, "name", location, true);
    if (pin.name.find('.') != std::string::npos)
      problems.add(ErrorCode::syntax, location + "/name", "The name of a pin must not contain '.'.", "Use a space or '_'.");
    const std::string type = text(json, "type", location, true);
    if (const PinType* found = find_pin_type(type)) {
      pin.type = found->id;
    } else {
      std::string all;
      for (const PinType& t : pin_types()) all += (all.empty() ? "" : ", ") + std::string(t.name);
      problems.add(ErrorCode::unknown, location + "/type", "There is no pin type '" + type.substr(0, max_shown) + "'.",
                   "Use one of: " + all + ".");
    }
    pin.unit = text(json, "unit", location, false);
    pin.doc = text(json, "doc", location, false);
    pin.ends = ends(json, direction, location);
    if (std::string_view(direction) == "from" && pin.ends.size() > 1)
      problems.add(ErrorCode::structure, location + "/from", "An output takes its value from one pin only.", "Name one \"id.pin\".");
    return pin;
  }

  BoundaryParameter read_parameter(const Json& json, const std::string& location) {
    BoundaryParameter p;
    if (!object(json, location)) return p;
    known_fields(json, location, {"name", "doc", "to"});
    p.name = text(json, "name", location, true);
    p.doc = text(json, "doc", location, false);
    p.ends = ends(json, "to", location);
    return p;
  }

  void read_values(const Json& json, const char* field, const std::string& location, std::vector<NamedValue>& out) {
    const auto it = json.find(field);
    if (it == json.end()) return;
    const std::string at = location + "/" + field;
    if (!object(*it, at)) return;
    for (auto value = it->begin(); value != it->end(); ++value) {
      const std::string here = at + "/" + value.key();
      if (value->is_boolean()) {
        out.emplace_back(value.key(), value->get<bool>());
      } else if (value->is_number()) {
        out.emplace_back(value.key(), value->get<double>());
      } else if (value->is_string()) {
        out.emplace_back(value.key(), value->get<std::string>());
      } else if (value->is_array()) {
        std::vector<double> numbers;
        for (const Json& n : *value) {
          if (n.is_number()) numbers.push_back(n.get<double>());
        }
        if (numbers.size() != value->size())
          problems.add(ErrorCode::syntax, here, "A list of numbers is expected here.", "Remove the elements that are not numbers.");
        out.emplace_back(value.key(), std::move(numbers));
      } else {
        problems.add(ErrorCode::syntax, here, "A number, true, false, a string or a list of numbers is expected here.",
                     "Remove it to use the default.");
      }
    }
  }

  Instance read_instance(const Json& json, const std::string& location) {
    Instance lsi;
    if (!object(json, location)) return lsi;
    known_fields(json, location, {"id", "type", "label", "note", "at", "every", "parameters", "values"});
    lsi.id = text(json, "id", location, true);
    if (json.contains("id") && !is_id(lsi.id))
      problems.add(ErrorCode::syntax, location + "/id", "'" + lsi.id.substr(0, max_shown) + "' cannot be an id.",
                   "Use 1 to 64 letters, digits, '_' and '-'.");
    lsi.type = text(json, "type", location, true);
    lsi.label = text(json, "label", location, false);
    lsi.note = text(json, "note", location, false);
    lsi.at = position(json, "at", location);
    if (const auto it = json.find("every"); it != json.end()) {
      if (it->is_number_unsigned() && it->get<std::uint64_t>() <= 1000000) {
        lsi.every = it->get<std::uint32_t>();
      } else {
        problems.add(ErrorCode::range, location + "/every", "A whole number of ticks from 0 to 1000000 is expected here.",
                     "Use 1 to run it at each tick, 0 to run it on demand only.");
      }
    }
    read_values(json, "parameters", location, lsi.parameters);
    read_values(json, "values", location, lsi.values);
    return lsi;
  }

  Position position(const Json& json, const char* field, const std::string& location) {
    const auto it = json.find(field);
    if (it == json.end()) return {};
    if (it->is_array() && it->size() == 2 && (*it)[0].is_number() && (*it)[1].is_number())
      return {(*it)[0].get<double>(), (*it)[1].get<double>()};
    problems.add(ErrorCode::syntax, location + "/" + field, "Two numbers [x, y] are expected here.", "Write a list of two numbers.");
    return {};
  }

  Note read_note(const Json& json, const std::string& location) {
    Note note;
    if (!object(json, location)) return note;
    known_fields(json, location, {"id", "text", "at", "size"});
    note.id = text(json, "id", location, true);
    note.text = text(json, "text", location, false);
    note.at = position(json, "at", location);
    note.size = position(json, "size", location);
    return note;
  }

  ProbeMark read_probe(const Json& json, const std::string& location) {
    ProbeMark probe;
    if (!object(json, location)) return probe;
    known_fields(json, location, {"pin", "at", "components"});
    const auto pin = json.find("pin");
    probe.pin = end(pin == json.end() ? Json() : *pin, location + "/pin");
    probe.at = position(json, "at", location);
    const std::string at = location + "/components";
    each(json, "components", location, [&](const Json& j, const std::string&) {
      if (j.is_number_unsigned() && j.get<std::uint64_t>() < (1u << 24))
        probe.components.push_back(j.get<std::uint32_t>());
      else
        problems.add(ErrorCode::syntax, at, "A list of integers from 0 is expected here.",
                     "Give indices of the pin's numbers, counted from 0.");
    });
    return probe;
  }

  Wire read_wire(const Json& json, const std::string& location) {
    Wire wire;
    if (!object(json, location)) return wire;
    known_fields(json, location, {"from", "to"});
    for (const char* field : {"from", "to"}) {
      const auto it = json.find(field);
      if (it == json.end()) {
        problems.add(ErrorCode::syntax, location, "The field '" + std::string(field) + "' is missing.", "Write it as \"id.pin\".");
      } else {
        (std::string_view(field) == "from" ? wire.from : wire.to) = end(*it, location + "/" + field);
      }
    }
    return wire;
  }
};

std::string quoted(const std::string& text) { return Json(text).dump(-1, ' ', false, Json::error_handler_t::replace); }

std::string value_text(const Value& value) {
  if (const auto* number = std::get_if<double>(&value)) return to_text(*number);
  if (const auto* flag = std::get_if<bool>(&value)) return *flag ? "true" : "false";
  if (const auto* text = std::get_if<std::string>(&value)) return quoted(*text);
  std::string out = "[";
  for (const double x : std::get<std::vector<double>>(value)) out += (out.size() > 1 ? ", " : "") + to_text(x);
  return out + "]";
}

void add_text(std::string& line, const char* field, const std::string& value) {
  if (!value.empty()) line += ", \"" + std::string(field) + "\": " + quoted(value);
}

void add_values(std::string& line, const char* field, const std::vector<NamedValue>& values) {
  if (values.empty()) return;
  line += ", \"" + std::string(field) + "\": {";
  for (std::size_t i = 0; i < values.size(); ++i) line += (i ? ", " : "") + quoted(values[i].first) + ": " + value_text(values[i].second);
  line += "}";
}

std::string ends_text(const std::vector<std::string>& ends) {
  if (ends.size() == 1) return quoted(ends[0]);
  std::string out = "[";
  for (std::size_t i = 0; i < ends.size(); ++i) out += (i ? ", " : "") + quoted(ends[i]);
  return out + "]";
}

std::string pin_text(const BoundaryPin& pin, const char* direction) {
  std::string line = "{\"name\": " + quoted(pin.name) + ", \"type\": " + quoted(std::string(pin_type(pin.type).name));
  add_text(line, "unit", pin.unit);
  add_text(line, "doc", pin.doc);
  return line + ", \"" + direction + "\": " + ends_text(pin.ends) + "}";
}

std::string position_text(const Position& p) { return "[" + to_text(p.x) + ", " + to_text(p.y) + "]"; }

std::string note_text(const Note& note) {
  std::string line = "{\"id\": " + quoted(note.id) + ", \"text\": " + quoted(note.text) + ", \"at\": " + position_text(note.at);
  if (!(note.size == Position{})) line += ", \"size\": " + position_text(note.size);
  return line + "}";
}

std::string probe_text(const ProbeMark& probe) {
  std::string line = "{\"pin\": " + quoted(probe.pin) + ", \"at\": " + position_text(probe.at);
  if (!probe.components.empty()) {
    line += ", \"components\": [";
    for (std::size_t i = 0; i < probe.components.size(); ++i) line += (i ? ", " : "") + std::to_string(probe.components[i]);
    line += "]";
  }
  return line + "}";
}

std::string instance_text(const Instance& lsi) {
  std::string line = "{\"id\": " + quoted(lsi.id) + ", \"type\": " + quoted(lsi.type);
  add_text(line, "label", lsi.label);
  add_text(line, "note", lsi.note);
  if (!(lsi.at == Position{})) line += ", \"at\": " + position_text(lsi.at);
  if (lsi.every != 1) line += ", \"every\": " + std::to_string(lsi.every);
  add_values(line, "parameters", lsi.parameters);
  add_values(line, "values", lsi.values);
  return line + "}";
}

template <class Items, class Text>
void write_list(std::string& out, const std::string& indent, const char* field, const Items& items, Text item_text) {
  if (items.empty()) return;
  out += ",\n" + indent + "  \"" + field + "\": [";
  for (std::size_t i = 0; i < items.size(); ++i) out += (i ? ",\n" : "\n") + indent + "    " + item_text(items[i]);
  out += "\n" + indent + "  ]";
}

std::string circuit_text(const Circuit& c, const std::string& indent, bool outermost) {
  std::string out = "{\n" + indent + "  ";
  if (outermost) out += "\"version\": " + std::to_string(circuit_version) + ",\n" + indent + "  ";
  out += "\"name\": " + quoted(c.name);
  if (!c.doc.empty()) out += ",\n" + indent + "  \"doc\": " + quoted(c.doc);
  if (c.inputs_at) out += ",\n" + indent + "  \"inputs_at\": " + position_text(*c.inputs_at);
  if (c.outputs_at) out += ",\n" + indent + "  \"outputs_at\": " + position_text(*c.outputs_at);
  write_list(out, indent, "inputs", c.inputs, [](const BoundaryPin& p) { return pin_text(p, "to"); });
  write_list(out, indent, "outputs", c.outputs, [](const BoundaryPin& p) { return pin_text(p, "from"); });
  write_list(out, indent, "parameters", c.parameters, [](const BoundaryParameter& p) {
    std::string line = "{\"name\": " + quoted(p.name);
    add_text(line, "doc", p.doc);
    return line + ", \"to\": " + ends_text(p.ends) + "}";
  });
  write_list(out, indent, "lsis", c.lsis, instance_text);
  write_list(out, indent, "wires", c.wires,
             [](const Wire& w) { return "{\"from\": " + quoted(w.from) + ", \"to\": " + quoted(w.to) + "}"; });
  write_list(out, indent, "notes", c.notes, note_text);
  write_list(out, indent, "probes", c.probes, probe_text);
  write_list(out, indent, "circuits", c.circuits, [&](const Circuit& inner) { return circuit_text(inner, indent + "    ", false); });
  return out + "\n" + indent + "}";
}

}  // namespace

Result<Circuit> read_circuit(std::string_view text, std::string_view location) {
  Result<Json> json = json::parse_json(text, location);
  if (!json) return fail(std::move(json.error()));
  migrate(*json);
  Reader reader;
  Circuit circuit = reader.read(*json, std::string(location), 0, true);
  if (!reader.problems.empty()) return fail(std::move(reader.problems));
  return circuit;
}

std::string write_circuit(const Circuit& circuit) { return circuit_text(circuit, "", true) + "\n"; }

}  // namespace ugoki::circuit
