// Converts <equality> elements of MJCF to loops.

#include <algorithm>
#include <cmath>

#include "ugoki/robot_formats/mjcf_build.h"

namespace ugoki::robot_formats {
namespace {

/// A coordinate frame in a body.
struct BodyFrame {
  int body = 0;
  Pose X_BJ;
};

/// Reads <equality>: loops between bodies, gears between joints, locked joints.
class LoopReader {
 public:
  explicit LoopReader(MjcfBuild& build) : build_(build) {}

  void run() {
    for (const MjcfPart& part : build_.tree.parts)
      for (const MjcfElement& section : part.source->document().sections("equality"))
        for (const MjcfElement& e : part.source->document().children(section)) read(e, part);
  }

 private:
  void read(const MjcfElement& e, const MjcfPart& part) {
    const MjcfAttributes a = part.source->defaults().attributes(e, {}, "equality");
    const std::string_view kind = e.kind();
    if (kind == "connect" || kind == "weld") return read_bodies(e, part, a, kind == "weld");
    if (kind == "joint") return read_joints(e, part, a);
    if (kind == "tendon") return read_tendons(e, part, a);
    e.note("The equality <" + std::string(kind.substr(0, 40)) + "> is left out.");
  }

  void add(LoopSpec loop, const MjcfElement& e, const MjcfPart& part, const MjcfAttributes& a) {
    const std::string own = e.text("name");
    loop.name = own.empty() ? std::string(e.kind()) + "_" + std::to_string(build_.spec.loops.size() + 1) : part.prefix + own + part.suffix;
    while (std::ranges::any_of(build_.spec.loops, [&](const LoopSpec& l) { return l.name == loop.name; })) loop.name += "_";
    loop.closed = a.flag("active", true);
    build_.spec.loops.push_back(std::move(loop));
    build_.loop_elements.push_back(e);
    if (!own.empty()) build_.joints.push_back({own, build_.spec.loops.back().name});
  }

  [[nodiscard]] const MjcfBody& body(int i) const { return build_.tree.bodies[static_cast<std::size_t>(i)]; }

  void read_bodies(const MjcfElement& e, const MjcfPart& part, const MjcfAttributes& a, bool weld) {
    const bool sites = e.has("site1") || e.has("site2");
    if (!has_valid_ends(e, sites, weld)) return;
    const char* const kind = sites ? "site" : "body";
    for (const MjcfPart& copy :
         build_.matching_parts(e, part, {{kind, e.text(sites ? "site1" : "body1")}, {kind, e.text(sites ? "site2" : "body2")}})) {
      BodyFrame A, B;
      if (sites)
        find_sites(e, copy, A, B);
      else
        find_bodies(e, copy, weld, A, B);
      join(e, copy, a, weld, A, B);
    }
  }

  void join(const MjcfElement& e, const MjcfPart& part, const MjcfAttributes& a, bool weld, const BodyFrame& A, const BodyFrame& B) {
    LoopSpec loop;
    loop.type = weld ? LoopType::weld : LoopType::ball;
    const double torque = weld ? a.number("torquescale", 1, not_negative) : 1;
    if (torque == 0) {
      loop.type = LoopType::ball;
      e.note("A weld without torques (torquescale 0) is approximated by a ball joint.");
    } else if (torque != 1) {
      e.note("The softness of a weld (torquescale) is left out.");
    }
    loop.link_a = link_name(A.body);
    loop.link_b = link_name(B.body);
    loop.X_AJ = body(A.body).X_LB * A.X_BJ;
    loop.X_BJ = body(B.body).X_LB * B.X_BJ;
    if (loop.link_a == loop.link_b)
      return e.problem(ErrorCode::structure, e.title() + " connects a body to itself.",
                       "Name two different bodies, or one body and the world.");
    add(std::move(loop), e, part, a);
  }

  [[nodiscard]] std::string link_name(int of_body) const {
    const int link = body(of_body).link;
    return link < 0 ? std::string() : build_.spec.links[static_cast<std::size_t>(link)].name;
  }

