// Compares our MJCF reader with MuJoCo's, in random states: poses, inertia matrix, inverse and forward dynamics, loops. The results can
// agree up to rounding, because both readers read the same inertias from the same text.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <map>
#include <random>

#include "mjcf_data.h"
#include "mujoco_peer.h"
#include "random_mjcf.h"
#include "ugoki/base/number.h"
#include "ugoki/dynamics/dynamics.h"
#include "ugoki/dynamics/loop_rows.h"
#include "ugoki/mechanism/state.h"
#include "ugoki/robot_formats/mjcf.h"

namespace ugoki::robot_formats {
namespace {

#ifndef UGOKI_HAVE_MUJOCO
TEST(MjcfPeer, SharedFiles) { GTEST_SKIP() << "MuJoCo (libmujoco-dev) is not installed"; }
#else

/// Maximum differences between our results and MuJoCo's, relative to the largest value of their kind.
struct Worst {
  double pose = 0, inertia = 0, moments = 0, M = 0, inverse = 0, forward = 0, methods = 0, gap = 0, jacobian = 0;
};

struct Tolerances {
  double mass = 1e-12;
  double inertia = 3e-6;   ///< for the inertia of each body
  double moments = 1e-11;  ///< for principal moments and centre of mass of each body
  double dynamics = 1e-8;  ///< for inertia matrix and inverse dynamics
  double forward = 1e-8;
  double methods = 1e-9;  ///< for differences between our three methods of forward dynamics
};

/// Our and MuJoCo's model of one file, matched DOF by DOF.
class Pair {
 public:
  Pair(const RobotModel& model, PeerModel& peer) : model_(model), m_(*model.mechanism), peer_(peer), ws_(m_), state_(m_) {}

  /// Matches bodies and joints, and compares their properties. False if the models differ in bodies or joints.
  bool match() {
    const mjModel& p = *peer_.model;
    EXPECT_EQ(m_.nq(), p.nq);
    EXPECT_EQ(m_.nv(), p.nv);
    EXPECT_NEAR(m_.mass(), mj_getTotalmass(&p), mass_tolerance * m_.mass());
    int link = m_.link_count() > 0 && m_.link(0).name == "world" ? 1 : 0;
    for (int b = 1; b < p.nbody; ++b) {
      const int joints = p.body_jntnum[b];
      for (int k = 0; k < joints; ++k, ++link)
        if (link < m_.link_count()) joint_links_.push_back(link);
      if (joints == 0) ++link;
      body_link_.push_back(link - 1);
    }
    EXPECT_EQ(link, m_.link_count()) << "bodies";
    if (m_.nq() != p.nq || m_.nv() != p.nv || link != m_.link_count()) return false;
    for (int b = 1; b < p.nbody; ++b)
      if (const char* name = mj_id2name(&p, mjOBJ_BODY, b); name && *name && !std::string(name).starts_with("peer_"))
        EXPECT_EQ(m_.link(body_link_[static_cast<std::size_t>(b - 1)]).name, name);
    for (int j = 0; j < p.njnt; ++j) {
      const Link& l = m_.link(joint_links_[static_cast<std::size_t>(j)]);
      const JointType wanted[] = {JointType::floating, JointType::spherical, JointType::prismatic, JointType::revolute};
      EXPECT_EQ(l.joint.type, wanted[p.jnt_type[j]]) << l.name;
      if (p.jnt_type[j] < 2 || l.joint.nv() != 1) continue;
      const Dof& f = l.joint.dofs[0];
      const double ref = p.qpos0[p.jnt_qposadr[j]];
      EXPECT_EQ(std::isfinite(f.lower), p.jnt_limited[j] != 0) << l.name;
      if (p.jnt_limited[j] && std::isfinite(f.lower)) {
        EXPECT_NEAR(f.lower, p.jnt_range[2 * j] - ref, 1e-12);
        EXPECT_NEAR(f.upper, p.jnt_range[2 * j + 1] - ref, 1e-12);
      }
      // springdamper values depend on the inertia of the DOF, so they are only as accurate as MuJoCo's principal axes
      const double spring_tolerance = std::max(1e-5, 100 * mass_tolerance);
      EXPECT_NEAR(f.stiffness, p.jnt_stiffness[j], spring_tolerance * (1 + f.stiffness)) << l.name;
      EXPECT_NEAR(f.damping, p.dof_damping[p.jnt_dofadr[j]], spring_tolerance * (1 + f.damping)) << l.name;
      EXPECT_NEAR(f.rest, p.qpos_spring[p.jnt_qposadr[j]] - ref, 1e-12) << l.name;
      EXPECT_EQ(f.armature, p.dof_armature[p.jnt_dofadr[j]]) << l.name;
      EXPECT_EQ(f.friction, p.dof_frictionloss[p.jnt_dofadr[j]]) << l.name;
    }
    return true;
  }

