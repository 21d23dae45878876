// Cuts recordings at jumps from one frame to the next and at held poses in mid-motion, and keeps the longest part.

#include <algorithm>
#include <cmath>

#include "ugoki/base/number.h"
#include "ugoki/intake/arrange.h"

namespace ugoki::intake {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

/// Longest part of a recording without a jump: frames from ... to - 1.
struct Cut {
  int jumps = 0, first = 0, from = 0, to = 0;
};
/// @param step [frames - 1] m, way from frame f to f + 1 @param min_jump m, a jump is longer than this and three times the usual way around
/// it
/// @param ignored number of the first steps that are no jumps
Cut find_cut(const std::vector<double>& step, double min_jump, std::size_t ignored) {
  std::vector<int> begins = {0};
  for (std::size_t f = ignored; f < step.size(); ++f) {
    std::vector<double> around(step.begin() + static_cast<std::ptrdiff_t>(f > 5 ? f - 5 : 0),
                               step.begin() + static_cast<std::ptrdiff_t>(std::min(step.size(), f + 6)));
    const auto middle = around.begin() + static_cast<std::ptrdiff_t>(around.size() / 2);
    std::nth_element(around.begin(), middle, around.end());
    if (step[f] > min_jump + 3 * *middle) begins.push_back(static_cast<int>(f) + 1);
  }
  Cut out;
  out.jumps = static_cast<int>(begins.size()) - 1;
  if (out.jumps == 0) return out;
  out.first = begins[1] - 1;
  begins.push_back(static_cast<int>(step.size()) + 1);
  for (std::size_t k = 0; k + 1 < begins.size(); ++k)
    if (begins[k + 1] - begins[k] > out.to - out.from) {
      out.from = begins[k];
      out.to = begins[k + 1];
    }
  return out;
}

/// A held pose: nothing moves in the steps from ... to - 1, although the character moves fast in the step before or after them.
struct Hold {
  int from, to;
};
/// @param fastest, mean [frames - 1] m, maximum and mean over the joints of the way from frame f to f + 1  @param leg m  @param rate 1/s
std::vector<Hold> find_holds(const std::vector<double>& fastest, const std::vector<double>& mean, double leg, double rate) {
  // Measured bodies are never exactly still, and nobody stops from 1 m/s (for a leg of 0.85 m; Froude) within a frame.
  constexpr double shortest = 0.25, still = 1e-5, fast = 0.35, gravity = 9.81;  // s, share of the leg, Froude number of the speed, m/s^2
  const int n = static_cast<int>(fastest.size());
  const double moving = fast * std::sqrt(gravity * leg) / rate;
  std::vector<Hold> out;
  for (int f = 0; f < n; ++f) {
    if (fastest[at(f)] > still * leg) continue;
    const int from = f;
    while (f < n && fastest[at(f)] <= still * leg) ++f;
    const bool cut_off = (from > 0 && mean[at(from - 1)] > moving) || (f < n && mean[at(f)] > moving);
    if ((f - from) / rate >= shortest && cut_off) out.push_back({from, f});
  }
  return out;
}

/// The longest part of `n` frames between the holds. A held pose is the last frame of the part before it: the next one can begin anywhere.
Cut longest_between(const std::vector<Hold>& holds, int n) {
  Cut out;
  out.jumps = static_cast<int>(holds.size());
  out.first = holds.front().from;
  int begin = 0;
  for (std::size_t k = 0; k <= holds.size(); ++k) {
    const int end = k < holds.size() ? holds[k].from + 1 : n;
    if (end - begin > out.to - out.from) {
      out.from = begin;
      out.to = end;
    }
    if (k < holds.size()) begin = holds[k].to + 1;
  }
  return out;
}

void keep_frames(MeasuredMotion& motion, int from, int to) {
  const auto n = static_cast<std::ptrdiff_t>(motion.skeleton.joints.size());
  motion.translations = {motion.translations.begin() + from * n, motion.translations.begin() + to * n};
  motion.rotations = {motion.rotations.begin() + from * n, motion.rotations.begin() + to * n};
  motion.frames = to - from;
}

std::string words_of(const Cut& cut, double rate) {
  return std::to_string(cut.jumps) + (cut.jumps == 1 ? " time" : " times") + ", first at " + to_fixed(cut.first / rate, 2) +
         " s); the motion was cut to the longest part without a jump, frames " + std::to_string(cut.from + 1) + " to " +
         std::to_string(cut.to);
}

}  // namespace

