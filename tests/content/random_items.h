#pragma once
// Random commands that set the less common fields of a scenario: of each type of event, condition and action, of looks, gaits, cameras and
// circuits.

#include <string>

#include "random_values.h"
#include "ugoki/content/scenario.h"

namespace ugoki::content::testing {

class RandomItems : public RandomValues {
 public:
  using RandomValues::RandomValues;

 protected:
  static constexpr std::size_t item_kinds = 13;

  /// A random command of one of the `item_kinds`; empty: the document has no item for it.
  std::string item_command(const Scenario& s) {
    switch (pick(item_kinds)) {
      case 0: return R"({"type": "event.add", "event": )" + event(s) + "}";
      case 1: return change_of("event", s.events, [&](const ScenarioEvent& e) { return event_fields(s, e.type); });
      case 2: return R"({"type": "rule.add", "rule": )" + rule(s) + R"(, "at": )" + std::to_string(pick(3)) + "}";
      case 3: return change_of("rule", s.rules, [&](const Rule&) { return rule(s); });
      case 4: return R"({"type": "character.set", "id": )" + character(s) + ", " + character_field() + "}";
      case 5: return clip_field(s);
      case 6: return R"({"type": "scenario.set", )" + setting(s) + "}";
      case 7: return R"({"type": "circuit.edit", "changes": [)" + circuit_change() + (pick(3) ? "]}" : ", " + circuit_change() + "]}");
      case 8: return change_of("camera", s.cameras, [&](const FilmCamera&) { return camera_fields(); });
      case 9: return change_of("shot", s.shots, [&](const FilmShot&) { return shot_fields(s); });
      case 10:
        return change_of("variable", s.variables, [&](const ScenarioVariable&) {
          return R"({"kind": )" + word({"number", "switch"}) + R"(, "initial": )" + std::to_string(pick(2)) + R"(, "minimum": )" +
                 (pick(2) ? "null" : number(-9, 0)) + R"(, "unit": )" + word({"", "%", "points"}) + "}";
        });
      case 11:
        return change_of("pose", s.poses,
                         [&](const ScenarioPose&) { return R"({"joints": [{"link": "leg", "q": [)" + number(-2, 2) + "]}]}"; });
      default:
        if (s.markers.empty()) return {};
        return R"({"type": "marker.set", "id": )" + quoted(any(s.markers).id) + R"(, "name": "M)" + number(0, 9) + "\"}";
    }
  }

  std::string character(const Scenario& s) {
    return s.characters.empty() ? R"("none")" : quoted(pick(2) ? s.characters[0].id : any(s.characters).id);
  }

