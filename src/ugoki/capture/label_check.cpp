#include "ugoki/capture/label_check.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "ugoki/capture/calibrate.h"
#include "ugoki/capture/model.h"

namespace ugoki::capture {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

/// Distances in the sampled frames, and the cost of assigning model markers to columns.
class Check {
 public:
  Check(const MarkerSet& set, const std::vector<int>& match, const MarkerMotion& motion) : set_(set), match_(match), motion_(motion) {
    std::vector<int> identity(set.markers.size());
    for (std::size_t i = 0; i < identity.size(); ++i) identity[i] = static_cast<int>(i);
    const Subject model = make_subject(set, identity, 1);
    calc_kinematics(model, model.rest(), k_);
    for (std::size_t i = 0; i < identity.size(); ++i) rest_.push_back(marker_position(model, k_, i));
    size_ = estimate_size(set, match, motion);
    const int stride = std::max(1, motion.frames / max_frames);
    for (int f = 0; f < motion.frames; f += stride) frames_.push_back(f);
  }

  LabelCheck run() {
    LabelCheck out;
    if (!(size_ > 1e-3 && size_ < 1e3)) return out;
    std::vector<Exchange> groups;
    for (const auto& parts : {std::vector<std::string>{"UpLeg", "Leg", "Foot", "ToeBase"},
                              {"Leg", "Foot", "ToeBase"},
                              {"Foot", "ToeBase"},
                              {"Shoulder", "Arm", "ForeArm", "Hand"},
                              {"Arm", "ForeArm", "Hand"},
                              {"ForeArm", "Hand"},
                              {"Hand"}})
      groups.push_back(mirror_exchange([&](const std::string& segment) {
        return std::ranges::any_of(parts, [&](const std::string& p) { return segment == "Left" + p || segment == "Right" + p; });
      }));
    for (int round = 0; round < max_exchanges; ++round) {
      Exchange best;
      double gain = 0;
      const auto consider = [&](const Exchange& e) {
        const double before = cost_of(e);
        apply(e);
        const double after = cost_of(e);
        apply(e);
        // An exchange of more labels is less likely.
        const double g = before - after - min_gain * std::sqrt(static_cast<double>(e.size()));
        if (after > max_left * before || g <= gain || !improves_everywhere(e)) return;
        gain = g;
        best = e;
      };
      for (const Exchange& e : groups)
        if (!e.empty()) consider(e);
      for (int a = 0; a < columns(); ++a)
        for (int b = 0; b < a; ++b)
          if (match_[at(a)] >= 0 && match_[at(b)] >= 0) consider({{a, b}});
      if (best.empty()) break;
      apply(best);
      out.pairs.insert(out.pairs.end(), best.begin(), best.end());
    }
    out.mirrored = is_mirrored();  // last: one wrong label far from its place can turn the trunk into its mirror image
    return out;
  }

 private:
  using Exchange = std::vector<std::pair<int, int>>;
  static constexpr int max_frames = 60, max_exchanges = 8;
  static constexpr double min_gain = 7;    // cost that one exchange has to save: a pair of markers at 2.6 standard deviations
  static constexpr double max_left = 0.6;  // share of the cost of the exchanged markers that may remain
  static constexpr double worst = 25;      // cost of a pair at five standard deviations; wrong labels can be farther off

  [[nodiscard]] int columns() const { return motion_.marker_count(); }
  [[nodiscard]] const ModelMarker& marker(int column) const { return set_.markers[at(match_[at(column)])]; }
  void apply(const Exchange& e) {
    for (const auto& [a, b] : e) std::swap(match_[at(a)], match_[at(b)]);
  }

  /// Exchange of the columns of the same markers on both sides, for the segments that `chosen` accepts.
  template <class Chosen>
  [[nodiscard]] Exchange mirror_exchange(const Chosen& chosen) const {
    Exchange out;
    for (int a = 0; a < columns(); ++a)
      if (const int b = opposite_column(set_, match_, a); b >= 0 && b < a && chosen(set_.segments[at(marker(a).segment)].name))
        out.emplace_back(a, b);
    return out;
  }

  /// True if an exchange improves the distances in each quarter of the recording. Labels can be exchanged in a part only.
  [[nodiscard]] bool improves_everywhere(const Exchange& e) {
    constexpr std::size_t parts = 4;
    const std::vector<int> all = frames_;
    bool improves = true;
    for (std::size_t k = 0; k < parts && improves; ++k) {
      frames_.assign(all.begin() + static_cast<std::ptrdiff_t>(all.size() * k / parts),
                     all.begin() + static_cast<std::ptrdiff_t>(all.size() * (k + 1) / parts));
      const double before = cost_of(e);
      apply(e);
      improves = cost_of(e) <= before;
      apply(e);
    }
    frames_ = all;
    return improves;
  }

