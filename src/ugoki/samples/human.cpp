// A human walking and standing. In the walk the feet roll over heel, sole and ball without sliding; the pelvis moves along published
// curves; the legs follow by inverse kinematics; the arms swing opposite to the legs. Sources: proportions Drillis and Contini (1966, in
// Winter 2009, fig. 4.1); timing, foot and pelvis curves Winter (1991), Perry (1992), Whittle (2007); arms Murray, Sepic and Barnard
// (1967). docs/design/samples.md compares the joint angles.

#include <algorithm>

#include "ugoki/samples/curves.h"
#include "ugoki/samples/samples.h"

namespace ugoki::samples {
namespace {

constexpr double height = 1.75;
constexpr double thigh = 0.245 * height, shank = 0.246 * height;
constexpr double ankle_height = 0.039 * height, ball_height = 0.019 * height;
constexpr double ball_forward = 0.075 * height, toe_length = 0.040 * height;
constexpr double heel_back = 0.036 * height, heel_radius = 0.04,
                 edge_forward = ball_forward + 0.012;  // same shape of the sole as in the module body
constexpr double hip_half_width = 0.050 * height, hip_drop = 0.022 * height;
constexpr double rate = 120;

enum Joint {
  hips,
  spine,
  spine1,
  chest,
  neck,
  head,
  shoulder_l,
  arm_l,
  forearm_l,
  hand_l,
  shoulder_r,
  arm_r,
  forearm_r,
  hand_r,
  thigh_l,
  shank_l,
  foot_l,
  toes_l,
  thigh_r,
  shank_r,
  foot_r,
  toes_r,
  joint_count
};

Skeleton make_skeleton() {
  Skeleton s;
  s.name = "Human 1.75 m";
  s.mass = 70;
  const auto add = [&](const char* name, int parent, const Vec3& offset, const std::vector<Vec3>& ends = {}) {
    SkeletonJoint j;
    j.name = name;
    j.parent = parent;
    j.offset = offset;
    j.end_sites = ends;
    j.dofs = {{{0, 0, 1}}, {{1, 0, 0}}, {{0, 1, 0}}};
    s.joints.push_back(j);
  };
  const double hip_height = 0.530 * height, shoulder_height = 0.818 * height, top = height;
  const double trunk = shoulder_height - hip_height;
  add("Hips", -1, {0, 0, 0});
  add("Spine", hips, {-0.012, 0, 0.20 * trunk - hip_drop});
  add("Spine1", spine, {-0.006, 0, 0.24 * trunk});
  add("Chest", spine1, {-0.004, 0, 0.24 * trunk});
  add("Neck", chest, {0.006, 0, 0.40 * trunk});
  const double neck_height = hip_height + 1.08 * trunk;
  add("Head", neck, {0.012, 0, 0.052 * height}, {{0.006, 0, top - neck_height - 0.052 * height}});
  for (const double side : {1.0, -1.0}) {
    const bool left = side > 0;
    add(left ? "LeftShoulder" : "RightShoulder", chest, {0, 0.03 * side, 0.33 * trunk});
    add(left ? "LeftArm" : "RightArm", left ? shoulder_l : shoulder_r, {-0.008, (0.112 * height - 0.03) * side, -0.01 * trunk});
    add(left ? "LeftForeArm" : "RightForeArm", left ? arm_l : arm_r, {0, 0.186 * height * side, 0});
    add(left ? "LeftHand" : "RightHand", left ? forearm_l : forearm_r, {0, 0.146 * height * side, 0}, {{0, 0.108 * height * side, 0}});
  }
  for (const double side : {1.0, -1.0}) {
    const bool left = side > 0;
    add(left ? "LeftUpLeg" : "RightUpLeg", hips, {0, hip_half_width * side, -hip_drop});
    add(left ? "LeftLeg" : "RightLeg", left ? thigh_l : thigh_r, {0, 0, -thigh});
    add(left ? "LeftFoot" : "RightFoot", left ? shank_l : shank_r, {0, 0, -shank});
    add(left ? "LeftToeBase" : "RightToeBase", left ? foot_l : foot_r, {ball_forward, 0, ball_height - ankle_height}, {{toe_length, 0, 0}});
  }
  return s;
}

Mat3 about_x(double angle) { return rotation_about({1, 0, 0}, angle); }
Mat3 about_y(double angle) { return rotation_about({0, 1, 0}, angle); }
Mat3 about_z(double angle) { return rotation_about({0, 0, 1}, angle); }

/// Posture at one moment: pose of the hips in the world, rotations of the other joints relative to their parents.
struct Posture {
  Pose hips;
  Mat3 local[joint_count];
  double worst_reach = 0;

