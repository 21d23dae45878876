#include "ugoki/content/executable.h"

#include <cmath>
#include <cstring>

#include "ugoki/content/generate.h"
#include "ugoki/content/secondary_motion.h"
#include "ugoki/content/track.h"
#include "ugoki/content/ugx.h"
#include "ugoki/formats/mechanism_json.h"
#include "ugoki/formats/motion_binary.h"

namespace ugoki::content {
namespace {

constexpr double max_run = 1e9;  // s, length of a motion that a rule repeats without end

/// Reads one file of executable data.
class Reader {
 public:
  Reader(const Ugx& ugx, std::string_view name) : ugx_(ugx), name_(name) {}

  Result<Executable> read() {
    const UgxSection* document = section("scenario");
    const UgxSection* circuit = section("circuit");
    const UgxSection* placements = section("placements");
    if (!problems_.empty()) return fail(std::move(problems_));
    Result<Scenario> scenario = read_scenario(document->text(), name_ + ", section scenario");
    if (!scenario) return fail(std::move(scenario.error()));
    read_resources();
    if (!problems_.empty()) return fail(std::move(problems_));
    const Catalogue catalogue = catalogue_of(resources_);
    problems_ = check_scenario(*scenario, &catalogue, name_ + ", section scenario");
    if (!problems_.empty()) return fail(std::move(problems_));
    take_settings(*scenario);
    out_.circuit = std::string(circuit->text());
    take_characters(*scenario, placements->bytes);
    take_events(*scenario);
    check_limits();
    if (!problems_.empty()) return fail(std::move(problems_));
    return std::move(out_);
  }

 private:
  const UgxSection* section(std::string_view name) {
    const UgxSection* found = ugx_.find(name);
    if (!found)
      problems_.add(ErrorCode::structure, name_, "Section '" + std::string(name) + "' is missing.",
                    "Generate the file again from its project.");
    return found;
  }

  void read_resources() {
    for (const UgxSection& s : ugx_.sections()) {
      const std::string location = name_ + ", section " + s.name;
      if (s.name.starts_with("mechanism/")) {
        Result<MechanismPtr> mechanism = formats::read_mechanism(s.text(), location);
        if (mechanism)
          add(out_.mechanism_ids, out_.mechanisms, resources_.mechanisms, s.name.substr(10), std::move(*mechanism));
        else
          take_problems(mechanism.error());
      } else if (s.name.starts_with("motion/")) {
        Result<Motion> motion = formats::read_motion(s.bytes, location);
        if (motion)
          add(out_.motion_ids, out_.motions, resources_.motions, s.name.substr(7), std::make_shared<const Motion>(std::move(*motion)));
        else
          take_problems(motion.error());
      }
    }
  }
  template <class List, class Map, class Pointer>
  static void add(std::vector<std::string>& ids, List& list, Map& map, const std::string& id, Pointer pointer) {
    ids.push_back(id);
    list.push_back(pointer);
    map.emplace(id, std::move(pointer));
  }
  void take_problems(const Error& error) {
    problems_.problems.insert(problems_.problems.end(), error.problems.begin(), error.problems.end());
  }

  static int index_of(const std::vector<std::string>& ids, const std::string& id) {
    for (std::size_t i = 0; i < ids.size(); ++i)
      if (ids[i] == id) return static_cast<int>(i);
    return -1;
  }

  void take_settings(const Scenario& s) {
    out_.name = s.name;
    out_.duration = s.duration;
    out_.frame_rate = s.frame_rate;
    out_.step = s.step;
    out_.gravity = s.gravity;
    out_.ground = s.ground;
    out_.camera = s.camera;
    out_.cameras = s.cameras;
    out_.shots = s.shots;
    out_.look = s.look;
    for (const ScenarioVariable& v : s.variables)
      if (v.shown) out_.variables.push_back(v);
  }

