// The dog's trot and stand. The trot is a gait of two beats: diagonal legs move in phase, and inverse kinematics fixes standing feet to the
// ground. Timing follows Maes et al. (2008, J. exp. Biol. 211, 138-149) for slow trots of dogs of this size: about 1.7 strides per second,
// each foot on the ground for about half of the stride.

#include <algorithm>

#include "ugoki/base/check.h"
#include "ugoki/mechanism/state.h"
#include "ugoki/motion/contact_labels.h"
#include "ugoki/samples/curves.h"
#include "ugoki/samples/dog.h"
#include "ugoki/samples/samples.h"

namespace ugoki::samples {
namespace {

Mat3 about_x(double angle) { return rotation_about({1, 0, 0}, angle); }
Mat3 about_y(double angle) { return rotation_about({0, 1, 0}, angle); }
Mat3 about_z(double angle) { return rotation_about({0, 0, 1}, angle); }

/// Angle [rad] about y of a rotation whose axis is nearly y.
double pitch_of(const Mat3& R) { return atan2(R.xz, R.zz); }
double angle_in_plane(const Vec3& v) { return atan2(v.x, -v.z); }  // angle [rad] from -z to a bone in the x-z plane, positive forwards

/// Target of one leg: position of the knuckle (world, m), and pitch of metapodium and paw relative to the standing position (rad, about
/// y; positive: toes down).
struct Step {
  Vec3 knuckle;
  double metapodium = 0, paw = 0;
};

class Poser {
 public:
  explicit Poser(const Mechanism& dog) : dog_(dog), q_(dog.neutral()) {}

  std::vector<double> take() { return q_; }

  void set(const char* link, const Mat3& R) {
    const Link& l = find(link);
    double* q = q_.data() + l.q_index;
    const Quat r = to_quat(R);
    switch (l.joint.type) {
      case JointType::spherical:
        q[0] = r.w;
        q[1] = r.x;
        q[2] = r.y;
        q[3] = r.z;
        return;
      case JointType::revolute: q[0] = 2 * atan2(dot(r.vec(), l.joint.axis), r.w); return;
      case JointType::universal: {  // about y, then about z
        const Vec3 e = to_euler(R, "YZX");
        q[0] = e.x;
        q[1] = e.y;
        return;
      }
      default: UGOKI_CHECK(false);
    }
  }
  void set_root(const Pose& X) {
    const Vec3 p = X.p - dog_root;  // the coordinates q are relative to the neutral position, in which the root is at dog_root
    const Quat r = to_quat(X.R);
    const double q[7] = {p.x, p.y, p.z, r.w, r.x, r.y, r.z};
    std::copy(q, q + 7, q_.begin());
  }
  [[nodiscard]] Pose pose_of(const char* link) const {
    std::vector<Pose> X(static_cast<std::size_t>(dog_.link_count()));
    calc_poses(dog_, q_, X);
    return X[static_cast<std::size_t>(dog_.find_link(link))];
  }

  void hind_leg(int side, const Step& s) {
    const bool left = side > 0;
    leg(dog_hind, left ? "LeftThigh" : "RightThigh", left ? "LeftShank" : "RightShank", left ? "LeftHock" : "RightHock",
        left ? "LeftHindPaw" : "RightHindPaw", "Pelvis", s, 1);
  }
  /// Sets the joints of a fore leg. @param side +1 left, -1 right @param scapula rad, rotation of the scapula about y
  void fore_leg(int side, const Step& s, double scapula) {
    const bool left = side > 0;
    set(left ? "LeftScapula" : "RightScapula", about_y(scapula));
    leg(dog_fore, left ? "LeftUpperArm" : "RightUpperArm", left ? "LeftForearm" : "RightForearm", left ? "LeftCarpus" : "RightCarpus",
        left ? "LeftForePaw" : "RightForePaw", left ? "LeftScapula" : "RightScapula", s, -1);
  }

 private:
  [[nodiscard]] const Link& find(const char* link) const {
    const int i = dog_.find_link(link);
    UGOKI_CHECK(i >= 0);
    return dog_.link(i);
  }

