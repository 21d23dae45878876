#include "ugoki/plugin/declarations.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace ugoki::plugin {
namespace {

using circuit::LsiClass;

// Bounds against damaged tables.
constexpr std::uint32_t max_entries = 10'000;                 // maximum number of entries of one table
constexpr std::uint32_t max_elements = 1'000'000;             // maximum number of elements of one pin
constexpr std::uint64_t max_state = std::uint64_t{64} << 20;  // maximum size of a state, bytes; documented in ugoki/lsi.h

std::string text_of(const char* text) { return text ? text : ""; }

/// True if the text is a valid name of a library.
bool is_name(std::string_view text) {
  return !text.empty() && text.size() <= 64 && std::all_of(text.begin(), text.end(), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '-';
  });
}

/// A table whose entries may be longer than T, if the library was built with a later header. The first field of an entry is its size in
/// bytes, which is the distance between entries.
template <class T>
class Table {
 public:
  Table(const T* first, std::uint32_t count) : bytes_(reinterpret_cast<const char*>(first)), count_(count) {}
  /// False if the entries are shorter than T, differ in size, are not aligned for T, or are too many.
  [[nodiscard]] bool valid() const {
    if (count_ == 0) return true;
    if (!bytes_ || count_ > max_entries) return false;
    const std::uint32_t stride = at(0, 0).size;
    if (stride < sizeof(T) || stride % alignof(T) != 0 || stride > 65536) return false;
    for (std::uint32_t i = 0; i < count_; ++i)
      if (at(i, stride).size != stride) return false;
    return true;
  }
  template <class Visit>
  void each(Visit visit) const {  // calls visit(entry) for all entries; requires valid()
    for (std::uint32_t i = 0; i < count_; ++i) visit(at(i, at(0, 0).size));
  }

 private:
  [[nodiscard]] const T& at(std::uint32_t i, std::uint32_t stride) const {
    return *reinterpret_cast<const T*>(bytes_ + static_cast<std::size_t>(i) * stride);
  }
  const char* bytes_;
  std::uint32_t count_;
};

/// Converts the tables of one library to LSI classes.
class Reader {
 public:
  Reader(std::string location, Error& problems) : location_(std::move(location)), problems_(problems) {}

  Declared read(const ugoki_library* library) {
    Declared out;
    if (!library || library->size < offsetof(ugoki_library, name)) {
      wrong(location_, "The library has no description, or one of a few bytes only.");
      return out;
    }
    if (library->abi != UGOKI_LSI_ABI) {
      problems_.add(ErrorCode::unsupported, location_,
                    "The library was built for version " + std::to_string(library->abi) +
                        " of the LSI interface; this program has version " + std::to_string(UGOKI_LSI_ABI) + ".",
                    "Rebuild it with this program: ugoki lsi build FILE.c");
      return out;
    }
    if (library->size < sizeof(ugoki_library)) {
      wrong(location_, "The description of the library is too short.");
      return out;
    }
    out.name = text_of(library->name);
    out.version = text_of(library->version);
    out.doc = text_of(library->doc);
    if (!is_name(out.name))
      wrong(location_, "'" + out.name + "' is not a valid name of a library: it needs 1 to 64 letters, digits, '_' and '-'.");
    if (library->class_count == 0 || library->class_count > max_entries || !library->classes) {
      wrong(location_, "The library has no LSIs, or more than " + std::to_string(max_entries) + ".");
      return out;
    }
    for (std::uint32_t i = 0; i < library->class_count; ++i) {
      if (library->classes[i] && library->classes[i]->size >= sizeof(ugoki_class))
        out.classes.push_back(read_class(*library->classes[i], out.name));
      else
        wrong(location_, "The description of LSI number " + std::to_string(i + 1) + " is missing or too short.");
    }
    std::sort(out.classes.begin(), out.classes.end(), [](const LsiClass& a, const LsiClass& b) { return a.name < b.name; });
    for (std::size_t i = 1; i < out.classes.size(); ++i)
      if (out.classes[i].name == out.classes[i - 1].name)
        wrong(location_, "Two LSIs of the library are called '" + out.classes[i].name + "'.");
    return out;
  }

 private:
  void wrong(const std::string& location, std::string message) {
    problems_.add(ErrorCode::structure, location, std::move(message), "Correct the declaration and rebuild the library.");
  }