  void compare(std::mt19937& random, Worst& worst) {
    set_state(random);
    compare_poses(worst);
    compare_dynamics(random, worst);
  }

  void compare_loops(std::mt19937& random, Worst& worst);

  /// The same mechanism with the inertias that MuJoCo computed from the file. They differ slightly from ours, and an ill-conditioned
  /// inertia matrix magnifies the difference: MuJoCo omits Jacobi rotations by less than 1.4e-6 rad (whose cosine is 1 up to 1e-12), and
  /// all rotations for products of inertia below 1e-12 kg m^2. Principal moments are hardly affected. The differences are stored in
  /// `worst`.
  MechanismPtr with_their_inertias(Worst& worst) const {
    const mjModel& p = *peer_.model;
    MechanismSpec spec = m_.spec();
    for (int b = 1; b < p.nbody; ++b) {
      const auto link = static_cast<std::size_t>(body_link_[static_cast<std::size_t>(b - 1)]);
      const mjtNum *q = p.body_iquat + 4 * b, *c = p.body_ipos + 3 * b, *I = p.body_inertia + 3 * b;
      const Mat3 R = to_matrix(Quat{q[0], q[1], q[2], q[3]});
      const Sym3 about_centre = rotated(Sym3{I[0], I[1], I[2], 0, 0, 0}, R);
      Inertia& ours = spec.links[link].inertia;
      const Sym3 own = rotated(ours.about_centre(), model_.X_BF[link].R.transposed()), d = own - about_centre;
      const double error = std::max({std::fabs(d.xx), std::fabs(d.yy), std::fabs(d.zz), std::fabs(d.xy), std::fabs(d.xz), std::fabs(d.yz)});
      // Moments about the centre are differences of moments about the link's origin. Errors are therefore relative to the moments about
      // the origin.
      const double scale = std::max({I[0], I[1], I[2], ours.I.xx, ours.I.yy, ours.I.zz, 1e-30});
      worst.inertia = std::max(worst.inertia, std::max(0.0, error - 4e-12) / scale);
      for (const double moment : {I[0], I[1], I[2]}) {  // an eigenvalue: det(own - moment 1) = 0
        const Mat3 rest = own.matrix() - Mat3::diagonal(moment, moment, moment);
        worst.moments = std::max(worst.moments, std::fabs(rest.determinant()) / (scale * scale * scale));
      }
      worst.moments = std::max(worst.moments, norm(ours.centre() - model_.X_BF[link] * Vec3{c[0], c[1], c[2]}) * (ours.mass > 0 ? 1 : 0));
      ours = Inertia::from_centre(p.body_mass[b], {c[0], c[1], c[2]}, about_centre).in_parent(model_.X_BF[link]);
    }
    Result<MechanismPtr> made = Mechanism::make(std::move(spec));
    EXPECT_TRUE(made.has_value()) << (made ? std::string() : made.error().text());
    return made ? *made : nullptr;
  }

  double mass_tolerance = 1e-12;

 private:
  static double uniform(std::mt19937& random, double reach) { return std::uniform_real_distribution<double>(-reach, reach)(random); }

