#include "ugoki/studio/pose_desk.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "ugoki/base/number.h"
#include "ugoki/content/track.h"
#include "ugoki/json/fields.h"
#include "ugoki/mechanism/state.h"
#include "ugoki/motion_edit/mirror.h"
#include "ugoki/posing/pose_edit.h"
#include "ugoki/studio/pose_json.h"

namespace ugoki::studio {
namespace {

using json::Fields;
using json::Json;
using motion_edit::JointPart;
using motion_edit::KeyedLayer;

constexpr double same = 1e-7;  // rad | m: joints whose coordinates differ less are unchanged
constexpr std::size_t max_ghosts = 32, max_curves = 64;
constexpr double max_drag_seconds = 0.1;  // s: a request of a drag with dynamics is answered within some milliseconds
constexpr std::size_t max_drags = 8;
constexpr int max_samples = 600;  // points of one curve: more than a panel has pixels per second of a clip

std::size_t at(int i) { return static_cast<std::size_t>(i); }

/// The clip that a request names, with its mechanism and its place on the track.
struct Shown {
  MechanismPtr mechanism;
  const content::ScenarioCharacter* character = nullptr;  // in the layered document
  const content::ScenarioClip* clip = nullptr;            // in the project's document
  MotionPtr motion;                                       // without layers
  std::vector<Clip> track;                                // laid with layers
  std::size_t index = 0;                                  // of the clip on the track
  const content::LayeredContent* layered = nullptr;

