// Shapes of the links of a human body, visible and colliding: capsules, and a box for each sole.

#include <algorithm>

#include "ugoki/body/build.h"

namespace ugoki::body {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

/// The shape without collision.
Shape decoration(Shape s) {
  s.collides = false;
  return s;
}

/// Makes the shapes of one joint's link. Radii below are m for a person of 1.75 m and 70 kg; h_ and w_ scale lengths and widths.
class Modeller {
 public:
  Modeller(const Build& build, int joint)
      : b_(build), a_(build.anatomy), i_(joint), h_(build.height / 1.75), w_(h_ * build.breadth), side_(a_.parts[at(joint)].side) {}

  std::vector<Shape> run() {
    switch (a_.parts[at(i_)].part) {
      case Part::pelvis:
      case Part::trunk: trunk(); break;
      case Part::neck: along_bone(0.052, 0.0, 1.0); break;
      case Part::head: head(); break;
      case Part::thigh:
        along_bone(0.062, 0.0, 1.0);
        bulge(0.072, 0.06, 0.42);
        break;
      case Part::shank:
        along_bone(0.046, 0.0, 1.0);
        bulge(0.054, 0.10, 0.38);
        break;
      case Part::foot:
      case Part::toes: sole(); break;
      case Part::shoulder: shoulder(); break;
      case Part::upper_arm:
        along_bone(0.041, 0.0, 1.0);
        bulge(0.049, 0.0, 0.22);
        break;
      case Part::forearm:
        along_bone(0.033, 0.0, 1.0);
        bulge(0.039, 0.04, 0.35);
        break;
      case Part::hand:
      case Part::fingers: hand(); break;
      case Part::thumb: along_bone(0.011, 0.1, 1.0); break;
      default: break;
    }
    return std::move(out_);
  }

 private:
  [[nodiscard]] Vec3 bone() const { return a_.bone[at(i_)]; }
  /// Capsule along the bone between the shares `from` and `to` of its length.
  void along_bone(double radius, double from, double to) {
    if (norm(bone()) > 0.02 * h_) out_.push_back(Shape::capsule(radius * w_, bone() * from, bone() * to));
  }
  /// Visible capsule without collision (a muscle) along the bone between the shares `from` and `to` of its length.
  void bulge(double radius, double from, double to) {
    if (norm(bone()) > 0.1 * h_) out_.push_back(decoration(Shape::capsule(radius * w_, bone() * from, bone() * to)));
  }