  void set_state(std::mt19937& random) {
    const mjModel& p = *peer_.model;
    mjData& d = *peer_.data;
    mj_resetData(&p, &d);
    for (int j = 0; j < p.njnt; ++j) {
      const Link& l = m_.link(joint_links_[static_cast<std::size_t>(j)]);
      double* q = state_.q.data() + l.q_index;
      mjtNum* theirs = d.qpos + p.jnt_qposadr[j];
      const auto random_quat = [&] {
        return normalized(Quat{uniform(random, 1), uniform(random, 1), uniform(random, 1), uniform(random, 1)});
      };
      const auto put = [](const Quat& r, double* to) { to[0] = r.w, to[1] = r.x, to[2] = r.y, to[3] = r.z; };
      if (l.joint.type == JointType::floating) {
        for (int i = 0; i < 3; ++i) q[i] = uniform(random, 1);
        put(random_quat(), q + 3);
        const Pose X = l.joint.X_PJ * joint_pose(l.joint, q);
        for (int i = 0; i < 3; ++i) theirs[i] = X.p[i];
        put(to_quat(X.R), theirs + 3);
      } else if (l.joint.type == JointType::spherical) {
        put(random_quat(), q);
        put(Quat{q[0], q[1], q[2], q[3]}, theirs);
      } else {
        q[0] = uniform(random, l.joint.type == JointType::revolute ? 3 : 0.5);
        theirs[0] = q[0] + p.qpos0[p.jnt_qposadr[j]];
      }
    }
    for (double& v : state_.v) v = uniform(random, 1);
    to_theirs(state_.v, d.qvel);
    for (int i = 0; i < 3; ++i) gravity_[i] = peer_.model->opt.gravity[i] = uniform(random, 10);
    dynamics::update_kinematics(m_, state_.q, state_.v, ws_);
  }

  /// Converts velocities or accelerations to MuJoCo's convention: for free joints the linear velocity comes first, in world axes. The map
  /// is orthogonal, so it also converts forces.
  void to_theirs(const std::vector<double>& ours, mjtNum* theirs) const {
    for (int j = 0; j < peer_.model->njnt; ++j) {
      const Link& l = m_.link(joint_links_[static_cast<std::size_t>(j)]);
      const double* v = ours.data() + l.v_index;
      mjtNum* out = theirs + peer_.model->jnt_dofadr[j];
      if (l.joint.type != JointType::floating) {
        for (int i = 0; i < l.joint.nv(); ++i) out[i] = v[i];
        continue;
      }
      const Vec3 linear = l.joint.X_PJ.R * Vec3{v[3], v[4], v[5]};
      for (int i = 0; i < 3; ++i) out[i] = linear[i], out[3 + i] = v[i];
    }
  }

  static void grow(double& worst, const std::vector<double>& a, const mjtNum* b, double min_scale = 1e-12) {
    double scale = min_scale, error = 0;
    for (std::size_t i = 0; i < a.size(); ++i) {
      scale = std::max(scale, std::fabs(b[i]));
      error = std::max(error, std::fabs(a[i] - b[i]));
    }
    worst = std::max(worst, error / scale);
  }

  void compare_poses(Worst& worst) {
    const mjModel& p = *peer_.model;
    mjData& d = *peer_.data;
    mj_kinematics(&p, &d);
    double size = 1e-3;
    for (int b = 1; b < p.nbody; ++b) size = std::max(size, mju_norm3(d.xpos + 3 * b));
    for (int b = 1; b < p.nbody; ++b) {
      const auto link = static_cast<std::size_t>(body_link_[static_cast<std::size_t>(b - 1)]);
      const Pose X = ws_.X_WB[link] * model_.X_BF[link];
      for (int i = 0; i < 3; ++i) {
        worst.pose = std::max(worst.pose, std::fabs(X.p[i] - d.xpos[3 * b + i]) / size);
        for (int k = 0; k < 3; ++k) worst.pose = std::max(worst.pose, std::fabs(X.R.row(i)[k] - d.xmat[9 * b + 3 * i + k]));
      }
    }
  }

