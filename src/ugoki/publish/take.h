#pragma once
// A take: the recorded motion of content in one run, as poses of all links at every display frame. Writers for other tools.

#include <functional>
#include <string>
#include <vector>

#include "ugoki/content/player.h"

namespace ugoki::publish {

struct TakeCharacter {
  std::string id, name;
  std::string color;                      ///< "#rrggbb"
  std::vector<std::string> shape_colors;  ///< of the visible shapes, link by link; those without one have `color`
  std::string shown = "skin";             ///< of a mechanism with a skin: ScenarioMaterial::shown
  MechanismPtr mechanism;
  std::vector<content::DisplayPose> poses;  ///< [frames * links] in the world
  std::vector<Vec3> centres;                ///< [frames] centre of mass, m, world
  std::vector<double> q;                    ///< [frames * nq] position coordinates

  [[nodiscard]] std::size_t links() const { return static_cast<std::size_t>(mechanism->link_count()); }
  [[nodiscard]] const content::DisplayPose& pose(int frame, std::size_t link) const {
    return poses[static_cast<std::size_t>(frame) * links() + link];
  }
};

struct Take {
  std::string name;
  double rate = 60;  ///< frames per second
  int frames = 0;
  std::vector<TakeCharacter> characters;
  Vec3 gravity;  ///< acceleration of gravity, m/s^2
  content::ScenarioCamera camera;
};

/// Callback with the completed fraction, 0 ... 1. The work ends if it returns false.
using TakeProgress = std::function<bool(double)>;

/// Runs a player from its present state to `duration` [s] and records frames at the times 0, 1/rate, 2/rate ... Each frame is the state
/// after the step closest to its time.
/// Errors: the run stopped; `progress` returned false.
[[nodiscard]] Result<Take> record_take(content::Player& player, double duration, double rate, const TakeProgress& progress = {});

/// Returns the take as binary glTF 2.0: one skin, mesh, material and skeleton for each character, one animation, one camera. Y up, Z
/// forward, metres. World positions of the joints have single precision.
[[nodiscard]] std::vector<std::byte> write_take_glb(const Take& take);

/// Returns the take as USD text (*.usda): UsdSkel skeletons with animations, bound meshes, materials and a camera; UsdPhysics bodies and
/// joints of each mechanism in the pose of its first frame. Z up, metres.
[[nodiscard]] std::string write_take_usda(const Take& take);

/// Returns the take as a CSV table with a row for each frame: time [s]; for each character the centre of mass [m], and for each link
/// position [m] and unit quaternion (w x y z), world. Names of columns: "character/link x". Numbers have 9 significant digits.
[[nodiscard]] std::string write_take_csv(const Take& take);

/// Returns the motion of one character as BVH, in centimetres. @param character id or name; empty: the first character with links
/// Error `unknown`: the take has no such character.
[[nodiscard]] Result<std::string> write_take_bvh(const Take& take, std::string_view character);

/// Returns the character with this id or name; empty: the first one with links. Error `unknown`: there is none.
[[nodiscard]] Result<const TakeCharacter*> find_character(const Take& take, std::string_view character);

/// The position [m] of the take's camera at a frame, and the unit vectors of its picture: right, up, and backwards (away from the scene).
struct TakeView {
  Vec3 position, right, up, back;
};
[[nodiscard]] TakeView view_at(const Take& take, int frame);
/// Vertical angle of view of the camera, rad.
inline constexpr double take_field_of_view = 36 * pi / 180;

}  // namespace ugoki::publish