  Posture() { std::fill(std::begin(local), std::end(local), Mat3::identity()); }
};

/// Pose of a foot: ankle position (m), pitch about y (rad, positive: toes down), pitch of the toes relative to the foot (rad).
struct FootPose {
  Vec3 ankle;
  double pitch = 0, toes = 0;
};

/// Sets the joints of a leg so that the ankle is at foot.ankle with the given pitch and heading [rad]. @param side +1 left, -1 right
void place_leg(Posture& p, int side, const FootPose& foot, double heading) {
  const int first = side > 0 ? thigh_l : thigh_r;
  const Vec3 hip = p.hips * Vec3{0, hip_half_width * side, -hip_drop};
  const Mat3 R_heading = about_z(heading);
  const LimbPosture leg = reach(hip, foot.ankle, thigh, shank, R_heading.column(1), 1);
  p.worst_reach = std::max(p.worst_reach, leg.reach);
  p.local[first] = p.hips.R.transposed() * leg.R_upper;
  p.local[first + 1] = about_y(leg.flexion);
  p.local[first + 2] = (leg.R_upper * p.local[first + 1]).transposed() * (R_heading * about_y(foot.pitch));
  p.local[first + 3] = about_y(foot.toes);
}

/// Sets spine and neck joints so that the chest has the rotation R_chest and the head R_head (world). The joints have equal shares of it.
void place_trunk(Posture& p, const Mat3& R_chest, const Mat3& R_head) {
  const Vec3 bend = log_map(to_quat(p.hips.R.transposed() * R_chest));
  for (const int j : {spine, spine1, chest}) p.local[j] = to_matrix(exp_map(bend * (1.0 / 3)));
  const Vec3 nod = log_map(to_quat(R_chest.transposed() * R_head));
  for (const int j : {neck, head}) p.local[j] = to_matrix(exp_map(nod * 0.5));
}

/// Sets the joints of an arm that hangs, is swung forward by `swing` and spread sideways by `spread`, with the elbow bent by `flexion` (all
/// in rad). The arm's rest posture is the T position.
void place_arm(Posture& p, int side, double swing, double spread, double flexion) {
  const int first = side > 0 ? arm_l : arm_r;
  p.local[first] = about_y(-swing) * about_x(-side * (pi / 2 - spread)) * about_y(-0.2);
  p.local[first + 1] = about_z(-side * flexion);
  p.local[first + 2] = about_z(-side * 0.12) * about_y(-0.05);
}

class Recorder {
 public:
  Recorder(const char* name, int frames) {
    m_.name = name;
    m_.source = "made by the project";
    m_.skeleton = make_skeleton();
    m_.rate = rate;
    m_.frames = frames;
  }
  void add(const Posture& p) {
    for (int j = 0; j < joint_count; ++j) {
      m_.translations.push_back(j == hips ? p.hips.p : m_.skeleton.joints[static_cast<std::size_t>(j)].offset);
      m_.rotations.push_back(to_quat(j == hips ? p.hips.R : p.local[j]));
    }
  }
  MeasuredMotion take() { return std::move(m_); }

