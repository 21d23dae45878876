#pragma once
// A scene as plain numbers, from which the worlds of the peers are built, and the interface of a world.
// Every engine gets the same links, joints, inertias, shapes, friction, excluded pairs, start and time step.

#include <limits>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "frame.h"

namespace ugoki::benchmarks {

enum class StepJoint : unsigned char { floating, revolute, prismatic, spherical };
enum class StepShapeType : unsigned char { sphere, capsule, box, cylinder, ellipsoid };

/// A link with the joint to its parent. Links that are fixed to each other are one link here.
struct StepLink {
  std::string name;  ///< name of the link's body in the MJCF file
  int parent = -1;   ///< -1: the world (floating links only)
  StepJoint joint = StepJoint::floating;
  Frame joint_frame;           ///< pose in the parent link; in the neutral position also the pose of this link
  double axis[3] = {0, 0, 1};  ///< in the joint frame
  double lower = -std::numeric_limits<double>::infinity(), upper = std::numeric_limits<double>::infinity();  ///< rad | m
  double damping = 0;                                                                                        ///< N m s/rad | N s/m
  double stiffness = 0, rest = 0;                                                                            ///< N m/rad, rad | N/m, m
  double armature = 0;                                                                                       ///< kg m^2 | kg
  double position = 0, speed = 0;          ///< rad, rad/s | m, m/s: initial values of a joint with one DOF
  double mass = 0;                         ///< kg; 0: an auxiliary link between two joints of one body
  double centre[3] = {0, 0, 0};            ///< m, centre of mass in the link
  double inertia[6] = {0, 0, 0, 0, 0, 0};  ///< kg m^2 about the centre of mass: xx yy zz xy xz yz
  Frame principal;                         ///< pose of the principal axes, at the centre of mass, in the link
  double moments[3] = {0, 0, 0};           ///< kg m^2: principal moments, including the armature about the joint axis
  Frame file_frame;                        ///< pose of the file's body in the link
};

struct StepShape {
  int link = 0;
  StepShapeType type = StepShapeType::sphere;
  Frame frame;                 ///< pose in the link
  double size[3] = {0, 0, 0};  ///< m: half sizes; sphere, capsule, cylinder: radius, half length along z
};

/// A point of link a that must coincide with a point of link b.
struct StepLoop {
  int a = 0, b = 0;
  double point_a[3] = {0, 0, 0}, point_b[3] = {0, 0, 0};  ///< m, in the frames of link a and of link b
};

/// A mechanism with a floating base.
struct StepBody {
  std::vector<StepLink> links;  ///< parents first
  std::vector<StepShape> shapes;
  std::vector<StepLoop> loops;
  std::vector<std::pair<int, int>> excluded;  ///< links that do not collide with each other
  Frame base;                                 ///< initial pose of link 0 in the world
};

/// A time interval of a run that becomes a row of the table.
struct StepPhase {
  std::string row;
  int steps = 0;
};

/// A scene above the ground z = 0.
struct StepScene {
  std::string name;
  std::vector<StepBody> bodies;
  std::vector<StepPhase> phases;
  double dt = 0.002;                         ///< s
  double gravity = 9.81;                     ///< m/s^2
  double friction = 0.9;                     ///< friction coefficient of all contacts
  double servo_gain = 0, servo_damping = 0;  ///< N m/rad, N m s/rad: servos that hold the neutral position; 0: none
  double rest_energy = 0.01;  ///< the bodies are at rest if the final kinetic energy is at most this fraction of the initial energy
  double stands = 0;          ///< the character has fallen if the final potential energy is below this fraction of the initial energy
  double sunk = 0.02;         ///< m: a centre of mass deeper in the ground than this is a failure
  int max_contacts = 500;     ///< number of contacts for which MuJoCo reserves memory
  bool limits = true;         ///< true: the limits of the joints are active
  std::string mjcf;           ///< if not empty: text that MuJoCo reads instead of one written from the bodies
  std::string mjcf_geom;      ///< attributes of MuJoCo's contacts in written text, for example solref

  [[nodiscard]] int steps() const {
    int sum = 0;
    for (const StepPhase& p : phases) sum += p.steps;
    return sum;
  }
};

/// Thrown if an engine cannot continue because of a limit, for example of its memory; the earlier steps are valid.
struct StepLimit : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// The scene in one engine. step() computes one step; only step() is timed.
class StepWorld {
 public:
  virtual ~StepWorld() = default;
  /// Collision detection, contact forces and integration over StepScene::dt. Throws StepLimit, or std::runtime_error if the
  /// engine reports failure.
  virtual void step() = 0;
  /// Poses in the world of all links with mass, body by body.
  virtual void poses(std::vector<Frame>& out) const = 0;
  /// m: maximum penetration over the contacts of the last step; 0: none.
  [[nodiscard]] virtual double depth() const = 0;
  [[nodiscard]] virtual int contacts() const = 0;  ///< contact points of the last step
  [[nodiscard]] virtual int dofs() const = 0;
  [[nodiscard]] virtual double mass() const = 0;  ///< kg
};
using StepWorldPtr = std::unique_ptr<StepWorld>;

// Each returns null where the engine is not installed, and throws std::runtime_error where it cannot model the scene.
StepWorldPtr make_mujoco_newton(const StepScene& scene);
StepWorldPtr make_mujoco_pgs(const StepScene& scene);
StepWorldPtr make_bullet(const StepScene& scene);
StepWorldPtr make_dart(const StepScene& scene);

/// MJCF text of the bodies; bodies are named "<index>/<link>".
std::string write_scene_mjcf(const StepScene& scene);

}  // namespace ugoki::benchmarks
