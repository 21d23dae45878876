#include "ugoki/naturalness/judge_motion.h"

#include <algorithm>
#include <cmath>

#include "ugoki/control/contact_forces.h"
#include "ugoki/dynamics/dynamics.h"
#include "ugoki/mechanism/state.h"
#include "ugoki/motion/clip.h"
#include "ugoki/motion/smooth_motion.h"
#include "ugoki/motion_edit/foot_contacts.h"
#include "ugoki/spatial/heading.h"

namespace ugoki::naturalness {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

constexpr double cutoff = 6;             // Hz, for a centre of mass at 0.95 m (Winter 2009: human gait)
constexpr double cutoff_height = 0.95;   // m
constexpr double cyclic_duration = 4;    // s
constexpr double loaded_height = 0.025;  // m: points of a sole up to this far above its lowest point bear load (correction/observe.cpp)
/// s: the load of a foot grows during this time after touch-down and decreases during this time before lift-off, in double support.
constexpr double load_time = 0.12;

Motion repeated_motion(const Mechanism& m, const Motion& cycle) {
  if (!cycle.cyclic || cycle.frames < 2 || cycle.duration() >= cyclic_duration) return cycle;
  const int rounds = static_cast<int>(std::ceil(cyclic_duration / cycle.duration()));
  Motion out = cycle;
  out.cyclic = false;
  out.q.clear();
  for (ContactTrack& track : out.contacts) track.on.clear();
  const Placement way = cycle_of(cycle, m);
  const auto nq = at(cycle.nq);
  for (int r = 0; r < rounds; ++r)
    for (int f = 0; f + (r + 1 < rounds ? 1 : 0) < cycle.frames; ++f) {
      out.q.insert(out.q.end(), cycle.frame(f), cycle.frame(f) + nq);
      displace_root(m, repeated(way, r), {out.q.data() + out.q.size() - nq, nq});
      for (std::size_t k = 0; k < out.contacts.size(); ++k) out.contacts[k].on.push_back(cycle.contacts[k].on[at(f)]);
    }
  out.frames = static_cast<int>(out.q.size() / nq);
  return out;
}

/// [frames] Share of the load that a foot takes, from its contacts: above 0 and at most 1 in contact.
std::vector<double> load_shares(const std::vector<std::uint8_t>& bears, double rate) {
  const int n = static_cast<int>(bears.size()), ramp = std::max(1, static_cast<int>(load_time * rate));
  std::vector<double> out(bears.size());
  for (int f = 0; f < n; ++f) {
    if (!bears[at(f)]) continue;
    int edge = ramp;
    for (int k = 1; k <= ramp; ++k)  // the begin and the end of the recording are no ends of contacts
      if ((f - k >= 0 && !bears[at(f - k)]) || (f + k < n && !bears[at(f + k)])) {
        edge = k;
        break;
      }
    out[at(f)] = (edge - 0.5) / ramp;
  }
  return out;
}

/// Forces of the feet and torques of the joints from the accelerations of a filtered motion.
class Inverse {
 public:
  Inverse(const Mechanism& m, const BodyLegs& body, const motion_edit::FootContacts& contacts, double rate, const JudgeOptions& options)
      : m_(m), body_(body), options_(options), ws_(m), external_(at(m.link_count())), forces(body.legs.size()), torque(at(m.nv())) {
    for (const auto& bears : contacts.bears) shares_.push_back(load_shares(bears, rate));
    std::vector<bool> is_foot(at(m.link_count()));
    for (const Leg& leg : body.legs)
      for (const int part : leg.limb.parts) is_foot[at(part)] = true;
    for (int i = 0; i < m.link_count(); ++i)
      if (!is_foot[at(i)])
        for (const SupportPoint& p : support_points(m.link(i))) others_.push_back({i, p});
  }

  void solve(int frame, std::span<const double> q, std::span<const double> v, std::span<const double> a) {
    dynamics::update_kinematics(m_, q, v, ws_);
    std::ranges::fill(external_, Vec6{});
    std::ranges::fill(forces, Vec3{});
    if (!body_.legs.empty()) {
      const dynamics::Centroidal c = dynamics::calc_centroidal(m_, ws_);
      Vec6 wanted = dynamics::calc_centroidal_momentum_rate(m_, ws_, a);
      wanted.v += Vec3{0, 0, options_.gravity} * c.mass;
      find_supports(frame);
      loads_.resize(supports_.size());
      missing = supports_.empty() ? wanted
                                  : problem_.solve(supports_, c.centre, wanted, std::max(0.05, c.centre.z - options_.ground), 1e-6, loads_);
      for (std::size_t i = 0; i < supports_.size(); ++i) {
        external_[at(links_[i])] += Vec6{cross(supports_[i].p, loads_[i]), loads_[i]};
        if (legs_[i] >= 0) forces[at(legs_[i])] += loads_[i];
      }
    }
    dynamics::calc_inverse_dynamics(m_, ws_, a, {0, 0, -options_.gravity}, external_, torque);
  }

