#include "ugoki/motion_edit/mirror.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>

#include "ugoki/mechanism/state.h"
#include "ugoki/motion/clip.h"

namespace ugoki::motion_edit {
namespace {

constexpr double alike = 0.9;  // minimum |cosine| between an axis and the mirror image of its partner's axis

std::size_t at(int i) { return static_cast<std::size_t>(i); }

Vec3 reflected(const Vec3& v) { return {v.x, -v.y, v.z}; }        // mirror image of a position or direction
Vec3 reflected_turn(const Vec3& w) { return {-w.x, w.y, -w.z}; }  // mirror image of an axis of rotation

/// The name with left and right exchanged; unchanged if it contains neither.
std::string other_side(const std::string& name) {
  static constexpr std::array<std::pair<const char*, const char*>, 3> words = {{{"left", "right"}, {"Left", "Right"}, {"LEFT", "RIGHT"}}};
  for (const auto& [left, right] : words) {
    std::string out = name;
    if (const auto i = name.find(left); i != std::string::npos) return out.replace(i, std::string(left).size(), right);
    if (const auto i = name.find(right); i != std::string::npos) return out.replace(i, std::string(right).size(), left);
  }
  const auto swapped = [](char c) { return c == 'l' ? 'r' : c == 'r' ? 'l' : c == 'L' ? 'R' : c == 'R' ? 'L' : '\0'; };
  const auto separator = [](char c) { return c == '_' || c == '.' || c == ' ' || c == '-' || c == ':'; };
  for (std::size_t i = 0; i < name.size(); ++i) {  // a single letter l or r between separators or at an end of the name
    const bool begins = i == 0 || separator(name[i - 1]), ends = i + 1 == name.size() || separator(name[i + 1]);
    if (!begins || !ends || !swapped(name[i])) continue;
    std::string out = name;
    out[i] = swapped(name[i]);
    return out;
  }
  return name;
}

/// The name with a first letter l or r replaced by the other one, as in "lfemur"; otherwise unchanged.
std::string other_initial(std::string name) {
  if (name.size() < 2) return name;
  const char c = name[0];
  name[0] = c == 'l' ? 'r' : c == 'r' ? 'l' : c == 'L' ? 'R' : c == 'R' ? 'L' : c;
  return name;
}

int find_by(const Mechanism& m, const std::string& name, bool label) {
  int found = -1;
  for (int i = 0; i < m.link_count(); ++i) {
    if ((label ? m.link(i).label : m.link(i).name) != name) continue;
    if (found >= 0) return -1;
    found = i;
  }
  return found;
}

struct Reflection {
  const Mechanism& m;
  std::vector<int> partner;
  std::vector<Mat3> axes;  // [links] orientation of the joint frames in the world in the neutral position

