#include "ugoki/content/track.h"

#include <algorithm>

namespace ugoki::content {

Clip to_clip(const ScenarioClip& clip) {
  Clip out;
  out.start = clip.start;
  out.length = clip.length;
  out.offset = clip.offset;
  out.speed = clip.speed;
  out.blend = clip.blend;
  out.loop = clip.loop;
  return out;
}

Placement to_placement(const ScenarioPlace& place) { return {place.x, place.y, place.z, place.heading * (pi / 180)}; }

MechanismPtr place_root(const MechanismPtr& mechanism, const Placement& place) {
  if (place == Placement{} || mechanism->link_count() == 0) return mechanism;
  const JointType root = mechanism->link(0).joint.type;
  if (root == JointType::floating || root == JointType::planar) return mechanism;
  const Pose X = to_pose(place);
  MechanismSpec spec = mechanism->spec();
  for (LinkSpec& link : spec.links)
    if (link.parent.empty()) link.joint.X_PJ = X * link.joint.X_PJ;
  for (LoopSpec& loop : spec.loops) {
    if (loop.link_a.empty()) loop.X_AJ = X * loop.X_AJ;
    if (loop.link_b.empty()) loop.X_BJ = X * loop.X_BJ;
  }
  return Mechanism::make(std::move(spec)).value();
}

std::vector<Clip> lay_track(const ScenarioCharacter& character, const Mechanism& mechanism, const Resources& resources) {
  std::vector<Clip> track;
  Placement at = to_placement(character.place);
  for (std::size_t i = 0; i < character.track.size(); ++i) {
    const ScenarioClip& source = character.track[i];
    Clip clip = to_clip(source);
    if (character.control.mode == ControlMode::torque) {  // the first state is a state in the world
      track.push_back(clip);
      continue;
    }
    if (i > 0) at = floor_placement(track.back(), *resources.motions.find(character.track[i - 1].motion)->second, mechanism, clip.start);
    lay_clip(clip, *resources.motions.find(source.motion)->second, mechanism, at);
    track.push_back(clip);
  }
  return track;
}

double calc_end_speed(const ScenarioCharacter& character, const Mechanism& mechanism, const Resources& resources) {
  if (character.track.empty() || mechanism.link(0).joint.type != JointType::floating) return 0;
  for (const ScenarioClip& clip : character.track)
    if (!resources.motions.contains(clip.motion)) return 0;
  const Clip last = lay_track(character, mechanism, resources).back();
  const Motion& motion = *resources.motions.find(character.track.back().motion)->second;
  constexpr double span = 0.1;  // s, interval of the finite difference: long enough to average measurement noise, shorter than a walking
                                // step
  const double end = last.start + last.length, before = std::max(last.start, end - span);
  if (!(end > before)) return 0;
  std::vector<double> q0(static_cast<std::size_t>(mechanism.nq())), q1(q0.size());
  sample(last, motion, mechanism, before, q0);
  sample(last, motion, mechanism, end, q1);
  return norm(Vec3{q1[0] - q0[0], q1[1] - q0[1], q1[2] - q0[2]}) / (end - before);
}

std::vector<double> start_position(const ScenarioCharacter& character, const Mechanism& mechanism, const std::vector<Clip>& track,
                                   const Resources& resources) {
  std::vector<double> q = mechanism.neutral();
  if (track.empty())
    displace_root(mechanism, to_placement(character.place), q);
  else
    sample(track.front(), *resources.motions.find(character.track.front().motion)->second, mechanism, 0, q);
  return q;
}

}  // namespace ugoki::content
