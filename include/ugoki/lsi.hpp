// Software LSIs from C++ structs: one declaration next to the struct makes it an LSI of a library. C++17, header only.
// The guide is docs/lsi.md; the binary interface behind this header is ugoki/lsi.h.
//
//   #include <ugoki/lsi.hpp>
//
//   struct Spring {
//     double x = 0, stiffness = 100, force = 0, peak = 0;
//     void step(const ugoki::Tick&) {
//       force = -stiffness * x;
//       if (force > peak) peak = force;
//     }
//   };
//   UGOKI_LSI(Spring, "spring", "Pulls back.",
//             ugoki::in(&Spring::x, "x", "m", "How far it is stretched.", {-1, 1}),
//             ugoki::parameter(&Spring::stiffness, "stiffness", "N/m", "Force for each metre.", {0, 1e6}),
//             ugoki::out(&Spring::force, "force", "N", "The force."),
//             ugoki::state(&Spring::peak, "peak", "N", "Maximum force so far."))
//   UGOKI_LIBRARY("springs", "1.0", "Springs of several kinds.")
//
// The struct is the state of the LSI: trivially copyable data, without pointers to memory, strings or containers, because the host saves
// and restores its bytes. Declared members are of type double, float, int, bool or std::array<double, N>; an array of 3 is a vector, of 4 a
// rotation (unit quaternion w, x, y, z), of 7 a pose, and of any other size joint values. A parameter is a single value, not an array.
//
// In each tick the inputs and parameters are copied into the members, then `step` is called, then the outputs are copied from the members.
// `step` takes no argument or a const ugoki::Tick&. It returns nothing, a bool or a const char*. To stop the circuit, return false, return
// a sentence with the reason, or throw an exception; a null pointer means success.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <exception>
#include <initializer_list>
#include <new>
#include <type_traits>
#include <utility>
#include <vector>

#include "ugoki/lsi.h"

