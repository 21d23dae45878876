// FCL's bounding-volume hierarchies.

#include "meshes.h"

#ifdef UGOKI_HAVE_FCL
#include <fcl/fcl.h>

namespace ugoki::benchmarks {
namespace {

template <class Bound>
class Fcl final : public MeshPeer {
 public:
  Fcl(const PlainMesh& a, const PlainMesh& b, std::string name) : a_(model(a)), b_(model(b)), name_(std::move(name)) {}
  std::string name() const override { return name_; }
  double distance(const PlainPose& X) override {
    fcl::Transform3d pose = fcl::Transform3d::Identity();
    pose.linear() << X.R[0], X.R[1], X.R[2], X.R[3], X.R[4], X.R[5], X.R[6], X.R[7], X.R[8];
    pose.translation() << X.p[0], X.p[1], X.p[2];
    const fcl::DistanceRequestd request(true);
    fcl::DistanceResultd result;
    return fcl::distance(a_.get(), fcl::Transform3d::Identity(), b_.get(), pose, request, result);
  }

 private:
  static std::unique_ptr<fcl::BVHModel<Bound>> model(const PlainMesh& m) {
    std::vector<fcl::Vector3d> vertices;
    for (std::size_t i = 0; i + 2 < m.vertices.size(); i += 3) vertices.push_back({m.vertices[i], m.vertices[i + 1], m.vertices[i + 2]});
    std::vector<fcl::Triangle> triangles;
    for (std::size_t i = 0; i + 2 < m.triangles.size(); i += 3)
      triangles.emplace_back(static_cast<std::size_t>(m.triangles[i]), static_cast<std::size_t>(m.triangles[i + 1]),
                             static_cast<std::size_t>(m.triangles[i + 2]));
    auto out = std::make_unique<fcl::BVHModel<Bound>>();
    out->beginModel(static_cast<int>(triangles.size()), static_cast<int>(vertices.size()));
    out->addSubModel(vertices, triangles);
    out->endModel();
    return out;
  }
  std::unique_ptr<fcl::BVHModel<Bound>> a_, b_;
  std::string name_;
};

}  // namespace

std::unique_ptr<MeshPeer> make_fcl_meshes(const PlainMesh& a, const PlainMesh& b, MeshBounds bounds) {
  if (bounds == MeshBounds::rss) return std::make_unique<Fcl<fcl::RSSd>>(a, b, "FCL RSS");
  return std::make_unique<Fcl<fcl::OBBRSSd>>(a, b, "FCL OBBRSS");
}

}  // namespace ugoki::benchmarks

#else

namespace ugoki::benchmarks {
std::unique_ptr<MeshPeer> make_fcl_meshes(const PlainMesh&, const PlainMesh&, MeshBounds) { return nullptr; }
}  // namespace ugoki::benchmarks

#endif
