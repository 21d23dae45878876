#include "ugoki/content/commands.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "ugoki/base/number.h"
#include "ugoki/content/circuit_edit.h"
#include "ugoki/content/default_circuit.h"
#include "ugoki/content/flatten.h"
#include "ugoki/content/layer_commands.h"
#include "ugoki/content/list_commands.h"
#include "ugoki/content/nest_commands.h"
#include "ugoki/content/scenario_json.h"

namespace ugoki::content {
namespace {

constexpr std::size_t max_commands = 10'000;  // maximum number in one group, including nested groups

/// Applies one command (with the commands of a group) to a copy of the document.
class Work {
 public:
  Work(const Scenario& scenario, const Catalogue& catalogue, std::uint64_t& next_id) : catalogue_(catalogue), next_id_(next_id) {
    effect_.scenario = scenario;
  }

  /// A type of command, and the function that reads and applies it.
  struct Kind {
    std::string_view type;
    std::string (Work::*run)(Fields&);
  };
  static const std::array<Kind, 46> kinds;

  /// Applies one command to the copy. Problems are collected and returned by finish(). @return the label for undo menus
  std::string apply(const Json& command, const std::string& path) {
    Fields f(command, path, problems_);
    std::string type;
    f.require("type", "the command's type, for example \"clip.add\"");
    f.text("type", type);
    if (!problems_.empty()) return {};
    for (const Kind& kind : kinds) {
      if (kind.type != type) continue;
      std::string label = (this->*kind.run)(f);
      f.refuse_others();
      return label;
    }
    problems_.add(ErrorCode::unsupported, f.path("type"), "There is no command '" + type + "'.",
                  "Use one of the commands of docs/scenario.md.");
    return {};
  }

  Result<CommandEffect> finish(std::string label) {
    if (!problems_.empty()) return fail(std::move(problems_));
    put_in_order(effect_.scenario);
    Error invalid = check_scenario(effect_.scenario, &catalogue_);
    if (!invalid.empty()) return fail(std::move(invalid));
    effect_.label = std::move(label);
    return std::move(effect_);
  }

 private:
  Scenario& root() { return effect_.scenario; }
  /// The scenario in which the command acts: the document, or the inner scenario of the command `in`.
  Scenario& document() { return target().scenario(); }
  NestTarget target() { return {effect_.scenario, inner_}; }

  bool used(const std::string& id) const {
    bool found = false;
    const auto look_in = [&](const auto& list) {
      found = found || std::any_of(list.begin(), list.end(), [&](const auto& item) { return item.id == id; });
    };
    for_each_scenario(effect_.scenario, [&](const Scenario& s) {
      for (const ScenarioCharacter& c : s.characters) look_in(c.track);
      look_in(s.characters), look_in(s.events), look_in(s.markers), look_in(s.rules), look_in(s.variables), look_in(s.poses);
      look_in(s.cameras), look_in(s.shots), look_in(s.instances);
    });
    return found;
  }
  /// Keeps an id that the command gives. If `id` is empty, creates a new id: `letter` followed by a number.
  void assign_id(std::string& id, char letter) {
    if (id.empty()) {
      do id = letter + std::to_string(next_id_++);
      while (used(id));
    } else if (const auto number = parse_long(std::string_view(id).substr(1)); number && *number >= 0 && *number < 1'000'000'000) {
      next_id_ = std::max(next_id_, static_cast<std::uint64_t>(*number) + 1);  // a command that gives "k7" uses up the number 7
    }
    effect_.created.push_back(id);
  }
  void report_missing(Fields& f, std::string_view key, std::string_view kind, const std::string& id) {
    problems_.add(ErrorCode::unknown, f.path(key), "There is no " + std::string(kind) + " '" + id + "'.",
                  "It may have been removed; reload the document.");
  }
  ScenarioCharacter* character_in(Fields& f, std::string_view key) {
    std::string id;
    f.require(key, "a character's id");
    f.text(key, id);
    if (!problems_.empty()) return nullptr;
    ScenarioCharacter* c = document().find_character(id);
    if (!c) report_missing(f, key, "character", id);
    return c;
  }
  /// As character_in(), and reports a problem and returns null if the character is locked.
  ScenarioCharacter* unlocked_in(Fields& f, std::string_view key) {
    ScenarioCharacter* c = character_in(f, key);
    if (!c || !c->locked) return c;
    problems_.add(ErrorCode::conflict, f.path(key), "The track of '" + c->name + "' is locked.", "Unlock the track first.");
    return nullptr;
  }
  /// Returns the character and the clip's index in its track, from the fields `character` and `key`; {null, 0} and a problem if missing.
  std::pair<ScenarioCharacter*, std::size_t> clip_in(Fields& f, std::string_view key = "id") {
    ScenarioCharacter* c = unlocked_in(f, "character");
    std::string id;
    f.require(key, "the clip's id");
    f.text(key, id);
    if (!c || !problems_.empty()) return {nullptr, 0};
    for (std::size_t i = 0; i < c->track.size(); ++i)
      if (c->track[i].id == id) return {c, i};
    report_missing(f, key, "clip", id);
    return {nullptr, 0};
  }
  ScenarioEvent* event_in(Fields& f) {
    std::string id;
    f.require("id", "the event's id");
    f.text("id", id);
    if (!problems_.empty()) return nullptr;
    for (ScenarioEvent& e : document().events)
      if (e.id == id) return &e;
    report_missing(f, "id", "event", id);
    return nullptr;
  }
  std::string clip_add(Fields& f) {
    ScenarioCharacter* c = unlocked_in(f, "character");
    f.require("motion", "a motion's id");
    f.require("start", "the time in seconds at which it starts");
    ScenarioClip clip;
    clip.length = 1;
    read_clip(f, clip);
    if (!c || !problems_.empty()) return {};
    assign_id(clip.id, 'k');
    const auto motion = catalogue_.motions.find(clip.motion);
    if (!f.has("length") && motion != catalogue_.motions.end())
      clip.length = clip.speed > 0 ? std::max(0.001, (motion->second.duration - clip.offset) / clip.speed) : motion->second.duration;
    c->track.push_back(clip);
    return "Add clip";
  }

