#include "ugoki/gait/posture.h"

#include <algorithm>
#include <cmath>

#include "ugoki/mechanism/state.h"
#include "ugoki/spatial/elementary.h"

namespace ugoki::gait {
namespace {

using retarget::Slot;

std::size_t at(int i) { return static_cast<std::size_t>(i); }
constexpr double degree = pi / 180;
constexpr double stretch = 0.9995;  // maximum extension of a leg as a share of its length

Mat3 about_x(double a) { return rotation_about({1, 0, 0}, a); }
Mat3 about_y(double a) { return rotation_about({0, 1, 0}, a); }
Mat3 about_z(double a) { return rotation_about({0, 0, 1}, a); }

/// Rotation at the share s of the way from a to b.
Mat3 between(const Mat3& a, const Mat3& b, double s) { return a * to_matrix(exp_map(log_map(to_quat(a.transposed() * b)) * s)); }

}  // namespace

Poser::Poser(const Walker& w, const GaitOptions& o, const Course& course)
    : w_(w), o_(o), course_(course), solver_(*w.mechanism), X_(at(w.mechanism->link_count())), feet_(w.legs.size()) {
  if (w.biped && w.rig)
    for (const retarget::LimbName name : {retarget::LimbName::left_arm, retarget::LimbName::right_arm}) {
      const retarget::Limb& limb = w.rig->anatomy.limb(name);
      if (!limb.found()) continue;
      for (const int i : limb.links)
        if (limb.slot_of(i) != Slot::girdle) arm_links_.push_back(i);
    }
}

void Poser::set_root(const Pose& X, std::span<double> q) {
  const Pose X_JB = w_.mechanism->link(0).joint.X_PJ.inverse() * X;
  const Quat r = to_quat(X_JB.R);
  const double sign = r.w * q[3] + r.x * q[4] + r.y * q[5] + r.z * q[6] < 0 ? -1 : 1;
  const double values[7] = {X_JB.p.x, X_JB.p.y, X_JB.p.z, sign * r.w, sign * r.x, sign * r.y, sign * r.z};
  std::copy(values, values + 7, q.begin());
}

/// Turns the links from the rotation `from` (of the link before them) to `to` in equal parts. Rotations are those of the anatomical axes.
void Poser::orient_chain(std::span<const int> links, const Mat3& from, const Mat3& to, std::span<double> q) {
  for (std::size_t i = 0; i < links.size(); ++i) {
    const Mat3 axes = between(from, to, static_cast<double>(i + 1) / static_cast<double>(links.size()));
    solver_.place(links[i], q.data(), X_);
    solver_.orient(links[i], axes * w_.rig->F[at(links[i])].transposed(), q.data(), X_);
    solver_.place(links[i], q.data(), X_);
  }
}

/// Closed form for thigh and shank: the start of the inverse kinematics, which finishes the other joints.
void Poser::bend_leg(const WalkerLeg& leg, const Pose& X_WF, std::span<double> q) {
  const retarget::Limb& limb = w_.rig->anatomy.limbs[at(leg.limb)];
  if (!limb.has(Slot::upper) || !limb.has(Slot::lower)) return;
  const std::vector<Pose>& rest = w_.rig->anatomy.X_WB;
  const Vec3 knee0 = rest[at(limb.first(Slot::lower))].p;
  const int foot = limb.has(Slot::end) ? limb.first(Slot::end) : leg.link;
  const double upper = norm(knee0 - rest[at(limb.first(Slot::upper))].p), lower = norm(rest[at(foot)].p - knee0);
  // The foot's first link may be behind `leg.link`; both are then fixed to each other.
  const Vec3 ankle = X_WF * (rest[at(leg.link)].inverse() * rest[at(foot)].p), hip = X_[at(limb.first(Slot::upper))].p;
  const Vec3 line = ankle - hip, down = normalized(line, {0, 0, -1});
  const double d = std::clamp(norm(line), std::fabs(upper - lower) * 1.001 + 1e-6, (upper + lower) * 0.9999);
  const Vec3 side = X_WF.R * leg.R_HF.transposed() * Vec3{0, 1, 0};
  const Vec3 y = normalized(side - down * dot(side, down), {0, 1, 0}), ahead = cross(y, -down);
  const double tilt = acos((upper * upper + d * d - lower * lower) / (2 * upper * d));
  const Vec3 thigh = down * cos(tilt) + ahead * sin(tilt);
  const Vec3 shank = normalized(down * d - thigh * upper);
  const auto turn = [&](Slot slot, const Vec3& along) {
    const Mat3 axes = Mat3::columns(along, y, cross(along, y));
    for (const int i : limb.links) {
      if (limb.slot_of(i) != slot) continue;
      solver_.place(i, q.data(), X_);
      solver_.orient(i, axes * w_.rig->F[at(i)].transposed(), q.data(), X_);
      solver_.place(i, q.data(), X_);
    }
  };
  turn(Slot::upper, thigh);
  turn(Slot::lower, shank);
  for (const int i : leg.chain)
    if (limb.slot_of(i) == Slot::end) {
      solver_.place(i, q.data(), X_);
      solver_.orient(i, X_WF.R * rest[at(leg.link)].R.transposed() * rest[at(i)].R, q.data(), X_);
      solver_.place(i, q.data(), X_);
    }
}

void Poser::set_trunk(int frame, double pitch, const Swing& swing, std::span<double> q) {
  const CourseFrame& b = course_.body[at(frame)];
  const LegFrame& first = course_.legs[0][at(frame)];
  const double phase = phase_of(first), w = 2 * pi * phase;
  const double V = std::fabs(b.speed) / std::sqrt(o_.gravity * w_.hip_height);
  const GaitStyle& style = o_.style;
  const Mat3 H = about_z(b.heading);
  const double slope = atan2(b.slope, 1);
  // Into a curve the body leans so that gravity and centripetal force act along it.
  const double curve = -0.7 * atan2(b.speed * b.turn, o_.gravity);
  const double size = b.moving * std::min(1.15, pow(std::max(V, 1e-3) / 0.42, 0.6));
  if (w_.biped && w_.rig) {
    const double walk = (1 - b.run) * size, run = b.run * b.moving, hips = style.hips;
    const double yaw = hips * degree * (-4.5 * walk * cos(w) - 7 * run * cos(w - 0.3));
    const double list = hips * degree * (3.5 * walk * sin(w + 0.55) + 3 * run * sin(w + 0.3));
    const double tilt = degree * (2 + walk * cos(2 * w) + 4 * run) + 0.35 * style.lean - 0.2 * slope;
    const Mat3 pelvis = H * about_x(curve) * about_z(yaw) * about_x(list) * about_y(tilt + pitch);
    if (w_.rig->anatomy.pelvis == 0)
      set_root({pelvis * w_.rig->F[0].transposed(), {q[0], q[1], q[2]}}, q);
    else
      set_root({H * about_x(curve) * about_y(tilt + pitch) * w_.R_root, {q[0], q[1], q[2]}}, q);
    calc_poses(*w_.mechanism, q, X_);
    const double lean = style.lean + 4 * degree * run + 0.5 * slope + 1.0 * degree * (1 - b.run) * size;
    const Mat3 chest = H * about_x(curve) * about_z(degree * (4 * walk * cos(w) + 9 * run * cos(w - 0.3))) *
                       about_x(-1.2 * degree * walk * sin(w + 0.3)) * about_y(0.5 * degree + lean + pitch);
    orient_chain(w_.rig->anatomy.spine, pelvis, chest, q);
    const double look = 0.4 * atan2(b.turn, 2.0);  // the head turns into a curve
    const Mat3 head = H * about_z(look + degree * 0.8 * walk * cos(w)) *
                      about_y(degree * (1.5 + 0.8 * size * cos(2 * w + 0.6)) + 0.35 * lean + style.head);
    orient_chain(w_.rig->anatomy.neck, chest, head, q);
    for (const retarget::LimbName name : {retarget::LimbName::left_arm, retarget::LimbName::right_arm}) {
      const retarget::Limb& limb = w_.rig->anatomy.limb(name);
      if (!limb.found()) continue;
      const int side = name == retarget::LimbName::left_arm ? 1 : -1;
      const double forward = -side * cos(w - 0.15);  // 1: the arm is farthest ahead, at the touch-down of the opposite leg
      const double range = swing.arms * style.arms;
      const double angle =
          degree * (-1 + b.moving * (-3 * (1 - b.run) - 8 * b.run) + forward * range * (18 * walk + 30 * run)) + 0.4 * lean;
      const double spread = degree * (7 + 3 * run);
      const double flexion =
          std::max(5 * degree, degree * (14 + 8 * walk + 11 * walk * forward * range + run * (62 + 12 * forward)) + style.elbows);
      const Mat3 base = H * about_x(curve) * about_z(degree * 2 * walk * cos(w));
      const Mat3 upper = base * about_y(-angle) * about_x(side * spread) * about_z(-side * 12 * degree);
      const Mat3 lower = upper * about_y(-flexion);
      for (const int i : limb.links) {
        const Slot slot = limb.slot_of(i);
        if (slot == Slot::girdle || slot == Slot::tip) continue;
        solver_.place(i, q.data(), X_);
        solver_.orient(i, (slot == Slot::upper ? upper : lower) * w_.rig->G[at(i)] * w_.rig->F[at(i)].transposed(), q.data(), X_);
        solver_.place(i, q.data(), X_);
      }
    }
  } else {
    const double roll = curve * 0.5 + b.moving * degree * 1.2 * sin(w) * style.hips * (1 - b.spring);
    const double yaw = -1.5 * degree * size * cos(w) * style.hips * (1 - b.spring);
    set_root({H * about_x(roll) * about_z(yaw) * about_y(pitch + style.lean - slope) * w_.R_root, {q[0], q[1], q[2]}}, q);
    calc_poses(*w_.mechanism, q, X_);
    if (w_.rig && !w_.rig->anatomy.neck.empty()) {
      // The neck compensates most of the pitch of the trunk, and follows a curve.
      const std::vector<int>& neck = w_.rig->anatomy.neck;
      const int last = neck.back();
      const Mat3 start = X_[at(last)].R;
      const Mat3 wanted = H * about_z(0.4 * atan2(b.turn, 2.0)) * about_y(0.25 * pitch - 0.5 * slope + style.head) * w_.R_HA.transposed() *
                          w_.rig->anatomy.X_WB[at(last)].R;
      const Vec3 turn = log_map(to_quat(wanted * start.transposed())) / static_cast<double>(neck.size());
      Mat3 sum = Mat3::identity();
      for (const int i : neck) {
        sum = to_matrix(exp_map(turn)) * sum;
        const Mat3 own = sum * X_[at(i)].R;
        solver_.place(i, q.data(), X_);
        solver_.orient(i, own, q.data(), X_);
        solver_.place(i, q.data(), X_);
      }
    }
  }
  calc_poses(*w_.mechanism, q, X_);
}

/// Place of a swing foot that its leg reaches without being stretched out: near full length, small movements of the foot move the joints
/// fast.
Vec3 Poser::within_reach(const WalkerLeg& leg, const Vec3& p) const {
  constexpr double from = 0.92, to = 0.975;  // shares of the length: where the place begins to differ, and its maximum
  const Vec3 hip = X_[at(leg.hip)].p, way = p - hip;
  const double d = norm(way) / leg.length, range = to - from;
  return d <= from ? p : hip + way * ((to - range * range / (range + d - from)) / d);
}

double Poser::pose(int frame, const Vec3& centre, double pitch, const Swing& swing, std::span<double> q) {
  const Mechanism& m = *w_.mechanism;
  set_trunk(frame, pitch, swing, q);
  for (std::size_t k = 0; k < w_.legs.size(); ++k) feet_[k] = foot_pose(w_, o_, course_, k, frame);
  double miss = 0;
  for (int round = 0; round < 8; ++round) {
    const Vec3 error = centre - centre_of_mass(m, X_);
    if (round > 0 && norm(error) < 2e-6) break;
    Pose X = X_[0];
    X.p += error * 1.15;  // the legs do not follow the body
    set_root(X, q);
    calc_poses(m, q, X_);
    miss = 0;
    for (std::size_t k = 0; k < w_.legs.size(); ++k) {
      const WalkerLeg& leg = w_.legs[k];
      retarget::ChainGoal goal;
      goal.point = leg.point;
      goal.target = feet_[k].X_WF * leg.point;
      // A paw is turned by its own joint only; the posture of the other joints of a leg stays near the standing posture.
      const bool free = !w_.biped && !leg.point_foot && leg.chain.size() > 2;
      const bool stands = course_.legs[k][at(frame)].stands;
      if (free && !stands) goal.target = within_reach(leg, goal.target);
      goal.turn = !leg.point_foot && !free;
      goal.R = feet_[k].X_WF.R;
      goal.length = leg.length;
      goal.iterations = round == 0 ? 30 : 6;
      if (round == 0)
        for (const int i : leg.chain)
          std::copy_n(w_.q_stand.data() + m.link(i).q_index, m.link(i).joint.nq(), q.data() + m.link(i).q_index);
      for (const int i : leg.chain) solver_.place(i, q.data(), X_);
      if (leg.limb >= 0) bend_leg(leg, feet_[k].X_WF, q);
      if (free && round == 0) {
        // The foot moves along a straight line from its place in the standing posture, so the posture is a smooth function of its place.
        const Vec3 start = X_[at(leg.link)] * leg.point, way = goal.target - start;
        constexpr int steps = 12;
        goal.iterations = 2;
        for (int i = 1; i <= steps; ++i) {
          goal.target = start + way * (static_cast<double>(i) / steps);
          if (i == steps) goal.iterations = 6;
          solver_.solve(leg.chain, goal, q.data(), X_);
        }
      }
      miss = std::max(miss, solver_.solve(leg.chain, goal, q.data(), X_));
      // The paw may not reach its orientation; then the leg moves until the point on which it stands is at its place.
      const int corrections = !free ? 0 : stands ? 4 : 1;
      for (int i = 0; i < corrections; ++i) {
        if (i > 0) {
          const Vec3 missing = feet_[k].X_WF * feet_[k].pivot - X_[at(leg.link)] * feet_[k].pivot;
          if (norm(missing) < 1e-5) break;
          goal.target += missing;
          goal.iterations = 6;
          solver_.solve(leg.chain, goal, q.data(), X_);
        }
        solver_.place(leg.link, q.data(), X_);
        solver_.orient(leg.link, feet_[k].X_WF.R, q.data(), X_);
        solver_.place(leg.link, q.data(), X_);
      }
      for (const int toe : leg.toes) {
        const Mat3 flat = w_.biped && w_.rig ? w_.rig->F[at(toe)].transposed() : leg.R_HF;
        solver_.place(toe, q.data(), X_);
        solver_.orient(toe, feet_[k].X_WF.R * leg.R_HF.transposed() * about_y(feet_[k].toes) * flat, q.data(), X_);
      }
    }
    calc_poses(m, q, X_);
  }
  return miss;
}

double Poser::excess(int frame) const {
  double lower = -1;
  for (std::size_t k = 0; k < w_.legs.size(); ++k) {
    const WalkerLeg& leg = w_.legs[k];
    const LegFrame& state = course_.legs[k][at(frame)];
    if (!state.stands && state.share > 0.03 && state.share < 0.985) continue;  // a swing leg may be a little short of its path
    const Vec3 hip = X_[at(leg.hip)].p, foot = feet_[k].X_WF * leg.point;
    const double across = norm(Vec3{foot.x - hip.x, foot.y - hip.y, 0}), length = stretch * leg.length;
    const double reach = std::sqrt(std::max(0.0, length * length - across * across));
    lower = std::max(lower, hip.z - foot.z - reach);
  }
  return lower;
}

}  // namespace ugoki::gait
