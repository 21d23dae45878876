// Bullet (libbullet-dev, double precision): btMultiBody for linked bodies, btRigidBody for free ones, with the default settings of its
// world. Bullet has no armature; here it is part of the links' inertia. Bullet has no springs and dampers in joints; here they are torques.

#include "scene.h"

#ifdef UGOKI_HAVE_BULLET
#include <BulletDynamics/Featherstone/btMultiBody.h>
#include <BulletDynamics/Featherstone/btMultiBodyConstraintSolver.h>
#include <BulletDynamics/Featherstone/btMultiBodyDynamicsWorld.h>
#include <BulletDynamics/Featherstone/btMultiBodyJointLimitConstraint.h>
#include <BulletDynamics/Featherstone/btMultiBodyJointMotor.h>
#include <BulletDynamics/Featherstone/btMultiBodyLinkCollider.h>
#include <BulletDynamics/Featherstone/btMultiBodyPoint2Point.h>
#include <btBulletDynamicsCommon.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "bullet_parts.h"

namespace ugoki::benchmarks {
namespace {

/// Excludes pairs of links of one body from collision. A collider's user index is the body; its user index 2 is the link.
struct Filter final : btOverlapFilterCallback {
  std::vector<std::set<std::pair<int, int>>> excluded;
  bool needBroadphaseCollision(btBroadphaseProxy* a, btBroadphaseProxy* b) const override {
    const auto* x = static_cast<btCollisionObject*>(a->m_clientObject);
    const auto* y = static_cast<btCollisionObject*>(b->m_clientObject);
    if (x->getUserIndex() < 0 || x->getUserIndex() != y->getUserIndex()) return true;
    const int i = x->getUserIndex2(), j = y->getUserIndex2();
    return excluded[static_cast<std::size_t>(x->getUserIndex())].count({std::min(i, j), std::max(i, j)}) == 0;
  }
};

class BulletWorld final : public StepWorld {
 public:
  explicit BulletWorld(const StepScene& scene)
      : scene_(scene), dispatcher_(&configuration_), world_(&dispatcher_, &broadphase_, &solver_, &configuration_) {
    world_.setGravity({0, 0, -scene.gravity});
    broadphase_.getOverlappingPairCache()->setOverlapFilterCallback(&filter_);
    shapes_.push_back(std::make_unique<btStaticPlaneShape>(btVector3(0, 0, 1), 0));
    rigid_.push_back(std::make_unique<btRigidBody>(btRigidBody::btRigidBodyConstructionInfo(0, nullptr, shapes_.back().get())));
    rigid_.back()->setFriction(std::sqrt(scene.friction));  // Bullet multiplies the friction of two bodies
    world_.addRigidBody(rigid_.back().get());
    for (std::size_t b = 0; b < scene.bodies.size(); ++b) {
      const StepBody& body = scene.bodies[b];
      filter_.excluded.emplace_back(body.excluded.begin(), body.excluded.end());
      if (body.links.size() == 1)
        add_rigid(body, static_cast<int>(b));
      else
        add_linked(body, static_cast<int>(b));
    }
  }
  ~BulletWorld() override {
    for (const auto& c : constraints_) world_.removeMultiBodyConstraint(c.get());
    for (const auto& c : colliders_) world_.removeCollisionObject(c.get());
    for (const auto& m : linked_) world_.removeMultiBody(m.get());
    for (const auto& r : rigid_) world_.removeRigidBody(r.get());
  }

  void step() override {
    for (BulletSprings& s : springs_) s.apply();
    world_.stepSimulation(scene_.dt, 1, scene_.dt);
  }
  void poses(std::vector<Frame>& out) const override {
    btAlignedObjectArray<btQuaternion> turns;
    btAlignedObjectArray<btVector3> points;
    for (const auto& m : linked_) m->forwardKinematics(turns, points);  // after a step, the links still have the poses before it
    out.clear();
    for (const Place& p : places_) {
      const btTransform X = p.rigid != nullptr ? p.rigid->getWorldTransform()
                            : p.link < 0       ? p.linked->getBaseWorldTransform()
                                               : p.linked->getLink(p.link).m_cachedWorldTransform;
      out.push_back(frame_of(X) * p.link_in_principal);
    }
  }
  double depth() const override {
    double worst = 0;
    for (int i = 0; i < dispatcher_.getNumManifolds(); ++i) {
      const btPersistentManifold& m = *const_cast<btCollisionDispatcher&>(dispatcher_).getManifoldByIndexInternal(i);
      for (int k = 0; k < m.getNumContacts(); ++k) worst = std::max(worst, static_cast<double>(-m.getContactPoint(k).getDistance()));
    }
    return worst;
  }
  int contacts() const override {
    int sum = 0;
    for (int i = 0; i < dispatcher_.getNumManifolds(); ++i)
      sum += const_cast<btCollisionDispatcher&>(dispatcher_).getManifoldByIndexInternal(i)->getNumContacts();
    return sum;
  }
  int dofs() const override {
    int sum = 6 * (static_cast<int>(rigid_.size()) - 1);
    for (const auto& m : linked_) sum += 6 + m->getNumDofs();
    return sum;
  }
  double mass() const override {
    double sum = 0;
    for (const auto& r : rigid_) sum += r->getMass();
    for (const auto& m : linked_) {
      sum += m->getBaseMass();
      for (int i = 0; i < m->getNumLinks(); ++i) sum += m->getLinkMass(i);
    }
    return sum;
  }

