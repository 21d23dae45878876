#include "ugoki/gait/pattern.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "ugoki/spatial/elementary.h"

namespace ugoki::gait {
namespace {

constexpr std::array<std::string_view, kind_count> kind_names{"walk",   "run",    "trot",  "pace", "canter",
                                                              "gallop", "rotary", "bound", "pronk"};

double fraction(double x) { return x - std::floor(x); }

/// Phases of four legs: left hind, left fore, right hind, right fore.
std::array<double, 4> phases_of_four(GaitKind kind) {
  switch (kind) {
    case GaitKind::walk: return {0, 0.25, 0.5, 0.75};
    case GaitKind::run:
    case GaitKind::trot: return {0, 0.5, 0.5, 0};
    case GaitKind::pace: return {0, 0, 0.5, 0.5};
    case GaitKind::canter: return {0.33, 0.66, 0, 0.33};
    case GaitKind::gallop: return {0, 0.5, 0.1, 0.6};
    case GaitKind::rotary: return {0, 0.6, 0.1, 0.5};
    case GaitKind::bound: return {0, 0.5, 0, 0.5};
    case GaitKind::pronk: return {0, 0, 0, 0};
  }
  return {};
}

struct Style {
  std::string_view name;
  GaitStyle style;
};
constexpr double degree = pi / 180;
constexpr std::array<Style, 5> styles{{
    {"usual", {}},
    {"sneak",
     {.lean = 14 * degree,
      .crouch = 0.09,
      .arms = 0.5,
      .elbows = 45 * degree,
      .width = 0.9,
      .bounce = 0.4,
      .cadence = 0.85,
      .hips = 0.7,
      .head = -10 * degree,
      .lift = 1.35,
      .foot_roll = 0.5}},
    {"tired",
     {.lean = 9 * degree,
      .crouch = 0.02,
      .arms = 0.55,
      .elbows = -8 * degree,
      .width = 1.15,
      .bounce = 0.8,
      .cadence = 0.9,
      .hips = 0.8,
      .head = 18 * degree,
      .lift = 0.75,
      .foot_roll = 0.7}},
    {"proud",
     {.lean = -4 * degree,
      .crouch = 0,
      .arms = 1.3,
      .elbows = 6 * degree,
      .width = 1,
      .bounce = 1.25,
      .cadence = 0.97,
      .hips = 1.15,
      .head = -7 * degree,
      .lift = 1.15,
      .foot_roll = 1.1}},
    {"hurried",
     {.lean = 5 * degree,
      .crouch = 0.01,
      .arms = 1.2,
      .elbows = 30 * degree,
      .width = 0.95,
      .bounce = 0.8,
      .cadence = 1.15,
      .hips = 1.1,
      .head = 3 * degree,
      .lift = 0.95,
      .foot_roll = 0.9}},
}};

}  // namespace

std::string_view name_of(GaitKind kind) { return kind_names[static_cast<std::size_t>(kind)]; }

std::optional<GaitKind> kind_named(std::string_view name) {
  for (std::size_t i = 0; i < kind_names.size(); ++i)
    if (kind_names[i] == name) return static_cast<GaitKind>(i);
  return std::nullopt;
}

std::optional<GaitStyle> style_named(std::string_view name) {
  for (const Style& s : styles)
    if (s.name == name) return s.style;
  return std::nullopt;
}

std::vector<std::string_view> style_names() {
  std::vector<std::string_view> out;
  for (const Style& s : styles) out.push_back(s.name);
  return out;
}

std::vector<GaitKind> kinds_for(int legs) {
  using enum GaitKind;
  if (legs == 2) return {walk, run};
  if (legs == 4) return {walk, run, trot, pace, canter, gallop, rotary, bound, pronk};
  return {walk, run, trot};
}

Pattern pattern_of(GaitKind kind, const std::vector<LegPlace>& legs, double leg_length, double speed, double gravity) {
  const double l = leg_length, unit = std::sqrt(gravity * l), V = std::fabs(speed) / unit;
  // Below the first speed a gait keeps its cadence, so that a character that starts, stops or turns on the spot steps at a natural rate.
  const double slow = std::max(V, kind == GaitKind::walk ? 0.22 : 0.5);
  Pattern out;
  const auto stride_of = [&](double stride_per_l) { out.stride_time = stride_per_l * l / (slow * unit); };
  if (legs.size() == 2) {
    if (kind == GaitKind::walk) {
      out.duty = std::clamp(0.66 - 0.10 * V, 0.54, 0.66);
      stride_of(2 * 1.06 * pow(slow, 0.42));
    } else {
      out.duty = std::clamp(0.36 - 0.11 * (V - 1.01), 0.2, 0.42);
      out.stride_time = 2 / std::clamp(2.9 + 0.35 * (V - 1.01), 2.5, 3.5) * std::sqrt(l / 0.9);
    }
    for (const LegPlace& leg : legs) out.phases.push_back(leg.left ? 0 : 0.5);
    return out;
  }
  if (legs.size() == 4) {
    if (kind == GaitKind::walk)
      stride_of(2.4 * pow(slow, 0.68));
    else
      stride_of(1.9 * pow(slow, 0.80));
    switch (kind) {
      case GaitKind::walk: out.duty = std::clamp(0.75 - 0.15 * (V - 0.25) / 0.45, 0.60, 0.84); break;
      case GaitKind::run:
      case GaitKind::trot:
      case GaitKind::pace: out.duty = std::clamp(0.55 - 0.10 * (V - 0.5) / 0.7, 0.38, 0.55); break;
      case GaitKind::canter: out.duty = 0.4; break;
      case GaitKind::gallop:
      case GaitKind::rotary: out.duty = std::clamp(0.35 - 0.05 * (V - 1.5), 0.22, 0.38); break;
      case GaitKind::bound:
      case GaitKind::pronk: out.duty = 0.4; break;
    }
    const std::array<double, 4> four = phases_of_four(kind);
    for (const LegPlace& leg : legs) out.phases.push_back(four[static_cast<std::size_t>((leg.left ? 0 : 2) + (leg.row > 0 ? 1 : 0))]);
    return out;
  }
  // Many legs. Walk: waves run from the back to the front, and the two legs of a row alternate. Run, trot: neighbouring legs alternate.
  // As in insects (Wilson 1966), a swing takes nearly the same time at all speeds, and stances become shorter. In a slow walk there are
  // times at which all feet stand.
  const int rows = std::ranges::max(legs, {}, &LegPlace::row).row + 1;
  out.duty = kind == GaitKind::walk ? std::max(0.6, 1 - 0.36 / rows - 1.2 * V) : 0.55;
  const double swing = 1.2 * std::sqrt(l / gravity), longest_step = 0.8 * l;  // s, m
  out.stride_time = swing / (1 - out.duty);
  if (std::fabs(speed) * out.stride_time * out.duty > longest_step) out.stride_time = longest_step / (std::fabs(speed) * out.duty);
  for (const LegPlace& leg : legs) {
    const double side = leg.left ? 0 : 0.5;
    out.phases.push_back(kind == GaitKind::walk ? fraction(side + leg.row * (1 - out.duty)) : fraction(side + 0.5 * (leg.row % 2)));
  }
  return out;
}

}  // namespace ugoki::gait
