// FCL's two solvers for convex shapes: libccd and its own.

#include "convex.h"

#ifdef UGOKI_HAVE_FCL
#include <fcl/fcl.h>

namespace ugoki::benchmarks {
namespace {

std::shared_ptr<fcl::Convexd> geometry(const PlainHull& h) {
  auto points = std::make_shared<std::vector<fcl::Vector3d>>();
  for (std::size_t i = 0; i + 2 < h.vertices.size(); i += 3) points->push_back({h.vertices[i], h.vertices[i + 1], h.vertices[i + 2]});
  auto faces = std::make_shared<std::vector<int>>();
  for (const auto& face : h.faces) {
    faces->push_back(static_cast<int>(face.size()));
    faces->insert(faces->end(), face.begin(), face.end());
  }
  return std::make_shared<fcl::Convexd>(points, static_cast<int>(h.faces.size()), faces);
}

class Fcl final : public ConvexPeer {
 public:
  Fcl(const PlainHull& a, const PlainHull& b, fcl::GJKSolverType solver, std::string name)
      : a_(geometry(a)), b_(geometry(b)), name_(std::move(name)) {
    request_.enable_nearest_points = true;
    request_.gjk_solver_type = solver;
    request_.distance_tolerance = 1e-8;
  }
  std::string name() const override { return name_; }
  double distance(const PlainPlace& a, const PlainPlace& b) override {
    fcl::DistanceResultd result;
    return fcl::distance(a_.get(), pose(a), b_.get(), pose(b), request_, result);
  }

 private:
  static fcl::Transform3d pose(const PlainPlace& x) {
    fcl::Transform3d X = fcl::Transform3d::Identity();
    X.linear() << x.R[0], x.R[1], x.R[2], x.R[3], x.R[4], x.R[5], x.R[6], x.R[7], x.R[8];
    X.translation() << x.p[0], x.p[1], x.p[2];
    return X;
  }
  std::shared_ptr<fcl::Convexd> a_, b_;
  std::string name_;
  fcl::DistanceRequestd request_;
};

}  // namespace

void add_fcl_convex(ConvexPeers& peers, const PlainHull& a, const PlainHull& b) {
  peers.push_back(std::make_unique<Fcl>(a, b, fcl::GST_LIBCCD, "FCL libccd"));
  peers.push_back(std::make_unique<Fcl>(a, b, fcl::GST_INDEP, "FCL own solver"));
}

}  // namespace ugoki::benchmarks

#else
namespace ugoki::benchmarks {
void add_fcl_convex(ConvexPeers&, const PlainHull&, const PlainHull&) {}
}  // namespace ugoki::benchmarks
#endif