 private:
  MeasuredMotion m_;
};

// ---- Walk. Phases are in strides: the left heel strikes at 0, the right heel at 0.5.

constexpr int stride_frames = 124;  // 1.033 s: 116 steps a minute
constexpr double stride_time = stride_frames / rate, speed = 1.35, stride = speed * stride_time;
constexpr double flat_from = 0.08, flat_to = 0.30, lift = 0.61;  // phases: foot flat begins, heel lifts, toes lift (Perry 1992)
constexpr double strike_pitch = -17 * degree, lift_pitch = 57 * degree;
constexpr double strike_speed = 1.0, strike_brake = 20;  // m/s, m/s^2: forward speed and deceleration of the heel at heel strike
constexpr double swing_lift = 0.085;                     // m, extra height of the ankle in swing
constexpr double toe_bend = 1.15;                        // ratio of the toes' angle relative to the foot to the pitch of the foot
constexpr double over_ankle = 0.22;                      // phase at which the pelvis is above the ankle
constexpr double half_track = 0.052;                     // m, distance of the ankles from the midline
constexpr double toe_out = 6 * degree;

/// Pitch [rad] of a standing foot at phase u.
double stance_pitch(double u) {
  if (u < flat_from) return strike_pitch * (1 - smooth_step(u / flat_from));
  if (u < flat_to) return 0;
  const double s = (u - flat_to) / (lift - flat_to);
  return lift_pitch * s * s * s * (1.6 - 0.6 * s);
}

/// Ankle position [m] of a standing foot with the given heading at phase u, relative to the point on the ground under the ankle of the
/// flat foot. The foot does not slide: it rolls on the round heel, is flat, then rotates about the front edge of the sole under the ball.
Vec3 stance_ankle(double u, double heading) {
  const double a = stance_pitch(u);
  const Mat3 R = about_y(a);
  const Vec3 heel{-heel_back + heel_radius, 0, -ankle_height + heel_radius}, edge{edge_forward, 0, -ankle_height};
  const Vec3 in_plane = u < flat_to ? Vec3{heel.x + heel_radius * a, 0, heel_radius} - R * heel : Vec3{edge_forward, 0, 0} - R * edge;
  return about_z(heading) * in_plane;
}

template <class F>
Jet jet_of(F f, double u, double h, double scale) {  // derivatives per swing, by one-sided differences (h < 0: backwards into the stance)
  const double x0 = f(u), x1 = f(u + h), x2 = f(u + 2 * h);
  return {x0, (-3 * x0 + 4 * x1 - x2) / (2 * h) * scale, (x0 - 2 * x1 + x2) / (h * h) * scale * scale};
}

FootPose walking_foot(double u, double heading) {
  FootPose foot;
  if (u < lift) {
    foot.pitch = stance_pitch(u);
    foot.ankle = stance_ankle(u, heading);
    foot.toes = u < flat_from ? -10 * degree * (1 - smooth_step(u / flat_from)) : -toe_bend * std::max(0.0, foot.pitch);
    return foot;
  }
  const double span = 1 - lift, s = (u - lift) / span;
  const double h = -1e-3;
  const auto between = [&](auto f, const Jet& end) { return quintic(jet_of(f, lift - 1e-9, h, span), end, s); };
  const Vec3 landing = stance_ankle(0, heading);
  // The foot returns quickly to a horizontal position so that the toes clear the ground, then pitches up for the heel strike.
  constexpr double level = 0.55;
  const Jet passing{7 * degree, -95 * degree, 0};  // pitch, and rate of the pitch per swing, at s = level
  Jet leaving = jet_of([](double w) { return stance_pitch(w); }, lift - 1e-9, h, span * level);
  leaving.a = 0;
  foot.pitch = s < level ? quintic(leaving, {passing.x, passing.v * level, 0}, s / level)
                         : quintic({passing.x, passing.v * (1 - level), 0}, {strike_pitch, 0, 0}, (s - level) / (1 - level));
  // At heel strike the heel still moves forward at strike_speed while it decelerates.
  foot.ankle.x = between([&](double w) { return stance_ankle(w, heading).x; },
                         {landing.x + stride, strike_speed * stride_time * span, -strike_brake * stride_time * span * stride_time * span});
  foot.ankle.y = between([&](double w) { return stance_ankle(w, heading).y; }, {landing.y, 0, 0});
  foot.ankle.z = between([&](double w) { return stance_ankle(w, heading).z; }, {landing.z, 0, 0}) + swing_lift * bump(s * (2 - s));
  const double relax = smooth_step((s - 0.12) / 0.5), ready = smooth_step((s - 0.5) / 0.5);
  foot.toes = -toe_bend * lift_pitch * (1 - relax) - 10 * degree * ready;
  return foot;
}

Posture walking_posture(double u, double pelvis_height) {
  Posture p;
  const double w = 2 * pi * u;
  const double yaw = -4.5 * degree * cos(w), list = 3.5 * degree * sin(w + 0.55), tilt = (3 + 1.0 * cos(2 * w)) * degree;
  p.hips.R = about_z(yaw) * about_x(list) * about_y(tilt);
  p.hips.p = {stride * (u - over_ankle) - 0.007 * sin(2 * (w - 2 * pi * 0.31)), 0.019 * sin(w - 0.38),
              pelvis_height + 0.023 * cos(2 * (w - 2 * pi * 0.285))};
  for (const int side : {1, -1}) {
    const double own = side > 0 ? u : u - 0.5, strides = std::floor(own);
    FootPose foot = walking_foot(own - strides, side * toe_out);
    foot.ankle += Vec3{stride * (strides + (side > 0 ? 0 : 0.5)), side * half_track, 0};
    place_leg(p, side, foot, side * toe_out);
  }
  const Mat3 R_chest = about_z(4 * degree * cos(w)) * about_x(-1.2 * degree * sin(w + 0.3)) * about_y(2.5 * degree);
  const Mat3 R_head = about_z(0.8 * degree * cos(w)) * about_y((1.5 + 0.8 * cos(2 * w + 0.6)) * degree);
  place_trunk(p, R_chest, R_head);
  for (const int side : {1, -1}) {
    const double forward = -side * cos(w - 0.15);  // 1 when the arm is farthest forward, which is at the heel strike of the opposite leg
    place_arm(p, side, (-4 + 18 * forward) * degree, 7 * degree, (23 + 11 * forward) * degree);
  }
  return p;
}

/// Maximum height [m] of the pelvis at which no leg is stretched beyond the fraction `max_reach` of its length.
double find_pelvis_height(double max_reach) {
  double low = 0.7, high = 1.1;
  for (int i = 0; i < 40; ++i) {
    const double middle = 0.5 * (low + high);
    double worst = 0;
    for (int f = 0; f < stride_frames; ++f)
      worst = std::max(worst, walking_posture(static_cast<double>(f) / stride_frames, middle).worst_reach);
    (worst > max_reach ? high : low) = middle;
  }
  return low;
}

}  // namespace

MeasuredMotion make_human_walk() {
  const double pelvis_height = find_pelvis_height(0.9988);
  Recorder out("Walk, relaxed", stride_frames + 1);
  for (int f = 0; f <= stride_frames; ++f) {
    Posture p = walking_posture(fraction(static_cast<double>(f) / stride_frames), pelvis_height);
    if (f == stride_frames) p.hips.p.x += stride;
    out.add(p);
  }
  return out.take();
}

MeasuredMotion make_human_stand() {
  constexpr int frames = 480;
  Recorder out("Stand at ease", frames + 1);
  for (int f = 0; f <= frames; ++f) {
    const double w = 2 * pi * fraction(static_cast<double>(f) / frames);
    Posture p;
    p.hips.R = about_z(0.6 * degree * sin(w)) * about_x(0.5 * degree * sin(w + 1)) * about_y((3 + 0.2 * sin(w)) * degree);
    // Quiet standing sways by about 5 mm (Winter 1995).
    p.hips.p = {0.012 + 0.003 * sin(w + 0.4), 0.005 * sin(w), 0.988 * (thigh + shank) + hip_drop + ankle_height + 0.0015 * sin(w + 2)};
    for (const int side : {1, -1}) {
      FootPose foot;
      foot.ankle = {0, side * 0.105, ankle_height};
      place_leg(p, side, foot, side * 9 * degree);
    }
    const double breath = sin(w);  // 15 breaths per minute: one per motion of 4 s
    place_trunk(p, about_y((2.5 + 0.6 * breath) * degree), about_z(2.5 * degree * sin(w + 0.7)) * about_y((2 + 0.5 * sin(2 * w)) * degree));
    for (const int side : {1, -1})
      place_arm(p, side, (1 + 0.7 * breath) * degree, (8 + 0.4 * breath) * degree, (16 + 0.8 * breath) * degree);
    out.add(p);
  }
  return out.take();
}

}  // namespace ugoki::samples
