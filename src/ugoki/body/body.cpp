#include "ugoki/body/body.h"

#include <algorithm>
#include <set>

#include "ugoki/base/check.h"
#include "ugoki/base/number.h"
#include "ugoki/body/body_motion.h"
#include "ugoki/body/build.h"
#include "ugoki/body/calibration_frames.h"
#include "ugoki/body/creature.h"
#include "ugoki/body/joints.h"
#include "ugoki/body/recognise.h"
#include "ugoki/mechanism/state.h"
#include "ugoki/motion/contact_labels.h"
#include "ugoki/motion/jumps.h"

namespace ugoki::body {
namespace {

constexpr double degree = pi / 180;
constexpr double nominal_ball = 0.019;       // height of the joint at the ball of the foot above the ground, share of the body's height
constexpr double foot_length = 0.152;        // share of the height (Drillis and Contini 1966, in Winter 2009, fig. 4.1)
constexpr double leg_share = 0.245 + 0.246;  // thigh and shank, share of the height (same source)

std::size_t at(int i) { return static_cast<std::size_t>(i); }

Error check_input(const MeasuredMotion& m) {
  Error errors;
  const std::string location = m.source.empty() ? m.name : m.source;
  const std::size_t n = m.skeleton.joints.size();
  if (n == 0) errors.add(ErrorCode::structure, location, "The skeleton has no joints.", "Export the motion with its skeleton.");
  if (m.translations.size() != n * at(m.frames) || m.rotations.size() != n * at(m.frames))
    errors.add(ErrorCode::structure, location, "The number of samples is not frames times joints.", "Export the file again.");
  for (std::size_t i = 0; i < n; ++i) {
    const SkeletonJoint& j = m.skeleton.joints[i];
    bool finite = is_finite(j.offset);
    for (const Vec3& e : j.end_sites) finite = finite && is_finite(e);
    if (!finite) errors.add(ErrorCode::range, location + ", joint " + j.name, "The offset is not finite.", "Correct the file.");
    if (j.parent >= static_cast<int>(i))
      errors.add(ErrorCode::structure, location + ", joint " + j.name, "The parent does not precede the joint.",
                 "Put parents before their children in the file.");
  }
  for (const Vec3& t : m.translations)
    if (!is_finite(t)) {
      errors.add(ErrorCode::range, location, "A measured position is not finite.", "Correct the file.");
      break;
    }
  return errors;
}

Pose rest_axes(const Anatomy& a) { return {a.R_WA, {}}; }

Shape turned(Shape s, const Mat3& R) {
  s.X_BS = {R * s.X_BS.R, R * s.X_BS.p};
  return s;
}

/// A measured motion with the anatomy of its character, in the rest pose of its body.
struct Subject {
  MeasuredMotion motion;
  std::vector<Mat3> turns;  ///< [joints] from the file's rest pose; empty: the file's own
  Anatomy anatomy;
  Character character;
};

/// True if the file's rest pose is already a T pose: trunk and limbs differ from the canonical pose by less than 8 degrees. Such a pose is
/// kept, because it is more symmetric than a pose that is estimated from the motion.
bool is_canonical(const Character& c, std::span<const Mat3> turns) {
  if (c.plan != BodyPlan::human || turns.empty()) return false;
  std::vector<int> joints = c.trunk;
  for (const std::array<Limb, 2>* limbs : {&c.legs, &c.arms})
    for (const Limb& l : *limbs) joints.insert(joints.end(), {l.proximal, l.distal});
  return std::ranges::all_of(joints, [&](int i) { return norm(log_map(to_quat(turns[at(i)]))) < 8 * degree; });
}

/// Recognises the character and gives it its canonical rest pose. If a human is recognised only in the file's rest pose, that pose is kept.
Subject make_subject(const MeasuredMotion& motion, const AnatomyMapping* mapping) {
  Subject s;
  s.character = recognise_character(motion, mapping);
  if (s.character.plan == BodyPlan::other && !s.character.corrected) {
    s.anatomy = find_anatomy(motion.skeleton);
    if (s.anatomy.human) {
      s.motion = motion;
      s.character.confidence = 0.5;
      s.character.decisions = {"A human, recognised from the rest pose of the file."};
      return s;
    }
  }
  s.turns = canonical_turns(motion, s.character);
  if (is_canonical(s.character, s.turns)) s.turns.clear();
  s.motion = s.turns.empty() ? motion : with_rest_pose(motion, s.turns);
  s.anatomy = anatomy_of(s.character, s.motion.skeleton);
  return s;
}

/// Makes one body in steps, each of which adds its findings to Body::report.
class Maker {
 public:
  Maker(const MeasuredMotion& motion, const BodyOptions& options)
      : subject_(make_subject(motion, options.mapping)), m_(subject_.motion), o_(options), anatomy_(subject_.anatomy) {}

