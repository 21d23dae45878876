#include "dialects.h"

#include <algorithm>
#include <array>
#include <random>

#include "ugoki/formats/asf.h"
#include "ugoki/formats/bvh.h"
#include "ugoki/formats/gltf.h"

namespace ugoki::dialects {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

// Names of the 31 joints of the CMU skeletons, in the order of their files: root, left leg (5), right leg (5), trunk (3), neck (2), head,
// left arm (7), right arm (7). '<' is replaced by the mark of the side.
struct Convention {
  const char* name;
  const char* left;
  const char* right;
  const char* joints[19];  // root; hip joint, thigh, shank, foot, toes; three of the trunk; two of the neck; head; seven of an arm
};
constexpr Convention conventions[] = {
    {"asf",
     "l",
     "r",
     {"root", "<hipjoint", "<femur", "<tibia", "<foot", "<toes", "lowerback", "upperback", "thorax", "lowerneck", "upperneck", "head",
      "<clavicle", "<humerus", "<radius", "<wrist", "<hand", "<fingers", "<thumb"}},
    {"mixamo",
     "Left",
     "Right",
     {"mixamorig:Hips", "mixamorig:<HipHelper", "mixamorig:<UpLeg", "mixamorig:<Leg", "mixamorig:<Foot", "mixamorig:<ToeBase",
      "mixamorig:Spine", "mixamorig:Spine1", "mixamorig:Spine2", "mixamorig:Neck", "mixamorig:Neck1", "mixamorig:Head",
      "mixamorig:<Shoulder", "mixamorig:<Arm", "mixamorig:<ForeArm", "mixamorig:<ForeArmRoll", "mixamorig:<Hand", "mixamorig:<HandIndex1",
      "mixamorig:<HandThumb1"}},
    {"biped",
     "L",
     "R",
     {"Bip01 Pelvis", "Bip01 < Hip", "Bip01 < Thigh", "Bip01 < Calf", "Bip01 < Foot", "Bip01 < Toe0", "Bip01 Spine", "Bip01 Spine1",
      "Bip01 Spine2", "Bip01 Neck", "Bip01 Neck1", "Bip01 Head", "Bip01 < Clavicle", "Bip01 < UpperArm", "Bip01 < Forearm",
      "Bip01 < ForeTwist", "Bip01 < Hand", "Bip01 < Finger1", "Bip01 < Finger0"}},
    {"character creator",
     "L",
     "R",
     {"CC_Base_Hip", "CC_Base_<_HipShareBone", "CC_Base_<_Thigh", "CC_Base_<_Calf", "CC_Base_<_Foot", "CC_Base_<_ToeBase", "CC_Base_Waist",
      "CC_Base_Spine01", "CC_Base_Spine02", "CC_Base_NeckTwist01", "CC_Base_NeckTwist02", "CC_Base_Head", "CC_Base_<_Clavicle",
      "CC_Base_<_Upperarm", "CC_Base_<_Forearm", "CC_Base_<_ForearmTwist01", "CC_Base_<_Hand", "CC_Base_<_Index1", "CC_Base_<_Thumb1"}},
    {"unreal",
     "l",
     "r",
     {"pelvis", "hip_socket_<", "thigh_<", "calf_<", "foot_<", "ball_<", "spine_01", "spine_02", "spine_03", "neck_01", "neck_02", "head",
      "clavicle_<", "upperarm_<", "lowerarm_<", "lowerarm_twist_01_<", "hand_<", "index_01_<", "thumb_01_<"}},
    {"vrm",
     "L",
     "R",
     {"J_Bip_C_Hips", "J_Bip_<_HipSub", "J_Bip_<_UpperLeg", "J_Bip_<_LowerLeg", "J_Bip_<_Foot", "J_Bip_<_ToeBase", "J_Bip_C_Spine",
      "J_Bip_C_Chest", "J_Bip_C_UpperChest", "J_Bip_C_Neck", "J_Bip_C_Neck1", "J_Bip_C_Head", "J_Bip_<_Shoulder", "J_Bip_<_UpperArm",
      "J_Bip_<_LowerArm", "J_Bip_<_ArmRoll", "J_Bip_<_Hand", "J_Bip_<_Index1", "J_Bip_<_Thumb1"}},
    {"human ik",
     "Left",
     "Right",
     {"Character1_Hips", "Character1_<HipJoint", "Character1_<UpLeg", "Character1_<Leg", "Character1_<Foot", "Character1_<ToeBase",
      "Character1_Spine", "Character1_Spine1", "Character1_Spine2", "Character1_Neck", "Character1_Neck1", "Character1_Head",
      "Character1_<Shoulder", "Character1_<Arm", "Character1_<ForeArm", "Character1_<ForeArmRoll", "Character1_<Hand",
      "Character1_<HandIndex1", "Character1_<HandThumb1"}},
    {"blender",
     "L",
     "R",
     {"DEF-hips", "DEF-pelvis.<", "DEF-thigh.<", "DEF-shin.<", "DEF-foot.<", "DEF-toe.<", "DEF-spine", "DEF-spine.001", "DEF-chest",
      "DEF-neck", "DEF-neck.001", "DEF-head", "DEF-shoulder.<", "DEF-upper_arm.<", "DEF-forearm.<", "DEF-forearm.<.001", "DEF-hand.<",
      "DEF-f_index.01.<", "DEF-thumb.01.<"}},
    {"daz",
     "l",
     "r",
     {"hip", "<HipNode", "<Thigh", "<Shin", "<Foot", "<Toe", "abdomen", "abdomen2", "chest", "neck", "neckUpper", "head", "<Collar",
      "<Shldr", "<ForeArm", "<ForearmTwist", "<Hand", "<Index1", "<Thumb1"}},
    {"smpl",
     "L",
     "R",
     {"Pelvis", "<_Groin", "<_Hip", "<_Knee", "<_Ankle", "<_Foot", "Spine1", "Spine2", "Spine3", "Neck", "Neck2", "Head", "<_Collar",
      "<_Shoulder", "<_Elbow", "<_Radius", "<_Wrist", "<_Hand", "<_Thumb"}},
    {"joint",
     "LT",
     "RT",
     {"joint_Root", "joint_HipSub<", "joint_Hip<", "joint_Knee<", "joint_Foot<", "joint_Toe<", "joint_TorsoA", "joint_TorsoB",
      "joint_TorsoC", "joint_NeckA", "joint_NeckB", "joint_Head", "joint_Clavicle<", "joint_Shoulder<", "joint_Elbow<", "joint_Roll<",
      "joint_Hand<", "joint_Finger<", "joint_Thumb<"}},
    {"xsens",
     "Left",
     "Right",
     {"Pelvis", "<Groin", "<UpperLeg", "<LowerLeg", "<Foot", "<Toe", "L5", "L3", "T8", "Neck", "Neck2", "Head", "<Shoulder", "<UpperArm",
      "<ForeArm", "<ForeArm2", "<Hand", "<Finger", "<Thumb"}},
    {"german",
     "links",
     "rechts",
     {"Becken", "Huefte_<", "Oberschenkel_<", "Unterschenkel_<", "Fuss_<", "Zehe_<", "Wirbel1", "Wirbel2", "Wirbel3", "Hals1", "Hals2",
      "Kopf", "Schluesselbein_<", "Oberarm_<", "Unterarm_<", "Drehung_<", "Hand_<", "Finger_<", "Daumen_<"}},
    {"nameless", "", "", {}},
};

std::string with_side(const char* pattern, const char* side) {
  std::string out = pattern;
  if (const std::size_t i = out.find('<'); i != std::string::npos) out.replace(i, 1, side);
  return out;
}

/// Name of joint `i` of the 31 joints.
std::string name_of(const Convention& c, int i) {
  if (c.joints[0] == nullptr) return "Bone" + std::to_string(i);
  if (i == 0) return c.joints[0];
  if (i <= 10) return with_side(c.joints[1 + (i - 1) % 5], i <= 5 ? c.left : c.right);
  if (i <= 16) return c.joints[i - 5];
  return with_side(c.joints[12 + (i - 17) % 7], i <= 23 ? c.left : c.right);
}

struct World {
  std::vector<std::vector<Pose>> X;  // [frames][joints]
};
World world_of(const MeasuredMotion& m) {
  World w;
  w.X.resize(at(m.frames));
  for (int f = 0; f < m.frames; ++f) m.calc_joint_poses(f, w.X[at(f)]);
  return w;
}
void set_world(MeasuredMotion& m, const World& w) {
  const std::size_t n = m.skeleton.joints.size();
  m.frames = static_cast<int>(w.X.size());
  m.translations.assign(w.X.size() * n, {});
  m.rotations.assign(w.X.size() * n, {});
  for (std::size_t f = 0; f < w.X.size(); ++f)
    for (std::size_t i = 0; i < n; ++i) {
      const int p = m.skeleton.joints[i].parent;
      const Pose X = p < 0 ? w.X[f][i] : w.X[f][at(p)].inverse() * w.X[f][i];
      m.translations[f * n + i] = X.p;
      m.rotations[f * n + i] = normalized(to_quat(X.R));
    }
}

/// Inserts a joint between joint `i` and its child `c`, at the fraction `along` of the bone. Its orientation is that of joint `i`, rotated
/// about the bone by half of the child's twist.
void insert_twist(MeasuredMotion& m, World& w, int i, int c, double along, const std::string& name) {
  SkeletonJoint j;
  j.name = name;
  j.parent = i;
  j.rotation_order = m.skeleton.joints[at(i)].rotation_order;
  const Vec3 bone = m.skeleton.joints[at(c)].offset;
  j.offset = bone * along;
  j.dofs = m.skeleton.joints[at(i)].dofs.empty() ? std::vector<MeasuredDof>{{{0, 0, 1}}, {{1, 0, 0}}, {{0, 1, 0}}}
                                                 : m.skeleton.joints[at(i)].dofs;
  // The new joint is inserted before the child, so the indices of the child and of later joints increase by one.
  m.skeleton.joints.insert(m.skeleton.joints.begin() + c, j);
  for (std::size_t k = at(c) + 1; k < m.skeleton.joints.size(); ++k) {
    int& p = m.skeleton.joints[k].parent;
    if (p >= c) ++p;
  }
  m.skeleton.joints[at(c) + 1].parent = c;
  m.skeleton.joints[at(c) + 1].offset = bone * (1 - along);
  for (auto& X : w.X) {
    const Pose parent = X[at(i)], child = X[at(c)];
    const Vec3 axis = normalized(child.p - parent.p);
    const Quat relative = to_quat(child.R * parent.R.transposed());
    const double twist = 2 * atan2(dot(relative.vec(), axis), relative.w);
    const double wrapped = twist > pi ? twist - 2 * pi : twist < -pi ? twist + 2 * pi : twist;
    X.insert(X.begin() + c, Pose{rotation_about(axis, 0.5 * wrapped) * parent.R, parent.p + (child.p - parent.p) * along});
  }
}

}  // namespace

