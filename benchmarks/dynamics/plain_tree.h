#pragma once
// A tree of links and its state as plain values, from which peers (other engines) are built in translation units with their own flags.
// Joint frames are parallel to the link frames; inertias are about the centre of mass along the link's axes.

#include <memory>
#include <string>
#include <vector>

namespace ugoki {
namespace benchmarks {

struct PlainLink {
  int parent = -1;        ///< -1: the world
  bool floating = false;  ///< joint type; true: floating, false: revolute
  double axis[3] = {};
  double p[3] = {};        ///< m: position of the joint in the parent's frame
  double mass = 0;         ///< kg
  double centre[3] = {};   ///< m: centre of mass in the link's frame
  double inertia[3] = {};  ///< kg m^2: principal moments
};

/// A closed loop: link b welded to link a, or a ball joint between a point of a and a point of b.
struct PlainLoop {
  int a = -1, b = -1;  ///< link indices; a = -1: the world
  bool weld = true;
  double p[3] = {};          ///< weld: origin of b in a; ball: the point in a, in m
  double rotation[4] = {1};  ///< weld: orientation of b in a, wxyz
  double inverse_p[3] = {};  ///< m; weld: origin of a in b; ball: the point in b
  double inverse_rotation[4] = {1};
};

/// Tree and state. For a floating link q is position and quaternion wxyz, v is angular velocity in the link's frame and velocity in the
/// world, and tau (in the order of v) is 0.
struct PlainTree {
  std::vector<PlainLink> links;
  std::vector<PlainLoop> loops;
  std::vector<double> q, v, tau;
  double gravity = -9.81;  ///< m/s^2 along z
};

/// The tree in another physics engine. forward(), inverse() and inertia() return false if the engine does not support the task.
class Peer {
 public:
  virtual ~Peer() = default;
  virtual std::string name() const = 0;
  /// Forward dynamics, inverse dynamics and mass matrix from q, v and tau, including kinematics. inverse() uses the accelerations of the
  /// last forward().
  virtual bool forward() { return false; }
  virtual bool inverse() { return false; }
  virtual bool inertia() { return false; }
  /// Results of the revolute joints in the order of links, after forward() or inverse().
  virtual std::vector<double> joint_accelerations() = 0;
  virtual std::vector<double> joint_torques() { return {}; }
};

/// Makes a peer; null if the engine is not installed.
std::unique_ptr<Peer> make_mujoco(const PlainTree& tree);
std::unique_ptr<Peer> make_bullet(const PlainTree& tree);
std::unique_ptr<Peer> make_dart(const PlainTree& tree);
std::unique_ptr<Peer> make_simbody(const PlainTree& tree);

}  // namespace benchmarks
}  // namespace ugoki
