#pragma once
// Maps one posture of the source to one posture of the target by assigning source links to target joints.

#include <span>
#include <string>
#include <vector>

#include "ugoki/retarget/mapping.h"

namespace ugoki::retarget {

/// How a limb of the target follows a limb of the source.
enum class LimbMode {
  none,    ///< not driven
  copied,  ///< the sections of the target's limb take the directions of the source's sections
  placed,  ///< inverse kinematics moves the limb's end like the end of the source's limb, starting from the standing posture
};

/// Assignment of one limb of the target.
struct LimbDrive {
  LimbMode mode = LimbMode::none;
  int source = -1;      ///< limb of the source (LimbName); -1: none
  bool ground = false;  ///< the limb's end can stand on the ground
  bool flat = false;    ///< the foot is kept level in stance, because source and target have different kinds of feet
};

/// Computes postures of the target. `source` and `target` must outlive the driver.
class Driver {
 public:
  Driver(const Rig& source, const Rig& target, const Mapping& mapping);

  /// Computes all joint coordinates of the target. The root is placed so that the midpoint of the target's hips follows the scaled midpoint
  /// of the source's hips.
  /// @param q_S [nq of the source] @param X_S [links of the source]
  /// @param q [nq of the target, in and out] in: the previous frame (or the standing posture), from which iterative solutions start
  /// @param X [links of the target, out]
  void pose(std::span<const double> q_S, std::span<const Pose> X_S, std::span<double> q, std::span<Pose> X);
  /// Moves the limb's end link to X_goal by inverse kinematics. @param turn false: joints beyond the limb's end point keep their angles
  /// @return m, remaining distance of the end point
  double reach(int limb, const Pose& X_goal, double* q, std::span<Pose> X, bool turn = true);
  /// ChainSolver::resistance of the limb's end point in the present posture.
  [[nodiscard]] Mat3 resistance(int limb, const Vec3& wish, const double* q, std::span<const Pose> X);
  /// Goal orientation of the limb's end link in the world.
  [[nodiscard]] Mat3 end_orientation(int limb, std::span<const Pose> X_S) const;
  /// Goal position [m] of the limb's end point relative to the target's hip or shoulder, world axes.
  [[nodiscard]] Vec3 end_position(int limb, std::span<const Pose> X_S) const;
  /// Goal position [m] of the midpoint between the target's hips.
  [[nodiscard]] Vec3 hip_position(std::span<const Pose> X_S) const;
  /// Maps a world position [m] of the source to the target's scaled world.
  [[nodiscard]] Vec3 scaled_position(const Vec3& p) const { return {path_scale_ * p.x, path_scale_ * p.y, scale_ * (p.z - ground_)}; }
  /// Heading [rad] of the source's pelvis about Z.
  [[nodiscard]] double heading(std::span<const Pose> X_S) const;

  /// @param crouch m, usual height of the source's hips below the height on straight legs; not copied to a target of another kind
  void set_crouch(double crouch) { crouch_ = crouch; }
  /// Ratio of lengths, target over source.
  [[nodiscard]] double scale() const { return scale_; }
  /// Ratio of horizontal root motion, target over source.
  void set_path_scale(double scale) { path_scale_ = scale; }
  /// @param ground m, height of the ground under the source; the target's ground is 0
  void set_ground(double ground) { ground_ = ground; }
  [[nodiscard]] const LimbDrive& limb(int k) const { return limbs_[static_cast<std::size_t>(k)]; }
  [[nodiscard]] const ChainSolver& solver() const { return solver_; }
  /// Returns one sentence for each mapped source link: which target links it drives.
  [[nodiscard]] std::vector<std::string> describe_mapping() const;

 private:
  /// Goal orientation of a target link: it follows source link a, or an orientation interpolated between source links a and b.
  struct LinkGoal {
    int link = -1;              ///< link of the target
    int a = -1, b = -1;         ///< links of the source; b = -1: the goal follows only a
    double t = 0;               ///< interpolation parameter from a (0) to b (1)
    bool level = false;         ///< true: the tilt is limited, because source and target trunk are of different kinds
    Mat3 K = Mat3::identity();  ///< constant rotation from the source's anatomical axes to the target link's frame
  };
  /// Method by which a cluster is solved. root: floating base; twin: coordinates are copied from identical joints of the source; single:
  /// one joint, in closed form; general: iteratively.
  enum class Kind { root, twin, single, general };
  /// Links of the target whose joints are solved together for one goal.
  struct Cluster {
    Kind kind = Kind::general;
    std::vector<int> links;
    int goal = -1;                  ///< index into goals_
    int movable = -1;               ///< root, single: the link whose joint is solved
    Mat3 R_rel = Mat3::identity();  ///< root, single: orientation of the goal's link relative to the movable link
    std::vector<int> twins;         ///< twin: [links] source links whose joints are identical
    bool from_stand = false;        ///< true: DOFs are redundant, so in each frame the solution starts from the standing posture
  };

  void map_trunk();
  void map_chain(const std::vector<int>& source, int source_base, const std::vector<int>& target, bool level);
  void map_limbs();
  void map_extras(const Mapping& mapping);
  void add_goal(int target, int a, int b, double t, bool deviation, bool level);
  void make_clusters();
  [[nodiscard]] bool is_twin(int source, int target) const;
  [[nodiscard]] Mat3 goal_rotation(const LinkGoal& w, std::span<const Pose> X_S) const;
  void solve(const Cluster& c, std::span<const double> q_S, std::span<const Pose> X_S, double* q, std::span<Pose> X);
  bool bend_knee(const LimbRig& limb, const Vec3& target, double* q, std::span<Pose> X);
  void aim(const LimbRig& limb, const Vec3& target, double* q, std::span<Pose> X);
  void turn_end(const LimbRig& limb, const Mat3& R, double* q, std::span<Pose> X);
  void place_from(const LimbRig& limb, int link, const double* q, std::span<Pose> X) const;

  const Rig& s_;
  const Rig& t_;
  bool same_kind_;
  double scale_ = 1, path_scale_ = 1, ground_ = 0, crouch_ = 0;
  ChainSolver solver_;
  std::vector<LinkGoal> goals_;
  std::vector<int> goal_of_;  // [links of the target] index into goals_; -1: none
  std::vector<int> partner_;  // [links of the target] corresponding link of the source; -1: none
  std::vector<Cluster> clusters_;
  std::vector<std::pair<int, int>> extras_;  // (source, target) links whose coordinates are copied
  std::vector<LimbDrive> limbs_;
};

}  // namespace ugoki::retarget