const std::vector<std::string>& convention_names() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> out;
    for (const Convention& c : conventions) out.emplace_back(c.name);
    return out;
  }();
  return names;
}

std::vector<Dialect> all_dialects() {
  std::vector<Dialect> out;
  const int count = static_cast<int>(std::size(conventions));
  const auto add = [&](const char* name) -> Dialect& {
    out.push_back({});
    out.back().name = name;
    out.back().seed = out.size();
    return out.back();
  };
  for (int c = 0; c < count; ++c) add(conventions[c].name).convention = c;  // 14 dialects
  add("random rest").rest = RestPose::random;
  add("bones along x").rest = RestPose::along_x;
  add("bones along y").rest = RestPose::along_y;
  add("bones along z").rest = RestPose::along_z;
  for (const auto& [name, rest, convention] : {std::tuple{"x and mixamo", RestPose::along_x, 1},
                                               {"y and biped", RestPose::along_y, 2},
                                               {"z and unreal", RestPose::along_z, 4},
                                               {"random and nameless", RestPose::random, count - 1}}) {
    Dialect& d = add(name);
    d.rest = rest;
    d.convention = convention;
  }
  add("prefix").prefix = "Subject01:";
  add("long prefix").prefix = "Armature_rig_";
  add("z up").z_up = true;
  add("metres").unit = 1;
  add("millimetres").unit = 0.001;
  add("centimetres").unit = 0.01;
  for (const char* order : {"XYZ", "YXZ", "ZYX"}) add(order).order = order;
  add("half rate").rate_factor = 0.5;
  {
    Dialect& d = add("far away");
    d.place = {340, -1210, 0};
    d.heading = 2.2;
  }
  add("root offset").root_offset = {0.31, 0.9, -0.4};
  add("still carrier").carrier = Carrier::still;
  {
    Dialect& d = add("moving carrier and camera");
    d.carrier = Carrier::moving;
    d.camera = true;
  }
  add("footsteps").footsteps = true;
  add("calibration frame").calibration_frame = true;
  add("twist bones").twists = true;
  {
    Dialect& d = add("end bones and six channels");
    d.helpers = true;
    d.six_channels = true;
  }
  add("amc").format = "amc";
  add("glb").format = "glb";
  {
    Dialect& d = add("everything");
    d.rest = RestPose::random;
    d.convention = 3;
    d.unit = 0.01;
    d.order = "XYZ";
    d.place = {-55, 20, 0};
    d.carrier = Carrier::moving;
    d.camera = true;
    d.footsteps = true;
    d.twists = true;
    d.helpers = true;
    d.six_channels = true;
    d.root_offset = {1, 2, 3};
  }
  return out;
}

