#include "ugoki/body/floor.h"

#include <algorithm>

#include "ugoki/motion/missing_travel.h"

namespace ugoki::body {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

/// Upper median; `values` must not be empty.
double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}
double percentile(std::vector<double> values, double share) {
  const auto position = values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), position, values.end());
  return *position;
}

/// World trajectory of one foot, [frames].
struct Track {
  std::vector<Vec3> ankle, ball;  ///< m
  std::vector<Mat3> R_foot, R_toes;
  std::vector<double> speed;  ///< m/s, maximum of ankle and ball
};

/// Gives a character that walks in place the travel of its steps: its standing feet are as fast as the belt of a treadmill, and slow where
/// they turn back in the air. @param root [frames] m
void add_missing_travel(std::span<const Vec3> root, double rate, double height, std::vector<Track>& tracks) {
  std::vector<FootTrack> feet;
  for (const Track& t : tracks) feet.push_back(foot_track(t.ball, rate));
  const MissingTravel travel = find_missing_travel(feet, root, rate, 0.5 * height);
  if (!travel.exists()) return;
  for (Track& t : tracks)
    for (std::size_t f = 0; f < root.size(); ++f) {
      t.ankle[f] += travel.shift[f];
      t.ball[f] += travel.shift[f];
    }
}

/// @param height m, of the person
std::vector<Track> track_feet(const MeasuredMotion& m, std::span<const Sole> soles, double height) {
  std::vector<Track> tracks(soles.size());
  std::vector<Vec3> root;
  std::vector<Pose> X;
  for (int f = 0; f < m.frames; ++f) {
    m.calc_joint_poses(f, X);
    root.push_back(X[0].p);
    for (std::size_t s = 0; s < soles.size(); ++s) {
      const Pose& foot = X[at(soles[s].foot)];
      tracks[s].ankle.push_back(foot.p);
      tracks[s].ball.push_back(foot * soles[s].ball);
      tracks[s].R_foot.push_back(foot.R);
      tracks[s].R_toes.push_back(soles[s].toes >= 0 ? X[at(soles[s].toes)].R : foot.R);
    }
  }
  add_missing_travel(root, m.rate, height, tracks);
  for (Track& t : tracks) {
    for (int f = 0; f < m.frames; ++f) {
      const int a = std::max(0, f - 1), b = std::min(m.frames - 1, f + 1);
      const double dt = std::max(1, b - a) / m.rate;
      t.speed.push_back(std::max(norm(t.ankle[at(b)] - t.ankle[at(a)]), norm(t.ball[at(b)] - t.ball[at(a)])) / dt);
    }
  }
  return tracks;
}

/// Slope of the floor (dz/dx, dz/dy, 0) by least squares through the balls' stance positions, along their two principal directions. A
/// direction gets slope zero if the stances span less than 1 m, or if the slope exceeds 0.035 (2 degrees). It also gets slope zero if the
/// line does not reduce the rms error by a quarter, or leaves an rms error above 12 mm.
Vec3 find_slope(const std::vector<Track>& tracks, const std::vector<Stance>& stances) {
  struct Sample {
    double x, y, z;
  };
  std::vector<Sample> samples;  // relative to each foot's own mean, because soles differ in thickness
  for (std::size_t s = 0; s < tracks.size(); ++s) {
    Vec3 mean{};
    for (const int f : stances[s].frames) mean += tracks[s].ball[at(f)];
    if (stances[s].frames.empty()) continue;
    mean = mean / static_cast<double>(stances[s].frames.size());
    for (const int f : stances[s].frames) {
      const Vec3 d = tracks[s].ball[at(f)] - mean;
      samples.push_back({d.x, d.y, d.z});
    }
  }
  if (samples.size() < 20) return {};
  double xx = 0, xy = 0, yy = 0;
  for (const Sample& a : samples) {
    xx += a.x * a.x;
    xy += a.x * a.y;
    yy += a.y * a.y;
  }
  const double angle = 0.5 * atan2(2 * xy, xx - yy);
  const SinCos sc = sin_cos(angle);
  Vec3 slope{};
  for (const Vec3 u : {Vec3{sc.cos, sc.sin, 0}, Vec3{-sc.sin, sc.cos, 0}}) {
    double low = 0, high = 0, uu = 0, uz = 0, zz = 0;
    for (const Sample& a : samples) {
      const double along = a.x * u.x + a.y * u.y, z = a.z - dot(slope, Vec3{a.x, a.y, 0});
      low = std::min(low, along);
      high = std::max(high, along);
      uu += along * along;
      uz += along * z;
      zz += z * z;
    }
    if (high - low < 1.0) continue;  // too short a span to determine a slope
    const double rise = uz / uu;
    const double left = std::sqrt(std::max(0.0, zz - rise * uz) / static_cast<double>(samples.size()));
    const double before = std::sqrt(zz / static_cast<double>(samples.size()));
    if (left < 0.75 * before && left < 0.012 && std::fabs(rise) < 0.035) slope += u * rise;
  }
  return slope;
}

/// Expresses the world direction `up` in the axes R[f] of each motion frame f of `frames`, and returns the normalized componentwise median.
Vec3 median_direction(const std::vector<Mat3>& R, const std::vector<int>& frames, const Vec3& up) {
  std::vector<double> x, y, z;
  for (const int f : frames) {
    const Vec3 u = transpose_times(R[at(f)], up);
    x.push_back(u.x);
    y.push_back(u.y);
    z.push_back(u.z);
  }
  return normalized(Vec3{median(x), median(y), median(z)});
}

