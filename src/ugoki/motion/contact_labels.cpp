#include "ugoki/motion/contact_labels.h"

#include <algorithm>

#include "ugoki/mechanism/state.h"

namespace ugoki {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

/// Inverts runs of `value` shorter than `min_length` frames. Runs at the two ends of the motion: only if `ends` is true.
void remove_short_runs(std::vector<std::uint8_t>& on, std::uint8_t value, int min_length, bool ends) {
  const int n = static_cast<int>(on.size());
  for (int from = 0; from < n;) {
    int to = from;
    while (to < n && on[at(to)] == on[at(from)]) ++to;
    const bool inside = from > 0 && to < n;
    if (on[at(from)] == value && to - from < min_length && (inside || ends))
      std::fill(on.begin() + from, on.begin() + to, static_cast<std::uint8_t>(1 - value));
    from = to;
  }
}

}  // namespace

std::vector<SupportPoint> support_points(const Link& link) {
  std::vector<SupportPoint> points;
  for (const Shape& s : link.shapes) {
    if (!s.collides) continue;
    switch (s.type) {
      case ShapeType::sphere: points.push_back({s.X_BS.p, s.radius}); break;
      case ShapeType::capsule:
        for (const double e : {-1.0, 1.0}) points.push_back({s.X_BS * Vec3{0, 0, e * s.half_length}, s.radius});
        break;
      case ShapeType::ellipsoid: {  // inscribed spheres at both ends of the longest axis
        const Vec3 h = s.half_extents;
        const int along = h.x >= h.y && h.x >= h.z ? 0 : h.y >= h.z ? 1 : 2;
        const double r = std::min({h.x, h.y, h.z});
        for (const double e : {-1.0, 1.0}) {
          Vec3 end;
          end[along] = e * (h[along] - r);
          points.push_back({s.X_BS * end, r});
        }
        break;
      }
      case ShapeType::cylinder:
        for (const double e : {-1.0, 1.0})
          for (const Vec3 rim : {Vec3{1, 0, 0}, Vec3{0, 1, 0}, Vec3{-1, 0, 0}, Vec3{0, -1, 0}})
            points.push_back({s.X_BS * Vec3{rim.x * s.radius, rim.y * s.radius, e * s.half_length}, 0});
        break;
      case ShapeType::box:
      case ShapeType::mesh: {  // corners of the bounding box
        const Bounds b = bounds(s);
        for (const double x : {b.low.x, b.high.x})
          for (const double y : {b.low.y, b.high.y})
            for (const double z : {b.low.z, b.high.z}) points.push_back({s.X_BS * Vec3{x, y, z}, 0});
        break;
      }
      case ShapeType::height_field: break;
    }
  }
  return points;
}

std::vector<int> find_feet(const Mechanism& mechanism) {
  std::vector<int> feet;
  const auto collides = [&](int i) { return std::ranges::any_of(mechanism.link(i).shapes, [](const Shape& s) { return s.collides; }); };
  const auto is_paw = [&](int i) { return mechanism.link(i).label.starts_with("paw") && collides(i); };
  for (int i = 0; i < mechanism.link_count(); ++i) {
    const std::string& label = mechanism.link(i).label;
    bool foot = label.starts_with("foot") || label.starts_with("toes") || label.starts_with("paw");
    // An animal whose limbs have three joints stands on its carpus or hock.
    if (label.starts_with("carpus") || label.starts_with("hock")) {
      foot = true;
      for (int d = i + 1; d < mechanism.link_count() && foot; ++d) {
        int up = d;
        while (up > i) up = mechanism.link(up).parent;
        foot = up != i || !is_paw(d);
      }
    }
    if (foot && collides(i)) feet.push_back(i);
  }
  return feet;
}

std::vector<std::uint8_t> find_contact(std::span<const std::vector<Pose>> poses, double rate, std::span<const LinkPoint> places,
                                       const ContactLabelOptions& o) {
  const int frames = static_cast<int>(poses.size());
  const int reach = std::max(1, static_cast<int>(o.span * rate + 0.5));
  std::vector<std::uint8_t> on(poses.size(), 0);
  bool bears = false;
  for (int f = 0; f < frames; ++f) {
    const int before = std::max(0, f - reach), after = std::min(frames - 1, f + reach);
    const double dt = std::max(1, after - before) / rate;
    const double high = bears ? o.height_off : o.height_on, fast = bears ? o.speed_off : o.speed_on;
    bears = std::any_of(places.begin(), places.end(), [&](const LinkPoint& at_link) {
      const SupportPoint& s = at_link.location;
      const auto pose = [&](int frame) -> const Pose& { return poses[at(frame)][at(at_link.link)]; };
      if ((pose(f) * s.p).z - s.radius - o.ground > high) return false;
      // On a rolling sphere the material point that touches the ground is at rest, so measure the speed of the lowest point.
      const Vec3 low = transpose_times(pose(f).R, Vec3{0, 0, -s.radius});
      return norm(pose(after) * (s.p + low) - pose(before) * (s.p + low)) / dt < fast;
    });
    on[at(f)] = bears ? 1 : 0;
  }
  remove_short_runs(on, 0, static_cast<int>(o.min_gap * rate + 0.5), false);
  remove_short_runs(on, 1, static_cast<int>(o.min_contact * rate + 0.5), false);
  return on;
}

std::vector<std::pair<std::size_t, std::size_t>> find_turns(std::span<const std::uint8_t> stands, std::span<const double> yaw_rate,
                                                            double rate) {
  constexpr double min_rate = 0.5, min_angle = 0.35;  // rad/s, rad
  std::vector<std::pair<std::size_t, std::size_t>> out;
  const auto turning = [&](std::size_t f) { return stands[f] && std::fabs(yaw_rate[f]) > min_rate; };
  for (std::size_t f = 0; f < stands.size();) {
    std::size_t to = f;
    double angle = 0;
    for (; to < stands.size() && turning(to) && yaw_rate[to] * yaw_rate[f] > 0; ++to) angle += yaw_rate[to] / rate;
    if (std::fabs(angle) > min_angle) out.emplace_back(f, to);
    f = std::max(to, f + 1);
  }
  return out;
}

void label_contacts(const Mechanism& mechanism, Motion& motion, std::span<const int> links, const ContactLabelOptions& o) {
  motion.contacts.clear();
  std::vector<std::vector<Pose>> poses(at(motion.frames), std::vector<Pose>(at(mechanism.link_count())));
  for (int f = 0; f < motion.frames; ++f) calc_poses(mechanism, std::span(motion.frame(f), at(motion.nq)), poses[at(f)]);
  for (const int link : links) {
    std::vector<LinkPoint> places;
    for (const SupportPoint& s : support_points(mechanism.link(link))) places.push_back({link, s});
    motion.contacts.push_back({mechanism.link(link).name, find_contact(poses, motion.rate, places, o)});
  }
}

void label_contacts(const Mechanism& mechanism, Motion& motion, const ContactLabelOptions& options) {
  label_contacts(mechanism, motion, find_feet(mechanism), options);
}

}  // namespace ugoki
