#include "named_peer.h"

#ifdef UGOKI_HAVE_MUJOCO
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>

namespace ugoki::robot_formats {
namespace {

constexpr double g[3] = {1, -2, -9};  // m/s^2, with all components different from zero

double uniform(std::mt19937& random, double reach) { return std::uniform_real_distribution<double>(-reach, reach)(random); }

Quat random_quat(std::mt19937& random) {
  return normalized(Quat{uniform(random, 1), uniform(random, 1), uniform(random, 1), uniform(random, 1)});
}

void grow(double& worst, const std::vector<double>& a, const double* b) {
  double scale = 1e-12, error = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    scale = std::max(scale, std::fabs(b[i]));
    error = std::max(error, std::fabs(a[i] - b[i]));
  }
  worst = std::max(worst, error / scale);
}

}  // namespace

MujocoModel open_in_mujoco(const std::string& text, std::string& why) {
  const auto file = std::filesystem::temp_directory_path() / ("ugoki-named-peer-" + std::to_string(::getpid()) + ".xml");
  std::ofstream(file) << text;
  char message[1000] = "";
  MujocoModel model(mj_loadXML(file.c_str(), nullptr, message, sizeof message), mj_deleteModel);
  std::filesystem::remove(file);
  why = message;
  if (!model) return model;
  model->opt.disableflags |= mjDSBL_CONSTRAINT | mjDSBL_PASSIVE | mjDSBL_ACTUATION | mjDSBL_CONTACT;
  for (int i = 0; i < 3; ++i) model->opt.gravity[i] = g[i];
  return model;
}

NamedPeer::NamedPeer(const RobotModel& model, const mjModel& peer)
    : model_(model), m_(*model.mechanism), peer_(peer), data_(mj_makeData(&peer), mj_deleteData), ws_(m_), state_(m_) {
  for (const Link& l : m_.links()) {
    const int body = mj_name2id(&peer, mjOBJ_BODY, l.name.c_str());
    body_.push_back(body);
    int dofs = 0;
    for (int k = 0; body >= 0 && k < peer.body_jntnum[body]; ++k) {
      const int type = peer.jnt_type[peer.body_jntadr[body] + k];
      dofs += type == mjJNT_FREE ? 6 : type == mjJNT_BALL ? 3 : 1;
    }
    if (body >= 0 && dofs != l.joint.nv()) mismatch_ += l.name + " has other degrees of freedom; ";
    if (body < 0 && l.joint.nv() > 0) mismatch_ += l.name + " has no body; ";
  }
  if (peer.nv != m_.nv()) mismatch_ += std::to_string(peer.nv) + " degrees of freedom there, " + std::to_string(m_.nv()) + " here";
}

std::vector<double> NamedPeer::to_theirs(const std::vector<double>& ours) const {
  std::vector<double> out(ours.size());
  for (std::size_t i = 0; i < body_.size(); ++i) {
    const Link& l = m_.link(static_cast<int>(i));
    if (l.joint.nv() == 0) continue;
    const double* from = ours.data() + l.v_index;
    double* to = out.data() + peer_.jnt_dofadr[peer_.body_jntadr[body_[i]]];
    std::copy_n(from, l.joint.nv(), to);
    if (l.joint.type != JointType::floating) continue;
    const Vec3 linear = l.joint.X_PJ.R * Vec3{from[3], from[4], from[5]};
    for (int k = 0; k < 3; ++k) to[k] = linear[k], to[3 + k] = from[k];
  }
  return out;
}

