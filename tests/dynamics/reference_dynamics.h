#pragma once
// Reference inverse dynamics of open link systems by Kane's method, for any scalar type. It uses only the definitions of the joints in
// mechanism/joint.h. Poses are functions of time (jets of second order), the accelerations of centres of mass are their second
// derivatives, and joint forces follow from virtual work. With complex scalars it gives derivatives exact to rounding (complex step
// method: Squire, Trapp 1998).

#include <array>
#include <cmath>
#include <complex>
#include <vector>

#include "ugoki/mechanism/state.h"

namespace ugoki::testing {

/// A value with its first and second time derivatives.
template <class T>
struct Jet {
  T x{}, d{}, dd{};
  friend Jet operator+(const Jet& a, const Jet& b) { return {a.x + b.x, a.d + b.d, a.dd + b.dd}; }
  friend Jet operator-(const Jet& a, const Jet& b) { return {a.x - b.x, a.d - b.d, a.dd - b.dd}; }
  friend Jet operator*(const Jet& a, const Jet& b) {
    return {a.x * b.x, a.d * b.x + a.x * b.d, a.dd * b.x + T(2) * a.d * b.d + a.x * b.dd};
  }
  friend Jet sine(const Jet& a) {
    using std::cos, std::sin;
    return {sin(a.x), cos(a.x) * a.d, cos(a.x) * a.dd - sin(a.x) * a.d * a.d};
  }
  friend Jet cosine(const Jet& a) {
    using std::cos, std::sin;
    return {cos(a.x), -sin(a.x) * a.d, -sin(a.x) * a.dd - cos(a.x) * a.d * a.d};
  }
};

/// The reference algorithm for scalar type T.
template <class T>
struct ReferenceDynamics {
  using J = Jet<T>;
  using V3 = std::array<J, 3>;
  using M3 = std::array<std::array<J, 3>, 3>;
  struct Frame {
    M3 R;
    V3 p;
  };

  static J constant(T x) { return {x, T(0), T(0)}; }
  static V3 vec(const Vec3& a) { return {constant(a.x), constant(a.y), constant(a.z)}; }
  static M3 mat(const Mat3& a) {
    M3 out;
    for (int r = 0; r < 3; ++r)
      for (int c = 0; c < 3; ++c) out[static_cast<std::size_t>(r)][static_cast<std::size_t>(c)] = constant(a.row(r)[c]);
    return out;
  }
  static V3 add(const V3& a, const V3& b) { return {a[0] + b[0], a[1] + b[1], a[2] + b[2]}; }
  static V3 scale(const V3& a, const J& s) { return {a[0] * s, a[1] * s, a[2] * s}; }
  static V3 times(const M3& m, const V3& v) {
    V3 out;
    for (std::size_t r = 0; r < 3; ++r) out[r] = m[r][0] * v[0] + m[r][1] * v[1] + m[r][2] * v[2];
    return out;
  }
  static M3 times(const M3& a, const M3& b) {
    M3 out;
    for (std::size_t r = 0; r < 3; ++r)
      for (std::size_t c = 0; c < 3; ++c) out[r][c] = a[r][0] * b[0][c] + a[r][1] * b[1][c] + a[r][2] * b[2][c];
    return out;
  }
  static M3 skew(const V3& a) {
    const J o = constant(T(0));
    return {{{o, o - a[2], a[1]}, {a[2], o, o - a[0]}, {o - a[1], a[0], o}}};
  }
  /// Rotation by a time-dependent angle about a constant axis (Rodrigues' formula).
  static M3 turn(const Vec3& axis, const J& angle) {
    const M3 K = skew(vec(axis)), K2 = times(K, K);
    const J s = sine(angle), c = constant(T(1)) - cosine(angle);
    M3 out = mat(Mat3::identity());
    for (std::size_t i = 0; i < 3; ++i)
      for (std::size_t j = 0; j < 3; ++j) out[i][j] = out[i][j] + K[i][j] * s + K2[i][j] * c;
    return out;
  }
  /// Rotation matrix of a small rotation vector: exact to second order in time, and to first order in an imaginary disturbance.
  static M3 small_turn(const V3& u) {
    const M3 K = skew(u), K2 = times(K, K);
    M3 out = mat(Mat3::identity());
    for (std::size_t i = 0; i < 3; ++i)
      for (std::size_t j = 0; j < 3; ++j) out[i][j] = out[i][j] + K[i][j] + K2[i][j] * constant(T(0.5));
    return out;
  }

