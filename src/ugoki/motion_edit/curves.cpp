#include "ugoki/motion_edit/curves.h"

#include <algorithm>
#include <cmath>

#include "ugoki/base/number.h"

namespace ugoki::motion_edit {
namespace {

constexpr double min_key_gap = 1e-6;  // s, minimum time between two keys; the interpolation divides by this time

using Values = std::array<double, 3>;

std::size_t at(int i) { return static_cast<std::size_t>(i); }

Quat quat_at(const double* q) { return {q[0], q[1], q[2], q[3]}; }

struct Hermite {
  const Key &a, &b;
  [[nodiscard]] Values value(double t) const {
    const double h = b.time - a.time, s = (t - a.time) / h, s2 = s * s, s3 = s2 * s;
    Values out{};
    for (std::size_t k = 0; k < 3; ++k)
      out[k] = (2 * s3 - 3 * s2 + 1) * a.value[k] + (s3 - 2 * s2 + s) * h * a.slope_out[k] + (3 * s2 - 2 * s3) * b.value[k] +
               (s3 - s2) * h * b.slope_in[k];
    return out;
  }
  [[nodiscard]] Values slope(double t) const {
    const double h = b.time - a.time, s = (t - a.time) / h, s2 = s * s;
    Values out{};
    for (std::size_t k = 0; k < 3; ++k)
      out[k] = (6 * s2 - 6 * s) / h * (a.value[k] - b.value[k]) + (3 * s2 - 4 * s + 1) * a.slope_out[k] + (3 * s2 - 2 * s) * b.slope_in[k];
    return out;
  }
};

/// One curve, together with the values and slopes of the motion in every animation frame.
struct Channel {
  Curve curve;
  std::vector<Values> value, slope;  // [frames]
  double rate = 0, bound = 0;

  /// Difference between an interpolated and a true value: angle [rad] for rotations, otherwise the norm of the difference [m or rad].
  [[nodiscard]] double error(const Values& made, const Values& true_value) const {
    if (curve.kind == Curve::Kind::rotation) {
      const Quat a = exp_map({made[0], made[1], made[2]}), b = exp_map({true_value[0], true_value[1], true_value[2]});
      return norm(log_map(a.conjugate() * b));
    }
    double sum = 0;
    for (std::size_t k = 0; k < 3; ++k) sum += (made[k] - true_value[k]) * (made[k] - true_value[k]);
    return std::sqrt(sum);
  }
  [[nodiscard]] Key key(int f) const { return {f / rate, value[at(f)], slope[at(f)], slope[at(f)]}; }

