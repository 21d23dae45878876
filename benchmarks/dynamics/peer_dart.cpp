#include "plain_tree.h"

#ifdef UGOKI_HAVE_DART
#include <dart/dynamics/BodyNode.hpp>
#include <dart/dynamics/FreeJoint.hpp>
#include <dart/dynamics/RevoluteJoint.hpp>
#include <dart/dynamics/Skeleton.hpp>

namespace ugoki::benchmarks {
namespace {

using namespace dart::dynamics;

Eigen::Vector3d vector(const double* x) { return {x[0], x[1], x[2]}; }

class Dart final : public Peer {
 public:
  explicit Dart(const PlainTree& tree) : skeleton_(Skeleton::create()) {
    std::vector<BodyNode*> bodies;
    std::size_t q = 0, v = 0;
    for (const PlainLink& l : tree.links) {
      BodyNode* const parent = l.parent < 0 ? nullptr : bodies[static_cast<std::size_t>(l.parent)];
      BodyNode* body = nullptr;
      const BodyNode::AspectProperties named("b" + std::to_string(bodies.size()));
      if (l.floating) {
        FreeJoint::Properties free;
        free.mName = "base";
        const auto pair = skeleton_->createJointAndBodyNodePair<FreeJoint>(parent, free, named);
        body = pair.second;
        Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
        pose.linear() = Eigen::Quaterniond(tree.q[q + 3], tree.q[q + 4], tree.q[q + 5], tree.q[q + 6]).toRotationMatrix();
        pose.translation() = vector(tree.q.data() + q);
        pair.first->setTransform(pose);
        Eigen::Vector6d velocity;
        velocity << vector(tree.v.data() + v), pose.linear().transpose() * vector(tree.v.data() + v + 3);
        pair.first->setVelocities(velocity);
        q += 7;
        v += 6;
      } else {
        RevoluteJoint::Properties properties;
        properties.mName = "j" + std::to_string(bodies.size());
        properties.mAxis = vector(l.axis);
        properties.mT_ParentBodyToJoint.translation() = vector(l.p);
        const auto pair = skeleton_->createJointAndBodyNodePair<RevoluteJoint>(parent, properties, named);
        body = pair.second;
        pair.first->setPosition(0, tree.q[q++]);
        pair.first->setVelocity(0, tree.v[v]);
        pair.first->setForce(0, tree.tau[v++]);
        joints_.push_back(pair.first);
      }
      Inertia inertia(l.mass, vector(l.centre), vector(l.inertia).asDiagonal());
      body->setInertia(inertia);
      bodies.push_back(body);
    }
    skeleton_->setGravity({0, 0, tree.gravity});
    for (RevoluteJoint* joint : joints_) torques_.push_back(joint->getForce(0));
    positions_[0] = skeleton_->getPositions();
    positions_[1] = positions_[0] * (1 + 1e-15);
  }
  std::string name() const override { return "DART 6.12"; }
  bool forward() override {
    move();
    for (std::size_t i = 0; i < joints_.size(); ++i) joints_[i]->setForce(0, torques_[i]);
    skeleton_->computeForwardDynamics();
    return true;
  }
  bool inverse() override {
    move();
    skeleton_->computeInverseDynamics();
    return true;
  }
  bool inertia() override {
    move();
    return skeleton_->getMassMatrix().size() > 0;
  }
  std::vector<double> joint_accelerations() override {
    std::vector<double> out;
    for (RevoluteJoint* joint : joints_) out.push_back(joint->getAcceleration(0));
    return out;
  }
  std::vector<double> joint_torques() override {
    std::vector<double> out;
    for (RevoluteJoint* joint : joints_) out.push_back(joint->getForce(0));
    return out;
  }

 private:
  /// Alternates between two positions, because DART recomputes position-dependent quantities only if the positions have changed.
  void move() { skeleton_->setPositions(positions_[which_ ^= 1]); }

  SkeletonPtr skeleton_;
  std::vector<RevoluteJoint*> joints_;
  std::vector<double> torques_;
  Eigen::VectorXd positions_[2];
  int which_ = 0;
};

}  // namespace

std::unique_ptr<Peer> make_dart(const PlainTree& tree) { return std::make_unique<Dart>(tree); }

}  // namespace ugoki::benchmarks
#else
namespace ugoki::benchmarks {
std::unique_ptr<Peer> make_dart(const PlainTree&) { return nullptr; }
}  // namespace ugoki::benchmarks
#endif
