#include "ugoki/retarget/driver.h"

#include <algorithm>
#include <cmath>

#include "ugoki/mechanism/state.h"

namespace ugoki::retarget {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }
constexpr double max_tilt = 0.35;  // rad, maximum tilt of the target's trunk if source and target are of different kinds (biped, quadruped)

/// True if a and b are equal up to rounding: each row of a - b has a norm of at most 1e-9.
bool near(const Mat3& a, const Mat3& b) {
  const Mat3 d = a - b;
  for (int i = 0; i < 3; ++i)
    if (norm(d.row(i)) > 1e-9) return false;
  return true;
}

/// Rotation about Z contained in r (the twist of its swing-twist decomposition).
Quat heading_of(const Quat& r) { return normalized(std::fabs(r.w) + std::fabs(r.z) > 1e-12 ? Quat{r.w, 0, 0, r.z} : Quat{}); }

/// Returns R with its tilt compressed smoothly to less than `max_tilt`; the heading is kept.
Mat3 levelled(const Mat3& R) {
  const Quat r = to_quat(R), heading = heading_of(r);
  const Vec3 tilt = log_map(r * heading.conjugate());
  const double angle = norm(tilt);
  if (angle < 1e-9) return R;
  const double soft = angle / (1 + angle / max_tilt);
  return to_matrix(exp_map(tilt * (soft / angle)) * heading);
}

}  // namespace

Driver::Driver(const Rig& source, const Rig& target, const Mapping& mapping)
    : s_(source), t_(target), same_kind_(source.anatomy.four_legs == target.anatomy.four_legs), solver_(*target.mechanism) {
  scale_ = same_kind_ && !t_.anatomy.four_legs ? t_.leg_length / s_.leg_length : t_.hip_height / s_.hip_height;
  path_scale_ = scale_;
  goal_of_.assign(at(t_.mechanism->link_count()), -1);
  partner_.assign(goal_of_.size(), -1);
  limbs_.resize(limb_count);
  map_trunk();
  map_limbs();
  map_extras(mapping);
  make_clusters();
  // A knee with at least 0.4 rad of flexion must not overextend by more than 0.03 rad, even if its mechanical limits allow more.
  for (int k = 0; k < 2; ++k) {
    const LimbRig& limb = t_.limbs[at(k)];
    if (!limb.found || limb.knee < 0 || (partner_[at(limb.knee)] >= 0 && is_twin(partner_[at(limb.knee)], limb.knee))) continue;
    const int f = t_.mechanism->link(limb.knee).v_index;
    double &low = solver_.lower[at(f)], &high = solver_.upper[at(f)];
    if (limb.knee_sign > 0 && high > 0.4 && low < -0.03) low = -0.03;
    if (limb.knee_sign < 0 && low < -0.4 && high > 0.03) high = 0.03;
  }
}

void Driver::add_goal(int target, int a, int b, double t, bool deviation, bool level) {
  if (target < 0 || a < 0) return;
  LinkGoal w;
  w.link = target;
  w.a = a;
  w.b = b;
  w.t = t;
  w.level = level;
  w.K = t_.F[at(target)].transposed();
  if (deviation) w.K = s_.G[at(a)].transposed() * (t_.G[at(target)] * w.K);
  goal_of_[at(target)] = static_cast<int>(goals_.size());
  goals_.push_back(w);
}

/// Maps a chain of source links to a chain of target links. If the chains have different numbers of links, each target link follows the
/// source link at the same relative position, or an interpolation of the two source links around this position.
void Driver::map_chain(const std::vector<int>& source, int source_base, const std::vector<int>& target, bool level) {
  const auto n = static_cast<double>(source.size()), count = static_cast<double>(target.size());
  int dofs = 3;  // DOFs of the joints since the link that last got a goal; an orientation needs at least three
  for (std::size_t i = target.size(); i-- > 0;) {
    const bool last = i + 1 == target.size();
    if (source.size() == target.size()) partner_[at(target[i])] = source[i];
    if (!last && dofs < 3) {
      dofs += t_.mechanism->link(target[i]).joint.nv();
      continue;
    }
    dofs = t_.mechanism->link(target[i]).joint.nv();
    const double u = n * static_cast<double>(i + 1) / count;
    if (source.empty()) {
      add_goal(target[i], source_base, -1, 0, !same_kind_, level);
      continue;
    }
    const double down = std::floor(u + 1e-9);
    const auto k = static_cast<int>(down);
    const int a = k == 0 ? source_base : source[at(k - 1)];
    if (u - down < 1e-9 || k >= static_cast<int>(source.size()))
      add_goal(target[i], a, -1, 0, !same_kind_, level);
    else
      add_goal(target[i], a, source[at(k)], u - down, !same_kind_, level);
  }
}

