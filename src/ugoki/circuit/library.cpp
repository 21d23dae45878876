#include "ugoki/circuit/library.h"

#include <algorithm>
#include <cstring>

#include "ugoki/base/check.h"
#include "ugoki/base/hash.h"

namespace ugoki::circuit {
namespace {

template <class Pins>
int find_by_name(const Pins& pins, std::string_view name) {
  for (std::size_t i = 0; i < pins.size(); ++i)
    if (pins[i].name == name) return static_cast<int>(i);
  return -1;
}

template <class Pins>
void check_names(const Pins& pins) {
  for (std::size_t i = 0; i < pins.size(); ++i) {
    UGOKI_CHECK(!pins[i].name.empty());
    UGOKI_CHECK(pins[i].name.find('.') == std::string::npos);
    UGOKI_CHECK(find_by_name(pins, pins[i].name) == static_cast<int>(i));
  }
}

}  // namespace

std::int32_t stop(const Call* call, std::string_view reason) {
  if (call->reason_size > 0) {
    const std::size_t n = std::min<std::size_t>(reason.size(), call->reason_size - 1);
    std::memcpy(call->reason, reason.data(), n);
    call->reason[n] = '\0';
  }
  return 1;
}

int LsiClass::find_input(std::string_view pin) const { return find_by_name(inputs, pin); }
int LsiClass::find_output(std::string_view pin) const { return find_by_name(outputs, pin); }
int LsiClass::find_parameter(std::string_view parameter) const { return find_by_name(parameters, parameter); }

std::size_t bytes_of(FieldType type) {
  switch (type) {
    case FieldType::f64:
    case FieldType::i64:
    case FieldType::u64: return 8;
    case FieldType::f32:
    case FieldType::i32:
    case FieldType::u32: return 4;
    case FieldType::i8:
    case FieldType::u8: return 1;
  }
  return 0;
}

std::uint64_t LsiClass::state_layout() const {
  Hash64 hash;
  hash.add(std::uint64_t{version});
  hash.add(std::uint64_t{state_bytes});
  for (const StateField& f : fields) {
    hash.add_bytes(f.name.data(), f.name.size() + 1);
    hash.add(static_cast<std::uint64_t>(f.type));
    hash.add(std::uint64_t{f.offset});
    hash.add(std::uint64_t{f.count});
  }
  return hash.value();
}

void Library::add(LsiClass c) {
  UGOKI_CHECK(!c.name.empty() && !has(c.name));
  check_names(c.inputs);
  check_names(c.outputs);
  check_names(c.parameters);
  bool multiple_seen = false;
  for (const InputPin& pin : c.inputs) {
    UGOKI_CHECK(pin.multiple || !multiple_seen);
    multiple_seen = pin.multiple;
    UGOKI_CHECK(!pin.direct || c.step || c.advance);
  }
  for (const OutputPin& pin : c.outputs) {
    UGOKI_CHECK(!pin.delayed || c.advance);
    UGOKI_CHECK(pin.like < static_cast<int>(c.inputs.size()));
  }
  for (const StateField& f : c.fields) UGOKI_CHECK(f.offset + f.count * bytes_of(f.type) <= c.state_bytes);
  for (const Parameter& p : c.parameters) {
    switch (p.kind) {
      case ParameterKind::number:
      case ParameterKind::integer: UGOKI_CHECK(std::holds_alternative<double>(p.initial)); break;
      case ParameterKind::boolean: UGOKI_CHECK(std::holds_alternative<bool>(p.initial)); break;
      case ParameterKind::text: UGOKI_CHECK(std::holds_alternative<std::string>(p.initial)); break;
      case ParameterKind::choice:
        UGOKI_CHECK(std::holds_alternative<std::string>(p.initial));
        UGOKI_CHECK(std::find(p.choices.begin(), p.choices.end(), std::get<std::string>(p.initial)) != p.choices.end());
        break;
      case ParameterKind::vector:
        UGOKI_CHECK(std::holds_alternative<std::vector<double>>(p.initial) && std::get<std::vector<double>>(p.initial).size() == 3);
        break;
    }
  }
  const auto at =
      std::lower_bound(classes_.begin(), classes_.end(), c.name, [](const LsiClass& a, const std::string& name) { return a.name < name; });
  classes_.insert(at, std::move(c));
}

const LsiClass* Library::find_exactly(std::string_view name) const {
  const auto at =
      std::lower_bound(classes_.begin(), classes_.end(), name, [](const LsiClass& a, std::string_view n) { return a.name < n; });
  return at != classes_.end() && at->name == name ? &*at : nullptr;
}

const std::string* Library::find_refusal(std::string_view name) const {
  const auto found = refused_.find(name);
  return found == refused_.end() ? nullptr : &found->second;
}

bool Library::has(std::string_view name) const { return find_exactly(name) != nullptr; }

const LsiClass* Library::find(std::string_view name) const {
  const LsiClass* found = find_exactly(name);
  if (found || name.find('/') != std::string_view::npos) return found;
  for (const LsiClass& c : classes_) {
    if (c.from.empty() || c.name.size() != c.from.size() + 1 + name.size() || !c.name.ends_with(name)) continue;
    if (found) return nullptr;  // two libraries have a class of this name: the circuit must write "library/name"
    found = &c;
  }
  return found;
}

}  // namespace ugoki::circuit
