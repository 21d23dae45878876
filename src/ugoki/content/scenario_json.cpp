#include "ugoki/content/scenario_json.h"

#include "ugoki/circuit/migrate.h"
#include "ugoki/content/film_json.h"
#include "ugoki/content/gait_recipe_json.h"
#include "ugoki/content/layers.h"
#include "ugoki/content/poses.h"
#include "ugoki/content/prop_json.h"

namespace ugoki::content {
namespace {

constexpr std::size_t max_pull_targets = 100'000;  // a mouse sends up to 1000 positions a second

/// Calls read(fields) with the fields of the object `key`, if it is present.
template <class Read>
void read_object(Fields& parent, std::string_view key, Read read) {
  const Json* object = parent.find(key);
  if (!object) return;
  Fields fields(*object, parent.path(key), parent.problems());
  read(fields);
  fields.refuse_others();
}

void read_camera(Fields& f, ScenarioCamera& out) {
  if (const Json* follow = f.find("follow"); follow && follow->is_null())
    out.follow.clear();
  else
    f.text("follow", out.follow);
  f.number("distance", out.distance);
  f.number("azimuth", out.azimuth);
  f.number("elevation", out.elevation);
}

}  // namespace

std::string_view name_of(ControlMode mode) {
  switch (mode) {
    case ControlMode::track: return "track";
    case ControlMode::passive: return "passive";
    case ControlMode::path: return "path";
    case ControlMode::torque: return "torque";
  }
  return "track";
}

std::string_view name_of(EventType type) {
  switch (type) {
    case EventType::push: return "push";
    case EventType::throw_: return "throw";
    case EventType::grab: return "grab";
    case EventType::release: return "release";
    case EventType::pull: return "pull";
  }
  return "push";
}

std::string_view name_of(PushAxes axes) { return axes == PushAxes::body ? "body" : "world"; }

void read_axes(Fields& f, PushAxes& out) {
  std::string axes(name_of(out));
  f.text("axes", axes);
  if (axes != "world" && axes != "body")
    f.report(ErrorCode::unsupported, f.path("axes"), "There are no axes '" + axes + "'.", "Use \"world\" or \"body\".");
  out = axes == "body" ? PushAxes::body : PushAxes::world;
}

void read_clip(Fields& f, ScenarioClip& out) {
  f.text("id", out.id);
  f.text("motion", out.motion);
  f.number("start", out.start);
  f.number("length", out.length);
  f.number("offset", out.offset);
  f.number("speed", out.speed);
  f.number("blend", out.blend);
  f.boolean("loop", out.loop);
  if (f.has("layers")) read_layers(f, out.layers);
  if (const Json* gait = f.find("gait"); gait && gait->is_null())
    out.gait.reset();
  else if (gait)
    read_gait_recipe(*gait, f.path("gait"), out.gait.emplace(), f.problems());
}

void read_place(Fields& f, ScenarioPlace& out) {
  f.number("x", out.x);
  f.number("y", out.y);
  f.number("z", out.z);
  f.number("heading", out.heading);
}

void read_control(Fields& f, ScenarioControl& out) {
  std::string mode(name_of(out.mode)), beyond = "release";
  f.text("mode", mode);
  bool known = false;
  for (const ControlMode m : {ControlMode::track, ControlMode::passive, ControlMode::path, ControlMode::torque}) {
    if (mode != name_of(m)) continue;
    out.mode = m;
    known = true;
  }
  if (!known)
    f.report(ErrorCode::unknown, f.path("mode"), "There is no control mode '" + mode + "'.",
             "Use \"track\", \"passive\", \"path\" or \"torque\".");
  f.number("tracking", out.tracking);
  f.number("balance", out.balance);
  f.number("assist_limit", out.assist_limit);
  f.number("swing", out.swing);
  f.text("beyond", beyond);
  if (beyond != "release" && beyond != "let_go")  // "let_go": the former name of "release"
    f.report(ErrorCode::unknown, f.path("beyond"), "There is no action '" + beyond + "' beyond the assist limit.", "Use \"release\".");
}

namespace {

void read_secondary(Fields& f, ScenarioSecondary& out) {
  std::string rest = "start";
  f.require("link", "the name of the first link of the chain");
  f.text("link", out.link);
  f.number("frequency", out.frequency);
  f.number("damping", out.damping);
  f.text("rest", rest);
  out.neutral = rest == "neutral";
  if (!out.neutral && rest != "start")
    f.report(ErrorCode::unknown, f.path("rest"), "There is no rest pose '" + rest + "'.", "Use \"start\" or \"neutral\".");
}

}  // namespace

void read_character(Fields& f, ScenarioCharacter& out) {
  f.text("id", out.id);
  f.text("name", out.name);
  f.text("mechanism", out.mechanism);
  f.text("color", out.color);
  read_material(f, out.material);
  f.boolean("muted", out.muted);
  f.boolean("solo", out.solo);
  f.boolean("locked", out.locked);
  f.text("group", out.group);
  read_object(f, "place", [&](Fields& g) { read_place(g, out.place); });
  if (f.has("prop")) {
    if (!out.prop) {
      out.prop.emplace();
      out.control.mode = ControlMode::passive;
    }
    read_object(f, "prop", [&](Fields& g) { read_prop(g, *out.prop); });
    out.mechanism = prop_mechanism_id(*out.prop);
  }
  read_object(f, "control", [&](Fields& g) { read_control(g, out.control); });
  if (const Json* list = f.list("secondary", 1000, "secondary")) {
    out.secondary.clear();
    for (std::size_t i = 0; i < list->size(); ++i) {
      Fields g((*list)[i], f.path("secondary") + "/" + std::to_string(i), f.problems());
      read_secondary(g, out.secondary.emplace_back());
      g.refuse_others();
    }
  }
}

namespace {

void read_grip(Fields& f, ScenarioGrip& out) {
  f.vec3("point", out.point);
  f.text("other", out.other);
  f.text("other_link", out.other_link);
  if (const Json* at = f.find("at"); at && at->is_null()) {
    out.has_at = false;
    out.at = {};
  } else if (at) {
    out.has_at = true;
    f.vec3("at", out.at);
  }
  f.boolean("rigid", out.rigid);
  f.number("limit", out.limit);
  f.number("reach", out.reach);
}

/// Reads the targets of a pull, each a list [time, x, y, z].
void read_path(Fields& f, std::vector<PullTarget>& out) {
  const Json* list = f.list("path", max_pull_targets, "targets");
  if (!list) return;
  out.clear();
  for (std::size_t i = 0; i < list->size(); ++i) {
    std::vector<double> x(4);
    const std::string at = f.path("path") + "/" + std::to_string(i);
    const Json& target = (*list)[i];
    if (!target.is_array() || target.size() != x.size()) {
      f.report(ErrorCode::syntax, at, "The target is not a list of four numbers.", "Give [time in s, x, y, z in m].");
      continue;
    }
    if (!f.numbers(target, at, x)) continue;
    for (double& value : x) value = value == 0 ? 0 : value;  // negative zero becomes zero, so that equal documents have equal text
    out.push_back({x[0], {x[1], x[2], x[3]}});
  }
}

}  // namespace

void read_event(Fields& f, ScenarioEvent& out) {
  std::string type(name_of(out.type));
  f.text("id", out.id);
  f.text("type", type);
  bool known = false;
  for (const EventType t : {EventType::push, EventType::throw_, EventType::grab, EventType::release, EventType::pull}) {
    if (type != name_of(t)) continue;
    out.type = t;
    known = true;
  }
  if (!known)
    f.report(ErrorCode::unsupported, f.path("type"), "There is no event of type '" + type + "'.",
             "Use \"push\", \"pull\", \"throw\", \"grab\" or \"release\".");
  f.number("time", out.time);
  f.text("character", out.character);
  if (out.type == EventType::push) {
    f.number("duration", out.duration);
    f.text("link", out.link);
    f.vec3("force", out.force);
    read_axes(f, out.axes);
  } else if (out.type == EventType::pull) {
    f.number("duration", out.duration);
    f.text("link", out.link);
    f.vec3("point", out.point);
    read_path(f, out.path);
  } else if (out.type == EventType::grab || out.type == EventType::release) {
    f.text("link", out.link);
    if (out.type == EventType::grab) read_grip(f, out.grip);
  } else {
    f.vec3("from", out.from);
    f.vec3("velocity", out.velocity);
    f.vec3("spin", out.spin);
  }
}

void read_marker(Fields& f, ScenarioMarker& out) {
  f.text("id", out.id);
  f.number("time", out.time);
  f.text("name", out.name);
}

void read_instance(Fields& f, ScenarioInstance& out) {
  f.text("id", out.id);
  f.text("name", out.name);
  f.text("scenario", out.scenario);
  f.number("start", out.start);
  read_object(f, "place", [&](Fields& g) { read_place(g, out.place); });
  f.boolean("muted", out.muted);
  f.boolean("solo", out.solo);
}

void read_inner_settings(Fields& f, Scenario& out) {
  f.text("name", out.name);
  f.number("duration", out.duration);
  read_object(f, "camera", [&](Fields& g) { read_camera(g, out.camera); });
  if (const Json* range = f.find("range"); range && range->is_null()) {
    out.range = {};
  } else {
    read_object(f, "range", [&](Fields& g) {
      g.require("from", "its begin in seconds");
      g.require("to", "its end in seconds");
      g.number("from", out.range.from);
      g.number("to", out.range.to);
    });
  }
}

void read_settings(Fields& f, Scenario& out) {
  read_inner_settings(f, out);
  read_world_settings(f, out);
}

void read_world_settings(Fields& f, Scenario& out) {
  f.number("frame_rate", out.frame_rate);
  f.number("step", out.step);
  f.vec3("gravity", out.gravity);
  read_object(f, "ground", [&](Fields& g) {
    g.number("height", out.ground.height);
    g.number("friction", out.ground.friction);
    g.number("restitution", out.ground.restitution);
  });
  read_object(f, "look", [&](Fields& g) { read_look(g, out.look); });
}

void read_circuit_field(Fields& f, Scenario& out) {
  const Json* circuit = f.find("circuit");
  if (!circuit) return;
  if (circuit->is_object()) {
    Json migrated = *circuit;
    circuit::migrate(migrated);
    out.circuit = to_text(migrated);
  } else if (circuit->is_null()) {
    out.circuit.clear();
  } else {
    f.report(ErrorCode::syntax, f.path("circuit"), "The value must be a circuit or null.",
             "Give an object in the form of docs/circuit.md, or null.");
  }
}

Json to_json(const ScenarioClip& c) {
  Json json = {{"id", c.id},         {"motion", c.motion}, {"start", c.start}, {"length", c.length},
               {"offset", c.offset}, {"speed", c.speed},   {"blend", c.blend}, {"loop", c.loop}};
  if (!c.layers.empty()) {
    Json layers = Json::array();
    for (const ScenarioLayer& layer : c.layers) layers.push_back(to_json(layer));
    json["layers"] = std::move(layers);
  }
  if (c.gait) json["gait"] = to_json(*c.gait);
  return json;
}

Json to_json(const ScenarioCharacter& c) {
  Json track = Json::array();
  for (const ScenarioClip& clip : c.track) track.push_back(to_json(clip));
  Json json = {{"id", c.id},
               {"name", c.name},
               {"mechanism", c.mechanism},
               {"color", c.color},
               {"place", {{"x", c.place.x}, {"y", c.place.y}, {"z", c.place.z}, {"heading", c.place.heading}}},
               {"control",
                {{"mode", name_of(c.control.mode)},
                 {"tracking", c.control.tracking},
                 {"balance", c.control.balance},
                 {"assist_limit", c.control.assist_limit},
                 {"beyond", "release"}}},
               {"track", std::move(track)}};
  if (c.control.swing != 0) json["control"]["swing"] = c.control.swing;
  if (c.prop) json["prop"] = to_json(*c.prop);
  write_material(c.material, json);
  if (!c.secondary.empty()) {
    Json chains = Json::array();
    for (const ScenarioSecondary& s : c.secondary)
      chains.push_back({{"link", s.link}, {"frequency", s.frequency}, {"damping", s.damping}, {"rest", s.neutral ? "neutral" : "start"}});
    json["secondary"] = std::move(chains);
  }
  if (c.muted) json["muted"] = true;
  if (c.solo) json["solo"] = true;
  if (c.locked) json["locked"] = true;
  if (!c.group.empty()) json["group"] = c.group;
  return json;
}

Json to_json(const ScenarioEvent& e) {
  Json json = {{"id", e.id}, {"type", name_of(e.type)}, {"time", e.time}};
  if (e.type == EventType::push) {
    json["duration"] = e.duration;
    json["character"] = e.character;
    json["link"] = e.link;
    json["force"] = to_json(e.force);
    if (e.axes != PushAxes::world) json["axes"] = name_of(e.axes);
  } else if (e.type == EventType::pull) {
    json["duration"] = e.duration;
    json["character"] = e.character;
    json["link"] = e.link;
    json["point"] = to_json(e.point);
    Json path = Json::array();
    for (const PullTarget& t : e.path) path.push_back({t.time, t.at.x, t.at.y, t.at.z});
    json["path"] = std::move(path);
  } else if (e.type == EventType::grab || e.type == EventType::release) {
    json["character"] = e.character;
    json["link"] = e.link;
    if (e.type == EventType::release) return json;
    json["point"] = to_json(e.grip.point);
    json["other"] = e.grip.other;
    json["other_link"] = e.grip.other_link;
    json["at"] = e.grip.has_at ? to_json(e.grip.at) : Json(nullptr);
    json["rigid"] = e.grip.rigid;
    json["limit"] = e.grip.limit;
    json["reach"] = e.grip.reach;
  } else {
    json["character"] = e.character;
    json["from"] = to_json(e.from);
    json["velocity"] = to_json(e.velocity);
    json["spin"] = to_json(e.spin);
  }
  return json;
}

namespace {

Json to_json(const ScenarioPlace& p) { return {{"x", p.x}, {"y", p.y}, {"z", p.z}, {"heading", p.heading}}; }

Json to_json(const ScenarioCamera& c) {
  return {{"follow", c.follow.empty() ? Json(nullptr) : Json(c.follow)},
          {"distance", c.distance},
          {"azimuth", c.azimuth},
          {"elevation", c.elevation}};
}

Json to_json(const ScenarioInstance& i) {
  Json json = {{"id", i.id}, {"name", i.name}, {"scenario", i.scenario}, {"start", i.start}, {"place", to_json(i.place)}};
  if (i.muted) json["muted"] = true;
  if (i.solo) json["solo"] = true;
  return json;
}

template <class List, class Make>
Json list_of(const List& list, Make make) {
  Json json = Json::array();
  for (const auto& item : list) json.push_back(make(item));
  return json;
}

/// Writes the lists that are absent if they are empty, of a document or an inner scenario.
void write_items(const Scenario& s, const std::vector<ScenarioPose>& poses, Json& json) {
  const auto item = [](const auto& x) { return content::to_json(x); };
  if (s.range.is_set()) json["range"] = {{"from", s.range.from}, {"to", s.range.to}};
  if (!s.markers.empty())
    json["markers"] =
        list_of(s.markers, [](const ScenarioMarker& m) -> Json { return {{"id", m.id}, {"time", m.time}, {"name", m.name}}; });
  if (!s.rules.empty()) json["rules"] = list_of(s.rules, item);
  if (!s.variables.empty()) json["variables"] = list_of(s.variables, item);
  if (!poses.empty()) json["poses"] = list_of(poses, item);
  if (!s.track_order.empty()) json["track_order"] = s.track_order;
  write_film(s.cameras, s.shots, json);
  if (!s.instances.empty()) json["instances"] = list_of(s.instances, [](const ScenarioInstance& i) { return to_json(i); });
  if (!s.order.empty()) json["order"] = s.order;
}

Json inner_to_json(const Scenario& s) {
  const auto item = [](const auto& x) { return content::to_json(x); };
  Json json = {{"id", s.id},
               {"name", s.name},
               {"duration", s.duration},
               {"characters", list_of(s.characters, item)},
               {"events", list_of(s.events, item)}};
  if (!(s.camera == ScenarioCamera())) json["camera"] = to_json(s.camera);
  write_items(s, {}, json);
  return json;
}

}  // namespace

Json to_json(const Scenario& s) {
  const auto item = [](const auto& x) { return content::to_json(x); };
  const bool nests = !s.scenarios.empty() || !s.instances.empty();
  Json json = {{"version", nests ? scenario_version : 1},
               {"name", s.name},
               {"duration", s.duration},
               {"frame_rate", s.frame_rate},
               {"step", s.step},
               {"gravity", to_json(s.gravity)},
               {"ground", {{"height", s.ground.height}, {"friction", s.ground.friction}, {"restitution", s.ground.restitution}}},
               {"characters", list_of(s.characters, item)},
               {"events", list_of(s.events, item)},
               {"camera", to_json(s.camera)},
               {"look", to_json(s.look)},
               {"circuit", nullptr}};
  write_items(s, s.poses, json);
  if (!s.scenarios.empty()) json["scenarios"] = list_of(s.scenarios, inner_to_json);
  if (!s.circuit.empty()) json["circuit"] = Json::parse(s.circuit, nullptr, false);
  return json;
}

}  // namespace ugoki::content
