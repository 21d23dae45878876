#include "ugoki/content/executable.h"

#include <cmath>
#include <cstring>

#include "ugoki/content/generate.h"
#include "ugoki/content/track.h"
#include "ugoki/content/ugx.h"
#include "ugoki/formats/mechanism_json.h"
#include "ugoki/formats/motion_binary.h"

namespace ugoki::content {
namespace {

/// One container at work.
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
    if (!problems_.empty()) return fail(std::move(problems_));
    return std::move(out_);
  }

 private:
  const UgxSection* section(std::string_view name) {
    const UgxSection* found = ugx_.find(name);
    if (!found)
      problems_.add(ErrorCode::structure, name_, "Section '" + std::string(name) + "' is missing.",
                    "Generate the file anew from its project.");
    return found;
  }

  void read_resources() {
    for (const UgxSection& s : ugx_.sections()) {
      const std::string place = name_ + ", section " + s.name;
      if (s.name.starts_with("mechanism/")) {
        Result<MechanismPtr> mechanism = formats::read_mechanism(s.text(), place);
        if (mechanism)
          add(out_.mechanism_ids, out_.mechanisms, resources_.mechanisms, s.name.substr(10), std::move(*mechanism));
        else
          take_problems(mechanism.error());
      } else if (s.name.starts_with("motion/")) {
        Result<Motion> motion = formats::read_motion(s.bytes, place);
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
    out_.look = s.look;
  }

  void take_characters(const Scenario& s, std::span<const std::byte> bytes) {
    std::size_t clips = 0;
    for (const ScenarioCharacter& c : s.characters) clips += c.track.size();
    if (bytes.size() != clips * 4 * sizeof(double)) {
      problems_.add(ErrorCode::structure, name_ + ", section placements", "It does not hold one placement for each clip.",
                    "Generate the file anew from its project.");
      return;
    }
    for (const ScenarioCharacter& c : s.characters) {
      ExecutableCharacter character;
      character.id = c.id;
      character.name = c.name;
      character.color = c.color;
      character.mechanism = index_of(out_.mechanism_ids, c.mechanism);
      character.control = c.control;
      character.place = to_placement(c.place);
      const Mechanism& mechanism = *out_.mechanisms[static_cast<std::size_t>(character.mechanism)];
      std::vector<Clip> track;
      for (const ScenarioClip& source : c.track) {
        const int index = index_of(out_.motion_ids, source.motion);
        const Motion& motion = *out_.motions[static_cast<std::size_t>(index)];
        const Error misfit = check_motion(motion, mechanism);
        if (!misfit.empty()) return take_problems(misfit);
        Clip clip = to_clip(source);
        double place[4];
        std::memcpy(place, bytes.data(), sizeof place);
        bytes = bytes.subspan(sizeof place);
        for (const double x : place)
          if (!std::isfinite(x) || std::fabs(x) > 1e9)
            return problems_.add(ErrorCode::range, name_ + ", section placements",
                                 "The placement of clip '" + source.id + "' is no number.", "Generate the file anew from its project.");
        clip.place = {place[0], place[1], place[2], place[3]};
        if (clip.loop) clip.cycle = cycle_of(motion, mechanism);
        track.push_back(clip);
        character.track.push_back({source.id, index, clip});
      }
      character.q0 = start_position(c, mechanism, track, resources_);
      out_.characters.push_back(std::move(character));
    }
  }

  void take_events(const Scenario& s) {
    for (const ScenarioEvent& e : s.events) {
      ExecutableEvent event;
      event.id = e.id;
      event.type = e.type;
      event.time = e.time;
      while (s.characters[static_cast<std::size_t>(event.character)].id != e.character) ++event.character;  // check_scenario found it
      event.duration = e.duration;
      if (e.type == EventType::push) {
        const int mechanism = index_of(out_.mechanism_ids, s.characters[static_cast<std::size_t>(event.character)].mechanism);
        event.link = find_link(*out_.mechanisms[static_cast<std::size_t>(mechanism)], e.link);
      }
      event.force = e.force;
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
    for (Problem& p : ugx.error().problems) p.place = std::string(name) + ": " + p.place;
    return fail(std::move(ugx.error()));
  }
  return Reader(*ugx, name).read();
}

}  // namespace ugoki::content
