#include "ugoki/control/ground_support.h"

#include <algorithm>
#include <cmath>

#include "ugoki/control/support_area.h"
#include "ugoki/spatial/elementary.h"

namespace ugoki::control {
namespace {
std::size_t at(int i) { return static_cast<std::size_t>(i); }
}  // namespace

double unevenness(const BalanceModel& model, const BalanceState& state) {
  constexpr double level = 0.005, uneven = 0.02;  // m: rises and humps of steps that count as level, and fully as uneven
  double share = norm(Vec3{state.tilt[0], state.tilt[1], 0}) / model.options.pace_slope;
  for (std::size_t f = 0; f < model.feet.size(); ++f) {
    const BalanceState::FootState& foot = state.feet[f];
    share = std::max(share, (std::fabs(foot.to[2] - foot.from[2]) + foot.bump - level) / (uneven - level));
  }
  return share < 1e-6 ? 0 : std::min(share, 1.0);
}

GroundSupport::GroundSupport(const BalanceModel& model) : touching_(model.feet.size()), blocked_(model.feet.size()) {
  contacts_.reserve(max_bearing);
  bearing_.reserve(max_bearing);
  std::size_t points = 0;
  for (const Foot& foot : model.feet) points += foot.points.size();
  hovering_.reserve(points);
  hull_.reserve(4 * max_bearing);
}

void GroundSupport::collect(const BalanceModel& model, const BalanceInput& in) {
  contacts_.clear();
  std::ranges::fill(touching_, 0);
  std::ranges::fill(blocked_, 0);
  for (const collision::ContactPoint& c : in.contacts) {
    const bool is_a = c.system_a == in.system;
    if (is_a ? c.system_b == in.system : c.system_b != in.system) continue;
    const int link = is_a ? c.link_a : c.link_b, foot = model.part_of[at(link)];
    const Vec3 n = is_a ? c.n : -c.n;
    if (foot >= 0 && c.distance <= model.options.touch) blocked_[at(foot)] = 1;
    if (foot < 0 || n.z < min_rise || contacts_.size() == max_bearing) continue;
    const bool loose = is_a ? !model.map.contains(c.system_b, c.link_b) : !model.map.contains(c.system_a, c.link_a);
    contacts_.push_back({foot, link, c.p, n, c.friction, c.distance, loose});
    if (c.distance <= model.options.touch) ++touching_[at(foot)];
  }
}

void GroundSupport::find_bearing(const BalanceModel& model, const BalanceState& state, const Vec3& pressure) {
  bearing_.clear();
  hovering_.clear();
  for (const FootContact& c : contacts_) {
    if (!state.feet[c.foot].stands || c.distance > model.options.touch) continue;
    const auto link = at(c.link);
    const Vec3 p_ref = model.ref.X_WB[link] * (model.now.X_WB[link].inverse() * c.p);
    const double rise = dynamics::point_velocity(model.ref, c.link, p_ref).z / state.rate;
    bearing_.push_back({c.foot, c.link, c.p, c.n, c.friction, p_ref.z, rise, {}});
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
    if (model.schedule.turns(f, state.time))
      find_turn(model, f);
    else if (state.feet[f].stands)
      find_hovering(model, state, pressure, f);
  }
}

bool GroundSupport::tips_about(const BalanceModel& model, std::size_t f, const Vec3& axis, double cosine) {
  for (int link = model.feet[f].link; link > 0; link = model.mechanism->link(link).parent) {
    const Link& l = model.mechanism->link(link);
    for (int k = 0; k < l.joint.nv(); ++k)
      if (std::fabs(dot(axis, normalized(model.now.S[at(l.v_index + k)].w))) > cosine) return true;
    if (l.joint.nv() > 0) break;
  }
  return false;
}

void GroundSupport::find_hovering(const BalanceModel& model, const BalanceState& state, const Vec3& pressure, std::size_t f) {
  const BalanceOptions& o = model.options;
  constexpr double edge = 0.01;   // m: bearing points that are this close to the edge stay
  constexpr double level = 3e-3;  // m: on ground that is level within this height, soles keep the tilt of the reference
  // A sole whose heel hovers bears load at the toes only, and the pressure in front of the centre of mass brakes each step. The soles of a
  // computed motion have no error, so they are pressed down as soon as a point ceases to bear load.
  const bool exact = model.schedule.knows_contacts(state.time);
  const double hover = exact ? o.touch : o.hover;
  double lowest = 1e9, slowest = 1e9;
  Vec3 low;
  const auto reference = [&](const LinkPoint& point) {
    const Pose& X = model.ref.X_WB[at(point.link)];
    return X * point.location.p - Vec3{0, 0, point.location.radius};
  };
  const auto rise_of = [&](const LinkPoint& point, const Vec3& p) {
    return dynamics::point_velocity(model.ref, point.link, p).z / state.rate;
  };
  for (const LinkPoint& point : model.feet[f].points) {
    const Vec3 p = reference(point);
    if (p.z < lowest) lowest = p.z, low = p;
  }
  for (const LinkPoint& point : model.feet[f].points) {
    const Vec3 p = reference(point);
    if (p.z < lowest + o.lifted) slowest = std::min(slowest, rise_of(point, p));
  }
  const std::size_t first = hovering_.size();
  double lowest_ground = 1e9, highest_ground = -1e9;
  for (const LinkPoint& point : model.feet[f].points) {
    const Vec3 wanted = reference(point);
    // The sole of the reference is level within the tilt `flat`.
    if (wanted.z > lowest + 0.5 * o.lifted + o.flat * norm(horizontal(wanted - low)) || rise_of(point, wanted) > slowest + o.lifting)
      continue;
    const Vec3 p = model.now.X_WB[at(point.link)] * point.location.p - Vec3{0, 0, point.location.radius};
    const double ground = model.map_height(state, p) + state.loose, gap = p.z - ground;
    lowest_ground = std::min(lowest_ground, ground);
    highest_ground = std::max(highest_ground, ground);
    // A sole on an edge bears load at the edge and at one end. If it tipped until the other end touches, the first one would hover.
    const BalanceState::FootState& foothold = state.feet[f];
    const Vec3 from = p - model.sole(f);
    const double plane = foothold.to[2] + foothold.tilt[0] * from.x + foothold.tilt[1] * from.y;
    if (gap < hover || gap > o.max_hover || ground < plane - o.max_gap) continue;
    hovering_.push_back({static_cast<int>(f), point.link, p, gap, wanted.z - lowest});
  }
  const bool even = highest_ground - lowest_ground < level;
  // On uneven ground, legs have other angles than in the reference, and a foot that lands on its heel does not become flat by itself.
  const double tolerance = o.exact + unevenness(model, state) * std::max(0.0, o.exact_uneven - o.exact);
  if (even) std::erase_if(hovering_, [&](const HoveringPoint& h) { return h.foot == static_cast<int>(f) && h.raised > tolerance; });
  if (hovering_.size() == first) return;
  Vec3 middle;
  for (std::size_t k = first; k < hovering_.size(); ++k) middle += hovering_[k].p;
  middle = middle / static_cast<double>(hovering_.size() - first);
  Vec3 bearing;
  double count = 0;
  for (const BearingPoint& b : bearing_)
    if (b.foot == static_cast<int>(f)) bearing += b.p, count += 1;
  if (count == 0) return;
  const Vec3 way = normalized(horizontal(middle - bearing / count), {});
  // A foot without an ankle tips about the axis of its own joint only. To press down its left or right edge, the whole leg and the body
  // would have to move.
  constexpr double across = 0.7;  // cosine of the angle between the two axes
  if (!model.feet[f].turns && !tips_about(model, f, cross(Vec3{0, 0, 1}, way), across)) {
    hovering_.resize(first);
    return;
  }
  double max_along = -1e9;
  for (const BearingPoint& b : bearing_)
    if (b.foot == static_cast<int>(f)) max_along = std::max(max_along, dot(b.p, way));
  // A foot that bears on both sides of the hovering points does not tip.
  // A measured sole on level ground is pressed down only if its pressure has to be at the end that hovers.
  if (dot(middle, way) < max_along || (even && !exact && dot(pressure, way) < max_along - o.press_margin)) {
    hovering_.resize(first);
    return;
  }
  std::erase_if(bearing_, [&](const BearingPoint& b) { return b.foot == static_cast<int>(f) && dot(b.p, way) < max_along - edge; });
}

void GroundSupport::find_turn(const BalanceModel& model, std::size_t f) {
  const auto l = at(model.feet[f].link);
  const Vec3 error = log_map(to_quat(model.ref.X_WB[l].R * model.now.X_WB[l].R.transposed()));
  const double rate = model.ref.V[l].w.z + error.z / model.options.turn_time;
  // The foot turns about the mean of the points, weighted by how little they move in the reference.
  constexpr double slow = 0.05;  // m/s: points that are slower count alike
  Vec3 pivot;
  double sum = 0;
  for (const BearingPoint& b : bearing_) {
    if (b.foot != static_cast<int>(f)) continue;
    const auto link = at(b.link);
    const Vec3 v = dynamics::point_velocity(model.ref, b.link, model.ref.X_WB[link] * (model.now.X_WB[link].inverse() * b.p));
    const double weight = 1 / (v.x * v.x + v.y * v.y + slow * slow);
    pivot += b.p * weight;
    sum += weight;
  }
  if (sum == 0) return;
  pivot = pivot / sum;
  for (BearingPoint& b : bearing_)
    if (b.foot == static_cast<int>(f)) b.slide = cross(Vec3{0, 0, rate}, b.p - pivot);
}

GroundSupport::Ground GroundSupport::ground_under(const BalanceModel& model, std::size_t foot) const {
  Vec3 point, normal;
  double count = 0;
  bool loose = false;
  for (const FootContact& c : contacts_) {
    if (c.foot != static_cast<int>(foot) || c.distance > model.options.touch) continue;
    point += c.p - c.n * (0.5 * c.distance);
    normal += c.n;
    loose = loose || c.loose;
    count += 1;
  }
  if (count == 0) return {};
  point = point / count;
  normal = normalized(normal);
  const Vec3 from = model.sole(foot) - point;
  return {true, point.z - (normal.x * from.x + normal.y * from.y) / normal.z, normal, loose};
}

double GroundSupport::distance_to_edge(int foot, const BalanceState& state, const Vec3& p, Vec3& closest) {
  hull_.clear();
  for (const FootContact& c : contacts_)
    if (c.distance <= near_ground && state.feet[c.foot].stands && (foot < 0 || c.foot == foot)) hull_.push_back(horizontal(c.p));
  closest = p;
  if (hull_.empty()) return -1e3;
  return control::distance_to_edge(hull_, p, closest);
}

}  // namespace ugoki::control