void Driver::map_trunk() {
  const Anatomy &s = s_.anatomy, &t = t_.anatomy;
  const bool level = !same_kind_;
  partner_[at(t.pelvis)] = s.pelvis;
  add_goal(t.pelvis, s.pelvis, -1, 0, !same_kind_, level);
  map_chain(s.spine, s.pelvis, t.spine, level);
  map_chain(s.neck, s.chest(), t.neck, level);
  if (!s.tail.empty()) map_chain(s.tail, s.pelvis, t.tail, level);
}

void Driver::map_limbs() {
  for (int k = 0; k < limb_count; ++k) {
    const LimbRig& limb = t_.limbs[at(k)];
    LimbDrive& drive = limbs_[at(k)];
    if (!limb.found) continue;
    const Limb& target = t_.anatomy.limbs[at(k)];
    drive.ground = k < 2 || t_.anatomy.four_legs;
    drive.source = k;
    if (k >= 2 && t_.anatomy.four_legs && !s_.anatomy.four_legs) drive.source = 3 - k;  // a fore leg follows the diagonally opposite leg
    if (!s_.limbs[at(drive.source)].found) {
      drive.source = -1;
      if (drive.ground) drive.source = k == 2 ? 1 : k == 3 ? 0 : -1;
      if (!drive.ground)  // an undriven arm hangs beside the chest
        for (const Slot slot : {Slot::upper, Slot::lower}) add_goal(target.last(slot), s_.anatomy.chest(), -1, 0, true, !same_kind_);
      if (drive.source < 0) continue;
    }
    const Limb& source = s_.anatomy.limbs[at(drive.source)];
    drive.mode = drive.ground && (!same_kind_ || drive.source != k) ? LimbMode::placed : LimbMode::copied;
    drive.flat = drive.ground && (!same_kind_ || s_.limbs[at(drive.source)].point_foot);
    if (drive.mode == LimbMode::placed) {
      if (!t_.anatomy.four_legs)
        for (const Slot slot : {Slot::upper, Slot::lower}) add_goal(target.last(slot), s_.anatomy.pelvis, -1, 0, true, true);
      continue;
    }
    const bool deviation = !same_kind_ || t_.anatomy.four_legs;
    for (int i = 0; i < slot_count; ++i) {
      const auto slot = static_cast<Slot>(i);
      if (!target.has(slot)) continue;
      const int from = source.begin[at(i)], count = source.begin[at(i) + 1] - from;
      if (count == target.begin[at(i) + 1] - target.begin[at(i)])
        for (int n = 0; n < count; ++n) partner_[at(target.links[at(target.begin[at(i)] + n)])] = source.links[at(from + n)];
      if (source.has(slot)) add_goal(target.last(slot), source.last(slot), -1, 0, deviation, false);
    }
  }
}

void Driver::map_extras(const Mapping& mapping) {
  const Mechanism &s = *s_.mechanism, &t = *t_.mechanism;
  std::vector<bool> used(at(s.link_count()), false);
  for (const int i : partner_)
    if (i >= 0) used[at(i)] = true;
  for (const auto& [from, to] : mapping.links) {
    const int a = s.find_link(from), b = t.find_link(to);
    if (a < 0 || b < 0) continue;
    if (s.link(a).joint.type == t.link(b).joint.type)
      extras_.emplace_back(a, b);
    else if (goal_of_[at(b)] < 0)
      add_goal(b, a, -1, 0, !same_kind_, false);
    partner_[at(b)] = a;
    used[at(a)] = true;
  }
  for (int i = 0; i < t.link_count(); ++i) {
    if (goal_of_[at(i)] >= 0 || partner_[at(i)] >= 0 || t.link(i).joint.nv() == 0 || i == 0) continue;
    const int a = s.find_link(t.link(i).name);
    if (a < 0 || used[at(a)] || a == 0) continue;
    const Joint &x = s.link(a).joint, &y = t.link(i).joint;
    if (x.type != y.type || norm(x.axis - y.axis) > 1e-9) continue;
    extras_.emplace_back(a, i);
    partner_[at(i)] = a;
  }
}

