#include "creatures.h"

#include <random>
#include <string>

namespace ugoki::dialects {

MeasuredMotion make_creature(std::uint64_t seed) {
  std::mt19937_64 random(seed);
  const auto uniform = [&](double a, double b) { return a + (b - a) * static_cast<double>(random() >> 11) * 0x1p-53; };
  const auto below = [&](int n) { return static_cast<int>(random() % static_cast<std::uint64_t>(n)); };
  MeasuredMotion m;
  m.name = "creature " + std::to_string(seed);
  m.rate = 30;
  m.frames = 60;
  auto& joints = m.skeleton.joints;
  const double size = 0.02 * std::pow(300.0, uniform(0, 1));
  const bool named = below(2) == 0;
  const auto add = [&](const std::string& name, int parent, const Vec3& offset) {
    SkeletonJoint j;
    j.name = named ? name : "n" + std::to_string(joints.size());
    j.parent = parent;
    j.offset = offset * size;
    j.dofs = {{{0, 0, 1}}, {{1, 0, 0}}, {{0, 1, 0}}};
    joints.push_back(j);
    return static_cast<int>(joints.size()) - 1;
  };
  const int segments = 1 + below(4), pairs = 1 + below(6);
  std::vector<int> trunk = {add("hips", -1, {})};
  std::vector<double> rise = {0};  // heights of the trunk's joints above the hips
  for (int k = 1; k <= segments; ++k) {
    const double up = uniform(-0.02, 0.05);
    rise.push_back(rise.back() + up);
    trunk.push_back(add("spine" + std::to_string(k), trunk.back(), {0.8 / segments, 0, up}));
  }
  const double hips = uniform(0.35, 0.9), spread = uniform(0.05, 0.4);
  for (int pair = 0; pair < pairs; ++pair) {
    const auto place = static_cast<std::size_t>(pairs == 1 ? 0 : pair * segments / std::max(1, pairs - 1));
    const int from = trunk[place];
    const double leg = hips + rise[place];  // the height of the trunk's joint, so that all feet reach the floor
    const int bones = 2 + below(3);
    const double shift = uniform(-0.05, 0.05), knee = uniform(-0.15, 0.15);
    for (const double side : {1.0, -1.0}) {
      int parent = from;
      for (int b = 0; b < bones; ++b) {
        const Vec3 offset = b == 0 ? Vec3{shift, side * 0.1, -0.02}
                                   : Vec3{(b % 2 == 1 ? knee : -knee) * leg, side * spread * leg / bones, -leg / (bones - 1)};
        parent = add("leg" + std::to_string(pair) + "_" + std::to_string(b) + (side > 0 ? "_L" : "_R"), parent, offset);
      }
      // Add a foot.
      joints[static_cast<std::size_t>(parent)].end_sites = {Vec3{0.1, 0, 0} * (leg * size)};
    }
  }
  if (below(2) == 0) {
    int parent = trunk.back();
    for (int k = 0, n = 1 + below(3); k < n; ++k)
      parent = add("neck" + std::to_string(k), parent, {uniform(0.05, 0.2), 0, uniform(0, 0.2)});
    joints[static_cast<std::size_t>(add("head", parent, {0.1, 0, 0.05}))].end_sites = {Vec3{0.15, 0, 0} * size};
  }
  if (below(2) == 0) {
    int parent = trunk.front();
    for (int k = 0, n = 1 + below(6); k < n; ++k)
      parent = add("tail" + std::to_string(k), parent, {-uniform(0.05, 0.15), 0, uniform(-0.02, 0.03)});
  }
  if (below(3) == 0)
    for (const double side : {1.0, -1.0}) {
      int parent = trunk.back();
      for (int k = 0; k < 3; ++k)
        parent = add(std::string("wing") + std::to_string(k) + (side > 0 ? "_L" : "_R"), parent, {-0.02, side * 0.25, 0.02});
      add(std::string("feather_tip") + (side > 0 ? "_L" : "_R"), parent, {0, side * 0.001, 0});
    }
  joints[0].translates = true;
  // The creature sways: legs and trunk turn by a few degrees.
  std::vector<double> phase;
  for (std::size_t i = 0; i < joints.size(); ++i) phase.push_back(uniform(0, 6));
  for (int f = 0; f < m.frames; ++f)
    for (std::size_t i = 0; i < joints.size(); ++i) {
      const double t = f / m.rate;
      m.translations.push_back(i == 0 ? Vec3{0, 0, hips * size * 1.05} : joints[i].offset);
      m.rotations.push_back(
          i == 0 ? Quat{} : axis_angle({0, 1, 0}, 0.04 * sin(3 * t + phase[i])) * axis_angle({0, 0, 1}, 0.03 * sin(2 * t + phase[i])));
    }
  return m;
}

}  // namespace ugoki::dialects
