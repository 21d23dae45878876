#include "outcome.h"

#include <algorithm>

#include "ugoki/content/generate.h"
#include "ugoki/content/player.h"
#include "ugoki/mechanism/state.h"
#include "ugoki/motion/clip.h"
#include "ugoki/motion/contact_labels.h"

namespace ugoki::dialects {
namespace {

Outcome run(const MechanismPtr& mechanism, const std::shared_ptr<const Motion>& motion) {
  content::Scenario s;
  s.name = "run";
  s.duration = std::max(0.01, motion->duration());
  content::ScenarioCharacter character;
  character.id = character.name = "character";
  character.mechanism = "mechanism";
  const Placement start = root_placement(*mechanism, {motion->frame(0), static_cast<std::size_t>(motion->nq)});
  character.place = {start.x, start.y, 0, start.heading * (180 / pi)};
  content::ScenarioClip clip;
  clip.id = "clip";
  clip.motion = "motion";
  clip.length = s.duration;
  character.track.push_back(clip);
  s.characters.push_back(character);
  content::Resources resources;
  resources.mechanisms["mechanism"] = mechanism;
  resources.motions["motion"] = motion;
  const auto ugx = content::generate(s, resources);
  if (!ugx) return {.error = ugx.error().text()};
  auto player = content::Player::open(*ugx);
  if (!player) return {.error = player.error().text()};
  Outcome out;
  while (player->time() < s.duration)
    if (const auto done = player->step(); !done) {
      out.error = done.error().text();
      break;
    }
  const content::PlayerMeasures m = player->measures(0);
  out.tracking = m.tracking_rms_deg;
  out.assist = m.assist_rms_bw;
  out.released = m.release_time;
  return out;
}

}  // namespace

Outcome simulate(const intake::Intake& in) { return run(in.mechanism, std::make_shared<const Motion>(*in.motion)); }

Outcome stand(const intake::Intake& in, double duration) {
  const Mechanism& m = *in.mechanism;
  const Motion& motion = *in.motion;
  const auto links = static_cast<std::size_t>(m.link_count());
  const auto nq = static_cast<std::size_t>(motion.nq);
  // Find the frame whose link positions, relative to the root and heading, are closest to their mean.
  std::vector<std::vector<Vec3>> p(static_cast<std::size_t>(motion.frames), std::vector<Vec3>(links));
  std::vector<Vec3> mean(links);
  std::vector<Pose> X(links);
  for (int f = 0; f < motion.frames; ++f) {
    calc_poses(m, std::span(motion.frame(f), nq), X);
    const double heading = root_placement(m, std::span(motion.frame(f), nq)).heading;
    for (std::size_t i = 0; i < links; ++i) {
      p[static_cast<std::size_t>(f)][i] = rotation_about({0, 0, 1}, -heading) * (X[i].p - X[0].p);
      mean[i] += p[static_cast<std::size_t>(f)][i] / motion.frames;
    }
  }
  int best = 0;
  double smallest = 1e300;
  for (int f = 0; f < motion.frames; ++f) {
    double error = 0;
    for (std::size_t i = 0; i < links; ++i) {
      const Vec3 d = p[static_cast<std::size_t>(f)][i] - mean[i];
      error += dot(d, d);
    }
    if (error < smallest) {
      smallest = error;
      best = f;
    }
  }
  std::vector<double> q(motion.frame(best), motion.frame(best) + motion.nq);
  calc_poses(m, q, X);
  double low = 1e300;
  for (std::size_t i = 0; i < links; ++i)
    for (const SupportPoint& s : support_points(m.links()[i])) low = std::min(low, (X[i] * s.p).z - s.radius);
  if (low < 1e200 && m.link(0).joint.type == JointType::floating) q[2] -= low;
  auto held = std::make_shared<Motion>();
  held->name = "stand";
  held->mechanism = motion.mechanism;
  held->nq = motion.nq;
  held->rate = 10;
  held->frames = static_cast<int>(duration * held->rate) + 1;
  for (int f = 0; f < held->frames; ++f) held->q.insert(held->q.end(), q.begin(), q.end());
  return run(in.mechanism, held);
}

}  // namespace ugoki::dialects