  void compare_dynamics(std::mt19937& random, Worst& worst) {
    const auto n = static_cast<std::size_t>(m_.nv());
    const mjModel& p = *peer_.model;
    mjData& d = *peer_.data;
    // inverse dynamics
    std::vector<double> vdot(n), tau(n), theirs(n);
    for (double& a : vdot) a = uniform(random, 3);
    to_theirs(vdot, d.qacc);
    mj_inverse(&p, &d);
    dynamics::calc_inverse_dynamics(m_, ws_, vdot, gravity_, {}, tau);
    to_theirs(tau, theirs.data());
    grow(worst.inverse, theirs, d.qfrc_inverse);

    // inertia matrix, converted to MuJoCo's convention column by column, then row by row
    std::vector<double> M(n * n), column(n), M_theirs(n * n), full(n * n);
    dynamics::calc_inertia_matrix(m_, ws_, M);
    mj_fullM(&p, full.data(), d.qM);
    for (std::size_t j = 0; j < n; ++j) {
      for (std::size_t i = 0; i < n; ++i) column[i] = M[i * n + j];
      to_theirs(column, theirs.data());
      for (std::size_t i = 0; i < n; ++i) M_theirs[i * n + j] = theirs[i];
    }
    for (std::size_t i = 0; i < n; ++i) {
      std::copy_n(M_theirs.begin() + static_cast<std::ptrdiff_t>(i * n), n, column.begin());
      to_theirs(column, theirs.data());
      std::copy_n(theirs.begin(), n, M_theirs.begin() + static_cast<std::ptrdiff_t>(i * n));
    }
    grow(worst.M, M_theirs, full.data());

    // forward dynamics with the forces of the inverse dynamics, so that accelerations are of order one for any masses
    to_theirs(tau, d.qfrc_applied);
    mj_forward(&p, &d);
    std::vector<double> by_factor(n), by_units(n);
    ASSERT_TRUE(dynamics::calc_forward_dynamics(m_, ws_, tau, gravity_, {}, vdot));
    ASSERT_TRUE(dynamics::calc_forward_dynamics_by_factor(m_, ws_, tau, gravity_, {}, by_factor));
    to_theirs(vdot, theirs.data());
    grow(worst.forward, theirs, d.qacc);
    grow(worst.methods, by_factor, vdot.data());
    if (n <= 200) {  // this method is O(nv^3) and allocates memory
      ASSERT_TRUE(dynamics::calc_forward_dynamics_by_unit_vectors(m_, ws_, tau, gravity_, {}, by_units));
      grow(worst.methods, by_units, vdot.data());
    }
  }

