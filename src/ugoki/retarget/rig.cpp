#include "ugoki/retarget/rig.h"

#include <algorithm>
#include <cmath>

#include "ugoki/mechanism/state.h"

namespace ugoki::retarget {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }
constexpr Vec3 x_axis{1, 0, 0}, y_axis{0, 1, 0}, z_axis{0, 0, 1};

/// Returns a rotation matrix with columns d, the component of b normal to d (normalized), and their cross product.
Mat3 axes_along(const Vec3& d, const Vec3& b) {
  Vec3 side = b - d * dot(d, b);
  side = norm(side) > 1e-6 ? normalized(side) : any_perpendicular(d);
  return Mat3::columns(d, side, cross(d, side));
}

/// Computes all other members of a Rig whose mechanism and anatomy are set.
class Maker {
 public:
  Maker(Rig& rig, const std::vector<SoleSpec>& soles) : r_(rig), m_(*rig.mechanism), anatomy_(rig.anatomy), soles_(soles), solver_(m_) {}

  void run() {
    const Mat3 A = trunk_axes();
    for (int i = 0; i < m_.link_count(); ++i) {
      r_.F.push_back(anatomy_.X_WB[at(i)].R.transposed() * anatomy_.R_WA);
      r_.G.push_back(Mat3::identity());
      r_.along.push_back({});
    }
    std::vector<int> trunk = anatomy_.spine;
    trunk.push_back(anatomy_.pelvis);
    trunk.insert(trunk.end(), anatomy_.neck.begin(), anatomy_.neck.end());
    for (const int i : trunk) r_.F[at(i)] = anatomy_.X_WB[at(i)].R.transposed() * A;
    r_.q_stand = m_.neutral();
    for (int i = 0; i < m_.link_count(); ++i) solver_.clamp(i, r_.q_stand.data());
    X_ = anatomy_.X_WB;
    for (int k = 0; k < limb_count; ++k)
      if (anatomy_.limbs[at(k)].found()) make_limb(k);
    calc_poses(m_, r_.q_stand, X_);
    if (anatomy_.four_legs) stand_on_four();
    for (int k = 0; k < limb_count; ++k) measure_stand(k);
    const LimbRig &l = r_.limbs[0], &r = r_.limbs[1];
    r_.leg_length = 0.5 * (l.length + r.length);
    r_.hip_height = 0.5 * (hip_height(l) + hip_height(r));
  }

 private:
  /// Anatomical axes of the trunk in the world. If a biped leans in the neutral position, they follow the line from hips to shoulders.
  [[nodiscard]] Mat3 trunk_axes() const {
    if (anatomy_.four_legs || !anatomy_.limbs[2].found() || !anatomy_.limbs[3].found()) return anatomy_.R_WA;
    const auto middle = [&](int k) {
      return (anatomy_.X_WB[at(anatomy_.limbs[at(k)].first(Slot::upper))].p +
              anatomy_.X_WB[at(anatomy_.limbs[at(k + 1)].first(Slot::upper))].p) *
             0.5;
    };
    const Vec3 up = middle(2) - middle(0);
    if (norm(up) < 1e-6 || up.z > 0.9 * norm(up)) return anatomy_.R_WA;
    return to_matrix(rotation_between(z_axis, normalized(up))) * anatomy_.R_WA;
  }

  [[nodiscard]] Vec3 origin(int link) const { return anatomy_.X_WB[at(link)].p; }
  /// Far end [m, world] of the section `slot`: the next section's origin, or the far end of the last link's shapes.
  [[nodiscard]] Vec3 end_of(const Limb& limb, Slot slot) const {
    for (int s = static_cast<int>(slot) + 1; s < slot_count; ++s)
      if (limb.has(static_cast<Slot>(s))) return origin(limb.first(static_cast<Slot>(s)));
    const int last = limb.links.back();
    Vec3 far = origin(last);
    const Vec3 from = origin(limb.first(slot));
    for (const SupportPoint& s : support_points(m_.link(last)))
      if (const Vec3 p = anatomy_.X_WB[at(last)] * s.p; norm(p - from) > norm(far - from)) far = p;
    return far;
  }

