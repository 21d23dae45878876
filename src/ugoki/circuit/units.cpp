#include "ugoki/circuit/units.h"

#include <algorithm>
#include <charconv>

#include "ugoki/circuit/flatten.h"

namespace ugoki::circuit {
namespace {

struct KnownUnit {
  std::string_view name;
  Dimension dimension;  // exponents of m, kg, s, A, K, mol, cd
};

constexpr KnownUnit known_units[] = {
    {"1", {}},
    {"%", {}},
    {"rad", {}},
    {"deg", {}},
    {"degree", {}},
    {"degrees", {}},
    {"°", {}},
    {"sr", {}},
    {"m", {1}},
    {"kg", {0, 1}},
    {"g", {0, 1}},
    {"t", {0, 1}},
    {"s", {0, 0, 1}},
    {"min", {0, 0, 1}},
    {"h", {0, 0, 1}},
    {"d", {0, 0, 1}},
    {"A", {0, 0, 0, 1}},
    {"K", {0, 0, 0, 0, 1}},
    {"degC", {0, 0, 0, 0, 1}},
    {"°C", {0, 0, 0, 0, 1}},
    {"mol", {0, 0, 0, 0, 0, 1}},
    {"cd", {0, 0, 0, 0, 0, 0, 1}},
    {"Hz", {0, 0, -1}},
    {"rpm", {0, 0, -1}},
    {"N", {1, 1, -2}},
    {"Nm", {2, 1, -2}},
    {"Pa", {-1, 1, -2}},
    {"bar", {-1, 1, -2}},
    {"J", {2, 1, -2}},
    {"Wh", {2, 1, -2}},
    {"W", {2, 1, -3}},
    {"C", {0, 0, 1, 1}},
    {"V", {2, 1, -3, -1}},
    {"Ohm", {2, 1, -3, -2}},
    {"F", {-2, -1, 4, 2}},
    {"S", {-2, -1, 3, 2}},
    {"Wb", {2, 1, -2, -1}},
    {"T", {0, 1, -2, -1}},
    {"H", {2, 1, -2, -2}},
    {"L", {3}},
    {"l", {3}},
};
constexpr std::string_view prefixes[] = {"da", "T", "G", "M", "k", "h", "d", "c", "m", "u", "µ", "n", "p"};

std::string_view trim(std::string_view text) {
  while (text.starts_with(' ')) text.remove_prefix(1);
  while (text.ends_with(' ')) text.remove_suffix(1);
  return text;
}

std::optional<Dimension> find_unit(std::string_view name) {
  const auto whole = std::ranges::find(known_units, name, &KnownUnit::name);
  if (whole != std::end(known_units)) return whole->dimension;
  for (const std::string_view p : prefixes) {
    if (!name.starts_with(p)) continue;
    const auto rest = std::ranges::find(known_units, name.substr(p.size()), &KnownUnit::name);
    if (rest != std::end(known_units)) return rest->dimension;
  }
  return std::nullopt;
}

/// Reads one alternative: factors with exponents, separated by ' ', '*', '.', '·' and '/'. Parentheses may follow '/'.
class UnitReader {
 public:
  explicit UnitReader(std::string_view text) : rest_(text) {}

  std::optional<Dimension> read() {
    const std::optional<Dimension> out = product(0);
    return out && rest_.empty() ? out : std::nullopt;
  }

 private:
  static constexpr int max_depth = 8;      // maximum nesting of parentheses
  static constexpr int max_exponent = 99;  // maximum exponent of one factor

  bool take(std::string_view token) {
    if (!rest_.starts_with(token)) return false;
    rest_.remove_prefix(token.size());
    return true;
  }
  void skip_spaces() {
    while (take(" ")) {
    }
  }

  /// True if the text begins with a character of a unit's name, or with a later byte of such a UTF-8 character.
  static bool is_letter(std::string_view text) {
    const char c = text[0];
    if (static_cast<unsigned char>(c) >= 0x80) return !text.starts_with("·") && !text.starts_with("²") && !text.starts_with("³");
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '%';
  }

  std::optional<Dimension> product(int depth) {
    Dimension out{};
    int sign = 1;
    while (true) {
      skip_spaces();
      const std::optional<Dimension> next = factor(depth);
      if (!next) return std::nullopt;
      for (std::size_t i = 0; i < out.size(); ++i) out[i] += sign * (*next)[i];
      skip_spaces();
      if (rest_.empty() || rest_.starts_with(')')) return out;
      sign = take("/") ? -1 : 1;
      if (sign > 0 && !take("*") && !take("·")) (void)take(".");
    }
  }

