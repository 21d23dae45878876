#include "ugoki/motion/marker_repair.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "ugoki/motion/butterworth.h"
#include "ugoki/spatial/rotation.h"

namespace ugoki {
namespace {

void put(MarkerMotion& m, int frame, int marker, const Vec3& x) {
  m.positions[m.index(frame, marker)] = x;
  m.residuals[m.index(frame, marker)] = 0;
}

/// Velocity [m/frame] of a marker in a frame in which it was seen, from the neighbouring frames in which it was seen.
Vec3 slope(const MarkerMotion& m, int marker, int frame) {
  const bool before = frame > 0 && m.seen(frame - 1, marker), after = frame + 1 < m.frames && m.seen(frame + 1, marker);
  if (before && after) return (m.at(frame + 1, marker) - m.at(frame - 1, marker)) * 0.5;
  if (before) return m.at(frame, marker) - m.at(frame - 1, marker);
  if (after) return m.at(frame + 1, marker) - m.at(frame, marker);
  return {};
}

/// Cubic Hermite interpolation between values a and b with slopes da and db over an interval of length h, at t in [0, 1].
Vec3 hermite(const Vec3& a, const Vec3& da, const Vec3& b, const Vec3& db, double h, double t) {
  const double t2 = t * t, t3 = t2 * t;
  return a * (2 * t3 - 3 * t2 + 1) + da * (h * (t3 - 2 * t2 + t)) + b * (3 * t2 - 2 * t3) + db * (h * (t3 - t2));
}

/// Rotation that maps the points a to b with the least squared error; both are relative to their centroids. The rotation is the
/// eigenvector of the largest eigenvalue of Horn's matrix (1987), found by shifted power iteration from `guess`.
Quat best_rotation(const std::vector<Vec3>& a, const std::vector<Vec3>& b, Quat guess) {
  Mat3 M{};
  double size = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    M = M + Mat3::columns(a[i] * b[i].x, a[i] * b[i].y, a[i] * b[i].z);
    size += norm(a[i]) * norm(b[i]);
  }
  const std::array<std::array<double, 4>, 4> N = {{{M.xx + M.yy + M.zz, M.yz - M.zy, M.zx - M.xz, M.xy - M.yx},
                                                   {M.yz - M.zy, M.xx - M.yy - M.zz, M.xy + M.yx, M.zx + M.xz},
                                                   {M.zx - M.xz, M.xy + M.yx, M.yy - M.xx - M.zz, M.yz + M.zy},
                                                   {M.xy - M.yx, M.zx + M.xz, M.yz + M.zy, M.zz - M.xx - M.yy}}};
  std::array<double, 4> v = {guess.w, guess.x, guess.y, guess.z};
  for (int iteration = 0; iteration < 200; ++iteration) {
    std::array<double, 4> w{};
    double length = 0, change = 0;
    for (std::size_t r = 0; r < 4; ++r) {
      w[r] = size * v[r];
      for (std::size_t c = 0; c < 4; ++c) w[r] += N[r][c] * v[c];
      length += w[r] * w[r];
    }
    length = std::sqrt(length);
    if (!(length > 0)) return guess;
    for (std::size_t r = 0; r < 4; ++r) {
      change += std::fabs(w[r] / length - v[r]);
      v[r] = w[r] / length;
    }
    if (change < 1e-13) break;
  }
  return normalized(Quat{v[0], v[1], v[2], v[3]});
}

/// Up to six markers whose distance from `marker` has the smallest standard deviation, below `rigid` [m].
std::vector<int> rigid_neighbours(const MarkerMotion& m, int marker, double rigid) {
  std::vector<std::pair<double, int>> order;
  for (int other = 0; other < m.marker_count(); ++other) {
    if (other == marker) continue;
    double sum = 0, squares = 0;
    int count = 0;
    for (int f = 0; f < m.frames; ++f) {
      if (!m.seen(f, marker) || !m.seen(f, other)) continue;
      const double d = norm(m.at(f, marker) - m.at(f, other));
      sum += d;
      squares += d * d;
      ++count;
    }
    if (count < 2) continue;
    const double mean = sum / count, deviation = std::sqrt(std::max(0.0, squares / count - mean * mean));
    if (deviation < rigid) order.emplace_back(deviation, other);
  }
  std::sort(order.begin(), order.end());
  std::vector<int> out;
  for (std::size_t i = 0; i < order.size() && i < 6; ++i) out.push_back(order[i].second);
  return out;
}

/// Computes the position of `marker` in frame `to` if it moved rigidly with the markers `others` since frame `from`.
/// @return false if fewer than three of these markers are seen in both frames
bool carry(const MarkerMotion& m, int marker, const std::vector<int>& others, int from, int to, Vec3& out) {
  std::vector<Vec3> a, b;
  for (const int o : others) {
    if (!m.seen(from, o) || !m.seen(to, o)) continue;
    a.push_back(m.at(from, o));
    b.push_back(m.at(to, o));
  }
  if (a.size() < 3) return false;
  Vec3 ma, mb;
  for (std::size_t i = 0; i < a.size(); ++i) {
    ma += a[i];
    mb += b[i];
  }
  ma = ma / static_cast<double>(a.size());
  mb = mb / static_cast<double>(a.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    a[i] -= ma;
    b[i] -= mb;
  }
  out = mb + rotate(best_rotation(a, b, {}), m.at(from, marker) - ma);
  return true;
}

/// Sum of the squared changes that a filter with this cut-off makes, over all seen coordinates.
/// @param count [out] number of seen coordinates
double removed(const MarkerMotion& motion, double cutoff, double& count) {
  MarkerMotion filtered = motion;
  filter_markers(filtered, cutoff);
  double sum = 0;
  count = 0;
  for (std::size_t i = 0; i < motion.positions.size(); ++i) {
    if (motion.residuals[i] < 0) continue;
    const Vec3 d = filtered.positions[i] - motion.positions[i];
    sum += dot(d, d);
    count += 3;
  }
  return sum;
}

}  // namespace

