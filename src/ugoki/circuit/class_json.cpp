#include "ugoki/circuit/class_json.h"

#include <cmath>

#include "ugoki/json/fields.h"

namespace ugoki::circuit {
namespace {

using json::Json;

constexpr const char* kind_names[] = {"number", "integer", "boolean", "text", "choice", "vector"};
constexpr const char* field_names[] = {"", "f64", "f32", "i64", "i32", "u64", "u32", "i8", "u8"};
constexpr double unbounded = 1e300;  // the bound of a parameter without a limit; such bounds are not written

void add_range(Json& j, double minimum, double maximum) {
  if (minimum == maximum) return;
  j["minimum"] = minimum;
  j["maximum"] = maximum;
}

Json value_json(const Value& value) {
  if (const auto* x = std::get_if<double>(&value)) return *x;
  if (const auto* x = std::get_if<bool>(&value)) return *x;
  if (const auto* x = std::get_if<std::string>(&value)) return *x;
  return std::get<std::vector<double>>(value);
}

class Reader {
 public:
  Reader(const Json& json, const std::string& location, Error& problems) : f(json, location, problems) {}
  json::Fields f;

  std::uint32_t count(const char* key) {
    int n = 0;
    f.integer(key, n);
    if (n < 0 || n > 100'000'000) {
      f.report(ErrorCode::range, f.path(key), "A count from 0 to 100000000 is expected here.", "Install the library again.");
      return 0;
    }
    return static_cast<std::uint32_t>(n);
  }
  PinTypeId type() {
    std::string name;
    f.require("type", "a pin type");
    f.text("type", name);
    if (const PinType* found = find_pin_type(name)) return found->id;
    f.report(ErrorCode::unknown, f.path("type"), "There is no pin type '" + name + "'.", "Install the library again.");
    return PinTypeId::scalar;
  }
  template <class Item>
  void texts(Item& item) {
    f.require("name", "a name");
    f.text("name", item.name);
    f.text("unit", item.unit);
    f.text("doc", item.doc);
  }
  template <class Item>
  void range(Item& item) {
    f.number("minimum", item.minimum);
    f.number("maximum", item.maximum);
  }
};

InputPin read_input(const Json& json, const std::string& location, Error& problems) {
  Reader r(json, location, problems);
  InputPin pin;
  r.texts(pin);
  pin.type = r.type();
  r.f.boolean("required", pin.required);
  r.f.boolean("direct", pin.direct);
  r.f.boolean("multiple", pin.multiple);
  pin.count = r.count("count");
  r.f.number("value", pin.value);
  r.range(pin);
  return pin;
}

OutputPin read_output(const Json& json, const std::string& location, std::size_t inputs, Error& problems) {
  Reader r(json, location, problems);
  OutputPin pin;
  r.texts(pin);
  pin.type = r.type();
  r.f.boolean("delayed", pin.delayed);
  pin.count = r.count("count");
  r.range(pin);
  r.f.integer("like", pin.like);
  if (pin.like < -1 || pin.like >= static_cast<int>(inputs)) {
    r.f.report(ErrorCode::range, r.f.path("like"), "'like' is " + std::to_string(pin.like) + ", which is not the index of an input.",
               "Install the library again.");
    pin.like = -1;
  }
  return pin;
}

Parameter read_parameter(const Json& json, const std::string& location, Error& problems) {
  Reader r(json, location, problems);
  Parameter p;
  r.texts(p);
  std::string kind = "number";
  r.f.text("kind", kind);
  int found = -1;
  for (int i = 0; i < 6; ++i)
    if (kind == kind_names[i]) found = i;
  if (found < 0)
    r.f.report(ErrorCode::unknown, r.f.path("kind"), "There is no kind of parameter '" + kind + "'.", "Install the library again.");
  p.kind = static_cast<ParameterKind>(std::max(found, 0));
  r.f.number("minimum", p.minimum);
  r.f.number("maximum", p.maximum);
  r.f.boolean("live", p.live);
  if (const Json* words = r.f.list("choices", 10000, "words"))
    for (const Json& w : *words) p.choices.push_back(w.is_string() ? w.get<std::string>() : "");
  switch (p.kind) {
    case ParameterKind::number:
    case ParameterKind::integer: {
      double x = 0;
      r.f.number("initial", x);
      p.initial = x;
      break;
    }
    case ParameterKind::boolean: {
      bool x = false;
      r.f.boolean("initial", x);
      p.initial = x;
      break;
    }
    case ParameterKind::text:
    case ParameterKind::choice: {
      std::string x;
      r.f.text("initial", x);
      if (p.kind == ParameterKind::choice && std::find(p.choices.begin(), p.choices.end(), x) == p.choices.end())
        r.f.report(ErrorCode::range, r.f.path("initial"), "The initial value '" + x + "' is not one of the choices.",
                   "Install the library again.");
      p.initial = x;
      break;
    }
    case ParameterKind::vector: {
      std::vector<double> x(3);
      r.f.numbers("initial", x);
      p.initial = x;
      break;
    }
  }
  return p;
}

StateField read_field(const Json& json, const std::string& location, std::size_t state_bytes, Error& problems) {
  Reader r(json, location, problems);
  StateField field;
  r.texts(field);
  std::string type;
  r.f.text("type", type);
  int found = 0;
  for (int i = 1; i <= 8; ++i)
    if (type == field_names[i]) found = i;
  if (found == 0) r.f.report(ErrorCode::unknown, r.f.path("type"), "There is no field type '" + type + "'.", "Install the library again.");
  field.type = static_cast<FieldType>(std::max(found, 1));
  field.offset = r.count("offset");
  field.count = r.count("count");
  r.f.number("initial", field.initial);
  if (field.offset + std::uint64_t{field.count} * bytes_of(field.type) > state_bytes)
    r.f.report(ErrorCode::range, location,
               "The field '" + field.name + "' is outside the state of " + std::to_string(state_bytes) + " bytes.",
               "Install the library again.");
  return field;
}

template <class Items, class Read>
void read_list(json::Fields& f, const char* key, Items& items, Read read) {
  if (const Json* list = f.list(key, 10000, key))
    for (std::size_t i = 0; i < list->size(); ++i) items.push_back(read((*list)[i], f.path(key) + "/" + std::to_string(i)));
}

}  // namespace

Json class_json(const LsiClass& c) {
  Json j = {{"name", c.name}, {"doc", c.doc}, {"group", c.group}, {"from", c.from}, {"version", c.version}};
  Json inputs = Json::array(), outputs = Json::array(), parameters = Json::array(), fields = Json::array();
  for (const InputPin& pin : c.inputs) {
    Json p = {
        {"name", pin.name},     {"type", pin_type(pin.type).name}, {"unit", pin.unit},   {"doc", pin.doc},    {"required", pin.required},
        {"direct", pin.direct}, {"multiple", pin.multiple},        {"count", pin.count}, {"value", pin.value}};
    add_range(p, pin.minimum, pin.maximum);
    inputs.push_back(std::move(p));
  }
  for (const OutputPin& pin : c.outputs) {
    Json p = {{"name", pin.name}, {"type", pin_type(pin.type).name}, {"unit", pin.unit},
              {"doc", pin.doc},   {"delayed", pin.delayed},          {"count", pin.count}};
    add_range(p, pin.minimum, pin.maximum);
    if (pin.like >= 0) p["like"] = pin.like;
    outputs.push_back(std::move(p));
  }
  for (const Parameter& parameter : c.parameters) {
    Json p = {{"name", parameter.name},
              {"kind", kind_names[static_cast<std::size_t>(parameter.kind)]},
              {"initial", value_json(parameter.initial)},
              {"unit", parameter.unit},
              {"doc", parameter.doc},
              {"live", parameter.live}};
    if (parameter.minimum > -unbounded) p["minimum"] = parameter.minimum;
    if (parameter.maximum < unbounded) p["maximum"] = parameter.maximum;
    if (!parameter.choices.empty()) p["choices"] = parameter.choices;
    parameters.push_back(std::move(p));
  }
  for (const StateField& field : c.fields)
    fields.push_back({{"name", field.name},
                      {"type", field_names[static_cast<std::size_t>(field.type)]},
                      {"offset", field.offset},
                      {"count", field.count},
                      {"unit", field.unit},
                      {"doc", field.doc},
                      {"initial", field.initial}});
  j["inputs"] = std::move(inputs);
  j["outputs"] = std::move(outputs);
  j["parameters"] = std::move(parameters);
  j["fields"] = std::move(fields);
  j["state_bytes"] = c.state_bytes;
  return j;
}

LsiClass read_class(const Json& json, const std::string& location, Error& problems) {
  LsiClass c;
  Reader r(json, location, problems);
  r.f.require("name", "a name");
  r.f.text("name", c.name);
  r.f.text("doc", c.doc);
  r.f.text("group", c.group);
  r.f.text("from", c.from);
  c.version = r.count("version");
  c.state_bytes = r.count("state_bytes");
  read_list(r.f, "inputs", c.inputs, [&](const Json& j, const std::string& at) { return read_input(j, at, problems); });
  read_list(r.f, "outputs", c.outputs, [&](const Json& j, const std::string& at) { return read_output(j, at, c.inputs.size(), problems); });
  read_list(r.f, "parameters", c.parameters, [&](const Json& j, const std::string& at) { return read_parameter(j, at, problems); });
  read_list(r.f, "fields", c.fields, [&](const Json& j, const std::string& at) { return read_field(j, at, c.state_bytes, problems); });
  return c;
}

Json library_json(const Library& library) {
  Json types = Json::array(), classes = Json::array();
  for (const PinType& t : pin_types()) types.push_back({{"name", t.name}, {"color", t.color}, {"numeric", t.numeric}, {"doc", t.doc}});
  for (const LsiClass& c : library.classes()) classes.push_back(class_json(c));
  return {{"pin_types", std::move(types)}, {"classes", std::move(classes)}};
}

}  // namespace ugoki::circuit
