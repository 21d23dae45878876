#include "ugoki/content/scenario.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <set>

#include "ugoki/base/number.h"
#include "ugoki/content/film_json.h"
#include "ugoki/content/flatten.h"
#include "ugoki/content/generate.h"
#include "ugoki/content/layers.h"
#include "ugoki/content/poses.h"
#include "ugoki/content/scenario_json.h"

namespace ugoki::content {
namespace {

constexpr double day = 86400;  // s: upper limit of times and durations

/// Checks the own items of one scenario and collects their problems.
class Checker {
 public:
  /// @param flat  the flattened scenario, to which references are resolved
  /// @param nests  the document has inner scenarios; otherwise items may have ids of a flattened document
  Checker(const Scenario& scenario, const Scenario& flat, bool nests, const Catalogue* catalogue, std::string_view name, Error& problems)
      : s_(scenario), flat_(flat), nests_(nests), catalogue_(catalogue), root_(name), problems_(problems) {}

  /// @param inner  true: an inner scenario, whose settings are those of the document
  void check(bool inner) {
    check_own_settings();
    if (!inner) check_settings();
    for (std::size_t i = 0; i < s_.instances.size(); ++i) check_instance(s_.instances[i], root_ + "/instances/" + std::to_string(i));
    for (std::size_t i = 0; i < s_.characters.size(); ++i) check_character(s_.characters[i], root_ + "/characters/" + std::to_string(i));
    for (std::size_t i = 0; i < s_.events.size(); ++i) check_event(s_.events[i], root_ + "/events/" + std::to_string(i));
    for (std::size_t i = 0; i < s_.markers.size(); ++i) check_marker(s_.markers[i], root_ + "/markers/" + std::to_string(i));
    for (std::size_t i = 0; i < s_.cameras.size(); ++i) check_own_id(root_ + "/cameras/" + std::to_string(i) + "/id", s_.cameras[i].id);
    for (std::size_t i = 0; i < s_.shots.size(); ++i) check_own_id(root_ + "/shots/" + std::to_string(i) + "/id", s_.shots[i].id);
    check_film(s_, flat_, root_, problems_);
    for (std::size_t i = 0; i < s_.rules.size(); ++i) {
      const std::string location = root_ + "/rules/" + std::to_string(i);
      check_own_id(location + "/id", s_.rules[i].id);
      check_rule(s_.rules[i], flat_, catalogue_, location, problems_);
    }
    for (std::size_t i = 0; i < s_.variables.size(); ++i) {
      const std::string location = root_ + "/variables/" + std::to_string(i);
      check_own_id(location + "/id", s_.variables[i].id);
      check_name(location + "/name", s_.variables[i].name);
      check_variable(s_.variables[i], location, problems_);
    }
    for (std::size_t i = 0; i < s_.poses.size(); ++i) {
      const std::string location = root_ + "/poses/" + std::to_string(i);
      check_own_id(location + "/id", s_.poses[i].id);
      check_name(location + "/name", s_.poses[i].name);
      check_pose(s_.poses[i], location, problems_);
    }
    for (std::size_t i = 0; i < s_.track_order.size(); ++i)
      check_character_id(root_ + "/track_order/" + std::to_string(i), s_.track_order[i]);
  }

 private:
  void range(const std::string& location, double value, double low, double high, std::string_view unit) {
    if (value >= low && value <= high) return;
    problems_.add(
        ErrorCode::range, location, "The value " + ugoki::to_text(value) + " is out of range.",
        "Give a value from " + ugoki::to_text(low) + " to " + ugoki::to_text(high) + (unit.empty() ? "." : " " + std::string(unit) + "."));
  }
  void vector_range(const std::string& location, const Vec3& v, double maximum, std::string_view unit) {
    for (int i = 0; i < 3; ++i) range(location, v[i], -maximum, maximum, unit);
  }
  void check_name(const std::string& location, std::string_view value) {
    if (value.empty() || value.size() > 200)
      problems_.add(ErrorCode::range, location, "The name is empty or longer than 200 bytes.", "Give it a short name.");
  }
  void check_color(const std::string& location, std::string_view value) {
    if (!is_color(value))
      problems_.add(ErrorCode::syntax, location, "'" + std::string(value) + "' is not a colour.",
                    "Write it as #rrggbb, for example #e6e6ea.");
  }
  void check_own_id(const std::string& location, const std::string& id) {
    if (nests_ ? !is_id(id) : !is_item_id(id))
      problems_.add(ErrorCode::syntax, location, "'" + id + "' cannot be an id.", "Use 1 to 40 letters, digits, '-', '_' or '.'.");
    else if (!ids_.insert(id).second)
      problems_.add(ErrorCode::duplicate, location, "Two items of the document have the id '" + id + "'.", "Give each item its own id.");
  }