  /// True if the element names two sites, or body1 and (for connect) an anchor; otherwise adds a problem.
  [[nodiscard]] static bool has_valid_ends(const MjcfElement& e, bool sites, bool weld) {
    if (sites) {
      for (const char* name : {"body1", "body2", "anchor", "relpose"})
        if (e.has(name)) {
          e.problem(ErrorCode::structure, e.title() + " names both sites and bodies.", "Keep site1 and site2, or body1, body2 and anchor.");
          return false;
        }
      return true;
    }
    if (e.has("body1") && (weld || e.has("anchor"))) return true;
    e.problem(ErrorCode::syntax, e.title() + " names neither " + (weld ? "body1" : "body1 and anchor") + " nor two sites.",
              "Add the missing attributes.");
    return false;
  }

  void find_sites(const MjcfElement& e, const MjcfPart& part, BodyFrame& A, BodyFrame& B) const {
    const MjcfSite a = *build_.find_site(part, e.text("site1")), b = *build_.find_site(part, e.text("site2"));
    A = {a.body, a.X_BS};
    B = {b.body, b.X_BS};
  }

  /// Finds the frames A in body 1 and B in body 2 that an equality constrains. connect: `anchor` is a point in body 1; B is the same point
  /// of space in the pose of the file. weld: `anchor` is a point in body 2; A is computed from relpose or, without relpose, from the pose
  /// of the file.
  void find_bodies(const MjcfElement& e, const MjcfPart& part, bool weld, BodyFrame& A, BodyFrame& B) const {
    A.body = build_.find_body(part, e.text("body1"));
    B.body = build_.find_body(part, e.text("body2"));
    const Pose X_12 = body(A.body).X_WB.inverse() * body(B.body).X_WB;
    const Vec3 anchor = e.file->vec3(e.attribute("anchor"), {});
    if (!weld) {
      A.X_BJ.p = anchor;
      B.X_BJ = X_12.inverse() * A.X_BJ;
      return;
    }
    B.X_BJ.p = anchor;
    double relative[7] = {};
    (void)e.file->numbers(e.attribute("relpose"), relative);
    const Quat q{relative[3], relative[4], relative[5], relative[6]};
    if (q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z > 1e-28)
      A.X_BJ = {to_matrix(normalized(q)), {relative[0], relative[1], relative[2]}};
    else
      A.X_BJ = X_12 * B.X_BJ;
  }

  void read_joints(const MjcfElement& e, const MjcfPart& part, const MjcfAttributes& a) {
    std::vector<MjcfBuild::Reference> names = {{"joint", e.text("joint1")}};
    if (e.has("joint2")) names.push_back({"joint", e.text("joint2")});
    for (const MjcfPart& copy : build_.matching_parts(e, part, names)) {
      MjcfJoint* const second = e.has("joint2") ? build_.find_joint(copy, e.text("joint2")) : nullptr;
      couple(e, copy, a, *build_.find_joint(copy, e.text("joint1")), second, polynomial(e));
    }
  }

  [[nodiscard]] static std::array<double, 5> polynomial(const MjcfElement& e) {
    std::array<double, 5> c = {0, 1, 0, 0, 0};
    if (!e.has("polycoef")) return c;
    const std::vector<double> given = e.file->list(e.attribute("polycoef"), 1, c.size());
    std::ranges::copy(given, c.begin());
    return c;
  }

  void couple(const MjcfElement& e, const MjcfPart& part, const MjcfAttributes& a, MjcfJoint& first, MjcfJoint* second,
              const std::array<double, 5>& c) {
    for (const MjcfJoint* j : {static_cast<const MjcfJoint*>(&first), static_cast<const MjcfJoint*>(second)})
      if (j && j->type != MjcfJointType::hinge && j->type != MjcfJointType::slide)
        return e.problem(ErrorCode::structure, e.title() + " couples a joint that is neither a hinge nor a slide.",
                         "Couple hinges and slides.");
    if (second == &first) return e.problem(ErrorCode::structure, e.title() + " couples a joint with itself.", "Name two different joints.");
    if (!second) {
      if (!a.flag("active", true)) return e.note("An equality that would lock a joint, but is inactive at the start, is left out.");
      Dof& f = build_.dof_of(first);
      f.lower = f.upper = c[0];
      e.note("A joint that an equality locks has both limits at the locked position.");
      return;
    }
    LoopSpec loop;
    loop.type = LoopType::gear;
    loop.link_a = build_.link_of(first).name;
    loop.link_b = build_.link_of(*second).name;
    loop.polynomial = c;
    add(std::move(loop), e, part, a);
  }