  void leg(const DogLimb& limb, const char* upper, const char* lower, const char* metapodium, const char* paw, const char* parent,
           const Step& s, int bend) {
    const double l1 = norm(limb.middle - limb.root), l2 = norm(limb.end - limb.middle);
    const Pose X_parent = pose_of(parent);
    const Link& first = find(upper);
    const Vec3 root = X_parent * first.joint.X_PJ.p;
    const double stand1 = angle_in_plane(limb.middle - limb.root), stand2 = angle_in_plane(limb.end - limb.middle);
    // The hinges of the leg move in one nearly vertical plane, which the rotation of the leg's root joint determines. The metapodium's
    // target depends on this plane, so target and leg are solved alternately; five iterations converge.
    Mat3 R3 = about_y(s.metapodium);
    LimbPosture p;
    double fold = 0;
    for (int i = 0; i < 5; ++i) {
      // reach() assumes bones that point straight down at rest; stand1 and stand2 account for the standing angles.
      p = reach(root, s.knuckle - R3 * (limb.knuckle - limb.end), l1, l2, {0, 1, 0}, bend);
      const Mat3 R2 = p.R_upper * about_y(p.flexion + stand2);
      fold = s.metapodium - pitch_of(R2);  // not converged yet: the target may be out of reach
      R3 = R2 * about_y(fold);
    }
    const Mat3 R1 = p.R_upper * about_y(stand1);
    set(upper, X_parent.R.transposed() * R1);
    set(lower, about_y(p.flexion + stand2 - stand1));
    set(metapodium, about_y(fold));
    set(paw, about_y(s.paw - s.metapodium));
    UGOKI_CHECK(p.reach < 1);  // the trajectories below keep the targets within the leg's length
  }