bool Driver::is_twin(int source, int target) const {
  if (source < 0) return false;
  const Link &s = s_.mechanism->link(source), &t = t_.mechanism->link(target);
  if (s.joint.type != t.joint.type || !near(s.joint.X_PJ.R, t.joint.X_PJ.R)) return false;
  if (norm(s.joint.axis - t.joint.axis) > 1e-9 || norm(s.joint.axis2 - t.joint.axis2) > 1e-9) return false;
  if (!near(s_.F[at(source)], t_.F[at(target)]) || !near(s_.G[at(source)], t_.G[at(target)])) return false;
  return s.parent >= 0 && t.parent >= 0 && partner_[at(t.parent)] == s.parent && near(s_.F[at(s.parent)], t_.F[at(t.parent)]);
}

void Driver::make_clusters() {
  const Mechanism& m = *t_.mechanism;
  std::vector<bool> owned(at(m.link_count()), false);
  for (int i = 0; i < m.link_count(); ++i) {
    if (goal_of_[at(i)] < 0) continue;
    Cluster c;
    c.goal = goal_of_[at(i)];
    int dofs = 0, twins = 0, movable = 0;
    for (int k = i; k >= 0 && !owned[at(k)]; k = m.link(k).parent) {
      c.links.insert(c.links.begin(), k);
      owned[at(k)] = true;
    }
    for (const int k : c.links) {
      const Joint& joint = m.link(k).joint;
      c.twins.push_back(partner_[at(k)]);
      if (joint.nv() == 0) continue;
      ++movable;
      c.movable = k;
      dofs += joint.nv();
      if (is_twin(partner_[at(k)], k)) ++twins;
    }
    if (c.links.empty()) continue;
    const JointType type = c.movable >= 0 ? m.link(c.movable).joint.type : JointType::fixed;
    if (c.links.front() == 0 && m.link(0).joint.type == JointType::floating) {
      c.kind = Kind::root;
      c.movable = 0;
    } else if (movable == twins) {
      c.kind = Kind::twin;
    } else if (movable == 1 && (type == JointType::spherical || type == JointType::revolute)) {
      c.kind = Kind::single;
    }
    c.from_stand = dofs > 3;
    if (c.movable >= 0) {
      std::vector<Pose> X(at(m.link_count()));
      calc_poses(m, t_.q_stand, X);
      c.R_rel = X[at(c.movable)].R.transposed() * X[at(i)].R;
    }
    clusters_.push_back(std::move(c));
  }
  std::erase_if(extras_, [&](const std::pair<int, int>& e) { return owned[at(e.second)]; });
}

Mat3 Driver::goal_rotation(const LinkGoal& w, std::span<const Pose> X_S) const {
  Mat3 O = X_S[at(w.a)].R * s_.F[at(w.a)];
  if (w.b >= 0) O = to_matrix(slerp(to_quat(O), to_quat(X_S[at(w.b)].R * s_.F[at(w.b)]), w.t));
  if (w.level) O = levelled(O);
  return O * w.K;
}

