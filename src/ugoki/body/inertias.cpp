// Mass properties of the links of a human body from de Leva's segments.

#include <algorithm>

#include "ugoki/body/build.h"
#include "ugoki/body/segments.h"

namespace ugoki::body {
namespace {

constexpr double neck_share = 0.22;       // mass of the neck as a share of the mass of head and neck
constexpr double shoulder_share = 0.008;  // share of the body's mass, moved from the upper trunk to each shoulder link
constexpr double toes_share = 0.17;       // mass of the toes as a share of the foot's mass
constexpr double thumb_share = 0.08;      // mass of the thumb as a share of the hand's mass
constexpr double palm_share = 0.62;       // mass of the palm as a share of the hand's mass without the thumb
constexpr double hand_length = 0.108;     // share of the height, wrist to fingertip (Drillis and Contini 1966)
constexpr double min_moment = 3e-5;       // kg m^2 about each axis, for 70 kg: smaller moments would make the mass matrix ill-conditioned

std::size_t at(int i) { return static_cast<std::size_t>(i); }

Vec3 mirrored(const Vec3& v) { return {v.x, -v.y, v.z}; }
Inertia mirrored(const Inertia& i) { return {i.mass, mirrored(i.h), {i.I.xx, i.I.yy, i.I.zz, -i.I.xy, i.I.xz, -i.I.yz}}; }

/// Inertia of a body of revolution about the unit vector u. @param across2, along2 m^2, squared radii of gyration across and along u
Inertia round_inertia(double mass, const Vec3& centre, const Vec3& u, double across2, double along2) {
  const Sym3 uu{u.x * u.x, u.y * u.y, u.z * u.z, u.x * u.y, u.x * u.z, u.y * u.z};
  const Sym3 one{1, 1, 1, 0, 0, 0};
  return Inertia::from_centre(mass, centre, (one * across2 + uu * (along2 - across2)) * mass);
}
/// Inertia of a box with the given edge lengths [m] along the columns of R.
Inertia box_inertia(double mass, const Vec3& centre, const Vec3& edges, const Mat3& R) {
  const double x = edges.x * edges.x, y = edges.y * edges.y, z = edges.z * edges.z;
  return Inertia::from_centre(mass, centre, rotated(Sym3{mass * (y + z) / 12, mass * (x + z) / 12, mass * (x + y) / 12, 0, 0, 0}, R));
}

/// Distributes the segments' mass properties over the links of one body.
class Distributor {
 public:
  Distributor(const Build& build, Sex sex)
      : b_(build),
        a_(build.anatomy),
        t_(segment_table(sex)),
        wide2_(build.breadth * build.breadth),
        s2_(build.height * build.height / (1.75 * 1.75)),
        out_(a_.p.size()) {}

  std::vector<Inertia> run() {
    trunk();
    head_and_neck();
    for (const int side : {1, -1}) {
      limb(Part::thigh, side, t_.thigh);
      limb(Part::shank, side, t_.shank);
      foot(side);
      limb(Part::upper_arm, side, t_.upper_arm);
      limb(Part::forearm, side, t_.forearm);
      hand(side);
      for (const int i : joints_of(Part::shoulder, side))
        if (i == joints_of(Part::shoulder, side).front()) {
          const Vec3 bone = a_.symmetric_bone(i);
          put(i, round_inertia(shoulder_share, bone * 0.6, normalized(bone, {0, 1, 0}), dot(bone, bone) / 16 + 0.0006 * s2_, 0.001 * s2_));
        }
    }
    // Copy the left side to the right, so that both sides are bitwise equal.
    for (std::size_t i = 0; i < out_.size(); ++i)
      if (a_.mirror[i] >= 0 && a_.parts[i].side > 0) out_[at(a_.mirror[i])] = mirrored(out_[i]);
    double sum = 0;
    for (const Inertia& i : out_) sum += i.mass;
    const double scale = b_.mass / sum;
    for (Inertia& i : out_) {
      i = {i.mass * scale, i.h * scale, i.I * scale};
      if (i.mass <= 0) continue;
      const Sym3 c = i.about_centre();
      const double lack = std::max(0.0, min_moment * std::min(1.0, 4 * s2_) * b_.mass / 70 - std::min({c.xx, c.yy, c.zz}));
      i.I = i.I + Sym3{lack, lack, lack, 0, 0, 0};
    }
    return std::move(out_);
  }

 private:
  void put(int joint, const Inertia& inertia) { out_[at(joint)] += inertia; }

  /// Joints of one part on one side, from the trunk outwards.
  [[nodiscard]] std::vector<int> joints_of(Part part, int side) const {
    std::vector<int> joints;
    for (std::size_t i = 0; i < a_.parts.size(); ++i)
      if (a_.parts[i].part == part && a_.parts[i].side == side) joints.push_back(static_cast<int>(i));
    return joints;
  }