  std::string clip_set(Fields& f) {
    const auto [c, i] = clip_in(f);
    if (!c) return {};
    ScenarioClip& clip = c->track[i];
    const ScenarioClip before = clip;
    read_clip(f, clip);
    clip.id = before.id;
    if (clip.motion != before.motion && !f.has("gait")) clip.gait.reset();  // the recipe describes the former motion
    if (clip.motion != before.motion) return "Replace motion of clip";
    if (clip.loop != before.loop) return clip.loop ? "Loop clip" : "Stop looping clip";
    if (clip.speed != before.speed) return "Stretch clip";
    if (clip.length != before.length) return "Trim clip";
    if (clip.start != before.start) return clip.offset != before.offset ? "Trim clip" : "Move clip";
    if (clip.offset != before.offset) return "Slip clip";
    if (clip.blend != before.blend) return "Set blend of clip";
    return "Change clip";
  }

  std::string clip_remove(Fields& f) {
    const auto [c, i] = clip_in(f);
    if (c) c->track.erase(c->track.begin() + static_cast<std::ptrdiff_t>(i));
    return "Remove clip";
  }

  std::string clip_split(Fields& f) {
    const auto [c, i] = clip_in(f);
    double time = 0;
    f.require("time", "the time in seconds at which to split");
    f.number("time", time);
    if (!c || !problems_.empty()) return {};
    ScenarioClip first = c->track[i];
    const double cut = time - first.start;
    if (!(cut > 0.001 && cut < first.length - 0.001)) {
      problems_.add(ErrorCode::range, f.path("time"), "The time " + ugoki::to_text(time) + " s is not inside clip '" + first.id + "'.",
                    "Choose a time between " + to_fixed(first.start, 3) + " s and " + to_fixed(first.start + first.length, 3) + " s.");
      return {};
    }
    ScenarioClip second = first;
    second.id.clear();
    assign_id(second.id, 'k');
    first.length = cut;
    second.start = time;
    second.length -= cut;
    second.blend = 0;
    second.offset += cut * first.speed;
    const auto motion = catalogue_.motions.find(second.motion);
    if (second.loop && motion != catalogue_.motions.end() && motion->second.duration > 0)
      second.offset -= std::floor(second.offset / motion->second.duration) * motion->second.duration;
    c->track[i] = first;
    c->track.push_back(second);
    return "Split clip";
  }

