#include "ugoki/capture/unlabelled.h"

#include <algorithm>
#include <cctype>
#include <string_view>
#include <tuple>

#include "ugoki/capture/gap_filling.h"

namespace ugoki::capture {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

/// Successive frames in which an unlabelled point is near the place of a missing marker.
struct Match {
  int column = -1, point = -1;  ///< of the marker, of the unlabelled point
  int from = 0, to = 0;         ///< frames, both included
  double distance = 0;          ///< m, mean
};

}  // namespace

bool is_unlabelled(const std::string& label) {
  std::string s;
  for (const char c : label)
    if (c != ' ' && c != '_' && c != '-') s += static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  if (s.starts_with('*')) return true;
  std::string_view rest = s;
  for (const std::string_view word : {"UNLABELED", "UNLABELLED", "UNNAMED", "UNAME", "UNKNOWN", "U", "C"})
    if (rest.starts_with(word)) {
      rest.remove_prefix(word.size());
      break;
    }
  const bool digits = std::ranges::all_of(rest, [](char c) { return c >= '0' && c <= '9'; });
  return digits && (!rest.empty() || s.size() > 2) && !(s.starts_with('C') && rest.size() < 3);  // C7 is a vertebra
}

std::vector<std::string> use_unlabelled(MarkerMotion& markers, const Subject& subject, const ModelPose& first, int from,
                                        const std::function<bool()>& cancelled) {
  constexpr double near = 0.04;  // m, for a body of the model's size: placement and movement of the skin
  constexpr int min_frames = 3;
  std::vector<int> points;
  for (int c = 0; c < markers.marker_count(); ++c)
    if (is_unlabelled(markers.labels[at(c)]) && std::ranges::find(subject.columns, c) == subject.columns.end()) points.push_back(c);
  bool has_gaps = false;
  for (int f = 0; f < markers.frames && !has_gaps; ++f)
    has_gaps = std::ranges::any_of(subject.columns, [&](int c) { return !markers.seen(f, c); });
  if (points.empty() || !has_gaps) return {};

  const std::size_t used = subject.columns.size();
  std::vector<Vec3> places(at(markers.frames) * used);  // m, places of the markers on the body
  std::vector<char> known(at(markers.frames), 0);
  solve_frames(markers, subject, first, from, cancelled, [&](int f, const PoseSolver& solver, const ModelPose&) {
    known[at(f)] = enough_markers_seen(markers, subject, f) ? 1 : 0;
    for (std::size_t m = 0; m < used; ++m) places[at(f) * used + m] = marker_position(subject, solver.kinematics(), m);
  });
  if (cancelled && cancelled()) return {};

  std::vector<Match> matches;
  for (std::size_t m = 0; m < used; ++m)
    for (const int point : points) {
      Match match{subject.columns[m], point, 0, -1, 0};
      const auto finish = [&] {
        const int count = match.to - match.from + 1;
        if (count >= min_frames) {
          match.distance /= count;
          matches.push_back(match);
        }
        match.to = -1;
      };
      for (int f = 0; f < markers.frames; ++f) {
        const double d = norm(markers.at(f, point) - places[at(f) * used + m]);
        if (known[at(f)] == 0 || markers.seen(f, match.column) || !markers.seen(f, point) || d > near * subject.size) {
          if (match.to >= 0) finish();
          continue;
        }
        if (match.to < 0) match = {match.column, point, f, f, 0};
        match.to = f;
        match.distance += d;
      }
      if (match.to >= 0) finish();
    }
  // The longest matches first; of matches of one length the closest ones.
  const auto rank = [](const Match& m) { return std::tuple(m.from - m.to, m.distance, m.column, m.point, m.from); };
  std::ranges::sort(matches, [&](const Match& a, const Match& b) { return rank(a) < rank(b); });
  std::vector<std::string> report;
  for (const Match& match : matches) {
    bool free = true;
    for (int f = match.from; f <= match.to; ++f) free = free && markers.seen(f, match.point) && !markers.seen(f, match.column);
    if (!free) continue;
    for (int f = match.from; f <= match.to; ++f) {
      const std::size_t to = markers.index(f, match.column), source = markers.index(f, match.point);
      markers.positions[to] = markers.positions[source];
      markers.residuals[to] = markers.residuals[source];
      markers.residuals[source] = -1;
    }
    report.push_back("The unlabelled trajectory " + markers.labels[at(match.point)] + " was used as " + markers.labels[at(match.column)] +
                     " in the frames " + std::to_string(markers.first_frame + match.from) + " to " +
                     std::to_string(markers.first_frame + match.to) + ", because it is at this marker's place on the body.");
  }
  return report;
}

}  // namespace ugoki::capture
