// DART (libdart-dev) with ODE's collision detection (libdart-collision-ode-dev), which knows capsules; the default detector does not. DART
// has no armature; here it is part of the links' inertia. DART has no ellipsoids.

#include "scene.h"

#ifdef UGOKI_HAVE_DART
#include <algorithm>
#include <cmath>
#include <dart/collision/CollisionFilter.hpp>
#include <dart/collision/ode/OdeCollisionDetector.hpp>
#include <dart/constraint/ConstraintSolver.hpp>
#include <dart/dynamics/BallJoint.hpp>
#include <dart/dynamics/BodyNode.hpp>
#include <dart/dynamics/BoxShape.hpp>
#include <dart/dynamics/CapsuleShape.hpp>
#include <dart/dynamics/CylinderShape.hpp>
#include <dart/dynamics/FreeJoint.hpp>
#include <dart/dynamics/PlaneShape.hpp>
#include <dart/dynamics/PrismaticJoint.hpp>
#include <dart/dynamics/RevoluteJoint.hpp>
#include <dart/dynamics/ShapeNode.hpp>
#include <dart/dynamics/Skeleton.hpp>
#include <dart/dynamics/SphereShape.hpp>
#include <dart/dynamics/WeldJoint.hpp>
#include <dart/simulation/World.hpp>
#include <stdexcept>

namespace ugoki::benchmarks {
namespace {

using namespace dart::dynamics;

constexpr double smallest = 1e-9;  // kg, kg m^2: minimum mass and moment, because DART warns of links without mass

Eigen::Vector3d vector(const double* x) { return {x[0], x[1], x[2]}; }
Eigen::Isometry3d transform(const Frame& X) {
  Eigen::Isometry3d out = Eigen::Isometry3d::Identity();
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) out.linear()(i, j) = X.R[3 * i + j];
  out.translation() = vector(X.p);
  return out;
}

ShapePtr make_shape(const StepShape& s) {
  const Eigen::Vector3d whole = 2 * vector(s.size);
  switch (s.type) {
    case StepShapeType::sphere: return std::make_shared<SphereShape>(s.size[0]);
    case StepShapeType::capsule: return std::make_shared<CapsuleShape>(s.size[0], whole[1]);
    case StepShapeType::cylinder: return std::make_shared<CylinderShape>(s.size[0], whole[1]);
    case StepShapeType::box: return std::make_shared<BoxShape>(whole);
    case StepShapeType::ellipsoid: break;
  }
  throw std::runtime_error("DART: its collision detection has no ellipsoids");
}

class DartWorld final : public StepWorld {
 public:
  explicit DartWorld(const StepScene& scene) : scene_(scene), world_(dart::simulation::World::create()) {
    for (const StepBody& b : scene.bodies)  // BallJointConstraint moves cassie by 0.2 m in 0.1 s of free fall, with any force mixing
      if (!b.loops.empty()) throw std::runtime_error("DART: its ball constraints push a closed robot apart");
    world_->setTimeStep(scene.dt);
    world_->setGravity({0, 0, -scene.gravity});
    auto* const solver = world_->getConstraintSolver();
    solver->setCollisionDetector(dart::collision::OdeCollisionDetector::create());
    auto& option = solver->getCollisionOption();
    option.maxNumContacts = 100'000;
    filter_ = std::make_shared<dart::collision::BodyNodeCollisionFilter>();
    option.collisionFilter = filter_;
    const SkeletonPtr ground = Skeleton::create("ground");
    BodyNode* const floor = ground->createJointAndBodyNodePair<WeldJoint>().second;
    add_shape(floor, std::make_shared<PlaneShape>(Eigen::Vector3d(0, 0, 1), 0.0), Eigen::Isometry3d::Identity());
    ground->setMobile(false);
    world_->addSkeleton(ground);
    for (const StepBody& b : scene.bodies) add_body(b);
  }

