// Contact between bodies, through `ugoki run`: stacks, slopes, heavy bodies on light ones, heaps, a ball and a plate.

#include <cmath>
#include <cstring>
#include <filesystem>
#include <random>

#include "cli_fixture.h"
#include "ugoki/collision/scene.h"
#include "ugoki/files/files.h"
#include "ugoki/geometry/prepare.h"
#include "ugoki/mechanism/shape.h"
#include "ugoki/project/project.h"

namespace ugoki::cli {
namespace {

/// One body of the scenario.
struct Body {
  Shape shape;
  double density = 500;  // kg/m^3
  Vec3 location;         // m
  double heading = 0;    // degrees, rotation about the vertical
  bool fixed = false;
};

class ContactCli : public CliTest {
 protected:
  content::Scenario scenario_;
  content::Resources resources_;
  std::vector<MechanismPtr> bodies_;

  void add(const Body& b) {
    MechanismSpec spec;
    const std::string id = "body" + std::to_string(bodies_.size());
    spec.name = id;
    LinkSpec l;
    l.name = "link";
    l.joint.type = b.fixed ? JointType::fixed : JointType::floating;
    if (b.fixed) l.joint.X_PJ.p = b.location;
    l.inertia = solid_inertia(b.shape, b.density);
    l.shapes.push_back(b.shape);
    spec.links.push_back(l);
    bodies_.push_back(Mechanism::make(std::move(spec)).value());
    resources_.mechanisms["m-" + id] = bodies_.back();
    content::ScenarioCharacter c;
    c.id = c.name = id;
    c.mechanism = "m-" + id;
    c.control.mode = content::ControlMode::passive;
    if (!b.fixed) c.place = {b.location.x, b.location.y, b.location.z, b.heading};
    scenario_.characters.push_back(c);
  }

  /// Runs the scenario and reads the poses of the bodies in every display frame.
  std::vector<std::vector<Pose>> run(double seconds) {
    scenario_.duration = seconds;
    const std::string project = path("bodies.ugoki"), frames = path("frames");
    const auto made = project::Project::create(project, scenario_, resources_);
    EXPECT_TRUE(made) << made.error().text();
    (void)json({"run", project, "--frames", frames, "--json"});
    return read_frames(read(frames));
  }

  static std::vector<std::vector<Pose>> read_frames(const std::string& bytes) {
    std::vector<std::vector<Pose>> out;
    std::size_t at = 0;
    const auto take = [&]<class T>(T value) {
      std::memcpy(&value, bytes.data() + at, sizeof value);
      at += sizeof value;
      return value;
    };
    const auto number = [&] { return static_cast<double>(take(0.0F)); };
    while (at < bytes.size()) {
      at += 24;  // skip magic, version, time, number, flags
      const auto characters = take(std::uint32_t{}), contacts = take(std::uint32_t{});
      at += 32;  // skip grab point and target, number of closest pairs, flag of normals
      std::vector<Pose>& poses = out.emplace_back();
      for (std::uint32_t c = 0; c < characters; ++c) {
        const auto links = take(std::uint32_t{});
        at += 52;
        for (std::uint32_t l = 0; l < links; ++l) {
          Pose X;
          for (int k = 0; k < 3; ++k) X.p[k] = number();
          Quat r;
          r.w = number();
          r.x = number();
          r.y = number();
          r.z = number();
          X.R = to_matrix(normalized(r));
          poses.push_back(X);
        }
      }
      at += std::size_t{44} * contacts;
    }
    return out;
  }

  /// Maximum distance of a body from its position in the first frame, m.
  static double drift(const std::vector<std::vector<Pose>>& frames) {
    double maximum = 0;
    for (const auto& poses : frames)
      for (std::size_t i = 0; i < poses.size(); ++i) maximum = std::max(maximum, norm(poses[i].p - frames.front()[i].p));
    return maximum;
  }

  /// Maximum overlap between bodies or with the ground, over all frames, m.
  double depth(const std::vector<std::vector<Pose>>& frames) const {
    const collision::Scene scene(bodies_, {scenario_.ground.height, scenario_.ground.friction, scenario_.ground.restitution});
    collision::Workspace workspace(scene);
    std::vector<collision::ContactPoint> contacts;
    double maximum = 0;
    for (const auto& poses : frames) {
      std::vector<std::span<const Pose>> views;
      for (const Pose& X : poses) views.emplace_back(&X, 1);
      collision::find_contacts(scene, views, 0, workspace, contacts);
      for (const collision::ContactPoint& c : contacts) maximum = std::max(maximum, -c.distance);
    }
    return maximum;
  }

  void add_stack(std::span<const double> densities) {
    for (const double d : densities)
      add({Shape::box({0.1, 0.1, 0.1}),
           d,
           {0.01 * std::sin(3.0 * static_cast<double>(bodies_.size())), 0, 0.1 + 0.2 * static_cast<double>(bodies_.size())}});
  }

