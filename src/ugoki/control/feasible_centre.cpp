#include "ugoki/control/feasible_centre.h"

#include <algorithm>
#include <cmath>

#include "ugoki/control/balance_model.h"
#include "ugoki/control/support_area.h"
#include "ugoki/dynamics/centroidal.h"

namespace ugoki::control {
namespace {

std::size_t idx(int i) { return static_cast<std::size_t>(i); }

constexpr double min_thrust = 0.2;  // body weights: with less ground force, the place of the pressure is not known

/// Appends the corners of the area in which a standing foot of the reference has its centre of pressure, in the horizontal plane.
void add_support(const dynamics::Workspace& ws, const Foot& foot, const BalanceOptions& options, std::vector<Vec3>& area) {
  double slowest = 1e9;
  const auto place = [&](const LinkPoint& point) { return ws.X_WB[idx(point.link)] * point.location.p; };
  for (const LinkPoint& point : foot.points) slowest = std::min(slowest, dynamics::point_velocity(ws, point.link, place(point)).z);
  const std::size_t first = area.size();
  Vec3 middle;
  for (const LinkPoint& point : foot.points) {
    if (dynamics::point_velocity(ws, point.link, place(point)).z > slowest + options.lifting) continue;
    area.push_back(horizontal(place(point)));
    middle += area.back();
  }
  middle = middle / static_cast<double>(std::max<std::size_t>(1, area.size() - first));
  for (std::size_t k = first; k < area.size(); ++k) area[k] = middle + (area[k] - middle) * options.sole_share;
}

}  // namespace

FeasibleCentre::FeasibleCentre(const Mechanism& m, std::span<const Foot> feet, const FootSchedule& schedule, const ReferenceMotion& motion,
                               const BalanceOptions& options, double floor, double rate)
    : rate_(rate) {
  const double gravity = norm(options.gravity);
  const int frames = std::max(1, static_cast<int>(std::floor(motion.end() * rate))) + 1;
  std::vector<double> q(idx(m.nq())), v(idx(m.nv())), a(v.size());
  std::vector<double> stiffness(idx(frames));  // w^2
  std::vector<Vec3> missing(idx(frames));      // s - p
  std::vector<Vec3> area;
  dynamics::Workspace ws(m);
  for (int f = 0; f < frames; ++f) {
    const double t = f / rate;
    area.clear();
    motion.sample(std::min(t, motion.end()), q, v, a);
    dynamics::update_kinematics(m, q, v, ws);
    for (std::size_t k = 0; k < feet.size(); ++k)
      if (schedule.at(k, t).stands) add_support(ws, feet[k], options, area);
    if (area.empty()) continue;
    const dynamics::Centroidal c = dynamics::calc_centroidal(m, ws);
    const Vec6 force = dynamics::calc_centroidal_momentum_rate(m, ws, a);  // without the weight
    const double load = std::max(min_thrust * gravity, gravity + force.v.z / c.mass), height = std::max(0.05, c.centre.z - floor);
    const Vec3 moment = Vec3{force.w.y, -force.w.x, 0} / c.mass;
    const Vec3 pressure = horizontal(c.centre) - (horizontal(force.v) * (height / c.mass) + moment) / load;
    Vec3 closest;
    distance_to_edge(area, pressure, closest);
    stiffness[idx(f)] = load / height;
    missing[idx(f)] = closest - pressure;
    const double distance = norm(missing[idx(f)]), reach = options.pressure_reach * height;
    if (distance > reach) missing[idx(f)] = missing[idx(f)] * (reach / distance);
  }
  // (d_{k-1} - 2 d_k + d_{k+1}) rate^2 - w_k^2 d_k = -w_k^2 missing_k, d_0 = 0, d_n = d_{n-1}. Thomas algorithm.
  position_.assign(idx(frames), {});
  acceleration_.assign(idx(frames), {});
  std::vector<double> upper(idx(frames));
  const double r2 = rate * rate;
  for (int f = 1; f + 1 < frames; ++f) {
    const double diagonal = 2 * r2 + stiffness[idx(f)] - r2 * upper[idx(f - 1)] - (f + 2 == frames ? r2 : 0);
    upper[idx(f)] = r2 / diagonal;
    position_[idx(f)] = (missing[idx(f)] * stiffness[idx(f)] + position_[idx(f - 1)] * r2) / diagonal;
  }
  for (int f = frames - 3; f > 0; --f) position_[idx(f)] += position_[idx(f + 1)] * upper[idx(f)];
  if (frames > 1) position_[idx(frames - 1)] = position_[idx(frames - 2)];
  for (int f = 0; f < frames; ++f) acceleration_[idx(f)] = (position_[idx(f)] - missing[idx(f)]) * stiffness[idx(f)];
}

FeasibleCentre::Shift FeasibleCentre::at(double t) const {
  const double last = static_cast<double>(position_.size() - 1);
  const double frame = t * rate_;
  if (!(frame >= 0) || frame >= last) return {frame >= last ? position_.back() : Vec3{}, {}, {}};
  const auto k = static_cast<std::size_t>(frame);
  const double s = frame - static_cast<double>(k);
  const auto mean = [&](const std::vector<Vec3>& x) { return x[k] * (1 - s) + x[k + 1] * s; };
  return {mean(position_), (position_[k + 1] - position_[k]) * rate_, mean(acceleration_)};
}

}  // namespace ugoki::control
