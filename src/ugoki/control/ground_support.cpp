#include "ugoki/control/ground_support.h"

#include <algorithm>

namespace ugoki::control {
namespace {
std::size_t at(int i) { return static_cast<std::size_t>(i); }
}  // namespace

GroundSupport::GroundSupport(const BalanceModel& model) : touching_(model.feet.size()) {
  bearing_.reserve(max_bearing);
  hull_.reserve(4 * max_bearing);
}

void GroundSupport::count_contacts(const BalanceModel& model, const BalanceInput& in) {
  std::ranges::fill(touching_, 0);
  for (const collision::ContactPoint& c : in.contacts)
    if (c.system_a == in.system && c.system_b < 0 && c.distance <= model.options.touch && model.part_of[at(c.link_a)] >= 0)
      ++touching_[at(model.part_of[at(c.link_a)])];
}

void GroundSupport::find_bearing(const BalanceModel& model, const BalanceInput& in, const BalanceState& state) {
  bearing_.clear();
  for (const collision::ContactPoint& c : in.contacts) {
    if (c.system_a != in.system || c.system_b >= 0 || bearing_.size() == max_bearing) continue;
    const int foot = model.part_of[at(c.link_a)];
    if (foot < 0 || !state.feet[foot].stands) continue;
    if (c.distance > model.options.touch) continue;
    const Vec3 p_ref = model.ref.X_WB[at(c.link_a)] * (model.now.X_WB[at(c.link_a)].inverse() * c.p);
    const double rise = dot(c.n, dynamics::point_velocity(model.ref, c.link_a, p_ref)) / state.rate;
    bearing_.push_back({foot, c.link_a, c.p, c.n, c.friction, dot(c.n, p_ref), rise});
  }
  for (std::size_t f = 0; f < model.feet.size(); ++f) {
    double slowest = 1e9, lowest = 1e9;
    for (const BearingPoint& b : bearing_) {
      if (b.foot != static_cast<int>(f)) continue;
      slowest = std::min(slowest, b.rise);
      lowest = std::min(lowest, b.height);
    }
    std::erase_if(bearing_, [&](const BearingPoint& b) {
      return b.foot == static_cast<int>(f) &&
             (b.rise > slowest + model.options.lifting || (b.height > lowest + model.options.lifted && b.rise > slowest + 0.02));
    });
  }
}

double GroundSupport::distance_to_edge(const BalanceModel& model, int foot, const BalanceInput& in, const BalanceState& state,
                                       const Vec3& p, Vec3& closest) {
  hull_.clear();
  for (const collision::ContactPoint& c : in.contacts) {
    if (c.system_a != in.system || c.system_b >= 0 || c.distance > 0.01 || hull_.size() == max_bearing) continue;
    const int f = model.part_of[at(c.link_a)];
    if (f < 0 || !state.feet[f].stands || (foot >= 0 && f != foot)) continue;
    hull_.push_back(horizontal(c.p));
  }
  closest = p;
  if (hull_.empty()) return -1e3;
  // Convex hull by the monotone chain (Andrew 1979), counter-clockwise, stored in hull_ after the points.
  std::sort(hull_.begin(), hull_.end(), [](const Vec3& a, const Vec3& b) { return a.x != b.x ? a.x < b.x : a.y < b.y; });
  const std::size_t n = hull_.size();
  const auto turn = [](const Vec3& o, const Vec3& a, const Vec3& b) { return (a.x - o.x) * (b.y - o.y) - (a.y - o.y) * (b.x - o.x); };
  for (int pass = 0; pass < 2; ++pass) {
    const std::size_t start = hull_.size();
    for (std::size_t k = 0; k < n; ++k) {
      const Vec3 q = hull_[pass == 0 ? k : n - 1 - k];
      while (hull_.size() >= start + 2 && turn(hull_[hull_.size() - 2], hull_.back(), q) <= 0) hull_.pop_back();
      hull_.push_back(q);
    }
    hull_.pop_back();
  }
  const std::size_t corners = hull_.size() - n;
  double inside = 1e3, best = 1e300;
  const Vec3 flat = horizontal(p);
  for (std::size_t k = 0; k < std::max<std::size_t>(1, corners); ++k) {
    const Vec3 a = corners ? hull_[n + k] : hull_[0], b = corners ? hull_[n + (k + 1) % corners] : hull_[0];
    const Vec3 edge = b - a;
    const double length = norm(edge);
    const double s = length > 0 ? std::clamp(dot(flat - a, edge) / (length * length), 0.0, 1.0) : 0;
    const Vec3 q = a + edge * s;
    if (norm(flat - q) < best) {
      best = norm(flat - q);
      closest = q;
    }
    inside = std::min(inside, length > 0 ? turn(a, b, flat) / length : -best);
  }
  if (corners < 3 || inside < 0) return -best;
  closest = flat;
  return inside;
}

}  // namespace ugoki::control
