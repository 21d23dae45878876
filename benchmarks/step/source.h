#pragma once
// Scenes from which both Ugoki's world and the plain description for the peers (other engines) are made.

#include <map>
#include <string>
#include <vector>

#include "scene.h"
#include "ugoki/mechanism/mechanism.h"
#include "ugoki/mechanism/state.h"

namespace ugoki::benchmarks {

/// A scene and its mechanisms, one for each body.
struct StepSource : StepScene {
  std::vector<MechanismPtr> mechanisms;
  std::vector<State> states;            ///< initial, one for each mechanism
  std::vector<std::vector<int>> links;  ///< [bodies][StepBody::links] index of the link in the mechanism
  int partly_excluded = 0;              ///< number of link pairs of which Ugoki tests some shapes; peers exclude such pairs completely

  /// Adds a mechanism with a floating base at the pose `base`, at rest. @param q [nq] positions of the joints; empty: neutral
  void add(const MechanismPtr& mechanism, const Pose& base, const std::map<std::string, Pose>& file_frames = {},
           std::span<const double> q = {});
  /// The scene lifted by `height` m, without joint limits and servos. Joints with one DOF have initial velocities of up to `speed` rad/s |
  /// m/s, unless the body has loops, which the velocities would open.
  /// @param armature false: joints have no armature
  [[nodiscard]] StepSource probe(double speed, double height, bool armature) const;
};

/// The mechanisms of a file of the shared data, one for each floating base.
struct StepModel {
  std::vector<MechanismPtr> mechanisms;
  std::map<std::string, Pose> file_frames;  ///< pose of the file's body in the link, by link name
  std::string mjcf;                         ///< MJCF files: the text for MuJoCo
};

/// Whether the shared data has this file.
bool have_model(const std::string& path);

/// Reads an MJCF or SDF file. Every shape gets the coefficient `friction`. The static shapes of the world are left out, and the links
/// named in `without` with all links attached to them. Revolute loops become ball loops. Throws std::runtime_error if the file cannot be
/// read.
StepModel read_model(const std::string& path, double friction, const std::vector<std::string>& without = {});

/// The text of an MJCF file for MuJoCo, reduced to bodies, joints and geoms with their defaults: pose, shapes and solver parameters remain
/// those of the file. Adds a floor, the time step and the excluded pairs of bodies.
std::string reduce_mjcf(const std::string& text, const std::vector<std::string>& without);

/// Sets source.mjcf: the reduced text with the parts that depend on the scene (sizes, time step, excluded pairs). `source` has one body.
void finish_mjcf(StepSource& source, const std::string& reduced);

/// Lowest and highest z coordinate [m] of the shapes of a mechanism in the world.
std::pair<double, double> heights(const Mechanism& m, const State& s);

StepWorldPtr make_ugoki(const StepSource& source);

}  // namespace ugoki::benchmarks
