#include "ugoki/intake/animal_size.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "ugoki/base/number.h"
#include "ugoki/intake/tree_edit.h"
#include "ugoki/spatial/elementary.h"

namespace ugoki::intake {
namespace {

constexpr double gravity = 9.81;              // m/s^2
constexpr double fall_limit = 1.2 * gravity;  // m/s^2: smoothing and animation exceed g a little

std::size_t at(int i) { return static_cast<std::size_t>(i); }

double value_at(std::vector<double> v, double share) {
  const auto k = v.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(v.size() - 1));
  std::nth_element(v.begin(), k, v.end());
  return *k;
}

std::vector<int> feet_of(const body::Character& c) {
  std::vector<int> feet;
  for (const auto* limbs : {&c.legs, &c.arms})
    for (const body::Limb& l : *limbs)
      if (const int foot = l.tip >= 0 ? l.tip : l.end >= 0 ? l.end : l.distal; foot >= 0) feet.push_back(foot);
  return feet;
}

/// Mean place of the roots of the four limbs.
Vec3 trunk_at(const body::Character& c, const std::vector<Pose>& X) {
  Vec3 p{};
  for (const auto* limbs : {&c.legs, &c.arms})
    for (const body::Limb& l : *limbs) p += X[at(l.proximal)].p * 0.25;
  return p;
}

/// Period [frames] of a signal: the first maximum of its autocorrelation above 0.5. @return 0 if it is shorter than two periods or not
/// periodic
double period_of(const std::vector<double>& x) {
  const int n = static_cast<int>(x.size());
  double mean = 0, variance = 0;
  for (const double v : x) mean += v / n;
  for (const double v : x) variance += (v - mean) * (v - mean) / n;
  if (n < 12 || !(variance > 0)) return 0;
  std::vector<double> r;
  for (int lag = 0; lag <= n / 2; ++lag) {
    double sum = 0;
    for (int k = 0; k + lag < n; ++k) sum += (x[at(k)] - mean) * (x[at(k + lag)] - mean);
    r.push_back(sum / ((n - lag) * variance));
  }
  bool left = false;  // the maximum at lag 0
  for (int lag = 1; lag + 1 < static_cast<int>(r.size()); ++lag) {
    left = left || r[at(lag)] < 0.2;
    if (left && r[at(lag)] > 0.5 && r[at(lag)] >= r[at(lag - 1)] && r[at(lag)] >= r[at(lag + 1)]) return lag;
  }
  return 0;
}

/// Froude number of a stride of the given length relative to the height of the hips.
double froude_of(double stride) {
  const double slow = ugoki::exp(ugoki::log(stride / 2.4) / 0.34);
  return slow < 2 ? slow : ugoki::exp(ugoki::log(stride / 1.9) / 0.40);
}

/// Stride of one foot: period [s] and speed [m/s] of the standing foot relative to the trunk.
struct Stride {
  double period = 0, speed = 0;
};
std::optional<Stride> stride_of(const body::Character& c, const MeasuredMotion& m, const std::vector<std::vector<Pose>>& world, int foot) {
  std::vector<Vec3> p;  // relative to the trunk, turned so that the animal heads along x
  std::vector<double> z;
  for (const auto& X : world) {
    Vec3 ahead{};
    for (int k = 0; k < 2; ++k) ahead += (X[at(c.arms[at(k)].proximal)].p - X[at(c.legs[at(k)].proximal)].p) * 0.5;
    ahead.z = 0;
    const double length = norm(ahead);
    if (!(length > 0)) return std::nullopt;
    ahead = ahead / length;
    const Vec3 d = X[at(foot)].p - trunk_at(c, X);
    p.push_back({dot(d, ahead), -d.x * ahead.y + d.y * ahead.x, d.z});
    z.push_back(X[at(foot)].p.z);
  }
  std::vector<double> x;
  for (const Vec3& v : p) x.push_back(v.x);
  const double period = period_of(x);
  if (!(period > 0)) return std::nullopt;
  const double low = value_at(z, 0.35);
  std::vector<double> speeds;
  for (int f = 1; f + 1 < m.frames; ++f)
    if (z[at(f)] <= low) speeds.push_back((x[at(f - 1)] - x[at(f + 1)]) * m.rate / 2);
  if (speeds.size() < 4) return std::nullopt;
  const double speed = value_at(speeds, 0.5);
  if (!(speed > 0)) return std::nullopt;
  return Stride{period / m.rate, speed};
}

/// Values that the sentence about the size mentions.
struct SizeValues {
  double mass_before, mass, trunk;  ///< kg, kg, m
  double fall, fall_before;         ///< m/s^2
  std::optional<double> hips;       ///< m, that the gait implies
  double lightest, heaviest;        ///< kg
};

std::string kilograms(double m) { return to_fixed(m, m < 1 ? 3 : m < 10 ? 1 : 0) + " kg"; }

/// Sentence about the chosen size; empty if nothing spoke against the file's unit.
std::string reason_for(const AnimalSize& size, const SizeValues& f, bool trusted, const std::optional<SpeciesMass>& species) {
  const bool unusual = 1.2 * f.mass_before < f.lightest || f.mass_before > 1.2 * f.heaviest;
  const std::string range =
      (species ? "a usual " + species->names + (species->source.empty() ? "" : " (" + species->source + ")") + " weighs "
               : std::string("four-legged animals usually weigh ")) +
      kilograms(f.lightest) + " to " + kilograms(f.heaviest);
  const auto falls = [](double a) { return "its trunk falls with up to " + to_fixed(a / gravity, 1) + " g"; };
  std::string out;
  if (size.changed) {
    out = "The unit of length is assumed to be " + to_text(size.unit) + " m, with which the trunk of the animal is " +
          to_fixed(f.trunk, 3) + " m long and the animal weighs about " + kilograms(f.mass);
    if (trusted) out += "; with the unit that the file states it would weigh " + kilograms(f.mass_before);
    if (unusual) out += "; " + range;
    if (f.fall_before > fall_limit) out += "; with the file's unit " + falls(f.fall_before);
    if (f.hips) out += "; its gait belongs to hips at " + to_fixed(*f.hips, 2) + " m";
    if (f.fall > fall_limit) out += "; now " + falls(f.fall) + ", because the motion is exaggerated or too fast";
  } else if (trusted && (unusual || f.fall_before > fall_limit)) {
    out = "The unit of length that the file states was kept. The animal weighs about " + kilograms(f.mass);
    if (unusual) out += "; " + range;
    if (f.fall > fall_limit) out += "; " + falls(f.fall) + ", because the motion is exaggerated, too fast or too large";
  } else {
    return out;
  }
  return out + ". Set the unit or the species if it is wrong.";
}

}  // namespace