  const RobotModel& model_;
  const Mechanism& m_;
  PeerModel& peer_;
  dynamics::Workspace ws_;
  State state_;
  Vec3 gravity_;
  std::vector<int> joint_links_;  ///< MuJoCo's joint -> our link
  std::vector<int> body_link_;    ///< MuJoCo's body - 1 -> our link
};

/// Compares the constraint rows of ball loops, of the translations of weld loops, and of gears.
void Pair::compare_loops(std::mt19937& random, Worst& worst) {
  set_state(random);
  const mjModel& p = *peer_.model;
  mjData& d = *peer_.data;
  peer_.model->opt.disableflags &= ~mjDSBL_EQUALITY;
  mj_forward(&p, &d);
  peer_.model->opt.disableflags |= mjDSBL_EQUALITY;
  dynamics::LoopRows rows(m_.loops());
  dynamics::update_loop_rows(m_, ws_, m_.loops(), state_.q, state_.v, rows);
  const auto n = static_cast<std::size_t>(m_.nv());
  std::vector<double> J(n, 0.0), theirs(n);
  int row = 0, i = 0;
  for (int e = 0; e < p.neq; ++e) {
    const int of_e = p.eq_type[e] == mjEQ_WELD ? 6 : p.eq_type[e] == mjEQ_CONNECT ? 3 : 1;
    if (!p.eq_active[e]) continue;
    ASSERT_LT(static_cast<std::size_t>(i), m_.loops().size());
    const Loop& loop = m_.loops()[static_cast<std::size_t>(i)];
    // For bodies that cannot move relative to each other, rounding decides whether MuJoCo has constraint rows: stop comparing.
    const auto last_dof = [&](int link) { return link < 0 ? -1 : ws_.link_chain[static_cast<std::size_t>(link)]; };
    if (loop.type != LoopType::gear && last_dof(loop.link_a) == last_dof(loop.link_b)) return;
    ASSERT_LE(row + of_e, d.nefc);
    const auto linked = [&](int link, const Pose& X_LJ) { return link < 0 ? X_LJ : ws_.X_WB[static_cast<std::size_t>(link)] * X_LJ; };
    if (of_e == 1) {  // gears: same convention
      dynamics::calc_loop_jacobian_row(m_, ws_, loop, rows, i, 0, J);
      to_theirs(J, theirs.data());
      worst.gap =
          std::max(worst.gap, std::fabs(rows.gap[static_cast<std::size_t>(rows.first[static_cast<std::size_t>(i)])] - d.efc_pos[row]));
      grow(worst.jacobian, theirs, d.efc_J + static_cast<std::ptrdiff_t>(row) * p.nv, 1);
    } else {
      // Ours: velocity of B's point relative to A, in the axes of A. MuJoCo's: velocity of A's point minus B's, in world axes.
      const Pose X_WJ = linked(loop.link_a, loop.X_AJ);
      const Vec3 gap = linked(loop.link_b, loop.X_BJ).p - X_WJ.p;
      std::vector<double> ours[3] = {std::vector<double>(n), std::vector<double>(n), std::vector<double>(n)};
      for (int r = 0; r < 3; ++r) {
        dynamics::calc_loop_jacobian_row(m_, ws_, loop, rows, i, r, J);
        const Vec3 axis = X_WJ.R.column(r);
        const double g = rows.gap[static_cast<std::size_t>(rows.first[static_cast<std::size_t>(i)] + r)];
        worst.gap = std::max(worst.gap, std::fabs(g + dot(axis, {d.efc_pos[row], d.efc_pos[row + 1], d.efc_pos[row + 2]})));
        for (int k = 0; k < 3; ++k)
          for (std::size_t c = 0; c < n; ++c) ours[k][c] += axis[k] * J[c];
      }
      if (loop.link_a >= 0)
        for (const int c : dynamics::chain_of_link(ws_, loop.link_a)) {
          const Vec3 turned = cross(ws_.S[static_cast<std::size_t>(c)].w, gap);
          for (int k = 0; k < 3; ++k) ours[k][static_cast<std::size_t>(c)] += turned[k];
        }
      std::vector<double> all(3 * n);
      for (std::size_t k = 0; k < 3; ++k) {
        for (double& x : ours[k]) x = -x;
        to_theirs(ours[k], all.data() + k * n);
      }
      grow(worst.jacobian, all, d.efc_J + static_cast<std::ptrdiff_t>(row) * p.nv, 1);
    }
    row += of_e;
    ++i;
  }
  EXPECT_EQ(static_cast<std::size_t>(i), m_.loops().size());
}

void check(const RobotModel& model, PeerModel& peer, const std::string& name, int states, const Tolerances& tolerance = {}) {
  ASSERT_TRUE(peer.model) << "MuJoCo does not open it: " << peer.why;
  Pair pair(model, peer);
  pair.mass_tolerance = tolerance.mass;
  if (!pair.match()) return;
  std::mt19937 random(7);
  Worst worst;
  for (int s = 0; s < states; ++s) pair.compare(random, worst);
  for (int s = 0; s < std::min(states, 20) && model.mechanism->has_loops(); ++s) pair.compare_loops(random, worst);
  RobotModel same = model;
  same.mechanism = pair.with_their_inertias(worst);
  ASSERT_TRUE(same.mechanism);
  Pair same_pair(same, peer);
  same_pair.mass_tolerance = tolerance.mass;
  Worst same_worst;
  if (same_pair.match())
    for (int s = 0; s < states; ++s) same_pair.compare(random, same_worst);
  EXPECT_LT(worst.pose, 1e-12);
  EXPECT_LT(worst.inertia, tolerance.inertia);
  EXPECT_LT(worst.moments, tolerance.moments);
  EXPECT_LT(worst.M, tolerance.dynamics);
  EXPECT_LT(worst.inverse, tolerance.dynamics);
  EXPECT_LT(worst.forward, tolerance.forward);
  EXPECT_LT(same_worst.M, 1e-12);
  EXPECT_LT(same_worst.inverse, 1e-11);
  EXPECT_LT(same_worst.forward, 1e-8);
  EXPECT_LT(worst.methods, tolerance.methods);
  EXPECT_LT(worst.gap, 1e-9);
  EXPECT_LT(worst.jacobian, 1e-9);
  std::printf(
      "%-52s links %3d nq %3d nv %3d mass %9.4f loops %d | pose %.0e I %.0e M %.0e inverse %.0e forward %.0e "
      "(same I: %.0e) ours %.0e",
      name.c_str(), model.mechanism->link_count(), model.mechanism->nq(), model.mechanism->nv(), model.mechanism->mass(),
      static_cast<int>(model.mechanism->loops().size()), worst.pose, worst.inertia, worst.M, worst.inverse, worst.forward,
      same_worst.forward, worst.methods);
  if (model.mechanism->has_loops()) std::printf(" gap %.0e J %.0e", worst.gap, worst.jacobian);
  std::printf("\n");
}

void check_file(const std::string& name, int states) {
  SCOPED_TRACE(name);
  const auto model = read_mjcf(load_data(name), name, data_options());
  ASSERT_TRUE(model.has_value()) << model.error().text();
  PeerModel peer = open_with_mujoco(data_folder() + name, {.strip_meshes = true, .stand_in = {}});
  Tolerances tolerance;
  // MuJoCo omits up to 1e-6 of a toe's inertia when it computes principal axes, and the toes have no other inertia.
  if (name == "animal/rodent.xml") tolerance.forward = 1e-5;
  check(*model, peer, std::filesystem::path(name).filename().string(), states, tolerance);
}

/// A rotated box that replaces a missing mesh file. Its coordinates are exact in single precision. It is a box because MuJoCo 2.2.2 uses
/// the volume of a mesh's inertia box; later versions of MuJoCo, and Ugoki, integrate the volume.
std::string stand_in(const std::string& path) {
  const std::string file = std::filesystem::path(path).filename().string();
  std::mt19937 random(static_cast<unsigned>(std::hash<std::string>()(file)));
  const double unit = file.ends_with(".obj") ? 5.0 / 16 : 5.0 / 1024;  // the fruit fly's OBJ meshes are scaled by 0.1
  const auto times = [&] { return unit * static_cast<double>(1 + random() % 4); };
  const Vec3 centre{times(), times(), times()}, half{times(), times(), times()};
  std::vector<Vec3> points;
  for (int i = 0; i < 8; ++i) {
    const Vec3 p{i & 1 ? half.x : -half.x, i & 2 ? half.y : -half.y, i & 4 ? half.z : -half.z};
    points.push_back(centre + Vec3{0.6 * p.x - 0.8 * p.y, 0.8 * p.x + 0.6 * p.y, p.z});
  }
  constexpr int faces[12][3] = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                                {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  std::string out;
  if (file.ends_with(".obj")) {
    for (const Vec3& p : points) out += "v " + to_text(p.x) + " " + to_text(p.y) + " " + to_text(p.z) + "\n";
    for (const auto& f : faces)
      out += "f " + std::to_string(f[0] + 1) + " " + std::to_string(f[1] + 1) + " " + std::to_string(f[2] + 1) + "\n";
    return out;
  }
  const auto put = [&](const auto& value) { out.append(reinterpret_cast<const char*>(&value), sizeof value); };
  out.assign(80, ' ');
  put(std::uint32_t{12});
  for (const auto& f : faces) {
    for (int i = 0; i < 3; ++i) put(0.0F);
    for (const int corner : f)
      for (int i = 0; i < 3; ++i) put(static_cast<float>(points[static_cast<std::size_t>(corner)][i]));
    put(std::uint16_t{0});
  }
  return out;
}

RobotOptions with_stand_ins() {
  RobotOptions options;
  options.read_asset = [](const std::string& path) -> Result<std::string> {
    if (path.ends_with(".stl") || path.ends_with(".obj")) return stand_in(path);
    return files::read_file(data_folder() + path);
  };
  return options;
}

void check_with_stand_ins(const std::string& name, int states, const Tolerances& tolerance) {
  SCOPED_TRACE(name);
  const auto model = read_mjcf(load_data(name), name, with_stand_ins());
  ASSERT_TRUE(model.has_value()) << model.error().text();
  PeerModel peer = open_with_mujoco(data_folder() + name, {.strip_meshes = false, .stand_in = stand_in});
  check(*model, peer, std::filesystem::path(name).filename().string() + " (boxes for meshes)", states, tolerance);
}

// Complete files: no mass depends on a missing mesh, and no attached model is missing.
const char* const complete_files[] = {
    "mechanism/closed_loop/mujoco/model__slider_crank__slider_crank.xml",
    "mechanism/closed_loop/mujoco/test__engine__testdata__connect.xml",
    "mechanism/closed_loop/mujoco/test__engine__testdata__core_constraint__jdotv_connect_2d.xml",
    "mechanism/closed_loop/mujoco/test__engine__testdata__core_constraint__jdotv_connect_3d.xml",
    "mechanism/closed_loop/mujoco/test__engine__testdata__core_constraint__jdotv_weld_3d.xml",
    "mechanism/closed_loop/mujoco/test__engine__testdata__equality_site.xml",
    "mechanism/closed_loop/mujoco/test__engine__testdata__weld.xml",
    "mechanism/open_chain/dm_control/cheetah.xml",
    "mechanism/open_chain/dm_control/fish.xml",
    "mechanism/open_chain/dm_control/humanoid.xml",
    "mechanism/open_chain/dm_control/humanoid_CMU.xml",
    "mechanism/open_chain/dm_control/quadruped.xml",
    "mechanism/open_chain/menagerie_xml_only/anybotics_anymal_b/anymal_b.xml",
    "mechanism/open_chain/menagerie_xml_only/anybotics_anymal_b/scene.xml",
    "mechanism/open_chain/menagerie_xml_only/robotis_op3/op3.xml",
    "mechanism/open_chain/menagerie_xml_only/robotis_op3/scene.xml",
    "mechanism/open_chain/menagerie_xml_only/unitree_a1/a1.xml",
    "mechanism/open_chain/menagerie_xml_only/unitree_a1/scene.xml",
    "mechanism/open_chain/menagerie_xml_only/unitree_a1/suspended_a1.xml",
    "mechanism/open_chain/mujoco/model__adhesion__active_adhesion.xml",
    "mechanism/open_chain/mujoco/model__humanoid__humanoid.xml",
    "mechanism/open_chain/mujoco/model__replicate__newton_cradle.xml",
    "mechanism/open_chain/mujoco/model__tendon_arm__arm26.xml",
    "animal/rodent.xml",
};

// MuJoCo stores mesh points in single precision, after moving them to their centre.
constexpr Tolerances single_precision = {.mass = 1e-6, .inertia = 1e-5, .moments = 1e-5, .dynamics = 1e-5, .forward = 1e-3};

TEST(MjcfPeer, SharedFilesWithMeshes) {
  NEEDS_MJCF_DATA();
  for (const char* name : {"animal/dog.xml", "animal/fruitfly.xml"}) check_with_stand_ins(name, 5, single_precision);
}

std::string replaced(std::string text, const std::string& old, const std::string& by) {
  const std::size_t at = text.find(old);
  EXPECT_NE(at, std::string::npos) << old;
  return at == std::string::npos ? text : text.replace(at, old.size(), by);
}

// The car's chassis is the convex hull of nine points. Its volume, computed from facets found by brute force over all triples of points, is
// 0.4158 l. For the comparison the mass is given, because MuJoCo 2.2.2 uses the volume of the inertia box.
TEST(MjcfPeer, HullVolumeOfCarChassis) {
  NEEDS_MJCF_DATA();
  const std::string name = "mechanism/open_chain/mujoco/model__car__car.xml", text = load_data(name);
  const auto model = read_mjcf(text, name, data_options());
  ASSERT_TRUE(model.has_value()) << model.error().text();
  const Mechanism& m = *model->mechanism;
  EXPECT_NEAR(m.link(m.find_link("car")).inertia.mass - 4.0 / 3.0 * pi * 0.015 * 0.015 * 0.015 * 1000, 0.4158, 1e-12);
  const std::string with_mass = replaced(text, "mesh=\"chasis\"/>", "mesh=\"chasis\" mass=\"0.4158\"/>");
  const auto again = read_mjcf(with_mass, name, data_options());
  ASSERT_TRUE(again.has_value()) << again.error().text();
  PeerModel peer = open_text_with_mujoco(with_mass);
  check(*again, peer, "model__car__car.xml (mass given)", 5, single_precision);
}

// One hundred free bodies from nested frames and replicates, and a humanoid attached from another file.
TEST(MjcfPeer, HumanoidAndAHundredBodies) {
  NEEDS_MJCF_DATA();
  const std::string folder = "mechanism/open_chain/mujoco/", name = folder + "model__humanoid__humanoid100.xml";
  const std::string text = load_data(name);
  RobotOptions options;
  options.read_asset = [&](const std::string& path) {
    return files::read_file(data_folder() + folder + "model__humanoid__" + path.substr(folder.size()));
  };
  const auto both = read_mjcf(text, name, options);
  ASSERT_TRUE(both.has_value()) << both.error().text();
  EXPECT_EQ(both->mechanism->nv(), 627) << "the file's own comment";

  const std::string alone = replaced(replaced(text, "<model file=\"humanoid.xml\"/>", ""),
                                     "<attach model=\"Humanoid\" body=\"torso\" prefix=\"humanoid_\"/>", "");
  const auto bodies = read_mjcf(alone, name);
  ASSERT_TRUE(bodies.has_value()) << bodies.error().text();
  PeerModel peer = open_text_with_mujoco(alone);
  check(*bodies, peer, "model__humanoid__humanoid100.xml (the bodies)", 2);

  // The remaining links come from the humanoid's file; their names have a prefix.
  const std::string humanoid_name = folder + "model__humanoid__humanoid.xml";
  const auto humanoid = read_mjcf(load_data(humanoid_name), humanoid_name);
  ASSERT_TRUE(humanoid.has_value());
  EXPECT_NEAR(both->mechanism->mass(), bodies->mechanism->mass() + humanoid->mechanism->mass(), 1e-9);
  for (const Link& l : humanoid->mechanism->links()) {
    if (l.name == "world") continue;
    const std::size_t colon = l.name.find(':');
    const std::string here =
        "humanoid_" + (colon == std::string::npos ? l.name : l.name.substr(0, colon) + ":humanoid_" + l.name.substr(colon + 1));
    const int i = both->mechanism->find_link(here);
    ASSERT_GE(i, 0) << here;
    EXPECT_EQ(both->mechanism->link(i).inertia, l.inertia) << here;
    EXPECT_EQ(both->mechanism->link(i).joint.dofs, l.joint.dofs) << here;
    EXPECT_EQ(both->mechanism->link(i).shapes.size(), l.shapes.size()) << here;
  }
}

TEST(MjcfPeer, SharedFiles) {
  NEEDS_MJCF_DATA();
  for (const char* name : complete_files) check_file(name, 3);
}

void check_random(unsigned first, unsigned last) {
  int compared = 0;
  for (unsigned seed = first; seed <= last; ++seed) {
    const std::string text = RandomMjcf(seed).make();
    SCOPED_TRACE("seed " + std::to_string(seed) + "\n" + text);
    PeerModel peer = open_text_with_mujoco(text);
    if (!peer.model) {
      // the only difference accepted: MuJoCo refuses impossible inertia, which we repair
      EXPECT_TRUE(peer.why.find("A + B >= C") != std::string::npos) << peer.why;
      continue;
    }
    const auto model = read_mjcf(text, "random.xml");
    ASSERT_TRUE(model.has_value()) << model.error().text();
    // a few in a thousand models have a chain of nearly parallel joint axes, and thus a nearly singular inertia matrix
    check(*model, peer, "random " + std::to_string(seed), 3,
          {.mass = 1e-12, .inertia = 3e-6, .moments = 1e-11, .dynamics = 1e-6, .forward = 1e-4, .methods = 1e-6});
    ++compared;
  }
  EXPECT_GT(compared, static_cast<int>(last - first) / 2);
}

TEST(MjcfPeer, RandomModels) { check_random(1, 40); }
TEST(SlowMjcfPeer, ManyRandomModels) { check_random(41, 1000); }

TEST(SlowMjcfPeer, SharedFilesInAHundredStates) {
  NEEDS_MJCF_DATA();
  for (const char* name : complete_files) check_file(name, 100);
}
#endif

}  // namespace
}  // namespace ugoki::robot_formats