  const Mechanism& dog_;
  std::vector<double> q_;
};

Motion start(const Mechanism& dog, const char* name, double rate) {
  Motion m;
  m.name = name;
  m.source = "made by the project";
  m.mechanism = dog.name();
  m.rate = rate;
  m.nq = dog.nq();
  m.cyclic = true;
  return m;
}
void add(Motion& m, const std::vector<double>& q) {
  m.q.insert(m.q.end(), q.begin(), q.end());
  ++m.frames;
}

// ---- Trot. Phases are in strides: left fore and right hind foot touch down at 0.

constexpr double rate = 120;
constexpr int stride_frames = 71;  // 0.592 s
constexpr double speed = 1.35, stride = speed * stride_frames / rate;
constexpr double duty = 0.52;  // share of the stride in which a foot is on the ground

/// Trajectory of one leg: position of the knuckle and pitches of metapodium and paw.
/// @param u phase of this leg in [0, 1)  @param forward m, forward shift of the stance relative to the standing position
/// @param lift m, height of the knuckle in mid-swing  @param swing_fold degrees, extra flexion of the metapodium in swing
/// @param push degrees, pitch of the metapodium at lift-off
Step trot_step(double u, const DogLimb& limb, double forward, double lift, double swing_fold, double push) {
  Step s;
  const double half = 0.5 * duty * stride;
  if (u < duty) {
    const double t = u / duty;
    s.knuckle = {half + forward, 0, 0};  // constant during the stance; the caller moves the body over the paw
    // The metapodium pitches forward over the standing paw during the stance.
    s.metapodium = (-12 + (12 + push) * smooth_step(t)) * degree;
    s.paw = 0;
    s.knuckle += limb.knuckle;
    return s;
  }
  const double t = (u - duty) / (1 - duty);
  s.knuckle = limb.knuckle + Vec3{half + forward + quintic({0, 0, 0}, {stride, 0, 0}, t), 0, lift * bump(std::min(1.0, t * 1.02))};
  const double fold = bump(0.08 + 0.84 * t) - bump(0.08) * (1 - t) - bump(0.92) * t;
  s.metapodium = (push + (-12 - push) * smooth_step(t) + swing_fold * fold) * degree;
  s.paw = (0.75 * swing_fold * fold) * degree;
  return s;
}

}  // namespace

Motion make_dog_trot(const Mechanism& dog) {
  Motion out = start(dog, "Trot", rate);
  for (int f = 0; f <= stride_frames; ++f) {
    const double u = fraction(static_cast<double>(f) / stride_frames), w = 2 * pi * u;
    const double x = stride * u;
    Poser p(dog);
    // The trunk is lowest in the middle of each diagonal's stance, half of `duty` after touch-down.
    const double bounce = -0.009 * cos(2 * w - pi * 2 * duty);
    p.set_root({about_z(1.2 * degree * sin(w)) * about_x(1.5 * degree * cos(w)) * about_y(0.7 * degree * cos(2 * w)),
                dog_root + Vec3{x, 0.004 * sin(w), -0.024 + bounce}});
    p.set("Loin", about_z(-1.6 * degree * sin(w)) * about_y(1.2 * degree * cos(2 * w + 0.4)));
    p.set("Chest", about_z(-1.2 * degree * sin(w)) * about_y(-1.0 * degree * cos(2 * w + 0.4)));
    p.set("Neck", about_z(0.8 * degree * sin(w)) * about_y((14 + 1.6 * cos(2 * w + 1)) * degree));
    p.set("Neck1", about_z(0.8 * degree * sin(w)) * about_y((10 + 1.2 * cos(2 * w + 1)) * degree));
    p.set("Head", about_y((-20 - 2.4 * cos(2 * w + 1)) * degree));
    const char* tail[] = {"Tail", "Tail1", "Tail2", "Tail3"};
    for (int i = 0; i < 4; ++i)
      p.set(tail[i], about_y((i == 0 ? 22 : 9) * degree + 2.5 * degree * cos(2 * w - 0.7 * i)) * about_z(5 * degree * sin(w - 0.8 * i)));
    for (const int side : {1, -1}) {
      const double fore = side > 0 ? u : u + 0.5, hind = side > 0 ? u + 0.5 : u;
      // `own` counts the leg's strides since the start of the motion, so that the position of a standing paw is constant in the world.
      const auto placed = [&](double own, const DogLimb& limb, double shift, double lift, double fold, double push) {
        const double completed = std::floor(own);
        Step s = trot_step(own - completed, limb, shift, lift, fold, push);
        // At touch-down (phase 0 of this leg) the body was at x - stride * (own - completed).
        s.knuckle.x += x - stride * (own - completed);
        s.knuckle.y *= side * 0.93;  // dogs place their feet closer to the midline when trotting than when standing
        return s;
      };
      p.fore_leg(side, placed(fore, dog_fore, 0.030, 0.080, 58, 40), (-14 * cos(2 * pi * (fore + 0.02)) - 2) * degree);
      p.hind_leg(side, placed(hind, dog_hind, 0.015, 0.075, 38, 42));
    }
    std::vector<double> q = p.take();
    if (f == stride_frames) q[0] += stride;
    add(out, q);
  }
  label_contacts(dog, out);
  return out;
}

Motion make_dog_stand(const Mechanism& dog) {
  constexpr int frames = 480;
  Motion out = start(dog, "Stand", rate);
  for (int f = 0; f <= frames; ++f) {
    const double w = 2 * pi * fraction(static_cast<double>(f) / frames);
    Poser p(dog);
    p.set_root({about_x(0.3 * degree * sin(w)), dog_root + Vec3{0.002 * sin(w), 0.003 * sin(w + 1), -0.006 + 0.001 * sin(w)}});
    p.set("Chest", about_y(0.4 * degree * sin(2 * w)));
    p.set("Neck", about_z(6 * degree * sin(w)) * about_y(2 * degree * sin(w + 1)));
    p.set("Neck1", about_z(5 * degree * sin(w)));
    p.set("Head", about_z(5 * degree * sin(w + 0.3)) * about_x(3 * degree * sin(w)));
    const char* tail[] = {"Tail", "Tail1", "Tail2", "Tail3"};
    for (int i = 0; i < 4; ++i) p.set(tail[i], about_z(9 * degree * sin(6 * w - 0.6 * i)));  // the tail wags
    for (const int side : {1, -1}) {
      const auto still = [&](const DogLimb& limb) {
        Step s;
        s.knuckle = {limb.knuckle.x, limb.knuckle.y * side, limb.knuckle.z};
        return s;
      };
      p.fore_leg(side, still(dog_fore), 0);
      p.hind_leg(side, still(dog_hind));
    }
    add(out, p.take());
  }
  label_contacts(dog, out);
  return out;
}

}  // namespace ugoki::samples
