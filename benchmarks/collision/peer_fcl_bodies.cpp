// FCL's managers of dynamic trees of boxes, with FCL's own distances.

#include "bodies.h"

#ifdef UGOKI_HAVE_FCL
#include <fcl/broadphase/broadphase_dynamic_AABB_tree.h>
#include <fcl/broadphase/default_broadphase_callbacks.h>
#include <fcl/fcl.h>

namespace ugoki::benchmarks {
namespace {

std::shared_ptr<fcl::CollisionGeometryd> geometry(const PlainBody& b, double margin) {
  if (b.vertices.empty()) return std::make_shared<fcl::Capsuled>(b.radius + 0.5 * margin, 2 * b.half_length);
  auto points = std::make_shared<std::vector<fcl::Vector3d>>();
  for (std::size_t i = 0; i + 2 < b.vertices.size(); i += 3) points->push_back({b.vertices[i], b.vertices[i + 1], b.vertices[i + 2]});
  auto faces = std::make_shared<std::vector<int>>();
  for (const auto& face : b.faces) {
    faces->push_back(static_cast<int>(face.size()));
    faces->insert(faces->end(), face.begin(), face.end());
  }
  return std::make_shared<fcl::Convexd>(points, static_cast<int>(b.faces.size()), faces);
}

class Fcl final : public BodiesPeer {
 public:
  Fcl(const PlainMotion& motion, double margin) : motion_(motion), margin_(margin) {
    for (const PlainBody& b : motion.bodies) objects_.push_back(std::make_unique<fcl::CollisionObjectd>(geometry(b, margin)));
    move(0);
    for (std::size_t i = 0; i < objects_.size(); ++i) {
      objects_[i]->setUserData(reinterpret_cast<void*>(i));
      all_.registerObject(objects_[i].get());
      (static_cast<int>(i) < motion.first_of_b ? a_ : b_).registerObject(objects_[i].get());
    }
    a_.setup();
    b_.setup();
    all_.setup();
    data_.request.enable_nearest_points = true;
    data_.request.gjk_solver_type = fcl::GST_LIBCCD;
    data_.request.distance_tolerance = 1e-8;
  }
  std::string name() const override { return "FCL dynamic AABB tree"; }
  double nearest(int step) override {
    move(step);
    a_.update();
    b_.update();
    data_.result.clear();
    data_.done = false;
    a_.distance(&b_, &data_, fcl::DefaultDistanceFunction<double>);
    return data_.result.min_distance;
  }
  int count_within(int step, double, PlainDistance distance, void* context) override {
    move(step);
    all_.update();
    Count count{distance, context, margin_, 0};
    all_.collide(&count, [](fcl::CollisionObjectd* x, fcl::CollisionObjectd* y, void* data) {
      Count& c = *static_cast<Count*>(data);
      const auto i = static_cast<int>(reinterpret_cast<std::size_t>(x->getUserData()));
      const auto j = static_cast<int>(reinterpret_cast<std::size_t>(y->getUserData()));
      if (c.distance(c.context, i, j) <= c.margin) ++c.found;
      return false;
    });
    return count.found;
  }

 private:
  struct Count {
    PlainDistance distance;
    void* context;
    double margin;
    int found;
  };
  void move(int step) {
    for (std::size_t i = 0; i < objects_.size(); ++i) {
      const std::size_t at = static_cast<std::size_t>(step) * objects_.size() + i;
      const double* R = motion_.rotations.data() + 9 * at;
      const double* p = motion_.translations.data() + 3 * at;
      fcl::Transform3d X = fcl::Transform3d::Identity();
      X.linear() << R[0], R[1], R[2], R[3], R[4], R[5], R[6], R[7], R[8];
      X.translation() << p[0], p[1], p[2];
      objects_[i]->setTransform(X);
      objects_[i]->computeAABB();
    }
  }
  const PlainMotion& motion_;
  double margin_;
  std::vector<std::unique_ptr<fcl::CollisionObjectd>> objects_;
  fcl::DynamicAABBTreeCollisionManagerd a_, b_, all_;
  fcl::DefaultDistanceData<double> data_;
};

}  // namespace

std::unique_ptr<BodiesPeer> make_fcl_bodies(const PlainMotion& motion, double margin) { return std::make_unique<Fcl>(motion, margin); }

}  // namespace ugoki::benchmarks
#else
namespace ugoki::benchmarks {
std::unique_ptr<BodiesPeer> make_fcl_bodies(const PlainMotion&, double) { return nullptr; }
}  // namespace ugoki::benchmarks
#endif
