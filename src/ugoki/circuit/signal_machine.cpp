// The state machine LSI, and the LSIs of input devices: keyboard, mouse, gamepad and OSC.

#include <cstring>
#include <memory>
#include <vector>

#include "ugoki/base/number.h"
#include "ugoki/circuit/declare.h"
#include "ugoki/circuit/setup.h"
#include "ugoki/circuit/signal_lsis.h"

namespace ugoki::circuit {
namespace {

constexpr std::size_t max_states = 256;

/// The machine changes from state `from` to `to` if the input is above (or below) `level`, and the state has lasted `after` seconds.
struct Transition {
  int from = -1;  ///< index of the state; -1: any state other than `to`
  int to = 0;
  std::size_t input = 0;  ///< index of the input pin
  bool above = true;      ///< true: the input must be above `level`; false: below
  double level = 0;
  double after = 0;  ///< minimum time in state `from`, s
};

/// Reads transitions in the form "idle -> walk when a > 0.5 after 1; any -> idle when d > 0".
class MachineReader {
 public:
  std::vector<Transition> transitions;
  std::vector<std::string> states;
  std::string wrong;  ///< the first transition that could not be read

  bool read(const std::string& text) {
    for (std::size_t at = 0; at <= text.size();) {
      const std::size_t end = std::min(text.find(';', at), text.size());
      words_.clear();
      split(text.substr(at, end - at));
      if (!words_.empty() && !read_transition()) {
        wrong = text.substr(at, end - at);
        return false;
      }
      at = end + 1;
    }
    return !transitions.empty();
  }

