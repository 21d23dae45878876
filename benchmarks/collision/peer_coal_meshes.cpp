// Coal's bounding-volume hierarchies.

#include "meshes.h"

#ifdef UGOKI_HAVE_COAL
#include <coal/BVH/BVH_model.h>
#include <coal/distance.h>

namespace ugoki::benchmarks {
namespace {

template <class Bound>
class Coal final : public MeshPeer {
 public:
  Coal(const PlainMesh& a, const PlainMesh& b, std::string name) : name_(std::move(name)) {
    fill(a_, a);
    fill(b_, b);
  }
  std::string name() const override { return name_; }
  double distance(const PlainPose& X) override {
    coal::Matrix3s R;
    R << X.R[0], X.R[1], X.R[2], X.R[3], X.R[4], X.R[5], X.R[6], X.R[7], X.R[8];
    const coal::Transform3s pose(R, coal::Vec3s(X.p[0], X.p[1], X.p[2]));
    const coal::DistanceRequest request;
    coal::DistanceResult result;
    return coal::distance(&a_, coal::Transform3s(), &b_, pose, request, result);
  }

 private:
  static void fill(coal::BVHModel<Bound>& out, const PlainMesh& m) {
    std::vector<coal::Vec3s> vertices;
    for (std::size_t i = 0; i + 2 < m.vertices.size(); i += 3) vertices.emplace_back(m.vertices[i], m.vertices[i + 1], m.vertices[i + 2]);
    std::vector<coal::Triangle> triangles;
    for (std::size_t i = 0; i + 2 < m.triangles.size(); i += 3)
      triangles.emplace_back(static_cast<unsigned>(m.triangles[i]), static_cast<unsigned>(m.triangles[i + 1]),
                             static_cast<unsigned>(m.triangles[i + 2]));
    out.beginModel();
    out.addSubModel(vertices, triangles);
    out.endModel();
  }
  coal::BVHModel<Bound> a_, b_;
  std::string name_;
};

}  // namespace

std::unique_ptr<MeshPeer> make_coal_meshes(const PlainMesh& a, const PlainMesh& b, MeshBounds bounds) {
  if (bounds == MeshBounds::rss) return std::make_unique<Coal<coal::RSS>>(a, b, "Coal RSS");
  return std::make_unique<Coal<coal::OBBRSS>>(a, b, "Coal OBBRSS");
}

}  // namespace ugoki::benchmarks

#else

namespace ugoki::benchmarks {
std::unique_ptr<MeshPeer> make_coal_meshes(const PlainMesh&, const PlainMesh&, MeshBounds) { return nullptr; }
}  // namespace ugoki::benchmarks

#endif