 private:
  struct Place {
    const btRigidBody* rigid;
    const btMultiBody* linked;
    int link;
    Frame link_in_principal;
  };

  /// The shapes of a link in the link's principal frame; null if the link has no shapes.
  btCollisionShape* shape_of(const StepBody& b, int link) {
    const Frame to_principal = inverse(b.links[static_cast<std::size_t>(link)].principal);
    std::unique_ptr<btCompoundShape> compound;
    const auto count = std::count_if(b.shapes.begin(), b.shapes.end(), [&](const StepShape& s) { return s.link == link; });
    if (count == 0) return nullptr;
    for (const StepShape& s : b.shapes) {
      if (s.link != link) continue;
      const Frame X = to_principal * s.frame;
      shapes_.push_back(make_shape(s));
      if (count == 1 && is_identity(X)) return shapes_.back().get();
      if (!compound) compound = std::make_unique<btCompoundShape>();
      compound->addChildShape(transform(X), shapes_.back().get());
    }
    shapes_.push_back(std::move(compound));
    return shapes_.back().get();
  }

  void add_rigid(const StepBody& b, int index) {
    const StepLink& l = b.links[0];
    rigid_.push_back(
        std::make_unique<btRigidBody>(btRigidBody::btRigidBodyConstructionInfo(l.mass, nullptr, shape_of(b, 0), vector(l.moments))));
    btRigidBody& r = *rigid_.back();
    r.setWorldTransform(transform(b.base * l.principal));
    r.setFriction(std::sqrt(scene_.friction));
    r.setActivationState(DISABLE_DEACTIVATION);
    r.setUserIndex(index);
    world_.addRigidBody(&r);
    places_.push_back({&r, nullptr, -1, inverse(l.principal)});
  }

