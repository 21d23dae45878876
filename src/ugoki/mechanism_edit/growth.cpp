#include "ugoki/mechanism_edit/growth.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string>

#include "ugoki/base/number.h"
#include "ugoki/mechanism/state.h"
#include "ugoki/mechanism_edit/scale.h"

namespace ugoki {
namespace {

struct Row {
  double age, boy_height, boy_mass, girl_height, girl_mass;  // years, m, kg
};
constexpr std::array<Row, 19> medians = {{{2, 0.865, 12.7, 0.850, 12.1},
                                          {3, 0.950, 14.3, 0.939, 13.9},
                                          {4, 1.022, 16.2, 1.008, 15.8},
                                          {5, 1.089, 18.4, 1.077, 17.9},
                                          {6, 1.154, 20.7, 1.147, 20.2},
                                          {7, 1.218, 23.1, 1.215, 22.8},
                                          {8, 1.279, 25.6, 1.276, 25.6},
                                          {9, 1.335, 28.6, 1.329, 29.0},
                                          {10, 1.386, 31.9, 1.380, 32.9},
                                          {11, 1.435, 35.9, 1.440, 37.2},
                                          {12, 1.491, 40.5, 1.512, 41.6},
                                          {13, 1.561, 45.6, 1.572, 45.8},
                                          {14, 1.638, 51.0, 1.604, 49.4},
                                          {15, 1.699, 56.3, 1.619, 52.0},
                                          {16, 1.735, 60.9, 1.625, 53.9},
                                          {17, 1.753, 64.6, 1.629, 55.1},
                                          {18, 1.762, 67.2, 1.631, 56.2},
                                          {19, 1.766, 69.1, 1.633, 57.3},
                                          {20, 1.768, 70.6, 1.633, 58.2}}};

// Per cent of the body mass at 6, 12 and 18 years. The head's values are replaced by the regression in mass_shares().
constexpr std::array<MassShares, 3> shares = {
    {{17.1, 43.0, 2.4, 1.3, 0.8, 8.5, 4.6, 1.9}, {10.1, 41.7, 3.2, 1.7, 0.9, 11.0, 5.3, 2.1}, {7.0, 44.6, 3.6, 1.9, 0.9, 11.4, 4.8, 1.7}}};

double total(const MassShares& s) { return s.head + s.trunk + 2 * (s.upper_arm + s.forearm + s.hand + s.thigh + s.shank + s.foot); }

/// The member of MassShares for a link with this label (labels: body/body.h); null if there is none.
double MassShares::* part_of(std::string_view label) {
  const auto begins = [&](std::string_view word) { return label.substr(0, word.size()) == word; };
  if (label == "head" || begins("neck")) return &MassShares::head;
  if (label == "pelvis" || begins("abdomen") || label == "chest" || begins("shoulder")) return &MassShares::trunk;
  if (begins("upper arm")) return &MassShares::upper_arm;
  if (begins("forearm")) return &MassShares::forearm;
  if (begins("hand") || begins("fingers") || begins("thumb")) return &MassShares::hand;
  if (begins("thigh")) return &MassShares::thigh;
  if (begins("shank")) return &MassShares::shank;
  if (begins("foot") || begins("toes")) return &MassShares::foot;
  return nullptr;
}

std::string metres(double x) { return to_fixed(x, 3) + " m"; }
std::string kilograms(double x) { return to_fixed(x, 2) + " kg"; }

/// Scale factors of each link between the two ages, such that the body has `mass` [kg]; lengths are not yet fitted to a height.
std::vector<LinkScale> scales_between(const Mechanism& m, double from_age, double to_age, double mass) {
  const MassShares from = mass_shares(from_age), to = mass_shares(to_age);
  std::vector<LinkScale> out(static_cast<std::size_t>(m.link_count()));
  double sum = 0;
  for (std::size_t i = 0; i < out.size(); ++i) {
    const auto part = part_of(m.links()[i].label);
    out[i].mass = part ? to.*part / (from.*part) : 1;
    sum += out[i].mass * m.links()[i].inertia.mass;
  }
  for (LinkScale& s : out) {
    s.mass *= mass / sum;
    s.along = pow(s.mass, 1.0 / 3);
  }
  return out;
}

void keep_density(std::vector<LinkScale>& scales) {
  for (LinkScale& s : scales) s.across = std::sqrt(s.mass / s.along);
}

/// Multiplies the lengths by a common factor so that the body gets the standing height `height` [m]. The factor is found by fixed-point
/// iteration, because soles and heads are not scaled like bones. @param even [links] nonzero: not multiplied by the factor
Result<Edited> fitted(const Mechanism& m, std::vector<LinkScale> scales, const std::vector<char>& even, double height) {
  Result<Edited> out;
  double factor = 1, worst = 0;
  for (int round = 0; round < 20; ++round) {
    std::vector<LinkScale> now = scales;
    for (std::size_t i = 0; i < now.size(); ++i)
      if (!even[i]) now[i].along *= factor;
    keep_density(now);
    out = scale_links(m, now);
    if (!out) return out;
    const double reached = standing_height(*out->mechanism);
    worst = std::fabs(reached / height - 1);
    if (worst < 1e-6) break;
    factor *= height / reached;
  }
  if (worst >= 1e-3) out->report.push_back("The resulting height is " + metres(standing_height(*out->mechanism)) + ".");
  return out;
}

}  // namespace

Growth median_growth(double age, GrowthSex sex) {
  const double a = std::clamp(age, medians.front().age, medians.back().age);
  const std::size_t i = std::min(static_cast<std::size_t>(a - medians.front().age), medians.size() - 2);
  const double t = a - medians[i].age;
  const auto between = [&](double x, double y) { return x + t * (y - x); };
  const Row &p = medians[i], &q = medians[i + 1];
  return sex == GrowthSex::boy ? Growth{between(p.boy_height, q.boy_height), between(p.boy_mass, q.boy_mass)}
                               : Growth{between(p.girl_height, q.girl_height), between(p.girl_mass, q.girl_mass)};
}

MassShares mass_shares(double age) {
  const double t = (std::clamp(age, 4.0, 20.0) - 6) / 6;
  MassShares out{};
  for (double MassShares::* part : {&MassShares::head, &MassShares::trunk, &MassShares::upper_arm, &MassShares::forearm, &MassShares::hand,
                                    &MassShares::thigh, &MassShares::shank, &MassShares::foot}) {
    const double a = shares[0].*part, b = shares[1].*part, c = shares[2].*part;
    out.*part = a + t * (b - a) + 0.5 * t * (t - 1) * (c - 2 * b + a);  // parabola through the three values, in Newton's form
  }
  const double years = std::clamp(age, 4.0, 20.0);
  out.head = 27.881 - 2.1152 * years + 0.053168 * years * years;
  const double sum = total(out);
  for (double MassShares::* part : {&MassShares::head, &MassShares::trunk, &MassShares::upper_arm, &MassShares::forearm, &MassShares::hand,
                                    &MassShares::thigh, &MassShares::shank, &MassShares::foot})
    out.*part /= sum;
  return out;
}

double standing_height(const Mechanism& m) {
  std::vector<Pose> X_WB(static_cast<std::size_t>(m.link_count()));
  const std::vector<double> q = m.neutral();
  calc_poses(m, q, X_WB);
  double low = INFINITY, high = -INFINITY;
  for (std::size_t i = 0; i < X_WB.size(); ++i) {
    low = std::min(low, X_WB[i].p.z);
    high = std::max(high, X_WB[i].p.z);
    for (const Shape& s : m.links()[i].shapes) {
      if (s.type == ShapeType::height_field) continue;
      const Pose X = X_WB[i] * s.X_BS;
      const Vec3 up = X.R.row(2);
      high = std::max(high, X.p.z + reach(s, up));
      low = std::min(low, X.p.z - reach(s, -up));
    }
  }
  return high - low;
}

Result<Edited> grow(const Mechanism& m, const GrowOptions& options) {
  const std::string location = "mechanism " + m.name();
  const bool by_age = options.age > 0;
  if (!by_age && !(options.height > 0) && !(options.mass > 0))
    return fail(ErrorCode::range, location, "Neither age nor height nor mass is specified.", "Specify at least one of them, above 0.");
  for (const double x : {options.age, options.height, options.mass, options.from_age})
    if (!std::isfinite(x) || x < 0)
      return fail(ErrorCode::range, location, "Age, height and mass must be finite and at least 0; one is " + to_fixed(x, 3) + ".",
                  "Correct the value.");
  if (by_age && options.age < 2)
    return fail(ErrorCode::unsupported, location, "The age is " + to_fixed(options.age, 2) + " years; the growth tables begin at 2 years.",
                "Use an age of 2 years or more.");
  const double standing = standing_height(m), was = options.from_height > 0 ? options.from_height : standing;
  if (!(standing > 0) || !(m.mass() > 0))
    return fail(ErrorCode::structure, location, "The mechanism has no height or no mass to scale.",
                "Give its links masses and shapes first.");
  const Growth median = by_age ? median_growth(options.age, options.sex) : Growth{};
  const double height = options.height > 0 ? options.height : by_age ? median.height : was;
  const double l = height / was;
  const double mass = options.mass > 0 ? options.mass : by_age ? median.mass : m.mass() * l * l * l;

  std::vector<char> even(static_cast<std::size_t>(m.link_count()), 0);
  std::size_t labelled = 0;
  for (std::size_t i = 0; i < even.size(); ++i) {
    const auto part = part_of(m.links()[i].label);
    labelled += part != nullptr;
    even[i] = part == &MassShares::head;
  }
  const bool proportions = by_age && 2 * labelled > even.size();
  Result<Edited> out = proportions ? fitted(m, scales_between(m, options.from_age, options.age, mass), even, standing * l)
                                   : scale(m, {.length = l, .mass = mass, .stout = true});
  if (!out) return out;
  std::vector<std::string> report = {"From " + metres(was) + " and " + kilograms(m.mass()) + " to " + metres(height) + " and " +
                                     kilograms(mass) + "."};
  if (by_age && options.height <= 0) report.push_back("The height is the median at that age.");
  if (by_age && options.mass <= 0) report.push_back("The mass is the median at that age.");
  if (!by_age && options.mass <= 0 && options.height > 0) report.push_back("The mass was scaled with the cube of the height.");
  if (proportions)
    report.push_back("The mass shares of the body parts are those at " + to_fixed(std::clamp(options.age, 4.0, 20.0), 1) +
                     " years (Jensen 1989); lengths and thicknesses follow at the same density.");
  else if (by_age)
    report.push_back("The links are not labelled as parts of a human, so all were scaled evenly: only height and mass follow the age.");
  out->report.insert(out->report.begin(), report.begin(), report.end());
  return out;
}

}  // namespace ugoki