 protected:
  /// A random command on instances and inner scenarios; empty: the document has none that it could change.
  std::string nest_command(const Scenario& s) {
    if (!s.circuit.empty()) return pick(2) ? R"({"type": "circuit.set", "circuit": null})" : "";  // it keeps nesting from working
    const std::size_t kind = s.scenarios.empty() ? 0 : pick(7);
    if (kind == 0 && s.characters.size() > 1) {
      const std::size_t first = pick(8) ? 1 : 0;  // most commands act on the first character
      std::string ids = quoted(s.characters[first + pick(s.characters.size() - first)].id);
      if (pick(2)) ids += ", " + quoted(s.characters[first + pick(s.characters.size() - first)].id);
      const std::string more = s.instances.empty() || pick(2) ? "" : R"(, "instances": [)" + quoted(any(s.instances).id) + "]";
      return R"({"type": "scenario.nest", "name": )" + word({"Duet", "Trio of 3", "+"}) + R"(, "characters": [)" + ids + "]" + more + "}";
    }
    if (kind == 1 && !s.scenarios.empty() && s.instances.size() < 4)
      return R"({"type": "instance.add", "scenario": )" + quoted(any(s.scenarios).id) + R"(, "start": )" + number(0, 4) +
             R"(, "place": {"y": )" + number(-5, 5) + R"(, "heading": )" + number(-90, 90) + "}}";
    if (kind == 2 && !s.scenarios.empty()) return R"({"type": "scenario.remove", "id": )" + quoted(any(s.scenarios).id) + "}";
    if (s.instances.empty()) return {};
    const std::string id = R"(", "id": )" + quoted(any(s.instances).id);
    if (kind == 3) return R"({"type": "instance.unnest)" + id + "}";
    if (kind == 4 && pick(3) == 0) return R"({"type": "instance.remove)" + id + "}";
    return R"({"type": "instance.set)" + id +
           (pick(2)   ? R"(, "start": )" + number(-0.2, 4) + R"(, "place": {"x": )" + number(-5, 5) + "}}"
            : pick(2) ? R"(, "muted": )" + boolean() + R"(, "solo": )" + boolean() + "}"
                      : R"(, "name": )" + word({"First", "Second"}) + "}");
  }

 private:
  /// The command KIND.set for any item of the list, with the given fields; empty: the list is empty.
  template <class List, class Make>
  std::string change_of(const std::string& kind, const List& list, Make make) {
    if (list.empty()) return {};
    const auto& item = any(list);
    return R"({"type": ")" + kind + R"(.set", "id": )" + quoted(item.id) + ", \"" + kind + "\": " + make(item) + "}";
  }
  std::string optional_id(const Scenario& s) { return pick(2) ? R"("")" : character(s); }
  std::string variable(const Scenario& s) { return s.variables.empty() ? R"("none")" : quoted(any(s.variables).id); }

  std::string event(const Scenario& s) {
    const EventType type = std::array{EventType::throw_, EventType::grab, EventType::release}[pick(3)];
    std::string fields = event_fields(s, type);
    fields.pop_back();
    return fields + R"(, "type": ")" + std::string(name_of(type)) + R"(", "character": )" +
           (type == EventType::throw_ ? R"("ball"})" : R"("human"})");
  }
  std::string event_fields(const Scenario& s, EventType type) {
    const std::string time = R"({"time": )" + number(0, 9);
    switch (type) {
      case EventType::push:
        return time + R"(, "duration": )" + number(0.01, 2) + R"(, "link": )" + word({"leg", "pelvis"}) + R"(, "axes": )" +
               word({"world", "body"}) + R"(, "force": )" + vector(-200, 200) + "}";
      case EventType::pull:
        return time + R"(, "duration": )" + number(0.01, 2) + R"(, "point": )" + vector(-0.1, 0.1) + R"(, "path": [[0, )" + number(0, 2) +
               ", 1, 1]]}";
      case EventType::throw_:
        return time + R"(, "from": )" + vector(0, 3) + R"(, "velocity": )" + vector(-9, 9) + R"(, "spin": )" + vector(-9, 9) + "}";
      case EventType::release: return time + R"(, "link": )" + word({"leg", "pelvis"}) + "}";
      case EventType::grab:
        return time + R"(, "link": )" + word({"leg", "pelvis"}) + R"(, "point": )" + vector(-0.1, 0.1) + R"(, "other": )" + optional_id(s) +
               R"(, "other_link": )" + word({"", "ball", "body"}) + R"(, "at": )" + (pick(2) ? "null" : vector(0, 1)) + R"(, "rigid": )" +
               boolean() + R"(, "limit": )" + number(100, 900) + R"(, "reach": )" + number(0.05, 0.5) + "}";
    }
    return time + "}";
  }

  std::string condition(const Scenario& s) {
    const std::string negated = pick(3) == 0 ? R"(, "not": true})" : "}";
    switch (pick(7)) {
      case 0: return R"({"type": "key", "key": )" + word({"Space", "KeyW", "ArrowUp"}) + negated;
      case 1:
        return R"({"type": "touch", "character": )" + character(s) + R"(, "link": )" + word({"", "leg", "ball"}) + R"(, "other": )" +
               (pick(2) ? R"("ground")" : optional_id(s)) + negated;
      case 2:
        return R"({"type": "near", "character": "human", "link": )" + word({"", "leg"}) + R"(, "other": "ball", "other_link": )" +
               word({"", "ball"}) + R"(, "distance": )" + number(0.1, 3) + negated;
      case 3: return R"({"type": "time", "time": )" + number(0, 9) + negated;
      case 4:
        return R"({"type": "playing", "character": "human", "rule": )" + (s.rules.empty() || pick(2) ? R"("")" : quoted(any(s.rules).id)) +
               negated;
      case 5: return R"({"type": "released", "character": )" + character(s) + negated;
      default:
        return R"({"type": "variable", "variable": )" + variable(s) + R"(, "compare": )" +
               word({"at_least", "at_most", "above", "below", "equal"}) + R"(, "value": )" + number(-5, 5) + negated;
    }
  }
  std::string action(const Scenario& s) {
    switch (pick(5)) {
      case 0:
        return R"({"type": "play", "character": "human", "motion": )" + word({"n-walk", "n-step"}) + R"(, "speed": )" + number(0.5, 2) +
               R"(, "blend": )" + number(0, 1) + R"(, "loop": )" + boolean() + "}";
      case 1:
        return R"({"type": "push", "character": "human", "link": )" + word({"leg", "pelvis"}) + R"(, "force": )" + vector(-99, 99) +
               R"(, "axes": )" + word({"world", "body"}) + R"(, "duration": )" + number(0.01, 1) + "}";
      case 2:
        return R"({"type": "grab", "character": "human", "link": "leg", "other": )" + optional_id(s) + R"(, "other_link": )" +
               word({"", "ball"}) + R"(, "rigid": )" + boolean() + R"(, "limit": )" + number(100, 900) + "}";
      case 3: return R"({"type": "release", "character": "human", "link": )" + word({"leg", "pelvis"}) + "}";
      default:
        return R"({"type": "set", "variable": )" + variable(s) + R"(, "change": )" + word({"set", "add", "toggle"}) + R"(, "value": )" +
               number(-5, 5) + "}";
    }
  }
  std::string rule(const Scenario& s) {
    return R"({"on": )" + boolean() + R"(, "mode": )" + word({"when", "while"}) + R"(, "if": [)" + condition(s) +
           (pick(3) ? "]" : ", " + condition(s) + "]") + R"(, "do": )" + action(s) + "}";
  }

  std::string character_field() {
    switch (pick(10)) {
      case 0: return R"("control": {"mode": )" + word({"track", "passive", "path", "torque"}) + R"(, "swing": )" + number(0, 90) + "}";
      case 1: return R"("control": {"tracking": )" + number(0, 2) + R"(, "assist_limit": )" + number(0, 1) + "}";
      case 2:
        return R"("secondary": )" + (pick(3) ? R"([{"link": )" + word({"leg", "pelvis"}) + R"(, "frequency": )" + number(1, 5) +
                                                   R"(, "damping": )" + number(0, 1) + R"(, "rest": )" + word({"start", "neutral"}) + "}]"
                                             : std::string("[]"));
      case 3: return R"("shown": )" + word({"skin", "body", "both"}) + R"(, "metalness": )" + number(0, 1);
      case 4: return R"("shape_colors": )" + (pick(3) ? "[" + color() + ", \"\"]" : std::string("[]"));
      case 5: return R"("color": )" + color();
      case 6: return R"("name": "N)" + number(0, 9) + "\"";
      case 7: return R"("place": {"x": )" + number(-5, 5) + R"(, "z": )" + number(0, 1) + R"(, "heading": )" + number(-180, 180) + "}";
      case 8: return R"("mechanism": )" + word({"m-walker", "m-ball"});
      default: return R"("locked": )" + boolean();
    }
  }
  /// A field of any clip of the first character.
  std::string clip_field(const Scenario& s) {
    if (s.characters.empty() || s.characters[0].track.empty()) return {};
    const std::string begin =
        R"({"type": "clip.set", "character": )" + quoted(s.characters[0].id) + R"(, "id": )" + quoted(any(s.characters[0].track).id) + ", ";
    switch (pick(5)) {
      case 0: return begin + R"("motion": )" + word({"n-walk", "n-step"}) + "}";
      case 1: return begin + R"("loop": )" + boolean() + R"(, "offset": 0, "length": 0.5})";
      case 2: return begin + R"("blend": )" + number(0, 1) + "}";
      case 3: return begin + (pick(4) ? R"("offset": )" + number(0, 0.5) + "}" : R"("layers": []})");
      default: return begin + R"("gait": )" + (pick(3) ? gait() : std::string("null")) + "}";
    }
  }
  std::string gait() {
    return R"({"kind": )" + word({"walk", "trot"}) + R"(, "style": )" + word({"usual", "proud"}) + R"(, "turn": )" + number(-30, 30) +
           R"(, "seconds": )" + number(1, 9) + R"(, "from_stand": )" + boolean() + R"(, "to_stand": )" + boolean() +
           R"(, "step_height": )" + number(0, 0.3) + R"(, "stages": [{"time": )" + number(1, 4) + R"(, "kind": "walk", "speed": )" +
           number(0, 2) + R"(, "turn": )" + number(-9, 9) + "}]}";
  }

  std::string setting(const Scenario& s) {
    switch (pick(8)) {
      case 0: return R"("name": "S)" + number(0, 9) + "\"";
      case 1: return R"("frame_rate": )" + (pick(2) ? std::string("30") : std::string("60"));
      case 2: return R"("step": )" + (pick(2) ? std::string("0.001") : std::string("0.002"));
      case 3: return R"("gravity": [0, 0, )" + number(-10, -1) + "]";
      case 4:
        return R"("ground": {"height": )" + number(-1, 0) + R"(, "friction": )" + number(0, 1) + R"(, "restitution": )" + number(0, 1) +
               "}";
      case 5:
        return R"("camera": {"follow": )" + (pick(2) ? std::string("null") : character(s)) + R"(, "distance": )" + number(1, 9) +
               R"(, "azimuth": )" + number(-3, 3) + R"(, "elevation": )" + number(0, 1) + "}";
      case 6:
        return R"("look": {"ambient": )" + number(0, 4) + R"(, "floor": )" + color() + R"(, "pattern": )" +
               word({"grid", "plain", "checker", "boards"}) + "}";
      default:
        return R"("look": {"sun": {"azimuth": )" + number(-3, 3) + R"(, "intensity": )" + number(0, 4) + R"(, "color": )" + color() +
               R"(}, "sky": {"zenith": )" + color() + R"(, "horizon": )" + color() + "}}";
    }
  }

  /// A change of any list of the circuit, or of its settings.
  std::string circuit_change() {
    const std::string n = std::to_string(pick(3));
    switch (pick(10)) {
      case 0: return R"({"list": "lsis", "put": {"id": "c)" + n + R"(", "type": "constant", "at": [)" + number(0, 99) + R"(, 0]}})";
      case 1: return R"({"list": "lsis", "take": "c)" + n + "\"}";
      case 2: return R"({"list": "wires", "put": {"from": "c0.out", "to": "c)" + n + R"(.in"}})";
      case 3: return R"({"list": "wires", "take": {"from": "c0.out", "to": "c)" + n + R"(.in"}})";
      case 4:
        return R"({"list": "notes", "put": {"id": "n)" + n + R"(", "text": "T)" + number(0, 9) + R"(", "at": [0, 0], "size": [100, 50]}})";
      case 5: return R"({"list": "probes", "put": {"pin": "c)" + n + R"(.out"}})";
      case 6: return R"({"list": "inputs", "put": {"name": "i)" + n + R"(", "type": "scalar"}})";
      case 7: return R"({"list": "parameters", "put": {"name": "p)" + n + R"(", "type": "scalar"}})";
      case 8: return R"({"list": "circuits", "put": {"name": "a)" + n + R"(", "lsis": [{"id": "c", "type": "constant"}]}})";
      default: return R"({"set": {"doc": "D)" + number(0, 9) + "\"}}";
    }
  }

  std::string camera_fields() {
    const std::string view = R"("target": )" + vector(0, 2) + R"(, "azimuth": )" + number(-3, 3) + R"(, "distance": )" + number(1, 9) +
                             R"(, "field_of_view": )" + number(0.3, 1);
    return R"({"name": "C)" + number(0, 9) + "\", " + view +
           (pick(2) ? R"(, "keys": [{"time": )" + number(0, 9) + ", " + view + "}]}" : "}");
  }
  std::string shot_fields(const Scenario& s) {
    return R"({"length": )" + number(0.1, 5) + R"(, "camera": )" +
           (s.cameras.empty() ? std::string(R"("none")") : quoted(any(s.cameras).id)) + "}";
  }
};

}  // namespace ugoki::content::testing
