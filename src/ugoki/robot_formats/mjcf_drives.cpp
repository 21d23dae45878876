// <actuator> and <keyframe> of MJCF, and notes about elements that a mechanism cannot store.

#include <algorithm>
#include <cmath>

#include "ugoki/base/number.h"
#include "ugoki/robot_formats/mjcf_build.h"
#include "ugoki/robot_formats/mjcf_elements.h"

namespace ugoki::robot_formats {
namespace {

constexpr double infinite = std::numeric_limits<double>::infinity();

/// True if the actuator's force depends on the state (position, velocity), so that ctrlrange does not limit the force.
bool has_feedback(const MjcfAttributes& a) {
  const auto feeds_back = [](std::string_view kind) {
    return kind == "position" || kind == "velocity" || kind == "intvelocity" || kind == "damper" || kind == "cylinder" || kind == "dcmotor";
  };
  if (a.own().kind() != "general") return feeds_back(a.own().kind());
  if (a.has("biastype")) return a.text("biastype") != "none";
  return std::ranges::any_of(a.levels(), [&](const MjcfElement& e) { return feeds_back(e.kind()); });
}

/// Larger magnitude of the two bounds in the attribute `range`; infinite if the attribute is absent.
double max_magnitude(const MjcfAttributes& a, const char* range) {
  double v[2] = {0, 0};
  return a.range(range, v) ? std::max(std::fabs(v[0]), std::fabs(v[1])) : infinite;
}

/// Maximum force of an actuator before multiplication by its gear, N or N m; infinite if the force has no limit.
double max_force(const MjcfCompiler& c, const MjcfAttributes& a) {
  if (mjcf_limited(c, a, "forcelimited", "forcerange")) return max_magnitude(a, "forcerange");
  if (has_feedback(a) || a.own().kind() == "muscle" || !mjcf_limited(c, a, "ctrllimited", "ctrlrange")) return infinite;
  double gain[10] = {1, 0, 0, 0, 0, 0, 0, 0, 0, 0};
  if (a.own().kind() == "general") {
    if (a.has("gaintype") && a.text("gaintype") != "fixed") return infinite;
    (void)a.overlay("gainprm", gain);
  }
  return std::fabs(gain[0]) * max_magnitude(a, "ctrlrange");
}

/// Reads <actuator>: finds the driven joints, and sums the force limits of their actuators.
class DriveReader {
 public:
  explicit DriveReader(MjcfBuild& build) : build_(build), efforts_(build.spec.links.size(), 0.0), driven_(build.spec.links.size(), false) {}

  void run() {
    for (const MjcfPart& part : build_.tree.parts)
      for (const MjcfElement& section : part.source->document().sections("actuator"))
        for (const MjcfElement& e : part.source->document().children(section)) read(e, part);
    for (std::size_t i = 0; i < driven_.size(); ++i) {
      if (!driven_[i]) continue;
      build_.driven.push_back(build_.spec.links[i].name);
      Joint& joint = build_.spec.links[i].joint;
      for (int k = 0; k < joint.nv(); ++k) {
        Dof& f = joint.dofs[static_cast<std::size_t>(k)];
        f.effort = std::min(f.effort, efforts_[i]);
      }
    }
  }

 private:
  void read(const MjcfElement& e, const MjcfPart& part) {
    const MjcfAttributes a = part.source->defaults().attributes(e, {});
    const char* const by = a.has("joint") ? "joint" : "jointinparent";
    if (!a.has(by)) return e.note("An actuator that does not act on a joint is left out (<" + std::string(e.kind().substr(0, 40)) + ">).");
    if (e.kind() == "muscle" || e.kind() == "plugin")
      e.note("The force limit of a muscle or plugin actuator is left out; its joint counts as driven.");
    double gear[6] = {1, 0, 0, 0, 0, 0};
    (void)a.overlay("gear", gear);
    for (const MjcfPart& copy : build_.matching_parts(e, part, {{"joint", a.text(by)}}))
      add(*build_.find_joint(copy, a.text(by)), std::fabs(gear[0]) * max_force(part.source->compiler(), a));
  }