  /// Pose of the moving frame B in the joint frame J at q (+) dq (q displaced by dq), as a function of time with velocity v and
  /// acceleration a.
  static Frame joint_frame(const Joint& joint, const double* q, const T* dq, const T* v, const T* a) {
    std::array<J, 6> x;
    for (int k = 0; k < joint.nv(); ++k) {
      const auto i = static_cast<std::size_t>(k);
      const bool plain = joint.type != JointType::spherical && joint.type != JointType::floating;
      x[i] = {plain ? T(q[k]) + dq[k] : T(0), v[k], a[k]};
    }
    const V3 none = vec({});
    switch (joint.type) {
      case JointType::fixed: return {mat(Mat3::identity()), none};
      case JointType::revolute: return {turn(joint.axis, x[0]), none};
      case JointType::prismatic: return {mat(Mat3::identity()), scale(vec(joint.axis), x[0])};
      case JointType::helical: return {turn(joint.axis, x[0]), scale(vec(joint.axis * joint.pitch), x[0])};
      case JointType::cylindrical: return {turn(joint.axis, x[0]), scale(vec(joint.axis), x[1])};
      case JointType::planar: return {turn({0, 0, 1}, x[2]), {x[0], x[1], constant(T(0))}};
      case JointType::universal: return {times(turn(joint.axis, x[0]), turn(joint.axis2, x[1])), none};
      case JointType::spherical:
      case JointType::floating: {
        const bool floats = joint.type == JointType::floating;
        const double* r = floats ? q + 3 : q;
        const V3 disturbance{constant(dq[0]), constant(dq[1]), constant(dq[2])};
        const M3 R = times(times(mat(to_matrix(Quat{r[0], r[1], r[2], r[3]})), small_turn(disturbance)), small_turn({x[0], x[1], x[2]}));
        if (!floats) return {R, none};
        V3 p;
        for (std::size_t i = 0; i < 3; ++i) p[i] = J{T(q[i]) + dq[3 + i], v[3 + i], a[3 + i]};
        return {R, p};
      }
    }
    return {};
  }

  static std::vector<Frame> frames(const Mechanism& m, std::span<const double> q, const std::vector<T>& dq, const std::vector<T>& v,
                                   const std::vector<T>& a) {
    std::vector<Frame> out(static_cast<std::size_t>(m.link_count()));
    for (std::size_t i = 0; i < out.size(); ++i) {
      const Link& link = m.links()[i];
      const auto f = static_cast<std::size_t>(link.v_index);
      const Frame B = joint_frame(link.joint, q.data() + link.q_index, dq.data() + f, v.data() + f, a.data() + f);
      const M3 R = times(mat(link.joint.X_PJ.R), B.R);
      const V3 p = add(times(mat(link.joint.X_PJ.R), B.p), vec(link.joint.X_PJ.p));
      if (link.parent < 0) {
        out[i] = {R, p};
      } else {
        const Frame& P = out[static_cast<std::size_t>(link.parent)];
        out[i] = {times(P.R, R), add(times(P.R, p), P.p)};
      }
    }
    return out;
  }

