// MuJoCo (libmujoco-dev), with its own settings for everything but time step, friction and the pairs that collide.

#include "scene.h"

#ifdef UGOKI_HAVE_MUJOCO
#include <mujoco/mujoco.h>

#include <algorithm>
#include <cstring>
#include <stdexcept>

namespace ugoki::benchmarks {
namespace {

class MujocoWorld final : public StepWorld {
 public:
  MujocoWorld(const StepScene& scene, mjtSolver solver) {
    const std::string text = scene.mjcf.empty() ? write_scene_mjcf(scene) : scene.mjcf;
    const auto files = std::make_unique<mjVFS>();
    mj_defaultVFS(files.get());
    if (mj_makeEmptyFileVFS(files.get(), "scene.xml", static_cast<int>(text.size())) != 0) throw StepLimit("MuJoCo: too much text");
    std::memcpy(files->filedata[mj_findFileVFS(files.get(), "scene.xml")], text.data(), text.size());
    char error[400] = "";
    model_.reset(mj_loadXML("scene.xml", files.get(), error, sizeof error));
    mj_deleteVFS(files.get());
    if (model_ == nullptr) throw std::runtime_error(std::string("MuJoCo: ") + error);
    mjModel& m = *model_;
    m.opt.solver = solver;
    m.opt.timestep = scene.dt;
    m.opt.gravity[2] = -scene.gravity;
    if (!scene.limits) m.opt.disableflags |= mjDSBL_LIMIT;
    for (int g = 0; g < m.ngeom; ++g) {
      m.geom_friction[3 * g] = scene.friction;
      m.geom_condim[g] = 3;
      m.geom_priority[g] = 0;
      if (m.geom_contype[g] == 0 && m.geom_conaffinity[g] == 0) continue;
      m.geom_contype[g] = m.geom_conaffinity[g] = 1;
    }
    if (scene.servo_gain > 0) set_servos(scene);
    data_.reset(mj_makeData(&m));
    if (data_ == nullptr) throw std::runtime_error("MuJoCo: no memory for so many contacts");
    int body_index = 0;
    for (const StepBody& b : scene.bodies) {
      const std::string prefix = scene.mjcf.empty() ? std::to_string(body_index++) + '/' : std::string();
      for (std::size_t i = 0; i < b.links.size(); ++i) add_link(b, static_cast<int>(i), prefix);
    }
    mj_forward(&m, data_.get());
  }

  void step() override {
    mj_step(model_.get(), data_.get());
    const auto warned = [&](mjtWarning w) { return data_->warning[w].number > 0; };
    if (warned(mjWARN_CONTACTFULL) || warned(mjWARN_CNSTRFULL)) throw StepLimit("its memory for contacts is full");
    // MuJoCo restarts the simulation after these warnings.
    if (warned(mjWARN_BADQPOS) || warned(mjWARN_BADQVEL) || warned(mjWARN_BADQACC)) throw std::runtime_error("it has diverged");
  }
  void poses(std::vector<Frame>& out) const override {
    const std::vector<double> q(data_->qpos, data_->qpos + model_->nq);
    mj_kinematics(model_.get(), data_.get());  // poses after the step; the call changes qpos by normalising quaternions
    std::copy(q.begin(), q.end(), data_->qpos);
    out.clear();
    for (const Place& p : places_) {
      Frame X;
      std::copy_n(data_->xmat + 9 * p.body, 9, X.R);
      std::copy_n(data_->xpos + 3 * p.body, 3, X.p);
      out.push_back(X * p.link_in_body);
    }
  }
  double depth() const override {
    double worst = 0;
    for (int i = 0; i < data_->ncon; ++i) worst = std::max(worst, -data_->contact[i].dist);
    return worst;
  }
  int contacts() const override { return data_->ncon; }
  int dofs() const override { return model_->nv; }
  double mass() const override { return mj_getTotalmass(model_.get()); }

 private:
  struct Place {
    int body;
    Frame link_in_body;
  };

  /// Adds the servos as springs and dampers of the hinges, like MuJoCo's position servos: explicit stiffness and implicit damping.
  void set_servos(const StepScene& scene) {
    mjModel& m = *model_;
    for (int j = 0; j < m.njnt; ++j) {
      if (m.jnt_type[j] != mjJNT_HINGE) continue;
      m.jnt_stiffness[j] += scene.servo_gain;
      m.dof_damping[m.jnt_dofadr[j]] += scene.servo_damping;
    }
  }

  void add_link(const StepBody& b, int i, const std::string& prefix) {
    const StepLink& l = b.links[static_cast<std::size_t>(i)];
    mjModel& m = *model_;
    if (l.mass > 0) {
      const int body = mj_name2id(&m, mjOBJ_BODY, (prefix + l.name).c_str());
      if (body < 0) throw std::runtime_error("MuJoCo has no body " + prefix + l.name);
      places_.push_back({body, inverse(l.file_frame)});
      if (l.joint == StepJoint::floating) {
        const Frame X = b.base * l.file_frame;
        double* const q = data_->qpos + m.jnt_qposadr[m.body_jntadr[body]];
        std::copy_n(X.p, 3, q);
        quaternion_of(X.R, q + 3);
      }
    }
    if (l.speed == 0 && l.position == 0) return;
    // A joint of an auxiliary link belongs to the next link with mass.
    int joint = 0, end = i;
    while (b.links[static_cast<std::size_t>(end)].mass == 0) ++end, ++joint;
    const int body = mj_name2id(&m, mjOBJ_BODY, (prefix + b.links[static_cast<std::size_t>(end)].name).c_str());
    const int j = m.body_jntadr[body] + m.body_jntnum[body] - 1 - joint;
    data_->qvel[m.jnt_dofadr[j]] = l.speed;
    data_->qpos[m.jnt_qposadr[j]] = m.qpos0[m.jnt_qposadr[j]] + l.position;
  }

  struct Delete {
    void operator()(mjModel* m) const { mj_deleteModel(m); }
    void operator()(mjData* d) const { mj_deleteData(d); }
  };
  std::unique_ptr<mjModel, Delete> model_;
  std::unique_ptr<mjData, Delete> data_;
  std::vector<Place> places_;
};

}  // namespace

StepWorldPtr make_mujoco_newton(const StepScene& scene) { return std::make_unique<MujocoWorld>(scene, mjSOL_NEWTON); }
StepWorldPtr make_mujoco_pgs(const StepScene& scene) { return std::make_unique<MujocoWorld>(scene, mjSOL_PGS); }

}  // namespace ugoki::benchmarks
#else
namespace ugoki::benchmarks {
StepWorldPtr make_mujoco_newton(const StepScene&) { return nullptr; }
StepWorldPtr make_mujoco_pgs(const StepScene&) { return nullptr; }
}  // namespace ugoki::benchmarks
#endif
