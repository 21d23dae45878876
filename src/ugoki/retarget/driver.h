#pragma once
// From one posture of the source to one of the target: which link of the source drives which joints of the target.

#include <span>
#include <string>
#include <vector>

#include "ugoki/retarget/mapping.h"

namespace ugoki::retarget {

/// How a limb of the target is led.
enum class LimbMode {
  none,
  copied,  ///< its sections point where those of the source point
  stood,   ///< it stands as it stands, and its end goes where the source's end goes
};

struct LimbDrive {
  LimbMode mode = LimbMode::none;
  int source = -1;      ///< limb of the source
  bool ground = false;  ///< its end can stand on the ground
  bool flat = false;    ///< of another kind: flat while it stands
};

class Driver {
 public:
  Driver(const Rig& source, const Rig& target, const Mapping& mapping);

  /// Turns of all joints of the target, root at the middle between the hips of the source (scaled).
  /// @param q_S [nq of the source] @param X_S [links of the source]
  /// @param q [nq of the target, in and out] in: the frame before (or the standing position), from which solutions start
  /// @param X [links of the target, out]
  void pose(std::span<const double> q_S, std::span<const Pose> X_S, std::span<double> q, std::span<Pose> X);
  /// Brings the end of a limb there. @param turn false: what is behind the led place keeps its joints
  /// @return m, what is missing
  double reach(int limb, const Pose& X_goal, double* q, std::span<Pose> X, bool turn = true);
  /// ChainSolver::resistance of a limb's end where it is.
  [[nodiscard]] Mat3 resistance(int limb, const Vec3& wish, const double* q, std::span<const Pose> X);
  /// Orientation that the end of the limb should have.
  [[nodiscard]] Mat3 end_turn(int limb, std::span<const Pose> X_S) const;
  /// Where the led place of the limb should be, seen from the target's hip or shoulder.
  [[nodiscard]] Vec3 end_place(int limb, std::span<const Pose> X_S) const;
  /// Middle between the hips, where the target's should be. m
  [[nodiscard]] Vec3 hip_place(std::span<const Pose> X_S) const;
  /// A place of the source's world in the target's, which is larger or smaller.
  [[nodiscard]] Vec3 scaled_place(const Vec3& p) const { return {path_scale_ * p.x, path_scale_ * p.y, scale_ * (p.z - ground_)}; }
  /// Heading of the source's pelvis.
  [[nodiscard]] double heading(std::span<const Pose> X_S) const;

  /// How much lower than on straight legs the source usually holds its hips [m]: a figure of another kind does not crouch for that.
  void set_crouch(double crouch) { crouch_ = crouch; }
  [[nodiscard]] double scale() const { return scale_; }
  void set_path_scale(double scale) { path_scale_ = scale; }
  /// @param ground m, height on which the source stands; the target's is 0
  void set_ground(double ground) { ground_ = ground; }
  [[nodiscard]] const LimbDrive& limb(int k) const { return limbs_[static_cast<std::size_t>(k)]; }
  [[nodiscard]] const ChainSolver& solver() const { return solver_; }
  [[nodiscard]] std::vector<std::string> words() const;

 private:
  struct Want {
    int link = -1;       ///< of the target
    int a = -1, b = -1;  ///< of the source
    double t = 0;        ///< between a and b
    bool level = false;  ///< tilts are limited: a trunk of another kind
    Mat3 K = Mat3::identity();
  };
  enum class Kind { root, twin, single, general };
  struct Cluster {
    Kind kind = Kind::general;
    std::vector<int> links;
    int want = -1;
    int movable = -1;               ///< single: the joint that moves
    Mat3 R_rel = Mat3::identity();  ///< single, root: of the wanted link against the movable one
    std::vector<int> twins;         ///< links of the source
    bool from_stand = false;        ///< more freedoms than needed: each frame starts from the standing position
  };

  void map_trunk();
  void map_chain(const std::vector<int>& source, int source_base, const std::vector<int>& target, bool level);
  void map_limbs();
  void map_extras(const Mapping& mapping);
  void want(int target, int a, int b, double t, bool deviation, bool level);
  void make_clusters();
  [[nodiscard]] bool is_twin(int source, int target) const;
  [[nodiscard]] Mat3 wanted(const Want& w, std::span<const Pose> X_S) const;
  void solve(const Cluster& c, std::span<const double> q_S, std::span<const Pose> X_S, double* q, std::span<Pose> X);
  bool bend_knee(const LimbRig& limb, const Vec3& place, double* q, std::span<Pose> X);
  void aim(const LimbRig& limb, const Vec3& place, double* q, std::span<Pose> X);
  void turn_end(const LimbRig& limb, const Mat3& R, double* q, std::span<Pose> X);
  void place_from(const LimbRig& limb, int link, const double* q, std::span<Pose> X) const;

  const Rig& s_;
  const Rig& t_;
  bool same_kind_;
  double scale_ = 1, path_scale_ = 1, ground_ = 0, crouch_ = 0;
  ChainSolver solver_;
  std::vector<Want> wants_;
  std::vector<int> want_of_;  // [links of the target]
  std::vector<int> partner_;  // [links of the target] link of the source at the same place; -1
  std::vector<Cluster> clusters_;
  std::vector<std::pair<int, int>> extras_;  // source, target
  std::vector<LimbDrive> limbs_;
};

}  // namespace ugoki::retarget