  void add_linked(const StepBody& b, int index) {
    const StepLink& base = b.links[0];
    const int count = static_cast<int>(b.links.size()) - 1;
    linked_.push_back(std::make_unique<btMultiBody>(count, base.mass, vector(base.moments), false, false));
    btMultiBody& m = *linked_.back();
    for (int i = 0; i < count; ++i) {
      const StepLink& l = b.links[static_cast<std::size_t>(i) + 1];
      const Frame joint =
          inverse(b.links[static_cast<std::size_t>(l.parent)].principal) * l.joint_frame;  // in the parent's principal frame
      const Frame turn = inverse(joint * l.principal);                                     // from the parent to this link
      btQuaternion rotation;
      transform(turn).getBasis().getRotation(rotation);
      double axis[3], arm[3];
      rotate_back(l.principal.R, l.axis, axis);
      rotate_back(l.principal.R, l.principal.p, arm);
      const btVector3 moments = vector(l.moments), pivot = vector(joint.p);
      if (l.joint == StepJoint::revolute)
        m.setupRevolute(i, l.mass, moments, l.parent - 1, rotation, vector(axis), pivot, vector(arm), false);
      else if (l.joint == StepJoint::prismatic)
        m.setupPrismatic(i, l.mass, moments, l.parent - 1, rotation, vector(axis), pivot, vector(arm), false);
      else
        m.setupSpherical(i, l.mass, moments, l.parent - 1, rotation, pivot, vector(arm), false);
    }
    m.finalizeMultiDof();
    m.setBaseWorldTransform(transform(b.base * base.principal));
    for (int i = 0; i < count; ++i)
      if (b.links[static_cast<std::size_t>(i) + 1].position != 0) m.setJointPos(i, b.links[static_cast<std::size_t>(i) + 1].position);
    m.setLinearDamping(0);
    m.setAngularDamping(0);
    m.setCanSleep(false);
    m.setHasSelfCollision(true);
    world_.addMultiBody(&m);
    btAlignedObjectArray<btQuaternion> turns;
    btAlignedObjectArray<btVector3> points;
    m.forwardKinematics(turns, points);
    for (int i = -1; i < count; ++i) {
      const StepLink& l = b.links[static_cast<std::size_t>(i) + 1];
      if (l.mass > 0) places_.push_back({nullptr, &m, i, inverse(l.principal)});
      if (btCollisionShape* const shape = shape_of(b, i + 1)) add_collider(m, i, shape, index);
      if (i >= 0) add_joint(m, i, l);
    }
    m.updateCollisionObjectWorldTransforms(turns, points);
    if (scene_.servo_gain == 0) springs_.emplace_back(m, b.links, scene_.dt);
    for (const StepLoop& l : b.loops) {
      double a[3], c[3];
      point_in_principal(b, l.a, l.point_a, a);
      point_in_principal(b, l.b, l.point_b, c);
      add(std::make_unique<btMultiBodyPoint2Point>(&m, l.a - 1, &m, l.b - 1, vector(a), vector(c)));
    }
  }
  static void point_in_principal(const StepBody& b, int link, const double* p, double* out) {
    const Frame& X = b.links[static_cast<std::size_t>(link)].principal;
    const double d[3] = {p[0] - X.p[0], p[1] - X.p[1], p[2] - X.p[2]};
    rotate_back(X.R, d, out);
  }
  void add(std::unique_ptr<btMultiBodyConstraint> c) {
    constraints_.push_back(std::move(c));
    constraints_.back()->finalizeMultiDof();
    world_.addMultiBodyConstraint(constraints_.back().get());
  }

  void add_collider(btMultiBody& m, int link, btCollisionShape* shape, int index) {
    colliders_.push_back(std::make_unique<btMultiBodyLinkCollider>(&m, link));
    btMultiBodyLinkCollider& c = *colliders_.back();
    c.setCollisionShape(shape);
    c.setFriction(std::sqrt(scene_.friction));
    c.setUserIndex(index);
    c.setUserIndex2(link + 1);
    c.setWorldTransform(link < 0 ? m.getBaseWorldTransform() : m.getLink(link).m_cachedWorldTransform);
    if (link < 0)
      m.setBaseCollider(&c);
    else
      m.getLink(link).m_collider = &c;
    world_.addCollisionObject(&c, btBroadphaseProxy::DefaultFilter, btBroadphaseProxy::AllFilter);
  }

  void add_joint(btMultiBody& m, int i, const StepLink& l) {
    if (l.joint == StepJoint::spherical) return;
    if (scene_.limits && (std::isfinite(l.lower) || std::isfinite(l.upper)))
      add(std::make_unique<btMultiBodyJointLimitConstraint>(&m, i, l.lower, l.upper));
    if (l.speed != 0) m.setJointVel(i, l.speed);
    if (scene_.servo_gain > 0) {  // a motor, as is usual in Bullet: a velocity constraint towards the position, with bounded impulse
      auto motor = std::make_unique<btMultiBodyJointMotor>(&m, i, 0.0, 200 * scene_.dt);
      motor->setPositionTarget(0, 0.1);
      add(std::move(motor));
    }
  }

  const StepScene& scene_;
  btDefaultCollisionConfiguration configuration_;
  btCollisionDispatcher dispatcher_;
  btDbvtBroadphase broadphase_;
  btMultiBodyConstraintSolver solver_;
  Filter filter_;
  btMultiBodyDynamicsWorld world_;
  std::vector<std::unique_ptr<btCollisionShape>> shapes_;
  std::vector<std::unique_ptr<btRigidBody>> rigid_;
  std::vector<std::unique_ptr<btMultiBody>> linked_;
  std::vector<std::unique_ptr<btMultiBodyLinkCollider>> colliders_;
  std::vector<std::unique_ptr<btMultiBodyConstraint>> constraints_;
  std::vector<BulletSprings> springs_;
  std::vector<Place> places_;
};

}  // namespace

StepWorldPtr make_bullet(const StepScene& scene) { return std::make_unique<BulletWorld>(scene); }

}  // namespace ugoki::benchmarks
#else
namespace ugoki::benchmarks {
StepWorldPtr make_bullet(const StepScene&) { return nullptr; }
}  // namespace ugoki::benchmarks
#endif