  /// Axis (unit, world, neutral position) about which knee or elbow bends; positive rotations flex.
  /// @param du, dl directions of upper and lower section @param hinge [out] link of the hinge; -1: none
  [[nodiscard]] Vec3 bend_axis(const Limb& limb, const Vec3& du, const Vec3& dl, bool leg, int& hinge) const {
    const Vec3 forward = anatomy_.R_WA * x_axis;
    Vec3 usual = cross(du, leg ? -forward : forward);
    if (norm(usual) < 0.3) usual = leg ? anatomy_.R_WA * y_axis : -(anatomy_.R_WA * z_axis);
    const Vec3 bent = cross(du, dl);
    const bool is_bent = norm(bent) > 0.25;
    hinge = -1;
    Vec3 axis{};
    for (int s = limb.begin[2]; s < limb.begin[3]; ++s) {
      const int i = limb.links[at(s)];
      if (m_.link(i).joint.nv() > 0) hinge = -1;  // a movable joint after the hinge would change the hinge's effect
      if (m_.link(i).joint.type != JointType::revolute) continue;
      const Vec3 a = anatomy_.X_WB[at(i)].R * m_.link(i).joint.axis;
      if (std::fabs(dot(a, dl)) < 0.5) {
        axis = a;
        hinge = i;
      }
    }
    if (norm(axis) > 0) return dot(axis, is_bent ? bent : usual) < 0 ? -axis : axis;
    return is_bent ? normalized(bent) : normalized(usual);
  }

  /// Normal of the sole (unit, world, neutral position): the upward face normal of the foot's box, otherwise Z.
  [[nodiscard]] Vec3 sole_normal(int foot) const {
    for (const Shape& s : m_.link(foot).shapes) {
      if (s.type != ShapeType::box || !s.collides) continue;
      const Mat3 R = anatomy_.X_WB[at(foot)].R * s.X_BS.R;
      Vec3 best = z_axis;
      double maximum = 0.7;
      for (int k = 0; k < 3; ++k)
        for (const double sign : {1.0, -1.0})
          if (const Vec3 n = R.column(k) * sign; n.z > maximum) {
            maximum = n.z;
            best = n;
          }
      return best;
    }
    return z_axis;
  }

  /// Sets F, G and `along` for all links of a section.
  /// @param world axes in the neutral position @param standing axes while standing @param along direction of the section, world
  void set_axes(const Limb& limb, Slot slot, const Mat3& world, const Mat3& standing, const Vec3& along) {
    if (!limb.has(slot)) return;
    for (int s = limb.begin[at(static_cast<int>(slot))]; s < limb.begin[at(static_cast<int>(slot) + 1)]; ++s) {
      const int i = limb.links[at(s)];
      const Mat3 R = anatomy_.X_WB[at(i)].R;
      r_.F[at(i)] = R.transposed() * world;
      r_.G[at(i)] = standing;
      r_.along[at(i)] = transpose_times(R, along);
    }
  }