  Result<Body> run() {
    auto body = build(false);
    // Hinges were accepted by the error at their own children. If these errors accumulate to more than 0.9e-6 m, build again with strict
    // hinges (fit_joint).
    if (body && position_error(*body, m_, convert(*body, m_)) > 0.9e-6) body = build(true);
    if (body) {
      body->rest = subject_.turns;
      body->confidence = subject_.character.confidence;
      body->anatomy = mapping_of(subject_.character, m_.skeleton);
      report_anatomy(*body);
    }
    return body;
  }

 private:
  Result<Body> build(bool strict) {
    strict_ = strict;
    body_ = {};
    spec_ = {};
    body_.human = anatomy_.human;
    body_.level_floor = o_.level_floor;
    name_links();
    for (const SkeletonJoint& j : m_.skeleton.joints) body_.joint_names.push_back(j.name);
    if (anatomy_.human)
      build_human();
    else
      build_creature();
    reset_root_frames();
    auto made = Mechanism::make(spec_);
    if (!made) return fail(std::move(made.error()));
    body_.mechanism = *made;
    body_.mass = body_.mechanism->mass();
    for (const LinkSpec& l : spec_.links) body_.link_of_joint.push_back(body_.mechanism->find_link(l.name));
    fit_limits();
    return body_;
  }

  /// Reports the recognised limbs with their confidences, and each limb that should be checked.
  static void report_anatomy(Body& body) {
    const AnatomyMapping& a = body.anatomy;
    if (a.limbs.empty()) return;
    std::string limbs;
    for (const LimbMapping& l : a.limbs) limbs += (limbs.empty() ? "" : ", ") + l.name + " " + to_fixed(l.confidence, 2);
    body.report.push_back("Anatomy: " + a.plan + ", confidence " + to_fixed(a.confidence, 2) + "; " + limbs + ".");
    constexpr double sure = 0.8;  // below it every fifth limb or more would be wrong, if confidences are probabilities
    for (const LimbMapping& l : a.limbs)
      if (l.confidence < sure)
        body.report.push_back("The " + l.name + " is uncertain (" + to_fixed(l.confidence, 2) + "): " + l.evidence +
                              " Check it, and correct it with a mapping if it is wrong.");
  }

  void note(std::string sentence) { body_.report.push_back(std::move(sentence)); }

  /// Rotation of joint i's frame in its parent's at which the file's DOFs are zero.
  [[nodiscard]] Mat3 zero_of(std::size_t i) const {
    if (subject_.turns.empty()) return Mat3::identity();
    const int parent = m_.skeleton.joints[i].parent;
    return (parent < 0 ? Mat3::identity() : subject_.turns[at(parent)]) * subject_.turns[i].transposed();
  }
  [[nodiscard]] bool is_helper(std::size_t i) const { return !anatomy_.helper.empty() && anatomy_.helper[i] != 0; }
  /// Fixed joint of a link that only follows its parent, at the link's mean position and first orientation relative to the parent.
  [[nodiscard]] Joint follower(std::size_t i) const {
    Joint joint;
    joint.X_PJ.p = m_.skeleton.joints[i].offset;
    if (m_.frames == 0) return joint;
    const std::size_t n = m_.skeleton.joints.size();
    joint.X_PJ.p = {};
    for (int f = 0; f < m_.frames; ++f) joint.X_PJ.p += m_.translations[at(f) * n + i] / m_.frames;
    joint.X_PJ.R = to_matrix(m_.rotations[i]);
    return joint;
  }