  /// A command that changes the layers of one clip; the clip's id is in the field `clip`.
  template <std::string (*change)(Fields&, ScenarioClip&)>
  std::string on_clip(Fields& f) {
    const auto [c, i] = clip_in(f, "clip");
    return c ? change(f, c->track[i]) : std::string();
  }
  template <std::string (*change)(Fields&, Scenario&)>
  std::string on_document(Fields& f) {
    return change(f, document());
  }
  /// A command on items that only the document has, even if an inner scenario is edited.
  template <std::string (*change)(Fields&, Scenario&)>
  std::string on_root(Fields& f) {
    return change(f, root());
  }
  template <std::string (*change)(Fields&, const NestTarget&)>
  std::string on_nest(Fields& f) {
    return change(f, target());
  }
  template <std::string (*change)(Fields&, const NestTarget&, const AssignId&)>
  std::string add_nest(Fields& f) {
    return change(f, target(), [this](std::string& id, char letter) { assign_id(id, letter); });
  }
  std::string variable_remove(Fields& f) {
    std::string label = drop_variable(f, document());
    remove_dangling(root());
    return label;
  }
  std::string pose_add(Fields& f) {
    return add_pose(f, root(), [this](std::string& id, char letter) { assign_id(id, letter); });
  }

  /// Applies a command to an inner scenario.
  std::string in_scenario(Fields& f) {
    std::string id;
    f.require("scenario", "the id of an inner scenario");
    f.require("command", "the command");
    f.text("scenario", id);
    const Json* command = f.find("command");
    if (!command || !problems_.empty()) return {};
    if (!root().find_scenario(id)) {
      report_missing(f, "scenario", "scenario", id);
      return {};
    }
    const std::string outside = std::exchange(inner_, id);
    std::string label = apply(*command, f.path("command"));
    inner_ = outside;
    return label;
  }
  /// Reports a problem if an inner scenario is edited: only the document has a circuit.
  bool has_no_circuit(Fields& f) {
    if (inner_.empty()) return false;
    problems_.add(ErrorCode::unsupported, f.path("type"), "An inner scenario has no circuit of its own.",
                  "Open the outermost scenario, and change the circuit there.");
    return true;
  }
  template <std::string (*add)(Fields&, Scenario&, const AssignId&)>
  std::string add_item(Fields& f) {
    return add(f, document(), [this](std::string& id, char letter) { assign_id(id, letter); });
  }
  std::string layer_add(Fields& f) {
    const auto [c, i] = clip_in(f, "clip");
    if (!c) return {};
    std::string free_id, id;
    const auto taken = [&, clip = &c->track[i]] {
      return std::any_of(clip->layers.begin(), clip->layers.end(), [&](const ScenarioLayer& l) { return l.id == free_id; });
    };
    for (std::size_t n = c->track[i].layers.size() + 1; free_id.empty() || taken(); ++n) free_id = "l" + std::to_string(n);
    std::string label = add_layer(f, c->track[i], free_id, id);
    if (!id.empty()) effect_.created.push_back(id);
    return label;
  }

  std::string character_add(Fields& f) {
    if (!f.has("prop")) f.require("mechanism", "a mechanism's id");
    ScenarioCharacter c;
    read_character(f, c);
    if (!problems_.empty()) return {};
    assign_id(c.id, 'c');
    const auto mechanism = catalogue_.mechanisms.find(c.mechanism);
    if (c.name.empty() && c.prop && c.prop->shape != PropShape::mesh) c.name = name_of(c.prop->shape);
    if (c.name.empty() && c.prop)
      if (const auto mesh = catalogue_.mechanisms.find(c.prop->mesh); mesh != catalogue_.mechanisms.end()) c.name = mesh->second.name;
    if (c.name.empty())
      c.name = mechanism != catalogue_.mechanisms.end() && !mechanism->second.name.empty() ? mechanism->second.name : c.id;
    document().characters.push_back(std::move(c));
    return document().characters.back().prop ? "Add prop" : "Add character";
  }

