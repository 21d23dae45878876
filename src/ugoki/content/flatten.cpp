#include "ugoki/content/flatten.h"

#include <algorithm>
#include <map>
#include <set>

#include "ugoki/spatial/elementary.h"

namespace ugoki::content {
namespace {

constexpr std::size_t max_name = 200;   // bytes, see check_scenario()
constexpr std::size_t max_levels = 16;  // of instances in instances

/// The movement of the items of an instance.
class Frame {
 public:
  explicit Frame(const ScenarioPlace& place)
      : place_(place), identity_(place == ScenarioPlace{}), turn_(place.heading * (pi / 180)), cos_(cos(turn_)), sin_(sin(turn_)) {}

  [[nodiscard]] Vec3 direction(const Vec3& v) const { return identity_ ? v : Vec3{cos_ * v.x - sin_ * v.y, sin_ * v.x + cos_ * v.y, v.z}; }
  [[nodiscard]] Vec3 point(const Vec3& p) const { return identity_ ? p : direction(p) + Vec3{place_.x, place_.y, place_.z}; }
  [[nodiscard]] ScenarioPlace place(const ScenarioPlace& p) const {
    if (identity_) return p;
    const Vec3 at = point({p.x, p.y, p.z});
    return {at.x, at.y, at.z, place_.heading + p.heading};
  }
  /// @param follows  the camera follows a character: x and y of its target are relative to the character
  void move(FilmView& view, bool follows) const {
    if (identity_) return;
    const Vec3 target = follows ? direction(view.target) : point(view.target);
    view.target = {target.x, target.y, view.target.z + place_.z};
    view.azimuth += turn_;
  }

 private:
  ScenarioPlace place_;
  bool identity_;
  double turn_, cos_, sin_;
};

/// Prefixes the ids and names of the items with those of the instance.
void prefix(Scenario& s, const ScenarioInstance& instance) {
  const auto put = [&](std::string& id) { id = instance.id + "/" + id; };
  const auto name = [&](std::string& text) {
    if (instance.name.size() + 3 + text.size() <= max_name) text = instance.name + " / " + text;
  };
  for_each_reference(s, put);
  for (ScenarioCharacter& c : s.characters) {
    put(c.id);
    name(c.name);
    for (ScenarioClip& clip : c.track) put(clip.id);
  }
  for (ScenarioEvent& e : s.events) put(e.id);
  for (Rule& rule : s.rules) put(rule.id);
  for (ScenarioVariable& v : s.variables) {
    put(v.id);
    name(v.name);
  }
  for (FilmCamera& camera : s.cameras) {
    put(camera.id);
    name(camera.name);
  }
  for (FilmShot& shot : s.shots) {
    put(shot.id);
    put(shot.camera);
  }
}

template <class List>
void append(List& to, List&& from) {
  to.insert(to.end(), std::make_move_iterator(from.begin()), std::make_move_iterator(from.end()));
}

/// The scenario without instances: its own items and those of its instances. Moves deeper than `levels` are left out.
Scenario expand(const Scenario& document, const Scenario& scenario, std::size_t levels) {
  Scenario out = scenario;
  out.instances.clear();
  out.order.clear();
  out.scenarios.clear();
  if (levels == 0) return out;
  for (const ScenarioInstance& instance : scenario.instances) {
    const Scenario* const inner = document.find_scenario(instance.scenario);
    if (!inner) continue;
    Scenario part = expand(document, *inner, levels - 1);
    resolve_solo(part);
    for (ScenarioCharacter& c : part.characters) {
      c.muted = c.muted || instance.muted;
      c.solo = instance.solo;
    }
    displace(part, instance.start, instance.place);
    prefix(part, instance);
    append(out.characters, std::move(part.characters));
    append(out.events, std::move(part.events));
    append(out.rules, std::move(part.rules));
    append(out.variables, std::move(part.variables));
    append(out.cameras, std::move(part.cameras));
    // Only one shot can be shown at a time: of shots that start together, the first one counts.
    for (FilmShot& shot : part.shots)
      if (std::ranges::none_of(out.shots, [&](const FilmShot& s) { return s.start == shot.start; })) out.shots.push_back(std::move(shot));
  }
  sort_by(scenario.order, out.characters);
  sort_by(scenario.order, out.rules);
  sort_by(scenario.order, out.variables);
  return out;
}

/// Follows the instances of a document and looks for cycles and for too many items.
class Walk {
 public:
  Walk(const Scenario& document, const std::string& root, Error& problems) : document_(document), root_(root), problems_(problems) {}

  void check() {
    (void)count(document_, root_);
    for (std::size_t i = 0; i < document_.scenarios.size(); ++i)
      (void)count(document_.scenarios[i], root_ + "/scenarios/" + std::to_string(i));
  }

