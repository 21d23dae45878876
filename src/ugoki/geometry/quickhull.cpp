#include "ugoki/geometry/quickhull.h"

#include <cstdio>
#include <memory>

extern "C" {
#include <libqhull_r/qhull_ra.h>
}

namespace ugoki::geometry {
namespace {

/// One run of Qhull. The destructor frees all its memory.
class Run {
 public:
  Run() : silent_(std::fopen("/dev/null", "w")) { qh_zero(&qh_, silent_); }
  ~Run() {
    qh_freeqhull(&qh_, qh_ALL);
    int held = 0, total = 0;
    qh_memfreeshort(&qh_, &held, &total);
    if (silent_ != nullptr) std::fclose(silent_);
  }
  Run(const Run&) = delete;
  Run& operator=(const Run&) = delete;

  bool run(std::vector<double>& coordinates, const std::string& command) {
    std::string text = command;
    return silent_ != nullptr &&
           qh_new_qhull(&qh_, 3, static_cast<int>(coordinates.size() / 3), coordinates.data(), False, text.data(), nullptr, silent_) == 0;
  }
  qhT* get() { return &qh_; }

 private:
  qhT qh_{};
  std::FILE* silent_;
};

}  // namespace

std::optional<PolygonHull> quickhull(std::span<const Vec3> points, std::size_t max_vertices, bool triangles) {
  std::vector<double> coordinates;
  coordinates.reserve(3 * points.size());
  for (const Vec3& p : points) coordinates.insert(coordinates.end(), {p.x, p.y, p.z});
  Run run;
  if (!run.run(coordinates, "qhull TA" + std::to_string(max_vertices + 1) + (triangles ? " Qt" : ""))) return std::nullopt;
  qhT* qh = run.get();
  PolygonHull out;
  if (static_cast<std::size_t>(qh->num_vertices) > max_vertices) {
    out.too_many = true;
    return out;
  }
  out.first_corner.push_back(0);
  facetT* facet;
  for (facet = qh->facet_list; facet != nullptr && facet->next != nullptr; facet = facet->next) {
    setT* ring = qh_facet3vertex(qh, facet);
    const int size = qh_setsize(qh, ring);
    for (int k = 0; k < size; ++k) {
      const auto* vertex = static_cast<const vertexT*>(ring->e[k].p);
      out.corners.push_back(qh_pointid(qh, vertex->point));
    }
    qh_settempfree(qh, &ring);
    out.first_corner.push_back(static_cast<std::int32_t>(out.corners.size()));
  }
  return out;
}

}  // namespace ugoki::geometry