  void trunk() {
    const std::vector<double> z = trunk_heights(b_);
    struct Slice {
      const Segment* segment;
      double bottom, top;  // share of the trunk's height
    };
    const double total = t_.lower_trunk.length + t_.middle_trunk.length + t_.upper_trunk.length;
    const double low = t_.lower_trunk.length / total, mid = low + t_.middle_trunk.length / total;
    const Slice slices[3] = {{&t_.lower_trunk, 0, low}, {&t_.middle_trunk, low, mid}, {&t_.upper_trunk, mid, 1}};
    const double bottom = z.front(), height = z.back() - z.front();
    const double front_low = 0.5 * (a_.p[at(a_.legs[0].proximal)].x + a_.p[at(a_.legs[1].proximal)].x);
    const double front_high = 0.5 * (a_.p[at(a_.arms[0].proximal)].x + a_.p[at(a_.arms[1].proximal)].x);
    double shoulders = 0;
    for (const int side : {1, -1}) shoulders += joints_of(Part::shoulder, side).empty() ? 0 : shoulder_share;
    for (std::size_t k = 0; k < a_.trunk.size(); ++k) {
      // A joint that is no lower than the next one gets a thin slice: without mass, it could turn about its bone without any inertia.
      const double thin = z[k + 1] > z[k] ? 0 : 0.01 * height;
      for (const Slice& s : slices) {
        const double from = std::max(z[k] - thin, bottom + s.bottom * height);
        const double to = std::min(z[k + 1] + thin, bottom + s.top * height);
        if (to <= from) continue;
        double mass = s.segment->mass * (to - from) / ((s.top - s.bottom) * height);
        if (s.segment == &t_.upper_trunk) mass *= 1 - shoulders / s.segment->mass;
        // Elliptic cylinder with the segment's radii of gyration; semi-axes a (forward) and b (sideways).
        const double l2 = s.segment->length * b_.height * s.segment->length * b_.height * wide2_;
        const double sag = s.segment->sagittal * s.segment->sagittal * l2, tra = s.segment->transverse * s.segment->transverse * l2;
        const double lon = s.segment->longitudinal * s.segment->longitudinal * l2;
        const double b2 = 2 * (lon + sag - tra), a2 = 2 * (lon - sag + tra), h2 = (to - from) * (to - from);
        const double middle = 0.5 * (from + to), along = (middle - bottom) / height;
        const Vec3 centre = {front_low + along * (front_high - front_low), 0, middle};
        const Vec3 own = {a_.p[at(a_.trunk[k])].x, a_.p[at(a_.trunk[k])].y, a_.p[at(a_.trunk[k])].z};
        Vec3 offset = centre - own;
        offset.y = 0;
        put(a_.trunk[k],
            Inertia::from_centre(mass, offset, Sym3{mass * (b2 / 4 + h2 / 12), mass * (a2 / 4 + h2 / 12), mass * (a2 + b2) / 4, 0, 0, 0}));
      }
    }
  }

  void head_and_neck() {
    const double s = b_.height / 1.741;
    const int head = a_.neck.back();
    const double top = head_top(b_);
    const double neck_mass = a_.neck.size() > 1 ? neck_share * t_.head.mass : 0;
    const double drop = a_.neck.size() > 1 ? 0.112 * s : t_.head.centre * t_.head.length * b_.height;
    const Vec3 centre = {0.012 * s, 0, top - drop - a_.p[at(head)].z};
    const double m = t_.head.mass - neck_mass;
    const double x = 0.068 * s, y = 0.072 * s, z = 0.060 * s;
    put(head, Inertia::from_centre(m, centre, Sym3{m * x * x, m * y * y, m * z * z, 0, 0, 0}));
    double length = 0;
    for (std::size_t k = 0; k + 1 < a_.neck.size(); ++k) length += norm(a_.p[at(a_.neck[k + 1])] - a_.p[at(a_.neck[k])]);
    if (length <= 0 && neck_mass > 0) put(a_.neck.front(), round_inertia(neck_mass, {}, {0, 0, 1}, 0.002 * s2_, 0.0016 * s2_));
    for (std::size_t k = 0; length > 0 && k + 1 < a_.neck.size(); ++k) {
      const Vec3 bone = a_.p[at(a_.neck[k + 1])] - a_.p[at(a_.neck[k])];
      const double l = norm(bone), r2 = 0.0016 * s2_ * wide2_;
      if (l > 0) put(a_.neck[k], round_inertia(neck_mass * l / length, bone * 0.5, bone / l, r2 + l * l / 12, 2 * r2));
    }
  }