  void check_settings() {
    constexpr std::array<double, 6> rates = {24, 25, 30, 50, 60, 120};
    if (std::find(rates.begin(), rates.end(), s_.frame_rate) == rates.end())
      problems_.add(ErrorCode::range, root_ + "/frame_rate", ugoki::to_text(s_.frame_rate) + " is not a display frame rate.",
                    "Use 24, 25, 30, 50, 60 or 120.");
    range(root_ + "/step", s_.step, 0.0005, 0.004, "s");
    vector_range(root_ + "/gravity", s_.gravity, 1000, "m/s^2");
    range(root_ + "/ground/height", s_.ground.height, -1000, 1000, "m");
    range(root_ + "/ground/friction", s_.ground.friction, 0, 10, "");
    range(root_ + "/ground/restitution", s_.ground.restitution, 0, 1, "");
    check_look(s_.look, root_ + "/look", problems_);
  }

  void check_own_settings() {
    check_name(root_ + "/name", s_.name);
    range(root_ + "/duration", s_.duration, 0.001, day, "s");
    range(root_ + "/camera/distance", s_.camera.distance, 0.05, 1000, "m");
    range(root_ + "/camera/azimuth", s_.camera.azimuth, -1000, 1000, "rad");
    range(root_ + "/camera/elevation", s_.camera.elevation, -1.6, 1.6, "rad");
    range(root_ + "/range/from", s_.range.from, 0, day, "s");
    range(root_ + "/range/to", s_.range.to, 0, day, "s");
    if (s_.range != ScenarioRange{} && !s_.range.is_set())
      problems_.add(ErrorCode::range, root_ + "/range",
                    "The range ends at " + ugoki::to_text(s_.range.to) + " s, but begins at " + ugoki::to_text(s_.range.from) + " s.",
                    "Choose an end after the begin, or remove the range with null.");
    if (!s_.camera.follow.empty()) check_character_id(root_ + "/camera/follow", s_.camera.follow);
  }

  void check_character_id(const std::string& location, const std::string& id) {
    if (!flat_.find_character(id))
      problems_.add(ErrorCode::unknown, location, "There is no character '" + id + "'.",
                    "Name a character of the document, or remove this reference.");
  }

  /// Reports a mesh that the project does not contain, and a mechanism that is no mesh body.
  bool check_mesh(const std::string& id, const std::string& location) {
    const auto it = catalogue_->mechanisms.find(id);
    if (it == catalogue_->mechanisms.end())
      problems_.add(ErrorCode::unknown, location, "The project has no mesh '" + id + "'.", "Import the mesh file, and choose it.");
    else if (!it->second.mesh_body)
      problems_.add(ErrorCode::unsupported, location, "The mechanism '" + it->second.name + "' is not made from a mesh file.",
                    "Choose a mesh that was imported from a .glb, .obj, .stl, .ply or .dae file, or add the mechanism as a character.");
    else
      return true;
    return false;
  }