  /// Creates a link for each joint, with unique names.
  void name_links() {
    std::set<std::string> used;
    for (const SkeletonJoint& j : m_.skeleton.joints) {
      const std::string wanted = j.name.empty() ? "joint" : j.name;
      std::string name = wanted;
      for (int k = 2; !used.insert(name).second; ++k) name = wanted + " " + std::to_string(k);
      LinkSpec link;
      link.name = std::move(name);
      if (j.parent >= 0) link.parent = spec_.links[at(j.parent)].name;
      spec_.links.push_back(std::move(link));
    }
    spec_.name = m_.skeleton.name.empty() ? m_.name : m_.skeleton.name;
  }

  void build_human() {
    Build build{anatomy_, 0, 0, 1, {}};
    find_size(build);
    find_soles(build);
    const std::vector<Inertia> inertias = human_inertias(build, o_.sex);
    int moved = 0;
    for (std::size_t i = 0; i < spec_.links.size(); ++i) {
      LinkSpec& link = spec_.links[i];
      link.label = label_of(anatomy_, static_cast<int>(i));
      link.inertia = inertias[i].in_parent(rest_axes(anatomy_));
      for (const Shape& s : human_shapes(build, static_cast<int>(i))) link.shapes.push_back(turned(s, anatomy_.R_WA));
      link.joint = is_helper(i) ? follower(i) : fit_joint(m_, static_cast<int>(i), o_, strict_, zero_of(i), body_.report);
      free_ankle(i, link.joint);
      set_joint_properties(link.joint, anatomy_, m_.skeleton.joints[i], static_cast<int>(i), build.mass);
      moved += link.joint.nv() > 0 ? 1 : 0;
    }
    give_mass_to_massless_ends();
    note(m_.frames == 1
             ? "One frame does not show how joints move; " + std::to_string(moved) + " of " + std::to_string(spec_.links.size()) +
                   " joints were made movable."
             : std::to_string(moved) + " of " + std::to_string(spec_.links.size()) + " joints move in this motion; the others are fixed.");
  }

  /// Gives an ankle three axes if the file measures two. Capture systems measure pitch and yaw of a foot but not its inversion. A foot
  /// without inversion stands on one edge of its sole, because the leg decides how the sole is inclined.
  void free_ankle(std::size_t i, Joint& joint) const {
    if (anatomy_.parts[i].part != Part::foot || joint.type != JointType::universal) return;
    joint.X_PJ.R = Mat3::identity();  // the ranges of spherical joints are relative to the rest pose, not to the zero of the file (zero_of)
    joint.type = JointType::spherical;
    joint.axis = {0, 0, 1};
    joint.axis2 = {0, 1, 0};
  }

  /// Sets height, mass and breadth, which are given in the options, taken from the file, or estimated.
  void find_size(Build& build) {
    const auto leg = [&](const Limb& l) {
      return norm(anatomy_.p[at(l.distal)] - anatomy_.p[at(l.proximal)]) + norm(anatomy_.p[at(l.end)] - anatomy_.p[at(l.distal)]);
    };
    const double legs = 0.5 * (leg(anatomy_.legs[0]) + leg(anatomy_.legs[1]));
    build.height = o_.height > 0 ? o_.height : legs / leg_share;
    body_.height = build.height;
    note(o_.height > 0 ? "Height " + to_fixed(build.height, 3) + " m, as given."
                       : "Height " + to_fixed(build.height, 3) + " m, estimated from legs of " + to_fixed(legs, 3) +
                             " m (hip to ankle is 49.1 % of the height).");
    const double bmi = m_.skeleton.mass / (build.height * build.height);
    if (o_.mass > 0) {
      build.mass = o_.mass;
      note("Mass " + to_fixed(build.mass, 1) + " kg, as given.");
    } else if (bmi > 12 && bmi < 60) {
      build.mass = m_.skeleton.mass;
      note("Mass " + to_fixed(build.mass, 1) + " kg, from the file.");
    } else {
      build.mass = 22.5 * build.height * build.height;
      note("Mass " + to_fixed(build.mass, 1) + " kg, estimated as 22.5 kg/m^2 times height squared" +
           (m_.skeleton.mass > 0 ? " (the file's mass is not plausible)." : "."));
    }
    build.breadth = std::sqrt((build.mass / build.height) / (70 / 1.75)) / (build.height / 1.75);
  }

