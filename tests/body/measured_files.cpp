#include "measured_files.h"

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <filesystem>

#include "ugoki/files/files.h"
#include "ugoki/formats/asf.h"
#include "ugoki/formats/bvh.h"

namespace ugoki::body::testing {
namespace {
const std::string root = std::string(UGOKI_SHARED_DATA) + "/human/";

/// Value of a result; aborts the program with the error's text if the result is an error.
template <class T>
T must(Result<T> result) {
  if (!result) {
    std::fprintf(stderr, "%s\n", result.error().text().c_str());
    std::abort();
  }
  return std::move(*result);
}
}  // namespace

std::vector<std::string> all_files() {
  std::vector<std::string> files;
  for (const char* folder : {"bvh", "asf_amc"}) {
    std::error_code none;
    for (const auto& entry : std::filesystem::directory_iterator(root + folder, none)) {
      const std::string extension = entry.path().extension().string();
      if (extension == ".bvh" || extension == ".amc") files.push_back(std::string(folder) + "/" + entry.path().filename().string());
    }
  }
  std::sort(files.begin(), files.end());
  return files;
}

std::vector<std::string> human_files() {
  std::vector<std::string> files = all_files();
  std::erase_if(files, [](const std::string& f) {
    return f == "bvh/sinusoidal.bvh" || f == "bvh/full_precision_frame_time.bvh" || f == "bvh/rotation_first_root.bvh";
  });
  return files;
}

MeasuredMotion read(const std::string& file) {
  const std::string text = must(files::read_file(root + file));
  if (file.ends_with(".bvh")) return must(formats::read_bvh(text, file));
  const std::string skeleton = "asf_amc/" + file.substr(8, 2) + ".asf";
  return must(formats::read_amc(text, file, must(formats::read_asf(must(files::read_file(root + skeleton)), skeleton))));
}

MeasuredMotion made_character(int frames, double floor, double slope) {
  MeasuredMotion m;
  m.name = "character";
  m.frames = frames;
  Skeleton& s = m.skeleton;
  const auto add = [&](const char* name, int parent, Vec3 offset, std::vector<Vec3> ends = {}) {
    SkeletonJoint j;
    j.name = name;
    j.parent = parent;
    j.offset = offset;
    j.end_sites = std::move(ends);
    j.dofs = {{{0, 0, 1}}, {{1, 0, 0}}, {{0, 1, 0}}};
    s.joints.push_back(j);
    return static_cast<int>(s.joints.size()) - 1;
  };
  const int hips = add("Hips", -1, {0, 0, 0});
  int knee[2], spine = add("Spine", hips, {0, 0, 0.1});
  const int chest = add("Chest", spine, {0, 0, 0.22});
  const int neck = add("Neck", chest, {0, 0, 0.24});
  add("Head", neck, {0.01, 0, 0.1}, {{0, 0, 0.18}});
  int arm[2];
  for (int side = 0; side < 2; ++side) {
    const double y = side == 0 ? 1 : -1;
    const std::string name = side == 0 ? "Left" : "Right";
    const int thigh = add((name + "UpLeg").c_str(), hips, {0, 0.09 * y, -0.02});
    knee[side] = add((name + "Leg").c_str(), thigh, {0, 0, -0.43});
    const int foot = add((name + "Foot").c_str(), knee[side], {0, 0, -0.43});
    add((name + "ToeBase").c_str(), foot, {0.13, 0, -0.035}, {{0.065, 0, 0}});
    arm[side] = add((name + "Arm").c_str(), chest, {0, 0.18 * y, 0.2});
    const int forearm = add((name + "ForeArm").c_str(), arm[side], {0, 0.30 * y, 0});
    add((name + "Hand").c_str(), forearm, {0, 0.26 * y, 0}, {{0, 0.18 * y, 0}});
  }
  const double hip_height = 0.02 + 0.43 + 0.43 + 0.035 + 0.03;
  for (int f = 0; f < frames; ++f) {
    const double t = f / m.rate, bend = 0.3 * (1 - cos(2 * pi * t));
    for (std::size_t i = 0; i < s.joints.size(); ++i) {
      m.translations.push_back(s.joints[i].offset);
      m.rotations.push_back({});
    }
    const std::size_t first = static_cast<std::size_t>(f) * s.joints.size();
    // The character jumps forward by 0.5 m every second.
    const double x = 0.5 * std::floor(t);
    m.translations[first] = {x, 0, floor + slope * x + hip_height - 2 * 0.43 * (1 - cos(bend))};
    for (int side = 0; side < 2; ++side) {
      const auto k = static_cast<std::size_t>(knee[side]);
      m.rotations[first + k - 1] = axis_angle({0, 1, 0}, -bend);
      m.rotations[first + k] = axis_angle({0, 1, 0}, 2 * bend);
      m.rotations[first + k + 1] = axis_angle({0, 1, 0}, -bend - atan(slope));
      m.rotations[first + static_cast<std::size_t>(arm[side])] =
          axis_angle({1, 0, 0}, side == 0 ? -1.3 : 1.3) * axis_angle({0, 0, 1}, 0.4 * sin(3 * t)) * axis_angle({0, 1, 0}, 0.1 * sin(5 * t));
    }
  }
  return m;
}

}  // namespace ugoki::body::testing