  /// Sets geometry and axes of limb k.
  void make_limb(int k) {
    const Limb& limb = anatomy_.limbs[at(k)];
    const bool leg = k < 2;
    LimbRig& out = r_.limbs[at(k)];
    out.found = true;
    out.root = limb.first(Slot::upper);
    const Vec3 hip = origin(out.root), knee = origin(limb.first(Slot::lower)), ankle = end_of(limb, Slot::lower);
    const Vec3 du = normalized(knee - hip), dl = normalized(ankle - knee);
    out.length = norm(knee - hip) + norm(ankle - knee);
    const Vec3 b = bend_axis(limb, du, dl, leg, out.knee);
    out.bend_axis = transpose_times(anatomy_.X_WB[at(limb.last(Slot::upper))].R, b);
    if (out.knee >= 0) out.knee_sign = dot(anatomy_.X_WB[at(out.knee)].R * m_.link(out.knee).joint.axis, b) < 0 ? -1 : 1;
    const double side = k % 2 == 0 ? 1 : -1;
    // In the standing posture legs are straight down and arms hang.
    const Vec3 bend_standing = leg ? y_axis : -y_axis;
    const Mat3 hanging = axes_along(-z_axis, bend_standing);
    set_axes(limb, Slot::upper, axes_along(du, b), hanging, du);
    set_axes(limb, Slot::lower, axes_along(dl, b), hanging, dl);
    if (limb.has(Slot::girdle)) {
      const Vec3 d = normalized(hip - origin(limb.first(Slot::girdle)), y_axis * side);
      set_axes(limb, Slot::girdle, axes_along(d, z_axis), axes_along(y_axis * side, z_axis), d);
    }
    find_end(k);
    if (!limb.has(Slot::end)) return;
    const Vec3 de = normalized(end_of(limb, Slot::end) - ankle, dl);
    if (leg && !anatomy_.four_legs) {
      const Vec3 up = sole_normal(out.end);
      Vec3 forward = end_of(limb, Slot::end) - ankle;
      forward -= up * dot(up, forward);
      const Vec3 usual = anatomy_.R_WA * x_axis;
      if (norm(forward) < 0.02 * out.length || dot(forward, usual) < 0.5 * norm(forward)) forward = usual - up * dot(up, usual);
      forward = normalized(forward);
      const Mat3 foot = Mat3::columns(forward, cross(up, forward), up);
      set_axes(limb, Slot::end, foot, Mat3::identity(), de);
      set_axes(limb, Slot::tip, foot, Mat3::identity(), de);
    } else {
      const Mat3 axes = axes_along(de, b);
      set_axes(limb, Slot::end, axes, hanging, de);
      if (!anatomy_.four_legs) set_axes(limb, Slot::tip, axes, hanging, de);
    }
  }

  [[nodiscard]] bool is_below(int i, int ancestor) const {
    for (; i >= 0; i = m_.link(i).parent)
      if (i == ancestor) return true;
    return false;
  }
  /// Lowest point [m] of the link's shapes in the neutral position.
  [[nodiscard]] double lowest(int link) const {
    double low = 1e300;
    for (const SupportPoint& s : support_points(m_.link(link))) low = std::min(low, (anatomy_.X_WB[at(link)] * s.p).z - s.radius);
    return low;
  }

  /// Finds the end link of limb k, its sole, and the chain from the limb's root to it.
  void find_end(int k) {
    const Limb& limb = anatomy_.limbs[at(k)];
    LimbRig& out = r_.limbs[at(k)];
    const bool ground = k < 2 || anatomy_.four_legs;
    out.end = limb.has(Slot::end) ? (ground ? limb.last(Slot::end) : limb.first(Slot::end)) : limb.links.back();
    const SoleSpec* given = nullptr;
    if (ground) {
      double low = 1e300;
      const int from = limb.has(Slot::end) ? limb.begin[3] : limb.begin[2];
      for (std::size_t i = at(from); i < limb.links.size(); ++i) low = std::min(low, lowest(limb.links[i]));
      for (std::size_t i = at(from); i < limb.links.size() && low < 1e300; ++i)
        if (lowest(limb.links[i]) < low + 0.02 * out.length) {
          out.end = limb.links[i];
          break;
        }
      for (const SoleSpec& s : soles_)
        for (const int i : limb.links)
          if (m_.link(i).name == s.link) {
            given = &s;
            out.end = i;
          }
      make_sole(out, given);
    }
    const int first = anatomy_.four_legs && k >= 2 ? limb.links.front() : out.root;
    for (const int i : limb.links)
      if (is_below(i, first) && is_below(out.end, i)) out.chain.push_back(i);
    const Vec3 end_point = anatomy_.X_WB[at(out.end)] * out.end_point;
    out.end_is_ankle = out.knee >= 0 && limb.has(Slot::end) && norm(end_point - origin(limb.first(Slot::end))) < 1e-6 * out.length;
    if (!limb.has(Slot::end) && out.point_foot) {
      out.end_is_ankle = out.knee >= 0 && out.end == limb.last(Slot::lower);
      out.length = norm(origin(limb.first(Slot::lower)) - origin(out.root)) + norm(end_point - origin(limb.first(Slot::lower)));
    }
    out.tip = limb.first(Slot::tip);
    bool above = true;
    for (const int i : out.chain) {
      above = above && i != out.knee;
      if (above) out.upper.push_back(i);
      const JointType type = m_.link(i).joint.type;
      const bool turns =
          type == JointType::spherical || type == JointType::revolute || type == JointType::universal || type == JointType::fixed;
      if (turns && !out.point_foot && norm(origin(i) - end_point) < 1e-6 * out.length)
        out.ankle.push_back(i);
      else
        out.movers.push_back(i);
    }
  }

