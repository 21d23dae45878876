// Converts springdamper of MJCF joints, a time constant and a damping ratio, to stiffness and damping.

#include <algorithm>
#include <cmath>

#include "ugoki/robot_formats/mjcf_build.h"

namespace ugoki::robot_formats {
namespace {

constexpr int max_dofs = 1000;       // limit, because the inertia matrix is dense and is factored in O(nv^3)
constexpr double min_value = 1e-15;  // MuJoCo's mjMINVAL: lower bound of every divisor

/// The diagonal of M^-1 at the pose of the file; M is the joint-space inertia matrix of the mechanism.
class RestInertia {
 public:
  explicit RestInertia(const MechanismSpec& spec) : links_(spec.links.size()) {
    std::map<std::string, std::size_t, std::less<>> index;
    for (std::size_t i = 0; i < links_.size(); ++i) {
      const LinkSpec& from = spec.links[i];
      Link& link = links_[i];
      link.first = dofs_;
      link.count = from.joint.nv();
      dofs_ += link.count;
      const Pose& X_PJ = from.joint.X_PJ;
      if (!from.parent.empty()) link.parent = static_cast<int>(index.find(from.parent)->second);
      link.X = link.parent < 0 ? X_PJ : links_[static_cast<std::size_t>(link.parent)].X * X_PJ;
      index.emplace(from.name, i);
    }
    if (dofs_ > max_dofs) return;
    for (std::size_t i = 0; i < links_.size(); ++i) add_columns(spec.links[i], links_[i]);
    fill(spec);
    factor();
  }

  /// Returns false if there are more than max_dofs DOFs or M is not positive definite.
  [[nodiscard]] bool works() const { return works_; }
  /// Mean of the diagonal entries of M^-1 over the DOFs of a link's joint, 1/kg or 1/(kg m^2).
  [[nodiscard]] double of_link(int link) const {
    const Link& l = links_[static_cast<std::size_t>(link)];
    double sum = 0;
    for (int k = 0; k < l.count; ++k) sum += inverse(l.first + k);
    return l.count > 0 ? sum / l.count : 0;
  }

 private:
  struct Link {
    int parent = -1, first = 0, count = 0;
    Pose X;
  };

  double& at(int i, int j) { return M_[static_cast<std::size_t>(i * dofs_ + j)]; }
  [[nodiscard]] double at(int i, int j) const { return M_[static_cast<std::size_t>(i * dofs_ + j)]; }

  /// Appends the motion subspaces of a link's joint, in world axes about the world's origin.
  void add_columns(const LinkSpec& from, const Link& link) {
    const auto turn = [&](const Vec3& axis) {
      const Vec3 w = link.X.R * axis;
      S_.push_back({w, cross(link.X.p, w)});
    };
    const auto slide = [&](const Vec3& axis) { S_.push_back({{}, link.X.R * axis}); };
    const Vec3 axes[] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    if (from.joint.type == JointType::revolute) turn(from.joint.axis);
    if (from.joint.type == JointType::prismatic) slide(from.joint.axis);
    if (from.joint.type == JointType::spherical || from.joint.type == JointType::floating)
      for (const Vec3& e : axes) turn(e);
    if (from.joint.type == JointType::floating)
      for (const Vec3& e : axes) slide(e);
  }

  /// Fills the inertia matrix by the composite-rigid-body algorithm (Featherstone 2008, table 6.2).
  void fill(const MechanismSpec& spec) {
    M_.assign(static_cast<std::size_t>(dofs_) * static_cast<std::size_t>(dofs_), 0.0);
    std::vector<Inertia> composite(links_.size());
    for (std::size_t i = links_.size(); i-- > 0;) {
      composite[i] += spec.links[i].inertia.in_parent(links_[i].X);
      if (links_[i].parent >= 0) composite[static_cast<std::size_t>(links_[i].parent)] += composite[i];
      for (int k = 0; k < links_[i].count; ++k) {
        const int column = links_[i].first + k;
        const Vec6 momentum = composite[i] * S_[static_cast<std::size_t>(column)];
        for (int l = static_cast<int>(i); l >= 0; l = links_[static_cast<std::size_t>(l)].parent) {
          const Link& above = links_[static_cast<std::size_t>(l)];
          for (int r = above.first; r < above.first + above.count; ++r)
            at(r, column) = at(column, r) = dot(S_[static_cast<std::size_t>(r)], momentum);
        }
        at(column, column) += spec.links[i].joint.dofs[static_cast<std::size_t>(k)].armature;
      }
    }
  }

  /// Cholesky factorisation M = L L^T; L replaces the lower half of M.
  void factor() {
    for (int j = 0; j < dofs_; ++j) {
      double d = at(j, j);
      for (int k = 0; k < j; ++k) d -= at(j, k) * at(j, k);
      if (!(d > 0)) return;
      at(j, j) = std::sqrt(d);
      for (int i = j + 1; i < dofs_; ++i) {
        double s = at(i, j);
        for (int k = 0; k < j; ++k) s -= at(i, k) * at(j, k);
        at(i, j) = s / at(j, j);
      }
    }
    works_ = true;
  }

  /// Diagonal entry of M^-1 for a DOF: |L^-1 e|^2, e: unit vector of this DOF.
  [[nodiscard]] double inverse(int dof) const {
    std::vector<double> y(static_cast<std::size_t>(dofs_), 0.0);
    double sum = 0;
    for (int i = dof; i < dofs_; ++i) {
      double s = i == dof ? 1 : 0;
      for (int k = dof; k < i; ++k) s -= at(i, k) * y[static_cast<std::size_t>(k)];
      s /= at(i, i);
      y[static_cast<std::size_t>(i)] = s;
      sum += s * s;
    }
    return sum;
  }

  std::vector<Link> links_;
  std::vector<Vec6> S_;    ///< [dofs] motion subspaces
  std::vector<double> M_;  ///< [dofs x dofs] inertia matrix, then its Cholesky factor
  int dofs_ = 0;
  bool works_ = false;
};

}  // namespace

void set_mjcf_springs(MjcfBuild& build) {
  const auto wanted = [](const MjcfJoint& j) { return j.springdamper[0] > 0 && j.springdamper[1] > 0 && j.link >= 0; };
  const bool any = std::ranges::any_of(build.tree.bodies, [&](const MjcfBody& b) { return std::ranges::any_of(b.joints, wanted); });
  if (!any) return;
  const RestInertia rest(build.spec);
  for (const MjcfBody& body : build.tree.bodies)
    for (const MjcfJoint& joint : body.joints) {
      if (!wanted(joint)) continue;
      if (!rest.works()) {
        joint.element.note("springdamper is left out: the model has more than 1000 degrees of freedom, or one without inertia.");
        continue;
      }
      const double inertia = 1 / std::max(min_value, rest.of_link(joint.link));
      const double time = joint.springdamper[0], ratio = joint.springdamper[1];
      Joint& to = build.link_of(joint).joint;
      for (int k = 0; k < to.nv(); ++k) {
        Dof& f = to.dofs[static_cast<std::size_t>(k)];
        if (joint.type != MjcfJointType::free) f.stiffness = inertia / std::max(min_value, time * time * ratio * ratio);
        f.damping = 2 * inertia / std::max(min_value, time);
      }
    }
}

}  // namespace ugoki::robot_formats
