// The ground force of the dynamics against a virtual force plate. The plate's force follows from the measured motion alone, by Newton's
// second law for the centre of mass: F = m (g + a).
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "outcome.h"
#include "ugoki/content/display_frame.h"
#include "ugoki/content/generate.h"
#include "ugoki/content/player.h"
#include "ugoki/files/files.h"
#include "ugoki/mechanism/state.h"
#include "ugoki/motion/butterworth.h"
#include "ugoki/motion/clip.h"

namespace ugoki::dialects {
namespace {

constexpr double rate = 500;      // 1/s, samples of both forces
constexpr double cutoff = 10;     // Hz, low-pass of both forces; the motion itself contains no more
constexpr double gravity = 9.81;  // m/s^2

/// Vertical force [N] of the plate at times k / rate: m (g + a) of the centre of mass of the body that follows the measured motion.
std::vector<double> plate_force(const Mechanism& m, const Motion& motion) {
  std::vector<double> z;
  std::vector<Pose> X(static_cast<std::size_t>(m.link_count()));
  for (int f = 0; f < motion.frames; ++f) {
    calc_poses(m, std::span(motion.frame(f), static_cast<std::size_t>(motion.nq)), X);
    z.push_back(centre_of_mass(m, X).z);
  }
  filter_both_ways(z, motion.rate, cutoff);
  std::vector<double> out;
  for (int k = 0; k / rate < motion.duration(); ++k) {
    const double at = k / rate * motion.rate;
    const int f = std::clamp(static_cast<int>(at), 1, motion.frames - 3);
    const auto acceleration = [&](int i) {
      const auto u = static_cast<std::size_t>(i);
      return (z[u + 1] - 2 * z[u] + z[u - 1]) * motion.rate * motion.rate;
    };
    const double share = std::clamp(at - f, 0.0, 1.0);
    out.push_back(m.mass() * (gravity + (1 - share) * acceleration(f) + share * acceleration(f + 1)));
  }
  return out;
}

TEST(PlateForce, VerticalForceOfTheDynamicsFollowsThePlate) {
  const char* const file = "human/bvh/cmu_12_01_walk.bvh";
  const auto bytes = files::read_file(std::string(UGOKI_SHARED_DATA) + "/" + file);
  if (!bytes) GTEST_SKIP() << "The shared measured data are absent.";
  const auto in = intake::take_in(*bytes, file);
  ASSERT_TRUE(in.has_value()) << in.error().text();
  const Motion& motion = *in->motion;
  content::Scenario s;
  s.name = "plate";
  s.duration = std::min(4.0, motion.duration());
  content::ScenarioCharacter character;
  character.id = character.name = "character";
  character.mechanism = "mechanism";
  const Placement start = root_placement(*in->mechanism, {motion.frame(0), static_cast<std::size_t>(motion.nq)});
  character.place = {start.x, start.y, 0, start.heading * (180 / pi)};
  content::ScenarioClip clip;
  clip.id = "clip";
  clip.motion = "motion";
  clip.length = s.duration;
  character.track.push_back(clip);
  s.characters.push_back(character);
  content::Resources resources;
  resources.mechanisms["mechanism"] = in->mechanism;
  resources.motions["motion"] = std::make_shared<const Motion>(motion);
  const auto ugx = content::generate(s, resources);
  ASSERT_TRUE(ugx.has_value()) << ugx.error().text();
  auto player = content::Player::open(*ugx);
  ASSERT_TRUE(player.has_value()) << player.error().text();
  std::vector<double> force, assist;
  content::DisplayFrame frame;
  while (player->time() < s.duration) {
    ASSERT_TRUE(player->step().has_value());
    player->display_frame(frame);
    if (player->time() * rate < static_cast<double>(force.size())) continue;
    double sum = 0;
    for (const content::DisplayContact& c : frame.contacts) sum += c.force.z;
    force.push_back(sum);
    assist.push_back(frame.characters[0].assist_force.z);
  }
  std::vector<double> plate = plate_force(*in->mechanism, motion);
  plate.resize(std::min(plate.size(), force.size()));
  force.resize(plate.size());
  filter_both_ways(force, rate, cutoff);
  filter_both_ways(plate, rate, cutoff);
  // The first and last 0.3 s are left out: there the filters have no samples beyond the ends.
  double squares = 0, all = 0, help = 0;
  const std::size_t from = static_cast<std::size_t>(0.3 * rate), to = plate.size() - from;
  for (std::size_t k = from; k < to; ++k) {
    squares += (force[k] - plate[k]) * (force[k] - plate[k]);
    all += plate[k] * plate[k];
    help += assist[k] * assist[k];
  }
  EXPECT_LT(std::sqrt(squares / all), 0.10);
  EXPECT_LT(std::sqrt(help / all), 0.01);  // the force comes from the contacts, not from the root assist
}

}  // namespace
}  // namespace ugoki::dialects
