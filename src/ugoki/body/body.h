#pragma once
// From a measured skeleton to a body that can be simulated: masses, inertias, shapes, joint limits, feet that can stand.
// docs/design/body.md says how.

#include <string>
#include <vector>

#include "ugoki/base/result.h"
#include "ugoki/mechanism/mechanism.h"
#include "ugoki/motion/motion.h"
#include "ugoki/motion/skeleton.h"

namespace ugoki::body {

enum class Sex { mean, female, male };

struct BodyOptions {
  double height = 0;          ///< m; 0: estimated from the skeleton
  double mass = 0;            ///< kg; 0: the file's if plausible, otherwise 22.5 kg/m^2 times height squared
  Sex sex = Sex::mean;        ///< which of de Leva's tables; mean: the average of both
  bool keep_unmoved = false;  ///< true: joints that have freedoms but do not move in this motion stay movable
  bool level_floor = true;    ///< false: the floor of the measured data is z = 0 and level; nothing is shifted
};

/// A foot on which the body stands.
struct Sole {
  int foot = -1;         ///< joint at the ankle
  int toes = -1;         ///< joint at the ball; -1: the foot ends in an end site there
  Vec3 ball;             ///< m, the ball in the foot's frame
  double thickness = 0;  ///< m, from the ball down to the ground
};

/// A mechanism made from a skeleton, and what is needed to bring measured motion onto it.
struct Body {
  MechanismPtr mechanism;
  std::vector<int> link_of_joint;        ///< [joints of the skeleton] index of the link
  std::vector<std::string> joint_names;  ///< [joints of the skeleton]
  double height = 0;                     ///< m, of the standing person
  double mass = 0;                       ///< kg, = mechanism->mass()
  bool human = false;                    ///< false: no human anatomy was recognised; capsules of density 1000 along the bones
  bool level_floor = true;
  std::vector<Sole> soles;
  std::vector<std::string> report;  ///< sentences for people: what was recognised, estimated, widened, shifted
};

/// The body of a measured skeleton. Links are the skeleton's joints, with the same names; a link's frame is parallel to
/// the world's at rest and sits at the joint. `motion` decides which joints are fixed, hinges, universal or spherical, and
/// how thick the soles are. Labels (Link::label): "pelvis", "abdomen", "abdomen upper", "chest", "neck", "head", and with
/// " left" or " right": "thigh", "shank", "foot", "toes", "shoulder", "upper arm", "forearm", "hand", "fingers", "thumb".
/// Fails when the skeleton has no joints, no extent, or numbers that are not finite.
[[nodiscard]] Result<Body> make_body(const MeasuredMotion& motion, const BodyOptions& options = {});

/// True if the first frame is a pose for calibration (a T, as many converters put before the motion): a joint turns by more
/// than 20 degrees to the second frame, and five times more than in the next ones.
[[nodiscard]] bool has_calibration_frame(const MeasuredMotion& motion);

/// The measured motion in the coordinates of the body's mechanism, moved by calc_floor_pose so that the floor is z = 0.
/// A calibration pose is replaced by what
/// leads into the second frame. Every joint's position is that of the measured motion to 1e-6 m for the motion the body was made of; for
/// others see calc_position_error. The skeleton's joints must be those of the body. Ground contacts are labelled.
[[nodiscard]] Motion to_motion(const Body& body, const MeasuredMotion& motion);

/// Pose of the measured motion's world in ours: lifts the floor found under the standing feet to z = 0, and levels it
/// where the stance feet show that the capture volume was tilted. Identity if the body is no human or has level_floor off.
[[nodiscard]] Pose calc_floor_pose(const Body& body, const MeasuredMotion& motion);

/// Greatest distance [m] between any joint of `measured` (moved by calc_floor_pose) and its link in `motion`, over all frames.
[[nodiscard]] double calc_position_error(const Body& body, const MeasuredMotion& measured, const Motion& motion);

}  // namespace ugoki::body
