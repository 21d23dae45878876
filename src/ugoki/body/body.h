#pragma once
// Makes a body that can be simulated from a measured skeleton: masses, inertias, shapes, joint limits, soles.
// docs/design/body.md describes the method and its sources.

#include <string>
#include <vector>

#include "ugoki/base/result.h"
#include "ugoki/body/mapping.h"
#include "ugoki/mechanism/mechanism.h"
#include "ugoki/motion/motion.h"
#include "ugoki/motion/skeleton.h"

namespace ugoki::body {

/// Selects de Leva's table; mean: the average of the female and the male table.
enum class Sex { mean, female, male };

/// Options of make_body; the defaults estimate everything from the motion.
struct BodyOptions {
  double height = 0;    ///< m; 0: estimated from the skeleton
  double mass = 0;      ///< kg; 0: the file's mass if its body mass index is 12 to 60 kg/m^2, otherwise 22.5 kg/m^2 times height squared
  Sex sex = Sex::mean;  ///< table of segment parameters
  bool keep_unmoved = false;                ///< true: joints with DOFs stay movable even if they do not move in this motion
  const AnatomyMapping* mapping = nullptr;  ///< corrects the recognised anatomy; null: none
  bool level_floor = true;                  ///< false: the measured floor is already z = 0 and level; the motion is not shifted
};

/// Sole of a foot on which the body stands.
struct Sole {
  int foot = -1;         ///< skeleton joint at the ankle
  int toes = -1;         ///< skeleton joint at the ball of the foot; -1: the foot ends there in an end site
  Vec3 ball;             ///< m, ball of the foot in the foot's frame
  double thickness = 0;  ///< m, height of the ball above the ground in stance
};

/// A mechanism made from a skeleton, with the data for converting measured motion to it (to_motion).
struct Body {
  MechanismPtr mechanism;
  std::vector<int> link_of_joint;        ///< [joints of the skeleton] index of the link
  std::vector<std::string> joint_names;  ///< [joints of the skeleton]
  double height = 0;                     ///< m, standing height of the person
  double mass = 0;                       ///< kg, = mechanism->mass()
  bool human = false;                    ///< false: no human anatomy was recognised; the links are capsules of 1000 kg/m^3 along the bones
  bool level_floor = true;               ///< BodyOptions::level_floor
  std::vector<Mat3> rest;                ///< [joints] turns from the file's rest pose to the body's (canonical_turns); empty: the same pose
  std::vector<Sole> soles;               ///< left, right; empty if not human; in the body's rest pose
  double confidence = 0;                 ///< 0 ... 1: confidence in the anatomy
  AnatomyMapping anatomy;                ///< recognised body plan and limbs; no entries if no limbs were recognised
  std::vector<std::string> report;       ///< sentences for display: what was recognised, estimated, widened, shifted
};

/// Makes the body of a measured skeleton. Each joint of the skeleton becomes a link of the same name. A link's frame has its origin at
/// the joint and is parallel to the world at rest, in the canonical rest pose (recognise.h). `motion` decides which joints are fixed,
/// hinges, universal or spherical, and how thick the soles are. Labels (Link::label): "pelvis", "abdomen", "abdomen upper", "chest",
/// "neck", "head", and with " left" or " right": "thigh", "shank", "foot", "toes", "shoulder", "upper arm", "forearm", "hand", "fingers",
/// "thumb". Errors: the skeleton has no joints or no extent; a value is not finite; parents do not precede children.
[[nodiscard]] Result<Body> make_body(const MeasuredMotion& motion, const BodyOptions& options = {});

/// Number of frames at the beginning that belong to a calibration pose (many converters put a T pose before the motion); 0: none.
/// It is 1 if from the first to the second frame some joint turns by more than 20 degrees, and by more than five times the largest turn in
/// the next two frame steps. Filters smear the calibration pose over the following frames. Up to eight frames are therefore counted if the
/// first step turns some joint by more than 20 degrees and six of ten moving joints by more than four times their usual turn (and 3
/// degrees).
[[nodiscard]] int count_calibration_frames(const MeasuredMotion& motion);

/// Converts a measured motion to coordinates of the body's mechanism, moved by calc_floor_pose so that the floor is z = 0.
/// Frames of a calibration pose (count_calibration_frames) are replaced by an extrapolation of the following frames. For the motion from
/// which the body was made, every joint's position agrees with the measured one to 1e-6 m; for other motions see calc_position_error.
/// `motion` must have the skeleton of the body. Ground contacts are labelled.
[[nodiscard]] Motion to_motion(const Body& body, const MeasuredMotion& motion);

/// Pose of the measured motion's world in the world of to_motion's result: moves the floor found under the standing feet to z = 0 and
/// levels it if the standing feet show that the capture volume was tilted. Identity if the body is not human or level_floor is false.
[[nodiscard]] Pose calc_floor_pose(const Body& body, const MeasuredMotion& motion);

/// Maximum distance [m] between any joint of `measured` (moved by calc_floor_pose) and its link in `motion`, over all frames.
[[nodiscard]] double calc_position_error(const Body& body, const MeasuredMotion& measured, const Motion& motion);

}  // namespace ugoki::body