namespace ugoki {

using Tick = ugoki_tick;

/// Range of values. Equal bounds mean: no range.
struct Range {
  double minimum = 0, maximum = 0;
};

namespace lsi_detail {

/// Use of a declared member: pin, parameter or field of the state.
enum class Role { in, out, delayed_out, parameter, state };
/// C++ type of the numbers of a member.
enum class Number { f64, f32, i32, boolean };

/// Type and count of the numbers of a member of type T. Only the five types below compile.
template <class T>
struct Shape;
template <>
struct Shape<double> {
  static constexpr Number number = Number::f64;
  static constexpr std::uint32_t count = 1;
};
template <>
struct Shape<float> {
  static constexpr Number number = Number::f32;
  static constexpr std::uint32_t count = 1;
};
template <>
struct Shape<int> {
  static constexpr Number number = Number::i32;
  static constexpr std::uint32_t count = 1;
};
template <>
struct Shape<bool> {
  static constexpr Number number = Number::boolean;
  static constexpr std::uint32_t count = 1;
};
template <std::size_t N>
struct Shape<std::array<double, N>> {
  static constexpr Number number = Number::f64;
  static constexpr std::uint32_t count = N;
};

/// A declared member of the struct S. `offset` is in bytes from the start of S.
template <class S>
struct Member {
  Role role;
  Number number;
  std::uint32_t count;
  std::size_t offset;
  const char *name, *unit, *doc;
  Range range;
};

/// Describes the member `where`. Its offset is measured on a default-constructed S.
template <class S, class T>
Member<S> member(Role role, T S::* where, const char* name, const char* unit, const char* doc, Range range) {
  static const S sample{};
  const auto offset = reinterpret_cast<const char*>(&(sample.*where)) - reinterpret_cast<const char*>(&sample);
  return {role, Shape<T>::number, Shape<T>::count, static_cast<std::size_t>(offset), name, unit, doc, range};
}

/// The number at an address, as a double; true is 1.
inline double read(const char* at, Number number) {
  switch (number) {
    case Number::f64: return *reinterpret_cast<const double*>(at);
    case Number::f32: return static_cast<double>(*reinterpret_cast<const float*>(at));
    case Number::i32: return static_cast<double>(*reinterpret_cast<const int*>(at));
    case Number::boolean: return *reinterpret_cast<const bool*>(at) ? 1.0 : 0.0;
  }
  return 0;
}
/// Writes x at an address. Integers are rounded to the nearest one; values above 0 are true.
inline void write(char* at, Number number, double x) {
  switch (number) {
    case Number::f64: *reinterpret_cast<double*>(at) = x; break;
    case Number::f32: *reinterpret_cast<float*>(at) = static_cast<float>(x); break;
    case Number::i32: *reinterpret_cast<int*>(at) = static_cast<int>(x < 0 ? x - 0.5 : x + 0.5); break;
    case Number::boolean: *reinterpret_cast<bool*>(at) = x > 0; break;
  }
}
/// Pin type (enum ugoki_type) of a member with `count` numbers.
inline std::uint32_t type_of(std::uint32_t count) {
  return count == 1 ? UGOKI_SCALAR : count == 3 ? UGOKI_VECTOR : count == 4 ? UGOKI_ROTATION : count == 7 ? UGOKI_POSE : UGOKI_JOINT_VALUES;
}

/// Location of the numbers of a pin or parameter in the struct: `count` numbers at `offset` bytes.
struct Wire {
  Number number;
  std::uint32_t count;
  std::size_t offset;
  [[nodiscard]] std::size_t bytes() const {
    return number == Number::f32 ? 4 : number == Number::i32 ? 4 : number == Number::boolean ? 1 : 8;
  }
};

/// The constant tables that describe the struct S to the host (ugoki/lsi.h), and the functions that the host calls. One static object for
/// each S; it exists as long as the library is loaded.
template <class S>
struct Tables {
  static_assert(std::is_trivially_copyable_v<S>,
                "The struct of an LSI must be trivially copyable: plain data without pointers to memory, strings or containers.");
  std::vector<ugoki_input> inputs;
  std::vector<ugoki_output> outputs;
  std::vector<ugoki_parameter> parameters;
  std::vector<ugoki_field> fields;
  std::vector<Wire> in, out, constants;
  ugoki_class described{};

  static Tables& get() {
    static Tables tables;
    return tables;
  }

  /// ugoki_class::init: constructs S in the state.
  static std::int32_t init(const ugoki_call* call) {
    new (call->state) S{};
    return 0;
  }

  /// ugoki_class::step or advance: copies inputs and parameters in, calls S::step, copies outputs out.
  static std::int32_t run(const ugoki_call* call) {
    const Tables& t = get();
    auto* bytes = static_cast<char*>(call->state);
    auto& lsi = *static_cast<S*>(call->state);
    for (std::size_t i = 0; i < t.in.size(); ++i) move(t.in[i], bytes, const_cast<double*>(static_cast<const double*>(call->in[i])), false);
    for (std::size_t i = 0; i < t.constants.size(); ++i) write(bytes + t.constants[i].offset, t.constants[i].number, call->parameters[i]);
    const char* why = nullptr;
    try {
      why = step(lsi, *call->tick);
    } catch (const std::exception& e) {
      return ugoki_stop(call, e.what());
    } catch (...) {
      return ugoki_stop(call, "The step threw an exception that is not a std::exception.");
    }
    if (why) return ugoki_stop(call, why);
    for (std::size_t i = 0; i < t.out.size(); ++i) move(t.out[i], bytes, static_cast<double*>(call->out[i]), true);
    return 0;
  }