  /// Sets ground normal and thickness of each sole from the stances, otherwise from the shank's direction and usual proportions.
  void find_soles(Build& build) {
    const Mat3 to_anatomical = anatomy_.R_WA.transposed();
    for (int side = 0; side < 2; ++side) {
      const Limb& leg = anatomy_.legs[at(side)];
      Sole sole;
      sole.foot = leg.end;
      sole.toes = leg.tip;
      sole.ball = anatomy_.R_WA * anatomy_.bone[at(leg.end)];
      sole.thickness = nominal_ball * build.height;
      body_.soles.push_back(sole);
    }
    const FloorFit fit = fit_floor(m_, body_.soles, build.height);
    double floor = 0;
    int standing = 0;
    for (const Stance& s : fit.stances)
      if (!s.frames.empty()) {
        floor += s.ball_height - nominal_ball * build.height;
        ++standing;
      }
    for (std::size_t side = 0; side < 2; ++side) {
      const Limb& leg = anatomy_.legs[side];
      Sole& sole = body_.soles[side];
      const Vec3 shank = normalized(anatomy_.p[at(leg.distal)] - anatomy_.p[at(leg.end)]);
      const Vec3 bone = anatomy_.bone[at(leg.end)];
      SoleShape shape;
      shape.foot = sole.foot;
      shape.toes = sole.toes;
      shape.ball = bone;
      // Default normal: the shank's direction, projected to the sagittal plane.
      const Vec3 usual = normalized(shank - Vec3{1, 0, 0} * dot(shank, Vec3{1, 0, 0}));
      shape.foot_up = usual;
      shape.toes_up = usual;
      if (const Stance& s = fit.stances[side]; !s.frames.empty()) {
        sole.thickness = std::clamp(s.ball_height - floor / standing, 0.009 * build.height, 0.032 * build.height);
        const auto plausible = [&](const Vec3& up) { return dot(up, usual) > 0.8; };
        const Vec3 foot_up = to_anatomical * s.foot_up, toes_up = to_anatomical * s.toes_up;
        if (plausible(foot_up)) shape.foot_up = foot_up;
        shape.toes_up = plausible(toes_up) ? toes_up : shape.foot_up;
      }
      const auto forward = [](const Vec3& direction, const Vec3& up) { return normalized(direction - up * dot(direction, up), {1, 0, 0}); };
      shape.foot_forward = forward(bone, shape.foot_up);
      const Vec3 toes = sole.toes >= 0 ? anatomy_.bone[at(sole.toes)] : Vec3{};
      shape.toes_forward = forward(norm(toes) > 0 ? toes : bone, shape.toes_up);
      shape.thickness = sole.thickness;
      const double ball = dot(bone, shape.foot_forward);
      shape.tip = std::max(dot(toes, shape.toes_forward), 0.028 * build.height);
      shape.heel = std::clamp(foot_length * build.height - ball - shape.tip, 0.026 * build.height, 0.036 * build.height);
      shape.ankle = std::max(0.02 * build.height, sole.thickness - dot(bone, shape.foot_up));
      build.soles.push_back(shape);
    }
    if (!fit.found) {
      note("No frame with a standing foot was found; usual proportions are assumed for the soles, and the floor is not corrected.");
      return;
    }
    if (!o_.level_floor) return;
    const Pose X = floor_pose_at_rest(body_, m_);
    note("The floor was found at " + to_fixed(-X.p.z * 100, 1) + " cm in the measured data" +
         (fit.tilt > 1e-9 ? ", tilted by " + to_fixed(fit.tilt / degree, 2) + " degrees; the motion is levelled and shifted onto z = 0."
                          : "; the motion is shifted onto z = 0."));
    note("Soles: " + to_fixed(1000 * body_.soles[0].thickness, 0) + " mm (left) and " + to_fixed(1000 * body_.soles[1].thickness, 0) +
         " mm (right) under the ball, heels " + to_fixed(1000 * build.soles[0].heel, 0) + " mm behind the ankles.");
  }

