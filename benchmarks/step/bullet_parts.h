#pragma once
// Shapes and joint springs of Bullet's world.

#include <BulletDynamics/Featherstone/btMultiBody.h>
#include <btBulletDynamicsCommon.h>

#include <algorithm>
#include <cmath>

#include "scene.h"

namespace ugoki::benchmarks {

inline btVector3 vector(const double* x) { return {x[0], x[1], x[2]}; }
inline btTransform transform(const Frame& X) {
  const double* R = X.R;
  return btTransform(btMatrix3x3(R[0], R[1], R[2], R[3], R[4], R[5], R[6], R[7], R[8]), vector(X.p));
}
inline Frame frame_of(const btTransform& X) {
  Frame out;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) out.R[3 * i + j] = X.getBasis()[i][j];
    out.p[i] = X.getOrigin()[i];
  }
  return out;
}
inline bool is_identity(const Frame& X) {
  double error = 0;
  for (int i = 0; i < 9; ++i) error = std::max(error, std::fabs(X.R[i] - (i % 4 == 0 ? 1 : 0)));
  for (const double x : X.p) error = std::max(error, std::fabs(x));
  return error < 1e-9;
}

inline std::unique_ptr<btCollisionShape> make_shape(const StepShape& s) {
  switch (s.type) {
    case StepShapeType::sphere: return std::make_unique<btSphereShape>(s.size[0]);
    case StepShapeType::capsule: return std::make_unique<btCapsuleShapeZ>(s.size[0], 2 * s.size[1]);
    case StepShapeType::cylinder: return std::make_unique<btCylinderShapeZ>(btVector3(s.size[0], s.size[0], s.size[1]));
    case StepShapeType::box: return std::make_unique<btBoxShape>(vector(s.size));
    case StepShapeType::ellipsoid: break;
  }
  constexpr int rings = 10, around = 16;  // an ellipsoid is the convex hull of 146 of its points
  auto hull = std::make_unique<btConvexHullShape>();
  for (int i = 0; i <= rings; ++i)
    for (int k = 0; k < (i % rings == 0 ? 1 : around); ++k) {
      const double a = SIMD_PI * i / rings, b = SIMD_2_PI * k / around;
      hull->addPoint({s.size[0] * std::sin(a) * std::cos(b), s.size[1] * std::sin(a) * std::sin(b), s.size[2] * std::cos(a)}, false);
    }
  hull->recalcLocalAabb();
  hull->setMargin(0.001);
  return hull;
}

/// Implicit springs and dampers of the joints of one body, applied as torques tau for the positions q and velocities v:
///   (1 + dt (D + dt K) W) tau = -K (q - rest) - (D + dt K) v
/// with stiffness K, damping D and the inverse inertia W of these joints in the initial pose. Explicit torques diverge with the dampers of
/// some models; exact implicit torques would need Bullet's inertia matrix in every step.
class BulletSprings {
 public:
  BulletSprings(btMultiBody& m, const std::vector<StepLink>& links, double dt) : body_(&m) {
    for (std::size_t i = 1; i < links.size(); ++i) {
      const StepLink& l = links[i];
      if (l.stiffness != 0 || l.damping != 0)
        springs_.push_back({static_cast<int>(i) - 1, l.stiffness, l.rest, l.damping + dt * l.stiffness});
    }
    btAlignedObjectArray<btScalar> scalars, force, response;
    btAlignedObjectArray<btVector3> vectors;
    btAlignedObjectArray<btMatrix3x3> matrices;
    m.computeAccelerationsArticulatedBodyAlgorithmMultiDof(0, scalars, vectors, matrices, false, false, false);
    const std::size_t n = springs_.size();
    std::vector<double> A(n * n);
    response.resize(6 + m.getNumDofs(), 0);
    for (std::size_t j = 0; j < n; ++j) {
      force.resize(0);
      force.resize(6 + m.getNumDofs(), 0);
      force[6 + m.getLink(springs_[j].link).m_dofOffset] = 1;
      m.calcAccelerationDeltasMultiDof(&force[0], &response[0], scalars, vectors);
      for (std::size_t i = 0; i < n; ++i)
        A[i * n + j] = (i == j ? 1 : 0) + dt * springs_[i].damping * response[6 + m.getLink(springs_[i].link).m_dofOffset];
    }
    invert(A);
    explicit_.resize(n);
  }

  /// Adds the torques for the next step.
  void apply() {
    const std::size_t n = springs_.size();
    for (std::size_t i = 0; i < n; ++i) {
      const Spring& s = springs_[i];
      explicit_[i] = -s.stiffness * (body_->getJointPos(s.link) - s.rest) - s.damping * body_->getJointVel(s.link);
    }
    for (std::size_t i = 0; i < n; ++i) {
      double torque = 0;
      for (std::size_t j = 0; j < n; ++j) torque += inverse_[i * n + j] * explicit_[j];
      body_->addJointTorque(springs_[i].link, torque);
    }
  }

 private:
  struct Spring {
    int link;
    double stiffness, rest, damping;  ///< damping: D + dt K
  };

  /// Gauss-Jordan elimination; the pivots of these matrices are at least about 1.
  void invert(std::vector<double>& A) {
    const std::size_t n = springs_.size();
    inverse_.assign(n * n, 0);
    for (std::size_t i = 0; i < n; ++i) inverse_[i * n + i] = 1;
    for (std::size_t p = 0; p < n; ++p) {
      const double pivot = A[p * n + p];
      for (std::size_t j = 0; j < n; ++j) A[p * n + j] /= pivot, inverse_[p * n + j] /= pivot;
      for (std::size_t i = 0; i < n; ++i) {
        const double f = A[i * n + p];
        if (i == p || f == 0) continue;
        for (std::size_t j = 0; j < n; ++j) A[i * n + j] -= f * A[p * n + j], inverse_[i * n + j] -= f * inverse_[p * n + j];
      }
    }
  }

  btMultiBody* body_;
  std::vector<Spring> springs_;
  std::vector<double> inverse_, explicit_;
};

}  // namespace ugoki::benchmarks