double fall_of_trunk(const body::Character& character, std::span<const MeasuredMotion> motions) {
  std::vector<double> falls;
  for (const MeasuredMotion& m : motions) {
    const int span = std::max(1, static_cast<int>(std::lround(0.04 * m.rate)));  // differences over shorter times measure noise
    if (m.frames < 2 * span + 6) continue;
    std::vector<double> heights;
    for (const auto& X : world_of(m)) heights.push_back(trunk_at(character, X).z);
    const double time = span / m.rate;
    for (int f = span; f + span < m.frames; ++f)
      falls.push_back((2 * heights[at(f)] - heights[at(f - span)] - heights[at(f + span)]) / (time * time));
  }
  return falls.size() < 20 ? 0 : value_at(std::move(falls), 0.98);
}

double hip_height(const body::Character& character, std::span<const MeasuredMotion> motions) {
  std::vector<double> hips, feet;
  const std::vector<int> ends = feet_of(character);
  for (const auto& X : sample_poses(motions)) {
    hips.push_back(0.5 * (X[at(character.legs[0].proximal)].p.z + X[at(character.legs[1].proximal)].p.z));
    for (const int foot : ends) feet.push_back(X[at(foot)].p.z);
  }
  return hips.empty() || feet.empty() ? 0 : value_at(std::move(hips), 0.5) - value_at(std::move(feet), 0.05);
}

std::optional<double> hip_height_by_gait(const body::Character& character, std::span<const MeasuredMotion> motions) {
  const double h = hip_height(character, motions);
  if (!(h > 0)) return std::nullopt;
  std::vector<double> heights;
  for (const MeasuredMotion& m : motions) {
    const auto world = world_of(m);
    std::vector<double> periods, speeds;
    for (const int foot : feet_of(character))
      if (const auto s = stride_of(character, m, world, foot)) {
        periods.push_back(s->period);
        speeds.push_back(s->speed);
      }
    if (periods.size() < 2) continue;
    const double period = value_at(periods, 0.5), stride = value_at(speeds, 0.5) * period / h;
    // Gaits from slow walks to gallops. Feet that hardly move, or slide, are no gait.
    if (stride > 0.6 && stride < 8) heights.push_back(gravity * period * period * froude_of(stride) / (stride * stride));
  }
  if (heights.empty()) return std::nullopt;
  return value_at(std::move(heights), 0.5);
}