  /// Puts a segment on the joints of a part. One joint gets the table's values. Several joints get slices of a bar with linearly varying
  /// density, so that total mass, centre of mass and moment about the long axis equal the table's.
  void limb(Part part, int side, const Segment& s) {
    std::vector<int> joints;
    std::vector<double> ends = {0};
    for (const int i : joints_of(part, side)) {
      const double l = norm(a_.symmetric_bone(i));
      const int parent_in_part = joints.empty() ? -1 : joints.back();
      const bool on_path = joints.empty() || norm(a_.p[at(i)] - a_.p[at(parent_in_part)] - a_.bone[at(parent_in_part)]) < 1e-9;
      if (l <= 0 || !on_path) continue;
      joints.push_back(i);
      ends.push_back(ends.back() + l);
    }
    if (joints.empty()) return;
    const double length = ends.back();
    const double across = 0.5 * (s.sagittal * s.sagittal + s.transverse * s.transverse), along = s.longitudinal * s.longitudinal;
    if (joints.size() == 1) {
      const Vec3 bone = a_.symmetric_bone(joints[0]);
      put(joints[0], round_inertia(s.mass, bone * s.centre, bone / length, across * length * length, along * length * length));
      return;
    }
    const double tilt = std::clamp(12 * (s.centre - 0.5), -1.8, 1.8);  // density 1 + tilt (x - 1/2), x in [0, 1]
    const double spread = 1.0 / 12 - (tilt / 12) * (tilt / 12);
    const double own2 = std::max(across - spread, 0.5 * along) * length * length;
    for (std::size_t k = 0; k < joints.size(); ++k) {
      const double x0 = ends[k] / length, x1 = ends[k + 1] / length;
      const auto moment = [&](int n) {  // integral of x^n (1 + tilt (x - 1/2))
        const auto power = [&](double x, int e) {
          double r = 1;
          for (int c = 0; c < e; ++c) r *= x;
          return r;
        };
        return (1 - tilt / 2) * (power(x1, n + 1) - power(x0, n + 1)) / (n + 1) + tilt * (power(x1, n + 2) - power(x0, n + 2)) / (n + 2);
      };
      const double m = moment(0), c = moment(1) / m, variance = moment(2) / m - c * c;
      const Vec3 u = a_.symmetric_bone(joints[k]) / (ends[k + 1] - ends[k]);
      put(joints[k], round_inertia(s.mass * m, u * ((c - x0) * length), u, own2 + variance * length * length, along * length * length));
    }
  }

  /// Mean of both soles, mirrored to the given side (1 left, -1 right).
  [[nodiscard]] SoleShape symmetric_sole(int side) const {
    SoleShape out = b_.soles[side > 0 ? 0 : 1];
    const SoleShape &l = b_.soles[0], &r = b_.soles[1];
    const auto mean = [&](const Vec3& left, const Vec3& right) {
      const Vec3 m = (left + mirrored(right)) * 0.5;
      return side > 0 ? m : mirrored(m);
    };
    out.foot_up = normalized(mean(l.foot_up, r.foot_up));
    out.foot_forward = normalized(mean(l.foot_forward, r.foot_forward));
    out.toes_up = normalized(mean(l.toes_up, r.toes_up));
    out.toes_forward = normalized(mean(l.toes_forward, r.toes_forward));
    out.ball = mean(l.ball, r.ball);
    out.tip = 0.5 * (l.tip + r.tip);
    out.heel = 0.5 * (l.heel + r.heel);
    out.thickness = 0.5 * (l.thickness + r.thickness);
    out.ankle = 0.5 * (l.ankle + r.ankle);
    return out;
  }

  void foot(int side) {
    const SoleShape s = symmetric_sole(side);
    const auto frame = [](const Vec3& forward, const Vec3& up) {
      const Vec3 y = normalized(cross(up, forward));
      return Mat3::columns(cross(y, up), y, up);
    };
    const bool toes = s.toes >= 0;
    const double ball = dot(s.ball, s.foot_forward), rear = s.heel + ball, length = rear + s.tip;
    const double share = toes ? toes_share : 0;
    // Centre of the rear foot, m along the ground from the heel: foot and toes together have the table's centre of mass.
    const double centre = (t_.foot.centre * length - share * (rear + 0.5 * s.tip)) / (1 - share);
    const double width = 0.045 * b_.height, height = 0.75 * s.ankle;
    const Vec3 c = s.foot_forward * (centre - s.heel) - s.foot_up * (0.55 * s.ankle);
    put(s.foot,
        box_inertia(t_.foot.mass * (1 - share), c, {0.85 * (toes ? rear : length), width, height}, frame(s.foot_forward, s.foot_up)));
    if (toes)
      put(s.toes, box_inertia(t_.foot.mass * share, s.toes_forward * (0.45 * s.tip) - s.toes_up * (0.4 * s.thickness),
                              {s.tip, 1.1 * width, s.thickness}, frame(s.toes_forward, s.toes_up)));
  }