std::string cut_at_jumps(const body::Character& character, MeasuredMotion& motion) {
  if (character.plan == body::BodyPlan::other || !(character.leg_length > 0) || motion.frames < 20) return {};
  std::vector<Vec3> root;
  std::vector<Pose> X;
  for (int f = 0; f < motion.frames; ++f) {
    motion.calc_joint_poses(f, X);
    root.push_back(X[at(character.pelvis)].p);
  }
  std::vector<double> step;
  for (std::size_t f = 1; f < root.size(); ++f) step.push_back(norm(root[f] - root[f - 1]));
  // A person does not move by a third of a leg in a frame beyond three times its usual way.
  const Cut cut = find_cut(step, 0.35 * character.leg_length, 1);
  if (cut.jumps == 0) return {};
  const int frames = motion.frames;
  keep_frames(motion, cut.from, cut.to);
  return "The character jumps to another place from one frame to the next (" + words_of(cut, motion.rate) + " of " +
         std::to_string(frames) + ", and the others are left out.";
}

std::string cut_at_holds(const body::Character& character, MeasuredMotion& motion) {
  if (character.plan == body::BodyPlan::other || !(character.leg_length > 0) || motion.frames < 20) return {};
  std::vector<double> fastest, mean;
  std::vector<Pose> X, before;
  for (int f = 0; f < motion.frames; ++f) {
    motion.calc_joint_poses(f, X);
    double max_way = 0, sum = 0;
    for (std::size_t i = 0; i < before.size(); ++i) {
      const double way = norm(X[i].p - before[i].p);
      max_way = std::max(max_way, way);
      sum += way;
    }
    if (f > 0) {
      fastest.push_back(max_way);
      mean.push_back(sum / static_cast<double>(X.size()));
    }
    before = X;
  }
  const std::vector<Hold> holds = find_holds(fastest, mean, character.leg_length, motion.rate);
  if (holds.empty()) return {};
  const Cut cut = longest_between(holds, motion.frames);
  int held = 0;
  for (const Hold& h : holds) held += h.to - h.from;
  const int frames = motion.frames;
  keep_frames(motion, cut.from, cut.to);
  return "The file holds a pose of the moving character exactly for " + to_fixed(held / motion.rate, 2) + " s (first at " +
         to_fixed(cut.first / motion.rate, 2) +
         " s), as in a gap between two recordings; the motion was cut to the longest part without it, frames " +
         std::to_string(cut.from + 1) + " to " + std::to_string(cut.to) + " of " + std::to_string(frames) +
         ", and the others are left out.";
}

std::string cut_markers_at_jumps(MarkerMotion& markers) {
  if (markers.frames < 20 || markers.labels.empty()) return {};
  // Step of a frame: the median over the markers, so that single markers that are exchanged do not count.
  std::vector<double> step, moves;
  Vec3 low{1e300, 1e300, 1e300}, high = low * -1.0;
  for (int f = 1; f < markers.frames; ++f) {
    moves.clear();
    for (int i = 0; i < markers.marker_count(); ++i) {
      if (!markers.seen(f, i) || !markers.seen(f - 1, i)) continue;
      moves.push_back(norm(markers.at(f, i) - markers.at(f - 1, i)));
      if (f > 1) continue;
      for (int k = 0; k < 3; ++k) {
        low[k] = std::min(low[k], markers.at(f, i)[k]);
        high[k] = std::max(high[k], markers.at(f, i)[k]);
      }
    }
    const auto middle = moves.begin() + static_cast<std::ptrdiff_t>(moves.size() / 2);
    if (!moves.empty()) std::nth_element(moves.begin(), middle, moves.end());
    step.push_back(moves.empty() ? 0 : *middle);
  }
  const double extent = high.x < low.x ? 0 : norm(high - low);
  if (!(extent > 0)) return {};
  const Cut cut = find_cut(step, 0.05 * extent, 0);  // 9 cm for a person, beyond three times the usual way
  if (cut.jumps == 0) return {};
  const std::size_t n = markers.labels.size(), per_frame = markers.analog.size() * at(markers.samples_per_frame());
  const auto keep = [&](auto& list, std::size_t width) {
    if (list.size() < at(cut.to) * width) return;
    list.erase(list.begin() + static_cast<std::ptrdiff_t>(at(cut.to) * width), list.end());
    list.erase(list.begin(), list.begin() + static_cast<std::ptrdiff_t>(at(cut.from) * width));
  };
  keep(markers.positions, n);
  keep(markers.residuals, n);
  keep(markers.samples, per_frame);
  const int frames = markers.frames;
  markers.frames = cut.to - cut.from;
  markers.first_frame += cut.from;
  for (MarkedEvent& e : markers.events) e.time -= cut.from / markers.rate;
  return "The markers jump together from one frame to the next (" + words_of(cut, markers.rate) + " of " + std::to_string(frames) +
         ", and the others are left out.";
}

}  // namespace ugoki::intake
