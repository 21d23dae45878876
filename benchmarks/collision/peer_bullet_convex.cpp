// Bullet's two algorithms for the distance between convex hulls, both started from the last separating direction.

#include "convex.h"

#ifdef UGOKI_HAVE_BULLET
#include <BulletCollision/CollisionShapes/btConvexHullShape.h>
#include <BulletCollision/NarrowPhaseCollision/btGjkEpa2.h>
#include <BulletCollision/NarrowPhaseCollision/btGjkEpaPenetrationDepthSolver.h>
#include <BulletCollision/NarrowPhaseCollision/btGjkPairDetector.h>
#include <BulletCollision/NarrowPhaseCollision/btPointCollector.h>
#include <BulletCollision/NarrowPhaseCollision/btVoronoiSimplexSolver.h>

namespace ugoki::benchmarks {
namespace {

void fill(btConvexHullShape& out, const PlainHull& h) {
  for (std::size_t i = 0; i + 2 < h.vertices.size(); i += 3) out.addPoint({h.vertices[i], h.vertices[i + 1], h.vertices[i + 2]}, false);
  out.setMargin(0);
  out.recalcLocalAabb();
}

btTransform pose(const PlainPlace& x) {
  return btTransform(btMatrix3x3(x.R[0], x.R[1], x.R[2], x.R[3], x.R[4], x.R[5], x.R[6], x.R[7], x.R[8]),
                     btVector3(x.p[0], x.p[1], x.p[2]));
}

class GjkEpa2 final : public ConvexPeer {
 public:
  GjkEpa2(const PlainHull& a, const PlainHull& b) {
    fill(a_, a);
    fill(b_, b);
  }
  std::string name() const override { return "Bullet GjkEpa2"; }
  double distance(const PlainPlace& a, const PlainPlace& b) override {
    btGjkEpaSolver2::sResults result;
    if (!btGjkEpaSolver2::Distance(&a_, pose(a), &b_, pose(b), guess_, result)) return -1;
    guess_ = result.normal;
    return result.distance;
  }

 private:
  btConvexHullShape a_, b_;
  btVector3 guess_{1, 0, 0};
};

class PairDetector final : public ConvexPeer {
 public:
  PairDetector(const PlainHull& a, const PlainHull& b) {
    fill(a_, a);
    fill(b_, b);
    detector_ = std::make_unique<btGjkPairDetector>(&a_, &b_, &simplex_, &depth_);  // the constructor copies the margins
    detector_->setCachedSeparatingAxis({1, 0, 0});
  }
  std::string name() const override { return "Bullet GjkPairDetector"; }
  double distance(const PlainPlace& a, const PlainPlace& b) override {
    btGjkPairDetector::ClosestPointInput input;
    input.m_transformA = pose(a);
    input.m_transformB = pose(b);
    btPointCollector out;
    detector_->getClosestPoints(input, out, nullptr);
    return out.m_hasResult ? out.m_distance : -1;
  }

 private:
  btConvexHullShape a_, b_;
  btVoronoiSimplexSolver simplex_;
  btGjkEpaPenetrationDepthSolver depth_;
  std::unique_ptr<btGjkPairDetector> detector_;
};

}  // namespace

void add_bullet_convex(ConvexPeers& peers, const PlainHull& a, const PlainHull& b) {
  peers.push_back(std::make_unique<GjkEpa2>(a, b));
  peers.push_back(std::make_unique<PairDetector>(a, b));
}

}  // namespace ugoki::benchmarks

#else
namespace ugoki::benchmarks {
void add_bullet_convex(ConvexPeers&, const PlainHull&, const PlainHull&) {}
}  // namespace ugoki::benchmarks
#endif