MeasuredMotion rewrite(const MeasuredMotion& motion, const Dialect& d) {
  MeasuredMotion m = motion;
  std::mt19937_64 random(d.seed);
  const auto uniform = [&] { return static_cast<double>(random() >> 11) * 0x1p-53; };
  const auto direction = [&] {
    while (true) {
      const Vec3 v{2 * uniform() - 1, 2 * uniform() - 1, 2 * uniform() - 1};
      if (norm(v) > 0.1 && norm(v) < 1) return normalized(v);
    }
  };
  World w = world_of(m);
  if (d.rate_factor != 1) {
    const int step = static_cast<int>(1 / d.rate_factor + 0.5);
    World slow;
    for (std::size_t f = 0; f < w.X.size(); f += at(step)) slow.X.push_back(w.X[f]);
    w = std::move(slow);
    m.rate /= step;
  }
  if (const Pose move{rotation_about({0, 0, 1}, d.heading), d.place}; d.heading != 0 || norm(d.place) > 0)
    for (auto& X : w.X)
      for (Pose& x : X) x = move * x;
  const int n = m.joint_count();
  if (d.convention >= 0 && n == 31)
    for (int i = 0; i < n; ++i) m.skeleton.joints[at(i)].name = name_of(conventions[d.convention], i);
  for (SkeletonJoint& j : m.skeleton.joints) {
    j.rotation_order = d.order;
    if (d.format == "bvh") j.dofs = {{{0, 0, 1}}, {{1, 0, 0}}, {{0, 1, 0}}};
  }
  if (d.twists && n == 31) {
    // Insert from the last to the first, so that the indices of the remaining joints do not change.
    for (const auto& [i, c] : {std::pair{25, 26}, {18, 19}, {7, 8}, {2, 3}})
      insert_twist(m, w, i, c, 0.5, m.skeleton.joints[at(i)].name + "_Twist");
  }
  if (d.helpers) {
    std::vector<int> ends;
    for (int i = 0; i < m.joint_count(); ++i)
      if (!m.skeleton.joints[at(i)].end_sites.empty()) ends.push_back(i);
    for (const int i : ends) {
      SkeletonJoint j;
      j.name = m.skeleton.joints[at(i)].name + "_Nub";
      j.parent = i;
      j.offset = m.skeleton.joints[at(i)].end_sites[0];
      j.rotation_order = d.order;
      m.skeleton.joints.push_back(j);
      for (auto& X : w.X) X.push_back(X[at(i)] * Pose{Mat3::identity(), j.offset});
    }
  }
  // For other rest poses each joint's frame is turned by a constant rotation, so that its bone points along one axis, or anywhere.
  if (d.rest != RestPose::as_is) {
    const std::vector<Vec3> rest = rest_positions(m.skeleton);
    for (int i = 0; i < m.joint_count(); ++i) {
      Vec3 bone{};
      for (const Vec3& e : m.skeleton.joints[at(i)].end_sites) bone = e;
      for (int c = m.joint_count() - 1; c > i; --c)
        if (m.skeleton.joints[at(c)].parent == i && norm(m.skeleton.joints[at(c)].offset) > 1e-6) bone = m.skeleton.joints[at(c)].offset;
      Mat3 D = rotation_about(direction(), 6 * uniform());
      if (d.rest != RestPose::random) {
        const Vec3 axis = d.rest == RestPose::along_x ? Vec3{1, 0, 0} : d.rest == RestPose::along_y ? Vec3{0, 1, 0} : Vec3{0, 0, 1};
        D = norm(bone) > 1e-9 ? to_matrix(rotation_between(axis, normalized(bone))) * rotation_about(axis, 6 * uniform())
                              : Mat3::identity();
      }
      for (auto& X : w.X) X[at(i)].R = X[at(i)].R * D;
      for (Vec3& e : m.skeleton.joints[at(i)].end_sites) e = transpose_times(D, e);
      for (int c = i + 1; c < m.joint_count(); ++c)
        if (m.skeleton.joints[at(c)].parent == i) m.skeleton.joints[at(c)].offset = transpose_times(D, m.skeleton.joints[at(c)].offset);
    }
  }
  if (d.footsteps) {
    SkeletonJoint j;
    j.name = "Footsteps";
    j.parent = 0;
    j.translates = true;
    j.rotation_order = d.order;
    m.skeleton.joints.push_back(j);
    for (std::size_t f = 0; f < w.X.size(); ++f) {
      const Vec3 p = w.X[f][0].p;
      w.X[f].push_back({rotation_about({0, 0, 1}, 0.3 * static_cast<double>(f % 7)), {p.x, p.y, 0}});
    }
  }
  if (d.carrier != Carrier::none) {
    SkeletonJoint j;
    j.name = "Reference";
    j.rotation_order = d.order;
    j.translates = true;
    for (SkeletonJoint& o : m.skeleton.joints) ++o.parent;
    for (SkeletonJoint& o : m.skeleton.joints)
      if (o.parent == 0) o.translates = true;
    m.skeleton.joints.insert(m.skeleton.joints.begin(), j);
    for (std::size_t f = 0; f < w.X.size(); ++f) {
      const double t = static_cast<double>(f) / m.rate;
      const Pose X = d.carrier == Carrier::still
                         ? Pose{rotation_about({1, 0, 0}, 0.4), {3, 1, 2}}
                         : Pose{rotation_about({0, 0, 1}, 0.2 * t) * rotation_about({1, 0, 0}, 0.1), {w.X[f][0].p.x, 0.3 * t, 0.2}};
      w.X[f].insert(w.X[f].begin(), X);
    }
    if (d.camera) {
      SkeletonJoint camera;
      camera.name = "Camera";
      camera.parent = 0;
      camera.translates = true;
      camera.rotation_order = d.order;
      m.skeleton.joints.push_back(camera);
      for (std::size_t f = 0; f < w.X.size(); ++f) w.X[f].push_back({Mat3::identity(), {14, 3 + 0.01 * static_cast<double>(f), 13.7}});
    }
  }
  if (d.calibration_frame) {
    std::vector<Pose> T(m.skeleton.joints.size());
    const std::vector<Vec3> rest = rest_positions(m.skeleton);
    for (std::size_t i = 0; i < T.size(); ++i)
      T[i] = {rotation_about({0, 0, 1}, 0.7), rotation_about({0, 0, 1}, 0.7) * rest[i] + Vec3{0, 0, 1}};
    w.X.insert(w.X.begin(), T);
  }
  set_world(m, w);
  m.skeleton.joints[0].offset += d.root_offset;
  if (d.six_channels)
    for (SkeletonJoint& j : m.skeleton.joints) j.translates = true;
  m.skeleton.joints[0].translates = true;
  for (SkeletonJoint& j : m.skeleton.joints) j.name = d.prefix + j.name;
  m.skeleton.unit = d.unit;
  return m;
}

DialectFile write(const MeasuredMotion& motion, const Dialect& d, const std::string& stem) {
  DialectFile out;
  if (d.format == "amc") {
    formats::AmcWriteOptions options;
    options.metres_per_unit = d.unit;
    const formats::AmcText text = formats::write_amc(motion, options);
    out = {stem + ".amc", text.amc, text.asf};
  } else if (d.format == "glb") {
    const std::vector<std::byte> bytes = formats::write_glb(motion);
    out = {stem + ".glb", std::string(reinterpret_cast<const char*>(bytes.data()), bytes.size()), {}};
  } else {
    formats::BvhWriteOptions options;
    options.metres_per_unit = d.unit;
    options.z_up = d.z_up;
    options.decimals = 9;
    out = {stem + ".bvh", formats::write_bvh(motion, options), {}};
  }
  return out;
}

}  // namespace ugoki::dialects