  void take_characters(const Scenario& s, std::span<const std::byte> bytes) {
    std::size_t clips = 0;
    for (const ScenarioCharacter& c : s.characters) clips += c.track.size();
    if (bytes.size() != clips * 4 * sizeof(double)) {
      problems_.add(
          ErrorCode::structure, name_ + ", section placements",
          "The section has " + std::to_string(bytes.size()) + " bytes; the " + std::to_string(clips) + " clips need 32 bytes each.",
          "Generate the file again from its project.");
      return;
    }
    for (const ScenarioCharacter& c : s.characters) {
      ExecutableCharacter character;
      character.id = c.id;
      character.name = c.name;
      character.color = c.color;
      character.material = c.material;
      character.mechanism = index_of(out_.mechanism_ids, c.mechanism);
      character.control = c.control;
      character.placement = to_placement(c.place);
      const Mechanism& mechanism = *out_.mechanisms[static_cast<std::size_t>(character.mechanism)];
      std::vector<Clip> track;
      for (const ScenarioClip& source : c.track) {
        const int index = index_of(out_.motion_ids, source.motion);
        const Motion& motion = *out_.motions[static_cast<std::size_t>(index)];
        const Error misfit = check_motion(motion, mechanism);
        if (!misfit.empty()) return take_problems(misfit);
        Clip clip = to_clip(source);
        double placement[4];  // x, y, z [m], heading [rad]
        std::memcpy(placement, bytes.data(), sizeof placement);
        bytes = bytes.subspan(sizeof placement);
        for (const double x : placement)
          if (!std::isfinite(x) || std::fabs(x) > 1e9)
            return problems_.add(ErrorCode::range, name_ + ", section placements",
                                 "The placement of clip '" + source.id + "' is not finite or exceeds 1e9 in magnitude.",
                                 "Generate the file again from its project.");
        clip.placement = {placement[0], placement[1], placement[2], placement[3]};
        if (clip.loop) clip.cycle = cycle_of(motion, mechanism);
        track.push_back(clip);
        character.track.push_back({source.id, index, clip});
      }
      for (const Rule* rule : play_rules(s, c.id)) {
        const int index = index_of(out_.motion_ids, rule->action.motion);
        const Motion& motion = *out_.motions[static_cast<std::size_t>(index)];
        const Error misfit = check_motion(motion, mechanism);
        if (!misfit.empty()) return take_problems(misfit);
        Clip clip;
        clip.speed = rule->action.speed;
        clip.blend = rule->action.blend;
        clip.loop = rule->action.loop;
        clip.length = clip.loop ? max_run : motion.duration() / clip.speed;
        clip.placement.z = c.place.z;
        if (clip.loop) clip.cycle = cycle_of(motion, mechanism);
        character.moves.push_back({rule->id, index, clip});
      }
      character.q0 = start_position(c, mechanism, track, resources_);
      const MechanismPtr placed = place_root(out_.mechanisms[static_cast<std::size_t>(character.mechanism)], character.placement);
      Result<MechanismPtr> sprung = with_secondary_motion(c, *placed, character.q0, s);
      if (!sprung) return take_problems(sprung.error());
      character.own = *sprung ? std::move(*sprung) : placed.get() != &mechanism ? placed : nullptr;
      out_.characters.push_back(std::move(character));
    }
  }

  /// Reports the first value of each mechanism that exceeds ExecutableLimits.
  void check_limits() {
    using Limits = ExecutableLimits;
    std::size_t links = 0, shapes = 0;
    for (const ExecutableCharacter& c : out_.characters)
      for (const Link& link : out_.mechanisms[static_cast<std::size_t>(c.mechanism)]->links()) {
        ++links;
        shapes += link.shapes.size();
      }
    const auto refuse = [&](const std::string& what, const std::string& where) {
      problems_.add(ErrorCode::range, where, what, "Make the content smaller.");
    };
    if (links > Limits::links)
      refuse("The characters have " + std::to_string(links) + " links; the limit is " + std::to_string(Limits::links) + ".", name_);
    if (shapes > Limits::shapes)
      refuse("The characters have " + std::to_string(shapes) + " shapes; the limit is " + std::to_string(Limits::shapes) + ".", name_);
    for (std::size_t i = 0; i < out_.mechanisms.size(); ++i)
      for (const Link& link : out_.mechanisms[i]->links())
        if (!within_limits(link)) {
          refuse("Link '" + link.name + "' has a size or a position above 10 km, or a mass above 1e9 kg.",
                 name_ + ", section mechanism/" + out_.mechanism_ids[i]);
          break;
        }
  }
  static bool within_limits(const Link& link) {
    const auto length = [](double x) { return std::fabs(x) <= ExecutableLimits::length; };
    const auto place = [&](const Vec3& p) { return length(p.x) && length(p.y) && length(p.z); };
    if (!(link.inertia.mass <= ExecutableLimits::mass) || !place(link.joint.X_PJ.p)) return false;
    for (const Shape& s : link.shapes)
      if (!length(s.radius) || !length(s.half_length) || !place(s.half_extents) || !place(s.X_BS.p)) return false;
    return true;
  }

  void take_events(const Scenario& s) {
    for (const ScenarioEvent& e : s.events) {
      ExecutableEvent event;
      event.id = e.id;
      event.type = e.type;
      event.time = e.time;
      while (s.characters[static_cast<std::size_t>(event.character)].id != e.character)
        ++event.character;  // the loop ends: check_scenario() has checked that the character exists
      event.duration = e.duration;
      if (e.type != EventType::throw_) {
        const int mechanism = index_of(out_.mechanism_ids, s.characters[static_cast<std::size_t>(event.character)].mechanism);
        event.link = find_link(*out_.mechanisms[static_cast<std::size_t>(mechanism)], e.link);
      }
      event.grip = e.grip;
      event.point = e.point;
      event.path = e.path;
      if (e.type == EventType::grab && !e.grip.other.empty()) {
        event.other = 0;
        while (s.characters[static_cast<std::size_t>(event.other)].id != e.grip.other) ++event.other;  // ends for the same reason
        const int mechanism = index_of(out_.mechanism_ids, s.characters[static_cast<std::size_t>(event.other)].mechanism);
        event.other_link = find_link(*out_.mechanisms[static_cast<std::size_t>(mechanism)], e.grip.other_link);
      }
      event.force = e.force;
      event.axes = e.axes;
      event.from = e.from;
      event.velocity = e.velocity;
      event.spin = e.spin;
      out_.events.push_back(std::move(event));
    }
  }

  const Ugx& ugx_;
  std::string name_;
  Error problems_;
  Resources resources_;
  Executable out_;
};

}  // namespace

Result<Executable> read_executable(std::span<const std::byte> bytes, std::string_view name) {
  Result<Ugx> ugx = read_ugx(bytes);
  if (!ugx) {
    for (Problem& p : ugx.error().problems) p.location = std::string(name) + ": " + p.location;
    return fail(std::move(ugx.error()));
  }
  return Reader(*ugx, name).read();
}

}  // namespace ugoki::content