  void find_slopes() {
    const int n = static_cast<int>(value.size());
    for (int f = 0; f < n; ++f) {
      const int before = std::max(0, f - 1), after = std::min(n - 1, f + 1);
      Values s{};
      for (std::size_t k = 0; k < 3 && after > before; ++k) s[k] = (value[at(after)][k] - value[at(before)][k]) * rate / (after - before);
      slope.push_back(s);
    }
  }
  void reduce() {
    find_slopes();
    const int n = static_cast<int>(value.size());
    std::vector<std::uint8_t> kept(value.size(), 0);
    kept.front() = kept.back() = 1;
    const bool still = std::all_of(value.begin(), value.end(), [&](const Values& v) { return error(value[0], v) <= bound; });
    if (still) {
      curve.keys = {{0, value[0], {}, {}}};
      return;
    }
    std::vector<std::pair<int, int>> open = {{0, n - 1}};
    while (!open.empty()) {
      const auto [a, b] = open.back();
      open.pop_back();
      if (b - a < 2) continue;
      const Key first = key(a), last = key(b);
      int worst = -1;
      double maximum = bound;
      for (int f = a + 1; f < b; ++f)
        if (const double e = error(Hermite{first, last}.value(f / rate), value[at(f)]); e > maximum) {
          maximum = e;
          worst = f;
        }
      if (worst < 0) continue;
      kept[at(worst)] = 1;
      open.emplace_back(a, worst);
      open.emplace_back(worst, b);
    }
    for (int f = 0; f < n; ++f)
      if (kept[at(f)]) curve.keys.push_back(key(f));
  }
};

/// Appends to c.value the joint's rotation vector in each frame, relative to the mean rotation. Of the equivalent rotation vectors (which
/// differ by full turns), the one closest to the previous frame's vector is used.
void add_rotation(const Motion& motion, const Link& link, int coordinate, Channel& c) {
  const int first = link.q_index + coordinate;
  Quat reference = quat_at(motion.frame(0) + first);
  Vec3 mean;
  for (int f = 0; f < motion.frames; ++f) mean += log_map(reference.conjugate() * quat_at(motion.frame(f) + first)) / motion.frames;
  reference = normalized(reference * exp_map(mean));
  c.curve.reference = reference;
  Vec3 before;
  for (int f = 0; f < motion.frames; ++f) {
    Vec3 r = log_map(reference.conjugate() * quat_at(motion.frame(f) + first));
    const double length = norm(r);
    if (f > 0 && length > 1e-9) {
      const Vec3 axis = r / length;
      r = axis * (length + 2 * pi * std::floor((dot(before, axis) - length) / (2 * pi) + 0.5));
    }
    c.value.push_back({r.x, r.y, r.z});
    before = r;
  }
}

void add_scalars(const Motion& motion, const Link& link, int coordinate, int size, Channel& c) {
  for (int f = 0; f < motion.frames; ++f) {
    Values v{};
    for (int k = 0; k < size; ++k) v[at(k)] = motion.frame(f)[link.q_index + coordinate + k];
    c.value.push_back(v);
  }
}

/// One of the curves that describe a joint: kind, first coordinate within the joint's q, number of components.
struct Part {
  Curve::Kind kind;
  int coordinate, size;
  bool length;  ///< true: values in m; false: values in rad
};
std::vector<Part> parts_of(const Joint& joint) {
  using enum Curve::Kind;
  switch (joint.type) {
    case JointType::fixed: return {};
    case JointType::revolute:
    case JointType::helical: return {{coordinate, 0, 1, false}};
    case JointType::prismatic: return {{coordinate, 0, 1, true}};
    case JointType::cylindrical: return {{coordinate, 0, 1, false}, {coordinate, 1, 1, true}};
    case JointType::universal: return {{coordinate, 0, 1, false}, {coordinate, 1, 1, false}};
    case JointType::planar: return {{coordinate, 0, 1, true}, {coordinate, 1, 1, true}, {coordinate, 2, 1, false}};
    case JointType::spherical: return {{rotation, 0, 3, false}};
    case JointType::floating: return {{location, 0, 3, true}, {rotation, 3, 3, false}};
  }
  return {};
}

Error check_curve(const Mechanism& m, const Curve& c) {
  const std::string location = "curve of link " + c.link;
  const int link = m.find_link(c.link);
  if (link < 0)
    return {ErrorCode::unknown, location, "Mechanism " + m.name() + " has no such link.",
            "Use the mechanism for which the curves were made."};
  const std::vector<Part> parts = parts_of(m.link(link).joint);
  if (std::none_of(parts.begin(), parts.end(),
                   [&](const Part& p) { return p.kind == c.kind && p.coordinate == c.coordinate && p.size == c.size; }))
    return {ErrorCode::structure, location, "The link's joint has no coordinate of this kind.",
            "Use the mechanism for which the curves were made."};
  if (c.keys.empty()) return {ErrorCode::structure, location, "The curve has no key.", "Add at least one key."};
  for (std::size_t i = 0; i < c.keys.size(); ++i) {
    bool finite = std::isfinite(c.keys[i].time);
    for (std::size_t k = 0; k < 3; ++k)
      finite = finite && std::isfinite(c.keys[i].value[k]) && std::isfinite(c.keys[i].slope_in[k]) && std::isfinite(c.keys[i].slope_out[k]);
    if (!finite)
      return {ErrorCode::range, location + ", key " + std::to_string(i), "The time, value or slope of the key is not finite.",
              "Set the key again."};
    if (i > 0 && !(c.keys[i].time > c.keys[i - 1].time))
      return {ErrorCode::structure, location + ", key " + std::to_string(i), "The key is not later than the previous one.",
              "Sort the keys by time."};
  }
  return {};
}

Error no_key(const Curve& c, int key) {
  return {ErrorCode::range, "curve of link " + c.link, "The curve has no key " + std::to_string(key) + ".",
          "Use a key from 0 to " + std::to_string(static_cast<int>(c.keys.size()) - 1) + "."};
}

bool has_key(const Curve& c, int key) { return key >= 0 && key < static_cast<int>(c.keys.size()); }

}  // namespace

std::array<double, 3> Curve::value(double t) const {
  if (t <= keys.front().time) return keys.front().value;
  if (t >= keys.back().time) return keys.back().value;
  const auto b = std::upper_bound(keys.begin(), keys.end(), t, [](double x, const Key& k) { return x < k.time; });
  return Hermite{*(b - 1), *b}.value(t);
}

std::array<double, 3> Curve::slope(double t) const {
  if (t < keys.front().time || t > keys.back().time || keys.size() < 2) return {};
  if (t == keys.back().time) return keys.back().slope_in;
  const auto b = std::upper_bound(keys.begin(), keys.end(), t, [](double x, const Key& k) { return x < k.time; });
  return Hermite{*(b - 1), *b}.slope(t);
}

int MotionCurves::key_count() const {
  int sum = 0;
  for (const Curve& c : curves) sum += static_cast<int>(c.keys.size());
  return sum;
}

int MotionCurves::find(const std::string& link, Curve::Kind kind) const {
  for (std::size_t i = 0; i < curves.size(); ++i)
    if (curves[i].link == link && curves[i].kind == kind) return static_cast<int>(i);
  return -1;
}

// Bounds of the keys: a rotation differs from another by at most 180 degrees; 100 m is far above any useful bound.
constexpr double max_degrees = 180, max_metres = 100;

Result<MotionCurves> reduce_keys(const Mechanism& m, const Motion& motion, const ReduceOptions& o) {
  if (Error wrong = check_motion(motion, m); !wrong.empty()) return fail(std::move(wrong));
  if (!(o.degrees > 0 && o.degrees <= max_degrees) || !(o.metres > 0 && o.metres <= max_metres))
    return fail(ErrorCode::range, "bounds of the keys",
                "The bounds are " + to_text(o.degrees) + " degrees and " + to_text(o.metres) + " m.",
                "Use bounds above 0 and at most 180 degrees and 100 m.");
  MotionCurves out{motion.name, motion.source, m.name(), motion.rate, motion.frames, motion.cyclic, {}, motion.contacts};
  for (const Link& link : m.links())
    for (const Part& part : parts_of(link.joint)) {
      Channel c;
      c.curve.link = link.name;
      c.curve.kind = part.kind;
      c.curve.coordinate = part.coordinate;
      c.curve.size = part.size;
      c.rate = motion.rate;
      c.bound = part.length ? o.metres : o.degrees * pi / 180;
      if (part.kind == Curve::Kind::rotation)
        add_rotation(motion, link, part.coordinate, c);
      else
        add_scalars(motion, link, part.coordinate, part.size, c);
      c.reduce();
      out.curves.push_back(std::move(c.curve));
    }
  return out;
}

Result<Motion> to_motion(const Mechanism& m, const MotionCurves& curves, double rate) {
  Error errors;
  for (const Curve& c : curves.curves) {
    const Error wrong = check_curve(m, c);
    errors.problems.insert(errors.problems.end(), wrong.problems.begin(), wrong.problems.end());
  }
  if (!(curves.rate > 0) || curves.frames < 1 || !(rate >= 0) || !std::isfinite(rate))
    errors.add(ErrorCode::range, "curves " + curves.name, "The curves have no frames or no valid frame rate.",
               "Make the curves from a motion again.");
  if (!errors.empty()) return fail(std::move(errors));
  Motion out;
  out.name = curves.name;
  out.source = curves.source;
  out.mechanism = m.name();
  out.rate = rate > 0 ? rate : curves.rate;
  const double duration = (curves.frames - 1) / curves.rate;
  out.frames = static_cast<int>(std::floor(duration * out.rate + 1e-6)) + 1;
  out.nq = m.nq();
  out.cyclic = curves.cyclic;
  const std::vector<double> neutral = m.neutral();
  for (int f = 0; f < out.frames; ++f) out.q.insert(out.q.end(), neutral.begin(), neutral.end());
  for (const Curve& c : curves.curves) {
    const int first = m.link(m.find_link(c.link)).q_index + c.coordinate;
    for (int f = 0; f < out.frames; ++f) {
      const Values v = c.value(f / out.rate);
      double* q = out.frame(f) + first;
      if (c.kind != Curve::Kind::rotation) {
        std::copy_n(v.data(), c.size, q);
        continue;
      }
      const Quat turn = normalized(c.reference * exp_map({v[0], v[1], v[2]}));
      std::copy_n(std::array{turn.w, turn.x, turn.y, turn.z}.data(), 4, q);
    }
  }
  for (const ContactTrack& track : curves.contacts) {
    if (track.on.empty()) continue;
    ContactTrack own{track.link, {}};
    for (int f = 0; f < out.frames; ++f)
      own.on.push_back(track.on[std::min(track.on.size() - 1, static_cast<std::size_t>(f / out.rate * curves.rate + 0.5))]);
    out.contacts.push_back(std::move(own));
  }
  return out;
}

Result<int> add_key(Curve& c, double t) {
  const auto b = std::lower_bound(c.keys.begin(), c.keys.end(), t, [](const Key& k, double x) { return k.time < x; });
  const bool occupied = (b != c.keys.end() && b->time - t < min_key_gap) || (b != c.keys.begin() && t - (b - 1)->time < min_key_gap);
  if (!std::isfinite(t) || occupied)
    return fail(ErrorCode::duplicate, "curve of link " + c.link,
                "A key cannot be added at " + to_text(t) + " s: the time is not finite, or a key exists there.",
                "Change the existing key, or use another time.");
  const Values slope = c.slope(t);
  const Key key{t, c.value(t), slope, slope};
  return static_cast<int>(c.keys.insert(b, key) - c.keys.begin());
}

Result<void> move_key(Curve& c, int key, double t, const Values& value) {
  if (!has_key(c, key)) return fail(no_key(c, key));
  const bool after = key == 0 || t >= c.keys[at(key - 1)].time + min_key_gap;
  const bool before = key + 1 == static_cast<int>(c.keys.size()) || t <= c.keys[at(key + 1)].time - min_key_gap;
  if (!std::isfinite(t) || !after || !before)
    return fail(ErrorCode::range, "curve of link " + c.link, "Key " + std::to_string(key) + " cannot be moved past its neighbours.",
                "Keep its time between theirs, or delete them first.");
  for (const double x : value)
    if (!std::isfinite(x)) return fail(ErrorCode::range, "curve of link " + c.link, "The new value is not finite.", "Use a finite value.");
  c.keys[at(key)].time = t;
  c.keys[at(key)].value = value;
  return {};
}

Result<void> set_slopes(Curve& c, int key, const Values& in, const Values& out) {
  if (!has_key(c, key)) return fail(no_key(c, key));
  for (const double x : {in[0], in[1], in[2], out[0], out[1], out[2]})
    if (!std::isfinite(x)) return fail(ErrorCode::range, "curve of link " + c.link, "The new slope is not finite.", "Use a finite slope.");
  c.keys[at(key)].slope_in = in;
  c.keys[at(key)].slope_out = out;
  return {};
}

Result<void> delete_key(Curve& c, int key) {
  if (!has_key(c, key)) return fail(no_key(c, key));
  if (c.keys.size() == 1)
    return fail(ErrorCode::structure, "curve of link " + c.link, "The last key of a curve cannot be deleted.", "Move the key instead.");
  c.keys.erase(c.keys.begin() + key);
  return {};
}

}  // namespace ugoki::motion_edit
