#include "gait_ground.h"

#include <algorithm>
#include <cmath>

#include "ugoki/spatial/elementary.h"

namespace ugoki::cli {
namespace {

constexpr double first_step = 1;         // m ahead of the start
constexpr double foot_of_ramp = 1.5;     // m ahead of the start
constexpr double margin = 3, side = 10;  // m of ground behind and beside the motion: a character without root assist strays from its path
constexpr double friction = 0.9;         // as the floor of a scenario

/// A prop on whose bottom's centre the point (x, y, z) is.
void add(content::Scenario& scenario, content::PropShape shape, const Vec3& at, const Vec3& size, double heading, int steps = 5) {
  content::ScenarioCharacter c;
  c.id = std::string(name_of(shape));
  c.name = shape == content::PropShape::box ? "Platform" : shape == content::PropShape::ramp ? "Ramp" : "Stairs";
  c.color = "#8f9aa8";
  c.group = "Props";
  c.place = {at.x, at.y, at.z, heading};
  c.control.mode = content::ControlMode::passive;
  content::Prop& prop = c.prop.emplace();
  prop.shape = shape;
  prop.size = size;
  if (shape == content::PropShape::stairs) prop.steps = steps;
  prop.friction = friction;
  c.mechanism = content::prop_mechanism_id(prop);
  scenario.characters.push_back(std::move(c));
}

struct Extent {
  double from_x, to_x, middle_y, width;  // m
};
Extent extent_of(const Motion& motion) {
  double low[2] = {1e9, 1e9}, high[2] = {-1e9, -1e9};
  for (int i = 0; i < motion.frames; ++i)
    for (int k = 0; k < 2; ++k) {
      low[k] = std::min(low[k], motion.frame(i)[k]);
      high[k] = std::max(high[k], motion.frame(i)[k]);
    }
  return {low[0] - margin, high[0] + margin, 0.5 * (low[1] + high[1]), high[1] - low[1] + 2 * side};
}

}  // namespace

std::function<double(double, double)> height_of(const GaitGround& ground) {
  std::function<double(double, double)> height;
  if (ground.slope != 0) height = [rise = tan(ground.slope * (pi / 180))](double x, double) { return rise * x; };
  if (ground.stairs == 0) return height;
  return [height, rise = ground.stairs, depth = ground.stair_depth](double x, double y) {
    return (height ? height(x, y) : 0.0) + (x > first_step ? rise * (std::floor((x - first_step) / depth) + 1) : 0.0);
  };
}

Result<void> add_ground(const GaitGround& ground, const Motion& motion, content::Scenario& scenario) {
  if (ground.level()) return {};
  if (ground.slope != 0 && ground.stairs != 0)
    return fail(ErrorCode::range, "--project", "The ground of a project is a slope or stairs, not both.",
                "Leave out --slope or --stairs, or write the motion to a file instead.");
  const Extent e = extent_of(motion);
  const bool sloping = ground.slope != 0;
  const double begin = sloping ? foot_of_ramp : first_step, depth = sloping ? std::max(0.0, e.to_x - begin) : ground.stair_depth;
  const int steps = static_cast<int>(std::ceil((e.to_x - begin) / ground.stair_depth));
  if (steps < 1) return {};
  if (e.to_x - e.from_x > content::Prop::max_size || e.width > content::Prop::max_size || (!sloping && steps > content::Prop::max_steps))
    return fail(ErrorCode::range, "--project",
                "The ground of the motion is longer than " + std::to_string(static_cast<int>(content::Prop::max_size)) + " m or " +
                    std::to_string(content::Prop::max_steps) + " steps.",
                "Make the motion shorter or the steps deeper, or write the motion to a file instead.");
  const double length = sloping ? depth : steps * depth;
  const double rise = sloping ? tan(ground.slope * (pi / 180)) * length : steps * ground.stairs;
  const content::PropShape shape = sloping ? content::PropShape::ramp : content::PropShape::stairs;
  if (rise > 0) {
    add(scenario, shape, {begin + 0.5 * length, e.middle_y, 0}, {length, e.width, rise}, 0, steps);
    return {};
  }
  // Downwards: a platform at the height of the motion's floor, and from there down to the floor of the scenario. The lowest step is that
  // floor.
  scenario.ground.height = rise;
  add(scenario, content::PropShape::box, {0.5 * (e.from_x + begin), e.middle_y, rise}, {begin - e.from_x, e.width, -rise}, 0);
  const int built = sloping ? 1 : steps - 1;
  const double share = sloping ? 1 : static_cast<double>(built) / steps;
  if (built > 0)
    add(scenario, shape, {begin + 0.5 * share * length, e.middle_y, rise}, {share * length, e.width, -share * rise}, 180, built);
  return {};
}

}  // namespace ugoki::cli
