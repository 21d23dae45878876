// Balance control of small characters and of characters on more than two feet.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "balance_scene.h"
#include "ugoki/control/leg_posture.h"

namespace ugoki::control {
namespace {

// The critically damped vertical error of a body of length L follows exp(-w t). Similar bodies under the same gravity move alike in times
// that are proportional to sqrt(L), so w sqrt(L / g) is the same for all.
TEST(BalanceOptions, FrequenciesOfSimilarSmallBodiesFollowFroude) {
  const BalanceOptions person = sized_for({}, 0.95, 2), child = sized_for({}, 0.4, 2), toy = sized_for({}, 0.1, 2);
  EXPECT_EQ(person.height_frequency, BalanceOptions{}.height_frequency);
  EXPECT_EQ(person.pelvis_weight, BalanceOptions{}.pelvis_weight);
  EXPECT_NEAR(child.joint_frequency * std::sqrt(0.4), toy.joint_frequency * std::sqrt(0.1), 1e-9);
  EXPECT_NEAR(child.joint_frequency * std::sqrt(0.4), person.joint_frequency * std::sqrt(0.8), 1e-9);
  // A trunk of radius of inertia r has the cost weight (alpha r)^2 if the weight is proportional to r^2.
  EXPECT_NEAR(child.pelvis_weight / (0.4 * 0.4), toy.pelvis_weight / (0.1 * 0.1), 1e-9);
  EXPECT_EQ(child.leg_weight, BalanceOptions{}.leg_weight);
  EXPECT_LT(sized_for({}, 0.95, 4).leg_weight, BalanceOptions{}.leg_weight);
}

/// The standing dog of the samples, in the posture of its reference except for a roll of one fore leg about its shoulder.
struct RolledPaw {
  MechanismPtr m = samples::make_dog();
  BalanceModel model{m, std::make_shared<const Looped>(m, samples::make_dog_stand(*m), 5), {}, 0};
  GroundSupport support{model};
  BalanceState state;

  /// @param roll, pitch rad: of the paw @param side m: where the pressure has to be, from the centre of mass
  /// @return number of points that are pressed down
  std::size_t pressed(double roll, double pitch, const Vec3& side) {
    for (std::size_t f = 0; f < model.feet.size(); ++f) state.feet[f].stands = 1;
    state.started = 1;
    state.time = state.clock = 1;
    model.sample_reference(state);
    std::vector<double> q = model.q_ref, v(model.v_ref.size());
    v[static_cast<std::size_t>(m->link(m->find_link("LeftUpperArm")).v_index)] = roll;
    v[static_cast<std::size_t>(m->link(m->find_link("LeftForePaw")).v_index)] = pitch;
    integrate(*m, q, v, 1, q);
    // The lowest point of the paw touches the ground.
    const auto foot =
        static_cast<std::size_t>(std::ranges::find(model.feet, m->find_link("LeftForePaw"), &Foot::link) - model.feet.begin());
    dynamics::update_kinematics(*m, q, model.v_ref, model.now);
    double lowest = 1e9;
    for (const LinkPoint& p : model.feet[foot].points) lowest = std::min(lowest, bottom(p).z);
    displace_root(*m, {0, 0, -lowest, 0}, q);
    dynamics::update_kinematics(*m, q, model.v_ref, model.now);
    model.centroid = dynamics::calc_centroidal(*m, model.now);
    std::vector<collision::ContactPoint> contacts;
    for (const LinkPoint& p : model.feet[foot].points) {
      if (bottom(p).z > 5e-4) continue;
      collision::ContactPoint touch;
      touch.system_a = 0;
      touch.link_a = p.link;
      touch.p = bottom(p);
      touch.n = {0, 0, 1};
      touch.friction = 0.9;
      contacts.push_back(touch);
    }
    support.collect(model, {q, model.v_ref, contacts, 0, 0.002});
    support.find_bearing(model, state, model.centroid.centre + side);
    return static_cast<std::size_t>(
        std::ranges::count_if(support.hovering(), [&](const HoveringPoint& h) { return h.foot == static_cast<int>(foot); }));
  }

 private:
  [[nodiscard]] Vec3 bottom(const LinkPoint& p) const {
    return model.now.X_WB[static_cast<std::size_t>(p.link)] * p.location.p - Vec3{0, 0, p.location.radius};
  }
};

// A paw has a joint for its pitch only. Pressing down its left edge would need the whole body, and braked a dog to 60 % of its speed.
TEST(GroundSupport, PawsArePressedDownAboutTheirOwnJointOnly) {
  RolledPaw paw;
  const Vec3 ahead{2, 0, 0}, left{0, 2, 0};
  EXPECT_EQ(paw.pressed(0, 0, ahead), 0u);
  for (const double roll : {-0.15, 0.15}) {
    EXPECT_EQ(paw.pressed(roll, 0, left), 0u) << "rolled by the leg";
    EXPECT_EQ(paw.pressed(roll, 0, -left), 0u) << "rolled by the leg";
  }
  EXPECT_GT(paw.pressed(0, -0.1, ahead), 0u) << "pitched by its own joint";
}

TEST(LegPosture, LegsOfADogReachThePlacesOfAllFeet) {
  const MechanismPtr dog = samples::make_dog();
  BalanceModel model(dog, std::make_shared<const Looped>(dog, samples::make_dog_trot(*dog), 5), {}, 0);
  BalanceState state;
  state.started = 1;
  state.time = 1;
  for (std::size_t f = 0; f < model.feet.size(); ++f) state.feet[f].stands = model.schedule.at(f, 1).stands;
  model.sample_reference(state);
  // The real body is 3 cm behind its reference, and so are its standing feet. Feet in swing shall land 4 cm to the left.
  std::vector<double> q = model.q_ref;
  displace_root(*dog, {-0.03, 0, 0, 0}, q);
  dynamics::update_kinematics(*dog, q, model.v_ref, model.now);
  for (std::size_t f = 0; f < model.feet.size(); ++f) state.feet[f].shift[1] = 0.04;
  LegPosture legs(model);
  legs.update(model, state);
  std::vector<Pose> X(static_cast<std::size_t>(dog->link_count()));
  calc_poses(*dog, legs.positions(), X);
  int standing = 0;
  for (std::size_t f = 0; f < model.feet.size(); ++f) {
    const Vec3 moved = X[static_cast<std::size_t>(model.feet[f].link)] * model.feet[f].sole - model.reference_sole(f);
    const ScheduledFoot planned = model.schedule.at(f, 1);
    const Vec3 wanted = state.feet[f].stands ? Vec3{-0.03, 0, 0}
                                             : Vec3{0, 0.04, 0} * smooth_step((1 - planned.begin) / (planned.end - planned.begin)).value;
    EXPECT_LT(norm(moved - wanted), 0.003) << f;
    standing += state.feet[f].stands ? 1 : 0;
  }
  EXPECT_GT(standing, 0);
  EXPECT_LT(standing, 4);
}

}  // namespace
}  // namespace ugoki::control