  /// Adds random bodies of six shapes with sizes of 0.1 to 0.5 m.
  void add_heap(int count, unsigned seed, double height) {
    std::mt19937_64 engine(seed);
    const auto uniform = [&](double low, double high) { return low + (high - low) * static_cast<double>(engine() >> 11) * 0x1p-53; };
    const int side = count < 100 ? 3 : 5;
    for (int i = 0; i < count; ++i) {
      const Vec3 e{uniform(0.05, 0.25), uniform(0.05, 0.25), uniform(0.05, 0.25)};
      std::vector<Vec3> points;
      for (int k = 0; k < 24; ++k) {
        const Vec3 d = normalized(Vec3{uniform(-1, 1), uniform(-1, 1), uniform(-1, 1)} + Vec3{0, 0, 1e-3});
        points.push_back({d.x * e.x, d.y * e.y, d.z * e.z});
      }
      const Shape shapes[] = {Shape::box(e),
                              Shape::sphere(e.x),
                              Shape::capsule(0.5 * e.x, {0, 0, -0.5 * e.y}, {0, 0, 0.5 * e.y}),
                              Shape::cylinder(e.x, e.y),
                              Shape::ellipsoid(e),
                              Shape::mesh(geometry::make_hull_geometry(points, "hull").value())};
      const int k = i % (side * side);
      add({shapes[i % 6],
           uniform(300, 1000),
           {0.9 * (k % side) + uniform(-0.01, 0.01), 0.9 * (k / side) + uniform(-0.01, 0.01), height + 0.45 + 0.9 * (i / (side * side))},
           uniform(-180, 180)});
    }
  }
};

TEST_F(ContactCli, StackOfTenBoxesIsStable) {
  add_stack(std::vector<double>(10, 500.0));
  EXPECT_LT(drift(run(5)), 1e-3);
}
TEST_F(ContactCli, BoxAThousandTimesHeavierRestsOnLightBox) {
  add_stack(std::vector{100.0, 1e5});
  EXPECT_LT(drift(run(5)), 1e-3);
}

TEST_F(ContactCli, BoxOnSlopeObeysCoulombFriction) {
  for (const double part : {0.99, 1.01, 1.5}) {
    constexpr double mu = 0.5;
    const double angle = std::atan(mu * part);
    scenario_ = {};
    bodies_.clear();
    scenario_.gravity = {9.81 * std::sin(angle), 0, -9.81 * std::cos(angle)};
    scenario_.ground.friction = mu;
    Shape box = Shape::box({0.2, 0.15, 0.05});
    box.friction = mu;
    add({box, 500, {0, 0, 0.05}});
    const auto frames = run(2);
    const double travel = frames.back()[0].p.x - frames.front()[0].p.x;
    const double expected = 0.5 * 9.81 * (std::sin(angle) - mu * std::cos(angle)) * 4;
    if (part < 1)
      EXPECT_LT(drift(frames), 1e-5);
    else
      EXPECT_NEAR(travel, expected, 0.01 * expected) << part;
    std::filesystem::remove(path("bodies.ugoki"));
  }
}

TEST_F(ContactCli, HeapHasNoDeepOverlap) {
  add_heap(30, 1, 0.5);
  const auto frames = run(2.5);
  EXPECT_EQ(frames.size(), 151U);
  EXPECT_LT(depth(frames), 2e-3);
}
using Slow_ContactCli = ContactCli;
TEST_F(Slow_ContactCli, HeapOfTwoHundredHasNoDeepOverlap) {
  add_heap(200, 2, 1);
  const auto frames = run(6);
  EXPECT_LT(depth(frames), 2e-3);
}

TEST_F(Slow_ContactCli, StacksAreStableForAMinute) {
  add_stack(std::vector<double>(10, 500.0));
  EXPECT_LT(drift(run(60)), 1e-3);
  std::filesystem::remove(path("bodies.ugoki"));
  scenario_ = {};
  bodies_.clear();
  add_stack(std::vector{100.0, 1e5});
  EXPECT_LT(drift(run(60)), 1e-3);
}

TEST_F(ContactCli, FastBallDoesNotPassPlate) {
  for (const double step : {0.004, 0.002, 0.0005})
    for (const bool fixed : {true, false})
      for (const double aside : {0.0, 0.2}) {
        scenario_ = {};
        bodies_.clear();
        scenario_.step = step;
        scenario_.gravity = {0, 0, 0};
        Shape ball = Shape::sphere(0.02), plate = Shape::box({0.0025, 0.5, 0.5});
        add({ball, 8000, {-1.5, 0, 1}});
        add({plate, 7800, {0, aside, 1 + aside}, 0, fixed});
        content::ScenarioEvent shot;
        shot.id = "shot";
        shot.type = content::EventType::throw_;
        shot.character = "body0";
        shot.from = {-1.5, 0, 1};
        shot.velocity = {300, 0, 0};
        scenario_.events = {shot};
        const auto frames = run(0.1);
        double farthest = -10;
        for (const auto& poses : frames) {
          const Vec3 at = poses[1].inverse() * poses[0].p;
          if (std::max(std::fabs(at.y), std::fabs(at.z)) < 0.5) farthest = std::max(farthest, at.x);
        }
        EXPECT_LT(farthest, -0.02) << "step " << step << " fixed " << fixed << " aside " << aside;
        EXPECT_GT(frames.back()[0].p.x, -1.0) << "the ball should have reached the plate";
        std::filesystem::remove(path("bodies.ugoki"));
      }
}

}  // namespace
}  // namespace ugoki::cli