  void check_character(const ScenarioCharacter& c, const std::string& location) {
    check_own_id(location + "/id", c.id);
    check_name(location + "/name", c.name);
    check_color(location + "/color", c.color);
    if (c.group.size() > 200)
      problems_.add(ErrorCode::range, location + "/group", "The name is longer than 200 bytes.", "Give it a short name.");
    vector_range(location + "/place", {c.place.x, c.place.y, c.place.z}, 10000, "m");
    range(location + "/place/heading", c.place.heading, -36000, 36000, "degrees");
    range(location + "/control/tracking", c.control.tracking, 0, 2, "");
    range(location + "/control/balance", c.control.balance, 0, 2, "");
    range(location + "/control/assist_limit", c.control.assist_limit, 0, 10, "body weights");
    range(location + "/control/swing", c.control.swing, 0, 90, "degrees");
    const MechanismFacts* mechanism = nullptr;
    if (c.prop) {
      const std::size_t before = problems_.problems.size();
      check_prop(*c.prop, location + "/prop", problems_);
      if (problems_.problems.size() > before) return;
      if (catalogue_ && c.prop->shape == PropShape::mesh && !check_mesh(c.prop->mesh, location + "/prop/mesh")) return;
      if (c.control.mode != ControlMode::passive || !c.track.empty())
        problems_.add(ErrorCode::structure, location, "The prop '" + c.name + "' has a track or a control mode other than \"passive\".",
                      "Remove its clips, and set the mode \"passive\".");
    }
    if (!is_id(c.mechanism, max_resource_id)) {
      problems_.add(ErrorCode::syntax, location + "/mechanism", "'" + c.mechanism + "' cannot be the id of a mechanism.",
                    "Choose a mechanism from the library.");
    } else if (catalogue_) {
      const auto it = catalogue_->mechanisms.find(c.mechanism);
      if (it == catalogue_->mechanisms.end())
        problems_.add(ErrorCode::unknown, location + "/mechanism", "The project has no mechanism '" + c.mechanism + "'.",
                      "Import it, or choose another one.");
      else
        mechanism = &it->second;
    }
    check_material(c.material, mechanism, location, problems_);
    if (c.control.mode == ControlMode::torque) check_torque_track(c, location);
    for (std::size_t i = 0; i < c.secondary.size(); ++i) {
      const ScenarioSecondary& s = c.secondary[i];
      const std::string at = location + "/secondary/" + std::to_string(i);
      check_link(at + "/link", s.link, mechanism);
      range(at + "/frequency", s.frequency, 0.05, 50, "Hz");
      range(at + "/damping", s.damping, 0, 10, "");
    }
    for (std::size_t i = 0; i < c.track.size(); ++i) {
      const std::string clip_location = location + "/track/" + std::to_string(i);
      check_clip(c.track[i], mechanism, clip_location);
      if (i > 0 && !(c.track[i].start > c.track[i - 1].start))
        problems_.add(ErrorCode::structure, clip_location + "/start",
                      "Clips '" + c.track[i - 1].id + "' and '" + c.track[i].id + "' start at the same time.", "Move one of them.");
    }
  }

  /// Checks the track of a character in the mode `torque`: one clip, which plays a torque-oriented motion as it is.
  void check_torque_track(const ScenarioCharacter& c, const std::string& location) {
    if (c.track.size() != 1 || c.track[0].start != 0 || c.track[0].offset != 0 || c.track[0].speed != 1 || c.track[0].loop) {
      problems_.add(ErrorCode::structure, location + "/track",
                    "Character '" + c.id +
                        "' has the control mode \"torque\", but its track is not one clip that starts at 0 s with "
                        "offset 0 and speed 1 and does not loop.",
                    "Torques continue from one first state: keep one such clip, or choose another control mode.");
      return;
    }
    if (!catalogue_) return;
    const auto it = catalogue_->motions.find(c.track[0].motion);
    if (it == catalogue_->motions.end()) return;
    const double step = it->second.torque_step;
    if (step == 0)
      problems_.add(ErrorCode::structure, location + "/track/0/motion", "Motion '" + it->second.name + "' has no torques.",
                    "Convert it with `ugoki motion torques`, or choose another control mode.");
    else if (std::fabs(step - s_.step) > 1e-9)
      problems_.add(ErrorCode::structure, root_ + "/step",
                    "The torques of motion '" + it->second.name + "' are for steps of " + ugoki::to_text(step) +
                        " s; the scenario has steps of " + ugoki::to_text(s_.step) + " s.",
                    "Set the step of the scenario to " + ugoki::to_text(step) + ", or convert the motion to torques again.");
  }