 private:
  void split(const std::string& part) {
    std::string word;
    for (const char c : part + " ") {
      if (c != ' ' && c != '\n' && c != '\t') {
        word += c;
      } else if (!word.empty()) {
        words_.push_back(word);
        word.clear();
      }
    }
  }
  int state(const std::string& name) {
    for (std::size_t i = 0; i < states.size(); ++i)
      if (states[i] == name) return static_cast<int>(i);
    states.push_back(name);
    return static_cast<int>(states.size()) - 1;
  }
  bool read_transition() {
    const bool waits = words_.size() == 9 && words_[7] == "after";
    if ((words_.size() != 7 && !waits) || words_[1] != "->" || words_[3] != "when") return false;
    if (words_[4].size() != 1 || words_[4][0] < 'a' || words_[4][0] > 'd' || (words_[5] != ">" && words_[5] != "<")) return false;
    Transition t;
    t.from = words_[0] == "any" ? -1 : state(words_[0]);
    t.to = state(words_[2]);
    t.input = static_cast<std::size_t>(words_[4][0] - 'a');
    t.above = words_[5] == ">";
    const auto level = parse_double(words_[6]), after = waits ? parse_double(words_[8]) : 0.0;
    if (!level || !after || states.size() > max_states) return false;
    t.level = *level;
    t.after = *after;
    transitions.push_back(t);
    return true;
  }
  std::vector<std::string> words_;
};

std::int32_t run_machine(const Call* c) {
  const auto& transitions = *static_cast<const std::vector<Transition>*>(c->object);
  auto* s = static_cast<double*>(c->state);  // s[0]: index of the state; s[1]: time spent in the state, s
  *output(c, 1) = 0;
  for (const Transition& t : transitions) {
    const double x = *input(c, t.input);
    const bool applies = t.from < 0 ? t.to != static_cast<int>(s[0]) : t.from == static_cast<int>(s[0]);
    if (!applies || s[1] < t.after || (t.above ? !(x > t.level) : !(x < t.level))) continue;
    s[0] = t.to;
    s[1] = 0;
    *output(c, 1) = 1;
    break;
  }
  *output(c, 0) = s[0];
  *output(c, 2) = s[1];
  s[1] += c->tick->dt;
  return 0;
}

void add_state_machine(Library& l) {
  LsiClass m =
      lsi("state machine", "State machine: at each tick it makes at most one transition, the first in the list whose condition is met.",
          {optional("a"), optional("b"), optional("c"), optional("d")},
          {out("state", PinTypeId::scalar, "Index of the state, in the order in which `transitions` names them: 0, 1, ..."),
           out("changed", PinTypeId::scalar, "1 in the tick of a transition, otherwise 0."),
           out("time", PinTypeId::scalar, "Seconds spent in this state.")},
          run_machine);
  Parameter p;
  p.name = "transitions";
  p.kind = ParameterKind::text;
  p.initial = std::string("idle -> go when a > 0; go -> idle when a < 0");
  p.doc =
      "STATE -> STATE when INPUT > NUMBER after SECONDS; ... INPUT is a, b, c or d. The comparison is > or <. `any` means every other "
      "state. \"after SECONDS\" is optional.";
  p.live = false;
  m.parameters = {p};
  m.state_bytes = 2 * sizeof(double);
  m.fields.resize(2);
  m.fields[0].name = "state";
  m.fields[1].name = "time";
  m.fields[1].offset = sizeof(double);
  m.fields[1].unit = "s";
  m.make = [](Setup& s) -> void* {
    MachineReader reader;
    if (reader.read(s.text("transitions"))) return std::make_unique<std::vector<Transition>>(std::move(reader.transitions)).release();
    s.fail(ErrorCode::syntax,
           reader.wrong.empty() ? "A state machine needs at least one transition." : "'" + reader.wrong + "' is not a transition.",
           "Write: idle -> walk when a > 0.5 after 1; walk -> idle when a < 0.2");
    return nullptr;
  };
  m.destroy = [](void* p_) { delete static_cast<std::vector<Transition>*>(p_); };
  l.add(std::move(m));
}

LsiClass device(std::string name, std::string doc, std::vector<OutputPin> outputs) {
  LsiClass c = lsi(name, std::move(doc), {}, std::move(outputs), nullptr);
  c.group = "input";
  c.device = std::move(name);
  return c;
}
Parameter word(std::string name, std::string initial, std::string doc) {
  Parameter p;
  p.name = std::move(name);
  p.kind = ParameterKind::text;
  p.initial = std::move(initial);
  p.doc = std::move(doc);
  p.live = false;
  return p;
}
/// Declares a scalar output with the range of its usual values, for plots.
OutputPin ranged_out(std::string name, std::string doc, double minimum, double maximum) {
  OutputPin pin = out(std::move(name), PinTypeId::scalar, std::move(doc));
  pin.minimum = minimum;
  pin.maximum = maximum;
  return pin;
}

void add_devices(Library& l) {
  LsiClass keyboard = device("keyboard", "A key of the keyboard.", {ranged_out("pressed", "1 while the key is down, otherwise 0.", 0, 1)});
  keyboard.parameters = {word("key", "Space", "Name of the key as the browser's KeyboardEvent.code: Space, KeyW, ArrowUp.")};
  l.add(std::move(keyboard));
  l.add(device("mouse", "Position, buttons and wheel of the mouse in the viewport.",
               {ranged_out("x", "Horizontal position, from 0 (left edge) to 1 (right edge).", 0, 1),
                ranged_out("y", "Vertical position, from 0 (top edge) to 1 (bottom edge).", 0, 1),
                ranged_out("left", "1 while the left button is down, otherwise 0.", 0, 1),
                ranged_out("middle", "1 while the middle button is down, otherwise 0.", 0, 1),
                ranged_out("right", "1 while the right button is down, otherwise 0.", 0, 1),
                ranged_out("wheel", "Notches turned so far, positive towards the user.", 0, 0)}));
  LsiClass gamepad = device("gamepad", "A gamepad in the standard layout.",
                            {ranged_out("left x", "Left stick, from -1 (left) to 1 (right).", -1, 1),
                             ranged_out("left y", "Left stick, from -1 (backwards) to 1 (forwards).", -1, 1),
                             ranged_out("right x", "Right stick, from -1 (left) to 1 (right).", -1, 1),
                             ranged_out("right y", "Right stick, from -1 (backwards) to 1 (forwards).", -1, 1),
                             ranged_out("left trigger", "How far the trigger is pulled, from 0 to 1.", 0, 1),
                             ranged_out("right trigger", "How far the trigger is pulled, from 0 to 1.", 0, 1),
                             ranged_out("south", "1 while the lowest of the four buttons is down, otherwise 0.", 0, 1),
                             ranged_out("east", "1 while the rightmost of the four buttons is down, otherwise 0.", 0, 1),
                             ranged_out("west", "1 while the leftmost of the four buttons is down, otherwise 0.", 0, 1),
                             ranged_out("north", "1 while the uppermost of the four buttons is down, otherwise 0.", 0, 1)});
  gamepad.parameters = {word("pad", "0", "Index of the gamepad: 0 for the first one connected.")};
  l.add(std::move(gamepad));
  LsiClass osc = device("osc", "The last number received at an address by Open Sound Control (OSC) from this computer.",
                        {out("value", PinTypeId::scalar, "First argument of the last message."),
                         out("count", PinTypeId::scalar, "Number of messages received so far.")});
  osc.parameters = {word("address", "/1", "OSC address, for example /fader/1.")};
  l.add(std::move(osc));
}

}  // namespace

void add_machine_lsis(Library& library) {
  add_state_machine(library);
  add_devices(library);
}

}  // namespace ugoki::circuit
