// A state machine, and the LSIs that stand for what a user holds in hand.

#include <cstring>
#include <memory>
#include <vector>

#include "ugoki/base/number.h"
#include "ugoki/circuit/declare.h"
#include "ugoki/circuit/setup.h"
#include "ugoki/circuit/signal_lsis.h"

namespace ugoki::circuit {
namespace {

constexpr std::size_t most_states = 256;

struct Transition {
  int from = -1;  ///< -1: any
  int to = 0;
  std::size_t input = 0;
  bool above = true;
  double level = 0, after = 0;  ///< s in the state before it may go
};

/// Reads "idle -> walk when a > 0.5 after 1; any -> idle when d > 0".
class MachineReader {
 public:
  std::vector<Transition> transitions;
  std::vector<std::string> states;
  std::string wrong;

  bool read(const std::string& text) {
    for (std::size_t at = 0; at <= text.size();) {
      const std::size_t end = std::min(text.find(';', at), text.size());
      words_.clear();
      split(text.substr(at, end - at));
      if (!words_.empty() && !one()) {
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
  bool one() {
    const bool waits = words_.size() == 9 && words_[7] == "after";
    if ((words_.size() != 7 && !waits) || words_[1] != "->" || words_[3] != "when") return false;
    if (words_[4].size() != 1 || words_[4][0] < 'a' || words_[4][0] > 'd' || (words_[5] != ">" && words_[5] != "<")) return false;
    Transition t;
    t.from = words_[0] == "any" ? -1 : state(words_[0]);
    t.to = state(words_[2]);
    t.input = static_cast<std::size_t>(words_[4][0] - 'a');
    t.above = words_[5] == ">";
    const auto level = parse_double(words_[6]), after = waits ? parse_double(words_[8]) : 0.0;
    if (!level || !after || states.size() > most_states) return false;
    t.level = *level;
    t.after = *after;
    transitions.push_back(t);
    return true;
  }
  std::vector<std::string> words_;
};

std::int32_t run_machine(const Call* c) {
  const auto& transitions = *static_cast<const std::vector<Transition>*>(c->object);
  auto* s = static_cast<double*>(c->state);  // state, seconds in it
  *output(c, 1) = 0;
  for (const Transition& t : transitions) {
    const double x = *input(c, t.input);
    const bool here = t.from < 0 ? t.to != static_cast<int>(s[0]) : t.from == static_cast<int>(s[0]);
    if (!here || s[1] < t.after || (t.above ? !(x > t.level) : !(x < t.level))) continue;
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
      lsi("state machine", "One of several states; each tick at most one transition, the first whose condition is met.",
          {optional("a"), optional("b"), optional("c"), optional("d")},
          {out("state", PinTypeId::scalar, "0 for the first state named, then 1, ..."),
           out("changed", PinTypeId::scalar, "1 in the tick of a transition."), out("time", PinTypeId::scalar, "Seconds in this state.")},
          run_machine);
  Parameter p;
  p.name = "transitions";
  p.kind = ParameterKind::text;
  p.initial = std::string("idle -> go when a > 0; go -> idle when a < 0");
  p.doc =
      "STATE -> STATE when INPUT > NUMBER after SECONDS; ... INPUT is a, b, c or d; < as well; `any` for every other state; after may be "
      "left out.";
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
    s.fail(ErrorCode::syntax, reader.wrong.empty() ? "A state machine needs a transition." : "'" + reader.wrong + "' is no transition.",
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
OutputPin shown(std::string name, std::string doc, double minimum, double maximum) {
  OutputPin pin = out(std::move(name), PinTypeId::scalar, std::move(doc));
  pin.minimum = minimum;
  pin.maximum = maximum;
  return pin;
}

void add_devices(Library& l) {
  LsiClass keyboard = device("keyboard", "A key of the keyboard.", {shown("pressed", "1 while it is down.", 0, 1)});
  keyboard.parameters = {word("key", "Space", "Its name in the browser's KeyboardEvent.code: Space, KeyW, ArrowUp.")};
  l.add(std::move(keyboard));
  l.add(device("mouse", "The mouse over the viewport.",
               {shown("x", "From the left (0) to the right (1).", 0, 1), shown("y", "From the top (0) to the bottom (1).", 0, 1),
                shown("left", "1 while the button is down.", 0, 1), shown("middle", "1 while the button is down.", 0, 1),
                shown("right", "1 while the button is down.", 0, 1), shown("wheel", "Notches turned so far.", 0, 0)}));
  LsiClass gamepad =
      device("gamepad", "A gamepad in the standard layout.",
             {shown("left x", "Left stick, to the right.", -1, 1), shown("left y", "Left stick, forwards.", -1, 1),
              shown("right x", "Right stick, to the right.", -1, 1), shown("right y", "Right stick, forwards.", -1, 1),
              shown("left trigger", "How far it is pulled.", 0, 1), shown("right trigger", "How far it is pulled.", 0, 1),
              shown("south", "1 while the lowest button is down.", 0, 1), shown("east", "1 while the right button is down.", 0, 1),
              shown("west", "1 while the left button is down.", 0, 1), shown("north", "1 while the upper button is down.", 0, 1)});
  gamepad.parameters = {word("pad", "0", "Which one: 0 for the first that is there.")};
  l.add(std::move(gamepad));
  LsiClass osc = device("osc", "The newest number that came to an address by Open Sound Control, from this computer.",
                        {out("value", PinTypeId::scalar, "The first argument."), out("count", PinTypeId::scalar, "Messages so far.")});
  osc.parameters = {word("address", "/1", "For example /fader/1.")};
  l.add(std::move(osc));
}

}  // namespace

void add_machine_lsis(Library& library) {
  add_state_machine(library);
  add_devices(library);
}

}  // namespace ugoki::circuit