 private:
  /// Copies the numbers of one pin from `payload` to `state`, or from `state` to `payload` if `outwards`.
  static void move(const Wire& w, char* state, double* payload, bool outwards) {
    for (std::uint32_t k = 0; k < w.count; ++k) {
      char* at = state + w.offset + k * w.bytes();
      if (outwards)
        payload[k] = read(at, w.number);
      else
        write(at, w.number, payload[k]);
    }
  }
  /// S::step with the tick if it takes one (the argument 0 prefers this overload), otherwise without.
  template <class T>
  static auto call_step(T& lsi, const Tick& tick, int) -> decltype(lsi.step(tick)) {
    return lsi.step(tick);
  }
  template <class T>
  static auto call_step(T& lsi, const Tick&, long) -> decltype(lsi.step()) {
    return lsi.step();
  }
  /// @return null on success, otherwise the reason to stop
  static const char* step(S& lsi, const Tick& tick) {
    using R = decltype(call_step(lsi, tick, 0));
    if constexpr (std::is_same_v<R, bool>) {
      return call_step(lsi, tick, 0) ? nullptr : "The step returned false.";
    } else if constexpr (std::is_convertible_v<R, const char*>) {
      return call_step(lsi, tick, 0);
    } else {
      call_step(lsi, tick, 0);
      return nullptr;
    }
  }
};

/// The LSIs declared so far in this library, in the order of declaration.
inline std::deque<const ugoki_class*>& classes() {
  static std::deque<const ugoki_class*> all;
  return all;
}

/// Fills the tables of S and adds it to classes(). If one output is delayed, all are, and all inputs are late. @return true
template <class S>
bool declare(const char* name, const char* doc, std::initializer_list<Member<S>> members) {
  Tables<S>& t = Tables<S>::get();
  static const S first{};
  const auto* bytes = reinterpret_cast<const char*>(&first);
  bool delayed = false;
  for (const Member<S>& m : members) delayed = delayed || m.role == Role::delayed_out;
  for (const Member<S>& m : members) {
    const Wire wire{m.number, m.count, m.offset};
    const double value = read(bytes + m.offset, m.number);
    const std::uint32_t type = type_of(m.count), count = type == UGOKI_JOINT_VALUES ? m.count : 0;
    switch (m.role) {
      case Role::in:
        t.inputs.push_back({sizeof(ugoki_input), type,
                            (m.count == 1 ? std::uint32_t{UGOKI_OPTIONAL} : 0u) | (delayed ? std::uint32_t{UGOKI_LATE} : 0u), count, m.name,
                            m.unit, m.doc, value, m.range.minimum, m.range.maximum});
        t.in.push_back(wire);
        break;
      case Role::out:
      case Role::delayed_out:
        t.outputs.push_back({sizeof(ugoki_output), type, delayed ? std::uint32_t{UGOKI_DELAYED} : 0u, count, m.name, m.unit, m.doc,
                             m.range.minimum, m.range.maximum, 0, 0});
        t.out.push_back(wire);
        break;
      case Role::parameter: {
        const std::uint32_t kind = m.number == Number::boolean ? UGOKI_BOOLEAN : m.number == Number::i32 ? UGOKI_INTEGER : UGOKI_NUMBER;
        t.parameters.push_back({sizeof(ugoki_parameter),
                                kind,
                                0,
                                0,
                                m.name,
                                m.unit,
                                m.doc,
                                {value, 0, 0},
                                m.range.minimum,
                                m.range.maximum,
                                nullptr,
                                nullptr});
        t.constants.push_back(wire);
        break;
      }
      case Role::state: {
        const std::uint32_t field = m.number == Number::f64   ? UGOKI_F64
                                    : m.number == Number::f32 ? UGOKI_F32
                                    : m.number == Number::i32 ? UGOKI_I32
                                                              : UGOKI_U8;
        t.fields.push_back({sizeof(ugoki_field), field, static_cast<std::uint32_t>(m.offset), m.count, m.name, m.unit, m.doc, value});
        break;
      }
    }
  }
  ugoki_class& c = t.described;
  c.size = sizeof c;
  c.version = 1;
  c.name = name;
  c.doc = doc;
  c.inputs = t.inputs.data();
  c.outputs = t.outputs.data();
  c.parameters = t.parameters.data();
  c.fields = t.fields.data();
  c.input_count = static_cast<std::uint32_t>(t.inputs.size());
  c.output_count = static_cast<std::uint32_t>(t.outputs.size());
  c.parameter_count = static_cast<std::uint32_t>(t.parameters.size());
  c.field_count = static_cast<std::uint32_t>(t.fields.size());
  c.state_size = sizeof(S);
  c.init = Tables<S>::init;
  (delayed ? c.advance : c.step) = Tables<S>::run;
  classes().push_back(&c);
  return true;
}

}  // namespace lsi_detail

/// An input pin for the member `where`. A single number needs no wire: without one it keeps the initial value of the member. Arrays need a
/// wire. @param range intended values; a value set in place of a wire must be inside it
template <class S, class T>
lsi_detail::Member<S> in(T S::* where, const char* name, const char* unit = "", const char* doc = "", Range range = {}) {
  return lsi_detail::member(lsi_detail::Role::in, where, name, unit, doc, range);
}
/// An output pin for the member `where`. Its consumers see the value in the same tick. @param range usual values, for plots
template <class S, class T>
lsi_detail::Member<S> out(T S::* where, const char* name, const char* unit = "", const char* doc = "", Range range = {}) {
  return lsi_detail::member(lsi_detail::Role::out, where, name, unit, doc, range);
}
/// An output pin whose consumers see the value from the next tick on, so that a feedback loop may pass through this LSI. One delayed output
/// makes all outputs of the LSI delayed.
template <class S, class T>
lsi_detail::Member<S> delayed_out(T S::* where, const char* name, const char* unit = "", const char* doc = "", Range range = {}) {
  return lsi_detail::member(lsi_detail::Role::delayed_out, where, name, unit, doc, range);
}
/// A parameter: a single number or bool that the user sets in the inspector and that is saved with the circuit. Its default is the initial
/// value of the member. @param range allowed values
template <class S, class T>
lsi_detail::Member<S> parameter(T S::* where, const char* name, const char* unit = "", const char* doc = "", Range range = {}) {
  return lsi_detail::member(lsi_detail::Role::parameter, where, name, unit, doc, range);
}
/// A field of the state that the host shows to the user. It keeps its value, by name, when the library is rebuilt while a circuit runs.
template <class S, class T>
lsi_detail::Member<S> state(T S::* where, const char* name, const char* unit = "", const char* doc = "") {
  return lsi_detail::member(lsi_detail::Role::state, where, name, unit, doc, {});
}

}  // namespace ugoki