  void hand(int side) {
    std::vector<int> joints = joints_of(Part::hand, side);
    const std::vector<int> fingers = joints_of(Part::fingers, side), thumbs = joints_of(Part::thumb, side);
    joints.insert(joints.end(), fingers.begin(), fingers.end());
    if (joints.empty()) {  // the arm ends at the wrist: the forearm's link gets the hand's mass
      const std::vector<int> forearm = joints_of(Part::forearm, side);
      const Vec3 bone = a_.symmetric_bone(forearm.back());
      const double l = 0.5 * hand_length * b_.height;
      put(forearm.back(), round_inertia(t_.hand.mass, bone + normalized(bone) * (0.8 * l), normalized(bone), l * l / 3, 0.0008 * s2_));
      return;
    }
    // The palm is the first joint whose bone is longer than 0.006 of the height.
    std::size_t palm = 0;
    while (palm + 1 < joints.size() && norm(a_.symmetric_bone(joints[palm])) < 0.006 * b_.height) ++palm;
    const double length = hand_length * b_.height;
    double left_over = t_.hand.mass;
    if (!thumbs.empty()) {
      const double m = thumb_share * t_.hand.mass / static_cast<double>(thumbs.size());
      for (const int i : thumbs) {
        const Vec3 bone = a_.symmetric_bone(i);
        put(i, round_inertia(m, bone * 0.5, normalized(bone), dot(bone, bone) / 12 + 3e-5 * s2_, 6e-5 * s2_));
      }
      left_over *= 1 - thumb_share;
    }
    const std::size_t finger_count = joints.size() - palm - 1;
    const double palm_mass = finger_count > 0 ? palm_share * left_over : left_over;
    const Vec3 bone = a_.symmetric_bone(joints[palm]);
    const Vec3 u = normalized(bone, {0, side > 0 ? 1.0 : -1.0, 0});
    const double l = finger_count > 0 ? 0.55 * length : length;
    put(joints[palm], round_inertia(palm_mass, u * (0.5 * l), u, l * l / 12 + 0.0003 * s2_, 0.0006 * s2_));
    for (std::size_t k = palm + 1; k < joints.size(); ++k) {
      const Vec3 f = a_.symmetric_bone(joints[k]);
      const double fl = std::max(norm(f), 0.45 * length / static_cast<double>(finger_count));
      put(joints[k], round_inertia((left_over - palm_mass) / static_cast<double>(finger_count), normalized(f, u) * (0.5 * fl),
                                   normalized(f, u), fl * fl / 12 + 0.0001 * s2_, 0.0003 * s2_));
    }
  }

  const Build& b_;
  const Anatomy& a_;
  SegmentTable t_;
  double wide2_;
  double s2_;  // squared ratio of the height to 1.75 m; radii of gyration below are those of a person of 1.75 m
  std::vector<Inertia> out_;
};

}  // namespace

std::vector<double> trunk_heights(const Build& build) {
  const Anatomy& a = build.anatomy;
  const double hips = 0.5 * (a.p[at(a.legs[0].proximal)].z + a.p[at(a.legs[1].proximal)].z);
  const double shoulders = 0.5 * (a.p[at(a.arms[0].proximal)].z + a.p[at(a.arms[1].proximal)].z);
  std::vector<double> z;
  bool first = true;
  for (const int i : a.trunk) {
    double at_joint = hips;
    if (a.parts[at(i)].part == Part::trunk) {
      at_joint = std::max(a.p[at(i)].z, first ? hips + 0.045 * build.height : hips);
      first = false;
    }
    z.push_back(z.empty() ? hips : std::max(z.back(), at_joint));
  }
  z.push_back(std::max({a.p[at(a.neck.front())].z, shoulders + 0.03 * build.height, z.back() + 0.02 * build.height}));
  return z;
}

double head_top(const Build& build) {
  const Anatomy& a = build.anatomy;
  const int head = a.neck.back();
  const double end = a.p[at(head)].z + a.bone[at(head)].z;
  const double neck = trunk_heights(build).back();
  // A head measures 0.13 of the height. Skeletons differ in the position of the head joint, from the base of the skull to the nose.
  return std::max({end, a.p[at(head)].z + 0.05 * build.height, neck + 0.135 * build.height});
}

std::vector<Inertia> human_inertias(const Build& build, Sex sex) { return Distributor(build, sex).run(); }

}  // namespace ugoki::body