  /// s, period of a looped clip; 0: the clip does not repeat
  [[nodiscard]] double period() const { return clip->loop ? motion->duration() : 0; }
  [[nodiscard]] const Motion& layered_motion(std::size_t i) const { return *layered->resources.motions.at(character->track[i].motion); }
};

Result<Shown> find_shown(const ShownScenario& project, const content::LayeredContent& layered, Fields& f) {
  std::string character, clip;
  f.require("character", "a character's id");
  f.text("character", character);
  f.require("clip", "the id of a clip of that character");
  f.text("clip", clip);
  if (!f.problems().empty()) return fail(f.problems());
  const content::ScenarioCharacter* own = project.scenario().find_character(character);
  if (!own) return fail(ErrorCode::unknown, "character", "There is no character '" + character + "'.", "Give a character's id.");
  Shown out;
  out.layered = &layered;
  out.character = layered.scenario.find_character(character);
  for (; out.index < own->track.size(); ++out.index)
    if (own->track[out.index].id == clip) break;
  if (out.index == own->track.size())
    return fail(ErrorCode::unknown, "clip", "The character has no clip '" + clip + "'.", "Give the id of one of its clips.");
  out.clip = &own->track[out.index];
  const auto mechanism = layered.resources.mechanisms.find(own->mechanism);
  const auto motion = layered.resources.motions.find(out.clip->motion);
  if (mechanism == layered.resources.mechanisms.end() || motion == layered.resources.motions.end())
    return fail(ErrorCode::unknown, "clip " + clip, "The project does not contain its motion or its mechanism.",
                "Remove the clip and add the motion again.");
  out.mechanism = mechanism->second;
  out.motion = motion->second;
  out.track = content::lay_track(*out.character, *out.mechanism, layered.resources);
  return out;
}

/// The coordinates at a time of the motion with the active layers from index `first` to before `last` applied to `q`.
void apply(const Shown& shown, std::size_t first, std::size_t last, double t, std::span<double> q) {
  for (std::size_t i = first; i < last; ++i)
    if (shown.clip->layers[i].on) motion_edit::apply_layer(*shown.mechanism, shown.clip->layers[i].keyed, t, q, shown.period());
}

/// The parts of a joint that keys move.
std::vector<std::pair<JointPart, const char*>> parts_of(const Joint& joint) {
  if (joint.type == JointType::floating) return {{JointPart::rotation, "rotation"}, {JointPart::position, "position"}};
  if (joint.nv() == 0) return {};
  return {{JointPart::whole, "joint"}};
}

/// Displacement of a part of a joint from the neutral position. @return number of components
int displacement(const Joint& joint, JointPart part, const double* q, double* out) {
  double x[6];
  if (joint.type == JointType::floating) {
    double zero[7];
    joint_neutral(joint, zero);
    joint_difference(joint, zero, q, x);
    std::copy_n(x + (part == JointPart::position ? 3 : 0), 3, out);
    return 3;
  }
  joint_displacement(joint, q, out);
  return joint.nv();
}

bool is_changed(const Joint& joint, const double* a, const double* b) {
  double v[6];
  joint_difference(joint, a, b, v);
  return std::any_of(v, v + joint.nv(), [](double x) { return std::fabs(x) > same; });
}

Vec3 vector_in(Fields& f, std::string_view key) {
  std::array<double, 3> v{};
  f.require(key, "three numbers");
  f.numbers(key, v);
  return {v[0], v[1], v[2]};
}

/// Makes the quaternion of a joint one of unit length. @return false if its length is far from 1
bool normalise(const Joint& joint, double* own) {
  const int k = joint.type == JointType::spherical ? 0 : joint.type == JointType::floating ? 3 : -1;
  if (k < 0) return true;
  const Quat r = {own[k], own[k + 1], own[k + 2], own[k + 3]};
  const double length = std::sqrt(r.w * r.w + r.x * r.x + r.y * r.y + r.z * r.z);
  if (!(length > 0.5 && length < 2)) return false;
  for (int j = 0; j < 4; ++j) own[k + j] /= length;
  return true;
}

/// Rotates and moves the root from x = y = 0 and heading 0 to the x, y and heading of `at`.
void place_root(const Mechanism& m, Placement at, std::span<double> q) {
  Placement root = root_placement(m, q);
  root.z = at.z = 0;
  displace_root(m, at * inverse(root), q);
}

/// Reads the edit `pose`: the joints of a stored pose, where the character stands. @param q the present pose
posing::BlendEdit read_stored(Fields& g, const Mechanism& m, std::span<const double> q) {
  posing::BlendEdit e;
  e.q.assign(q.begin(), q.end());
  g.number("share", e.share);
  if (!(e.share >= 0 && e.share <= 1))
    g.report(ErrorCode::range, g.path("share"), "The share " + to_text(e.share) + " is out of range.", "Give a value from 0 to 1.");
  bool mirrored = false;
  g.boolean("mirror", mirrored);
  std::vector<std::uint8_t> given(at(m.link_count())), wanted(at(m.link_count()), 1);
  const Json* joints = g.list("joints", at(m.link_count()), "joints");
  for (std::size_t i = 0; joints && i < joints->size(); ++i) {
    Fields h((*joints)[i], g.path("joints") + "/" + std::to_string(i), g.problems());
    std::string name;
    h.require("link", "the link's name");
    h.text("link", name);
    const int index = m.find_link(name);
    if (index < 0) continue;  // a pose of a similar body: joints that this one does not have are left out
    double* own = e.q.data() + m.link(index).q_index;
    if (!h.numbers("q", {own, at(m.link(index).joint.nq())})) continue;
    if (!normalise(m.link(index).joint, own))
      h.report(ErrorCode::range, h.path("q"), "The quaternion is not of unit length.", "Give the coordinates of an earlier answer.");
    given[at(index)] = 1;
  }
  if (const Json* links = g.list("links", at(m.link_count()), "names of links")) {
    std::fill(wanted.begin(), wanted.end(), std::uint8_t{0});
    for (const Json& name : *links) {
      const int index = name.is_string() ? m.find_link(name.get<std::string>()) : -1;
      if (index < 0)
        g.report(ErrorCode::unknown, g.path("links"), "The mechanism '" + m.name() + "' has no link " + json::to_text(name) + ".",
                 "Give names of its links.");
      else
        wanted[at(index)] = 1;
    }
  }
  if (!g.problems().empty()) return e;
  place_root(m, root_placement(m, q), e.q);
  if (mirrored) {
    if (Result<void> done = posing::edit_pose(m, posing::MirrorEdit{}, {}, e.q); !done) {
      for (Problem& p : done.error().problems) g.problems().problems.push_back(std::move(p));
      return e;
    }
    const std::vector<int> partners = motion_edit::find_mirror_links(m);
    std::vector<std::uint8_t> exchanged(given.size());
    for (std::size_t i = 0; i < given.size(); ++i)
      if (partners[i] >= 0) exchanged[at(partners[i])] = given[i];
    given = exchanged;
  }
  for (int i = 0; i < m.link_count(); ++i)
    if (given[at(i)] && wanted[at(i)]) e.links.push_back(i);
  return e;
}

/// Coordinates of all joints as they are stored: the root at x = y = 0 with heading 0.
Json stored_joints(const Mechanism& m, std::span<const double> pose) {
  std::vector<double> q(pose.begin(), pose.end());
  place_root(m, {}, q);
  Json out = Json::array();
  for (int i = 0; i < m.link_count(); ++i) {
    const Link& link = m.link(i);
    if (link.joint.nq() == 0) continue;
    Json own = Json::array();
    for (int k = 0; k < link.joint.nq(); ++k)
      own.push_back(rounded(q[at(link.q_index + k)], 1e-9));  // finer than `same`, so that a pose at its own time changes no joint
    out.push_back({{"link", link.name}, {"q", std::move(own)}});
  }
  return out;
}

/// The fields of a drag with dynamics, in addition to those of a ReachEdit.
struct DragFields {
  std::string id;      ///< empty: no drag with dynamics
  double seconds = 0;  ///< time since the last request of this drag
};

/// Reads the field `edit`. `q` is the present pose.
std::optional<posing::PoseEdit> read_edit(Fields& f, const Mechanism& m, std::span<const double> q, DragFields& drag) {
  const Json* object = f.find("edit");
  if (!object || object->is_null()) return {};
  Fields g(*object, f.path("edit"), f.problems());
  std::string type;
  g.require("type", "the kind of edit, for example \"turn\"");
  g.text("type", type);
  const auto link = [&] {
    int value = -1;
    g.require("link", "the link's index");
    g.integer("link", value);
    return value;
  };
  std::optional<posing::PoseEdit> out;
  if (type == "turn") {
    posing::TurnEdit e;
    e.link = link();
    e.axis = vector_in(g, "axis");
    if (norm(e.axis) > 0) e.axis = e.axis / norm(e.axis);
    g.number("angle", e.angle);
    out = e;
  } else if (type == "set") {
    posing::SetEdit e;
    e.link = link();
    g.integer("dof", e.dof);
    g.number("value", e.value);
    out = e;
  } else if (type == "reach") {
    posing::ReachEdit e;
    e.link = link();
    e.point = vector_in(g, "point");
    e.target = vector_in(g, "target");
    std::string moves = "limb";
    g.text("moves", moves);
    if (moves == "physics") {
      g.require("drag", "an id of the drag, which its requests have in common");
      g.text("drag", drag.id);
      if (drag.id.empty() || drag.id.size() > 40)
        g.report(ErrorCode::range, g.path("drag"), "The id of the drag has no or more than 40 bytes.", "Give a short text.");
      g.number("seconds", drag.seconds);
      if (!(drag.seconds >= 0 && drag.seconds <= max_drag_seconds))
        g.report(ErrorCode::range, g.path("seconds"), "The time " + to_text(drag.seconds) + " s is out of range.",
                 "Give a value from 0 to " + to_text(max_drag_seconds) + " s.");
      if (e.link < 0 || e.link >= m.link_count())
        g.report(ErrorCode::range, g.path("link"), "The mechanism has no link " + std::to_string(e.link) + ".", "Give a link's index.");
    } else if (moves != "limb" && moves != "body") {
      g.report(ErrorCode::unknown, g.path("moves"), "The value '" + moves + "' is not known.", "Use \"limb\", \"body\" or \"physics\".");
    }
    e.moves = moves == "body" ? posing::Reach::body : posing::Reach::limb;
    out = e;
  } else if (type == "mirror") {
    out = posing::MirrorEdit{};
  } else if (type == "pose") {
    out = read_stored(g, m, q);
  } else if (f.problems().empty()) {
    g.report(ErrorCode::unknown, g.path("type"), "There is no edit '" + type + "'.", "Use turn, set, reach, mirror or pose.");
  }
  g.refuse_others();
  return out;
}

/// Overlays the joints in the field `from` over q: [{"link": index, "q": [...]}].
void read_from(Fields& f, const Mechanism& m, std::span<double> q) {
  const Json* list = f.list("from", at(m.link_count()), "joints");
  for (std::size_t i = 0; list && i < list->size(); ++i) {
    Fields g((*list)[i], f.path("from") + "/" + std::to_string(i), f.problems());
    int link = -1;
    g.require("link", "the link's index");
    g.integer("link", link);
    if (link < 0 || link >= m.link_count()) {
      g.report(ErrorCode::range, g.path("link"), "The mechanism has no link " + std::to_string(link) + ".", "Give a link's index.");
      return;
    }
    const Joint& joint = m.link(link).joint;
    double* own = q.data() + m.link(link).q_index;
    if (!g.numbers("q", {own, at(joint.nq())})) continue;
    if (!normalise(joint, own)) {
      g.report(ErrorCode::range, g.path("q"), "The quaternion is not of unit length.", "Give the coordinates of an earlier answer.");
      return;
    }
  }
}

}  // namespace

Result<const content::LayeredContent*> PoseDesk::layered(const ShownScenario& project) {
  if (!layered_ || revision_ != project.revision() || path_ != project.path()) {
    Result<content::LayeredContent> made = content::apply_layers(project.scenario(), project.resources());
    if (!made) return fail(std::move(made.error()));
    layered_ = std::move(*made);
    revision_ = project.revision();
    path_ = project.path();
  }
  return &*layered_;
}

Result<void> PoseDesk::drag(const ShownScenario& project, const MechanismPtr& mechanism, const std::string& id, BodyDragOptions options,
                            const Vec3& target, double seconds, std::span<double> q) {
  auto found = std::ranges::find_if(drags_, [&](const Drag& d) { return d.id == id && d.revision == project.revision(); });
  if (found == drags_.end()) {
    if (drags_.size() >= max_drags) drags_.erase(drags_.begin());
    drags_.push_back({id, project.revision(), std::make_unique<BodyDrag>(mechanism, q, std::move(options))});
    found = drags_.end() - 1;
  }
  if (Result<void> done = found->body->advance(target, seconds); !done) {
    drags_.erase(found);
    return done;
  }
  std::ranges::copy(found->body->q(), q.begin());
  return {};
}

Result<std::string> PoseDesk::pose(const ShownScenario& project, const Json& request) {
  Error problems;
  Fields f(request, "", problems);
  const Result<const content::LayeredContent*> content = layered(project);
  if (!content) return fail(content.error());
  Result<Shown> found = find_shown(project, **content, f);
  if (!found) return fail(std::move(found.error()));
  const Shown& shown = *found;
  const Mechanism& m = *shown.mechanism;
  const Clip& clip = shown.track[shown.index];

  double time = clip.start;
  f.require("time", "a time of the scenario, in seconds");
  f.number("time", time);
  std::string layer_id;
  f.text("layer", layer_id);
  std::size_t layer = shown.clip->layers.size();
  if (!layer_id.empty()) {
    layer = 0;
    while (layer < shown.clip->layers.size() && shown.clip->layers[layer].id != layer_id) ++layer;
    if (layer == shown.clip->layers.size())
      return fail(ErrorCode::unknown, "layer", "The clip has no layer '" + layer_id + "'.", "Give the id of one of its layers, or none.");
    if (!shown.clip->layers[layer].on || !(shown.clip->layers[layer].keyed.weight > 0))
      return fail(ErrorCode::conflict, "layer", "The layer '" + shown.clip->layers[layer].name + "' is off or has the weight 0.",
                  "Switch the layer on, or choose another layer.");
  }
  bool free = false, coordinates = false;
  f.boolean("free", free);
  f.boolean("coordinates", coordinates);
  posing::PoseEditOptions options;
  options.limits = !free;
  if (const Json* pins = f.list("pins", at(m.link_count()), "pins"))
    for (const Json& pin : *pins) {
      if (!pin.is_number_integer()) return fail(ErrorCode::syntax, "pins", "A pin is not the index of a link.", "Give indices of links.");
      options.pins.push_back(pin.get<int>());
    }

  // the pose of the document, in the coordinates of the motion and in the world
  const ClipPhase phase = phase_of(clip, shown.motion->duration(), time);
  const Placement placement = placement_in(clip, phase.rounds);
  std::vector<double> below(at(m.nq())), document;
  sample(*shown.motion, m, phase.time, below);
  apply(shown, 0, layer, phase.time, below);
  document = below;
  apply(shown, layer, shown.clip->layers.size(), phase.time, document);
  displace_root(m, placement, document);

  std::vector<double> q = document;
  read_from(f, m, q);
  DragFields dragged;
  const std::optional<posing::PoseEdit> edit = read_edit(f, m, q, dragged);
  if (!problems.empty()) return fail(std::move(problems));
  if (const auto* reach = edit ? std::get_if<posing::ReachEdit>(&*edit) : nullptr; reach && !dragged.id.empty()) {
    BodyDragOptions how{reach->link, reach->point, options.pins, project.scenario().ground.height};
    if (Result<void> done = drag(project, shown.mechanism, dragged.id, std::move(how), reach->target, dragged.seconds, q); !done)
      return fail(std::move(done.error()));
  } else if (edit)
    if (Result<void> done = posing::edit_pose(m, *edit, options, q); !done) return fail(std::move(done.error()));
  if (!is_finite(q)) return fail(ErrorCode::range, "edit", "The edit gives values that are not finite.", "Use a smaller value.");

  // the keys of the layer that give this pose
  std::vector<double> wanted = q;
  displace_root(m, inverse(placement), wanted);
  std::vector<double> unlayered = wanted;
  for (std::size_t i = shown.clip->layers.size(); i-- > layer + 1;)
    if (shown.clip->layers[i].on) motion_edit::remove_layer(m, shown.clip->layers[i].keyed, phase.time, unlayered, shown.period());
  const bool new_layer = layer == shown.clip->layers.size();
  const motion_edit::LayerMode mode = new_layer ? motion_edit::LayerMode::additive : shown.clip->layers[layer].keyed.mode;
  const double weight = new_layer ? 1 : shown.clip->layers[layer].keyed.weight;
  Json changed = Json::array(), keys = Json::array(), angles = Json::array();
  for (int i = 0; i < m.link_count(); ++i) {
    const Link& link = m.link(i);
    Json x = Json::array();
    double values[6];
    if (link.joint.type != JointType::floating) {
      joint_displacement(link.joint, q.data() + link.q_index, values);
      for (int k = 0; k < link.joint.nv(); ++k) x.push_back(rounded(values[k], 1e-6));
    }
    angles.push_back(std::move(x));
    const bool moved = is_changed(link.joint, document.data() + link.q_index, q.data() + link.q_index);
    if (moved)
      changed.push_back({{"link", i}, {"q", std::vector<double>(q.begin() + link.q_index, q.begin() + link.q_index + link.joint.nq())}});
    for (const auto& [part, name] : parts_of(link.joint)) {
      const auto value =
          motion_edit::key_value(link.joint, part, mode, weight, below.data() + link.q_index, unlayered.data() + link.q_index);
      Json components = Json::array();
      for (int k = 0; k < motion_edit::component_count(link.joint.type, part); ++k) components.push_back(rounded(value[at(k)], 1e-6));
      keys.push_back({{"link", link.name}, {"part", name}, {"value", std::move(components)}, {"moved", moved}});
    }
  }
  Json planted = Json::array();
  for (const ContactTrack& track : shown.motion->contacts) {
    const auto frame = static_cast<std::size_t>(phase.time * shown.motion->rate + 0.5);
    const int link = m.find_link(track.link);
    if (link >= 0 && frame < track.on.size() && track.on[frame]) planted.push_back(link);
  }
  Json out = {{"motion_time", phase.time},     {"links", poses_json(m, q, 1e-6)}, {"angles", std::move(angles)},
              {"changed", std::move(changed)}, {"keys", std::move(keys)},         {"planted", std::move(planted)}};

  if (coordinates) out["joints"] = stored_joints(m, q);
  if (const Json* times = f.list("ghosts", max_ghosts, "times")) {
    Json ghosts = Json::array();
    for (const Json& t : *times) {
      const double wanted_time = t.is_number() ? t.get<double>() : time;
      std::size_t i = shown.track.size() - 1;
      while (i > 0 && shown.track[i].start > wanted_time) --i;
      sample(shown.track[i], shown.layered_motion(i), m, wanted_time, q);
      ghosts.push_back(poses_json(m, q, 1e-6));
    }
    out["ghosts"] = std::move(ghosts);
  }
  const std::string text = json::to_text(out);
  return "," + text.substr(1, text.size() - 2);
}

Result<std::string> PoseDesk::curves(const ShownScenario& project, const Json& request) {
  Error problems;
  Fields f(request, "", problems);
  const Result<const content::LayeredContent*> content = layered(project);
  if (!content) return fail(content.error());
  Result<Shown> found = find_shown(project, **content, f);
  if (!found) return fail(std::move(found.error()));
  const Shown& shown = *found;
  const Mechanism& m = *shown.mechanism;
  std::vector<int> links;
  f.require("links", "a list of names of links");
  if (const Json* names = f.list("links", max_curves, "links"))
    for (const Json& name : *names) {
      const int link = name.is_string() ? m.find_link(name.get<std::string>()) : -1;
      if (link < 0)
        f.report(ErrorCode::unknown, "links", "The mechanism '" + m.name() + "' has no link " + json::to_text(name) + ".",
                 "Give names of its links.");
      else
        links.push_back(link);
    }
  if (!problems.empty()) return fail(std::move(problems));

  const content::ScenarioClip& clip = *shown.clip;
  const double duration = shown.motion->duration();
  const double from = clip.loop ? 0 : std::min(clip.offset, duration);
  const double to = clip.loop ? duration : std::min(duration, clip.offset + clip.length * clip.speed);
  const int count = std::clamp(static_cast<int>((to - from) * shown.motion->rate + 1.5), 2, max_samples);
  const double step = (to - from) / (count - 1);
  struct Track {
    int link;
    JointPart part;
    const char* name;
    std::vector<std::vector<double>> base, result;  // [components][samples]
  };
  std::vector<Track> tracks;
  for (const int link : links)
    for (const auto& [part, name] : parts_of(m.link(link).joint)) {
      const auto n = at(motion_edit::component_count(m.link(link).joint.type, part));
      tracks.push_back({link, part, name, std::vector<std::vector<double>>(n), std::vector<std::vector<double>>(n)});
    }
  std::vector<double> q(at(m.nq()));
  for (int i = 0; i < count; ++i) {
    const double t = from + i * step;
    sample(*shown.motion, m, t, q);
    for (const bool result : {false, true}) {
      if (result) apply(shown, 0, clip.layers.size(), t, q);
      for (Track& track : tracks) {
        double x[6];
        const int n = displacement(m.link(track.link).joint, track.part, q.data() + m.link(track.link).q_index, x);
        for (int k = 0; k < n; ++k) (result ? track.result : track.base)[at(k)].push_back(rounded(x[k], 1e-5));
      }
    }
  }
  Json list = Json::array();
  for (const Track& track : tracks)
    list.push_back({{"link", m.link(track.link).name}, {"part", track.name}, {"base", track.base}, {"result", track.result}});
  return ",\"duration\":" + json::to_text(duration) + ",\"from\":" + json::to_text(from) + ",\"step\":" + json::to_text(step) +
         ",\"curves\":" + json::to_text(list);
}

Result<std::string> PoseDesk::stored(const ShownScenario& project, const Json& request) {
  Error problems;
  Fields f(request, "", problems);
  std::string id;
  f.require("mechanism", "a mechanism's id");
  f.text("mechanism", id);
  if (!problems.empty()) return fail(std::move(problems));
  const auto found = project.resources().mechanisms.find(id);
  if (found == project.resources().mechanisms.end())
    return fail(ErrorCode::unknown, "mechanism", "The project has no mechanism '" + id + "'.", "Give the id of a character's mechanism.");
  const Mechanism& m = *found->second;
  Json list = Json::array();
  for (const content::ScenarioPose& pose : project.scenario().poses) {
    std::vector<double> q = m.neutral();
    const bool fits = std::ranges::all_of(pose.joints, [&](const content::PoseJoint& joint) {
      const int index = m.find_link(joint.link);
      if (index < 0 || joint.q.size() != at(m.link(index).joint.nq())) return false;
      std::copy(joint.q.begin(), joint.q.end(), q.begin() + m.link(index).q_index);
      return normalise(m.link(index).joint, q.data() + m.link(index).q_index);
    });
    if (fits) list.push_back({{"id", pose.id}, {"links", poses_json(m, q, 1e-6)}});
  }
  return ",\"poses\":" + json::to_text(list);
}

Result<std::string> PoseDesk::joints(const ShownScenario& project, const Json& request) {
  Error problems;
  Fields f(request, "", problems);
  std::string id;
  f.require("mechanism", "a mechanism's id");
  f.text("mechanism", id);
  if (!problems.empty()) return fail(std::move(problems));
  const auto found = project.resources().mechanisms.find(id);
  if (found == project.resources().mechanisms.end())
    return fail(ErrorCode::unknown, "mechanism", "The project has no mechanism '" + id + "'.", "Give the id of a character's mechanism.");
  const Mechanism& m = *found->second;
  const std::vector<int> partners = motion_edit::find_mirror_links(m);
  const std::vector<double> neutral = m.neutral();
  const auto finite = [](double x) { return std::isfinite(x) ? Json(x) : Json(nullptr); };
  Json list = Json::array();
  for (int i = 0; i < m.link_count(); ++i) {
    const Joint& joint = m.link(i).joint;
    Vec6 S[6];
    joint_subspace(joint, neutral.data() + m.link(i).q_index, S);
    Json dofs = Json::array();
    for (int k = 0; k < joint.nv(); ++k) {
      const bool turns = norm(S[k].w) > 0;
      const Vec3 axis = turns ? S[k].w : S[k].v;
      dofs.push_back({{"lower", finite(joint.dofs[at(k)].lower)},
                      {"upper", finite(joint.dofs[at(k)].upper)},
                      {"effort", finite(joint.dofs[at(k)].effort)},
                      {"turns", turns},
                      {"axis", {axis.x, axis.y, axis.z}}});
    }
    list.push_back({{"type", std::string(name_of(joint.type))}, {"dofs", std::move(dofs)}, {"mirror", partners[at(i)]}});
  }
  return ",\"joints\":" + json::to_text(list);
}

}  // namespace ugoki::studio
