// Drags with dynamics: closed forms of a free body, pins, limits, the floor, and requests that continue a drag.

#include "ugoki/studio/body_drag.h"

#include <gtest/gtest.h>

#include <cmath>

#include "studio_fixture.h"
#include "ugoki/mechanism/state.h"
#include "ugoki/samples/samples.h"

namespace ugoki::studio {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

std::vector<Pose> poses_of(const Mechanism& m, std::span<const double> q) {
  std::vector<Pose> X(at(m.link_count()));
  calc_poses(m, q, X);
  return X;
}
double lowest_of(const Mechanism& m, std::span<const double> q, bool collides = true) {
  double low = 1e9;
  const std::vector<Pose> X = poses_of(m, q);
  for (int i = 0; i < m.link_count(); ++i)
    for (const Shape& s : m.link(i).shapes) {
      const Pose X_WS = X[at(i)] * s.X_BS;
      if (s.collides == collides) low = std::min(low, X_WS.p.z - reach(s, -X_WS.R.row(2)));
    }
  return low;
}
int labelled(const Mechanism& m, std::string_view label) {
  for (int i = 0; i < m.link_count(); ++i)
    if (m.link(i).label == label) return i;
  ADD_FAILURE() << label;
  return 0;
}

/// A target far away: the pull has its maximum F = 3 m g, so that m x'' = F - m c x' and x = F / (m c) (t - (1 - exp(-c t)) / c).
TEST(BodyDrag, FreeBodyMovesAsTheClosedForm) {
  MechanismSpec spec;
  LinkSpec ball;
  ball.name = "ball";
  ball.joint.type = JointType::floating;
  ball.inertia = Inertia::from_centre(2, {}, {0.02, 0.02, 0.02, 0, 0, 0});
  ball.shapes.push_back(Shape::sphere(0.1));
  spec.links = {ball};
  const MechanismPtr m = Mechanism::make(spec).value();
  std::vector<double> q = m->neutral();
  q[2] = 50;
  BodyDrag drag(m, q, {});
  ASSERT_TRUE(drag.advance({1e5, 0, 50}, 1.0 + 1e-9));
  const double c = BodyDragOptions::root_damping, a = BodyDragOptions::pull.max_weights * 9.81;
  EXPECT_NEAR(drag.q()[0], a / c * (1 - (1 - std::exp(-c)) / c), 0.1);
  EXPECT_NEAR(drag.q()[2], 50, 1e-6) << "gravity does not act";
}

class DragOfAPerson : public ::testing::Test {
 protected:
  void SetUp() override {
    q = person->neutral();
    q[2] -= lowest_of(*person, q);
    hand = labelled(*person, "hand right");
    pins = {labelled(*person, "foot left"), labelled(*person, "foot right")};
    X0 = poses_of(*person, q);
  }
  BodyDrag drag(std::vector<int> with) const { return BodyDrag(person, q, {hand, {}, std::move(with), 0}); }
  void check_limits(std::span<const double> now) const {
    for (int i = 0; i < person->link_count(); ++i) {
      const Link& link = person->link(i);
      if (link.joint.type == JointType::floating) continue;
      double x[6];
      joint_displacement(link.joint, now.data() + link.q_index, x);
      for (int k = 0; k < link.joint.nv(); ++k) {
        EXPECT_GT(x[k], link.joint.dofs[at(k)].lower - 0.03) << link.name;
        EXPECT_LT(x[k], link.joint.dofs[at(k)].upper + 0.03) << link.name;
      }
    }
  }

