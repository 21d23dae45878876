// Bullet's multibody in double precision (libbullet-float64), with the flags of its package.

#include "plain_tree.h"

#ifdef UGOKI_HAVE_BULLET
#include <BulletDynamics/Featherstone/btMultiBody.h>

namespace ugoki::benchmarks {
namespace {

btVector3 vector(const double* x) { return {x[0], x[1], x[2]}; }

class Bullet final : public Peer {
 public:
  explicit Bullet(const PlainTree& tree) : tree_(tree), links_(static_cast<int>(tree.links.size())) {
    const PlainLink& base = tree.links[0];
    const bool fixed = !base.floating;
    first_ = fixed ? 0 : 1;
    const btVector3 none(0, 0, 0);
    body_ = std::make_unique<btMultiBody>(links_ - first_, fixed ? 1.0 : base.mass, fixed ? none : vector(base.inertia), fixed, false);
    for (int i = first_; i < links_; ++i) {
      const PlainLink& l = at(i);
      const btVector3 from = vector(l.p) - (l.parent >= 0 ? vector(at(l.parent).centre) : none);
      body_->setupRevolute(i - first_, l.mass, vector(l.inertia), l.parent - first_, btQuaternion::getIdentity(), vector(l.axis), from,
                           vector(l.centre), true);
    }
    body_->finalizeMultiDof();
    body_->setLinearDamping(0);
    body_->setAngularDamping(0);
    body_->setUseGyroTerm(true);
    body_->setMaxCoordinateVelocity(1e30);
    std::size_t q = 0, v = 0;
    if (!fixed) {
      const double* x = tree.q.data();
      const btQuaternion turn(x[4], x[5], x[6], x[3]);
      const btVector3 centre = quatRotate(turn, vector(base.centre)), w = quatRotate(turn, vector(tree.v.data()));
      body_->setBasePos(vector(x) + centre);
      body_->setWorldToBaseRot(turn.inverse());
      body_->setBaseOmega(w);
      body_->setBaseVel(vector(tree.v.data() + 3) + w.cross(centre));
      q = 7;
      v = 6;
    }
    for (int i = 0; i < links_ - first_; ++i) {
      positions_.push_back(tree.q[q + static_cast<std::size_t>(i)]);
      body_->setJointVel(i, tree.v[v + static_cast<std::size_t>(i)]);
      torques_.push_back(tree.tau[v + static_cast<std::size_t>(i)]);
    }
  }
  std::string name() const override { return "Bullet"; }
  bool forward() override {
    for (int i = 0; i < links_ - first_; ++i) body_->setJointPos(i, positions_[static_cast<std::size_t>(i)]);
    body_->clearForcesAndTorques();
    if (first_ == 1) body_->addBaseForce({0, 0, tree_.gravity * at(0).mass});
    for (int i = first_; i < links_; ++i) {
      body_->addLinkForce(i - first_, {0, 0, tree_.gravity * at(i).mass});
      body_->addJointTorque(i - first_, torques_[static_cast<std::size_t>(i - first_)]);
    }
    body_->computeAccelerationsArticulatedBodyAlgorithmMultiDof(0, r_, v_, m_, false, false, false);
    return true;
  }
  std::vector<double> joint_accelerations() override {
    std::vector<double> out;
    for (int i = 0; i < links_ - first_; ++i)
      out.push_back(r_[body_->getNumDofs() + 6 + i]);  // the results follow nv + 6 intermediate values
    return out;
  }

 private:
  const PlainLink& at(int i) const { return tree_.links[static_cast<std::size_t>(i)]; }
  PlainTree tree_;
  int links_, first_ = 0;
  std::unique_ptr<btMultiBody> body_;
  std::vector<double> positions_, torques_;
  btAlignedObjectArray<btScalar> r_;
  btAlignedObjectArray<btVector3> v_;
  btAlignedObjectArray<btMatrix3x3> m_;
};

}  // namespace

std::unique_ptr<Peer> make_bullet(const PlainTree& tree) { return std::make_unique<Bullet>(tree); }

}  // namespace ugoki::benchmarks
#else
namespace ugoki::benchmarks {
std::unique_ptr<Peer> make_bullet(const PlainTree&) { return nullptr; }
}  // namespace ugoki::benchmarks
#endif