  void check_clip(const ScenarioClip& clip, const MechanismFacts* mechanism, const std::string& location) {
    check_own_id(location + "/id", clip.id);
    range(location + "/start", clip.start, 0, day, "s");
    range(location + "/length", clip.length, 0.001, day, "s");
    range(location + "/offset", clip.offset, 0, day, "s");
    range(location + "/speed", clip.speed, 0.01, 100, "");
    range(location + "/blend", clip.blend, 0, 60, "s");
    check_layers(clip.layers, mechanism, location + "/layers", problems_);
    if (clip.gait) check_gait_recipe(*clip.gait, location + "/gait", problems_);
    if (!is_id(clip.motion, max_resource_id)) {
      problems_.add(ErrorCode::syntax, location + "/motion", "'" + clip.motion + "' cannot be the id of a motion.",
                    "Choose a motion from the library.");
      return;
    }
    if (!catalogue_) return;
    const auto it = catalogue_->motions.find(clip.motion);
    if (it == catalogue_->motions.end()) {
      problems_.add(ErrorCode::unknown, location + "/motion", "The project has no motion '" + clip.motion + "'.",
                    "Import it, or choose another one.");
      return;
    }
    const MotionFacts& motion = it->second;
    if (mechanism && motion.nq != mechanism->nq)
      problems_.add(ErrorCode::structure, location + "/motion",
                    "Motion '" + motion.name + "' has " + std::to_string(motion.nq) + " coordinates, mechanism '" + mechanism->name +
                        "' has " + std::to_string(mechanism->nq) + ".",
                    "Use a motion that was made for this mechanism.");
    if (clip.loop && !motion.cyclic)
      problems_.add(ErrorCode::structure, location + "/loop", "Motion '" + motion.name + "' is not cyclic, so it cannot be looped.",
                    "Switch loop off, or use a cyclic motion.");
    // s: after dragging and rounding, a clip may exceed the motion's end by this time; then it holds the last frame
    constexpr double slack = 0.01;
    const double needed = clip.offset + clip.length * clip.speed;
    if (!clip.loop && needed > motion.duration + slack)
      problems_.add(ErrorCode::range, location + "/length",
                    "The clip needs " + to_fixed(needed, 2) + " s of motion '" + motion.name + "', which lasts " +
                        to_fixed(motion.duration, 2) + " s.",
                    motion.cyclic ? "Shorten it, slow it down or loop it." : "Shorten it or slow it down.");
    else if (clip.offset > motion.duration + slack)
      problems_.add(ErrorCode::range, location + "/offset",
                    "The clip begins after the end of motion '" + motion.name + "' (" + to_fixed(motion.duration, 2) + " s).",
                    "Give a smaller offset.");
  }

  void check_instance(const ScenarioInstance& i, const std::string& location) {
    check_own_id(location + "/id", i.id);
    check_name(location + "/name", i.name);
    range(location + "/start", i.start, 0, day, "s");
    vector_range(location + "/place", {i.place.x, i.place.y, i.place.z}, 10000, "m");
    range(location + "/place/heading", i.place.heading, -36000, 36000, "degrees");
  }

  void check_marker(const ScenarioMarker& m, const std::string& location) {
    check_own_id(location + "/id", m.id);
    range(location + "/time", m.time, 0, day, "s");
    check_name(location + "/name", m.name);
  }

  [[nodiscard]] const MechanismFacts* mechanism_of(const ScenarioCharacter* character) const {
    if (!character || !catalogue_) return nullptr;
    const auto it = catalogue_->mechanisms.find(character->mechanism);
    return it == catalogue_->mechanisms.end() ? nullptr : &it->second;
  }
  void check_link(const std::string& location, const std::string& link, const MechanismFacts* mechanism) {
    const auto has = [&](const std::vector<std::string>& names) { return std::find(names.begin(), names.end(), link) != names.end(); };
    if (link.empty())
      problems_.add(ErrorCode::structure, location, "The event names no link.", "Name the link on which it acts.");
    else if (mechanism && !has(mechanism->links) && !has(mechanism->labels))
      problems_.add(ErrorCode::unknown, location, "Mechanism '" + mechanism->name + "' has no link '" + link + "'.",
                    "Name one of its links.");
  }
  void check_grip(const ScenarioEvent& e, const std::string& location) {
    vector_range(location + "/point", e.grip.point, 100, "m");
    vector_range(location + "/at", e.grip.at, 10000, "m");
    range(location + "/limit", e.grip.limit, 1, 1e6, "N");
    range(location + "/reach", e.grip.reach, 0, 10, "m");
    if (e.grip.other.empty()) {
      if (!e.grip.other_link.empty())
        problems_.add(ErrorCode::structure, location + "/other_link", "The grip names a link, but no character that has the link.",
                      "Name the character in \"other\", or omit the link to grip the world.");
      return;
    }
    const ScenarioCharacter* const other = flat_.find_character(e.grip.other);
    if (!other) check_character_id(location + "/other", e.grip.other);
    check_link(location + "/other_link", e.grip.other_link, mechanism_of(other));
    if (e.grip.other == e.character && e.grip.other_link == e.link)
      problems_.add(ErrorCode::structure, location + "/other_link", "The link grips itself.", "Name another link.");
  }