  /// Gives 2 % of a donor's mass to each movable link whose subtree has no mass: its equation of motion would be singular.
  void give_mass_to_massless_ends() {
    std::vector<double> behind(spec_.links.size(), 0.0);
    for (std::size_t i = behind.size(); i-- > 0;) {
      LinkSpec& link = spec_.links[i];
      behind[i] += link.inertia.mass;
      if (link.joint.nv() > 0 && behind[i] <= 0) {
        Inertia& from = spec_.links[find_donor(i)].inertia;
        const double small_mass = 0.02 * from.mass;
        link.inertia = Inertia::from_centre(small_mass, {}, {1e-4, 1e-4, 1e-4, 0, 0, 0});
        behind[i] += small_mass;
        // The donor keeps its centre of mass; its mass and moments decrease in proportion.
        from = {from.mass - small_mass, from.h * 0.98, from.I * 0.98};
      }
      if (const int parent = m_.skeleton.joints[i].parent; parent >= 0) behind[at(parent)] += behind[i];
    }
  }
  /// Link that gives mass to the massless link `i`: its nearest ancestor with mass. If no ancestor has mass (a second root, a sibling of
  /// the hips): the link with the maximum mass.
  [[nodiscard]] std::size_t find_donor(std::size_t i) const {
    for (int k = m_.skeleton.joints[i].parent; k >= 0; k = m_.skeleton.joints[at(k)].parent)
      if (spec_.links[at(k)].inertia.mass > 0) return at(k);
    const auto heaviest = std::ranges::max_element(spec_.links, {}, [](const LinkSpec& l) { return l.inertia.mass; });
    return static_cast<std::size_t>(heaviest - spec_.links.begin());
  }

  /// Makes the links of a character that is not human.
  void build_creature() {
    const Creature creature = make_creature(subject_.character, m_, o_);
    if (subject_.character.plan == BodyPlan::four_legs)
      note("A four-legged animal with a trunk of " + to_fixed(subject_.character.trunk_length, 3) + " m and legs of " +
           to_fixed(subject_.character.leg_length, 3) + " m (thigh and shank) was recognised.");
    else
      note("No human anatomy was recognised: " + subject_.character.why_not + " The body is made of capsules along the bones.");
    for (const std::string& sentence : creature.notes) note(sentence);
    body_.height = creature.height;
    for (std::size_t i = 0; i < spec_.links.size(); ++i) {
      LinkSpec& link = spec_.links[i];
      const CreatureLink& made = creature.links[i];
      link.label = made.label;
      link.inertia = made.inertia;
      link.shapes = made.shapes;
      const bool root = m_.skeleton.joints[i].parent < 0;
      link.joint = made.follows && !root ? follower(i) : fit_joint(m_, static_cast<int>(i), o_, strict_, zero_of(i), body_.report);
      if (root) continue;
      const SkeletonJoint& source = m_.skeleton.joints[i];
      const bool limited = static_cast<int>(source.dofs.size()) == link.joint.nv() && link.joint.type != JointType::spherical &&
                           std::ranges::all_of(source.dofs, [](const MeasuredDof& d) { return d.limited; });
      for (int k = 0; k < link.joint.nv(); ++k) {
        Dof& f = link.joint.dofs[at(k)];
        f.effort = made.strength;
        f.damping = made.damping;
        f.armature = made.armature;
        if (limited) {
          f.lower = source.dofs[at(k)].lower;
          f.upper = source.dofs[at(k)].upper;
        }
      }
    }
    give_mass_to_massless_ends();
  }

  /// Floating roots start at the world's origin.
  void reset_root_frames() {
    for (LinkSpec& l : spec_.links)
      if (l.joint.type == JointType::floating) l.joint.X_PJ = {};
  }