std::vector<MarkerGap> find_gaps(const MarkerMotion& m) {
  std::vector<MarkerGap> out;
  for (int i = 0; i < m.marker_count(); ++i) {
    for (int f = 0; f < m.frames; ++f) {
      if (m.seen(f, i)) continue;
      int last = f;
      while (last + 1 < m.frames && !m.seen(last + 1, i)) ++last;
      out.push_back({i, f, last});
      f = last;
    }
  }
  return out;
}

int remove_spikes(MarkerMotion& m, double limit) {
  int count = 0;
  std::vector<double> jumps, sorted;
  for (int i = 0; i < m.marker_count(); ++i) {
    jumps.assign(static_cast<std::size_t>(m.frames), 0);
    for (int f = 1; f + 1 < m.frames; ++f)
      if (m.seen(f - 1, i) && m.seen(f, i) && m.seen(f + 1, i))
        jumps[static_cast<std::size_t>(f)] = norm(m.at(f, i) - (m.at(f - 1, i) + m.at(f + 1, i)) * 0.5);
    sorted = jumps;
    if (sorted.empty()) continue;
    const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
    std::nth_element(sorted.begin(), middle, sorted.end());
    const double threshold = std::max(limit, 6 * *middle);
    for (int f = 1; f + 1 < m.frames; ++f) {
      const double jump = jumps[static_cast<std::size_t>(f)];
      // A spike also displaces the midpoints of its neighbours by half its height, so only the largest of the three is removed.
      if (jump <= threshold || jump < jumps[static_cast<std::size_t>(f - 1)] || jump < jumps[static_cast<std::size_t>(f + 1)]) continue;
      m.positions[m.index(f, i)] = {};
      m.residuals[m.index(f, i)] = -1;
      ++count;
    }
  }
  return count;
}