std::optional<AnimalSize> size_of_animal(const body::Character& character, std::span<const MeasuredMotion> motions, double metres_per_unit,
                                         bool trusted, const std::optional<SpeciesMass>& species) {
  if (character.plan != body::BodyPlan::four_legs || !(character.trunk_length > 0)) return std::nullopt;
  const double lightest = species ? species->lightest : 0.05, heaviest = species ? species->heaviest : 960;
  const double fall = fall_of_trunk(character, motions);
  const std::optional<double> by_gait = trusted ? std::nullopt : hip_height_by_gait(character, motions);
  const double hips = by_gait ? hip_height(character, motions) : 0;
  const auto mass = [&](double k) { return mass_of_trunk * std::pow(character.trunk_length * k, 3); };
  const auto square = [](double x, double deviation) { return 0.5 * (x / deviation) * (x / deviation); };
  // Cost of the size k times the present one. 0.25: an animal 2.1 times as heavy as the range costs as much as changing a stated unit. The
  // gait of a motion differs by a factor of 1.8 from the mean of animals (small animals crouch), and animations by more, so its cost is
  // limited.
  const auto cost = [&](double k) {
    const double m = mass(k), outside = std::max({0.0, std::log(lightest / m), std::log(m / heaviest)});
    double sum = square(outside, species ? 0.25 : 0.3);
    if (fall * k > fall_limit) sum += square(std::log(fall * k / fall_limit), 0.3);
    if (by_gait) sum += std::min(3.0, square(std::log(hips * k / *by_gait), 0.6));
    return sum;
  };
  constexpr double other_unit = 4, any_scale = 4.5;
  double best_unit = metres_per_unit, min_cost = trusted ? cost(1) : 1e300;
  const auto consider = [&](double unit, double unlikely) {
    const double c = cost(unit / metres_per_unit) + unlikely;
    if (c < min_cost - 1e-9) {
      min_cost = c;
      best_unit = unit;
    }
  };
  if (trusted)
    for (const double unit : {1.0, 0.01, 0.001, 0.0254, 0.3048}) consider(unit, other_unit);
  else
    for (const auto& [unit, unlikely] : {std::pair{0.01, 0.0}, {1.0, 0.5}, {0.001, 1.0}, {0.0254, 1.0}}) consider(unit, unlikely);
  // Without a usual unit, an animal of a medium mass is more likely than one at the limits of the range: between dog and horse, if the
  // species is not known.
  const double middle = species ? 0.5 * (std::log(lightest) + std::log(heaviest)) : std::log(120.0);
  const double width = species ? std::max(0.3, 0.5 * std::log(heaviest / lightest)) : 2;
  double scale = 1, cheapest = 1e300;
  for (double x = -14; x <= 14; x += 0.002) {
    const double k = std::exp(x), c = cost(k) + square(std::log(mass(k)) - middle, width) + any_scale;
    if (c < cheapest) {
      cheapest = c;
      scale = k;
    }
  }
  const bool scaled = cheapest < min_cost - 1e-9;
  AnimalSize out;
  out.unit = scaled ? metres_per_unit * scale : best_unit;
  const double k = out.unit / metres_per_unit;
  out.changed = std::fabs(k - 1) > 1e-9;
  if (!out.changed) out.unit = metres_per_unit;
  out.reason =
      reason_for(out, {mass(1), mass(k), character.trunk_length * k, fall * k, fall, by_gait, lightest, heaviest}, trusted, species);
  return out;
}

std::string limit_mass(body::Body& body, const SpeciesMass& species, const MeasuredMotion& motion, body::BodyOptions options) {
  const double by_size = body.mass;
  options.mass = std::clamp(by_size, species.lightest, species.heaviest);
  if (options.mass == by_size) return {};
  Result<body::Body> again = body::make_body(motion, options);
  if (!again) return {};
  body = std::move(*again);
  const auto kg = [](double mass) { return to_fixed(mass, mass < 10 ? 2 : 0) + " kg"; };
  return "By its size the animal would weigh " + kg(by_size) + ". It gets " + kg(body.mass) + ", the closest mass of a usual " +
         species.names + (species.source.empty() ? "" : " (" + species.source + ")") +
         ". Set the mass, the unit or the species if it is wrong.";
}

}  // namespace ugoki::intake
