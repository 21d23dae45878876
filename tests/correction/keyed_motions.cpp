#include <algorithm>
#include <cmath>

#include "keyed_pose.h"
#include "ugoki/mechanism/state.h"
#include "ugoki/spatial/rotation.h"

namespace ugoki::correction {
namespace {

/// Mean place of the soles' middles [m] and the centre of mass, over the ground.
Vec3 lean_of(const Mechanism& m, const std::vector<double>& q) {
  std::vector<Pose> X(m.links().size());
  calc_poses(m, q, X);
  Vec3 feet;
  for (std::size_t i = 0; i < X.size(); ++i)
    if (m.links()[i].name.ends_with("Foot")) feet += (X[i].p + X[i].R * Vec3{0.05, 0, 0}) * 0.5;
  return centre_of_mass(m, X) - feet;
}

/// Turns hips and thighs against each other until the centre of mass is above the soles.
void balance(const Mechanism& m, Key& k) {
  double low = k.turn.y - 0.6, high = k.turn.y + 0.6;
  const Key given = k;
  for (int i = 0; i < 40; ++i) {
    const double pitch = 0.5 * (low + high);
    k.turn.y = pitch;
    k.left.hip = given.left.hip + pitch - given.turn.y;
    k.right.hip = given.right.hip + pitch - given.turn.y;
    (lean_of(m, pose(m, k)).x > 0 ? high : low) = pitch;
  }
}

/// Softens the path of the root as an animator's curves are soft: limbs then hover and sink by millimetres.
void smooth_root(Motion& motion, int rounds) {
  for (int round = 0; round < rounds; ++round) {
    const Motion before = motion;
    for (int f = 1; f + 1 < motion.frames; ++f)
      for (int k = 0; k < 3; ++k) motion.frame(f)[k] = 0.5 * before.frame(f)[k] + 0.25 * (before.frame(f - 1)[k] + before.frame(f + 1)[k]);
  }
}

}  // namespace

Motion keyed_walk(const Mechanism& m, double travel) {
  // contact, down, passing, up: the leading or standing leg, then the other one
  struct Leg {
    double hip, knee, ankle;
  };
  constexpr Leg lead[4] = {{0.42, 0.08, 0.05}, {0.33, 0.35, -0.02}, {0.08, 0.12, -0.04}, {-0.17, 0.1, -0.17}};
  constexpr Leg trail[4] = {{-0.38, 0.35, -0.18}, {-0.3, 0.75, 0.0}, {0.25, 1.05, -0.1}, {0.5, 0.65, -0.05}};
  constexpr double swing[4] = {-0.4, -0.3, 0, 0.3};
  constexpr int per_stride = 60;
  std::vector<Key> keys;
  for (int k = 0; k <= 24; ++k) {  // three strides
    const int phase = k % 4;
    const bool left_leads = k / 4 % 2 == 0;
    Key key;
    key.time = k * 0.125;
    const auto set = [&](Side& side, const Leg& leg, double arm) { side = {{arm, 0.15, -1}, 0.3, leg.hip, leg.knee, leg.ankle, 0}; };
    set(left_leads ? key.left : key.right, lead[phase], swing[phase]);
    set(left_leads ? key.right : key.left, trail[phase], -swing[phase]);
    key.place.x = travel * k / 8.0;
    key.turn.y = 0.03;
    const std::vector<double> q = pose(m, key);
    key.place.z = -lowest_point(m, q);
    keys.push_back(key);
  }
  Motion three = through_keys(m, keys, per_stride, 7);
  Motion out = three;
  const auto nq = static_cast<std::size_t>(out.nq);
  out.name = "keyed walk";
  out.frames = per_stride + 1;
  out.cyclic = true;
  out.q.assign(three.frame(per_stride), three.frame(2 * per_stride) + nq);
  return out;
}

Motion keyed_cartwheel(const Mechanism& m) {
  // The body turns about x, to its left (y), with arms and legs stretched and apart.
  const auto key = [](double time, double roll, double apart, double arms, double knee) {
    Key k;
    k.time = time;
    k.turn = {-roll, 0, 0};
    k.left = {{0.1, 0.35, arms}, 0.05, 0.0, knee, 0.0, apart};
    k.right = k.left;
    return k;
  };
  constexpr double turn = 6.283185307179586;
  const std::vector<Key> keys = {
      key(0, 0, 0.05, -1, 0.05),           key(0.4, 0, 0.05, -1, 0.05),         key(1.0, 0.1, 0.45, 1, 0.05),
      key(1.6, 1.3, 0.65, 1, 0.05),        key(2.2, 0.5 * turn, 0.65, 1, 0.05), key(2.8, turn - 1.3, 0.65, 1, 0.05),
      key(3.4, turn - 0.1, 0.45, 1, 0.05), key(4.0, turn, 0.05, -1, 0.05),      key(4.4, turn, 0.05, -1, 0.05)};
  Motion out = through_keys(m, keys, 60, 20);
  roll_over_ground(m, out);
  smooth_root(out, 30);
  out.name = "keyed cartwheel";
  return out;
}

Motion keyed_tuck_jump(const Mechanism& m, double rate) {
  const auto key = [&](double time, double up, double pitch, double thigh, double shank, double arm) {
    Key k;
    k.time = time;
    k.turn.y = pitch;
    k.left = {{arm, 0.2, arm > 0.5 ? 0.3 : -1}, 0.2, pitch + thigh, shank + thigh, -shank, 0.05};
    k.right = k.left;
    balance(m, k);
    k.place.z = up - lowest_point(m, pose(m, k));
    return k;
  };
  const std::vector<Key> keys = {key(0, 0, 0, 0.03, 0.03, 0.1),     key(0.4, 0, 0, 0.03, 0.03, 0.1),  key(0.8, 0, 0.5, 0.9, 0.45, -0.5),
                                 key(1.05, 0, 0.05, 0.05, 0.05, 1), key(1.25, 0.3, 0.2, 0.7, 0.6, 1), key(1.45, 0, 0.05, 0.1, 0.1, 0.6),
                                 key(1.75, 0, 0.5, 0.9, 0.45, 0.3), key(2.3, 0, 0, 0.03, 0.03, 0.1),  key(2.8, 0, 0, 0.03, 0.03, 0.1)};
  Motion out = through_keys(m, keys, rate, 2);
  out.name = "keyed jump";
  return out;
}

Motion keyed_get_up(const Mechanism& m) {
  const auto key = [](double time, double pitch, double spine, double arm_ahead, double arm_down, double thigh, double shank) {
    // thigh, shank: rad, angles from the vertical in the world, knee ahead; the sole is flat
    Key k;
    k.time = time;
    k.turn.y = pitch;
    k.spine = spine;
    k.left = {{arm_ahead, 0.2, arm_down}, 0.15, pitch + thigh, shank + thigh, -shank, 0.05};
    k.right = k.left;
    return k;
  };
  std::vector<Key> keys = {key(0, 1.0, 0.22, 1, -0.1, 1.0, 0.45),  key(0.5, 1.0, 0.22, 1, -0.1, 1.0, 0.45),
                           key(1.4, 0.75, 0.2, 1, -0.5, 1.2, 0.5), key(2.2, 0.7, 0.15, 0.6, -1, 1.1, 0.5),
                           key(3.4, 0.3, 0.05, 0.1, -1, 0.4, 0.2), key(4.2, 0.02, 0, 0.1, -1, 0.05, 0.03),
                           key(5.4, 0.0, 0, 0.1, -1, 0.03, 0.03)};
  for (std::size_t k = 2; k < keys.size(); ++k) balance(m, keys[k]);
  Motion out = through_keys(m, keys, 60, 10);
  roll_over_ground(m, out);
  out.name = "keyed get-up";
  return out;
}

}  // namespace ugoki::correction
