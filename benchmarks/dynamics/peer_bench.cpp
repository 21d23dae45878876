// The same figure in MuJoCo, in the same run, so that the figure to quote is a ratio. Without contacts: forward dynamics only.

#ifdef UGOKI_HAVE_MUJOCO

#include <benchmark/benchmark.h>
#include <mujoco/mujoco.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <string>

#include "figure.h"
#include "ugoki/base/number.h"
#include "ugoki/dynamics/dynamics.h"

namespace ugoki::benchmarks {
namespace {

std::string numbers(const Vec3& v) { return to_text(v.x) + " " + to_text(v.y) + " " + to_text(v.z); }

void write_body(const Mechanism& m, int index, std::string& out) {
  const Link& link = m.link(index);
  const Sym3 inertia = link.inertia.about_centre();
  const std::string armature = "armature='" + to_text(link.joint.freedoms[0].armature) + "'";
  out += "<body name='" + link.name + "' pos='" + numbers(link.joint.X_PJ.p) + "'>";
  if (link.joint.type == JointType::floating) out += "<freejoint/>";
  if (link.joint.type == JointType::revolute) out += "<joint type='hinge' axis='" + numbers(link.joint.axis) + "' " + armature + "/>";
  if (link.joint.type == JointType::spherical) out += "<joint type='ball' " + armature + "/>";
  out += "<inertial pos='" + numbers(link.inertia.centre()) + "' mass='" + to_text(link.inertia.mass) + "' diaginertia='" +
         numbers({inertia.xx, inertia.yy, inertia.zz}) + "'/>";
  for (int child = link.child; child >= 0; child = m.link(child).brother) write_body(m, child, out);
  out += "</body>";
}

mjModel* load(const Mechanism& m) {
  std::string text = "<mujoco><compiler balanceinertia='false' boundmass='0' boundinertia='0'/><option gravity='0 0 -9.81'/><worldbody>";
  write_body(m, 0, text);
  text += "</worldbody></mujoco>";
  const auto file = std::filesystem::temp_directory_path() / ("ugoki-bench-" + std::to_string(::getpid()) + ".xml");
  std::ofstream(file) << text;
  char why[1000] = "";
  mjModel* model = mj_loadXML(file.c_str(), nullptr, why, sizeof why);
  std::filesystem::remove(file);
  return model;
}

void forward_mujoco(benchmark::State& run) {
  const MechanismPtr figure = make_figure();
  const State state = lively_state(*figure);
  mjModel* model = load(*figure);
  if (model == nullptr || model->nv != figure->nv()) {
    run.SkipWithError("MuJoCo does not load the figure");
    return;
  }
  mjData* data = mj_makeData(model);
  std::vector<std::size_t> v_at(state.v.size());
  for (const Link& link : figure->links()) {
    const int body = mj_name2id(model, mjOBJ_BODY, link.name.c_str());
    const int joint = model->body_jntadr[body];
    for (int k = 0; k < link.joint.nq(); ++k)
      data->qpos[model->jnt_qposadr[joint] + k] = state.q[static_cast<std::size_t>(link.q_index + k)];
    for (int k = 0; k < link.joint.nv(); ++k) {
      const int theirs = model->jnt_dofadr[joint] + (link.joint.type == JointType::floating ? (k + 3) % 6 : k);
      const auto ours = static_cast<std::size_t>(link.v_index + k);
      v_at[ours] = static_cast<std::size_t>(theirs);
      data->qvel[theirs] = state.v[ours];
      data->qfrc_applied[theirs] = state.tau[ours];
    }
  }
  mj_forward(model, data);

  dynamics::Workspace ws(*figure);
  std::vector<double> ours(state.v.size());
  dynamics::update_kinematics(*figure, state.q, state.v, ws);
  bool same = dynamics::calc_forward_dynamics(*figure, ws, state.tau, {0, 0, -9.81}, {}, ours);
  for (std::size_t i = 0; i < ours.size(); ++i) same = same && std::fabs(ours[i] - data->qacc[v_at[i]]) < 1e-6 * (1 + std::fabs(ours[i]));
  if (!same) run.SkipWithError("MuJoCo's accelerations are others");

  if (same)
    for (auto _ : run) {
      mj_fwdPosition(model, data);
      mj_fwdVelocity(model, data);
      mj_fwdAcceleration(model, data);
      benchmark::DoNotOptimize(data->qacc_smooth);
    }
  mj_deleteData(data);
  mj_deleteModel(model);
}
BENCHMARK(forward_mujoco);

}  // namespace
}  // namespace ugoki::benchmarks

#endif
