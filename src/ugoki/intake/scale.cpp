#include "ugoki/intake/scale.h"

#include <algorithm>

#include "ugoki/base/number.h"
#include "ugoki/intake/gravity_time.h"
#include "ugoki/intake/support.h"
#include "ugoki/intake/tree_edit.h"

namespace ugoki::intake {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

}  // namespace

std::optional<Vec3> up_by_posture(const body::Character& character) {
  if (character.plan != body::BodyPlan::human) return std::nullopt;
  const Vec3 u = character.up;
  int axis = 0;
  for (int k = 1; k < 3; ++k)
    if (std::fabs(u[k]) > std::fabs(u[axis])) axis = k;
  if (std::fabs(u[axis]) < 0.8 || u.z > 0.5 || (axis == 2 && u.z > 0)) return std::nullopt;
  Vec3 up{};
  up[axis] = u[axis] > 0 ? 1 : -1;
  return up;
}

std::optional<double> unit_by_height(const body::Character& character, double metres_per_unit, bool trusted) {
  if (character.plan != body::BodyPlan::human || !(character.leg_length > 0)) return std::nullopt;
  const double height = character.leg_length / 0.491;
  if (trusted ? height > 0.55 && height < 2.8 : height > 1.25 && height < 2.15) return std::nullopt;
  // Units that motion files use: m, dm, cm, mm, inch, foot, and the inch of the CMU skeletons divided by their scale of 0.45.
  double best = 0, smallest = 1e300;
  for (const double unit : {1.0, 0.1, 0.01, 0.001, 0.0254, 0.3048, 0.0254 / 0.45}) {
    const double away = std::fabs(std::log(height / metres_per_unit * unit / 1.7));
    if (away < smallest) {
      smallest = away;
      best = unit;
    }
  }
  // If no usual unit gives a usual height, the character gets a height of 1.7 m. 0.22: a usual height is 1.7 m within a factor of 1.25.
  if (smallest > 0.22) return metres_per_unit * 1.7 / height;
  if (std::fabs(std::log(height / 1.7)) <= smallest + 1e-9) return std::nullopt;
  return best;
}

MissingTravel find_missing_travel(const body::Character& character, const MeasuredMotion& motion) {
  if (character.plan == body::BodyPlan::other) return {};
  std::vector<int> feet;
  for (const body::Limb& l : character.legs) feet.push_back(l.tip >= 0 ? l.tip : l.end);
  if (character.plan == body::BodyPlan::four_legs)
    for (const body::Limb& l : character.arms) feet.push_back(l.tip >= 0 ? l.tip : l.end >= 0 ? l.end : l.distal);
  const std::vector<std::vector<Pose>> world = world_of(motion);
  std::vector<Vec3> body, points(world.size());
  for (const auto& X : world) body.push_back(X[at(character.pelvis)].p);
  std::vector<FootTrack> tracks;
  for (const int foot : feet) {
    for (std::size_t f = 0; f < world.size(); ++f) points[f] = world[f][at(foot)].p;
    tracks.push_back(foot_track(points, motion.rate));
  }
  return ugoki::find_missing_travel(tracks, body, motion.rate, character.leg_length);
}

void add_travel(MeasuredMotion& motion, const std::vector<Vec3>& shift) {
  const std::size_t n = motion.skeleton.joints.size();
  for (std::size_t f = 0; f < at(motion.frames); ++f)
    for (std::size_t i = 0; i < n; ++i)
      if (motion.skeleton.joints[i].parent < 0) motion.translations[f * n + i] += shift[f];
}

std::vector<Change> suit_to_gravity(MeasuredMotion& measured, const body::Body& body) {
  constexpr double far = 0.08;  // share of the height
  std::vector<Change> out;
  Motion motion = body::to_motion(body, measured);
  if (std::string sentence = retime_to_gravity(measured, *body.mechanism, motion, body.height); !sentence.empty()) {
    out.push_back({std::move(sentence)});
    motion = body::to_motion(body, measured);
  }
  if (motion.frames != measured.frames) return out;
  const std::vector<double> heights = hovering_heights(*body.mechanism, motion, body.height);
  if (heights.empty()) return out;
  const std::size_t n = measured.skeleton.joints.size();
  for (std::size_t f = 0; f < heights.size(); ++f)
    for (std::size_t j = 0; j < n; ++j)
      if (measured.skeleton.joints[j].parent < 0) measured.translations[f * n + j].z -= heights[f];
  const double highest = *std::ranges::max_element(heights);
  out.push_back({measured.name + ": the character was lowered by up to " + to_fixed(100 * highest, 1) +
                     " cm where it hovers above the floor without falling, or falls faster than gravity.",
                 highest > far * body.height});
  return out;
}

}  // namespace ugoki::intake
