#include "plain_tree.h"

#ifdef UGOKI_HAVE_MUJOCO
#include <mujoco/mujoco.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <fstream>

namespace ugoki::benchmarks {
namespace {

std::string numbers(const double* x, int n) {
  std::string out;
  char text[32];
  for (int i = 0; i < n; ++i) {
    std::snprintf(text, sizeof text, "%.17g ", x[i]);
    out += text;
  }
  return out;
}

class MuJoCo final : public Peer {
 public:
  explicit MuJoCo(const PlainTree& tree) : tree_(tree) {
    std::string text = "<mujoco><compiler balanceinertia='false' boundmass='0' boundinertia='0'/><option gravity='0 0 " +
                       numbers(&tree.gravity, 1) + "'><flag contact='disable' passive='disable'" +
                       (tree.loops.empty() ? " constraint='disable'" : "") + "/></option><worldbody>";
    for (std::size_t i = 0; i < tree.links.size(); ++i)
      if (tree.links[i].parent < 0) write(static_cast<int>(i), text);
    text += "</worldbody><equality>";
    for (const PlainLoop& l : tree.loops) text += equality(l);
    text += "</equality></mujoco>";
    const auto file = std::filesystem::temp_directory_path() / ("ugoki-bench-" + std::to_string(::getpid()) + ".xml");
    std::ofstream(file) << text;
    char why[1000] = "";
    model_ = mj_loadXML(file.c_str(), nullptr, why, sizeof why);
    std::filesystem::remove(file);
    if (model_ == nullptr) return;
    data_ = mj_makeData(model_);
    int q = 0, v = 0;
    for (std::size_t i = 0; i < tree.links.size(); ++i) {
      const int joint = model_->body_jntadr[mj_name2id(model_, mjOBJ_BODY, ("b" + std::to_string(i)).c_str())];
      const bool floating = tree.links[i].floating;
      const auto qi = static_cast<std::size_t>(q), vi = static_cast<std::size_t>(v);
      std::copy_n(tree.q.data() + qi, floating ? 7 : 1, data_->qpos + model_->jnt_qposadr[joint]);
      const int dof = model_->jnt_dofadr[joint];
      for (int k = 0; k < (floating ? 6 : 1); ++k) {  // MuJoCo's order: linear before angular velocity
        data_->qvel[dof + (floating ? (k + 3) % 6 : k)] = tree.v[vi + static_cast<std::size_t>(k)];
        data_->qfrc_applied[dof + (floating ? (k + 3) % 6 : k)] = tree.tau[vi + static_cast<std::size_t>(k)];
      }
      if (!floating) dofs_.push_back(dof);
      q += floating ? 7 : 1;
      v += floating ? 6 : 1;
    }
  }
  ~MuJoCo() override {
    mj_deleteData(data_);
    mj_deleteModel(model_);
  }
  [[nodiscard]] bool loaded() const { return model_ != nullptr; }
  std::string name() const override { return std::string("MuJoCo ") + mj_versionString(); }
  bool forward() override {
    mj_forward(model_, data_);
    return true;
  }
  bool inverse() override {
    kinematics();
    mj_comVel(model_, data_);
    mj_rne(model_, data_, 1, data_->qfrc_inverse);
    return true;
  }
  bool inertia() override {
    kinematics();
    mj_crb(model_, data_);
    return true;
  }
  std::vector<double> joint_accelerations() override { return of(data_->qacc); }
  std::vector<double> joint_torques() override { return of(data_->qfrc_inverse); }

 private:
  void kinematics() {
    mj_kinematics(model_, data_);
    mj_comPos(model_, data_);
  }
  std::vector<double> of(const mjtNum* x) const {
    std::vector<double> out;
    for (const int dof : dofs_) out.push_back(x[dof]);
    return out;
  }
  static std::string equality(const PlainLoop& l) {  // soft constraints: gaps close gradually
    const std::string b = "b" + std::to_string(l.b), a = "b" + std::to_string(l.a);
    if (l.a < 0) return "<weld body1='" + b + "' relpose='" + numbers(l.inverse_p, 3) + numbers(l.inverse_rotation, 4) + "'/>";
    if (l.weld) return "<weld body1='" + a + "' body2='" + b + "' relpose='" + numbers(l.p, 3) + numbers(l.rotation, 4) + "'/>";
    return "<connect body1='" + a + "' body2='" + b + "' anchor='" + numbers(l.p, 3) + "'/>";
  }
  void write(int i, std::string& out) const {
    const PlainLink& l = tree_.links[static_cast<std::size_t>(i)];
    out += "<body name='b" + std::to_string(i) + "' pos='" + numbers(l.p, 3) + "'>";
    out += l.floating ? "<freejoint/>" : "<joint type='hinge' axis='" + numbers(l.axis, 3) + "'/>";
    out += "<inertial pos='" + numbers(l.centre, 3) + "' mass='" + numbers(&l.mass, 1) + "' diaginertia='" + numbers(l.inertia, 3) + "'/>";
    for (std::size_t k = 0; k < tree_.links.size(); ++k)
      if (tree_.links[k].parent == i) write(static_cast<int>(k), out);
    out += "</body>";
  }

  PlainTree tree_;
  mjModel* model_ = nullptr;
  mjData* data_ = nullptr;
  std::vector<int> dofs_;
};

}  // namespace

std::unique_ptr<Peer> make_mujoco(const PlainTree& tree) {
  auto peer = std::make_unique<MuJoCo>(tree);
  return peer->loaded() ? std::move(peer) : nullptr;
}

}  // namespace ugoki::benchmarks
#else
namespace ugoki::benchmarks {
std::unique_ptr<Peer> make_mujoco(const PlainTree&) { return nullptr; }
}  // namespace ugoki::benchmarks
#endif
