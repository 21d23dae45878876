#include "ugoki/correction/observe.h"

#include <algorithm>
#include <cmath>

#include "ugoki/control/contact_forces.h"
#include "ugoki/correction/contacts.h"
#include "ugoki/dynamics/centroidal.h"
#include "ugoki/dynamics/dynamics.h"
#include "ugoki/mechanism/state.h"
#include "ugoki/motion/clip.h"
#include "ugoki/motion/foot_slip.h"
#include "ugoki/motion/measures.h"
#include "ugoki/spatial/elementary.h"

namespace ugoki::correction {
namespace {

/// m: points of a sole that are at most this far above its lowest point carry load. Soles of captures tilt by a few degrees in stance,
/// which raises one end of a sole of 0.25 m by 2 cm.
constexpr double loaded_height = 0.025;
constexpr double leg_of_constants = 0.9;  // m: heights scale with the leg

std::size_t at(int i) { return static_cast<std::size_t>(i); }

/// Central differences of a sequence; one-sided at its ends.
std::vector<Vec3> rate_of(const std::vector<Vec3>& x, double rate) {
  std::vector<Vec3> out(x.size());
  for (std::size_t i = 0; i < x.size(); ++i) {
    const std::size_t a = i > 0 ? i - 1 : i, b = std::min(i + 1, x.size() - 1);
    out[i] = (x[b] - x[a]) * (rate / static_cast<double>(std::max<std::size_t>(1, b - a)));
  }
  return out;
}

/// rms over frames and joints of the third difference of the joints' rotations, 1000 rad/s^3.
double rms_jerk(const Mechanism& m, const Motion& motion) {
  const std::size_t nv = at(m.nv());
  std::vector<std::vector<double>> v;
  for (int f = 0; f + 1 < motion.frames; ++f) {
    v.emplace_back(nv);
    difference(m, {motion.frame(f), at(motion.nq)}, {motion.frame(f + 1), at(motion.nq)}, v.back());
  }
  double sum = 0, count = 0;
  const double r3 = motion.rate * motion.rate * motion.rate;
  for (std::size_t f = 1; f + 1 < v.size(); ++f)
    for (std::size_t i = 6; i < nv; ++i) {
      const double jerk = (v[f - 1][i] - 2 * v[f][i] + v[f + 1][i]) * r3 / 1000;
      sum += jerk * jerk;
      count += 1;
    }
  return count > 0 ? std::sqrt(sum / count) : 0;
}

/// Maximum excess [deg] of a limit of a rotational DOF.
double worst_limit(const Mechanism& m, const Motion& motion) {
  double worst = 0, x[6];
  for (int f = 0; f < motion.frames; ++f)
    for (const Link& link : m.links()) {
      const JointType type = link.joint.type;
      if (type != JointType::revolute && type != JointType::universal && type != JointType::spherical) continue;
      joint_displacement(link.joint, motion.frame(f) + link.q_index, x);
      for (int k = 0; k < link.joint.nv(); ++k) {
        const Dof& d = link.joint.dofs[at(k)];
        worst = std::max({worst, x[k] - d.upper, d.lower - x[k]});
      }
    }
  return worst * 180 / pi;
}

}  // namespace

void displace(const Mechanism& m, const Pose& X, double* q) {
  const Joint& root = m.link(0).joint;
  const Pose X_JB = root.X_PJ.inverse() * X * root.X_PJ * joint_pose(root, q);
  const Quat r = to_quat(X_JB.R);
  const double sign = r.w * q[3] + r.x * q[4] + r.y * q[5] + r.z * q[6] < 0 ? -1 : 1;  // keep the sign: quaternions change continuously
  const double values[7] = {X_JB.p.x, X_JB.p.y, X_JB.p.z, sign * r.w, sign * r.x, sign * r.y, sign * r.z};
  std::copy(values, values + 7, q);
}

namespace {

/// Times without supports that last long enough, and in which the body leaves the floor.
std::vector<Flight> find_flights(const Observation& o, double clearance) {
  std::vector<Flight> flights;
  const auto flies = [&](int f) { return o.supports[at(f)].empty(); };
  for (int f = 0; f < o.frames(); ++f) {
    if (!flies(f)) continue;
    const int first = f;
    while (f + 1 < o.frames() && flies(f + 1)) ++f;
    const double highest = *std::max_element(o.clearance.begin() + first, o.clearance.begin() + f + 1);
    if (first > 0 && f + 1 < o.frames() && f - first + 1 >= min_flight * o.rate && highest >= clearance) flights.push_back({first, f});
  }
  return flights;
}

}  // namespace

Observation observe(const Mechanism& m, const Motion& motion, const motion_edit::FootContacts& contacts) {
  Observation o;
  const int n = motion.frames;
  o.rate = motion.rate;
  dynamics::Workspace ws(m);
  std::vector<double> v(at(m.nv()));
  o.supports.resize(at(n));
  o.on_feet.assign(at(n), 1);
  o.clearance.assign(at(n), 1e300);
  o.trunk_clearance.assign(at(n), 1e300);
  const std::vector<LinkPoint> others = other_points(m, contacts);
  const double leg = motion_edit::mean_leg_length(contacts.feet), size = leg > 0 ? leg / leg_of_constants : 1;
  for (int f = 0; f < n; ++f) {
    const int a = std::max(0, f - 1), b = std::min(n - 1, f + 1);
    difference(m, {motion.frame(a), at(motion.nq)}, {motion.frame(b), at(motion.nq)}, v);
    for (double& x : v) x *= motion.rate / std::max(1, b - a);
    dynamics::update_kinematics(m, {motion.frame(f), at(motion.nq)}, v, ws);
    const dynamics::Centroidal c = dynamics::calc_centroidal(m, ws);
    o.mass = c.mass;
    o.centre.push_back(c.centre);
    o.spin.push_back(c.momentum.w);
    o.inertia.push_back(c.inertia);
    const auto lowest = [&](const LinkPoint& p) { return ws.X_WB[at(p.link)] * p.location.p - Vec3{0, 0, p.location.radius}; };
    for (std::size_t k = 0; k < contacts.feet.size(); ++k) {
      std::vector<Vec3> points;
      double low = 1e300;
      for (const LinkPoint& p : contacts.feet[k].points) {
        points.push_back(lowest(p));
        low = std::min(low, points.back().z);
      }
      o.clearance[at(f)] = std::min(o.clearance[at(f)], low);
      if (!contacts.bears[k][at(f)]) continue;
      if (m.link(contacts.feet[k].link).label.starts_with("hand")) o.on_feet[at(f)] = 0;
      for (const Vec3& p : points)
        if (p.z <= low + loaded_height) o.supports[at(f)].push_back(p);
    }
    for (const LinkPoint& p : others) {
      const Vec3 point = lowest(p);
      o.trunk_clearance[at(f)] = std::min(o.trunk_clearance[at(f)], point.z);
      if (point.z > other_height * size) continue;
      o.supports[at(f)].push_back(point);
      o.on_feet[at(f)] = 0;
    }
    o.clearance[at(f)] = std::min(o.clearance[at(f)], o.trunk_clearance[at(f)]);
  }
  o.moment = rate_of(o.spin, motion.rate);
  o.acceleration.resize(at(n));
  for (int f = 1; f + 1 < n; ++f)
    o.acceleration[at(f)] = (o.centre[at(f - 1)] - o.centre[at(f)] * 2 + o.centre[at(f + 1)]) * (motion.rate * motion.rate);
  if (n > 2) {
    o.acceleration.front() = o.acceleration[1];
    o.acceleration.back() = o.acceleration[at(n - 2)];
  }
  o.flights = find_flights(o, min_clearance * size);
  return o;
}

CorrectionMeasures measure(const Mechanism& m, const Motion& motion, const motion_edit::FootContacts& contacts,
                           const CorrectOptions& options) {
  CorrectionMeasures out;
  const int n = motion.frames;
  const Observation o = observe(m, motion, contacts);
  // Slip and penetration, as `ugoki judge` measures them
  const std::vector<int> feet = find_feet(m);
  FootSlip slip(m, feet);
  GroundPenetration depth(m);
  Motion labelled = motion;
  label_contacts(m, labelled, feet);
  std::vector<Pose> X(at(m.link_count()));
  std::vector<std::uint8_t> on(feet.size());
  for (int f = 0; f < n; ++f) {
    calc_poses(m, {motion.frame(f), at(motion.nq)}, X);
    for (std::size_t k = 0; k < feet.size(); ++k) on[k] = labelled.contacts[k].on[at(f)];
    slip.add(X, on, 1 / motion.rate);
    depth.add(X);
  }
  out.skate_cm = slip.mean_cm();
  out.penetration_mm = depth.worst_mm();
  // Missing wrench
  const double weight = o.mass * options.gravity;
  control::ContactForceProblem problem;
  std::vector<control::Support> supports;
  std::vector<Vec3> forces;
  double residual = 0;
  for (int f = 1; f + 1 < n; ++f) {
    const Vec6 wanted{o.moment[at(f)], (o.acceleration[at(f)] + Vec3{0, 0, options.gravity}) * o.mass};
    supports.clear();
    const double heading = root_placement(m, {motion.frame(f), at(motion.nq)}).heading;
    const Vec3 along{cos(heading), sin(heading), 0};
    for (const Vec3& p : o.supports[at(f)]) supports.push_back({{p.x, p.y, 0}, {0, 0, 1}, options.friction, 1, along});
    forces.resize(supports.size());
    const Vec6 missing = supports.empty() ? wanted : problem.solve(supports, o.centre[at(f)], wanted, 1, 1e-6, forces);
    residual += (dot(missing.v, missing.v) + dot(missing.w, missing.w)) / (weight * weight);
  }
  out.residual_bw = n > 2 ? std::sqrt(residual / (n - 2)) : 0;
  double fall = 0, spin = 0, frames = 0;
  for (const Flight& flight : o.flights) {
    Vec3 mean;
    for (int f = flight.first; f <= flight.last; ++f) mean += o.spin[at(f)] / flight.frames();
    for (int f = flight.first + 1; f < flight.last; ++f) {
      const Vec3 a = o.acceleration[at(f)] + Vec3{0, 0, options.gravity}, h = (o.spin[at(f)] - mean) / o.mass;
      fall += dot(a, a) / (options.gravity * options.gravity);
      spin += dot(h, h);
      frames += 1;
    }
  }
  if (frames > 0) {
    out.flight_g = std::sqrt(fall / frames);
    out.spin = std::sqrt(spin / frames);
  }
  out.jerk = rms_jerk(m, motion);
  out.limit_deg = worst_limit(m, motion);
  return out;
}

double rms_change(const Mechanism& m, const Motion& a, const Motion& b, double& root_cm) {
  double turn = 0, way = 0, d[6];
  int joints = 0;
  for (int f = 0; f < a.frames; ++f)
    for (std::size_t i = 0; i < m.links().size(); ++i) {
      const Link& link = m.links()[i];
      if (link.joint.nv() == 0) continue;
      joint_difference(link.joint, a.frame(f) + link.q_index, b.frame(f) + link.q_index, d);
      if (i == 0) {
        way += d[3] * d[3] + d[4] * d[4] + d[5] * d[5];
        continue;
      }
      if (link.joint.type == JointType::prismatic) continue;
      if (f == 0) ++joints;
      for (int k = 0; k < link.joint.nv(); ++k) turn += d[k] * d[k];
    }
  root_cm = 100 * std::sqrt(way / a.frames);
  return joints > 0 ? std::sqrt(turn / (static_cast<double>(a.frames) * joints)) * 180 / pi : 0;
}

}  // namespace ugoki::correction
