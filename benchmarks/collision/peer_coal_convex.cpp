// Coal's Gilbert distance, started from the last simplex.

#include "convex.h"

#ifdef UGOKI_HAVE_COAL
#include <coal/distance.h>
#include <coal/shape/convex.h>

namespace ugoki::benchmarks {
namespace {

using CoalHull = coal::Convex<coal::Triangle>;

std::shared_ptr<CoalHull> geometry(const PlainHull& h) {
  auto points = std::make_shared<std::vector<coal::Vec3s>>();
  for (std::size_t i = 0; i + 2 < h.vertices.size(); i += 3) points->push_back({h.vertices[i], h.vertices[i + 1], h.vertices[i + 2]});
  auto triangles = std::make_shared<std::vector<coal::Triangle>>();
  for (const auto& face : h.faces)
    for (std::size_t k = 1; k + 1 < face.size(); ++k)
      triangles->push_back({static_cast<std::size_t>(face[0]), static_cast<std::size_t>(face[k]), static_cast<std::size_t>(face[k + 1])});
  const auto n = static_cast<unsigned>(points->size()), m = static_cast<unsigned>(triangles->size());
  return std::make_shared<CoalHull>(points, n, triangles, m);
}

class Coal final : public ConvexPeer {
 public:
  Coal(const PlainHull& a, const PlainHull& b) : a_(geometry(a)), b_(geometry(b)), distance_(a_.get(), b_.get()) {
    request_.gjk_initial_guess = coal::GJKInitialGuess::CachedGuess;
  }
  std::string name() const override { return "Coal"; }
  double distance(const PlainPlace& a, const PlainPlace& b) override {
    coal::DistanceResult result;
    const double d = distance_(pose(a), pose(b), request_, result);
    request_.updateGuess(result);
    return d;
  }

 private:
  static coal::Transform3s pose(const PlainPlace& x) {
    coal::Matrix3s R;
    R << x.R[0], x.R[1], x.R[2], x.R[3], x.R[4], x.R[5], x.R[6], x.R[7], x.R[8];
    return coal::Transform3s(R, coal::Vec3s(x.p[0], x.p[1], x.p[2]));
  }
  std::shared_ptr<CoalHull> a_, b_;
  coal::ComputeDistance distance_;
  coal::DistanceRequest request_;
};

}  // namespace

void add_coal_convex(ConvexPeers& peers, const PlainHull& a, const PlainHull& b) { peers.push_back(std::make_unique<Coal>(a, b)); }

}  // namespace ugoki::benchmarks

#else
namespace ugoki::benchmarks {
void add_coal_convex(ConvexPeers&, const PlainHull&, const PlainHull&) {}
}  // namespace ugoki::benchmarks
#endif