 private:
  /// Number of items of the flattened scenario.
  std::size_t count(const Scenario& s, const std::string& location) {
    if (const auto known = counts_.find(&s); known != counts_.end()) return known->second;
    chain_.push_back(&s);
    std::size_t total = s.characters.size() + s.events.size() + s.rules.size() + s.variables.size() + s.cameras.size() + s.shots.size();
    for (const ScenarioCharacter& c : s.characters) total += c.track.size();
    for (std::size_t i = 0; i < s.instances.size(); ++i) {
      const std::string at = location + "/instances/" + std::to_string(i) + "/scenario";
      const ScenarioInstance& instance = s.instances[i];
      const Scenario* const inner = document_.find_scenario(instance.scenario);
      if (!inner) {
        problems_.add(ErrorCode::unknown, at, "There is no scenario '" + instance.scenario + "'.",
                      "Name one of the inner scenarios of the document.");
      } else if (const auto begin = std::ranges::find(chain_, inner); begin != chain_.end()) {
        std::string names;
        for (auto link = begin; link != chain_.end(); ++link) names += (*link)->name + " > ";
        problems_.add(ErrorCode::structure, at, "The scenario '" + inner->name + "' would contain itself: " + names + inner->name + ".",
                      "Place another scenario here.");
        return total;
      } else {
        total =
            std::min(total + count(*inner, root_ + "/scenarios/" + std::to_string(inner - document_.scenarios.data())), 2 * max_flattened);
        if (chain_.size() >= max_levels)
          problems_.add(ErrorCode::range, at, "The scenario is nested more than " + std::to_string(max_levels) + " levels deep.",
                        "Place it at a higher level.");
        check_torques(instance, *inner, at);
      }
    }
    chain_.pop_back();
    if (total > max_flattened && !reported_) {
      reported_ = true;
      problems_.add(ErrorCode::range, location + "/instances",
                    "With its inner scenarios, '" + s.name + "' has more than " + std::to_string(max_flattened) + " items.",
                    "Place the inner scenarios less often.");
    }
    counts_[&s] = total;
    return total;
  }

  void check_torques(const ScenarioInstance& instance, const Scenario& inner, const std::string& at) {
    if (!problems_.empty() || (instance.start == 0 && instance.place == ScenarioPlace{})) return;
    for (const ScenarioCharacter& c : expand(document_, inner, max_levels).characters)
      if (c.control.mode == ControlMode::torque)
        problems_.add(ErrorCode::structure, at,
                      "'" + instance.name + "' is moved, but its character '" + c.id +
                          "' has the control mode \"torque\": its first state has a fixed place and the time 0.",
                      "Place the scenario at the origin with start 0, or choose another control mode.");
  }

  const Scenario& document_;
  const std::string& root_;
  Error& problems_;
  bool reported_ = false;
  std::vector<const Scenario*> chain_;
  std::map<const Scenario*, std::size_t> counts_;
};

}  // namespace

ScenarioPlace compose(const ScenarioPlace& frame, const ScenarioPlace& p) { return Frame(frame).place(p); }

void displace(Scenario& s, double start, const ScenarioPlace& place) {
  const Frame frame(place);
  for (ScenarioCharacter& c : s.characters) {
    c.place = frame.place(c.place);
    for (ScenarioClip& clip : c.track) clip.start += start;
  }
  for (ScenarioInstance& i : s.instances) {
    i.place = frame.place(i.place);
    i.start += start;
  }
  for (ScenarioEvent& e : s.events) {
    e.time += start;
    if (e.axes == PushAxes::world) e.force = frame.direction(e.force);
    if (e.type == EventType::throw_) {
      e.from = frame.point(e.from);
      e.velocity = frame.direction(e.velocity);
      e.spin = frame.direction(e.spin);
    }
    if (e.type == EventType::grab && e.grip.has_at && e.grip.other.empty()) e.grip.at = frame.point(e.grip.at);
    for (PullTarget& target : e.path) target.at = frame.point(target.at);
  }
  for (Rule& rule : s.rules) {
    for (RuleCondition& c : rule.conditions)
      if (c.type == ConditionType::time) c.time += start;
    if (rule.action.axes == PushAxes::world) rule.action.force = frame.direction(rule.action.force);
  }
  for (FilmCamera& camera : s.cameras) {
    frame.move(camera.view, !camera.follow.empty());
    for (FilmKey& key : camera.keys) {
      key.time += start;
      frame.move(key.view, !camera.follow.empty());
    }
  }
  for (FilmShot& shot : s.shots) shot.start += start;
  for (ScenarioMarker& marker : s.markers) marker.time += start;
}

void resolve_solo(Scenario& s) {
  const auto solo = [](const auto& track) { return track.solo; };
  const bool any = std::ranges::any_of(s.characters, solo) || std::ranges::any_of(s.instances, solo);
  const auto resolve = [&](auto& track) {
    track.muted = track.muted || (any && !track.solo);
    track.solo = false;
  };
  std::ranges::for_each(s.characters, resolve);
  std::ranges::for_each(s.instances, resolve);
}

Scenario flatten(const Scenario& document) {
  Scenario out = expand(document, document, max_levels);
  if (!document.instances.empty()) put_in_order(out);
  return out;
}

Scenario open_scenario(const Scenario& document, std::string_view id) {
  Scenario out = document;
  const Scenario* const inner = document.find_scenario(id);
  if (!inner) return out;
  out.name = inner->name;
  out.duration = inner->duration;
  out.characters = inner->characters;
  out.events = inner->events;
  out.markers = inner->markers;
  out.rules = inner->rules;
  out.variables = inner->variables;
  out.track_order = inner->track_order;
  out.range = inner->range;
  out.camera = inner->camera;
  out.cameras = inner->cameras;
  out.shots = inner->shots;
  out.instances = inner->instances;
  out.order = inner->order;
  out.circuit.clear();
  return out;
}

void check_instances(const Scenario& document, const std::string& root, Error& problems) {
  std::set<std::string> ids;
  for (std::size_t i = 0; i < document.scenarios.size(); ++i) {
    const Scenario& inner = document.scenarios[i];
    const std::string at = root + "/scenarios/" + std::to_string(i) + "/id";
    if (!is_id(inner.id))
      problems.add(ErrorCode::syntax, at, "'" + inner.id + "' cannot be an id.", "Use 1 to 40 letters, digits, '-', '_' or '.'.");
    else if (!ids.insert(inner.id).second)
      problems.add(ErrorCode::duplicate, at, "Two scenarios have the id '" + inner.id + "'.", "Give each scenario its own id.");
  }
  if (problems.empty()) Walk(document, root, problems).check();
}

}  // namespace ugoki::content
