#include "ugoki/correction/centre_path.h"

#include <algorithm>
#include <cmath>

#include "ugoki/motion/band.h"

namespace ugoki::correction {
namespace {

constexpr double time_unit = 0.1;       // s: an acceleration a counts as the distance a time_unit^2, as for a centre of mass 1 m high
constexpr double flight_weight = 85;    // relative to the distance of the centre of pressure from the soles
constexpr double max_shift = 0.15;      // m over the ground: a motion that needs more is not balanced by moving its root
constexpr double shift_weight = 10;     // of the distance beyond max_shift
constexpr double pull_weight = 0.2;     // of the displacement itself
constexpr double smooth_weight = 0.01;  // of its acceleration
constexpr double inside = 0.85;         // the centre of pressure is kept in the soles shrunk by this factor
constexpr double min_load = 0.15;       // fraction of the weight with which the ground must push in contact
constexpr double max_load = 2.75;       // the same, at most; captured runs and jumps have 2.4 to 3.1, filtered
constexpr double max_walk_load = 1.4;   // the same in walks, which have 1.2 to 1.5
constexpr double calm_weight = 0.005;   // of the vertical acceleration in a walk, which halves its oscillations of 4 Hz
constexpr double around_flight = 0.4;   // s: before and after flights and contacts of other links than feet, a motion is no walk
constexpr double reach_weight = 1000;   // of a height in contact that the legs do not reach
constexpr double trunk_weight = 1000;   // of the depth of the trunk, knees and other links that are no limbs with contacts in the floor
constexpr int rounds = 60;
constexpr double min_warp = 0.15;         // relative error of gravity above which a flight is retimed; captured flights have up to 10 %
constexpr double min_warp_flight = 0.15;  // s: the acceleration of shorter flights is not accurate
constexpr double warp_ease = 0.25;        // s

std::size_t at(int i) { return static_cast<std::size_t>(i); }

/// A flight without the frames at its ends in which the ground still pushes.
Flight free_part(const Observation& o, Flight flight, double gravity) {
  const int margin = std::max(1, static_cast<int>(0.04 * o.rate));
  const auto pushed = [&](int f) { return o.acceleration[at(f)].z > -0.5 * gravity; };
  for (int i = 0; i < margin && flight.frames() > 2 && pushed(flight.first); ++i) ++flight.first;
  for (int i = 0; i < margin && flight.frames() > 2 && pushed(flight.last); ++i) --flight.last;
  return flight;
}

/// Convex hull in the plane, counterclockwise (Andrew's monotone chain).
std::vector<Vec3> hull_of(std::vector<Vec3> points) {
  if (points.empty()) return {};
  std::ranges::sort(points, [](const Vec3& a, const Vec3& b) { return a.x != b.x ? a.x < b.x : a.y < b.y; });
  std::vector<Vec3> hull;
  for (int side = 0; side < 2; ++side) {
    const std::size_t base = hull.size();
    for (const Vec3& p : points) {
      while (hull.size() >= base + 2) {
        const Vec3 &a = hull[hull.size() - 2], &b = hull.back();
        if ((b.x - a.x) * (p.y - a.y) - (b.y - a.y) * (p.x - a.x) > 0) break;
        hull.pop_back();
      }
      hull.push_back(p);
    }
    hull.pop_back();
    std::ranges::reverse(points);
  }
  if (hull.empty() && !points.empty()) hull.push_back(points.front());
  return hull;
}

/// Point of the polygon that is closest to p, in the plane.
Vec3 closest(const std::vector<Vec3>& hull, const Vec3& p) {
  bool is_inside = hull.size() > 2;
  double best = 1e300;
  Vec3 out = p;
  for (std::size_t i = 0; i < hull.size(); ++i) {
    const Vec3 &a = hull[i], &b = hull[(i + 1) % hull.size()];
    const double dx = b.x - a.x, dy = b.y - a.y, length = dx * dx + dy * dy;
    if (dx * (p.y - a.y) - dy * (p.x - a.x) < 0) is_inside = false;
    const double t = length > 0 ? std::clamp(((p.x - a.x) * dx + (p.y - a.y) * dy) / length, 0.0, 1.0) : 0;
    const Vec3 c{a.x + t * dx, a.y + t * dy, 0};
    const double d = (c.x - p.x) * (c.x - p.x) + (c.y - p.y) * (c.y - p.y);
    if (d < best) {
      best = d;
      out = c;
    }
  }
  return is_inside ? Vec3{p.x, p.y, 0} : out;
}

/// What one frame demands.
struct Frame {
  bool flies = false;
  bool calm = true;        // a walk or a slower motion on the feet
  double lever = 0;        // s^2: the centre of pressure moves by -lever times the acceleration of the centre of mass
  Vec3 pressure;           // m: centre of pressure of the unchanged motion
  std::vector<Vec3> sole;  // shrunk polygon
};

std::vector<Frame> make_frames(const Observation& o, double gravity) {
  std::vector<Frame> frames(at(o.frames()));
  for (const Flight& flight : o.flights)
    for (int f = 0; f < o.frames(); ++f) {
      const int away = std::max({0, flight.first - f, f - flight.last});
      if (away == 0) frames[at(f)].flies = true;
      if (away < around_flight * o.rate) frames[at(f)].calm = false;
    }
  for (int f = 0; f < o.frames(); ++f) {
    const int reach = static_cast<int>(around_flight * o.rate);
    if (o.on_feet[at(f)]) continue;
    for (int k = std::max(0, f - reach); k <= std::min(o.frames() - 1, f + reach); ++k) frames[at(k)].calm = false;
  }
  for (int f = 0; f < o.frames(); ++f) {
    Frame& frame = frames[at(f)];
    if (frame.flies) continue;
    const Vec3 &c = o.centre[at(f)], &a = o.acceleration[at(f)], &moment = o.moment[at(f)];
    const double up = std::max(a.z + gravity, 0.3 * gravity);
    frame.lever = std::max(c.z, 0.1) / up;
    frame.pressure = {c.x - frame.lever * a.x - moment.y / (o.mass * up), c.y - frame.lever * a.y + moment.x / (o.mass * up), 0};
    int near = f;  // frames without detected contact before a take-off or after a landing: the closest frame with contact
    for (int d = 0; d < o.frames() && o.supports[at(near)].empty(); ++d) {
      if (f - d >= 0 && !o.supports[at(f - d)].empty())
        near = f - d;
      else if (f + d < o.frames() && !o.supports[at(f + d)].empty())
        near = f + d;
    }
    frame.sole = hull_of(o.supports[at(near)]);
    Vec3 middle;
    for (const Vec3& p : frame.sole) middle += p / static_cast<double>(frame.sole.size());
    for (Vec3& p : frame.sole) p = middle + (p - middle) * inside;
  }
  return frames;
}

}  // namespace

std::vector<Vec3> find_centre_displacement(const Observation& o, double gravity, const std::vector<double>& headroom) {
  const std::size_t n = o.centre.size();
  const std::vector<Frame> frames = make_frames(o, gravity);
  const double r2 = o.rate * o.rate, unit = time_unit * time_unit;
  std::vector<Vec3> u(n);
  for (int round = 0; round < rounds; ++round) {
    BandLeastSquares terms[3] = {BandLeastSquares(n), BandLeastSquares(n), BandLeastSquares(n)};
    for (std::size_t f = 0; f < n; ++f) {
      for (BandLeastSquares& t : terms) t.add(f, 0, pull_weight * (frames[f].flies ? 0.01 : 1.0));
      if (const double way = std::sqrt(u[f].x * u[f].x + u[f].y * u[f].y); way > max_shift)
        for (int k = 0; k < 2; ++k) terms[k].add(f, u[f][k] * (max_shift / way), shift_weight);
      if (u[f].z < -o.trunk_clearance[f]) terms[2].add(f, -o.trunk_clearance[f], trunk_weight);
    }
    for (std::size_t f = 1; f + 1 < n; ++f) {
      const Frame& frame = frames[f];
      const Vec3 bend = (u[f - 1] - u[f] * 2 + u[f + 1]) * r2;
      const std::array<double, 3> second{unit * r2, -2 * unit * r2, unit * r2};
      if (frame.flies) {
        for (int k = 0; k < 3; ++k) terms[k].add(f - 1, second, unit * ((k == 2 ? -gravity : 0.0) - o.acceleration[f][k]), flight_weight);
        continue;
      }
      for (BandLeastSquares& t : terms) t.add(f - 1, second, 0, smooth_weight);
      if (u[f].z > headroom[f]) terms[2].add(f, headroom[f], reach_weight);
      const double load = o.acceleration[f].z + bend.z + gravity;
      if (load < min_load * gravity) terms[2].add(f - 1, second, unit * ((min_load - 1) * gravity - o.acceleration[f].z), 1);
      if (frame.calm) terms[2].add(f - 1, second, -unit * o.acceleration[f].z, calm_weight);
      const double max_now = frame.calm ? max_walk_load : max_load;
      if (load > max_now * gravity) terms[2].add(f - 1, second, unit * ((max_now - 1) * gravity - o.acceleration[f].z), 1);
      if (frame.sole.empty()) continue;
      const Vec3 pressure = frame.pressure + u[f] - bend * frame.lever;
      const Vec3 goal = closest(frame.sole, pressure);
      const double b = frame.lever * r2;
      for (int k = 0; k < 2; ++k) terms[k].add(f - 1, {-b, 1 + 2 * b, -b}, goal[k] - frame.pressure[k], 1);
    }
    for (int k = 0; k < 3; ++k) {
      const std::vector<double> x = terms[k].solve();
      for (std::size_t f = 0; f < n; ++f) u[f][k] = x[f];
    }
  }
  return u;
}

std::vector<double> find_flight_times(const Observation& o, double gravity, double strength) {
  const int n = o.frames();
  std::vector<double> factor(at(n), 1.0);
  for (const Flight& flight : o.flights) {
    const Flight free = free_part(o, flight, gravity);
    if (free.frames() < min_warp_flight * o.rate) continue;
    double sum = 0;  // least-squares parabola = mean of the second differences weighted by the parabola through the ends
    double weight = 0;
    for (int f = free.first + 1; f < free.last; ++f) {
      const double w = (f - free.first) * static_cast<double>(free.last - f);
      sum += w * w * o.acceleration[at(f)].z;
      weight += w * w;
    }
    const double ratio = -sum / (weight * gravity);
    if (!(ratio > 0.2 && ratio < 5) || std::fabs(ratio - 1) < min_warp) continue;
    const double change = strength * (std::sqrt(ratio) - 1);
    for (int f = 0; f < n; ++f) {
      const double away = std::max({0, flight.first - f, f - flight.last}) / (warp_ease * o.rate), s = std::max(0.0, 1 - away);
      const double own = 1 + change * s * s * (3 - 2 * s);
      if (std::fabs(own - 1) > std::fabs(factor[at(f)] - 1)) factor[at(f)] = own;
    }
  }
  std::vector<double> times(at(n), 0.0);
  for (int f = 1; f < n; ++f) times[at(f)] = times[at(f - 1)] + 0.5 * (factor[at(f - 1)] + factor[at(f)]) / o.rate;
  return times;
}

}  // namespace ugoki::correction