  /// Sets the sole of a limb. @param given sole from the mapping; null: found from the shapes of the end link and its descendants
  void make_sole(LimbRig& out, const SoleSpec* given) {
    motion_edit::FootLimb& sole = out.sole;
    sole.link = out.end;
    sole.length = out.length;
    sole.chain = out.chain;
    out.has_sole = true;
    if (given) {
      sole.parts = {out.end};
      for (const Vec3& p : given->points) sole.points.push_back({out.end, {p, 0}});
    } else {
      for (int i = out.end; i < m_.link_count(); ++i) {
        const std::vector<SupportPoint> points = support_points(m_.link(i));
        if (points.empty() || !is_below(i, out.end)) continue;
        sole.parts.push_back(i);
        for (const SupportPoint& p : points) sole.points.push_back({i, p});
      }
    }
    if (sole.points.empty()) {
      r_.notes.push_back("Foot " + m_.link(out.end).name + " has no shape that can bear on the ground; its joint is used as the sole.");
      sole.parts = {out.end};
      sole.points.push_back({out.end, {}});
      out.has_sole = false;
      out.point_foot = true;
    } else {
      // If all low points are close together (a ball at the end of a robot's leg), the sole is a point and the foot's orientation is free.
      double low = 1e300;
      for (const auto& p : sole.points) low = std::min(low, height(p));
      std::vector<LinkPoint> bearing;
      for (const auto& p : sole.points)
        if (height(p) < low + 0.02 * out.length) bearing.push_back(p);
      double spread = 0;
      for (const auto& p : bearing)
        spread =
            std::max(spread, norm(anatomy_.X_WB[at(p.link)] * p.location.p - anatomy_.X_WB[at(bearing[0].link)] * bearing[0].location.p));
      if (spread < 0.02 * out.length) {
        out.point_foot = true;
        out.end = bearing[0].link;
        out.end_point = bearing[0].location.p;
        sole.link = out.end;
        sole.parts = {out.end};
        sole.points = {{out.end, {{}, bearing[0].location.radius}}};
      }
    }
    for (int i = 0; i < static_cast<int>(sole.points.size()); ++i) {
      sole.heel.push_back(i);
      sole.toe.push_back(i);
    }
  }
  [[nodiscard]] double height(const LinkPoint& p) const { return (anatomy_.X_WB[at(p.link)] * p.location.p).z - p.location.radius; }