void Driver::solve(const Cluster& c, std::span<const double> q_S, std::span<const Pose> X_S, double* q, std::span<Pose> X) {
  const Mechanism& m = *t_.mechanism;
  if (c.kind == Kind::twin) {
    for (std::size_t i = 0; i < c.links.size(); ++i) {
      const Link& link = m.link(c.links[i]);
      if (c.twins[i] >= 0 && link.joint.nq() > 0) {
        const double* own = q_S.data() + s_.mechanism->link(c.twins[i]).q_index;
        std::copy(own, own + link.joint.nq(), q + link.q_index);
        solver_.clamp(c.links[i], q);
      }
      solver_.place(c.links[i], q, X);
    }
    return;
  }
  const LinkGoal& w = goals_[at(c.goal)];
  const Mat3 R = goal_rotation(w, X_S);
  if (c.kind == Kind::root || c.kind == Kind::single) {
    bool there = true;
    for (const int i : c.links) {
      if (i == c.movable)
        there = solver_.orient(i, R * c.R_rel.transposed(), q, X);
      else
        solver_.place(i, q, X);
    }
    if (there || c.kind == Kind::root || m.link(c.movable).joint.type == JointType::revolute) return;
  }
  if (c.from_stand)
    for (const int i : c.links) {
      const Link& link = m.link(i);
      std::copy_n(t_.q_stand.data() + link.q_index, link.joint.nq(), q + link.q_index);
    }
  for (const int i : c.links) solver_.place(i, q, X);
  ChainGoal goal;
  goal.first = ChainGoal::First::direction;
  goal.point = norm(t_.along[at(w.link)]) > 0 ? t_.along[at(w.link)] : t_.F[at(w.link)].column(2);
  goal.target = R * goal.point;
  goal.R = R;
  goal.iterations = c.from_stand ? 12 : 8;
  solver_.solve(c.links, goal, q, X);
}

void Driver::pose(std::span<const double> q_S, std::span<const Pose> X_S, std::span<double> q, std::span<Pose> X) {
  const Mechanism& m = *t_.mechanism;
  for (const Cluster& c : clusters_) solve(c, q_S, X_S, q.data(), X);
  for (const auto& [from, to] : extras_) {
    const Link& link = m.link(to);
    std::copy_n(q_S.data() + s_.mechanism->link(from).q_index, link.joint.nq(), q.data() + link.q_index);
    solver_.clamp(to, q.data());
  }
  // Legs placed by inverse kinematics start from the standing posture, so that the solution is independent of the previous frame.
  for (int k = 0; k < limb_count; ++k)
    if (limbs_[at(k)].mode == LimbMode::placed && t_.anatomy.four_legs)
      for (const int i : t_.limbs[at(k)].chain)
        std::copy_n(t_.q_stand.data() + m.link(i).q_index, m.link(i).joint.nq(), q.data() + m.link(i).q_index);
  calc_poses(m, q, X);
  if (m.link(0).joint.type != JointType::floating) return;
  const Vec3 hips = (X[at(t_.limbs[0].root)].p + X[at(t_.limbs[1].root)].p) * 0.5;
  const Vec3 move = hip_position(X_S) - hips;
  const Vec3 own = transpose_times(m.link(0).joint.X_PJ.R, move);
  for (int k = 0; k < 3; ++k) q[at(k)] += own[k];
  for (Pose& pose : X) pose.p += move;
}

double Driver::heading(std::span<const Pose> X_S) const {
  const Quat h = heading_of(to_quat(X_S[at(s_.anatomy.pelvis)].R * s_.F[at(s_.anatomy.pelvis)]));
  return 2 * atan2(h.z, h.w);
}

Vec3 Driver::hip_position(std::span<const Pose> X_S) const {
  const Vec3 p = (X_S[at(s_.limbs[0].root)].p + X_S[at(s_.limbs[1].root)].p) * 0.5;
  return {path_scale_ * p.x, path_scale_ * p.y, t_.hip_height + scale_ * (p.z - ground_ + crouch_ - s_.hip_height)};
}

Vec3 Driver::end_position(int k, std::span<const Pose> X_S) const {
  const LimbDrive& drive = limbs_[at(k)];
  const LimbRig &s = s_.limbs[at(drive.source)], &t = t_.limbs[at(k)];
  const bool toes = !same_kind_ && t_.anatomy.four_legs && s.tip >= 0;
  const Vec3 position = toes ? X_S[at(s.tip)].p : X_S[at(s.end)] * s.end_point;
  const Vec3 from_hip = position - X_S[at(s.root)].p, stand = toes ? s.stand_tip : s.stand;
  Vec3 rest = t.stand - Vec3{path_scale_ * stand.x, path_scale_ * stand.y, scale_ * (stand.z + crouch_)};
  // A biped that follows a four-legged source stands with its feet raised by 0.03 of the leg's length, because fully straight legs could
  // not correct the positions of their feet.
  if (!same_kind_ && !t_.anatomy.four_legs) rest.z += 0.03 * t.length;
  return Vec3{path_scale_ * from_hip.x, path_scale_ * from_hip.y, scale_ * from_hip.z} + rotation_about({0, 0, 1}, heading(X_S)) * rest;
}