  /// Reads an equality of a <fixed> tendon (a linear combination of joint coordinates). It couples one or two joints like a gear.
  void read_tendons(const MjcfElement& e, const MjcfPart& part, const MjcfAttributes& a) {
    std::vector<MjcfElement> members;
    for (const MjcfElement& section : part.source->document().sections("tendon"))
      for (const MjcfElement& t : part.source->document().children(section))
        if (t.kind() == "fixed" && t.text("name") == e.text("tendon1")) members = part.source->document().children(t);
    if (e.has("tendon2") || members.empty() || members.size() > 2)
      return e.note("An equality of tendons is left out, unless it is for one fixed tendon of one or two joints.");
    double factors[2] = {1, 0};
    std::vector<MjcfBuild::Reference> names;
    for (std::size_t i = 0; i < members.size(); ++i) {
      names.push_back({"joint", members[i].text("joint")});
      factors[i] = members[i].file->number(members[i].attribute("coef"), 0);
    }
    if (!(std::fabs(factors[0]) > 1e-9))
      return e.problem(ErrorCode::range, "The first coefficient of the tendon is zero.", "Remove that joint from the tendon.");
    for (const MjcfPart& copy : build_.matching_parts(members[0], part, names))
      couple(e, copy, a, *build_.find_joint(copy, names[0].name), names.size() > 1 ? build_.find_joint(copy, names[1].name) : nullptr,
             {polynomial(e)[0] / factors[0], -factors[1] / factors[0], 0, 0, 0});
  }

  MjcfBuild& build_;
};

}  // namespace

namespace {
/// Finds a name with the prefix and suffix of a part. Inside a copy of a <replicate>, a name may also mean an object outside the copy.
template <class Map>
auto find_in(const Map& map, const MjcfPart& part, const std::string& name) {
  const auto it = map.find(part.prefix + name + part.suffix);
  return it == map.end() && part.copied ? map.find(part.prefix + name) : it;
}
}  // namespace

MjcfJoint* MjcfBuild::find_joint(const MjcfPart& part, const std::string& name) {
  const auto it = find_in(tree.joint_named, part, name);
  if (it == tree.joint_named.end() || it->second.joint >= tree.bodies[it->second.body].joints.size()) return nullptr;
  return &joint_at(it->second);
}

const MjcfSite* MjcfBuild::find_site(const MjcfPart& part, const std::string& name) const {
  const auto it = find_in(tree.site_named, part, name);
  return it == tree.site_named.end() ? nullptr : &it->second;
}

int MjcfBuild::find_body(const MjcfPart& part, const std::string& name) const {
  if (name.empty() || name == "world") return 0;
  const auto it = find_in(tree.body_named, part, name);
  return it == tree.body_named.end() ? -1 : static_cast<int>(it->second);
}

std::vector<MjcfPart> MjcfBuild::matching_parts(const MjcfElement& e, const MjcfPart& part, const std::vector<Reference>& names) {
  const auto missing = [&](const MjcfPart& in) {  // returns the first name in `names` that is unknown in the part
    return std::ranges::find_if(names, [&](const Reference& r) {
      const std::string_view kind = r.kind;
      return kind == "joint" ? !find_joint(in, r.name) : kind == "site" ? !find_site(in, r.name) : find_body(in, r.name) < 0;
    });
  };
  const auto first = missing(part);
  if (first == names.end()) return {part};
  std::vector<MjcfPart> out;
  if (const auto it = tree.copies.find(std::string(first->kind) + " " + part.prefix + first->name); it != tree.copies.end())
    for (const std::string& suffix : it->second) {
      MjcfPart copy = part;
      copy.suffix = suffix;
      copy.copied = true;
      if (missing(copy) == names.end()) out.push_back(std::move(copy));
    }
  if (!out.empty()) return out;
  const std::string reason = "no " + std::string(first->kind) + " is named " + formats::in_quotes(first->name) + ".";
  if (part.attached)
    e.note("<" + std::string(e.kind()) + "> of an attached model is left out: " + reason);
  else
    e.problem(ErrorCode::unknown, e.title() + ": " + reason, "Correct the name.");
  return out;
}

void read_mjcf_loops(MjcfBuild& build) { LoopReader(build).run(); }

}  // namespace ugoki::robot_formats
