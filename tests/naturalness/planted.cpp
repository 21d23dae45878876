#include "planted.h"

#include <algorithm>
#include <cmath>

#include "../correction/faults.h"
#include "ugoki/mechanism/state.h"
#include "ugoki/motion/clip.h"
#include "ugoki/motion_edit/foot_contacts.h"
#include "ugoki/naturalness/legs.h"

namespace ugoki::naturalness {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

void move(const Mechanism& m, Motion& motion, int f, const Vec3& by, double turn = 0) {
  displace_root(m, {by.x, by.y, by.z, turn}, {motion.frame(f), at(motion.nq)});
}

/// Turns the joint of `link` by `angle` [rad] about the axis of its DOF `k`.
void bend(const Mechanism& m, Motion& motion, int f, int link, int k, double angle) {
  std::vector<double> v(at(m.nv()), 0.0);
  v[at(m.link(link).v_index + k)] = angle;
  std::vector<double> q(motion.frame(f), motion.frame(f) + motion.nq);
  integrate(m, q, v, 1, {motion.frame(f), at(motion.nq)});
}

/// The body turns to and fro about the vertical by 40 degrees, 1.5 times per second.
Motion twisting(const Mechanism& m, const Motion& clean) {
  Motion out = clean;
  for (int f = 0; f < out.frames; ++f) {
    std::vector<double> v(at(m.nv()), 0.0);
    v[2] = 0.7 * std::sin(2 * 3.14159265 * 1.5 * f / out.rate);
    std::vector<double> q(out.frame(f), out.frame(f) + out.nq);
    integrate(m, q, v, 1, {out.frame(f), at(out.nq)});
  }
  return out;
}

/// The head nods by 6 degrees, five times per second.
Motion nodding(const Mechanism& m, const Motion& clean) {
  Motion out = clean;
  const int head = find_legs(m).head;
  if (head < 0) return out;
  const int neck = m.link(m.link(head).parent).joint.nv() > 0 ? m.link(head).parent : head;
  for (int f = 0; f < out.frames; ++f)
    for (int k = 0; k < m.link(neck).joint.nv(); ++k) bend(m, out, f, neck, k, 0.25 * std::sin(2 * 3.14159265 * 5 * f / out.rate));
  return out;
}

/// A hip shakes by 30 degrees, five times per second.
Motion shaking(const Mechanism& m, const Motion& clean) {
  Motion out = clean;
  const BodyLegs body = find_legs(m);
  const int link = body.legs.empty() || body.legs[0].knee < 0 ? m.link_count() - 1 : body.legs[0].hip;
  for (int f = 0; f < out.frames; ++f) bend(m, out, f, link, 0, 0.5 * std::sin(2 * 3.14159265 * 5 * f / out.rate));
  return out;
}

/// The root stops over the ground while the character is in the air.
Motion stopping(const Mechanism& m, const Motion& clean) {
  Motion out = clean;
  const motion_edit::FootContacts contacts = motion_edit::find_contacts(m, clean);
  Vec3 lost;
  for (int f = 1; f < out.frames; ++f) {
    int since = 0;  // frames in the air
    while (since < f && std::ranges::none_of(contacts.bears, [&](const auto& on) { return on[at(f - since)] != 0; })) ++since;
    const double *a = clean.frame(f - 1), *b = clean.frame(f);
    const double slow = std::min(0.8, 6.0 * since / out.rate);
    lost += Vec3{b[0] - a[0], b[1] - a[1], 0} * (since > 0 ? slow : 0.0);
    move(m, out, f, -lost);
  }
  return out;
}

/// The character floats in the air: flights take 1.6 times as long.
Motion slow_flight(const Mechanism& m, const Motion& clean) {
  Motion out = clean;
  const motion_edit::FootContacts contacts = motion_edit::find_contacts(m, clean);
  out.q.clear();
  out.contacts.clear();
  std::vector<double> q(at(clean.nq));
  double t = 0;
  const double end = clean.duration();
  while (t < end) {
    sample(clean, m, t, q);
    out.q.insert(out.q.end(), q.begin(), q.end());
    const std::size_t f = std::min(at(clean.frames - 1), at(static_cast<int>(t * clean.rate)));
    const bool air = std::ranges::none_of(contacts.bears, [&](const auto& on) { return on[f] != 0; });
    t += (air ? 1 / 1.6 : 1.0) / clean.rate;
  }
  out.frames = static_cast<int>(out.q.size()) / out.nq;
  return out;
}

/// The whole motion twice as fast.
Motion hasty(const Mechanism&, const Motion& clean) {
  Motion out = clean;
  out.rate *= 2;
  return out;
}

Motion from_correction(const char* name, const Mechanism& m, const Motion& clean) {
  for (const correction::Fault& fault : correction::faults())
    if (fault.name == name) {
      Motion out = fault.plant(m, clean);
      out.contacts.clear();  // labels of the clean motion
      return out;
    }
  return clean;
}
template <int I>
Motion plant(const Mechanism& m, const Motion& clean) {
  static constexpr const char* names[] = {"floating", "sliding",     "gravity", "jerky",    "floor",
                                          "limbs",    "penetrating", "popping", "drifting", "mistimed"};
  return from_correction(names[I], m, clean);
}

}  // namespace

const std::vector<Planted>& walk_faults() {
  using enum MeasureId;
  static const std::vector<Planted> all = {{"floating", plant<0>, {hover}},
                                           {"sliding", plant<1>, {slip}},
                                           {"jerky", plant<3>, {jerk}},
                                           {"floor", plant<4>, {root_force}},
                                           {"limbs", plant<5>, {penetration}},
                                           {"penetrating", plant<6>, {penetration}},
                                           {"popping", plant<7>, {jerk}},
                                           {"drifting", plant<8>, {slip}},
                                           {"mistimed", plant<9>, {step_symmetry, stance_symmetry}},
                                           {"twisting", twisting, {angular_momentum}},
                                           {"nodding", nodding, {head_acceleration}},
                                           {"shaking", shaking, {torque}},
                                           {"hasty", hasty, {step_force}},
                                           {"shaking", shaking, {work}}};
  return all;
}

const std::vector<Planted>& flight_faults() {
  using enum MeasureId;
  static const std::vector<Planted> all = {
      {"heavy", plant<2>, {flight_gravity}}, {"slow flight", slow_flight, {flight_gravity}}, {"stopping", stopping, {flight_speed}}};
  return all;
}

}  // namespace ugoki::naturalness