  /// Transverse capsules over the link's part of the trunk, narrow at the waist and wide at the chest.
  void trunk() {
    const auto it = std::find(a_.trunk.begin(), a_.trunk.end(), i_);
    if (it == a_.trunk.end()) return;
    const auto k = static_cast<std::size_t>(it - a_.trunk.begin());
    const std::vector<double> z = trunk_heights(b_);
    const Vec3 own = a_.p[at(i_)];
    const Vec3 hip = (a_.p[at(a_.legs[0].proximal)] + a_.p[at(a_.legs[1].proximal)]) * 0.5;
    const Vec3 shoulder = (a_.p[at(a_.arms[0].proximal)] + a_.p[at(a_.arms[1].proximal)]) * 0.5;
    const double height = z.back() - z.front();
    const auto middle = [&](double level) {  // the trunk's axis leans from the hips to the shoulders
      const double t = (level - z.front()) / height;
      return Vec3{hip.x + t * (shoulder.x - hip.x), 0.5 * (hip.y + shoulder.y), level};
    };
    const auto across = [&](double level, double half_width, double radius) {
      const Vec3 c = middle(level) - own, y{0, half_width * w_, 0};
      out_.push_back(Shape::capsule(radius * w_, c - y, c + y));
    };
    if (a_.parts[at(i_)].part == Part::pelvis) {
      if (k + 1 < a_.trunk.size() && a_.parts[at(a_.trunk[k + 1])].part == Part::pelvis) return;  // the last pelvis joint gets the shapes
      const double half = 0.5 * norm(a_.p[at(a_.legs[0].proximal)] - a_.p[at(a_.legs[1].proximal)]) / w_;
      across(z.front() + 0.025 * h_, std::max(0.05, half - 0.012), 0.088);
      across(z.front() + 0.07 * h_, 0.065, 0.088);
      return;
    }
    const double low = z[k], high = z[k + 1];
    const auto half_width = [&](double level) {  // half the trunk's width in m: hips 0.065, waist 0.05, chest 0.085
      const double t = (level - z.front()) / height;
      return t < 0.45 ? 0.05 + 0.015 * (0.45 - t) / 0.45 : 0.05 + 0.035 * std::min(1.0, (t - 0.45) / 0.35);
    };
    const auto depth = [&](double level) {
      const double t = (level - z.front()) / height;
      return 0.078 + 0.014 * std::clamp((t - 0.35) / 0.4, 0.0, 1.0);
    };
    const bool chest = k + 1 == a_.trunk.size();
    const double top = chest ? std::max(low + 0.02 * h_, shoulder.z - 0.045 * h_) : high;
    // Spacing of at most 0.085 m, so that the capsules overlap.
    const int count = std::max(1, static_cast<int>((top - low) / (0.085 * h_) + 0.99));
    for (int c = 0; c < count; ++c) {
      const double level = low + (top - low) * (chest ? (c + 1.0) / count : (c + 0.5) / count);
      across(level, half_width(level), depth(level));
    }
    // Upright capsules fill the grooves between the transverse ones.
    const double bottom = low - 0.01 * h_, middle_level = 0.5 * (low + top);
    for (const double side : {-1.0, 0.0, 1.0}) {
      const Vec3 from = middle(bottom) + Vec3{0, side * half_width(bottom) * w_, 0},
                 to = middle(top) + Vec3{0, side * half_width(top) * w_, 0};
      out_.push_back(decoration(Shape::capsule(0.985 * depth(middle_level) * w_, from - own, to - own)));
    }
    if (chest) {  // slanted capsules for the shoulders
      const Vec3 neck = a_.p[at(a_.neck.front())];
      for (const double s : {1.0, -1.0}) {
        const Vec3 end =
            Vec3{shoulder.x, shoulder.y + s * 0.72 * std::fabs(a_.p[at(a_.arms[0].proximal)].y - shoulder.y), shoulder.z - 0.005 * h_};
        out_.push_back(decoration(
            Shape::capsule(0.052 * w_, Vec3{middle(z.back()).x, neck.y + s * 0.02 * w_, shoulder.z + 0.018 * h_} - own, end - own)));
      }
    }
  }

  void head() {
    const double top = head_top(b_) - a_.p[at(i_)].z;
    const double r = 0.078 * h_, half = 0.036 * h_;
    const Vec3 up{0, 0, 1}, centre = {0.014 * h_, 0, top - r - half};
    out_.push_back(Shape::capsule(r, centre - up * half, centre + up * half));
    // The face: a little narrower, forward and down.
    out_.push_back(decoration(Shape::capsule(0.062 * h_, centre + Vec3{0.022, 0, -0.048} * h_, centre + Vec3{0.024, 0, 0.01} * h_)));
    if (a_.neck.size() == 1) out_.push_back(Shape::capsule(0.052 * w_, {0, 0, 0}, centre - up * half));
  }

  void shoulder() {
    if (std::fabs(bone().y) < 0.05 * h_) return;
    out_.push_back(decoration(Shape::capsule(0.05 * w_, bone() * 0.55, bone() * 0.97)));
  }

  void hand() {
    const Vec3 previous = a_.bone[at(std::max(0, wrist()))];
    const double length = 0.108 * b_.height;
    const bool fingers = a_.parts[at(i_)].part == Part::fingers;
    const bool last = a_.children[at(i_)].empty();
    const double own = norm(bone());
    if (!fingers && own < 0.006 * b_.height && !last) return;  // the palm is on the next joint
    if (fingers && own < 0.006 * b_.height) return;
    const Vec3 u = normalized(bone(), normalized(previous));
    // Distance of this joint from the wrist, m.
    const int w = wrist();
    const double start = w < 0 ? 0 : norm(a_.p[at(i_)] - a_.p[at(w)]);
    const bool palm = !fingers || start < 0.006 * b_.height;
    const double end = last ? std::max(own, length - start) : palm ? std::max(own, 0.5 * length) : own;
    const Vec3 side = normalized(cross(u, Vec3{0, 0, 1}), {1, 0, 0});
    if (palm) {
      for (const double s : {1.0, -1.0})
        out_.push_back(Shape::capsule(0.017 * w_, u * (0.012 * h_) + side * (s * 0.012 * w_),
                                      u * (0.55 * std::max(end, 0.6 * length)) + side * (s * 0.021 * w_)));
      if (last) out_.push_back(Shape::capsule(0.015 * w_, u * (0.4 * end), u * (end - 0.015 * w_)));
    } else {
      for (const double s : {1.0, -1.0})
        out_.push_back(
            Shape::capsule(0.0125 * w_, side * (s * 0.016 * w_), u * std::max(0.01, end - 0.0125 * w_) + side * (s * 0.012 * w_)));
    }
  }
  [[nodiscard]] int wrist() const {
    const Limb& arm = a_.arms[side_ > 0 ? 0 : 1];
    return arm.end >= 0 ? arm.end : arm.distal;
  }