 private:
  void find_supports(int frame) {
    supports_.clear();
    links_.clear();
    legs_.clear();
    const Vec3 heading = heading_of(ws_.X_WB[0].R);
    for (std::size_t k = 0; k < body_.legs.size(); ++k) {
      const double share = shares_[k][at(frame)];
      if (share <= 0) continue;
      points_.clear();
      double low = 1e300;
      for (const LinkPoint& p : body_.legs[k].limb.points) {
        points_.push_back(ws_.X_WB[at(p.link)] * p.location.p - Vec3{0, 0, p.location.radius});
        low = std::min(low, points_.back().z);
      }
      for (std::size_t i = 0; i < points_.size(); ++i) {
        if (points_[i].z > low + loaded_height) continue;
        supports_.push_back({{points_[i].x, points_[i].y, options_.ground}, {0, 0, 1}, options_.friction, 1 / share, heading});
        links_.push_back(body_.legs[k].limb.points[i].link);
        legs_.push_back(static_cast<int>(k));
      }
    }
    // Hands, knees, the trunk and other links bear load where they are on the ground: rolls, push-ups, falls.
    const double low = options_.ground + loaded_height * body_.centre_height / cutoff_height;
    for (const LinkPoint& p : others_) {
      const Vec3 point = ws_.X_WB[at(p.link)] * p.location.p - Vec3{0, 0, p.location.radius};
      if (point.z > low) continue;
      supports_.push_back({{point.x, point.y, options_.ground}, {0, 0, 1}, options_.friction, 1, heading});
      links_.push_back(p.link);
      legs_.push_back(-1);
    }
  }

  const Mechanism& m_;
  const BodyLegs& body_;
  JudgeOptions options_;
  dynamics::Workspace ws_;
  control::ContactForceProblem problem_;
  std::vector<std::vector<double>> shares_;
  std::vector<control::Support> supports_;
  std::vector<LinkPoint> others_;  // support points of all links that are not feet
  std::vector<int> links_, legs_;  // of each support; leg -1: not a foot
  std::vector<Vec3> loads_, points_;
  std::vector<Vec6> external_;

 public:
  std::vector<Vec3> forces;    ///< [legs] N
  std::vector<double> torque;  ///< [nv] N m | N
  Vec6 missing;                ///< N m about the centre of mass, N
};

}  // namespace

Report judge_motion(const Mechanism& m, const Motion& given, const JudgeOptions& options) {
  Motion motion = repeated_motion(m, given);
  MeterOptions meter_options;
  meter_options.gravity = options.gravity;
  meter_options.ground = options.ground;
  Meter meter(m, meter_options);
  const BodyLegs& body = meter.body();
  const double hz = std::min(0.25 * motion.rate, cutoff * std::sqrt(cutoff_height / body.centre_height));
  const SmoothMotion smooth(motion, m, hz);
  // Feet of faulty motions hover and slide: the thresholds are those of the correction of motions.
  std::vector<motion_edit::FootLimb> limbs;
  for (const Leg& leg : body.legs) limbs.push_back(leg.limb);
  motion_edit::FootContactOptions tolerant;
  tolerant.ground = options.ground;
  tolerant.height_on = 0.05;
  tolerant.height_off = 0.065;
  tolerant.speed_on = 0.5;
  tolerant.speed_off = 0.9;
  const motion_edit::FootContacts contacts = motion_edit::find_contacts(m, motion, limbs, tolerant);
  if (motion.contacts.empty() && !body.feet.empty()) {
    ContactLabelOptions labels;
    labels.ground = options.ground;
    label_contacts(m, motion, body.feet, labels);
  }
  std::vector<const ContactTrack*> tracks(body.feet.size(), nullptr);
  for (std::size_t i = 0; i < body.feet.size(); ++i)
    for (const ContactTrack& track : motion.contacts)
      if (track.link == m.link(body.feet[i]).name) tracks[i] = &track;

  Inverse inverse(m, body, contacts, motion.rate, options);
  Recorder recorder;
  std::vector<Pose> X(at(m.link_count()));
  std::vector<std::uint8_t> stance(body.feet.size()), touches(body.legs.size());
  std::vector<double> q(at(m.nq())), v(at(m.nv())), a(at(m.nv()));
  for (int f = 0; f < motion.frames; ++f) {
    calc_poses(m, {motion.frame(f), at(motion.nq)}, X);
    for (std::size_t i = 0; i < stance.size(); ++i) stance[i] = tracks[i] ? tracks[i]->on[at(f)] : 0;
    for (std::size_t k = 0; k < touches.size(); ++k) touches[k] = contacts.bears[k][at(f)];
    smooth.sample(m, f / motion.rate, q, v, a);
    inverse.solve(f, q, v, a);
    Sample s;
    s.dt = 1 / motion.rate;
    s.q = {motion.frame(f), at(motion.nq)};
    s.v = v;
    s.X_WB = X;
    s.stance = stance;
    s.stands = s.touches = touches;
    s.forces = inverse.forces;
    s.torque = inverse.torque;
    // The filter does not know the motion before its first and after its last frame.
    const double margin = 0.15;  // s
    const bool inside = motion.frames < 4 * margin * motion.rate || (f > margin * motion.rate && f < motion.frames - margin * motion.rate);
    s.has_missing = inside && !body.legs.empty();
    s.missing_moment = inverse.missing.w;
    s.missing_force = inverse.missing.v;
    if (!inside) s.torque = {};
    if (!inside) s.forces = {};
    meter.add(s);
    recorder.add(meter.now());
  }
  return recorder.finish(meter.totals(), given.name, motion.rate);
}

}  // namespace ugoki::naturalness
