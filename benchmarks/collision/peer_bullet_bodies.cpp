// Bullet's dynamic trees of boxes (btDbvt), with its Gilbert distance of convex hulls in double precision.
//
// Bullet has no query for the closest pair. Instead, the boxes of one group are enlarged by the present distance of the previous closest
// pair and collided with the boxes of the other group. The distance of each pair of overlapping boxes is then calculated.

#include "bodies.h"

#ifdef UGOKI_HAVE_BULLET
#include <BulletCollision/BroadphaseCollision/btDbvt.h>
#include <BulletCollision/BroadphaseCollision/btDbvtBroadphase.h>
#include <BulletCollision/CollisionShapes/btCapsuleShape.h>
#include <BulletCollision/CollisionShapes/btConvexHullShape.h>
#include <BulletCollision/NarrowPhaseCollision/btGjkEpaPenetrationDepthSolver.h>
#include <BulletCollision/NarrowPhaseCollision/btGjkPairDetector.h>
#include <BulletCollision/NarrowPhaseCollision/btPointCollector.h>
#include <BulletCollision/NarrowPhaseCollision/btVoronoiSimplexSolver.h>

#include <algorithm>
#include <limits>

namespace ugoki::benchmarks {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

class Bullet final : public BodiesPeer {
 public:
  Bullet(const PlainMotion& motion, double margin) : motion_(motion), margin_(margin) {
    for (const PlainBody& b : motion.bodies) {
      if (b.vertices.empty()) {
        shapes_.push_back(std::make_unique<btCapsuleShapeZ>(b.radius, 2 * b.half_length));
      } else {
        auto hull = std::make_unique<btConvexHullShape>();
        for (std::size_t i = 0; i + 2 < b.vertices.size(); i += 3)
          hull->addPoint({b.vertices[i], b.vertices[i + 1], b.vertices[i + 2]}, false);
        hull->setMargin(0);
        hull->recalcLocalAabb();
        shapes_.push_back(std::move(hull));
      }
    }
    poses_.resize(shapes_.size());
    move(0);
    for (std::size_t i = 0; i < shapes_.size(); ++i) {
      btVector3 low, high;
      box(i, 0, low, high);
      btDbvt& tree = in_a(i) ? a_ : b_;
      leaves_.push_back(tree.insert(btDbvtVolume::FromMM(low, high), reinterpret_cast<void*>(i)));
      box(i, 0.5 * margin, low, high);
      proxies_.push_back(all_.createProxy(low, high, 0, reinterpret_cast<void*>(i), 1, 1, nullptr));
    }
  }
  ~Bullet() override {
    for (btBroadphaseProxy* p : proxies_) all_.destroyProxy(p, nullptr);
  }
  std::string name() const override { return "Bullet btDbvt"; }
  double nearest(int step) override {
    move(step);
    min_value_ = last_i_ < 0 ? infinity : distance(last_i_, last_j_);
    const double grow = min_value_ < 1e9 ? min_value_ : 1e9;
    for (std::size_t i = 0; i < shapes_.size(); ++i) {
      btVector3 low, high;
      box(i, in_a(i) ? grow : 0, low, high);
      btDbvtVolume volume = btDbvtVolume::FromMM(low, high);
      (in_a(i) ? a_ : b_).update(leaves_[i], volume);
    }
    Policy policy{*this};
    a_.collideTTpersistentStack(a_.m_root, b_.m_root, policy);
    return min_value_;
  }
  int count_within(int step, double, PlainDistance f, void* context) override {
    move(step);
    for (std::size_t i = 0; i < shapes_.size(); ++i) {
      btVector3 low, high;
      box(i, 0.5 * margin_, low, high);
      all_.setAabb(proxies_[i], low, high, nullptr);
    }
    all_.calculateOverlappingPairs(nullptr);
    const auto& pairs = all_.getOverlappingPairCache()->getOverlappingPairArray();
    int found = 0;
    for (int k = 0; k < pairs.size(); ++k) {
      const auto i = static_cast<int>(reinterpret_cast<std::size_t>(pairs[k].m_pProxy0->m_clientObject));
      const auto j = static_cast<int>(reinterpret_cast<std::size_t>(pairs[k].m_pProxy1->m_clientObject));
      if (f(context, i, j) <= margin_) ++found;
    }
    return found;
  }

 private:
  struct Policy : btDbvt::ICollide {
    explicit Policy(Bullet& owner) : owner_(owner) {}
    void Process(const btDbvtNode* x, const btDbvtNode* y) override {
      const auto i = static_cast<int>(reinterpret_cast<std::size_t>(x->data)), j = static_cast<int>(reinterpret_cast<std::size_t>(y->data));
      if (i == owner_.last_i_ && j == owner_.last_j_) return;
      const double d = owner_.distance(i, j);
      if (d >= owner_.min_value_) return;
      owner_.min_value_ = d;
      owner_.last_i_ = i;
      owner_.last_j_ = j;
    }
    Bullet& owner_;
  };
  bool in_a(std::size_t i) const { return static_cast<int>(i) < motion_.first_of_b; }
  void box(std::size_t i, double grow, btVector3& low, btVector3& high) const {
    shapes_[i]->getAabb(poses_[i], low, high);
    const btVector3 g(grow, grow, grow);
    low -= g;
    high += g;
  }
  double distance(int i, int j) {
    const auto* a = static_cast<const btConvexShape*>(shapes_[static_cast<std::size_t>(i)].get());
    const auto* b = static_cast<const btConvexShape*>(shapes_[static_cast<std::size_t>(j)].get());
    btGjkPairDetector detector(a, b, &simplex_, &depth_);
    btGjkPairDetector::ClosestPointInput input;
    input.m_transformA = poses_[static_cast<std::size_t>(i)];
    input.m_transformB = poses_[static_cast<std::size_t>(j)];
    btPointCollector out;
    detector.getClosestPoints(input, out, nullptr);
    return out.m_hasResult ? out.m_distance : infinity;
  }
  void move(int step) {
    for (std::size_t i = 0; i < poses_.size(); ++i) {
      const std::size_t at = static_cast<std::size_t>(step) * poses_.size() + i;
      const double* R = motion_.rotations.data() + 9 * at;
      const double* p = motion_.translations.data() + 3 * at;
      poses_[i] = btTransform({R[0], R[1], R[2], R[3], R[4], R[5], R[6], R[7], R[8]}, {p[0], p[1], p[2]});
    }
  }
  const PlainMotion& motion_;
  double margin_;
  std::vector<std::unique_ptr<btConvexShape>> shapes_;
  std::vector<btTransform> poses_;
  btDbvt a_, b_;
  std::vector<btDbvtNode*> leaves_;
  btDbvtBroadphase all_;
  std::vector<btBroadphaseProxy*> proxies_;
  btVoronoiSimplexSolver simplex_;
  btGjkEpaPenetrationDepthSolver depth_;
  double min_value_ = infinity;
  int last_i_ = -1, last_j_ = -1;
};

}  // namespace

std::unique_ptr<BodiesPeer> make_bullet_bodies(const PlainMotion& motion, double margin) {
  return std::make_unique<Bullet>(motion, margin);
}

}  // namespace ugoki::benchmarks
#else
namespace ugoki::benchmarks {
std::unique_ptr<BodiesPeer> make_bullet_bodies(const PlainMotion&, double) { return nullptr; }
}  // namespace ugoki::benchmarks
#endif
