#include "ugoki/motion/missing_travel.h"

#include <algorithm>
#include <cmath>

#include "ugoki/motion/pass_through.h"

namespace ugoki {
namespace {

constexpr double leg_of_constants = 0.9;  // m: lengths scale with the leg, speeds with its square root (Froude)
constexpr double low = 0.03;              // m above its usual lowest height: a foot that is lower stands
constexpr double usual_share = 0.1;       // of the frames: in so many of them a foot is below its usual lowest height
constexpr double stance_share = 0.33;     // of the frames in which a foot is lowest: it stands for at least so long
constexpr double min_speed = 0.3;         // m/s: slower slides are drift, which contact detection tolerates
constexpr double common_share = 0.7;      // of the standing feet that must have at least half of the common velocity
constexpr double one_way = 0.75;          // of the sum of all slides that must be along their mean
constexpr double along = 0.33;            // of the slide: a body that moves with the feet by more than this glides
constexpr double follow_time = 0.1;       // s: time constant with which the body follows the standing feet
constexpr double min_distance = 0.4;      // of the leg: shorter slides are no steps
constexpr std::size_t min_samples = 10;

double quantile(std::vector<double> x, double share) {
  const auto place = x.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(x.size() - 1));
  std::nth_element(x.begin(), place, x.end());
  return *place;
}

/// A standing foot in one frame.
struct Sample {
  std::size_t frame;
  Vec3 velocity;  // m/s, horizontal
  double weight;
};

std::vector<Sample> standing_feet(std::span<const FootTrack> feet, double size) {
  std::vector<Sample> out;
  for (const FootTrack& foot : feet) {
    const double highest = std::max(quantile(foot.height, usual_share) + low * size, quantile(foot.height, stance_share));
    const double lowest = quantile(foot.height, 0);
    for (std::size_t f = 1; f + 1 < foot.height.size(); ++f) {
      if (foot.height[f] > highest) continue;
      const double above = (foot.height[f] - lowest) / (highest - lowest + 1e-9 * size);
      out.push_back({f, {foot.velocity[f].x, foot.velocity[f].y, 0}, (1 - above) * (1 - above)});
    }
  }
  return out;
}

/// Velocity [frames] of the standing feet, smoothed over `follow_time`.
std::vector<Vec3> smooth_velocity(const std::vector<Sample>& standing, std::size_t frames, double rate) {
  std::vector<double> x(frames), y(frames), weight(frames);
  for (const Sample& s : standing) {
    x[s.frame] += s.weight * s.velocity.x;
    y[s.frame] += s.weight * s.velocity.y;
    weight[s.frame] += s.weight;
  }
  for (std::size_t f = 0; f < frames; ++f) {
    if (!(weight[f] > 0)) continue;
    x[f] /= weight[f];
    y[f] /= weight[f];
    weight[f] = 1;
  }
  const double stiffness = follow_time * rate * follow_time * rate;
  x = pass_through(x, weight, stiffness);
  y = pass_through(y, weight, stiffness);
  std::vector<Vec3> out(frames);
  for (std::size_t f = 0; f < frames; ++f) out[f] = {x[f], y[f], 0};
  return out;
}

}  // namespace

FootTrack foot_track(std::span<const Vec3> points, double rate) {
  FootTrack out;
  const std::size_t span = std::max<std::size_t>(1, static_cast<std::size_t>(0.03 * rate));
  for (std::size_t f = 0; f < points.size(); ++f) {
    const std::size_t before = f - std::min(f, span), after = std::min(points.size() - 1, f + span);
    out.height.push_back(points[f].z);
    out.velocity.push_back((points[after] - points[before]) * (rate / static_cast<double>(std::max<std::size_t>(1, after - before))));
  }
  return out;
}

MissingTravel find_missing_travel(std::span<const FootTrack> feet, std::span<const Vec3> body, double rate, double leg) {
  const std::size_t n = body.size();
  if (feet.empty() || n < min_samples || !(leg > 0) || !(rate > 0)) return {};
  const double size = leg / leg_of_constants;
  const std::vector<Sample> standing = standing_feet(feet, size);
  if (standing.size() < min_samples) return {};
  std::vector<double> vx, vy;
  Vec3 sum;
  double path = 0;
  for (const Sample& s : standing) {
    vx.push_back(s.velocity.x);
    vy.push_back(s.velocity.y);
    sum += s.velocity;
    path += norm(s.velocity);
  }
  const double count = static_cast<double>(standing.size());
  const Vec3 common{quantile(vx, 0.5), quantile(vy, 0.5), 0};
  const auto share = [&](auto&& holds) { return static_cast<double>(std::ranges::count_if(standing, holds)) / count; };
  const double speed = norm(common);
  const double limit = min_speed * std::sqrt(size);
  const bool one_direction = norm(sum) >= one_way * path;
  const bool alike =
      speed >= limit && share([&](const Sample& s) { return dot(s.velocity, common) > 0.5 * speed * speed; }) >= common_share;
  if (!alike && !(one_direction && norm(sum) >= limit * count)) return {};
  MissingTravel out;
  out.steady = alike;
  const Vec3 slide = alike ? common : sum / count;
  const Vec3 moved = body[n - 1] - body[0];
  const double duration = static_cast<double>(n - 1) / rate;
  if (norm(slide) * duration < min_distance * leg) return {};
  if (dot(Vec3{moved.x, moved.y, 0}, slide) > along * dot(slide, slide) * duration) return {};
  out.velocity = slide * -1;
  const std::vector<Vec3> velocity = alike ? std::vector<Vec3>(n, slide) : smooth_velocity(standing, n, rate);
  out.shift.resize(n);
  for (std::size_t f = 1; f < n; ++f) out.shift[f] = out.shift[f - 1] - (velocity[f - 1] + velocity[f]) * (0.5 / rate);
  return out;
}

}  // namespace ugoki