  using Plain = std::array<T, 3>;
  static Plain cross_of(const Plain& a, const Plain& b) {
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
  }
  static T dot_of(const Plain& a, const Plain& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

  struct LinkMotion {
    Plain centre, velocity, acceleration;  // centre of mass, its velocity and its acceleration
    Plain w, alpha;                        // angular velocity and acceleration
    std::array<Plain, 3> inertia;          // rows of the inertia matrix about the centre of mass, world axes
  };

  static LinkMotion motion_of(const Frame& X, const Inertia& inertia) {
    LinkMotion out;
    const V3 c = add(times(X.R, vec(inertia.centre())), X.p);
    for (std::size_t i = 0; i < 3; ++i) {
      out.centre[i] = c[i].x;
      out.velocity[i] = c[i].d;
      out.acceleration[i] = c[i].dd;
    }
    // Cross-product matrices of the angular velocity w and acceleration alpha: R' R^T = [w x],  R'' R^T + R' R'^T = [alpha x]
    const auto entry = [&](std::size_t i, std::size_t j, bool rate) {
      T sum(0);
      for (std::size_t k = 0; k < 3; ++k) sum += rate ? X.R[i][k].dd * X.R[j][k].x + X.R[i][k].d * X.R[j][k].d : X.R[i][k].d * X.R[j][k].x;
      return sum;
    };
    out.w = {entry(2, 1, false), entry(0, 2, false), entry(1, 0, false)};
    out.alpha = {entry(2, 1, true), entry(0, 2, true), entry(1, 0, true)};
    const Mat3 I = inertia.about_centre().matrix();
    for (std::size_t i = 0; i < 3; ++i)
      for (std::size_t j = 0; j < 3; ++j) {
        T sum(0);
        for (std::size_t k = 0; k < 3; ++k)
          for (std::size_t l = 0; l < 3; ++l) sum += X.R[i][k].x * T(I.row(static_cast<int>(k))[static_cast<int>(l)]) * X.R[j][l].x;
        out.inertia[i][j] = sum;
      }
    return out;
  }

  /// Joint forces tau at the configuration q (+) dq (q displaced by dq). [nv] N | N m
  static std::vector<T> inverse(const Mechanism& m, std::span<const double> q, const std::vector<T>& dq, const std::vector<T>& v,
                                const std::vector<T>& vdot, const Vec3& gravity, std::span<const Vec6> external) {
    const std::vector<Frame> X = frames(m, q, dq, v, vdot);
    const std::size_t n = v.size(), links = X.size();
    std::vector<Plain> force(links), moment(links), centre(links);
    for (std::size_t i = 0; i < links; ++i) {
      const Inertia& inertia = m.links()[i].inertia;
      const LinkMotion b = motion_of(X[i], inertia);
      Plain Iw, Ia;
      for (std::size_t k = 0; k < 3; ++k) {
        Iw[k] = dot_of(b.inertia[k], b.w);
        Ia[k] = dot_of(b.inertia[k], b.alpha);
      }
      const Plain gyro = cross_of(b.w, Iw);
      Plain push_force{}, push_moment{};
      if (!external.empty()) {
        const Vec6& e = external[i];
        push_force = {T(e.v.x), T(e.v.y), T(e.v.z)};
        const Plain shift = cross_of(b.centre, push_force);  // converts the moment about the world origin to that about the centre
        push_moment = {T(e.w.x) - shift[0], T(e.w.y) - shift[1], T(e.w.z) - shift[2]};
      }
      for (std::size_t k = 0; k < 3; ++k) {
        force[i][k] = T(inertia.mass) * (b.acceleration[k] - T(gravity[static_cast<int>(k)])) - push_force[k];
        moment[i][k] = Ia[k] + gyro[k] - push_moment[k];
      }
    }
    std::vector<T> tau(n), unit(n), rest(n);
    for (std::size_t j = 0; j < n; ++j) {
      unit[j] = T(1);
      const std::vector<Frame> Y = frames(m, q, dq, unit, rest);
      unit[j] = T(0);
      for (std::size_t i = 0; i < links; ++i) {
        const LinkMotion partial = motion_of(Y[i], m.links()[i].inertia);
        tau[j] += dot_of(partial.velocity, force[i]) + dot_of(partial.w, moment[i]);
      }
      tau[j] += T(m.dof(static_cast<int>(j)).armature) * vdot[j];
    }
    return tau;
  }
};

}  // namespace ugoki::testing