  void step() override { world_->step(); }
  void poses(std::vector<Frame>& out) const override {
    out.clear();
    for (const BodyNode* body : places_) {
      const Eigen::Isometry3d X = body->getWorldTransform();
      Frame f;
      for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) f.R[3 * i + j] = X.linear()(i, j);
        f.p[i] = X.translation()[i];
      }
      out.push_back(f);
    }
  }
  double depth() const override {
    double worst = 0;
    for (const auto& c : world_->getLastCollisionResult().getContacts()) worst = std::max(worst, c.penetrationDepth);
    return worst;
  }
  int contacts() const override { return static_cast<int>(world_->getLastCollisionResult().getNumContacts()); }
  int dofs() const override {
    std::size_t sum = 0;
    for (std::size_t i = 1; i < world_->getNumSkeletons(); ++i) sum += world_->getSkeleton(i)->getNumDofs();
    return static_cast<int>(sum);
  }
  double mass() const override {
    double sum = 0;
    for (std::size_t i = 1; i < world_->getNumSkeletons(); ++i) sum += world_->getSkeleton(i)->getMass();
    return sum;
  }

 private:
  void add_shape(BodyNode* body, const ShapePtr& shape, const Eigen::Isometry3d& at) {
    auto* const node = body->createShapeNodeWith<CollisionAspect, DynamicsAspect>(shape);
    node->setRelativeTransform(at);
    node->getDynamicsAspect()->setFrictionCoeff(scene_.friction);
    node->getDynamicsAspect()->setRestitutionCoeff(0);
  }

  template <class JointType>
  std::pair<JointType*, BodyNode*> add_link(const SkeletonPtr& skeleton, BodyNode* parent, const StepLink& l, const std::string& name) {
    typename JointType::Properties properties;
    properties.mName = "joint " + name;
    properties.mT_ParentBodyToJoint = l.joint == StepJoint::floating ? Eigen::Isometry3d::Identity() : transform(l.joint_frame);
    return skeleton->createJointAndBodyNodePair<JointType>(parent, properties, BodyNode::AspectProperties(name));
  }

  template <class JointType>
  BodyNode* add_single(const SkeletonPtr& skeleton, BodyNode* parent, const StepLink& l, const std::string& name) {
    const auto [joint, body] = add_link<JointType>(skeleton, parent, l, name);
    joint->setAxis(vector(l.axis));
    joint->setSpringStiffness(0, l.stiffness);
    joint->setRestPosition(0, l.rest);
    joint->setDampingCoefficient(0, l.damping);
    if (scene_.servo_gain > 0) {
      joint->setSpringStiffness(0, l.stiffness + scene_.servo_gain);
      joint->setDampingCoefficient(0, l.damping + scene_.servo_damping);
    }
    if (scene_.limits && (std::isfinite(l.lower) || std::isfinite(l.upper))) {
      joint->setPositionLowerLimit(0, l.lower);
      joint->setPositionUpperLimit(0, l.upper);
      joint->setLimitEnforcement(true);
    }
    joint->setPosition(0, l.position);
    joint->setVelocity(0, l.speed);
    return body;
  }

  void add_body(const StepBody& b) {
    const SkeletonPtr skeleton = Skeleton::create("body " + std::to_string(world_->getNumSkeletons()));
    std::vector<BodyNode*> nodes;
    for (const StepLink& l : b.links) {
      const std::string name = "link " + std::to_string(nodes.size());
      BodyNode* const parent = l.parent < 0 ? nullptr : nodes[static_cast<std::size_t>(l.parent)];
      BodyNode* body = nullptr;
      switch (l.joint) {
        case StepJoint::floating: {
          const auto [joint, node] = add_link<FreeJoint>(skeleton, parent, l, name);
          joint->setTransform(transform(b.base));
          body = node;
          break;
        }
        case StepJoint::revolute: body = add_single<RevoluteJoint>(skeleton, parent, l, name); break;
        case StepJoint::prismatic: body = add_single<PrismaticJoint>(skeleton, parent, l, name); break;
        case StepJoint::spherical: body = add_link<BallJoint>(skeleton, parent, l, name).second; break;
      }
      const Eigen::Matrix3d R = transform(l.principal).linear();
      const Eigen::Vector3d moments = vector(l.moments).cwiseMax(smallest);
      const Eigen::Matrix3d I = R * moments.asDiagonal() * R.transpose();
      body->setInertia(Inertia(std::max(l.mass, smallest), vector(l.centre), I));
      nodes.push_back(body);
      if (l.mass > 0) places_.push_back(body);
    }
    for (const StepShape& s : b.shapes) add_shape(nodes[static_cast<std::size_t>(s.link)], make_shape(s), transform(s.frame));
    for (const auto& pair : b.excluded)
      filter_->addBodyNodePairToBlackList(nodes[static_cast<std::size_t>(pair.first)], nodes[static_cast<std::size_t>(pair.second)]);
    skeleton->enableSelfCollisionCheck();
    skeleton->enableAdjacentBodyCheck();
    world_->addSkeleton(skeleton);
  }

  const StepScene& scene_;
  dart::simulation::WorldPtr world_;
  std::shared_ptr<dart::collision::BodyNodeCollisionFilter> filter_;
  std::vector<BodyNode*> places_;
};

}  // namespace

StepWorldPtr make_dart(const StepScene& scene) { return std::make_unique<DartWorld>(scene); }

}  // namespace ugoki::benchmarks
#else
namespace ugoki::benchmarks {
StepWorldPtr make_dart(const StepScene&) { return nullptr; }
}  // namespace ugoki::benchmarks
#endif