  std::string character_set(Fields& f) {
    ScenarioCharacter* c = character_in(f, "id");
    if (!c) return {};
    const ScenarioCharacter before = *c;
    read_character(f, *c);
    c->id = before.id;
    if (c->prop && c->mechanism != prop_mechanism_id(*c->prop))
      problems_.add(ErrorCode::structure, f.path("mechanism"),
                    "'" + c->name + "' is a prop; its mechanism is made from the values of the prop.",
                    "Set the fields of `prop`, or add a character with this mechanism.");
    if (c->prop != before.prop) return "Change prop";
    if (c->mechanism != before.mechanism) return "Replace mechanism of character";
    if (!(c->place == before.place)) return "Place character";
    if (c->name != before.name) return "Rename character";
    if (c->color != before.color) return "Colour character";
    if (!(c->material == before.material)) return "Change material";
    if (!(c->control == before.control)) return "Set control of character";
    if (!(c->secondary == before.secondary)) return "Set secondary motion of character";
    if (c->muted != before.muted) return c->muted ? "Mute track" : "Unmute track";
    if (c->solo != before.solo) return c->solo ? "Solo track" : "End solo of track";
    if (c->locked != before.locked) return c->locked ? "Lock track" : "Unlock track";
    if (c->group != before.group) return c->group.empty() ? "Take track out of its group" : "Group tracks";
    return "Change character";
  }

  /// Removes the character together with its events and rules.
  std::string character_remove(Fields& f) {
    const ScenarioCharacter* c = unlocked_in(f, "id");
    if (!c) return {};
    const std::string id = c->id;
    std::erase_if(document().characters, [&](const ScenarioCharacter& x) { return x.id == id; });
    std::erase_if(document().events, [&](const ScenarioEvent& e) { return e.character == id || e.grip.other == id; });
    remove_rules_of(document(), id);
    std::erase(document().track_order, id);
    if (document().camera.follow == id) document().camera.follow.clear();
    for (FilmCamera& camera : document().cameras)
      if (camera.follow == id) camera.follow.clear();
    remove_dangling(root());
    return "Remove character";
  }

  std::string event_add(Fields& f) {
    f.require("event", "the event: an object with type, time, character and so on");
    ScenarioEvent event;
    if (const Json* object = f.find("event")) {
      Fields g(*object, f.path("event"), problems_);
      g.require("type", "\"push\", \"pull\", \"throw\", \"grab\" or \"release\"");
      g.require("time", "the time in seconds at which it happens");
      g.require("character", "a character's id");
      read_event(g, event);
      g.refuse_others();
    }
    if (!problems_.empty()) return {};
    assign_id(event.id, 'e');
    const std::string label = "Add " + std::string(name_of(event.type));
    document().events.push_back(std::move(event));
    return label;
  }

  std::string event_set(Fields& f) {
    ScenarioEvent* event = event_in(f);
    f.require("event", "an object with the fields to change");
    const Json* object = f.find("event");
    if (!event || !object) return {};
    const ScenarioEvent before = *event;
    Fields g(*object, f.path("event"), problems_);
    read_event(g, *event);
    g.refuse_others();
    if (event->type != before.type)
      problems_.add(ErrorCode::structure, g.path("type"), "An event cannot change its type.", "Remove it and add another.");
    event->id = before.id;
    return (event->time != before.time ? "Move " : "Change ") + std::string(name_of(event->type));
  }

  std::string event_remove(Fields& f) {
    const ScenarioEvent* event = event_in(f);
    if (!event) return {};
    const std::string id = event->id, label = "Remove " + std::string(name_of(event->type));
    std::erase_if(document().events, [&](const ScenarioEvent& e) { return e.id == id; });
    return label;
  }

  std::vector<Rule>::iterator rule_in(Fields& f) {
    std::vector<Rule>& rules = document().rules;
    std::string id;
    f.require("id", "the rule's id");
    f.text("id", id);
    if (!problems_.empty()) return rules.end();
    const auto found = std::find_if(rules.begin(), rules.end(), [&](const Rule& r) { return r.id == id; });
    if (found == rules.end()) report_missing(f, "id", "rule", id);
    return found;
  }
  void read_rule_in(Fields& f, Rule& rule) {
    f.require("rule", "an object with the fields of the rule");
    if (const Json* object = f.find("rule")) {
      Fields g(*object, f.path("rule"), problems_);
      read_rule(g, rule);
      g.refuse_others();
    }
  }

  std::string rule_add(Fields& f) {
    Rule rule;
    read_rule_in(f, rule);
    int at = static_cast<int>(document().rules.size());
    f.integer("at", at);
    if (!problems_.empty()) return {};
    assign_id(rule.id, 'r');
    document().rules.insert(document().rules.begin() + std::clamp(at, 0, static_cast<int>(document().rules.size())), std::move(rule));
    return "Add rule";
  }

