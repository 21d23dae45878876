// PQP with a warm start from the closest triangles of the previous query.

#include "meshes.h"

#ifdef UGOKI_HAVE_PQP
#include <PQP.h>

namespace ugoki::benchmarks {
namespace {

class Pqp final : public MeshPeer {
 public:
  Pqp(const PlainMesh& a, const PlainMesh& b) {
    fill(a_, a);
    fill(b_, b);
  }
  std::string name() const override { return "PQP warm"; }
  double distance(const PlainPose& X) override {
    PQP_REAL one[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, none[3] = {0, 0, 0}, R[3][3], p[3];
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) R[i][j] = static_cast<PQP_REAL>(X.R[3 * i + j]);
      p[i] = static_cast<PQP_REAL>(X.p[i]);
    }
    PQP_DistanceResult result;
    PQP_Distance(&result, one, none, &a_, R, p, &b_, 0.0, 0.0);
    return result.Distance();
  }

 private:
  static void fill(PQP_Model& out, const PlainMesh& m) {
    out.BeginModel(static_cast<int>(m.triangles.size() / 3));
    for (std::size_t i = 0; i + 2 < m.triangles.size(); i += 3) {
      PQP_REAL p[3][3];
      for (std::size_t k = 0; k < 3; ++k)
        for (std::size_t c = 0; c < 3; ++c)
          p[k][c] = static_cast<PQP_REAL>(m.vertices[3 * static_cast<std::size_t>(m.triangles[i + k]) + c]);
      out.AddTri(p[0], p[1], p[2], static_cast<int>(i / 3));
    }
    out.EndModel();
  }
  PQP_Model a_, b_;
};

}  // namespace

std::unique_ptr<MeshPeer> make_pqp_meshes(const PlainMesh& a, const PlainMesh& b) { return std::make_unique<Pqp>(a, b); }

}  // namespace ugoki::benchmarks

#else

namespace ugoki::benchmarks {
std::unique_ptr<MeshPeer> make_pqp_meshes(const PlainMesh&, const PlainMesh&) { return nullptr; }
}  // namespace ugoki::benchmarks

#endif
