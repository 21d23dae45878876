#pragma once
// Random commands for a scenario. Most are valid; some are refused.

#include <array>
#include <string>
#include <utility>
#include <vector>

#include "random_items.h"
#include "ugoki/content/flatten.h"

namespace ugoki::content::testing {

class RandomCommands : public RandomItems {
 public:
  using RandomItems::RandomItems;

  /// A random command (JSON) for the document `s`.
  std::string next(const Scenario& s) {
    if (std::string removal = shrink(s); !removal.empty()) return removal;
    if (!s.find_character("human") && pick(4) == 0) return R"({"type": "character.add", "id": "human", "mechanism": "m-walker"})";
    if (pick(25) == 0)
      if (std::string command = nest_command(s); !command.empty()) return command;
    if (!s.scenarios.empty() && pick(10) == 0) {
      const std::string id = any(s.scenarios).id;
      return R"({"type": "in", "scenario": ")" + id + R"(", "command": )" + next(open_scenario(s, id)) + "}";
    }
    switch (pick(47 + item_kinds)) {
      case 0:
        return R"({"type": "clip.add", "character": "human", "motion": ")" + std::string(pick(2) ? "n-walk" : "n-step") +
               R"(", "start": )" + number(0, 8) + "}";
      case 1:
      case 2: return clip_command(s, R"("start": )" + number(0, 8));
      case 3: return clip_command(s, R"("length": )" + number(0.05, 2.1));
      case 4: return clip_command(s, R"("offset": )" + number(0, 0.5) + R"(, "length": 0.4)");
      case 5:
        if (pick(4) == 0)
          return clip_command(s, R"("gait": {"kind": "walk", "speed": )" + number(0.5, 2) + R"(, "path": [[)" + number(1, 9) + ", 0]]}");
        return clip_command(s, R"("speed": )" + number(0.5, 2) + R"(, "length": 0.2)");
      case 6: return s.characters.empty() || s.characters[0].track.size() < 3 ? next(s) : command_on(s, "clip.remove", "");
      case 7: return split_command(s);
      case 8: return R"({"type": "character.add", "mechanism": "m-ball", "place": {"x": )" + number(-5, 5) + "}}";
      case 9:
        return R"({"type": "character.set", "id": ")" + any_character(s) + R"(", "place": {"y": )" + number(-5, 5) +
               R"(}, "control": {"balance": )" + number(0, 2) + "}}";
      case 10: return s.characters.size() < 3 ? next(s) : R"({"type": "character.remove", "id": ")" + s.characters.back().id + "\"}";
      case 11:
        return R"({"type": "event.add", "event": {"type": "push", "time": )" + number(0, 9) +
               R"(, "character": "human", "link": "leg", "force": [)" + number(-200, 200) + ", 0, 0]}}";
      case 38:
        return R"({"type": "event.add", "event": {"type": "pull", "time": )" + number(0, 9) +
               R"(, "character": "human", "link": "leg", "path": [[0, 1, 2, )" + number(0, 2) + "], [" + number(-0.1, 1) + ", 1, 2, 1]]}}";
      case 12:
        if (s.events.empty()) return next(s);
        return pick(2) ? R"({"type": "event.set", "id": ")" + s.events[pick(s.events.size())].id + R"(", "event": {"time": )" +
                             number(0, 9) + "}}"
                       : R"({"type": "event.remove", "id": ")" + s.events[pick(s.events.size())].id + "\"}";
      case 13: return R"({"type": "marker.add", "time": )" + number(0, 9) + "}";
      case 14:
        if (s.markers.empty()) return next(s);
        return R"({"type": "marker.)" + std::string(pick(2) ? "remove" : "set") + R"(", "id": ")" + s.markers[pick(s.markers.size())].id +
               (pick(2) ? "\"}" : R"(", "time": )" + number(0, 9) + "}");
      case 15:
        return R"({"type": "character.set", "id": ")" + any_character(s) + R"(", ")" + std::string(pick(2) ? "muted" : "solo") + R"(": )" +
               std::string(pick(2) ? "true}" : "false}");
      case 16:
        return R"({"type": "scenario.set", "range": )" +
               (pick(3) == 0 ? "null}" : R"({"from": )" + number(0, 4) + R"(, "to": )" + number(4.1, 9) + "}}");
      case 17:
        return R"({"type": "rule.add", "rule": {"if": [{"type": "time", "time": )" + number(0, 9) +
               R"(}], "do": {"type": "play", "character": "human", "motion": "n-step", "loop": true}}})";
      case 18:
        if (s.rules.empty()) return next(s);
        return R"({"type": "rule.set", "id": ")" + s.rules[pick(s.rules.size())].id + R"(", "rule": {"on": )" +
               (pick(2) ? "true" : "false") + R"(, "if": [{"type": "key", "key": "KeyW"}, {"type": "time", "time": )" + number(-1, 9) +
               "}]}}";
      case 19:
        if (s.rules.empty()) return next(s);
        return R"({"type": "rule.)" + std::string(pick(2) ? "move" : "remove") + R"(", "id": ")" + s.rules[pick(s.rules.size())].id + "\"" +
               (pick(2) ? R"(, "at": 0})" : "}");
      case 20:
      case 44:
        return command_on_clip(s, "layer.add",
                               R"("value": {"mode": ")" + std::string(pick(2) ? "additive" : "replace") + R"(", "ease_in": )" +
                                   (pick(2) ? "null" : number(0, 1)) + R"(, "weight": )" + number(0, 1.05) + "}");
      case 21:
      case 22: return key_command(s);
      case 23:
      case 45:
        return layer_command(s, "layer.set",
                             R"(, "value": {"on": )" + std::string(pick(2) ? "true" : "false") + R"(, "weight": )" + number(0, 1) +
                                 R"(, "ease_out": )" + number(0, 2) + "}");
      case 40:
      case 41:
        return layer_command(s, "layer.move", R"(, "at": )" + std::to_string(pick(3)));  // most layers have no other one in their clip
      case 24:
      case 46:
        return pick(3) == 0 ? layer_command(s, "layer.remove", "")
                            : layer_command(s, "layer.move", R"(, "at": )" + std::to_string(pick(3)));
      case 25: {
        const std::string command = next(s), other = next(s);
        return R"({"type": "group", "label": "Two", "commands": [)" + command + ", " + other + "]}";
      }
      case 26:
        return R"({"type": "camera.add", "camera": {"distance": )" + number(1, 9) + R"(, "keys": [{"time": )" + number(0, 4) + "}, " +
               R"({"time": )" + number(4, 9) + R"(, "azimuth": )" + number(-3, 3) + "}]}}";
      case 27:
        if (s.cameras.empty()) return next(s);
        return pick(4) == 0 ? R"({"type": "camera.remove", "id": ")" + s.cameras[pick(s.cameras.size())].id + "\"}"
                            : R"({"type": "camera.set", "id": ")" + s.cameras[pick(s.cameras.size())].id + R"(", "camera": {"follow": )" +
                                  (pick(2) ? "\"" + any_character(s) + "\"" : "null") + R"(, "elevation": )" + number(-0.2, 1.6) +
                                  (pick(2) ? R"(, "keys": []}})" : "}}");
      case 28:
        if (s.cameras.empty()) return next(s);
        return R"({"type": "shot.add", "shot": {"camera": ")" + s.cameras[pick(s.cameras.size())].id + R"(", "start": )" + number(0, 9) +
               R"(, "length": )" + number(0.1, 5) + "}}";
      case 29:
        if (s.shots.empty()) return next(s);
        return pick(3) == 0 ? R"({"type": "shot.remove", "id": ")" + s.shots[pick(s.shots.size())].id + "\"}"
                            : R"({"type": "shot.set", "id": ")" + s.shots[pick(s.shots.size())].id + R"(", "shot": {"start": )" +
                                  number(0, 9) + "}}";
      case 30: return look_command(s);
      case 31:
        return R"({"type": "pose.add", "pose": {"mechanism": "m-walker", "joints": [{"link": "leg", "q": [)" + number(-2, 2) +
               R"(]}]}, "at": )" + std::to_string(pick(4)) + "}";
      case 32:
        if (s.poses.empty()) return next(s);
        return pick(2) ? R"({"type": "pose.set", "id": ")" + s.poses[pick(s.poses.size())].id + R"(", "pose": {"name": "P)" + number(0, 9) +
                             "\"}}"
                       : R"({"type": "pose.remove", "id": ")" + s.poses[pick(s.poses.size())].id + "\"}";
      case 33: return R"({"type": "track.move", "character": ")" + any_character(s) + R"(", "at": )" + std::to_string(pick(4)) + "}";
      case 34:
        return R"({"type": "character.set", "id": ")" + any_character(s) + R"(", "group": ")" +
               (pick(2) ? "" : "G" + std::to_string(pick(3))) + "\"}";
      case 35:
        return R"({"type": "variable.add", "variable": {"kind": ")" + std::string(pick(2) ? "switch" : "number") + R"(", "initial": )" +
               (pick(3) ? "1" : number(-2, 12)) + R"(, "maximum": )" + (pick(2) ? "null" : "10") + "}}";
      case 36:
        if (s.variables.empty()) return next(s);
        return pick(3) ? R"({"type": "variable.set", "id": ")" + s.variables[pick(s.variables.size())].id +
                             R"(", "variable": {"name": "N)" + number(0, 9) + R"(", "shown": )" + (pick(2) ? "true}}" : "false}}")
                       : R"({"type": "variable.remove", "id": ")" + s.variables[pick(s.variables.size())].id + "\"}";
      case 37:
        if (s.variables.empty()) return next(s);
        return R"({"type": "rule.add", "rule": {"if": [{"type": "variable", "variable": ")" + s.variables[pick(s.variables.size())].id +
               R"(", "compare": ")" + std::array{"at_least", "at_most", "above", "below", "equal"}[pick(5)] + R"(", "value": )" +
               number(-5, 5) + R"(}], "do": {"type": "set", "variable": ")" + s.variables[pick(s.variables.size())].id +
               R"(", "change": ")" + std::array{"set", "add", "toggle"}[pick(3)] + R"(", "value": )" + number(-5, 5) + "}}}";
      case 42: return R"({"type": "character.add", "prop": )" + prop() + R"(, "place": {"z": )" + number(0, 2) + "}}";
      case 43: return R"({"type": "character.set", "id": ")" + any_character(s) + R"(", "prop": )" + prop() + "}";
      case 39:
        return pick(2) ? R"({"type": "scenario.set", "duration": )" + number(1, 30) + R"(, "look": {"light": )" + number(0, 2.1) + "}}"
                       : circuit_command();
      default:
        if (std::string command = item_command(s); !command.empty()) return command;
        return next(s);
    }
  }

 private:
  /// Splits any clip of the first character.
  std::string split_command(const Scenario& s) {
    if (s.characters.empty() || s.characters[0].track.empty()) return R"({"type": "clip.remove", "character": "human", "id": "none"})";
    const ScenarioClip& clip = s.characters[0].track[pick(s.characters[0].track.size())];
    return R"({"type": "clip.split", "character": ")" + s.characters[0].id + R"(", "id": ")" + clip.id + R"(", "time": )" +
           number(clip.start, clip.start + clip.length) + "}";
  }
  std::string look_command(const Scenario& s) {
    if (pick(2))
      return R"({"type": "character.set", "id": ")" + any_character(s) + R"(", "roughness": )" + number(0, 1.1) + R"(, "link_colors": )" +
             (pick(2) ? "{}}" : R"({"leg": "#102030"}})");
    return R"({"type": "scenario.set", "look": {"pattern": ")" + std::string(pick(2) ? "boards" : "grid") + R"(", "sky": )" +
           (pick(2) ? "null" : R"({"zenith": "#204080", "horizon": "#c0d0e0"})") + R"(, "sun": {"elevation": )" + number(0, 1.6) + "}}}";
  }
  std::string circuit_command() {
    if (pick(4) == 0) return R"({"type": "circuit.set", "circuit": null})";
    const std::string lsi =
        R"({"id": "c)" + std::to_string(pick(3)) + R"(", "type": "constant", "parameters": {"value": )" + number(0, 1) + "}}";
    if (pick(3) == 0) return R"({"type": "circuit.set", "circuit": {"version": 1, "name": "mine", "lsis": [)" + lsi + "]}}";
    return R"({"type": "circuit.edit", "changes": [{"list": "lsis", "put": )" + lsi + "}]}";
  }
  std::string prop() {
    if (pick(7) == 0)
      return R"({"shape": "mesh", "mesh": "m-table", "scale": )" + vector(0.5, 2) + R"(, "collision": )" +
             word({"hull", "parts", "surface"}) + R"(, "tilt": )" + vector(-90, 90) + R"(, "friction": )" + number(0, 2) +
             R"(, "restitution": )" + number(0, 1) + "}";
    if (pick(7) == 0)
      return R"({"shape": "terrain", "size": [)" + number(1, 9) + ", 4, " + number(0.1, 1) + R"(], "mass": )" + (pick(5) ? "0" : "3") +
             R"(, "grain": )" + number(0.5, 4) + R"(, "seed": )" + std::to_string(pick(99)) + "}";
    return R"({"shape": ")" + std::string(std::array{"box", "ramp", "stairs", "cylinder", "sphere", "bar"}[pick(6)]) + R"(", "size": [)" +
           number(-0.05, 2) + ", 1, " + number(0.1, 3) + R"(], "mass": )" + (pick(2) ? "0" : number(0, 20)) + R"(, "steps": )" +
           std::to_string(pick(8)) + "}";
  }
  std::string any_character(const Scenario& s) { return s.characters.empty() ? "none" : s.characters[pick(s.characters.size())].id; }
  std::string command_on(const Scenario& s, const std::string& type, const std::string& more) {
    if (s.characters.empty() || s.characters[0].track.empty()) return R"({"type": "clip.remove", "character": "human", "id": "none"})";
    const auto& track = s.characters[0].track;
    return R"({"type": ")" + type + R"(", "character": ")" + s.characters[0].id + R"(", "id": ")" + track[pick(track.size())].id + "\"" +
           more + "}";
  }
  /// A command that removes an item from a list that has become long, so that long histories stay fast; empty: no list is long.
  std::string shrink(const Scenario& s) {
    constexpr std::size_t max_length = 8;
    const auto remove = [&](const char* type, const auto& list) {
      return R"({"type": ")" + std::string(type) + R"(", "id": ")" + list[pick(list.size())].id + "\"}";
    };
    if (s.characters.size() > max_length) {  // a locked track keeps others from being removed whose removal would change it
      const std::string& id = any(s.characters).id;
      if (pick(3) == 0) return R"({"type": "character.set", "id": ")" + id + R"(", "locked": false})";
      return R"({"type": "character.remove", "id": ")" + (pick(2) ? id : s.characters.back().id) + "\"}";
    }
    if (s.events.size() > max_length) return remove("event.remove", s.events);
    if (s.markers.size() > max_length) return remove("marker.remove", s.markers);
    if (s.rules.size() > max_length) return remove("rule.remove", s.rules);
    if (s.variables.size() > max_length) return remove("variable.remove", s.variables);
    if (s.poses.size() > max_length) return remove("pose.remove", s.poses);
    if (s.shots.size() > max_length) return remove("shot.remove", s.shots);
    if (s.cameras.size() > max_length) return remove("camera.remove", s.cameras);
    if ((s.instances.size() > 4 || s.scenarios.size() > 4) && !s.circuit.empty()) return R"({"type": "circuit.set", "circuit": null})";
    if (s.instances.size() > 4) return remove("instance.remove", s.instances);
    if (s.scenarios.size() > 4) {  // a scenario is removed only if nothing places it
      const Scenario& host = pick(2) || s.instances.empty() ? any(s.scenarios) : s;
      if (pick(2) || host.instances.empty()) return remove("scenario.remove", s.scenarios);
      const std::string command = remove("instance.remove", host.instances);
      return &host == &s ? command : R"({"type": "in", "scenario": ")" + host.id + R"(", "command": )" + command + "}";
    }
    if (s.characters.empty() || s.characters[0].locked) return {};
    for (const ScenarioClip& clip : s.characters[0].track) {
      if (s.characters[0].track.size() > max_length) return command_on(s, "clip.remove", "");
      std::size_t keys = 0;
      for (const ScenarioLayer& layer : clip.layers)
        for (const motion_edit::JointKeys& joint : layer.keyed.joints) keys += joint.keys.size();
      if (clip.layers.size() > 3 || keys > 40)
        return R"({"type": "layer.remove", "character": ")" + s.characters[0].id + R"(", "clip": ")" + clip.id + R"(", "layer": ")" +
               clip.layers[0].id + "\"}";
    }
    return {};
  }
  /// A command on the layers of any clip of the first character.
  std::string command_on_clip(const Scenario& s, const std::string& type, const std::string& more) {
    if (s.characters.empty() || s.characters[0].track.empty()) return R"({"type": "clip.remove", "character": "human", "id": "none"})";
    const auto& track = s.characters[0].track;
    return R"({"type": ")" + type + R"(", "character": ")" + s.characters[0].id + R"(", "clip": ")" + track[pick(track.size())].id +
           "\", " + more + "}";
  }
  /// A layer of any clip of the first character; null: there is none.
  std::pair<const ScenarioClip*, const ScenarioLayer*> any_layer(const Scenario& s) {
    if (s.characters.empty()) return {};
    std::vector<std::pair<const ScenarioClip*, const ScenarioLayer*>> all;
    for (const ScenarioClip& clip : s.characters[0].track)
      for (const ScenarioLayer& layer : clip.layers) all.emplace_back(&clip, &layer);
    return all.empty() ? std::pair<const ScenarioClip*, const ScenarioLayer*>{} : all[pick(all.size())];
  }
  std::string layer_command(const Scenario& s, const std::string& type, const std::string& more) {
    const auto [clip, layer] = any_layer(s);
    if (!layer) return next(s);
    return R"({"type": ")" + type + R"(", "character": ")" + s.characters[0].id + R"(", "clip": ")" + clip->id + R"(", "layer": ")" +
           layer->id + "\"" + more + "}";
  }
  /// Sets, changes or removes a key.
  std::string key_command(const Scenario& s) {
    const auto [clip, layer] = any_layer(s);
    if (!layer) return next(s);
    std::string more =
        R"(, "put": [{"link": "leg", "time": )" + number(-0.05, 2) + R"(, "value": [)" + number(-1, 1) + R"(], "tangent": ")" +
        std::array{"smooth", "linear", "step", "free"}[pick(4)] + R"(", "in": [)" + number(-5, 5) + R"(], "out": [0]},
                       {"link": "pelvis", "part": ")" +
        (pick(2) ? "rotation" : "position") + R"(", "time": )" + number(0, 2) + R"(, "value": [0, )" + number(-1, 1) + ", -0.5]}]";
    if (!layer->keyed.joints.empty() && pick(2)) {
      const motion_edit::JointKeys& joint = layer->keyed.joints[pick(layer->keyed.joints.size())];
      const std::string part = joint.part == motion_edit::JointPart::whole      ? "joint"
                               : joint.part == motion_edit::JointPart::rotation ? "rotation"
                                                                                : "position";
      more = R"(, "take": [{"link": ")" + joint.link + R"(", "part": ")" + part + R"(", "time": )" +
             std::to_string(joint.keys[pick(joint.keys.size())].time) + "}]" + (pick(2) ? more : "");
    }
    return R"({"type": "key.edit", "character": ")" + s.characters[0].id + R"(", "clip": ")" + clip->id + R"(", "layer": ")" + layer->id +
           "\"" + more + "}";
  }
  std::string clip_command(const Scenario& s, const std::string& fields) { return command_on(s, "clip.set", ", " + fields); }
};

}  // namespace ugoki::content::testing