  /// Bends legs that are straight in the neutral position (robots): raises each foot towards the hip by 12 % of the distance between them.
  void stand_on_four() {
    for (int k = 0; k < limb_count; ++k) {
      LimbRig& limb = r_.limbs[at(k)];
      if (!limb.found || limb.knee < 0) continue;
      const Vec3 hip = X_[at(limb.root)].p, foot = X_[at(limb.end)] * limb.end_point;
      if (norm(foot - hip) < 0.95 * limb.length) continue;
      double* q = r_.q_stand.data();
      q[m_.link(limb.knee).q_index] += 0.8 * limb.knee_sign;
      solver_.clamp(limb.knee, q);
      calc_poses(m_, r_.q_stand, X_);
      ChainGoal goal;
      goal.point = limb.end_point;
      goal.target = foot + (hip - foot) * 0.12;
      goal.turn = false;
      goal.length = limb.length;
      goal.iterations = 60;
      solver_.solve(limb.chain, goal, q, X_);
    }
    calc_poses(m_, r_.q_stand, X_);
    for (int k = 0; k < limb_count; ++k)
      for (const int i : anatomy_.limbs[at(k)].links) r_.G[at(i)] = anatomy_.R_WA.transposed() * (X_[at(i)].R * r_.F[at(i)]);
  }

  /// Computes `stand` and `stand_tip` of limb k from the standing posture.
  void measure_stand(int k) {
    LimbRig& limb = r_.limbs[at(k)];
    if (!limb.found) return;
    const Vec3 hip = X_[at(limb.root)].p;
    if (anatomy_.four_legs) {
      limb.stand = transpose_times(anatomy_.R_WA, X_[at(limb.end)] * limb.end_point - hip);
      limb.stand_tip = limb.tip >= 0 ? transpose_times(anatomy_.R_WA, X_[at(limb.tip)].p - hip) : limb.stand;
      return;
    }
    limb.stand = {0, 0, -limb.length};
    limb.stand_tip = limb.stand;
    const Limb& links = anatomy_.limbs[at(k)];
    if (k >= 2 || !links.has(Slot::end)) return;
    const int foot = links.first(Slot::end);
    const Mat3 axes = anatomy_.X_WB[at(foot)].R * r_.F[at(foot)];
    limb.stand += transpose_times(axes, anatomy_.X_WB[at(limb.end)] * limb.end_point - origin(foot));
    if (limb.tip >= 0) limb.stand_tip += transpose_times(axes, origin(limb.tip) - origin(foot));
  }

  /// Height [m] of the hip above the sole in the standing posture.
  [[nodiscard]] double hip_height(const LimbRig& leg) const {
    double low = 1e300;
    const Mat3 axes = anatomy_.four_legs ? X_[at(leg.end)].R.transposed() * anatomy_.R_WA
                      : leg.point_foot   ? Mat3::identity()
                                         : r_.F[at(leg.end)];
    for (const LinkPoint& p : leg.sole.points) {
      // In the standing posture, points of the toes have the same position relative to the foot as in the neutral position.
      const Vec3 in_foot =
          anatomy_.X_WB[at(leg.end)].inverse() * (anatomy_.X_WB[at(p.link)] * p.location.p) - leg.end_point * (leg.point_foot ? 0 : 1);
      low = std::min(low, (leg.point_foot ? 0 : transpose_times(axes, in_foot).z) - p.location.radius);
    }
    return -leg.stand.z - low;
  }

  Rig& r_;
  const Mechanism& m_;
  const Anatomy& anatomy_;
  const std::vector<SoleSpec>& soles_;
  ChainSolver solver_;
  std::vector<Pose> X_;
};

}  // namespace

Result<Rig> make_rig(MechanismPtr mechanism, const AnatomyNames& names, const std::vector<SoleSpec>& soles) {
  Rig rig;
  rig.mechanism = std::move(mechanism);
  Result<Anatomy> anatomy = find_anatomy(*rig.mechanism, names);
  if (!anatomy) return fail(std::move(anatomy.error()));
  rig.anatomy = std::move(*anatomy);
  Maker(rig, soles).run();
  return rig;
}

}  // namespace ugoki::retarget
