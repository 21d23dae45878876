#include "ugoki/gait/walker.h"

#include <algorithm>
#include <cmath>

#include "ugoki/mechanism/state.h"

namespace ugoki::gait {
namespace {

using retarget::Slot;

std::size_t at(int i) { return static_cast<std::size_t>(i); }

class Maker {
 public:
  Maker(Walker& w) : w_(w), m_(*w.mechanism), X_(at(m_.link_count())), solver_(m_) {}

  Result<void> run() {
    const std::string where = "mechanism " + m_.name();
    if (m_.link_count() == 0 || m_.link(0).joint.type != JointType::floating)
      return fail(ErrorCode::structure, where, "The root of the mechanism is not floating, so that it cannot walk.",
                  "Use a mechanism with a floating root, or import it with a floating base.");
    const std::vector<motion_edit::FootLimb> feet = motion_edit::find_foot_limbs(m_);
    const std::size_t n = feet.size();
    if (n < 2 || n % 2 != 0)
      return fail(ErrorCode::structure, where,
                  "The mechanism has " + std::to_string(n) + " feet; gaits need an even number of legs, two or more.",
                  "Label the links that stand on the ground 'foot' or 'paw'.");
    w_.biped = n == 2;
    if (n <= 4) {
      if (Result<retarget::Rig> rig = retarget::make_rig(w_.mechanism)) {
        if (rig->anatomy.four_legs == (n == 4)) w_.rig = std::move(*rig);
      }
    }
    if (!w_.rig)
      w_.notes.push_back("The anatomy of the trunk is not known; the trunk is kept level, and the mechanism walks along its x axis.");
    stand();
    for (const motion_edit::FootLimb& foot : feet) add_leg(foot);
    sort_legs();
    for (const WalkerLeg& leg : w_.legs)
      if (leg.chain.empty() || leg.length < 1e-3)
        return fail(ErrorCode::structure, where,
                    "The foot " + m_.link(leg.link).name + " has no movable joint above it that belongs to it alone.",
                    "Label only the links at the ends of legs 'foot' or 'paw'.");
    if (w_.biped)
      for (WalkerLeg& leg : w_.legs) leg.home.x = 0;
    name_limbs();
    return {};
  }

 private:
  void orient(int link, const Mat3& R) { solver_.orient(link, R, w_.q_stand.data(), X_); }
  void set_root(const Pose& X) {
    const Pose X_JB = m_.link(0).joint.X_PJ.inverse() * X;
    const Quat r = to_quat(X_JB.R);
    const double q[7] = {X_JB.p.x, X_JB.p.y, X_JB.p.z, r.w, r.x, r.y, r.z};
    std::copy(q, q + 7, w_.q_stand.begin());
  }

  /// Sets the standing posture, facing +x.
  void stand() {
    w_.q_stand = w_.rig ? w_.rig->q_stand : m_.neutral();
    for (int i = 1; i < m_.link_count(); ++i) solver_.clamp(i, w_.q_stand.data());
    calc_poses(m_, w_.q_stand, X_);
    if (w_.rig) w_.R_HA = w_.rig->anatomy.R_WA;
    w_.R_root = w_.R_HA.transposed() * X_[0].R;
    const bool upright = w_.biped && w_.rig;
    if (upright && w_.rig->anatomy.pelvis == 0) w_.R_root = w_.rig->F[0].transposed();
    set_root({w_.R_root, {}});
    calc_poses(m_, w_.q_stand, X_);
    if (upright) {
      for (const retarget::Limb& limb : w_.rig->anatomy.limbs)
        for (const int i : limb.links) {
          orient(i, w_.rig->G[at(i)] * w_.rig->F[at(i)].transposed());
          solver_.place(i, w_.q_stand.data(), X_);
        }
      calc_poses(m_, w_.q_stand, X_);
    }
    for (int i = 0; i < m_.link_count(); ++i) w_.mass += m_.link(i).inertia.mass;
  }

