#include "ugoki/studio/display_json.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "ugoki/base/base64.h"
#include "ugoki/mechanism/state.h"

namespace ugoki::studio {
namespace {

using Json = nlohmann::json;

template <class T>
std::string packed(const std::vector<T>& values) {
  return to_base64({reinterpret_cast<const std::uint8_t*>(values.data()), values.size() * sizeof(T)});
}

constexpr int max_preview_frames = 480;

/// Number of motion frames from one frame of a preview to the next.
int preview_stride(int frames) { return std::max(1, (frames + max_preview_frames - 1) / max_preview_frames); }

void add_number(std::vector<float>& out, double x) { out.push_back(static_cast<float>(x)); }

}  // namespace

std::string motion_json(std::string_view id, const Motion& motion, const Mechanism& mechanism) {
  const int stride = preview_stride(motion.frames);
  std::vector<float> poses;
  std::vector<Pose> X(static_cast<std::size_t>(mechanism.link_count()));
  int count = 0;
  for (int f = 0; f < motion.frames; f += stride, ++count) {
    calc_poses(mechanism, {motion.frame(f), static_cast<std::size_t>(motion.nq)}, X);
    for (const Pose& pose : X)
      for (const double x : pose_json(pose)) add_number(poses, x);
  }
  return Json{{"id", id},         {"name", motion.name},     {"rate", motion.rate},
              {"stride", stride}, {"frames", motion.frames}, {"duration", motion.duration()},
              {"count", count},   {"links", X.size()},       {"poses", packed(poses)}}
      .dump(-1, ' ', false, Json::error_handler_t::replace);
}

std::string markers_json(const MarkerMotion& markers) {
  const int stride = preview_stride(markers.frames);
  std::vector<float> points;
  int count = 0;
  for (int f = 0; f < markers.frames; f += stride, ++count)
    for (int i = 0; i < markers.marker_count(); ++i) {
      const bool seen = markers.seen(f, i);
      for (int k = 0; k < 3; ++k) add_number(points, seen ? markers.at(f, i)[k] : std::numeric_limits<double>::quiet_NaN());
    }
  return Json{{"labels", markers.labels}, {"stride", stride}, {"count", count}, {"points", packed(points)}}.dump(
      -1, ' ', false, Json::error_handler_t::replace);
}

std::vector<double> thumbnail_curve(const Motion& motion, const Mechanism& mechanism) {
  if (motion.frames < 2 || motion.nq != mechanism.nq()) return {};
  const int root = mechanism.link_count() > 0 ? mechanism.link(0).joint.nq() : 0;
  int best = -1;
  double max_variance = 1e-6;  // m^2 or rad^2; a coordinate that varies less does not move visibly
  for (int i = root < motion.nq ? root : 0; i < motion.nq; ++i) {
    double sum = 0, squares = 0;
    for (int f = 0; f < motion.frames; ++f) {
      const double q = motion.frame(f)[i];
      sum += q;
      squares += q * q;
    }
    const double variance = squares / motion.frames - sum / motion.frames * (sum / motion.frames);
    if (variance > max_variance) {
      max_variance = variance;
      best = i;
    }
  }
  if (best < 0) return {};
  const int count = std::min(48, motion.frames);
  std::vector<double> curve;
  for (int k = 0; k < count; ++k)
    curve.push_back(motion.frame(static_cast<int>(static_cast<long>(k) * (motion.frames - 1) / (count - 1)))[best]);
  const auto [low, high] = std::ranges::minmax(curve);
  for (double& value : curve) value = high > low ? std::round(1000 * (value - low) / (high - low)) / 1000 : 0.5;
  return curve;
}

}  // namespace ugoki::studio