Mat3 Driver::end_orientation(int k, std::span<const Pose> X_S) const {
  const LimbDrive& drive = limbs_[at(k)];
  const LimbRig &s = s_.limbs[at(drive.source)], &t = t_.limbs[at(k)];
  const Mat3 O = X_S[at(s.end)].R * s_.F[at(s.end)];
  if (same_kind_ && !t_.anatomy.four_legs) return O * t_.F[at(t.end)].transposed();
  return O * (s_.G[at(s.end)].transposed() * (t_.G[at(t.end)] * t_.F[at(t.end)].transposed()));
}

void Driver::place_from(const LimbRig& limb, int link, const double* q, std::span<Pose> X) const {
  bool below = false;
  for (const int i : limb.chain) {
    below = below || i == link;
    if (below) solver_.place(i, q, X);
  }
}

/// Bends the knee so that the distance from hip to end point equals the distance from hip to target (law of cosines in the plane normal to
/// the knee's axis; components along the axis are constant). @return false if the target is too far away or too close
bool Driver::bend_knee(const LimbRig& limb, const Vec3& target, double* q, std::span<Pose> X) {
  const Link& knee = t_.mechanism->link(limb.knee);
  const Vec3 hip = X[at(limb.root)].p, k = X[at(limb.knee)].p, end = X[at(limb.end)] * limb.end_point;
  const Vec3 axis = X[at(limb.knee)].R * knee.joint.axis * limb.knee_sign;
  const Vec3 u = hip - k, w = end - k;
  const double ua = dot(u, axis), wa = dot(w, axis);
  const Vec3 up = u - axis * ua, wp = w - axis * wa;
  const double both = norm(up) * norm(wp);
  if (!(both > 1e-12)) return true;
  const double distance = norm(target - hip);
  const double c = (dot(u, u) + dot(w, w) - distance * distance - 2 * ua * wa) / (2 * both);
  const double now = atan2(dot(axis, cross(up, wp)), dot(up, wp));
  double turn = -acos(c) - now;  // flexion: difference from the straight limb (pi)
  turn -= 2 * pi * std::floor(turn / (2 * pi) + 0.5);
  double& angle = q[knee.q_index];
  angle += limb.knee_sign * turn;
  const double middle = 0.5 * (solver_.lower[at(knee.v_index)] + solver_.upper[at(knee.v_index)]);
  if (std::isfinite(middle)) angle -= 2 * pi * std::floor((angle - middle) / (2 * pi) + 0.5);
  solver_.clamp(limb.knee, q);
  place_from(limb, limb.knee, q, X);
  return c >= -1;
}

/// Turns the upper section of the limb until the direction from hip to end point equals the direction from hip to target.
void Driver::aim(const LimbRig& limb, const Vec3& target, double* q, std::span<Pose> X) {
  const Vec3 hip = X[at(limb.root)].p, to = normalized(target - hip);
  const int last = limb.upper.back();
  if (t_.mechanism->link(limb.root).joint.type == JointType::spherical) {
    const Vec3 is = normalized(X[at(limb.end)] * limb.end_point - hip);
    const bool free = solver_.orient(limb.root, to_matrix(rotation_between(is, to)) * X[at(limb.root)].R, q, X);
    place_from(limb, limb.root, q, X);
    if (free) return;
  }
  ChainGoal goal;
  goal.first = ChainGoal::First::direction;
  goal.point = normalized(transpose_times(X[at(last)].R, X[at(limb.end)] * limb.end_point - hip));
  goal.target = to;
  goal.turn = false;
  solver_.solve(limb.upper, goal, q, X);
  place_from(limb, limb.upper.front(), q, X);
}

