#pragma once
// Conversions between the two kinds of motion data of Nagashima (1999), section 3.2: angle-oriented (coordinates over time) and
// torque-oriented (torques over time from a first state). Both conversions run the complete content, because the torques of a character
// depend on the ground and on everything else that touches it.

#include <functional>
#include <string>
#include <vector>

#include "ugoki/content/generate.h"

namespace ugoki::content {

/// A document with its mechanisms and motions.
struct ConvertedContent {
  Scenario scenario;
  Resources resources;
};

/// Deviation of a run from a reference. Angles: DOFs of joints that are rotations, and the rotation of a floating root.
struct Deviation {
  double rms_deg = 0, max_deg = 0;  ///< joints
  double root_deg = 0;              ///< maximum, degrees
  double root_mm = 0;               ///< maximum, mm
};

/// What a conversion changed or lost, for one character.
struct ConversionReport {
  std::string character;
  std::string motion;                       ///< id of the new motion
  Deviation deviation;                      ///< to torques: from the coordinates of the track; to angles: of the new motion from the run
  double root_rms_bw = 0, root_max_bw = 0;  ///< force on the root that no joint supplies, body weights; 0: the joints alone make the motion
  double over_effort = 0;                   ///< fraction of all torques that exceed the effort limit of their joint
};

struct ConversionOptions {
  /// To torques. False: the control mode `path` follows the coordinates of the tracks as they are, and the root receives the force that the
  /// joints lack. True: the content's own control is used; with an assist limit of 0 no force acts on the root.
  bool own_control = false;
  double duration = 0;  ///< s; 0: the duration of the scenario
  double rate = 0;      ///< frames per second of the new coordinates (to angles); 0: one frame after each step, which loses nothing
  /// Receives the completed fraction. If it returns false, the conversion ends with an error. May be empty.
  std::function<bool(double)> progress;
};

struct TorqueConversion {
  ConvertedContent content;  ///< the converted characters have the control mode `torque`
  std::vector<ConversionReport> characters;
  bool replays = false;  ///< a run of `content` has the same state bits after the last step as the run in which the torques were computed
};

/// Converts the tracks of all characters that follow one. Torques are constant during each simulation step.
/// Errors: no character has a track; the scenario has a circuit of its own without the LSI `dynamics`, or with `own_control` false; an
/// error of the run.
[[nodiscard]] Result<TorqueConversion> to_torques(const Scenario& scenario, const Resources& resources,
                                                  const ConversionOptions& options = {});

struct AngleConversion {
  ConvertedContent content;  ///< the converted characters have the control mode `path`
  std::vector<ConversionReport> characters;
};

/// Converts the torque-oriented motions of all characters of the control mode `torque`: runs the content and samples the coordinates.
/// Errors: no character has this control mode; an error of the run.
[[nodiscard]] Result<AngleConversion> to_angles(const Scenario& scenario, const Resources& resources,
                                                const ConversionOptions& options = {});

}  // namespace ugoki::content
