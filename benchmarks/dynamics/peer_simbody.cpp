// Compiled as C++14, because Simbody 3.7's headers do not compile with newer standards.

#include "plain_tree.h"

#ifdef UGOKI_HAVE_SIMBODY
#include <Simbody.h>

namespace ugoki {
namespace benchmarks {
namespace {

SimTK::Vec3 vector(const double* x) { return {x[0], x[1], x[2]}; }

class Simbody final : public Peer {
 public:
  explicit Simbody(const PlainTree& tree)
      : matter_(system_), forces_(system_), gravity_(forces_, matter_, {0, 0, 1}, -tree.gravity), torques_(forces_, matter_) {
    gravity_.setDefaultDownDirection(SimTK::UnitVec3(0, 0, -1));
    std::vector<SimTK::MobilizedBody> bodies;
    for (const PlainLink& l : tree.links) {
      const SimTK::Vec3 c = vector(l.centre);
      const SimTK::Inertia about_origin = SimTK::Inertia(l.inertia[0], l.inertia[1], l.inertia[2]).shiftFromMassCenter(-c, l.mass);
      const SimTK::Body::Rigid body(SimTK::MassProperties(l.mass, c, about_origin));
      SimTK::MobilizedBody& parent =
          l.parent < 0 ? static_cast<SimTK::MobilizedBody&>(matter_.Ground()) : bodies[static_cast<std::size_t>(l.parent)];
      if (l.floating) {
        bodies.push_back(SimTK::MobilizedBody::Free(parent, body));
      } else {
        const SimTK::Rotation turned(SimTK::UnitVec3(vector(l.axis)), SimTK::ZAxis);
        bodies.push_back(SimTK::MobilizedBody::Pin(parent, SimTK::Transform(turned, vector(l.p)), body, SimTK::Transform(turned)));
      }
    }
    for (const PlainLoop& l : tree.loops) {
      SimTK::MobilizedBody& a = l.a < 0 ? static_cast<SimTK::MobilizedBody&>(matter_.Ground()) : bodies[static_cast<std::size_t>(l.a)];
      SimTK::MobilizedBody& b = bodies[static_cast<std::size_t>(l.b)];
      const double* q = l.rotation;
      if (l.weld)
        SimTK::Constraint::Weld(a, SimTK::Transform(SimTK::Rotation(SimTK::Quaternion(q[0], q[1], q[2], q[3])), vector(l.p)), b,
                                SimTK::Transform());
      else
        SimTK::Constraint::Ball(a, vector(l.p), b, vector(l.inverse_p));
    }
    system_.realizeTopology();
    state_ = system_.getDefaultState();
    system_.realizeModel(state_);
    std::size_t q = 0, v = 0;
    SimTK::Vector mobility(matter_.getNumMobilities(), 0.0);
    for (std::size_t i = 0; i < bodies.size(); ++i) {
      const SimTK::MobilizedBody& body = bodies[i];
      if (tree.links[i].floating) {
        const double* x = tree.q.data() + q;
        const SimTK::Rotation R(SimTK::Quaternion(x[3], x[4], x[5], x[6]));
        body.setQToFitTransform(state_, SimTK::Transform(R, vector(x)));
        body.setUToFitVelocity(state_, SimTK::SpatialVec(R * vector(tree.v.data() + v), vector(tree.v.data() + v + 3)));
        q += 7;
        v += 6;
      } else {
        body.setOneQ(state_, 0, tree.q[q++]);
        body.setOneU(state_, 0, tree.v[v]);
        const int u = static_cast<int>(body.getFirstUIndex(state_));
        mobility[u] = tree.tau[v++];
        joints_.push_back(u);
      }
    }
    torques_.setAllMobilityForces(state_, mobility);
    known_ = mobility;
  }
  std::string name() const override { return "Simbody 3.7"; }
  bool forward() override {
    state_.invalidateAllCacheAtOrAbove(SimTK::Stage::Position);
    system_.realize(state_, SimTK::Stage::Acceleration);
    known_ = state_.getUDot();
    return true;
  }
  bool inverse() override {
    state_.invalidateAllCacheAtOrAbove(SimTK::Stage::Position);
    system_.realize(state_, SimTK::Stage::Dynamics);
    const SimTK::Vector_<SimTK::SpatialVec>& weights = gravity_.getBodyForces(state_);
    matter_.calcResidualForceIgnoringConstraints(state_, SimTK::Vector(), weights, known_, residual_);
    return true;
  }
  std::vector<double> joint_accelerations() override { return of(state_.getUDot()); }
  std::vector<double> joint_torques() override { return of(residual_); }

 private:
  std::vector<double> of(const SimTK::Vector& x) const {
    std::vector<double> out;
    for (const int u : joints_) out.push_back(x[u]);
    return out;
  }
  SimTK::MultibodySystem system_;
  SimTK::SimbodyMatterSubsystem matter_;
  SimTK::GeneralForceSubsystem forces_;
  SimTK::Force::Gravity gravity_;
  SimTK::Force::DiscreteForces torques_;
  SimTK::State state_;
  SimTK::Vector known_, residual_;
  std::vector<int> joints_;
};

}  // namespace

std::unique_ptr<Peer> make_simbody(const PlainTree& tree) { return std::unique_ptr<Peer>(new Simbody(tree)); }

}  // namespace benchmarks
}  // namespace ugoki
#else
namespace ugoki {
namespace benchmarks {
std::unique_ptr<Peer> make_simbody(const PlainTree&) { return nullptr; }
}  // namespace benchmarks
}  // namespace ugoki
#endif