/// Turns the links beyond the end point so that the end link has the orientation R; the end point does not move.
void Driver::turn_end(const LimbRig& limb, const Mat3& R, double* q, std::span<Pose> X) {
  int movable = 0;
  for (const int i : limb.ankle) {
    if (t_.mechanism->link(i).joint.nv() > 0) ++movable;
    solver_.place(i, q, X);
  }
  if (movable == 0) return;
  const JointType type = t_.mechanism->link(limb.end).joint.type;
  if (movable == 1 && (type == JointType::spherical || type == JointType::revolute)) {
    if (solver_.orient(limb.end, R, q, X) || type == JointType::revolute) return;
  }
  ChainGoal goal;
  goal.first = ChainGoal::First::direction;
  goal.point = t_.F[at(limb.end)].column(2);
  goal.target = R * goal.point;
  goal.R = R;
  goal.iterations = 10;
  solver_.solve(limb.ankle, goal, q, X);
}

double Driver::reach(int k, const Pose& X_goal, double* q, std::span<Pose> X, bool turn) {
  const LimbRig& limb = t_.limbs[at(k)];
  const Vec3 target = X_goal * limb.end_point;
  const double enough = 1e-8 * limb.length;
  double misses = norm(target - X[at(limb.end)] * limb.end_point);
  bool stretched = false;  // true: the limb is straight and points at the goal, so that iterations cannot come closer
  if (limb.end_is_ankle && misses > enough) {
    const bool too_short = !bend_knee(limb, target, q, X);
    aim(limb, target, q, X);
    const Vec3 hip = X[at(limb.root)].p, end = X[at(limb.end)] * limb.end_point;
    misses = norm(target - end);
    stretched = too_short && norm(cross(target - hip, end - hip)) < 1e-5 * limb.length * limb.length;
  }
  if (misses > enough && !stretched) {
    ChainGoal goal;
    goal.point = limb.movers.back() == limb.end
                     ? limb.end_point
                     : transpose_times(X[at(limb.movers.back())].R, X[at(limb.end)] * limb.end_point - X[at(limb.movers.back())].p);
    goal.target = target;
    goal.turn = false;
    goal.length = limb.length;
    goal.iterations = 30;
    misses = solver_.solve(limb.movers, goal, q, X);
  }
  if (!limb.point_foot && turn)
    turn_end(limb, X_goal.R, q, X);
  else
    place_from(limb, limb.chain.front(), q, X);
  return misses;
}

Mat3 Driver::resistance(int k, const Vec3& wish, const double* q, std::span<const Pose> X) {
  const LimbRig& limb = t_.limbs[at(k)];
  return solver_.resistance(limb.movers, X[at(limb.end)] * limb.end_point, wish, limb.length, q, X);
}

std::vector<std::string> Driver::describe_mapping() const {
  const Mechanism &s = *s_.mechanism, &t = *t_.mechanism;
  std::vector<std::string> out;
  for (const Cluster& c : clusters_) {
    const LinkGoal& w = goals_[at(c.goal)];
    std::string text;
    for (const int i : c.links)
      if (t.link(i).joint.nv() > 0) text += (text.empty() ? "" : " + ") + t.link(i).name;
    if (text.empty()) continue;
    text += c.kind == Kind::twin ? " as " : " from ";
    text += s.link(w.a).name + (w.b >= 0 ? " and " + s.link(w.b).name : "");
    out.push_back(text);
  }
  for (int k = 0; k < limb_count; ++k) {
    const LimbDrive& d = limbs_[at(k)];
    if (!d.ground || d.source < 0) continue;
    out.push_back(t.link(t_.limbs[at(k)].end).name + " follows " + s.link(s_.limbs[at(d.source)].end).name);
  }
  for (const auto& [from, to] : extras_) out.push_back(t.link(to).name + " as " + s.link(from).name);
  std::string still;
  for (int i = 0; i < t.link_count(); ++i) {
    bool driven = t.link(i).joint.nv() == 0;
    for (const Cluster& c : clusters_) driven = driven || std::find(c.links.begin(), c.links.end(), i) != c.links.end();
    for (const LimbRig& l : t_.limbs) driven = driven || std::find(l.chain.begin(), l.chain.end(), i) != l.chain.end();
    for (const auto& e : extras_) driven = driven || e.second == i;
    if (!driven) still += (still.empty() ? "" : ", ") + t.link(i).name;
  }
  if (!still.empty()) out.push_back("Not driven, so not moving: " + still + ".");
  return out;
}

}  // namespace ugoki::retarget
