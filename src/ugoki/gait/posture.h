#pragma once
// Postures of the whole mechanism: trunk, arms, and inverse kinematics of the legs. Internal to gait.

#include "ugoki/gait/foot_path.h"

namespace ugoki::gait {

/// Numbers that the rounds of make_gait find.
struct Swing {
  double arms = 1;  ///< factor on the swing of the arms
};

class Poser {
 public:
  Poser(const Walker& walker, const GaitOptions& options, const Course& course);

  /// Sets root orientation, trunk, arms and legs in a frame so that the centre of mass is at `centre`.
  /// @param lower m: the body is lowered by this @param pitch rad: pitch of the trunk
  /// @param q [nq, in and out] in: a start for the inverse kinematics
  /// @return m: largest distance of a foot from its goal
  double pose(int frame, const Vec3& centre, double pitch, const Swing& swing, std::span<double> q);
  /// How far the body must be lowered so that no leg is longer than its length. Uses the poses of the last call of pose().
  [[nodiscard]] double excess(int frame) const;
  /// Poses of the links of the last call.
  [[nodiscard]] std::span<const Pose> poses() const { return X_; }
  /// Links of the arms.
  [[nodiscard]] std::span<const int> arms() const { return arm_links_; }

 private:
  void set_trunk(int frame, double pitch, const Swing& swing, std::span<double> q);
  void orient_chain(std::span<const int> links, const Mat3& from, const Mat3& to, std::span<double> q);
  void bend_leg(const WalkerLeg& leg, const Pose& X_WF, std::span<double> q);
  /// @param p m, world: wanted place of WalkerLeg::point
  [[nodiscard]] Vec3 within_reach(const WalkerLeg& leg, const Vec3& p) const;
  void set_root(const Pose& X, std::span<double> q);

  const Walker& w_;
  const GaitOptions& o_;
  const Course& course_;
  retarget::ChainSolver solver_;
  std::vector<Pose> X_;
  std::vector<int> arm_links_;
  std::vector<FootPose> feet_;
};

}  // namespace ugoki::gait