/// Makes `Struct` an LSI. The other arguments are the name and description of the LSI and its members: in, out, delayed_out, parameter,
/// state. Write it once for each struct, in the namespace of the struct.
#define UGOKI_LSI(Struct, name, doc, ...)                  \
  UGOKI_MANIFEST(ugoki_lsi_manifest_##Struct, "lsi " name) \
  static const bool ugoki_lsi_##Struct = ugoki::lsi_detail::declare<Struct>(name, doc, {__VA_ARGS__});

/// Exports the library. Write it once, at the end of the file, outside of any namespace.
#define UGOKI_LIBRARY(library_name, library_version, library_doc)                                                               \
  UGOKI_MANIFEST(ugoki_lsi_manifest, "library " library_name)                                                                   \
  extern "C" UGOKI_EXPORT const ugoki_library* ugoki_lsi_library(void) {                                                        \
    static const std::vector<const ugoki_class*> all(ugoki::lsi_detail::classes().begin(), ugoki::lsi_detail::classes().end()); \
    static const ugoki_library library = {sizeof(ugoki_library),                                                                \
                                          UGOKI_LSI_ABI,                                                                        \
                                          library_name,                                                                         \
                                          library_version,                                                                      \
                                          library_doc,                                                                          \
                                          all.data(),                                                                           \
                                          static_cast<std::uint32_t>(all.size()),                                               \
                                          0};                                                                                   \
    return &library;                                                                                                            \
  }
