#include "ugoki/mechanism/joint.h"

namespace ugoki {
namespace {

constexpr std::array<std::string_view, 9> type_names = {"fixed",  "revolute",  "prismatic", "helical", "cylindrical",
                                                        "planar", "universal", "spherical", "floating"};

Quat quat_at(const double* q) { return {q[0], q[1], q[2], q[3]}; }
void store(const Quat& r, double* q) {
  q[0] = r.w;
  q[1] = r.x;
  q[2] = r.y;
  q[3] = r.z;
}

}  // namespace

std::string_view name_of(JointType type) { return type_names[static_cast<std::size_t>(type)]; }

std::optional<JointType> joint_type_named(std::string_view name) {
  for (std::size_t i = 0; i < type_names.size(); ++i)
    if (type_names[i] == name) return static_cast<JointType>(i);
  return std::nullopt;
}

Pose joint_pose(const Joint& joint, const double* q) {
  switch (joint.type) {
    case JointType::fixed: return {};
    case JointType::revolute: return {rotation_about(joint.axis, q[0]), {}};
    case JointType::prismatic: return {Mat3::identity(), joint.axis * q[0]};
    case JointType::helical: return {rotation_about(joint.axis, q[0]), joint.axis * (joint.pitch * q[0])};
    case JointType::cylindrical: return {rotation_about(joint.axis, q[0]), joint.axis * q[1]};
    case JointType::planar: return {rotation_about({0, 0, 1}, q[2]), {q[0], q[1], 0}};
    case JointType::universal: return {rotation_about(joint.axis, q[0]) * rotation_about(joint.axis2, q[1]), {}};
    case JointType::spherical: return {to_matrix(quat_at(q)), {}};
    case JointType::floating: return {to_matrix(quat_at(q + 3)), {q[0], q[1], q[2]}};
  }
  return {};
}

int joint_subspace(const Joint& joint, const double* q, Vec6* S) {
  constexpr Vec3 ex{1, 0, 0}, ey{0, 1, 0}, ez{0, 0, 1}, zero{};
  switch (joint.type) {
    case JointType::fixed: return 0;
    case JointType::revolute: S[0] = {joint.axis, zero}; return 1;
    case JointType::prismatic: S[0] = {zero, joint.axis}; return 1;
    case JointType::helical: S[0] = {joint.axis, joint.axis * joint.pitch}; return 1;
    case JointType::cylindrical:
      S[0] = {joint.axis, zero};
      S[1] = {zero, joint.axis};
      return 2;
    case JointType::planar: {
      const SinCos sc = sin_cos(q[2]);
      S[0] = {zero, {sc.cos, -sc.sin, 0}};
      S[1] = {zero, {sc.sin, sc.cos, 0}};
      S[2] = {ez, zero};
      return 3;
    }
    case JointType::universal:
      S[0] = {transpose_times(rotation_about(joint.axis2, q[1]), joint.axis), zero};
      S[1] = {joint.axis2, zero};
      return 2;
    case JointType::spherical:
      S[0] = {ex, zero};
      S[1] = {ey, zero};
      S[2] = {ez, zero};
      return 3;
    case JointType::floating: {
      const Mat3 R = to_matrix(quat_at(q + 3));
      S[0] = {ex, zero};
      S[1] = {ey, zero};
      S[2] = {ez, zero};
      S[3] = {zero, R.row(0)};
      S[4] = {zero, R.row(1)};
      S[5] = {zero, R.row(2)};
      return 6;
    }
  }
  return 0;
}

Vec6 joint_bias(const Joint& joint, const double* q, const double* v) {
  switch (joint.type) {
    case JointType::planar: {
      Vec6 S[3];
      joint_subspace(joint, q, S);
      return {{}, -cross(Vec3{0, 0, v[2]}, S[0].v * v[0] + S[1].v * v[1])};
    }
    case JointType::universal: {
      Vec6 S[2];
      joint_subspace(joint, q, S);
      return {-cross(joint.axis2 * v[1], S[0].w * v[0]), {}};
    }
    case JointType::floating: {
      const Mat3 R = to_matrix(quat_at(q + 3));
      return {{}, -cross(Vec3{v[0], v[1], v[2]}, transpose_times(R, Vec3{v[3], v[4], v[5]}))};
    }
    default: return {};
  }
}

void joint_neutral(const Joint& joint, double* q) {
  for (int i = 0; i < joint.nq(); ++i) q[i] = 0;
  if (joint.type == JointType::spherical) q[0] = 1;
  if (joint.type == JointType::floating) q[3] = 1;
}

void joint_integrate(JointType type, const double* q, const double* v, double dt, double* q_out) {
  switch (type) {
    case JointType::spherical: store(normalized(quat_at(q) * exp_map(Vec3{v[0], v[1], v[2]} * dt)), q_out); return;
    case JointType::floating:
      for (int i = 0; i < 3; ++i) q_out[i] = q[i] + dt * v[3 + i];
      store(normalized(quat_at(q + 3) * exp_map(Vec3{v[0], v[1], v[2]} * dt)), q_out + 3);
      return;
    default:
      for (int i = 0; i < velocity_count(type); ++i) q_out[i] = q[i] + dt * v[i];
  }
}

void joint_difference(JointType type, const double* q0, const double* q1, double* v) {
  const auto turn = [](const double* a, const double* b, double* w) {
    const Vec3 r = log_map(quat_at(a).conjugate() * quat_at(b));
    w[0] = r.x;
    w[1] = r.y;
    w[2] = r.z;
  };
  switch (type) {
    case JointType::spherical: turn(q0, q1, v); return;
    case JointType::floating:
      turn(q0 + 3, q1 + 3, v);
      for (int i = 0; i < 3; ++i) v[3 + i] = q1[i] - q0[i];
      return;
    default:
      for (int i = 0; i < velocity_count(type); ++i) v[i] = q1[i] - q0[i];
  }
}

void joint_displacement(const Joint& joint, const double* q, double* x) {
  switch (joint.type) {
    case JointType::spherical: {
      const Vec3 r = log_map(quat_at(q));
      x[0] = r.x;
      x[1] = r.y;
      x[2] = r.z;
      return;
    }
    case JointType::floating:
      for (int i = 0; i < 6; ++i) x[i] = 0;
      return;
    default:
      for (int i = 0; i < joint.nv(); ++i) x[i] = q[i];
  }
}

}  // namespace ugoki
