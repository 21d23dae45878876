#include "ugoki/studio/motion_compare.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "ugoki/content/layered_motions.h"
#include "ugoki/content/scenario.h"
#include "ugoki/content/track.h"
#include "ugoki/mechanism/state.h"
#include "ugoki/studio/pose_json.h"

namespace ugoki::studio {
namespace {

using json::Json;

constexpr double rate = 30;              // 1/s: poses between two samples are interpolated by the page
constexpr std::size_t max_poses = 1200;  // 40 s at `rate`; longer clips are sampled more coarsely

std::size_t at(int i) { return static_cast<std::size_t>(i); }

/// The track of a character with all layers applied.
struct Track {
  content::LayeredContent content;
  const content::ScenarioCharacter* character = nullptr;
  std::vector<Clip> clips;

  void sample_at(const Mechanism& m, double time, std::span<double> q) const {
    std::size_t i = clips.size() - 1;
    while (i > 0 && clips[i].start > time) --i;
    sample(clips[i], *content.resources.motions.at(character->track[i].motion), m, time, q);
  }
};

Result<Track> make_track(const content::Scenario& scenario, const content::Resources& resources, const std::string& id,
                         const Mechanism& m) {
  Result<content::LayeredContent> layered = content::apply_layers(scenario, resources);
  if (!layered) return fail(std::move(layered.error()));
  Track out{std::move(*layered), nullptr, {}};
  out.character = out.content.scenario.find_character(id);
  out.clips = content::lay_track(*out.character, m, out.content.resources);
  return out;
}

/// The document with `before` in place of the clip.
Result<content::Scenario> with_clip(const ShownScenario& project, const std::string& character, const std::string& clip, Json before) {
  Result<Json> document = json::parse_json(content::write_scenario(project.scenario()), "scenario");
  if (!document) return fail(std::move(document.error()));
  before["id"] = clip;
  for (Json& c : (*document)["characters"]) {
    if (c["id"] != character) continue;
    for (Json& k : c["track"])
      if (k["id"] == clip) k = before;
  }
  Result<content::Scenario> made = content::read_scenario(json::to_text(*document), "before");
  if (!made) return fail(std::move(made.error()));
  const content::Catalogue catalogue = content::catalogue_of(project.resources());
  Error problems = content::check_scenario(*made, &catalogue, "before");
  if (!problems.empty()) return fail(std::move(problems));
  return made;
}

/// The largest differences of two motions.
struct Largest {
  double angle = 0, angle_time = 0;  ///< rad, s
  int link = -1;
  double move = 0, move_time = 0;  ///< m, s: of the centre of mass

  void add(const Mechanism& m, double time, std::span<const double> a, std::span<const double> b) {
    for (int i = 0; i < m.link_count(); ++i) {
      const Joint& joint = m.link(i).joint;
      if (joint.nv() == 0 || joint.type == JointType::floating || joint.type == JointType::prismatic) continue;
      double v[6];
      joint_difference(joint, a.data() + m.link(i).q_index, b.data() + m.link(i).q_index, v);
      double sum = 0;
      for (int k = 0; k < std::min(joint.nv(), 3); ++k) sum += v[k] * v[k];
      if (std::sqrt(sum) > angle) {
        angle = std::sqrt(sum);
        angle_time = time;
        link = i;
      }
    }
    std::vector<Pose> X(at(m.link_count())), Y(at(m.link_count()));
    calc_poses(m, a, X);
    calc_poses(m, b, Y);
    const double distance = norm(centre_of_mass(m, Y) - centre_of_mass(m, X));
    if (distance > move) {
      move = distance;
      move_time = time;
    }
  }
};

}  // namespace

Result<std::string> compare_motion(const ShownScenario& project, const Json& request) {
  const auto text = [&](const char* key) {
    return request.contains(key) && request[key].is_string() ? request[key].get<std::string>() : std::string();
  };
  const std::string id = text("character"), clip = text("clip");
  const content::ScenarioCharacter* character = project.scenario().find_character(id);
  if (!character) return fail(ErrorCode::unknown, "character", "There is no character '" + id + "'.", "Give a character's id.");
  const auto own = std::ranges::find(character->track, clip, &content::ScenarioClip::id);
  if (own == character->track.end())
    return fail(ErrorCode::unknown, "clip", "The character has no clip '" + clip + "'.", "Give the id of one of its clips.");
  if (!request.contains("before") || !request["before"].is_object())
    return fail(ErrorCode::syntax, "before", "The request does not contain the earlier clip.", "Give the fields of the clip as an object.");
  const auto mechanism = project.resources().mechanisms.find(character->mechanism);
  if (mechanism == project.resources().mechanisms.end())
    return fail(ErrorCode::unknown, "character", "The project does not contain the mechanism of '" + id + "'.",
                "Choose another character.");
  const Mechanism& m = *mechanism->second;
  Result<content::Scenario> earlier = with_clip(project, id, clip, request["before"]);
  if (!earlier) return fail(std::move(earlier.error()));
  Result<Track> before = make_track(*earlier, project.resources(), id, m), now = make_track(project.scenario(), project.resources(), id, m);
  if (!before) return fail(std::move(before.error()));
  if (!now) return fail(std::move(now.error()));

  const double from = own->start, length = own->length;
  const std::size_t count = std::clamp<std::size_t>(static_cast<std::size_t>(length * rate) + 1, 2, max_poses);
  const double step = length / static_cast<double>(count - 1);
  std::vector<double> a(at(m.nq())), b(at(m.nq()));
  Largest largest;
  Json poses = Json::array();
  for (std::size_t i = 0; i < count; ++i) {
    // the last sample is just before the end, where the next clip may begin
    const double time = from + (i + 1 < count ? static_cast<double>(i) * step : length * (1 - 1e-9));
    before->sample_at(m, time, a);
    now->sample_at(m, time, b);
    largest.add(m, time, a, b);
    poses.push_back(poses_json(m, a, 1e-4));
  }
  const Json out = {{"from", from},
                    {"step", step},
                    {"poses", std::move(poses)},
                    {"link", largest.link},
                    {"degrees", rounded(largest.angle * 180 / std::numbers::pi, 1e-3)},
                    {"time", largest.angle_time},
                    {"move", rounded(largest.move, 1e-5)},
                    {"move_time", largest.move_time}};
  const std::string body = json::to_text(out);
  return "," + body.substr(1, body.size() - 2);
}

}  // namespace ugoki::studio