  std::string rule_set(Fields& f) {
    const auto rule = rule_in(f);
    if (rule == document().rules.end()) return {};
    const Rule before = *rule;
    read_rule_in(f, *rule);
    rule->id = before.id;
    if (rule->on != before.on) return rule->on ? "Switch on rule" : "Switch off rule";
    return "Change rule";
  }

  /// Changes the priority of a rule.
  std::string rule_move(Fields& f) {
    const auto rule = rule_in(f);
    int at = 0;
    f.require("at", "the new index in the list of rules");
    f.integer("at", at);
    if (rule == document().rules.end() || !problems_.empty()) return {};
    Rule moved = std::move(*rule);
    document().rules.erase(rule);
    document().rules.insert(document().rules.begin() + std::clamp(at, 0, static_cast<int>(document().rules.size())), std::move(moved));
    return "Move rule";
  }

  std::string rule_remove(Fields& f) {
    const auto rule = rule_in(f);
    if (rule != document().rules.end()) remove_rule(document(), std::string(rule->id));
    remove_dangling(root());
    return "Remove rule";
  }

  /// Changes the place of a character's track in the timeline. The order of the characters themselves, on which the bits of a simulation
  /// depend, stays as it is.
  std::string track_move(Fields& f) {
    const ScenarioCharacter* c = character_in(f, "character");
    int at = 0;
    f.require("at", "the new index of the track");
    f.integer("at", at);
    if (!c || !problems_.empty()) return {};
    std::vector<std::string> order = document().track_order;
    for (const ScenarioCharacter& other : document().characters)
      if (std::find(order.begin(), order.end(), other.id) == order.end()) order.push_back(other.id);
    std::erase(order, c->id);
    order.insert(order.begin() + std::clamp(at, 0, static_cast<int>(order.size())), c->id);
    document().track_order = std::move(order);
    return "Move track";
  }

  std::string scenario_set(Fields& f) {
    const Scenario before = document(), before_root = root();
    read_inner_settings(f, document());
    read_world_settings(f, root());
    if (document().name != before.name) return inner_.empty() ? "Rename content" : "Rename scenario";
    if (document().duration != before.duration) return "Set duration";
    if (!(document().camera == before.camera)) return "Set camera";
    if (!(root().look == before_root.look)) return "Set look";
    if (!(document().range == before.range)) return document().range.is_set() ? "Set in and out" : "Clear in and out";
    return "Change settings";
  }

  std::string circuit_set(Fields& f) {
    f.require("circuit", "a circuit, or null for the default one");
    if (has_no_circuit(f)) return {};
    read_circuit_field(f, document());
    if (const Json* circuit = f.find("circuit"); circuit && circuit->is_object()) check_form(*circuit);
    return document().circuit.empty() ? "Use default circuit" : "Change circuit";
  }

  /// Changes the stored circuit item by item. A document without its own circuit first gets a copy of the default circuit.
  std::string circuit_edit(Fields& f) {
    std::string label = "Change circuit";
    f.text("label", label);
    f.require("changes", "a list of changes");
    const Json* changes = f.find("changes");
    if (!changes || !problems_.empty() || has_no_circuit(f)) return {};
    const std::string text = document().circuit.empty() ? default_circuit(played_part(document())) : document().circuit;
    Result<Json> circuit = parse_json(text, "circuit", max_command_size);
    if (!circuit) {
      for (Problem& p : circuit.error().problems) problems_.problems.push_back(std::move(p));
      return {};
    }
    apply_circuit_changes(*circuit, *changes, f.path("changes"), problems_);
    if (problems_.empty()) check_form(*circuit);
    if (problems_.empty()) document().circuit = to_text(*circuit);
    return label.empty() ? "Change circuit" : label.substr(0, 200);
  }

  void check_form(const Json& circuit) {
    for (Problem& p : check_circuit_form(circuit).problems) problems_.problems.push_back(std::move(p));
  }