  void check_path(const ScenarioEvent& e, const std::string& location) {
    if (e.path.empty() || e.path.front().time != 0)
      problems_.add(ErrorCode::structure, location, "The pull has no target at its begin.", "Give a first target with the time 0.");
    for (std::size_t i = 0; i < e.path.size(); ++i) {
      const std::string at = location + "/" + std::to_string(i);
      vector_range(at, e.path[i].at, 10000, "m");
      if (i > 0 && !(e.path[i].time > e.path[i - 1].time))
        problems_.add(ErrorCode::structure, at, "The target is not later than the one before it.", "Sort the targets by time.");
      range(at, e.path[i].time, 0, day, "s");
    }
  }

  void check_event(const ScenarioEvent& e, const std::string& location) {
    check_own_id(location + "/id", e.id);
    range(location + "/time", e.time, 0, day, "s");
    const ScenarioCharacter* character = flat_.find_character(e.character);
    if (!character) check_character_id(location + "/character", e.character);
    const MechanismFacts* mechanism = nullptr;
    if (character && catalogue_)
      if (const auto it = catalogue_->mechanisms.find(character->mechanism); it != catalogue_->mechanisms.end()) mechanism = &it->second;
    if (e.type == EventType::push) {
      range(location + "/duration", e.duration, 0.0005, 3600, "s");
      vector_range(location + "/force", e.force, 1e6, "N");
      const auto has = [&](const std::vector<std::string>& names) { return std::find(names.begin(), names.end(), e.link) != names.end(); };
      if (e.link.empty())
        problems_.add(ErrorCode::structure, location + "/link", "The push names no link.", "Name the link that is pushed.");
      else if (mechanism && !has(mechanism->links) && !has(mechanism->labels))
        problems_.add(ErrorCode::unknown, location + "/link", "Mechanism '" + mechanism->name + "' has no link '" + e.link + "'.",
                      "Name one of its links.");
      return;
    }
    if (e.type == EventType::pull) {
      range(location + "/duration", e.duration, 0.0005, 3600, "s");
      vector_range(location + "/point", e.point, 100, "m");
      check_link(location + "/link", e.link, mechanism);
      check_path(e, location + "/path");
      return;
    }
    if (e.type == EventType::grab || e.type == EventType::release) {
      check_link(location + "/link", e.link, mechanism);
      if (e.type == EventType::grab) check_grip(e, location);
      return;
    }
    vector_range(location + "/from", e.from, 10000, "m");
    vector_range(location + "/velocity", e.velocity, 1000, "m/s");
    vector_range(location + "/spin", e.spin, 1000, "rad/s");
    if (character && character->control.mode != ControlMode::passive)
      problems_.add(ErrorCode::structure, location + "/character",
                    "Character '" + e.character + "' follows a track, so it cannot be thrown.",
                    "Throw a passive character, or set its control mode to passive.");
    if (mechanism && !mechanism->free_root)
      problems_.add(ErrorCode::structure, location + "/character",
                    "Mechanism '" + mechanism->name + "' is fixed to the world, so it cannot be thrown.",
                    "Choose a character whose mechanism has a floating root.");
  }