  LsiClass read_class(const ugoki_class& from, const std::string& library) {
    LsiClass c;
    const std::string name = text_of(from.name);
    const std::string here = location_ + ", LSI '" + name + "'";
    if (name.empty() || name.size() > 100 || name.find_first_of("./") != std::string::npos)
      wrong(here, "The name of an LSI must have 1 to 100 characters, none of them '.' or '/'.");
    c.name = library + "/" + name;
    c.doc = text_of(from.doc);
    c.group = from.group && *from.group ? from.group : library;
    c.from = library;
    c.version = from.version;
    c.abi = &from;
    const Table inputs(from.inputs, from.input_count);
    const Table outputs(from.outputs, from.output_count);
    const Table parameters(from.parameters, from.parameter_count);
    const Table fields(from.fields, from.field_count);
    if (!inputs.valid() || !outputs.valid() || !parameters.valid() || !fields.valid()) {
      wrong(here, "The tables of pins, parameters or state fields are damaged.");
      return c;
    }
    inputs.each([&](const ugoki_input& pin) { c.inputs.push_back(read_input(pin, here)); });
    outputs.each([&](const ugoki_output& pin) { c.outputs.push_back(read_output(pin, here, from)); });
    parameters.each([&](const ugoki_parameter& p) { c.parameters.push_back(read_parameter(p, here)); });
    if (from.state_size > max_state) wrong(here, "The state has " + std::to_string(from.state_size) + " bytes; the limit is 64 MB.");
    c.state_bytes = static_cast<std::size_t>(std::min(from.state_size, max_state));
    fields.each([&](const ugoki_field& f) { c.fields.push_back(read_field(f, here, c.state_bytes)); });
    check_names(c.inputs, here, "inputs");
    check_names(c.outputs, here, "outputs");
    check_names(c.parameters, here, "parameters");
    check_names(c.fields, here, "fields of the state");
    for (std::size_t i = 0; i + 1 < c.inputs.size(); ++i)
      if (c.inputs[i].multiple && !c.inputs[i + 1].multiple)
        wrong(here, "Inputs with UGOKI_MULTIPLE must be declared after all other inputs.");
    if (!from.step && !from.advance) wrong(here, "The LSI has neither 'step' nor 'advance'.");
    c.init = from.init;
    c.step = from.step;
    c.advance = from.advance;
    c.destroy = from.destroy;
    c.store = from.store;
    c.recall = from.recall;
    return c;
  }

  circuit::PinTypeId read_type(std::uint32_t type, const std::string& here, const std::string& pin) {
    if (type >= UGOKI_SCALAR && type <= UGOKI_EVENT) return static_cast<circuit::PinTypeId>(type);
    wrong(here, "The pin '" + pin + "' has the unknown type " + std::to_string(type) + ".");
    return circuit::PinTypeId::scalar;
  }

  /// Checks the properties that pins, parameters and state fields share: name, count of elements, and range.
  void check_pin(const std::string& name, std::uint32_t count, double minimum, double maximum, const std::string& here) {
    if (name.empty() || name.find('.') != std::string::npos || name.size() > 100)
      wrong(here, "'" + name + "' is not a valid name of a pin, parameter or field: it needs 1 to 100 characters, none of them '.'.");
    if (count > max_elements)
      wrong(here, "The pin '" + name + "' has " + std::to_string(count) + " elements; the limit is " + std::to_string(max_elements) + ".");
    if (!(minimum <= maximum)) wrong(here, "The minimum of '" + name + "' is above its maximum.");
  }

  circuit::InputPin read_input(const ugoki_input& from, const std::string& here) {
    circuit::InputPin pin;
    pin.name = text_of(from.name);
    pin.type = read_type(from.type, here, pin.name);
    pin.unit = text_of(from.unit);
    pin.doc = text_of(from.doc);
    pin.required = (from.flags & UGOKI_OPTIONAL) == 0;
    pin.direct = (from.flags & UGOKI_LATE) == 0;
    pin.multiple = (from.flags & UGOKI_MULTIPLE) != 0;
    pin.count = from.count;
    pin.value = from.value;
    pin.minimum = from.minimum;
    pin.maximum = from.maximum;
    check_pin(pin.name, pin.count, pin.minimum, pin.maximum, here);
    if (!std::isfinite(pin.value)) wrong(here, "The default value of the input '" + pin.name + "' is not finite.");
    return pin;
  }