  std::string group(Fields& f) {
    std::string label = "Change";
    f.require("commands", "a list of commands");
    f.text("label", label);
    const Json* commands = f.find("commands");
    if (!commands) return {};
    if (!commands->is_array()) {
      problems_.add(ErrorCode::syntax, f.path("commands"), "The value must be a list of commands.", "Write it as [ ... ].");
      return {};
    }
    count_ += commands->size();
    if (count_ > max_commands) {
      problems_.add(ErrorCode::range, f.path("commands"), "The group has more than " + std::to_string(max_commands) + " commands.",
                    "Split it into smaller groups.");
      return {};
    }
    for (std::size_t i = 0; i < commands->size() && problems_.empty(); ++i)
      apply((*commands)[i], f.path("commands") + "/" + std::to_string(i));
    return label.empty() ? "Change" : label.substr(0, 200);
  }

  const Catalogue& catalogue_;
  std::uint64_t& next_id_;
  CommandEffect effect_;
  std::string inner_;  ///< id of the inner scenario in which commands act; empty: the document
  Error problems_;
  std::size_t count_ = 0;
};

const std::array<Work::Kind, 46> Work::kinds = {{{"clip.add", &Work::clip_add},
                                                 {"clip.set", &Work::clip_set},
                                                 {"clip.remove", &Work::clip_remove},
                                                 {"clip.split", &Work::clip_split},
                                                 {"layer.add", &Work::layer_add},
                                                 {"layer.set", &Work::on_clip<set_layer>},
                                                 {"layer.remove", &Work::on_clip<remove_layer>},
                                                 {"layer.move", &Work::on_clip<move_layer>},
                                                 {"key.edit", &Work::on_clip<edit_keys>},
                                                 {"character.add", &Work::character_add},
                                                 {"character.set", &Work::character_set},
                                                 {"character.remove", &Work::character_remove},
                                                 {"event.add", &Work::event_add},
                                                 {"event.set", &Work::event_set},
                                                 {"event.remove", &Work::event_remove},
                                                 {"marker.add", &Work::add_item<add_marker>},
                                                 {"marker.set", &Work::on_document<set_marker>},
                                                 {"marker.remove", &Work::on_document<remove_marker>},
                                                 {"rule.add", &Work::rule_add},
                                                 {"rule.set", &Work::rule_set},
                                                 {"rule.move", &Work::rule_move},
                                                 {"rule.remove", &Work::rule_remove},
                                                 {"variable.add", &Work::add_item<add_variable>},
                                                 {"variable.set", &Work::on_document<set_variable>},
                                                 {"variable.remove", &Work::variable_remove},
                                                 {"pose.add", &Work::pose_add},
                                                 {"pose.set", &Work::on_root<set_pose>},
                                                 {"pose.remove", &Work::on_root<remove_pose>},
                                                 {"track.move", &Work::track_move},
                                                 {"camera.add", &Work::add_item<add_camera>},
                                                 {"camera.set", &Work::on_document<set_camera>},
                                                 {"camera.remove", &Work::on_document<remove_camera>},
                                                 {"shot.add", &Work::add_item<add_shot>},
                                                 {"shot.set", &Work::on_document<set_shot>},
                                                 {"shot.remove", &Work::on_document<remove_shot>},
                                                 {"scenario.set", &Work::scenario_set},
                                                 {"circuit.set", &Work::circuit_set},
                                                 {"circuit.edit", &Work::circuit_edit},
                                                 {"scenario.nest", &Work::add_nest<nest_tracks>},
                                                 {"scenario.remove", &Work::on_nest<remove_scenario>},
                                                 {"instance.add", &Work::add_nest<add_instance>},
                                                 {"instance.set", &Work::on_nest<set_instance>},
                                                 {"instance.remove", &Work::on_nest<remove_instance>},
                                                 {"instance.unnest", &Work::add_nest<unnest_instance>},
                                                 {"in", &Work::in_scenario},
                                                 {"group", &Work::group}}};

}  // namespace

Result<CommandEffect> apply_command(const Scenario& scenario, std::string_view command, const Catalogue& catalogue,
                                    std::uint64_t& next_id) {
  const Result<Json> json = parse_json(command, "command", max_command_size);
  if (!json) return fail(json.error());
  std::uint64_t counter = next_id;
  Work work(scenario, catalogue, counter);
  std::string label = work.apply(*json, "command");
  Result<CommandEffect> effect = work.finish(std::move(label));
  if (effect) next_id = counter;
  return effect;
}

std::vector<std::string_view> command_types() {
  std::vector<std::string_view> types;
  for (const Work::Kind& kind : Work::kinds) types.push_back(kind.type);
  return types;
}

}  // namespace ugoki::content
