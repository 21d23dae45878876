#pragma once
// Gaits without measurement: makes a motion in which a mechanism with legs walks, runs, trots, gallops ... The motion is computed from a
// table of gaits and from the laws of mechanics. docs/design/gait.md describes the method.

#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "ugoki/motion/motion.h"
#include "ugoki/spatial/vec3.h"

namespace ugoki::gait {

enum class GaitKind { walk, run, trot, pace, canter, gallop, rotary, bound, pronk };
inline constexpr int kind_count = 9;
[[nodiscard]] std::string_view name_of(GaitKind kind);
[[nodiscard]] std::optional<GaitKind> kind_named(std::string_view name);

/// What the character does from a time on. Speed and turn rate change smoothly from one stage to the next.
struct GaitStage {
  double time = 0;  ///< s: begin
  GaitKind kind = GaitKind::walk;
  double speed = 1.25;  ///< m/s, forward; 0: stand
  double turn = 0;      ///< rad/s, positive to the left; not used if the gait has a path
};

/// How a gait differs from the usual one. The defaults are the usual gait.
struct GaitStyle {
  double lean = 0;       ///< rad: the trunk leans forward by this more than usual
  double crouch = 0;     ///< share of the leg length by which the body is lowered
  double arms = 1;       ///< factor on the swing of the arms
  double elbows = 0;     ///< rad: further flexion of the elbows
  double width = 1;      ///< factor on the lateral distance of the feet
  double bounce = 1;     ///< factor on the vertical movement of the centre of mass
  double cadence = 1;    ///< factor on the number of strides per second
  double hips = 1;       ///< factor on rotation and list of the pelvis
  double head = 0;       ///< rad: the head is pitched forward by this more than usual
  double lift = 1;       ///< factor on the height of the swing feet
  double foot_roll = 1;  ///< factor on the pitch of the feet at touch-down and lift-off
};
/// Names: "usual", "sneak", "tired", "proud", "hurried". Nothing: no style has this name.
[[nodiscard]] std::optional<GaitStyle> style_named(std::string_view name);
[[nodiscard]] std::vector<std::string_view> style_names();

struct GaitOptions {
  std::vector<GaitStage> stages{{}};  ///< sorted by time; the first one begins at the start, whatever its time
  double seconds = 10;                ///< s: duration; not used for one stride
  bool one_stride = false;            ///< true: one stride of the first stage, cyclic
  bool from_stand = true;             ///< the character stands at the begin, and starts to move at once
  bool to_stand = true;               ///< the character stands at the end
  double rate = 120;                  ///< frames per second
  double step_height = 0;             ///< m: height of the swing feet; 0: usual
  double stride_time = 0;             ///< s: duration of a stride; 0: from the table
  double gravity = 9.81;              ///< m/s^2
  GaitStyle style;
  /// Height of the ground [m] at x, y. Empty: the plane z = 0. Used where the body walks and at the feet.
  std::function<double(double, double)> ground;
  std::vector<Vec3> path;           ///< m: points of a path over the ground (x, y) from the start; fewer than two: stages decide
  std::vector<double> phases;       ///< [legs] touch-down of each leg as a share of the stride; empty: from the table
  double duty = 0;                  ///< share of the stride in which a foot stands; 0: from the table
  std::function<bool()> cancelled;  ///< called before each frame; true ends the work with ErrorCode::cancelled
};

/// Time interval in which a foot stands.
struct FootStance {
  double begin = 0, end = 0;  ///< s
  Vec3 place;                 ///< m, world: the middle of the sole, on the ground
  double heading = 0;         ///< rad
};

struct GaitReport {
  std::vector<std::string> legs;                 ///< names of the feet, in the order of GaitOptions::phases
  std::vector<std::vector<FootStance>> stances;  ///< [legs]
  double stride_time = 0;                        ///< s, of the last stage
  double duty = 0;                               ///< of the last stage
  double max_miss = 0;                           ///< m: maximum distance of a foot from its path
  double max_lowering = 0;                       ///< m: maximum lowering of the body for the reach of the legs
  double pressure_rms = 0;                       ///< m: rms distance of the centre of pressure from the planned one
  std::vector<std::string> notes;                ///< sentences about assumptions
};

/// A usual speed [m/s] of the kind for this mechanism. Errors: as make_gait.
[[nodiscard]] Result<double> usual_speed(const MechanismPtr& mechanism, GaitKind kind, double gravity = 9.81);

/// The kinds of gaits for the number of legs of this mechanism. Errors: the root is not floating; no feet, or a number of legs for which no
/// gait is known.
[[nodiscard]] Result<std::vector<GaitKind>> kinds_of(const MechanismPtr& mechanism);

/// Sets the duration such that the gait, from standing to standing, ends at the end of `options.path`. If the path is too short to reach
/// the speeds of the stages, the speeds become lower. Errors: as make_gait; no path; the path takes longer than 3600 s.
[[nodiscard]] Result<void> fit_to_path(const MechanismPtr& mechanism, GaitOptions& options);

/// Makes the motion. It begins at x = y = 0 and goes along +x. Errors: the root is not floating; no feet, or a number of legs for which no
/// gait is known; the kind does not fit the number of legs; options out of range.
[[nodiscard]] Result<Motion> make_gait(const MechanismPtr& mechanism, const GaitOptions& options, GaitReport* report = nullptr);

}  // namespace ugoki::gait