  circuit::OutputPin read_output(const ugoki_output& from, const std::string& here, const ugoki_class& owner) {
    circuit::OutputPin pin;
    pin.name = text_of(from.name);
    pin.type = read_type(from.type, here, pin.name);
    pin.unit = text_of(from.unit);
    pin.doc = text_of(from.doc);
    pin.delayed = (from.flags & UGOKI_DELAYED) != 0;
    pin.count = from.count;
    pin.minimum = from.minimum;
    pin.maximum = from.maximum;
    check_pin(pin.name, pin.count, pin.minimum, pin.maximum, here);
    if (pin.delayed && !owner.advance) wrong(here, "The output '" + pin.name + "' is delayed, but the LSI has no 'advance' to write it.");
    if (from.like > owner.input_count)
      wrong(here, "The output '" + pin.name + "' refers to input " + std::to_string(from.like) + " by 'like', but the LSI has " +
                      std::to_string(owner.input_count) + " inputs.");
    else
      pin.like = static_cast<int>(from.like) - 1;
    if (pin.count == 0 && pin.like < 0 && pin_type(pin.type).default_count == 0)
      wrong(here, "The number of elements of the output '" + pin.name + "' is unknown: set 'count' or 'like'.");
    return pin;
  }

  circuit::Parameter read_parameter(const ugoki_parameter& from, const std::string& here) {
    circuit::Parameter p;
    p.name = text_of(from.name);
    p.unit = text_of(from.unit);
    p.doc = text_of(from.doc);
    p.live = (from.flags & UGOKI_FIXED) == 0;
    const bool open = from.minimum == from.maximum;
    p.minimum = open ? -1e300 : from.minimum;
    p.maximum = open ? 1e300 : from.maximum;
    check_pin(p.name, 0, p.minimum, p.maximum, here);
    const double first = from.initial[0];
    const auto in_range = [&](double x) { return std::isfinite(x) && x >= p.minimum && x <= p.maximum; };
    bool good = true;
    switch (from.kind) {
      case UGOKI_NUMBER:
      case UGOKI_INTEGER:
        p.kind = from.kind == UGOKI_NUMBER ? circuit::ParameterKind::number : circuit::ParameterKind::integer;
        p.initial = first;
        good = in_range(first) && (from.kind == UGOKI_NUMBER || std::floor(first) == first);
        break;
      case UGOKI_BOOLEAN:
        p.kind = circuit::ParameterKind::boolean;
        p.initial = first != 0;
        break;
      case UGOKI_TEXT:
        p.kind = circuit::ParameterKind::text;
        p.initial = text_of(from.text);
        p.live = false;
        break;
      case UGOKI_CHOICE:
        p.kind = circuit::ParameterKind::choice;
        good = from.choices && from.choice_count > 0 && from.choice_count <= max_entries;
        for (std::uint32_t i = 0; good && i < from.choice_count; ++i) p.choices.push_back(text_of(from.choices[i]));
        good = good && first >= 0 && first < static_cast<double>(from.choice_count);
        if (good) p.initial = p.choices[static_cast<std::size_t>(first)];
        break;
      case UGOKI_VECTOR3:
        p.kind = circuit::ParameterKind::vector;
        p.initial = std::vector<double>(from.initial, from.initial + 3);
        good = std::all_of(from.initial, from.initial + 3, in_range);
        break;
      default: good = false;
    }
    if (!good) wrong(here, "The parameter '" + p.name + "' has an unknown kind, no choices, or an initial value out of its range.");
    return p;
  }

  circuit::StateField read_field(const ugoki_field& from, const std::string& here, std::size_t state_bytes) {
    circuit::StateField f;
    f.name = text_of(from.name);
    f.unit = text_of(from.unit);
    f.doc = text_of(from.doc);
    f.offset = from.offset;
    f.count = from.count ? from.count : 1;
    f.initial = from.initial;
    check_pin(f.name, 0, 0, 0, here);
    if (from.type < UGOKI_F64 || from.type > UGOKI_U8) {
      wrong(here, "The field '" + f.name + "' of the state has the unknown type " + std::to_string(from.type) + ".");
      return f;
    }
    f.type = static_cast<circuit::FieldType>(from.type);
    if (f.offset + std::uint64_t{f.count} * bytes_of(f.type) > state_bytes)
      wrong(here, "The field '" + f.name + "' is outside of the state, which has " + std::to_string(state_bytes) + " bytes.");
    return f;
  }

  template <class Items>
  void check_names(const Items& items, const std::string& here, const char* what) {
    for (std::size_t i = 0; i < items.size(); ++i)
      for (std::size_t k = 0; k < i; ++k)
        if (items[i].name == items[k].name) wrong(here, "Two " + std::string(what) + " are called '" + items[i].name + "'.");
  }

  std::string location_;
  Error& problems_;
};

}  // namespace

Declared read_declarations(const ugoki_library* library, const std::string& location, Error& problems) {
  return Reader(location, problems).read(library);
}

}  // namespace ugoki::plugin