/// Handles walking on the spot (treadmill, game loop): stance feet slide there, and feet are slow only at the reversal in the air.
/// Feet then go below the floor found from slow feet, so the frames with the lowest feet become the stances. A runner's foot stands for a
/// quarter of a stride; toes of hand-animated characters that sink into the floor while the heel leaves it are below for a shorter time.
/// @return true if this case was detected and `stances` was replaced
bool stand_where_lowest(const std::vector<Track>& tracks, double scale, std::vector<Stance>& stances) {
  constexpr double shortest = 0.2;  // share of the stride
  std::vector<double> slow, all;
  for (std::size_t s = 0; s < tracks.size(); ++s) {
    for (const int f : stances[s].frames) slow.push_back(tracks[s].ball[at(f)].z);
    for (const Vec3& p : tracks[s].ball) all.push_back(p.z);
  }
  const double lowest = percentile(all, 0.02);
  const double floor = percentile(slow, 0.1);
  if (floor < lowest + 0.08 * scale || percentile(all, shortest) > floor - 0.04 * scale) return false;
  for (std::size_t s = 0; s < tracks.size(); ++s) {
    stances[s].frames.clear();
    for (std::size_t f = 0; f < tracks[s].ball.size(); ++f)
      if (tracks[s].ball[f].z < lowest + 0.04 * scale) stances[s].frames.push_back(static_cast<int>(f));
  }
  return true;
}

/// Removes stances in which the ball is far below its level while the foot is flat. The large feet of cartoon characters sink with the toes
/// while the heel leaves the floor.
void remove_sunken(const Track& track, double scale, std::vector<int>& frames) {
  constexpr double pitch = 0.25;  // sine of the angle by which a foot that is not flat is pitched
  std::vector<double> rise;       // m, of the ankle above the ball
  for (const int f : frames) rise.push_back(track.ankle[at(f)].z - track.ball[at(f)].z);
  if (rise.empty()) return;
  const double flat = percentile(rise, 0.1) + pitch * norm(track.ankle[0] - track.ball[0]);
  std::vector<double> level;
  for (std::size_t k = 0; k < frames.size(); ++k)
    if (rise[k] < flat) level.push_back(track.ball[at(frames[k])].z);
  if (level.size() < 4) return;
  const double lowest = median(level) - 0.04 * scale;
  std::erase_if(frames, [&](int f) {
    const Vec3 ankle = track.ankle[at(f)], ball = track.ball[at(f)];
    return ball.z < lowest && ankle.z - ball.z >= flat;
  });
}

}  // namespace

FloorFit fit_floor(const MeasuredMotion& m, std::span<const Sole> soles, double height) {
  FloorFit fit;
  fit.stances.resize(soles.size());
  if (soles.empty() || m.frames < 1) return fit;
  const std::vector<Track> tracks = track_feet(m, soles, height);
  const double scale = height / 1.7;
  // Raise the speed limit (m/s, for a person of 1.7 m) until at least 4 frames and 2 % of the frames qualify.
  std::size_t found = 0;
  for (const double limit : {0.2, 0.4, 0.8}) {
    found = 0;
    for (std::size_t s = 0; s < soles.size(); ++s) {
      fit.stances[s].frames.clear();
      for (int f = 0; f < m.frames; ++f)
        if (tracks[s].speed[at(f)] < limit * scale) fit.stances[s].frames.push_back(f);
      found += fit.stances[s].frames.size();
    }
    if (found >= std::max<std::size_t>(4, static_cast<std::size_t>(m.frames) / 50)) break;
  }
  if (found == 0) return fit;
  fit.found = true;
  for (std::size_t s = 0; s < soles.size(); ++s) remove_sunken(tracks[s], scale, fit.stances[s].frames);
  const bool on_the_spot = stand_where_lowest(tracks, scale, fit.stances);
  const Vec3 slope = on_the_spot ? Vec3{} : find_slope(tracks, fit.stances);
  const Vec3 up = normalized(Vec3{-slope.x, -slope.y, 1});
  fit.R_level = to_matrix(rotation_between(up, {0, 0, 1}));
  fit.tilt = acos(up.z);
  // Keep stances within 4 cm of the lowest ones: feet on stairs or boxes are not on the floor.
  std::vector<double> heights;
  for (std::size_t s = 0; s < soles.size(); ++s)
    for (const int f : fit.stances[s].frames) heights.push_back(dot(up, tracks[s].ball[at(f)]));
  const double ceiling = percentile(heights, 0.1) + 0.04 * scale;
  for (std::size_t s = 0; s < soles.size(); ++s) {
    Stance& stance = fit.stances[s];
    std::erase_if(stance.frames, [&](int f) { return dot(up, tracks[s].ball[at(f)]) > ceiling; });
    if (stance.frames.empty()) continue;
    std::vector<double> z;
    z.reserve(stance.frames.size());
    for (const int f : stance.frames) z.push_back(dot(up, tracks[s].ball[at(f)]));
    stance.ball_height = median(z);
    stance.foot_up = median_direction(tracks[s].R_foot, stance.frames, up);
    stance.toes_up = median_direction(tracks[s].R_toes, stance.frames, up);
  }
  return fit;
}

}  // namespace ugoki::body