  /// Foot: an invisible box from heel to ball and a round heel bear on the ground; visible capsules touch the same plane. Toes: visible
  /// only.
  void sole() {
    const SoleShape* s = b_.sole_of(i_);
    if (!s) return;
    const bool is_foot = s->foot == i_;
    const auto frame = [](const Vec3& forward, const Vec3& up) {
      const Vec3 y = normalized(cross(up, forward));
      return Mat3::columns(cross(y, up), y, up);
    };
    const double r = std::min(0.034 * h_, 0.9 * s->thickness + 0.008 * h_);
    if (is_foot) {
      const Mat3 R = frame(s->foot_forward, s->foot_up);
      const double ball = dot(s->ball, s->foot_forward), front = s->toes >= 0 ? ball + std::min(0.012 * h_, 0.5 * s->tip) : ball + s->tip;
      const double across = dot(s->ball, R.column(1));
      const double ground = dot(s->ball, s->foot_up) - s->thickness;
      const double height = 0.8 * s->thickness;
      // The heel is round, so that the foot rolls over it at heel strike. Ahead of it the sole is flat.
      const double heel_r = std::min(0.04 * h_, 0.6 * s->ankle);
      const double back = std::max(0.0, s->heel - heel_r - 0.014 * h_);
      Shape box = Shape::box({0.5 * (front + back), 0.040 * w_, 0.5 * height},
                             {R, R * Vec3{0.5 * (front - back), 0.5 * across, ground + 0.5 * height}});
      box.visible = false;
      out_.push_back(box);
      const Vec3 heel{-s->heel + heel_r, 0, ground + heel_r}, sideways{0, 0.016 * w_, 0};
      out_.push_back(Shape::capsule(heel_r, R * (heel - sideways), R * (heel + sideways)));
      for (const double e : {1.0, -1.0})
        out_.push_back(decoration(Shape::capsule(r, R * Vec3{-s->heel + heel_r, e * 0.004 * w_, ground + r},
                                                 R * Vec3{front - 0.3 * r, across + e * 0.018 * w_, ground + r})));
      out_.push_back(decoration(Shape::capsule(0.034 * w_, R * (heel + Vec3{0.004 * h_, 0, 0}), R * Vec3{0.008 * h_, 0, 0})));
      out_.push_back(decoration(
          Shape::capsule(0.030 * w_, R * Vec3{0.012 * h_, 0, -0.01 * h_}, R * Vec3{front - 0.02 * h_, 0.8 * across, ground + 0.032 * w_})));
      return;
    }
    // Toes bear no load: measured toe angles are mostly noise, and rigid toes that follow them lift the foot off the floor.
    const Mat3 R = frame(s->toes_forward, s->toes_up);
    const double t = std::min(0.8 * r, 0.024 * h_);
    for (const double e : {1.0, 0.0, -1.0})
      out_.push_back(decoration(Shape::capsule(t, R * Vec3{0, e * 0.020 * w_, -s->thickness + t},
                                               R * Vec3{s->tip - t - 0.006 * h_ * e * e, e * 0.018 * w_, -s->thickness + t})));
  }

  const Build& b_;
  const Anatomy& a_;
  int i_;
  double h_, w_;
  int side_;
  std::vector<Shape> out_;
};

}  // namespace

std::vector<Shape> human_shapes(const Build& build, int i) { return Modeller(build, i).run(); }

}  // namespace ugoki::body