  /// Cost of the distance of two columns, per frame at most `worst`; 0 if their segments are not adjacent or they are not seen together.
  [[nodiscard]] double pair_cost(int a, int b) const {
    const ModelMarker &ma = marker(a), &mb = marker(b);
    const int sa = ma.segment, sb = mb.segment;
    const auto parent = [&](int s) { return set_.segments[at(s)].parent; };
    const int joint = sa == sb ? -1 : parent(sa) == sb ? sa : parent(sb) == sa ? sb : -2;
    if (joint == -2) return 0;
    const Vec3 pa = rest_[at(match_[at(a)])], pb = rest_[at(match_[at(b)])];
    double low = norm(pa - pb) * size_, high = low;
    if (joint >= 0) {
      const double da = norm(pa - k_.p[at(joint)]) * size_, db = norm(pb - k_.p[at(joint)]) * size_;
      low = std::fabs(da - db);
      high = da + db;
    }
    // Placement, proportions of the subject, and movement of the skin. Distances within a cluster are unknown, but constant.
    const double place = size_ * std::sqrt(ma.sigma * ma.sigma + mb.sigma * mb.sigma) + 0.01 * size_ + 0.08 * high;
    double sum = 0, mean = 0, squares = 0;
    int count = 0;
    for (const int f : frames_) {
      if (!motion_.seen(f, a) || !motion_.seen(f, b)) continue;
      const double d = norm(motion_.at(f, a) - motion_.at(f, b));
      const double off = std::max({0.0, low - d, d - high}) / place;
      sum += std::min(worst, off * off);
      mean += d;
      squares += d * d;
      ++count;
    }
    if (count == 0) return 0;
    mean /= count;
    double cost = sum / count;
    if (joint == -1) cost += std::min(worst, std::max(0.0, squares / count - mean * mean) / (rigid * rigid * size_ * size_));
    return cost;
  }
  static constexpr double rigid = 0.02;  // m, standard deviation of a distance on one segment, mostly of the skin

  /// Cost of all pairs with one of the columns of an exchange.
  [[nodiscard]] double cost_of(const Exchange& e) const {
    std::vector<char> in(at(columns()), 0);
    for (const auto& [a, b] : e) in[at(a)] = in[at(b)] = 1;
    double sum = 0;
    for (int a = 0; a < columns(); ++a) {
      if (in[at(a)] == 0 || match_[at(a)] < 0) continue;
      for (int b = 0; b < columns(); ++b)
        if (b != a && match_[at(b)] >= 0 && (in[at(b)] == 0 || b < a)) sum += pair_cost(a, b);
    }
    return sum;
  }

  /// True if trunk and head are a mirror image of the model in nearly all frames; without markers on them, pelvis and both legs.
  [[nodiscard]] bool is_mirrored() const {
    constexpr double mostly = 0.9, flat = 1e-4;
    const auto central = [&](int column) {
      const std::string& name = set_.segments[at(marker(column).segment)].name;
      return name.ends_with("Shoulder") || (!name.starts_with("Left") && !name.starts_with("Right"));
    };
    const auto of_legs = [&](int column) {
      const std::string& name = set_.segments[at(marker(column).segment)].name;
      return central(column) || name.ends_with("Leg") || name.ends_with("Foot") || name.ends_with("ToeBase");
    };
    // Legs that stand and walk have nearly the shape of the model at rest.
    constexpr std::ptrdiff_t fewest = 6;
    std::vector<int> labelled;
    for (int c = 0; c < columns(); ++c)
      if (match_[at(c)] >= 0) labelled.push_back(c);
    const bool person = std::ranges::any_of(set_.segments, [](const ModelSegment& s) { return s.name == "LeftUpLeg"; });
    const bool legs_only = person && std::ranges::count_if(labelled, central) < fewest;
    int count = 0, mirrored = 0;
    for (const int f : frames_) {
      std::vector<int> used;
      Vec3 own, model;
      for (const int c : labelled)
        if ((legs_only ? of_legs(c) : central(c)) && motion_.seen(f, c)) used.push_back(c);
      if (std::ssize(used) < (legs_only ? 2 * fewest : fewest)) continue;
      for (const int c : used) {
        own += motion_.at(f, c) / static_cast<double>(used.size());
        model += rest_[at(match_[at(c)])] / static_cast<double>(used.size());
      }
      Vec3 columns[3];
      double spread_own = 0, spread_model = 0;
      for (const int c : used) {
        const Vec3 a = motion_.at(f, c) - own, b = rest_[at(match_[at(c)])] - model;
        for (int k = 0; k < 3; ++k) columns[k] += a * b[k];
        spread_own += dot(a, a);
        spread_model += dot(b, b);
      }
      const double scale = std::sqrt(spread_own * spread_model);
      const double handed = dot(columns[0], cross(columns[1], columns[2])) / (scale * scale * scale);
      ++count;
      mirrored += handed < -flat ? 1 : 0;
    }
    return count > 0 && mirrored >= mostly * count;
  }

  const MarkerSet& set_;
  std::vector<int> match_;  // [columns] as corrected so far
  const MarkerMotion& motion_;
  Kinematics k_;            // of the model at rest
  std::vector<Vec3> rest_;  // [markers of the set] m, at rest
  double size_ = 0;
  std::vector<int> frames_;
};

}  // namespace

int opposite_column(const MarkerSet& set, const std::vector<int>& match, int column) {
  if (match[at(column)] < 0) return -1;
  const auto place = [&](int marker) {
    Vec3 p = set.markers[at(marker)].at;
    for (int s = set.markers[at(marker)].segment; s >= 0; s = set.segments[at(s)].parent) p += set.segments[at(s)].offset;
    return p;
  };
  const Vec3 own = place(match[at(column)]);
  if (std::fabs(own.y) < 1e-6) return -1;
  for (std::size_t b = 0; b < match.size(); ++b)
    if (match[b] >= 0 && norm(place(match[b]) - Vec3{own.x, -own.y, own.z}) < 1e-6) return static_cast<int>(b);
  return -1;
}

LabelCheck check_labels(const MarkerSet& set, const std::vector<int>& match, const MarkerMotion& motion) {
  return Check(set, match, motion).run();
}

}  // namespace ugoki::capture
