#include "ugoki/posing/pose_goals.h"

#include <algorithm>
#include <cmath>

#include "ugoki/spatial/rotation.h"

namespace ugoki::posing {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

/// A point of a link and the link's motion, relative to which rows of the Jacobian are written. Link -1: the world.
struct Side {
  Pose X;
  std::vector<std::uint8_t> moved_by;  // [links] 1: the joint of this link moves the side
};

class Writer {
 public:
  Writer(const Mechanism& m, std::span<const Variable> variables, std::span<const double> q, std::span<const Pose> X_WB, Equations& out)
      : m_(m), variables_(variables), q_(q), X_WB_(X_WB), out_(out) {
    out_.count = 0;
    out_.residual.clear();
    out_.J.clear();
  }

  void goal(const PoseGoal& g) {
    const Side side = side_of(g.link, Pose{Mat3::identity(), g.point});
    const Side world = side_of(-1, {});
    translation_rows(world, side, side.X.p - g.target, Mat3::identity());
    if (!g.turn) return;
    const Vec3 turn = log_map(to_quat(X_WB_[at(g.link)].R * g.R.transposed()));
    rotation_rows(world, side, turn, Mat3::identity());
  }

  void loop(const Loop& l) {
    using enum LoopType;
    if (l.type == gear) return gear_row(l);
    const Side a = side_of(l.link_a, l.X_AJ), b = side_of(l.link_b, l.X_BJ);
    const Vec3 axis_a = a.X.R * l.axis, axis_b = b.X.R * l.axis, p = b.X.p - a.X.p;
    const Mat3 along = Mat3::columns(axis_a * axis_a.x, axis_a * axis_a.y, axis_a * axis_a.z);
    switch (l.type) {
      case weld:
      case ball:
      case revolute:
      case universal: translation_rows(a, b, p, Mat3::identity()); break;
      case prismatic:
      case cylindrical: translation_rows(a, b, p - along * p, Mat3::identity() - along); break;
      case planar: translation_rows(a, b, along * p, along); break;
      case distance: distance_row(a, b, p, l.length); break;
      case gear: break;
    }
    if (l.type == weld || l.type == prismatic) {
      rotation_rows(a, b, log_map(to_quat(b.X.R * a.X.R.transposed())), Mat3::identity());
    } else if (l.type == revolute || l.type == cylindrical || l.type == planar) {
      // c = axis_a x axis_b; dc = axis_a x (w x axis_b) = w (axis_a . axis_b) - axis_b (axis_a . w)
      const Mat3 M = Mat3::identity() * dot(axis_a, axis_b) - Mat3::columns(axis_b * axis_a.x, axis_b * axis_a.y, axis_b * axis_a.z);
      rotation_rows(a, b, cross(axis_a, axis_b), M);
    } else if (l.type == universal) {
      const Vec3 second = b.X.R * l.axis2, c = cross(second, axis_a);  // d(axis_a . second) = axis_a . (w x second) = w . c
      rotation_row(a, b, dot(axis_a, second), c);
    }
  }

 private:
  Side side_of(int link, const Pose& X_BJ) const {
    Side side;
    side.moved_by.assign(at(m_.link_count()), 0);
    side.X = link < 0 ? X_BJ : X_WB_[at(link)] * X_BJ;
    if (link >= 0) mark_ancestors(m_, link, side.moved_by);
    return side;
  }
  /// Velocity of b relative to a at b's point, for unit rate of the variable.
  Vec6 relative(const Side& a, const Side& b, const Variable& x) const {
    const double share = double(b.moved_by[at(x.link)]) - double(a.moved_by[at(x.link)]);
    if (share == 0) return {};
    return Vec6{x.S.w, x.S.v + cross(x.S.w, b.X.p)} * share;
  }
  void row(double residual) {
    out_.residual.push_back(residual);
    out_.J.resize(out_.J.size() + variables_.size());
    ++out_.count;
  }
  double* last_row() { return out_.J.data() + (out_.J.size() - variables_.size()); }
  void translation_rows(const Side& a, const Side& b, const Vec3& residual, const Mat3& M) {
    for (int r = 0; r < 3; ++r) {
      row(residual[r]);
      for (std::size_t k = 0; k < variables_.size(); ++k) last_row()[k] = dot(M.row(r), relative(a, b, variables_[k]).v);
    }
  }
  void rotation_rows(const Side& a, const Side& b, const Vec3& residual, const Mat3& M) {
    for (int r = 0; r < 3; ++r) rotation_row(a, b, residual[r], M.row(r));
  }
  void rotation_row(const Side& a, const Side& b, double residual, const Vec3& factor) {
    row(lever * residual);
    for (std::size_t k = 0; k < variables_.size(); ++k) last_row()[k] = lever * dot(factor, relative(a, b, variables_[k]).w);
  }
  void distance_row(const Side& a, const Side& b, const Vec3& p, double length) {
    const double distance = norm(p);
    const Vec3 direction = distance > 1e-12 ? p / distance : Vec3{0, 0, 1};
    row(distance - length);
    for (std::size_t k = 0; k < variables_.size(); ++k) last_row()[k] = dot(direction, relative(a, b, variables_[k]).v);
  }
  void gear_row(const Loop& l) {
    const auto coordinate = [&](int dof) {
      const Link& link = m_.link(m_.link_of_dof(dof));
      return q_[at(link.q_index + dof - link.v_index)];
    };
    const double x = coordinate(l.dof_b);
    double value = 0, slope = 0;
    for (std::size_t k = 5; k-- > 0;) {
      slope = slope * x + value;
      value = value * x + l.polynomial[k];
    }
    row(lever * (coordinate(l.dof_a) - value));
    for (std::size_t k = 0; k < variables_.size(); ++k) {
      const int dof = m_.link(variables_[k].link).v_index + variables_[k].dof;
      last_row()[k] = lever * (dof == l.dof_a ? 1 : dof == l.dof_b ? -slope : 0);
    }
  }

  const Mechanism& m_;
  std::span<const Variable> variables_;
  std::span<const double> q_;
  std::span<const Pose> X_WB_;
  Equations& out_;
};

}  // namespace

void mark_ancestors(const Mechanism& m, int link, std::vector<std::uint8_t>& on) {
  for (int i = link; i >= 0; i = m.link(i).parent) on[at(i)] = 1;
}

void write_equations(const Mechanism& m, std::span<const PoseGoal> goals, std::span<const Variable> variables, std::span<const double> q,
                     std::span<const Pose> X_WB, Equations& out) {
  Writer writer(m, variables, q, X_WB, out);
  for (const PoseGoal& g : goals) writer.goal(g);
  for (const Loop& l : m.loops())
    if (l.closed) writer.loop(l);
}

}  // namespace ugoki::posing
