// Bias forces, inertia matrix and forward dynamics compared with MuJoCo on random trees written as MJCF.

#include <gtest/gtest.h>

#include "random_mechanism.h"
#include "ugoki/base/number.h"
#include "ugoki/dynamics/dynamics.h"

#ifdef UGOKI_HAVE_MUJOCO
#include <mujoco/mujoco.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#endif

namespace ugoki::dynamics {
namespace {

#ifndef UGOKI_HAVE_MUJOCO
TEST(AgainstMuJoCo, RandomTrees) { GTEST_SKIP() << "MuJoCo (libmujoco-dev) is not installed"; }
#else

using testing::RandomSource;

std::string numbers(std::initializer_list<double> values) {
  std::string out;
  for (const double v : values) out += to_text(v) + " ";
  return out;
}

void write_body(const Mechanism& m, int i, std::string& out) {
  const Link& l = m.link(i);
  const Quat r = to_quat(l.joint.X_PJ.R);
  const Vec3 p = l.joint.X_PJ.p, c = l.inertia.centre();
  const Sym3 I = l.inertia.about_centre();
  out += "<body name='" + l.name + "' pos='" + numbers({p.x, p.y, p.z}) + "' quat='" + numbers({r.w, r.x, r.y, r.z}) + "'>";
  const Vec3 a = l.joint.axis;
  const std::string armature = "armature='" + to_text(l.joint.dofs[0].armature) + "'";
  if (l.joint.type == JointType::floating) out += "<freejoint/>";
  if (l.joint.type == JointType::revolute) out += "<joint type='hinge' axis='" + numbers({a.x, a.y, a.z}) + "' " + armature + "/>";
  if (l.joint.type == JointType::prismatic) out += "<joint type='slide' axis='" + numbers({a.x, a.y, a.z}) + "' " + armature + "/>";
  if (l.joint.type == JointType::spherical) out += "<joint type='ball' " + armature + "/>";
  out += "<inertial pos='" + numbers({c.x, c.y, c.z}) + "' mass='" + to_text(l.inertia.mass) + "' diaginertia='" +
         numbers({I.xx, I.yy, I.zz}) + "'/>";
  for (int k = l.child; k >= 0; k = m.link(k).sibling) write_body(m, k, out);
  out += "</body>";
}

TEST(AgainstMuJoCo, RandomTrees) {
  const JointType joints[] = {JointType::revolute, JointType::prismatic, JointType::spherical, JointType::fixed};
  for (unsigned seed = 1; seed <= 30; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    RandomSource random(seed);
    MechanismSpec spec = random_spec(random, 2 + random.below(20), joints);
    for (LinkSpec& l : spec.links) {
      // Principal axes parallel to the link's axes; MuJoCo computes other principal axes only to about 1e-8
      l.inertia = solid_inertia(Shape::box(random.vec(0.2) + Vec3{0.3, 0.3, 0.3}, {Mat3::identity(), random.vec(0.3)}), 800);
      for (Dof& f : l.joint.dofs) f.armature = l.joint.dofs[0].armature;
      if (l.joint.type == JointType::floating)
        for (Dof& f : l.joint.dofs) f.armature = 0;
    }
    spec.links[0].joint.X_PJ = {};  // the pose of MuJoCo's free joint is given by its coordinates alone
    const MechanismPtr m = Mechanism::make(std::move(spec)).value();
    std::string xml = "<mujoco><compiler balanceinertia='false' boundmass='0' boundinertia='0'/><option gravity='0 0 -9.81'/><worldbody>";
    write_body(*m, 0, xml);
    xml += "</worldbody></mujoco>";
    const auto file = std::filesystem::temp_directory_path() / ("ugoki-peer-" + std::to_string(::getpid()) + ".xml");
    std::ofstream(file) << xml;
    char why[1000] = "";
    mjModel* model = mj_loadXML(file.c_str(), nullptr, why, sizeof why);
    std::filesystem::remove(file);
    ASSERT_NE(model, nullptr) << why;
    mjData* data = mj_makeData(model);
    ASSERT_EQ(model->nv, m->nv());
    ASSERT_EQ(model->nq, m->nq());

    // MuJoCo may number its bodies in another order, so bodies are matched by name.
    State s(*m);
    randomize(random, *m, s);
    Workspace ws(*m);
    std::vector<int> q_at(s.q.size()), v_at(s.v.size());
    for (const Link& l : m->links()) {
      if (l.joint.nv() == 0) continue;
      const int body = mj_name2id(model, mjOBJ_BODY, l.name.c_str());
      const int joint = model->body_jntadr[body];
      // MuJoCo's free joint has linear velocity before angular velocity
      for (int k = 0; k < l.joint.nq(); ++k) q_at[static_cast<std::size_t>(l.q_index + k)] = model->jnt_qposadr[joint] + k;
      for (int k = 0; k < l.joint.nv(); ++k)
        v_at[static_cast<std::size_t>(l.v_index + k)] = model->jnt_dofadr[joint] + (l.joint.type == JointType::floating ? (k + 3) % 6 : k);
    }
    for (std::size_t i = 0; i < s.q.size(); ++i) data->qpos[q_at[i]] = s.q[i];
    for (std::size_t i = 0; i < s.v.size(); ++i) {
      data->qvel[v_at[i]] = s.v[i];
      data->qfrc_applied[v_at[i]] = s.tau[i];
    }
    mj_forward(model, data);
    update_kinematics(*m, s.q, s.v, ws);
    std::vector<double> vdot(s.v.size());
    ASSERT_TRUE(calc_forward_dynamics(*m, ws, s.tau, {0, 0, -9.81}, {}, vdot));
    double scale = 1;
    for (const double x : vdot) scale = std::max(scale, std::fabs(x));
    for (std::size_t i = 0; i < vdot.size(); ++i) EXPECT_NEAR(vdot[i], data->qacc[v_at[i]], 1e-8 * scale) << "degree of freedom " << i;

    std::vector<double> b(s.v.size());
    calc_inverse_dynamics(*m, ws, {}, {0, 0, -9.81}, {}, b);
    double b_scale = 1;
    for (const double x : b) b_scale = std::max(b_scale, std::fabs(x));
    for (std::size_t i = 0; i < b.size(); ++i) EXPECT_NEAR(b[i], data->qfrc_bias[v_at[i]], 1e-8 * b_scale) << "degree of freedom " << i;

    const std::size_t n = s.v.size();
    std::vector<double> M(n * n), theirs(n * n);
    calc_inertia_matrix(*m, ws, M);
    mj_fullM(model, theirs.data(), data->qM);
    double M_scale = 1;
    for (const double x : M) M_scale = std::max(M_scale, std::fabs(x));
    for (std::size_t i = 0; i < n; ++i)
      for (std::size_t j = 0; j < n; ++j)
        EXPECT_NEAR(M[i * n + j], theirs[static_cast<std::size_t>(v_at[i]) * n + static_cast<std::size_t>(v_at[j])], 1e-10 * M_scale);
    mj_deleteData(data);
    mj_deleteModel(model);
  }
}
#endif

}  // namespace
}  // namespace ugoki::dynamics