  /// Adds the effort limit of one actuator. 0 * infinity (gear 0, actuator without limit) is NaN and counts as no limit.
  void add(const MjcfJoint& joint, double effort) {
    const auto link = static_cast<std::size_t>(joint.link);
    const bool scalar = joint.type == MjcfJointType::hinge || joint.type == MjcfJointType::slide;
    driven_[link] = true;
    if (!scalar) efforts_[link] = infinite;
    efforts_[link] += effort;
    if (std::isnan(efforts_[link])) efforts_[link] = infinite;
  }

  MjcfBuild& build_;
  std::vector<double> efforts_;  ///< [links] sum of the limits of all actuators of the link's joint, N or N m
  std::vector<bool> driven_;
};

void note_options(const MjcfElement& e, const MjcfDocument& document) {
  const MjcfAttributes a(e);
  if (a.has("gravity")) {
    const Vec3 g = a.vec3("gravity", {});
    e.note("The model specifies gravity: " + to_text(g.x) + " " + to_text(g.y) + " " + to_text(g.z) + " m/s^2.");
  }
  if (a.has("timestep")) e.note("The model specifies a time step of " + to_text(a.number("timestep", 0)) + " s.");
  if (a.number("density", 0) > 0 || a.number("viscosity", 0) > 0) e.note("The fluid around the model (density, viscosity) is left out.");
  for (const MjcfElement& flag : document.children(e))
    if (flag.kind() == "flag" && flag.text("gravity") == "disable") flag.note("The model switches gravity off.");
}

}  // namespace

void read_mjcf_drives(MjcfBuild& build) { DriveReader(build).run(); }

void note_mjcf_left_out(const MjcfBuild& build) {
  for (const MjcfPart& part : build.tree.parts) {
    const MjcfDocument& document = part.source->document();
    for (const MjcfElement& section : document.children(document.root())) {
      const std::string_view kind = section.kind();
      if (kind == "option") note_options(section, document);
      if (kind == "extension" || kind == "deformable") section.note("<" + std::string(kind) + "> is left out.");
      if (kind != "tendon") continue;
      for (const MjcfElement& e : document.children(section)) {
        if (e.kind() == "spatial") e.note("A spatial tendon is left out, with its limits and springs.");
        if (e.kind() == "fixed") e.note("A fixed tendon is left out, with its limits and springs.");
      }
    }
  }
}

void read_mjcf_keyframes(MjcfBuild& build) {
  const MjcfPart& part = build.tree.parts[0];
  std::size_t wanted = 0;
  for (const MjcfBody& body : build.tree.bodies)
    for (const MjcfJoint& joint : body.joints) wanted += joint.type == MjcfJointType::free ? 7 : joint.type == MjcfJointType::ball ? 4 : 1;
  for (const MjcfElement& section : part.source->document().sections("keyframe"))
    for (const MjcfElement& e : part.source->document().children(section)) {
      if (!e.has("qpos")) continue;
      if (build.tree.deformables_left_out || build.options.base != Base::by_file) {
        e.note("Keyframes are left out, because the file's joints differ from those of the mechanism.");
        return;
      }
      const std::vector<double> theirs = e.file->list(e.attribute("qpos"), wanted, wanted);
      if (theirs.size() != wanted) continue;
      NamedPosition position;
      position.name = e.has("name") ? e.text("name") : "key_" + std::to_string(build.positions.size() + 1);
      std::size_t at = 0;
      const auto quaternion = [&](std::size_t i) { return normalized(Quat{theirs[i], theirs[i + 1], theirs[i + 2], theirs[i + 3]}); };
      const auto put = [&](const Quat& q) { position.q.insert(position.q.end(), {q.w, q.x, q.y, q.z}); };
      for (const MjcfBody& body : build.tree.bodies)
        for (const MjcfJoint& joint : body.joints) {
          if (joint.type == MjcfJointType::free) {
            const Pose X_JB = body.X_WB.inverse() * Pose{to_matrix(quaternion(at + 3)), {theirs[at], theirs[at + 1], theirs[at + 2]}};
            position.q.insert(position.q.end(), {X_JB.p.x, X_JB.p.y, X_JB.p.z});
            put(to_quat(X_JB.R));
            at += 7;
          } else if (joint.type == MjcfJointType::ball) {
            put(quaternion(at));
            at += 4;
          } else {
            position.q.push_back(theirs[at++] - joint.ref);
          }
        }
      build.positions.push_back(std::move(position));
    }
}

}  // namespace ugoki::robot_formats