  const Scenario& s_;
  const Scenario& flat_;
  bool nests_;
  const Catalogue* catalogue_;
  std::string root_;
  Error& problems_;
  std::set<std::string> ids_;
};

template <class Read>
void read_list(Fields& parent, std::string_view key, Read read) {
  const Json* list = parent.list(key, 10'000, key);
  if (!list) return;
  for (std::size_t i = 0; i < list->size(); ++i) {
    Fields fields((*list)[i], parent.path(key) + "/" + std::to_string(i), parent.problems());
    read(fields);
    fields.refuse_others();
  }
}

/// Reads a list of texts.
void read_texts(Fields& f, std::string_view key, std::string_view meaning, std::vector<std::string>& out) {
  const Json* list = f.list(key, 10'000, meaning);
  if (!list) return;
  for (const Json& id : *list) {
    if (id.is_string())
      out.push_back(id.get<std::string>());
    else
      f.report(ErrorCode::syntax, f.path(key), "The list contains a value that is not a text.", "Give " + std::string(meaning) + ".");
  }
}

/// Reads the lists of items of a document or of an inner scenario.
void read_items(Fields& f, Scenario& s) {
  read_list(f, "characters", [&](Fields& g) {
    ScenarioCharacter c;
    read_character(g, c);
    read_list(g, "track", [&](Fields& h) {
      h.require("length", "its length in seconds");
      read_clip(h, c.track.emplace_back());
    });
    if (c.name.empty()) c.name = c.id;
    s.characters.push_back(std::move(c));
  });
  read_list(f, "events", [&](Fields& g) {
    g.require("type", "\"push\", \"pull\", \"throw\", \"grab\" or \"release\"");
    read_event(g, s.events.emplace_back());
  });
  read_list(f, "markers", [&](Fields& g) { read_marker(g, s.markers.emplace_back()); });
  read_list(f, "rules", [&](Fields& g) { read_rule(g, s.rules.emplace_back()); });
  read_list(f, "variables", [&](Fields& g) { read_variable(g, s.variables.emplace_back()); });
  read_list(f, "instances", [&](Fields& g) {
    ScenarioInstance& instance = s.instances.emplace_back();
    g.require("id", "the id of the instance");
    g.require("scenario", "the id of an inner scenario");
    read_instance(g, instance);
    if (instance.name.empty()) instance.name = instance.id;
  });
  read_texts(f, "track_order", "ids of characters", s.track_order);
  read_texts(f, "order", "ids of characters, rules and variables", s.order);
  read_film(f, s);
}

}  // namespace

const ScenarioCharacter* Scenario::find_character(std::string_view wanted) const {
  for (const ScenarioCharacter& c : characters)
    if (c.id == wanted) return &c;
  return nullptr;
}
ScenarioCharacter* Scenario::find_character(std::string_view wanted) {
  for (ScenarioCharacter& c : characters)
    if (c.id == wanted) return &c;
  return nullptr;
}

const Scenario* Scenario::find_scenario(std::string_view wanted) const {
  for (const Scenario& inner : scenarios)
    if (inner.id == wanted) return &inner;
  return nullptr;
}
Scenario* Scenario::find_scenario(std::string_view wanted) {
  for (Scenario& inner : scenarios)
    if (inner.id == wanted) return &inner;
  return nullptr;
}

bool is_item_id(std::string_view text) {
  for (std::size_t slash = text.find('/'); slash != std::string_view::npos; slash = text.find('/')) {
    if (!is_id(text.substr(0, slash))) return false;
    text.remove_prefix(slash + 1);
  }
  return is_id(text);
}

bool is_id(std::string_view text, std::size_t max_size) {
  return !text.empty() && text.size() <= max_size && std::all_of(text.begin(), text.end(), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '-' || c == '_' || c == '.';
  });
}

void put_in_order(Scenario& scenario) {
  for (ScenarioCharacter& c : scenario.characters)
    std::sort(c.track.begin(), c.track.end(),
              [](const auto& a, const auto& b) { return a.start != b.start ? a.start < b.start : a.id < b.id; });
  const auto last_part = [](const std::string& id) { return std::string_view(id).substr(id.rfind('/') + 1); };
  std::sort(scenario.events.begin(), scenario.events.end(), [&](const auto& a, const auto& b) {
    if (a.time != b.time) return a.time < b.time;
    const std::string_view last_a = last_part(a.id), last_b = last_part(b.id);
    return last_a != last_b ? last_a < last_b : a.id < b.id;
  });
  std::sort(scenario.markers.begin(), scenario.markers.end(),
            [](const auto& a, const auto& b) { return a.time != b.time ? a.time < b.time : a.id < b.id; });
  put_in_order(scenario.cameras, scenario.shots);
  for (Scenario& inner : scenario.scenarios) put_in_order(inner);
}

Scenario played_part(Scenario document) {
  Scenario s = flatten(document);
  const bool any_solo = std::any_of(s.characters.begin(), s.characters.end(), [](const ScenarioCharacter& c) { return c.solo; });
  const auto out = [&](const ScenarioCharacter& c) { return c.muted || (any_solo && !c.solo); };
  std::vector<std::string> left_out;
  for (const ScenarioCharacter& c : s.characters)
    if (out(c)) left_out.push_back(c.id);
  std::erase_if(s.characters, out);
  std::erase_if(s.events, [&](const ScenarioEvent& e) {
    return !s.find_character(e.character) || (!e.grip.other.empty() && !s.find_character(e.grip.other));
  });
  for (const std::string& id : left_out) remove_rules_of(s, id);
  if (!s.find_character(s.camera.follow)) s.camera.follow.clear();
  for (FilmCamera& camera : s.cameras)
    if (!s.find_character(camera.follow)) camera.follow.clear();
  for (ScenarioCharacter& c : s.characters) {
    c.solo = c.locked = false;
    c.group.clear();
  }
  s.markers.clear();
  s.poses.clear();
  s.track_order.clear();
  s.range = {};
  return s;
}

Result<Scenario> read_scenario(std::string_view text, std::string_view name) {
  Result<Json> json = parse_json(text, name);
  if (!json) return fail(std::move(json.error()));
  Error problems;
  Scenario s;
  Fields f(*json, std::string(name), problems);
  int version = scenario_version;
  f.require("version", "\"version\": 1");
  f.integer("version", version);
  if (version > scenario_version)
    return fail(
        ErrorCode::unsupported, f.path("version"),
        "The document has version " + std::to_string(version) + "; this program reads version " + std::to_string(scenario_version) + ".",
        "Open it with a newer Ugoki.");
  if (version < 1)
    problems.add(ErrorCode::range, f.path("version"), "The version " + std::to_string(version) + " does not exist.",
                 "Write \"version\": 1.");
  read_settings(f, s);
  read_items(f, s);
  read_list(f, "poses", [&](Fields& g) {
    g.require("joints", "a list of joints");
    read_pose(g, s.poses.emplace_back());
  });
  read_list(f, "scenarios", [&](Fields& g) {
    Scenario& inner = s.scenarios.emplace_back();
    g.require("id", "the id of the inner scenario");
    g.text("id", inner.id);
    inner.name = inner.id;
    read_inner_settings(g, inner);
    read_items(g, inner);
  });
  read_circuit_field(f, s);
  f.refuse_others();
  if (!problems.empty()) return fail(std::move(problems));
  put_in_order(s);
  problems = check_scenario(s, nullptr, name);
  if (!problems.empty()) return fail(std::move(problems));
  return s;
}
std::string write_scenario(const Scenario& scenario) { return to_text(to_json(scenario), 2) + "\n"; }

Error check_scenario(const Scenario& scenario, const Catalogue* catalogue, std::string_view name) {
  Error problems;
  Catalogue with_props;
  const auto add_prop = [&](const ScenarioCharacter& c) {
    Error unused;
    if (!catalogue || !c.prop) return;
    check_prop(*c.prop, "", unused);
    if (!unused.empty()) return;
    if (catalogue != &with_props) with_props = *catalogue;
    catalogue = &with_props;
    if (c.prop->shape != PropShape::mesh) {
      with_props.mechanisms.emplace(c.mechanism, facts_of(*make_prop(*c.prop)));
    } else if (const auto mesh = with_props.mechanisms.find(c.prop->mesh); mesh != with_props.mechanisms.end()) {
      MechanismFacts facts = mesh->second;
      facts.mesh_body = false;
      facts.free_root = c.prop->mass > 0;
      facts.joints = {facts.free_root ? JointType::floating : JointType::fixed};
      facts.nq = facts.free_root ? 7 : 0;
      with_props.mechanisms.emplace(c.mechanism, std::move(facts));
    }
  };
  for_each_scenario(scenario, [&](const Scenario& s) { std::ranges::for_each(s.characters, add_prop); });
  const std::string root(name);
  check_instances(scenario, root, problems);
  if (!problems.empty()) return problems;
  const bool nested = !scenario.instances.empty(), nests = nested || !scenario.scenarios.empty();
  const Scenario flat = nested ? flatten(scenario) : Scenario();
  Checker(scenario, nested ? flat : scenario, nests, catalogue, name, problems).check(false);
  for (std::size_t i = 0; i < scenario.scenarios.size(); ++i) {
    const Scenario& inner = scenario.scenarios[i];
    Checker(inner, flatten(open_scenario(scenario, inner.id)), true, catalogue, root + "/scenarios/" + std::to_string(i), problems)
        .check(true);
  }
  // Values can leave their range only when an instance moves or shifts them.
  if (nested && problems.empty()) Checker(flat, flat, false, catalogue, root + ", flattened", problems).check(false);
  return problems;
}

}  // namespace ugoki::content
