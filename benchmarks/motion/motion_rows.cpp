// One minute of motion capture at 120 frames per second: read, filtered, retargeted and written; compared with assimp's BVH reader.

#include <cmath>
#include <functional>
#include <stdexcept>

#include "assimp_bvh.h"
#include "table.h"
#include "ugoki/body/body.h"
#include "ugoki/formats/bvh.h"
#include "ugoki/mechanism_edit/growth.h"
#include "ugoki/motion/smooth_motion.h"
#include "ugoki/motion_edit/to_measured.h"
#include "ugoki/retarget/retarget.h"
#include "ugoki/samples/samples.h"

namespace ugoki::benchmarks {
namespace {

constexpr int frames = 7200;

/// The sample's walk with four fingers on each hand: 30 joints.
MeasuredMotion walk_with_fingers() {
  const MeasuredMotion plain = samples::make_human_walk();
  MeasuredMotion m = plain;
  for (int hand = 0; hand < plain.joint_count(); ++hand) {
    const std::string name = plain.skeleton.joints[static_cast<std::size_t>(hand)].name;
    if (!name.ends_with("Hand")) continue;
    const double side = name.starts_with("Left") ? 1 : -1;
    double forward = 0.04;
    for (const char* finger : {"Thumb1", "Index1", "Middle1", "Ring1"}) {
      SkeletonJoint j;
      j.name = name + finger;
      j.parent = hand;
      j.offset = {forward, (forward > 0.03 ? 0.03 : 0.09) * side, 0};
      j.end_sites = {{0, 0.07 * side, 0}};
      j.dofs = {{{0, 0, 1}}, {{1, 0, 0}}, {{0, 1, 0}}};
      m.skeleton.joints.push_back(j);
      forward -= 0.02;
    }
  }
  const auto before = static_cast<std::ptrdiff_t>(plain.skeleton.joints.size());
  m.translations.clear();
  m.rotations.clear();
  for (std::ptrdiff_t f = 0; f < plain.frames; ++f) {
    m.translations.insert(m.translations.end(), plain.translations.begin() + f * before, plain.translations.begin() + (f + 1) * before);
    m.rotations.insert(m.rotations.end(), plain.rotations.begin() + f * before, plain.rotations.begin() + (f + 1) * before);
    for (std::size_t j = plain.skeleton.joints.size(); j < m.skeleton.joints.size(); ++j) {
      m.translations.push_back(m.skeleton.joints[j].offset);
      m.rotations.push_back({});
    }
  }
  return m;
}

/// walk_with_fingers() repeated for 60 s with a little noise, so that no two cycles are equal.
MeasuredMotion minute() {
  const MeasuredMotion walk = walk_with_fingers();
  MeasuredMotion m = walk;
  m.rate = 120;
  m.frames = frames;
  m.translations.clear();
  m.rotations.clear();
  const std::size_t n = walk.skeleton.joints.size();
  const int round = walk.frames - 1;
  const Vec3 step = walk.translations[static_cast<std::size_t>(round) * n] - walk.translations[0];
  unsigned seed = 1;
  const auto noise = [&] {
    seed = seed * 1664525u + 1013904223u;
    return (static_cast<double>(seed >> 8) / (1 << 24) - 0.5) * 2e-3;
  };
  for (int f = 0; f < frames; ++f)
    for (std::size_t j = 0; j < n; ++j) {
      const std::size_t at = static_cast<std::size_t>(f % round) * n + j;
      Vec3 p = walk.translations[at];
      if (j == 0) p += Vec3{step.x, step.y, 0} * (f / round);
      m.translations.push_back(p);
      m.rotations.push_back(normalized(walk.rotations[at] * exp_map({noise(), noise(), noise()})));
    }
  return m;
}

template <class T>
T required(Result<T> r) {
  if (!r) throw std::runtime_error(r.error().text());
  return std::move(*r);
}

/// Applies the zero-lag Butterworth filter to every coordinate.
Motion filtered(const Motion& motion, const Mechanism& mechanism) {
  const SmoothMotion smooth(motion, mechanism, 6);
  Motion out = motion;
  std::vector<double> v(static_cast<std::size_t>(mechanism.nv())), a(v.size());
  for (int f = 0; f < motion.frames; ++f) smooth.sample(mechanism, f / motion.rate, {out.frame(f), static_cast<std::size_t>(out.nq)}, v, a);
  return out;
}

void rows(Table& table) {
  const MeasuredMotion source = minute();
  const std::string text = formats::write_bvh(source, {.metres_per_unit = 0.01, .decimals = 6});
  const formats::BvhOptions centimetres{.metres_per_unit = 0.01};
  const MeasuredMotion read = required(formats::read_bvh(text, "minute.bvh", centimetres));
  const std::string title = std::to_string(source.joint_count()) + " joints, 60 s at 120 Hz: ";

  const AssimpMotion theirs = read_bvh_with_assimp(text);
  std::vector<double> ours;
  for (int f = 0; f < frames; ++f) {
    const Vec3 p = read.translations[static_cast<std::size_t>(f) * read.skeleton.joints.size()] * 100.0;
    for (const double x : {p.y, p.z, p.x}) ours.push_back(x);
  }
  require_same(ours, theirs.root, 1e-6, "BVH");
  const std::vector<double> reading =
      measure({[&] { (void)required(formats::read_bvh(text, "minute.bvh", centimetres)); }, [&] { (void)read_bvh_with_assimp(text); }}, 2);
  table.add({title + "read BVH", reading[0], "assimp", reading[1], 0});

  const body::Body body = required(body::make_body(read));
  const Motion motion = body::to_motion(body, read);
  const MechanismPtr child = required(grow(*body.mechanism, {.age = 8})).mechanism;
  const Motion smooth = filtered(motion, *body.mechanism);
  const Motion moved = required(retarget::retarget(body.mechanism, smooth, child)).motion;
  const MeasuredMotion to_write = motion_edit::to_measured(*child, moved);
  const formats::BvhWriteOptions how{.metres_per_unit = 0.01, .decimals = 6};
  const auto minimum = [](const std::function<void()>& f) { return measure({f}, 1)[0]; };
  table.add({title + "onto the body", minimum([&] { (void)body::to_motion(body, read); }), "", 0, 0});
  table.add({title + "low-pass filter, 6 Hz", minimum([&] { (void)filtered(motion, *body.mechanism); }), "", 0, 0});
  table.add({title + "retarget to a child", minimum([&] { (void)required(retarget::retarget(body.mechanism, smooth, child)); }), "", 0, 0});
  table.add({title + "write BVH", minimum([&] { (void)formats::write_bvh(to_write, how); }), "", 0, 0});
  table.add({title + "all of it (goal: 0.5 s)", minimum([&] {
               const MeasuredMotion m = required(formats::read_bvh(text, "minute.bvh", centimetres));
               const Motion onto = filtered(body::to_motion(body, m), *body.mechanism);
               const Motion other = required(retarget::retarget(body.mechanism, onto, child)).motion;
               (void)formats::write_bvh(motion_edit::to_measured(*child, other), how);
             }),
             "", 0, 0});
}
const RowRegistration registration(100, rows);

}  // namespace
}  // namespace ugoki::benchmarks