  std::optional<Dimension> factor(int depth) {
    std::optional<Dimension> out;
    if (take("(")) {
      if (depth < max_depth) out = product(depth + 1);
      if (!out || !take(")")) return std::nullopt;
    } else {
      std::size_t n = rest_.starts_with('1') ? 1 : 0;
      while (n < rest_.size() && rest_[0] != '1' && is_letter(rest_.substr(n))) ++n;
      out = find_unit(rest_.substr(0, n));
      if (!out) return std::nullopt;
      rest_.remove_prefix(n);
    }
    const std::optional<int> power = exponent();
    if (!power) return std::nullopt;
    for (int& e : *out) e *= *power;
    return out;
  }

  /// Reads an exponent: "^2", "^-1", "²", or the 2 of "m2". Returns 1 if there is none.
  std::optional<int> exponent() {
    if (take("²")) return 2;
    if (take("³")) return 3;
    const bool written = take("^");
    const bool digits = !rest_.empty() && ((rest_[0] >= '0' && rest_[0] <= '9') || rest_[0] == '-');
    if (!digits) return written ? std::nullopt : std::optional(1);
    int x = 0;
    const auto end = std::from_chars(rest_.data(), rest_.data() + rest_.size(), x);
    if (end.ec != std::errc{} || x < -max_exponent || x > max_exponent) return std::nullopt;
    rest_.remove_prefix(static_cast<std::size_t>(end.ptr - rest_.data()));
    return x;
  }

  std::string_view rest_;
};

bool is_dimensionless(const std::vector<Dimension>& all) {
  return std::ranges::all_of(all, [](const Dimension& d) { return d == Dimension{}; });
}

}  // namespace

std::optional<std::vector<Dimension>> read_dimensions(std::string_view unit) {
  std::vector<Dimension> out;
  while (true) {
    const std::size_t end = std::min(unit.find_first_of("|,"), unit.size());
    const std::string_view text = trim(unit.substr(0, end));
    const std::optional<Dimension> one = text.empty() ? std::nullopt : UnitReader(text).read();
    if (!one) return std::nullopt;
    out.push_back(*one);
    if (end == unit.size()) return out;
    unit.remove_prefix(end + 1);
  }
}

bool fit(std::string_view from, std::string_view to) {
  if (from == to) return true;
  const auto a = read_dimensions(from), b = read_dimensions(to);
  if (!a || !b || is_dimensionless(*a) || is_dimensionless(*b)) return true;
  return std::ranges::find_first_of(*a, *b) != a->end();
}

std::vector<Problem> check_units(const Circuit& circuit, const Library& library) {
  Error errors;
  const FlatCircuit flat = flatten(circuit, library, errors);
  std::vector<Problem> out;
  if (!errors.empty()) return out;
  // Inputs of the circuit are placeholder LSIs, whose pins have no unit: the circuit declares the unit.
  std::vector<const BoundaryPin*> ports(flat.lsis.size(), nullptr);
  for (const FlatPort& port : flat.inputs)
    for (const BoundaryPin& pin : circuit.inputs)
      if (pin.name == port.name) ports[static_cast<std::size_t>(port.source.lsi)] = &pin;
  const auto warn = [&](const std::string& location, const std::string& from, std::string_view from_unit, const std::string& to,
                        std::string_view to_unit) {
    out.push_back({ErrorCode::structure, location,
                   "'" + from + "' is in " + std::string(from_unit) + ", but '" + to + "' is in " + std::string(to_unit) + ".",
                   "Wire an output of the same quantity, or correct the unit."});
  };
  for (const FlatLsi& lsi : flat.lsis)
    for (std::size_t i = 0; i < lsi.inputs.size(); ++i)
      for (const Source& s : lsi.inputs[i].sources) {
        const FlatLsi& from = flat.lsis[static_cast<std::size_t>(s.lsi)];
        const OutputPin& output = from.lsi_class->outputs[static_cast<std::size_t>(s.pin)];
        const InputPin& input = lsi.lsi_class->inputs[i];
        const BoundaryPin* port = ports[static_cast<std::size_t>(s.lsi)];
        const std::string& unit = port ? port->unit : output.unit;
        if (!fit(unit, input.unit))
          warn(lsi.location, port ? port->name : from.id + "." + output.name, unit, lsi.id + "." + input.name, input.unit);
      }
  for (std::size_t i = 0; i < flat.outputs.size(); ++i) {
    const FlatPort& port = flat.outputs[i];
    if (port.source.lsi < 0) continue;
    const FlatLsi& from = flat.lsis[static_cast<std::size_t>(port.source.lsi)];
    const OutputPin& output = from.lsi_class->outputs[static_cast<std::size_t>(port.source.pin)];
    for (const BoundaryPin& pin : circuit.outputs)
      if (pin.name == port.name && !fit(output.unit, pin.unit))
        warn("circuit/outputs/" + std::to_string(&pin - circuit.outputs.data()), from.id + "." + output.name, output.unit, pin.name,
             pin.unit);
  }
  return out;
}

}  // namespace ugoki::circuit
