#include "keyed_roll.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "keyed_pose.h"
#include "ugoki/mechanism/state.h"
#include "ugoki/motion/contact_labels.h"
#include "ugoki/spatial/rotation.h"

namespace ugoki::correction {
namespace {

struct RollKey {
  double time;                     // s
  double pitch, ahead;             // rad, m: of the hips
  Vec3 arm;                        // direction of the left arm in the frame of the chest
  double elbow, hip, knee, ankle;  // rad, flexed; ankle: toes down
  double spine, neck;              // rad, of each of three and two joints
};

// clang-format off
constexpr std::array<RollKey, 10> keys{{
    {0.0,  0.0,  0.00,  {0.1, 0.25, -1},   0.2, 0.03, 0.06, -0.03, 0.0, 0.0},    // stands
    {0.2,  0.0,  0.00,  {0.1, 0.25, -1},   0.2, 0.03, 0.06, -0.03, 0.0, 0.0},
    {1.1,  0.75, -0.05, {1, 0.2, -0.2},    0.3, 2.05, 2.1,  -0.5,  0.2, 0.2},    // squats
    {1.45, 1.05, 0.0,   {1, 0.25, 0.1},    0.3, 2.0,  2.0,  -0.3,  0.3, 0.5},    // leans ahead
    {1.7,  1.6,  0.15,  {1, 0.25, 0.4},    0.5, 1.9,  1.5,  0.2,   0.4, 0.75},   // hands on the floor
    {1.9,  2.35, 0.40,  {1, 0.3, 0.6},     1.3, 2.1,  0.9,  0.4,   0.6, 0.75},   // on the shoulders
    {2.12, 3.3,  0.65,  {1, 0.3, 0.3},     1.3, 2.15, 0.8,  0.4,   0.65, 0.75},  // rolls over the back
    {2.38, 4.3,  0.95,  {1, 0.3, -0.2},    0.3, 2.1,  1.9,  0.3,   0.6, 0.6},
    {2.6,  4.8,  1.05,  {1, 0.3, -0.5},    0.2, 1.6,  2.1,  0.1,   0.3, 0.4},    // lies on the back, feet on the floor
    {3.2,  4.8,  1.05,  {1, 0.3, -0.6},    0.2, 1.5,  2.0,  0.1,   0.2, 0.3}}};
// clang-format on

std::vector<double> pose(const Mechanism& m, const RollKey& k) {
  std::vector<double> q = m.neutral();
  for (const double side : {1.0, -1.0}) {
    const std::string s = side > 0 ? "Left" : "Right";
    set_joint(m, s + "Arm", arm_turn(side, {k.arm.x, side * k.arm.y, k.arm.z}), q);
    set_joint(m, s + "ForeArm", {k.elbow, 0, 0}, q);
    set_joint(m, s + "UpLeg", {0, -k.hip, 0}, q);
    set_joint(m, s + "Leg", {0, k.knee, 0}, q);
    set_joint(m, s + "Foot", {0, k.ankle, 0}, q);
  }
  for (const char* name : {"Spine", "Spine1", "Chest"}) set_joint(m, name, {0, k.spine, 0}, q);
  for (const char* name : {"Neck", "Head"}) set_joint(m, name, {0, k.neck, 0}, q);
  const Quat turn{std::cos(0.5 * k.pitch), 0, std::sin(0.5 * k.pitch), 0};
  q[0] = k.ahead, q[1] = q[2] = 0;
  q[3] = turn.w, q[4] = turn.x, q[5] = turn.y, q[6] = turn.z;
  return q;
}

/// m: mean place ahead of the toes.
double toes(const Mechanism& m, std::span<const double> q) {
  std::vector<Pose> X(m.links().size());
  calc_poses(m, q, X);
  double x = 0;
  for (std::size_t i = 0; i < X.size(); ++i)
    if (m.links()[i].name.ends_with("ToeBase")) x += 0.5 * X[i].p.x;
  return x;
}

}  // namespace

Motion keyed_roll(const Mechanism& m) {
  const auto nq = static_cast<std::size_t>(m.nq());
  Motion roll;
  roll.name = "roll";
  roll.mechanism = m.name();
  roll.rate = 60;
  roll.nq = m.nq();
  roll.frames = static_cast<int>(std::lround(keys.back().time * roll.rate)) + 1;
  const auto frame = [&](int f) { return std::span(roll.frame(f), nq); };
  roll.q.resize(nq * static_cast<std::size_t>(roll.frames));
  for (int f = 0; f < roll.frames; ++f) {
    std::size_t k = 0;
    while (k + 2 < keys.size() && keys[k + 1].time <= f / roll.rate) ++k;
    double s = std::clamp((f / roll.rate - keys[k].time) / (keys[k + 1].time - keys[k].time), 0.0, 1.0);
    if (k < 2 || k + 3 > keys.size()) s = s * s * (3 - 2 * s);
    interpolate(m, pose(m, keys[k]), pose(m, keys[k + 1]), s, frame(f));
  }
  std::vector<double> mean(nq);
  for (int round = 0; round < 7; ++round) {  // softens the keys
    const Motion before = roll;
    for (int f = 1; f + 1 < roll.frames; ++f) {
      interpolate(m, std::span(before.frame(f - 1), nq), std::span(before.frame(f + 1), nq), 0.5, mean);
      interpolate(m, std::span(before.frame(f), nq), mean, 0.5, frame(f));
    }
  }
  const double stand = toes(m, frame(0));
  double shift = 0;
  for (int f = 0; f < roll.frames; ++f) {  // the toes stay in place until the hands are on the floor; the lowest point is on the floor
    if (f <= 1.7 * roll.rate) shift = stand - toes(m, frame(f));
    frame(f)[0] += shift;
    frame(f)[2] -= lowest_point(m, frame(f));
  }
  return roll;
}

}  // namespace ugoki::correction