  /// Factor from the coordinate of link i's partner (axis `other`) to the mirrored coordinate of link i (axis `own`): 1 or -1; 0 if the
  /// axes are not mirror images.
  /// @param turns true: the coordinate is an angle; false: a displacement
  [[nodiscard]] double sign(int i, const Vec3& own, const Vec3& other, bool turns) const {
    const Vec3 there = axes[at(partner[at(i)])] * other, image = turns ? reflected_turn(there) : reflected(there);
    const double c = dot(axes[at(i)] * own, image);
    return c > alike ? 1 : c < -alike ? -1 : 0;
  }
  [[nodiscard]] Quat turned(int i, const Quat& q) const {
    const Vec3 v = transpose_times(axes[at(i)], reflected_turn(axes[at(partner[at(i)])] * Vec3{q.x, q.y, q.z}));
    return {q.w, v.x, v.y, v.z};
  }
};

Error not_alike(const Mechanism& m, int i, int k) {
  return {ErrorCode::structure, "joint of link " + m.link(i).name,
          "The joint is not the mirror image of the joint of link " + m.link(k).name + ".",
          "Make the mechanism symmetric, with the same joint types and mirrored axes on both sides. For measured files, keep all joints "
          "movable."};
}

}  // namespace

std::vector<int> find_mirror_links(const Mechanism& m) {
  const int n = m.link_count();
  std::vector<int> out(at(n), -1);
  for (int i = 0; i < n; ++i) {
    const Link& link = m.link(i);
    int k = -1;
    if (const std::string other = other_side(link.name); other != link.name) k = find_by(m, other, false);
    if (k < 0 && !link.label.empty())
      if (const std::string other = other_side(link.label); other != link.label) k = find_by(m, other, true);
    if (k < 0)
      if (const std::string other = other_initial(link.name); other != link.name) k = find_by(m, other, false);
    if (k >= 0) out[at(i)] = k;
  }
  for (int i = 0; i < n; ++i)  // keep only mutual partners
    if (out[at(i)] >= 0 && out[at(out[at(i)])] != i) out[at(i)] = -1;
  std::vector<Pose> X(at(n));
  calc_poses(m, m.neutral(), X);
  double size = 0;
  for (const Pose& pose : X) size = std::max(size, norm(pose.p - X[0].p));
  const auto depth = [&](int i) {
    int d = 0;
    for (; i >= 0; i = m.link(i).parent) ++d;
    return d;
  };
  for (int i = 0; i < n; ++i) {
    if (out[at(i)] >= 0) continue;
    const Vec3 p = X[at(i)].p - X[0].p, image = reflected(p);
    int best = i;
    double minimum = std::fabs(p.y) < 0.02 * size ? 0.0 : 0.05 * size;  // a link in the plane of symmetry is its own partner
    for (int k = 0; k < n; ++k) {
      if (k == i || out[at(k)] >= 0 || depth(k) != depth(i) || m.link(k).joint.type != m.link(i).joint.type) continue;
      if (const double off = norm(X[at(k)].p - X[0].p - image); off < minimum) {
        minimum = off;
        best = k;
      }
    }
    out[at(i)] = best;
    out[at(best)] = i;
  }
  return out;
}

Result<Motion> mirror(const Mechanism& m, const Motion& motion) {
  if (Error wrong = check_motion(motion, m); !wrong.empty()) return fail(std::move(wrong));
  Reflection r{m, find_mirror_links(m), {}};
  std::vector<Pose> X(at(m.link_count()));
  calc_poses(m, m.neutral(), X);
  for (const Link& link : m.links()) r.axes.push_back((link.parent < 0 ? Mat3::identity() : X[at(link.parent)].R) * link.joint.X_PJ.R);
  // Signs of the coordinates of joints with scalar coordinates (not planar, spherical or floating).
  Error errors;
  std::vector<std::array<double, 2>> signs(at(m.link_count()), {1, 1});
  for (int i = 0; i < m.link_count(); ++i) {
    const int k = r.partner[at(i)];
    const Joint &own = m.link(i).joint, &other = m.link(k).joint;
    std::array<double, 2>& s = signs[at(i)];
    if (own.type == JointType::fixed || other.type == JointType::fixed) continue;
    const bool good = own.type == other.type;
    switch (own.type) {
      case JointType::revolute:
      case JointType::helical: s[0] = r.sign(i, own.axis, other.axis, true); break;
      case JointType::prismatic: s[0] = r.sign(i, own.axis, other.axis, false); break;
      case JointType::cylindrical: s = {r.sign(i, own.axis, other.axis, true), r.sign(i, own.axis, other.axis, false)}; break;
      case JointType::universal: s = {r.sign(i, own.axis, other.axis, true), r.sign(i, own.axis2, other.axis2, true)}; break;
      default: break;
    }
    if (!good || s[0] == 0 || s[1] == 0) errors.problems.push_back(not_alike(m, i, k).problems.front());
  }
  if (!errors.empty()) return fail(std::move(errors));
  const auto nq = at(m.nq());
  Placement plane = root_placement(m, {motion.frame(0), nq});
  plane.z = 0;
  Motion out = motion;
  std::vector<double> q(nq);
  for (int f = 0; f < motion.frames; ++f) {
    std::copy_n(motion.frame(f), nq, q.data());
    displace_root(m, inverse(plane), q);
    double* to = out.frame(f);
    for (int i = 0; i < m.link_count(); ++i) {
      const int k = r.partner[at(i)];
      const Joint& joint = m.link(i).joint;
      const double* from = q.data() + m.link(k).q_index;
      double* own = to + m.link(i).q_index;
      if (m.link(k).joint.type == JointType::fixed) {
        joint_neutral(joint, own);
        continue;
      }
      switch (joint.type) {
        case JointType::fixed: break;
        case JointType::revolute:
        case JointType::helical:
        case JointType::prismatic: own[0] = signs[at(i)][0] * from[0]; break;
        case JointType::cylindrical:
        case JointType::universal:
          for (int c = 0; c < 2; ++c) own[c] = signs[at(i)][at(c)] * from[c];
          break;
        case JointType::planar:
        case JointType::floating: {
          const Vec3 location{from[0], from[1], joint.type == JointType::planar ? 0.0 : from[2]};
          const Vec3 there = r.axes[at(k)] * location + m.link(k).joint.X_PJ.p;
          const Vec3 p = transpose_times(r.axes[at(i)], reflected(there) - joint.X_PJ.p);
          own[0] = p.x;
          own[1] = p.y;
          if (joint.type == JointType::planar) {
            own[2] = -from[2] * (dot(r.axes[at(i)].column(2), r.axes[at(k)].column(2)) >= 0 ? 1 : -1);
            break;
          }
          own[2] = p.z;
          const Quat turn = r.turned(i, {from[3], from[4], from[5], from[6]});
          std::copy_n(std::array{turn.w, turn.x, turn.y, turn.z}.data(), 4, own + 3);
          break;
        }
        case JointType::spherical: {
          const Quat turn = r.turned(i, {from[0], from[1], from[2], from[3]});
          std::copy_n(std::array{turn.w, turn.x, turn.y, turn.z}.data(), 4, own);
          break;
        }
      }
    }
    displace_root(m, plane, {to, nq});
  }
  for (std::size_t t = 0; t < out.contacts.size(); ++t) {
    const int link = m.find_link(out.contacts[t].link);
    if (link >= 0) out.contacts[t].link = m.link(r.partner[at(link)]).name;
  }
  return out;
}

}  // namespace ugoki::motion_edit