int fill_short_gaps(MarkerMotion& m, double longest) {
  int count = 0;
  for (const MarkerGap& gap : find_gaps(m)) {
    if (gap.first == 0 || gap.last + 1 == m.frames || (gap.last - gap.first + 1) / m.rate > longest) continue;
    const int a = gap.first - 1, b = gap.last + 1;
    const Vec3 xa = m.at(a, gap.marker), xb = m.at(b, gap.marker);
    const Vec3 da = slope(m, gap.marker, a), db = slope(m, gap.marker, b);
    for (int f = gap.first; f <= gap.last; ++f) {
      put(m, f, gap.marker, hermite(xa, da, xb, db, b - a, static_cast<double>(f - a) / (b - a)));
      ++count;
    }
  }
  return count;
}

int fill_gaps_by_neighbours(MarkerMotion& m, double rigid) {
  int count = 0;
  const MarkerMotion measured = m;
  std::vector<std::vector<int>> neighbours(m.labels.size());
  for (const MarkerGap& gap : find_gaps(measured)) {
    auto& others = neighbours[static_cast<std::size_t>(gap.marker)];
    if (others.empty()) others = rigid_neighbours(measured, gap.marker, rigid);
    if (others.size() < 3) continue;
    const bool before = gap.first > 0, after = gap.last + 1 < m.frames;
    for (int f = gap.first; f <= gap.last; ++f) {
      Vec3 from_before, from_after;
      const bool has_before = before && carry(measured, gap.marker, others, gap.first - 1, f, from_before);
      const bool has_after = after && carry(measured, gap.marker, others, gap.last + 1, f, from_after);
      if (!has_before && !has_after) continue;
      const double t = static_cast<double>(f - gap.first + 1) / (gap.last - gap.first + 2);
      put(m, f, gap.marker, !has_before ? from_after : !has_after ? from_before : from_before * (1 - t) + from_after * t);
      ++count;
    }
  }
  return count;
}

double choose_cutoff(const MarkerMotion& m, const std::function<bool()>& cancelled) {
  const double highest = m.rate / 4;
  if (!(highest > 5) || m.frames < 20) return 0;
  // White noise: at high cut-offs the residual grows linearly as the cut-off falls. The line through two high cut-offs, extrapolated to
  // 0 Hz, estimates the noise. At the cut-off whose residual equals this value, remaining noise and lost signal are balanced.
  double count = 0;
  const auto residual = [&](double cutoff) {
    if (cancelled && cancelled()) return 0.0;
    const double squares = removed(m, cutoff, count);
    return count > 0 ? std::sqrt(squares / count) : 0;
  };
  const double f1 = 0.7 * highest, f2 = highest, r1 = residual(f1), r2 = residual(f2);
  const double noise = r1 + (r1 - r2) / (f2 - f1) * f1;
  double low = std::min(4.0, highest), high = f1;
  if (residual(low) <= noise) return low;
  for (int i = 0; i < 12; ++i) {
    const double middle = 0.5 * (low + high);
    (residual(middle) > noise ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

void filter_markers(MarkerMotion& m, double cutoff) {
  if (!(cutoff > 0 && cutoff < m.rate / 3)) return;
  std::vector<double> row;
  for (int i = 0; i < m.marker_count(); ++i) {
    for (int first = 0; first < m.frames; ++first) {
      if (!m.seen(first, i)) continue;
      int last = first;
      while (last + 1 < m.frames && m.seen(last + 1, i)) ++last;
      const int n = last - first + 1;
      const int pad = std::min(n - 1, static_cast<int>(2 * m.rate / cutoff) + 1);
      for (int c = 0; n >= 4 && c < 3; ++c) {
        const auto at = [&](int k) { return m.at(first + k, i)[c]; };
        row.resize(static_cast<std::size_t>(n + 2 * pad));
        for (int k = 0; k < n + 2 * pad; ++k) {
          const int f = k - pad;
          row[static_cast<std::size_t>(k)] = f < 0 ? 2 * at(0) - at(-f) : f < n ? at(f) : 2 * at(n - 1) - at(2 * n - 2 - f);
        }
        filter_both_ways(row, m.rate, cutoff);
        for (int k = 0; k < n; ++k) m.positions[m.index(first + k, i)][c] = row[static_cast<std::size_t>(k + pad)];
      }
      first = last;
    }
  }
}

}  // namespace ugoki