void NamedPeer::set_state(std::mt19937& random) {
  for (std::size_t i = 0; i < body_.size(); ++i) {
    const Link& l = m_.link(static_cast<int>(i));
    if (l.joint.nv() == 0) continue;
    double* q = state_.q.data() + l.q_index;
    double* theirs = data_->qpos + peer_.jnt_qposadr[peer_.body_jntadr[body_[i]]];
    const auto put = [](const Quat& r, double* to) { to[0] = r.w, to[1] = r.x, to[2] = r.y, to[3] = r.z; };
    if (l.joint.type == JointType::floating) {
      for (int k = 0; k < 3; ++k) q[k] = uniform(random, 1);
      put(random_quat(random), q + 3);
      const Pose X = l.joint.X_PJ * joint_pose(l.joint, q);
      for (int k = 0; k < 3; ++k) theirs[k] = X.p[k];
      put(to_quat(X.R), theirs + 3);
    } else if (l.joint.type == JointType::spherical) {
      put(random_quat(random), q);
      std::copy_n(q, 4, theirs);
    } else {
      for (int k = 0; k < l.joint.nq(); ++k) theirs[k] = q[k] = uniform(random, l.joint.type == JointType::prismatic ? 0.5 : 3);
    }
  }
  for (double& v : state_.v) v = uniform(random, 2);
  const std::vector<double> v = to_theirs(state_.v);
  std::copy(v.begin(), v.end(), data_->qvel);
}

void NamedPeer::compare_poses(Disagreement& worst) {
  for (std::size_t i = 0; i < body_.size(); ++i) {
    if (body_[i] < 0) continue;
    const Pose X = ws_.X_WB[i] * model_.X_BF[i];
    for (int k = 0; k < 3; ++k) {
      worst.pose = std::max(worst.pose, std::fabs(X.p[k] - data_->xpos[3 * body_[i] + k]));
      for (int c = 0; c < 3; ++c) worst.pose = std::max(worst.pose, std::fabs(X.R.row(k)[c] - data_->xmat[9 * body_[i] + 3 * k + c]));
    }
  }
}

void NamedPeer::compare_dynamics(std::mt19937& random, Disagreement& worst) {
  const Vec3 gravity{g[0], g[1], g[2]};
  const auto n = static_cast<std::size_t>(m_.nv());
  std::vector<double> vdot(n), tau(n), M(n * n), full(n * n), by_factor(n), by_units(n);
  for (double& a : vdot) a = uniform(random, 3);
  std::vector<double> theirs = to_theirs(vdot);
  std::copy(theirs.begin(), theirs.end(), data_->qacc);
  mj_inverse(&peer_, data_.get());
  dynamics::calc_inverse_dynamics(m_, ws_, vdot, gravity, {}, tau);
  grow(worst.inverse, to_theirs(tau), data_->qfrc_inverse);

  // MuJoCo's matrix is P M P^T, where P reorders our DOFs to MuJoCo's order. Convert the columns, then the rows.
  dynamics::calc_inertia_matrix(m_, ws_, M);
  mj_fullM(&peer_, full.data(), data_->qM);
  for (int pass = 0; pass < 2; ++pass) {
    std::vector<double> turned(n * n);
    for (std::size_t j = 0; j < n; ++j) {
      std::vector<double> line(n);
      for (std::size_t i = 0; i < n; ++i) line[i] = M[j * n + i];
      const std::vector<double> moved = to_theirs(line);
      for (std::size_t i = 0; i < n; ++i) turned[i * n + j] = moved[i];
    }
    M = turned;
  }
  grow(worst.inertia, M, full.data());

  // Forward dynamics with the forces of the inverse dynamics, so that accelerations are of order one for any masses.
  theirs = to_theirs(tau);
  std::copy(theirs.begin(), theirs.end(), data_->qfrc_applied);
  mj_forward(&peer_, data_.get());
  const bool ok = dynamics::calc_forward_dynamics(m_, ws_, tau, gravity, {}, vdot) &&
                  dynamics::calc_forward_dynamics_by_factor(m_, ws_, tau, gravity, {}, by_factor) &&
                  dynamics::calc_forward_dynamics_by_unit_vectors(m_, ws_, tau, gravity, {}, by_units);
  if (!ok) worst.methods = INFINITY;
  grow(worst.forward, to_theirs(vdot), data_->qacc);
  grow(worst.methods, by_factor, vdot.data());
  grow(worst.methods, by_units, vdot.data());
}

void NamedPeer::compare(std::mt19937& random, Disagreement& worst) {
  set_state(random);
  mj_forward(&peer_, data_.get());
  dynamics::update_kinematics(m_, state_.q, state_.v, ws_);
  compare_poses(worst);
  compare_dynamics(random, worst);
}

}  // namespace ugoki::robot_formats
#endif