  /// Reports joints whose angle jumps from one frame to the next.
  void report_jumps(const Motion& motion, const Mechanism& mech) {
    const std::vector<Jump> jumps = find_jumps(motion, mech);
    std::string list;
    for (std::size_t from = 0, to = 0; from < jumps.size(); from = to) {
      while (to < jumps.size() && jumps[to].link == jumps[from].link) ++to;
      list += (from > 0 ? ", " : "") + mech.link(jumps[from].link).name + " (" + std::to_string(to - from) + ")";
    }
    if (!list.empty())
      note("Joints that turn over from one frame to the next in the data: " + list + "; motion control skips these jumps.");
  }

  /// Widens limits that the measured motion exceeds (by a margin of 3 degrees) and sets the springs' rest positions to the motion's median.
  /// Spherical joints that turn by more than 165 degrees get no limits and no spring: their rotation vector wraps around.
  void fit_limits() {
    if (m_.frames < 1) return;
    const Motion motion = convert(body_, m_);
    const Mechanism& mech = *body_.mechanism;
    report_jumps(motion, mech);
    MechanismSpec spec = mech.spec();
    std::string widened;
    int count = 0;
    for (int i = 0; i < mech.link_count(); ++i) {
      const Link& link = mech.link(i);
      const int nv = link.joint.nv();
      if (nv == 0 || link.joint.type == JointType::floating) continue;
      std::vector<std::vector<double>> x(at(nv));
      bool wraps = false;
      for (int f = 0; f < motion.frames; ++f) {
        double d[6];
        joint_displacement(link.joint, motion.frame(f) + link.q_index, d);
        if (link.joint.type == JointType::spherical) wraps = wraps || norm(Vec3{d[0], d[1], d[2]}) > 165 * degree;
        for (int k = 0; k < nv; ++k) x[at(k)].push_back(d[k]);
      }
      bool wider = false;
      for (int k = 0; k < nv; ++k) {
        Dof& f = spec.links[at(i)].joint.dofs[at(k)];
        auto& values = x[at(k)];
        const auto [low, high] = std::minmax_element(values.begin(), values.end());
        if (wraps) {
          f.lower = -std::numeric_limits<double>::infinity();
          f.upper = std::numeric_limits<double>::infinity();
          wider = true;
        } else {
          const double margin = 3 * degree;
          wider = wider || *low < f.lower || *high > f.upper;
          f.lower = std::min(f.lower, *low - margin);
          f.upper = std::max(f.upper, *high + margin);
        }
        const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
        std::nth_element(values.begin(), middle, values.end());
        f.rest = wraps ? 0 : *middle;
        if (wraps) f.stiffness = 0;
      }
      if (wider) {
        widened += (count++ > 0 ? ", " : "") + link.name;
      }
    }
    if (count > 0) note("The motion goes beyond the usual joint limits, which were widened: " + widened + ".");
    auto made = Mechanism::make(std::move(spec));
    UGOKI_CHECK(made.has_value());
    body_.mechanism = *made;
  }

  Subject subject_;
  const MeasuredMotion& m_;
  const BodyOptions& o_;
  const Anatomy& anatomy_;
  MechanismSpec spec_;
  bool strict_ = false;
  Body body_;
};

}  // namespace

Result<Body> make_body(const MeasuredMotion& motion, const BodyOptions& options) {
  if (Error errors = check_input(motion); !errors.empty()) return fail(std::move(errors));
  if (const std::optional<MeasuredMotion> corrected = with_measured_offsets(motion)) return make_body(*corrected, options);
  const int calibration = count_calibration_frames(motion);
  if (calibration == 0) return Maker(motion, options).run();
  Result<Body> body = Maker(without_first(motion, calibration), options).run();
  if (body)
    body->report.push_back(calibration == 1 ? "The first frame is a calibration pose, from which the motion jumps; it is replaced by an "
                                              "extrapolation of the following frames."
                                            : "The motion leaves a calibration pose in the first " + std::to_string(calibration) +
                                                  " frames; they are replaced by an extrapolation of the following frames.");
  return body;
}

}  // namespace ugoki::body
