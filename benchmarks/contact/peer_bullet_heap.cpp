#include "heap.h"

#ifdef UGOKI_HAVE_BULLET
#include <btBulletDynamicsCommon.h>

#include <algorithm>
#include <memory>
#endif

namespace ugoki::benchmarks {

#ifdef UGOKI_HAVE_BULLET
HeapResult run_bullet_heap(const std::vector<HeapBody>& heap, double dt, int steps) {
  btDefaultCollisionConfiguration configuration;
  btCollisionDispatcher dispatcher(&configuration);
  btDbvtBroadphase broadphase;
  btSequentialImpulseConstraintSolver solver;
  btDiscreteDynamicsWorld world(&dispatcher, &broadphase, &solver, &configuration);
  world.setGravity({0, 0, -9.81});
  std::vector<std::unique_ptr<btCollisionShape>> shapes;
  std::vector<std::unique_ptr<btRigidBody>> bodies;
  const auto add = [&](double mass, const btTransform& at) {
    btVector3 inertia(0, 0, 0);
    if (mass > 0) shapes.back()->calculateLocalInertia(mass, inertia);
    bodies.push_back(std::make_unique<btRigidBody>(btRigidBody::btRigidBodyConstructionInfo(mass, nullptr, shapes.back().get(), inertia)));
    bodies.back()->setWorldTransform(at);
    bodies.back()->setFriction(mass > 0 ? heap_friction : 1.0);
    world.addRigidBody(bodies.back().get());
  };
  shapes.push_back(std::make_unique<btStaticPlaneShape>(btVector3(0, 0, 1), 0));
  add(0, btTransform::getIdentity());
  constexpr double pi = 3.14159265358979323846;
  for (const HeapBody& b : heap) {
    const double r = b.size[0], h = b.size[1];
    double volume = 0;
    switch (b.shape) {
      case HeapShape::box:
        shapes.push_back(std::make_unique<btBoxShape>(btVector3(b.size[0], b.size[1], b.size[2])));
        volume = 8 * b.size[0] * b.size[1] * b.size[2];
        break;
      case HeapShape::sphere:
        shapes.push_back(std::make_unique<btSphereShape>(r));
        volume = 4 * pi / 3 * r * r * r;
        break;
      case HeapShape::capsule:
        shapes.push_back(std::make_unique<btCapsuleShapeZ>(r, 2 * h));
        volume = 4 * pi / 3 * r * r * r + 2 * pi * r * r * h;
        break;
      case HeapShape::cylinder:
        shapes.push_back(std::make_unique<btCylinderShapeZ>(btVector3(r, r, h)));
        volume = 2 * pi * r * r * h;
        break;
    }
    const double* q = b.orientation;
    add(b.density * volume, btTransform(btQuaternion(q[1], q[2], q[3], q[0]), btVector3(b.position[0], b.position[1], b.position[2])));
  }
  HeapResult result;
  for (int i = 0; i < steps; ++i) {
    world.stepSimulation(dt, 1, dt);
    for (int m = 0; m < dispatcher.getNumManifolds(); ++m) {
      const btPersistentManifold* manifold = dispatcher.getManifoldByIndexInternal(m);
      for (int k = 0; k < manifold->getNumContacts(); ++k)
        result.deepest = std::max(result.deepest, static_cast<double>(-manifold->getContactPoint(k).getDistance()));
    }
  }
  for (const auto& body : bodies) world.removeRigidBody(body.get());
  result.measured = true;
  return result;
}
#else
HeapResult run_bullet_heap(const std::vector<HeapBody>&, double, int) { return {}; }
#endif

}  // namespace ugoki::benchmarks