  void add_leg(const motion_edit::FootLimb& foot) {
    WalkerLeg leg;
    leg.link = foot.link;
    leg.chain = foot.chain;
    if (leg.chain.empty()) {
      w_.legs.push_back(leg);
      return;
    }
    leg.hip = leg.chain.front();
    if (w_.biped && w_.rig)
      leg.R_HF = w_.rig->F[at(leg.link)].transposed();
    else
      leg.R_HF = X_[at(leg.link)].R;
    // Low points of the sole, in the flat foot
    std::vector<Vec3> all;
    double low = 1e300;
    for (const LinkPoint& p : foot.points) {
      const Vec3 own = X_[at(leg.link)].inverse() * (X_[at(p.link)] * p.location.p);
      all.push_back(own);
      low = std::min(low, (leg.R_HF * own).z - p.location.radius);
    }
    double chain = 0;
    for (std::size_t k = 1; k < leg.chain.size(); ++k) chain += norm(X_[at(leg.chain[k])].p - X_[at(leg.chain[k - 1])].p);
    const double thin = std::max(0.004, 0.025 * chain);
    Vec3 back{1e300, 0, 0}, front{-1e300, 0, 0};
    for (std::size_t i = 0; i < all.size(); ++i) {
      const Vec3 flat = leg.R_HF * all[i];
      const double radius = foot.points[i].location.radius;
      if (flat.z - radius > low + thin) continue;
      leg.points.push_back(all[i]);
      leg.radii.push_back(radius);
      if (flat.x < back.x) {
        back = flat;
        leg.heel_radius = radius;
      }
      if (flat.x > front.x) {
        front = flat;
        leg.toe_radius = radius;
      }
    }
    double side_sum = 0;
    for (const Vec3& p : leg.points) side_sum += (leg.R_HF * p).y / static_cast<double>(leg.points.size());
    const Mat3 R_FH = leg.R_HF.transposed();
    leg.heel = R_FH * Vec3{back.x, side_sum, low + leg.heel_radius};
    leg.toe = R_FH * Vec3{front.x, side_sum, low + leg.toe_radius};
    leg.sole = R_FH * Vec3{0.5 * (back.x + front.x), side_sum, low};
    leg.point_foot = front.x - back.x < 0.05 * (chain + norm(leg.sole));
    if (leg.point_foot) {
      leg.point = R_FH * Vec3{0.5 * (back.x + front.x), side_sum, low + leg.toe_radius};
      leg.heel_radius = leg.toe_radius;
    }
    leg.length = chain + (leg.point_foot ? norm(leg.point) : 0);
    for (const int part : foot.parts)
      if (part != leg.link && m_.link(part).parent == leg.link && m_.link(part).joint.nv() > 0) leg.toes.push_back(part);
    if (w_.rig)
      for (const retarget::LimbRig& limb : w_.rig->limbs)
        if (limb.found && limb.end == leg.link && limb.tip >= 0 && std::ranges::find(leg.toes, limb.tip) == leg.toes.end() &&
            m_.link(limb.tip).joint.nv() > 0)
          leg.toes.push_back(limb.tip);
    w_.legs.push_back(leg);
  }

  /// Finds the limb of the rig that each leg of a biped is.
  void name_limbs() {
    if (!w_.rig || !w_.biped) return;
    for (WalkerLeg& leg : w_.legs)
      for (const int k : {0, 1}) {
        const retarget::LimbRig& limb = w_.rig->limbs[at(k)];
        if (limb.found && std::ranges::find(leg.chain, limb.root) != leg.chain.end()) leg.limb = k;
      }
  }

  /// Finds rows and sides, and the place of each foot while the character stands.
  void sort_legs() {
    const Vec3 centre = centre_of_mass(m_, X_);
    double low = 1e300, hips = 0;
    for (WalkerLeg& leg : w_.legs) {
      if (leg.chain.empty()) continue;
      const Vec3 sole = X_[at(leg.link)].p + leg.R_HF * leg.sole;
      leg.home = sole - centre;
      low = std::min(low, sole.z);
      leg.hip_ahead = X_[at(leg.hip)].p.x - centre.x;
      leg.hip_side = X_[at(leg.hip)].p.y - centre.y;
      leg.place.left = w_.biped ? leg.hip_side > 0 : leg.home.y > 0;
    }
    w_.centre_height = centre.z - low;
    for (const WalkerLeg& leg : w_.legs)
      if (!leg.chain.empty()) hips += (X_[at(leg.hip)].p.z - low) / static_cast<double>(w_.legs.size());
    if (w_.rig && w_.rig->hip_height > 0) hips = w_.rig->hip_height;
    w_.hip_height = hips;
    for (const bool left : {true, false}) {
      std::vector<WalkerLeg*> side;
      for (WalkerLeg& leg : w_.legs)
        if (leg.place.left == left) side.push_back(&leg);
      std::ranges::sort(side, {}, [](const WalkerLeg* leg) { return leg->home.x; });
      for (std::size_t r = 0; r < side.size(); ++r) side[r]->place.row = static_cast<int>(r);
    }
    for (WalkerLeg& leg : w_.legs) leg.home.z = 0;
    std::ranges::sort(w_.legs, [](const WalkerLeg& a, const WalkerLeg& b) {
      return a.place.left != b.place.left ? a.place.left : a.place.row < b.place.row;
    });
  }

  Walker& w_;
  const Mechanism& m_;
  std::vector<Pose> X_;
  retarget::ChainSolver solver_;
};

}  // namespace

Result<Walker> make_walker(const MechanismPtr& mechanism) {
  Walker walker;
  walker.mechanism = mechanism;
  if (Result<void> made = Maker(walker).run(); !made) return fail(std::move(made.error()));
  return walker;
}

}  // namespace ugoki::gait