  const MechanismPtr person = samples::make_person(1.7).value();
  std::vector<double> q;
  std::vector<Pose> X0;
  int hand = 0;
  std::vector<int> pins;
};

TEST_F(DragOfAPerson, PinsHoldAndTheTrunkFollowsTheHand) {
  BodyDrag body = drag(pins);
  const Vec3 target = X0[at(hand)].p + Vec3{0.55, 0, -0.25};
  ASSERT_TRUE(body.advance(target, 3));
  const std::vector<Pose> X = poses_of(*person, body.q());
  EXPECT_LT(norm(X[at(hand)].p - target), 0.04);
  for (const int pin : pins) {
    EXPECT_LT(norm(X[at(pin)].p - X0[at(pin)].p), 1e-3);
    EXPECT_GT(dot(X[at(pin)].R.column(2), X0[at(pin)].R.column(2)), 1 - 1e-4);
  }
  EXPECT_GT(norm(X[at(labelled(*person, "chest"))].p - X0[at(labelled(*person, "chest"))].p), 0.01) << "the body follows";
  check_limits(body.q());
  double speed = 0;
  for (const double v : body.v()) speed = std::max(speed, std::fabs(v));
  EXPECT_LT(speed, 0.2) << "it comes to rest while the hand rests";
}

TEST_F(DragOfAPerson, WithoutPinsTheWholeBodyFollows) {
  BodyDrag body = drag({});
  const Vec3 target = X0[at(hand)].p + Vec3{1, 0, 0.4};
  ASSERT_TRUE(body.advance(target, 4));
  EXPECT_LT(norm(poses_of(*person, body.q())[at(hand)].p - target), 0.04);
  EXPECT_GT(body.q()[0] - q[0], 0.4);
  check_limits(body.q());
}

TEST_F(DragOfAPerson, TheFloorStopsTheHand) {
  BodyDrag body = drag(pins);
  ASSERT_TRUE(body.advance(X0[at(hand)].p + Vec3{0.4, 0, -2}, 3));
  EXPECT_GT(lowest_of(*person, body.q()), -0.01);
}

TEST_F(DragOfAPerson, ResultDoesNotDependOnHowTheTimeIsSplit) {
  BodyDrag one = drag(pins), two = drag(pins);
  const Vec3 target = X0[at(hand)].p + Vec3{0.3, 0.2, 0.2};
  const double dt = BodyDragOptions::step;
  ASSERT_TRUE(one.advance(target, 100.5 * dt));
  for (const double steps : {10.25, 0.0, 40.5, 49.75}) ASSERT_TRUE(two.advance(target, steps * dt));
  EXPECT_TRUE(std::ranges::equal(one.q(), two.q()));
  // a hand that stays where it is moves nothing
  BodyDrag still = drag(pins);
  ASSERT_TRUE(still.advance(X0[at(hand)].p, 1));
  EXPECT_LT(norm(poses_of(*person, still.q())[at(hand)].p - X0[at(hand)].p), 0.01);
}

using DragRequests = test::StudioTest;

TEST_F(DragRequests, ContinueADragAndAreRefusedWithARemedy) {
  test::Page p = page();
  const auto drag = [](const std::string& id, double seconds, double x = 0.3) {
    return nlohmann::json{{"op", "pose"},
                          {"character", "human"},
                          {"clip", "k1"},
                          {"time", 0.5},
                          {"edit",
                           {{"type", "reach"},
                            {"link", 0},
                            {"point", {0, 0, 0}},
                            {"target", {x, 0, 1}},
                            {"moves", "physics"},
                            {"drag", id},
                            {"seconds", seconds}}}};
  };
  const auto x_of = [](const nlohmann::json& reply) { return reply["links"][0].get<double>(); };
  const nlohmann::json first = p.ask(drag("a", 0));
  ASSERT_TRUE(first["ok"]) << first;
  const double start = x_of(first);
  const double after = x_of(p.ask(drag("a", 0.1, start + 0.5)));
  EXPECT_GT(after, start + 1e-3);
  EXPECT_GT(x_of(p.ask(drag("a", 0.1, start + 0.5))), after + 1e-3) << "the drag goes on";
  EXPECT_NEAR(x_of(p.ask(drag("b", 0, start + 0.5))), start, 1e-6) << "another drag begins at the pose of the document";
  for (const nlohmann::json& wrong : {drag("", 0.1), drag("a", 1), drag("a", -1), drag(std::string(60, 'a'), 0.1)}) {
    const nlohmann::json reply = p.ask(wrong);
    ASSERT_FALSE(reply["ok"]) << wrong;
    EXPECT_FALSE(reply["error"]["problems"][0]["remedy"].get<std::string>().empty());
  }
}

}  // namespace
}  // namespace ugoki::studio
