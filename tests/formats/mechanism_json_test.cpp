// The JSON form of a mechanism: exact round trip, hand-written documents, errors with a JSON path.
#include "ugoki/formats/mechanism_json.h"

#include <gtest/gtest.h>

#include <cstring>
#include <random>

namespace ugoki::formats {
namespace {

bool same(const void* a, const void* b, std::size_t n) { return std::memcmp(a, b, n) == 0; }
bool same(const Pose& a, const Pose& b) { return same(&a, &b, sizeof a); }

/// A mechanism with links of every joint type, loops of every type, several shapes, and values without a short decimal form.
MechanismSpec rich() {
  std::mt19937_64 random(11);
  std::uniform_real_distribution<double> any(-2, 2), some(0.1, 2);
  const auto pose = [&] {
    return Pose{to_matrix(normalized(Quat{any(random), any(random), any(random), any(random)})), {any(random), any(random), any(random)}};
  };
  MechanismSpec spec;
  spec.name = "rich \"quoted\" \xE5\x8B\x95";
  for (int i = 0; i < 9; ++i) {
    LinkSpec l;
    l.name = "link " + std::to_string(i);
    l.parent = i == 0 ? "" : "link " + std::to_string((i - 1) / 2);
    l.label = i % 2 ? "left shank" : "";
    l.joint.type = static_cast<JointType>(i);
    l.joint.X_PJ = i == 3 ? Pose{} : pose();
    l.joint.axis = normalized(Vec3{any(random), any(random), any(random)});
    l.joint.axis2 = normalized(Vec3{any(random), any(random), any(random)});
    l.joint.pitch = any(random);
    for (int k = 0; k < l.joint.nv(); k += 1 + i % 2) {
      Dof& f = l.joint.dofs[static_cast<std::size_t>(k)];
      f = {-some(random), some(random), some(random), some(random), any(random), some(random), some(random), some(random)};
      if (k == 1) f.lower = -std::numeric_limits<double>::infinity();
    }
    l.inertia = Inertia::from_centre(some(random), {any(random), any(random), any(random)},
                                     {1 + 0.1 * any(random), 1.1, 0.9, 0.01 * any(random), 0, -0.0});
    l.shapes = {Shape::sphere(some(random), pose()), Shape::capsule(some(random), {any(random), 0, 0}, {0, any(random), 1}),
                Shape::box({some(random), some(random), some(random)})};
    l.shapes[1].collides = false;
    l.shapes[1].friction = some(random);
    l.shapes[2].visible = false;
    l.shapes[2].restitution = 0.3;
    l.shapes[0].groups = 0x80000002U;
    l.shapes[1].partners = i == 0 ? 0 : 6;
    l.shapes[2].smooth = true;
    spec.links.push_back(l);
  }
  LinkSpec hand;
  hand.name = "second body";
  hand.parent = "link 8";
  hand.joint.type = JointType::spherical;
  hand.real = "link 4";
  hand.X_RV = pose();
  spec.links.push_back(hand);
  for (int i = 0; i < 9; ++i) {
    LoopSpec l;
    l.name = "loop " + std::to_string(i);
    l.type = static_cast<LoopType>(i);
    l.link_a = i == 2 ? "" : "link 5";
    l.link_b = l.type == LoopType::gear ? "link 6" : "link 7";
    l.X_AJ = pose();
    l.X_BJ = pose();
    l.axis = normalized(Vec3{any(random), any(random), any(random)});
    l.axis2 = normalized(Vec3{any(random), any(random), any(random)});
    l.length = some(random);
    l.dof_a = l.type == LoopType::gear ? 2 : 0;
    l.dof_b = l.type == LoopType::gear ? 1 : 0;
    l.polynomial = {any(random), any(random), -0.0, 0, any(random)};
    l.closed = i % 2 == 0;
    spec.loops.push_back(l);
  }
  spec.exclusions = {{"link 7", "link 2"}, {"link 0", "link 5"}};
  return spec;
}

TEST(MechanismJson, RoundTripKeepsEveryBit) {
  const auto made = Mechanism::make(rich());
  ASSERT_TRUE(made.has_value()) << made.error().text();
  const std::string text = write_mechanism(**made);
  const auto back = read_mechanism(text, "rich.json");
  ASSERT_TRUE(back.has_value()) << back.error().text();
  const Mechanism &a = **made, &b = **back;
  EXPECT_EQ(a.name(), b.name());
  ASSERT_EQ(a.link_count(), b.link_count());
  ASSERT_EQ(a.loops().size(), b.loops().size());
  for (std::size_t i = 0; i < a.loops().size(); ++i) {
    const Loop &x = a.loops()[i], &y = b.loops()[i];
    SCOPED_TRACE(x.name);
    EXPECT_EQ(x.name, y.name);
    EXPECT_EQ(x.type, y.type);
    EXPECT_EQ(x.link_a, y.link_a);
    EXPECT_EQ(x.link_b, y.link_b);
    EXPECT_TRUE(same(x.X_AJ, y.X_AJ));
    EXPECT_TRUE(same(x.X_BJ, y.X_BJ));
    EXPECT_TRUE(same(&x.axis, &y.axis, sizeof x.axis));
    EXPECT_TRUE(same(&x.axis2, &y.axis2, sizeof x.axis2));
    EXPECT_TRUE(same(&x.length, &y.length, sizeof x.length));
    EXPECT_EQ(x.dof_a, y.dof_a);
    EXPECT_EQ(x.dof_b, y.dof_b);
    EXPECT_TRUE(same(&x.polynomial, &y.polynomial, sizeof x.polynomial));
    EXPECT_EQ(x.closed, y.closed);
    EXPECT_EQ(x.of_virtual_link, y.of_virtual_link);
  }
  for (int i = 0; i < a.link_count(); ++i) {
    const Link &x = a.link(i), &y = b.link(i);
    SCOPED_TRACE(x.name);
    EXPECT_EQ(x.name, y.name);
    EXPECT_EQ(x.label, y.label);
    EXPECT_EQ(x.parent, y.parent);
    EXPECT_EQ(x.real, y.real);
    EXPECT_TRUE(same(x.X_RV, y.X_RV));
    EXPECT_EQ(x.joint.type, y.joint.type);
    EXPECT_TRUE(same(x.joint.X_PJ, y.joint.X_PJ));
    EXPECT_TRUE(same(&x.joint.axis, &y.joint.axis, sizeof(Vec3)));
    EXPECT_TRUE(same(&x.joint.axis2, &y.joint.axis2, sizeof(Vec3)));
    EXPECT_EQ(x.joint.pitch, y.joint.pitch);
    for (int k = 0; k < x.joint.nv(); ++k) EXPECT_EQ(x.joint.dofs[static_cast<std::size_t>(k)], y.joint.dofs[static_cast<std::size_t>(k)]);
    EXPECT_EQ(x.inertia, y.inertia);
    ASSERT_EQ(x.shapes.size(), y.shapes.size());
    for (std::size_t k = 0; k < x.shapes.size(); ++k) {
      const Shape &s = x.shapes[k], &t = y.shapes[k];
      EXPECT_EQ(s.type, t.type);
      EXPECT_TRUE(same(s.X_BS, t.X_BS));
      EXPECT_EQ(s.radius, t.radius);
      EXPECT_EQ(s.half_length, t.half_length);
      EXPECT_EQ(s.half_extents, t.half_extents);
      EXPECT_EQ(s.friction, t.friction);
      EXPECT_EQ(s.restitution, t.restitution);
      EXPECT_EQ(s.collides, t.collides);
      EXPECT_EQ(s.visible, t.visible);
    }
  }
  EXPECT_EQ(write_mechanism(b), text) << "writing the mechanism that was read gives the same text";
}

TEST(MechanismJson, FormerFieldNamesAreRead) {
  std::string text = write_mechanism(**Mechanism::make(rich()));
  const std::string present = text;
  std::size_t renamed = 0;
  for (const auto& [now, former] : {std::pair<std::string, std::string>("\"dofs\":", "\"freedoms\":"), {"\"dof\":", "\"freedom\":"}})
    for (std::size_t at = text.find(now); at != std::string::npos; at = text.find(now, at + former.size()), ++renamed)
      text.replace(at, now.size(), former);
  ASSERT_GT(renamed, 4u);
  const auto back = read_mechanism(text, "old.json");
  ASSERT_TRUE(back.has_value()) << back.error().text();
  EXPECT_EQ(write_mechanism(**back), present);
}

TEST(MechanismJson, HandWrittenDocumentIsRead) {
  const auto m = read_mechanism(R"({
    "format": "ugoki-mechanism", "version": 1, "name": "pendulum",
    "links": [{"name": "rod",
               "joint": {"type": "revolute", "axis": [0, 1, 0], "position": [0, 0, 2], "rotation": [0, 0, 0, 2], "dofs": [{"damping": 0.1}]},
               "inertia": {"mass": 2, "centre": [0, 0, -0.5], "about_centre": [0.1, 0.1, 0.01, 0, 0, 0]},
               "shapes": [{"type": "capsule", "radius": 0.05, "half_length": 0.5, "position": [0, 0, -0.5]}]}]})",
                                "pendulum.json");
  ASSERT_TRUE(m.has_value()) << m.error().text();
  const Link& rod = (*m)->link(0);
  EXPECT_EQ(rod.joint.X_PJ.R, (Mat3{-1, 0, 0, 0, -1, 0, 0, 0, 1})) << "the quaternion is normalised";
  EXPECT_EQ(rod.inertia.h, (Vec3{0, 0, -1}));
  EXPECT_DOUBLE_EQ(rod.inertia.I.xx, 0.6);
  EXPECT_EQ(rod.joint.dofs[0].damping, 0.1);
  EXPECT_EQ(rod.joint.dofs[0].lower, -std::numeric_limits<double>::infinity());
  const std::string text = write_mechanism(**m);
  EXPECT_EQ(text.find("axis2"), std::string::npos) << "defaults are omitted: " << text;
  EXPECT_EQ(text.find("collides"), std::string::npos);
}

std::string document(const std::string& link) { return "{\"format\": \"ugoki-mechanism\",\n\"version\": 1,\n\"links\": [" + link + "]}"; }

TEST(MechanismJson, ErrorsHaveTheJsonPath) {
  const std::pair<std::string, std::string> cases[] = {
      {"[]", "a.json:/"},
      {"{}", "a.json:format"},
      {"{\"format\": 3}", "a.json:format"},
      {"{\"format\": \"ugoki-mechanism\", \"version\": 2, \"links\": []}", "a.json:version"},
      {"{\"format\": \"ugoki-mechanism\", \"version\": 1}", "a.json:links"},
      {"{\"format\": \"ugoki-mechanism\", \"version\": 1, \"links\": {}}", "a.json:links"},
      {document("3"), "a.json:links/0"},
      {document("{\"name\": 3}"), "a.json:links/0/name"},
      {document("{\"nmae\": \"x\"}"), "a.json:links/0/nmae"},
      {document("{\"name\": \"x\", \"joint\": []}"), "a.json:links/0/joint"},
      {document("{\"name\": \"x\", \"joint\": {}}"), "a.json:links/0/joint/type"},
      {document("{\"name\": \"x\", \"joint\": {\"type\": \"hinge\"}}"), "a.json:links/0/joint/type"},
      {document("{\"name\": \"x\", \"joint\": {\"type\": \"revolute\", \"axis\": [0, 1]}}"), "a.json:links/0/joint/axis"},
      {document("{\"name\": \"x\", \"joint\": {\"type\": \"revolute\", \"axis\": [0, 1, \"z\"]}}"), "a.json:links/0/joint/axis"},
      {document("{\"name\": \"x\", \"joint\": {\"type\": \"revolute\", \"rotation\": [0, 0, 0, 0]}}"), "a.json:links/0/joint/rotation"},
      {document("{\"name\": \"x\", \"joint\": {\"type\": \"revolute\", \"rotation\": [1, 0]}}"), "a.json:links/0/joint/rotation"},
      {document("{\"name\": \"x\", \"joint\": {\"type\": \"revolute\", \"rotation\": [[1, 0, 0], [0, 1, 0], 7]}}"),
       "a.json:links/0/joint/rotation/2"},
      {document("{\"name\": \"x\", \"joint\": {\"type\": \"revolute\", \"dofs\": [{}, {}]}}"), "a.json:links/0/joint/dofs"},
      {document("{\"name\": \"x\", \"joint\": {\"type\": \"revolute\", \"dofs\": [{\"damping\": null}]}}"),
       "a.json:links/0/joint/dofs/0/damping"},
      {document("{\"name\": \"x\", \"inertia\": {\"mass\": \"heavy\"}}"), "a.json:links/0/inertia/mass"},
      {document("{\"name\": \"x\", \"inertia\": {\"centre\": [0,0,0], \"first_moment\": [0,0,0]}}"), "a.json:links/0/inertia"},
      {document("{\"name\": \"x\", \"shapes\": {}}"), "a.json:links/0/shapes"},
      {document("{\"name\": \"x\", \"shapes\": [{\"type\": \"cone\"}]}"), "a.json:links/0/shapes/0/type"},
      {document("{\"name\": \"x\", \"shapes\": [{\"type\": \"box\", \"collides\": 1}]}"), "a.json:links/0/shapes/0/collides"},
      {document("{\"name\": \"x\", \"virtual\": {\"real\": 5}}"), "a.json:links/0/virtual/real"},
      {R"({"format": "ugoki-mechanism", "version": 1, "links": [{"name": "x"}], "loops": [{"name": "l", "type": "knot"}]})",
       "a.json:loops/0/type"},
      {R"({"format": "ugoki-mechanism", "version": 1, "links": [{"name": "x"}], "loops": [{"type": "gear", "a": {"dof": 0.5}}]})",
       "a.json:loops/0/a/dof"},
      {document("{\"name\": \"x\",}"), "a.json:3:24"},
      {document("{\"name\": \"x\", \"inertia\": {\"mass\": NaN}}"), "a.json:3:45"},
      {document("{\"name\": \"x\", \"inertia\": {\"mass\": 1e999}}"), "a.json:3:45"},
      {document("{\"name\": \"\xFF\"}"), "a.json:3:21"},
      {"", "a.json:1:1"},
      {"{\"format\": \n\"ugoki", "a.json:2:7"},
      {std::string("\x00\x01\x02", 3), "a.json:1:1"},
      {document("{\"name\": \"x\", \"parent\": \"nobody\"}"), "a.json: link x"},
      {document("{\"name\": \"x\"}, {\"name\": \"x\"}"), "a.json: link x"},
      {document(""), "a.json: mechanism (no name)"},
  };
  for (const auto& [text, location] : cases) {
    const auto result = read_mechanism(text, "a.json");
    ASSERT_FALSE(result.has_value()) << text;
    EXPECT_EQ(result.error().problems.at(0).location, location) << text << "\n" << result.error().text();
    EXPECT_FALSE(result.error().problems[0].remedy.empty()) << text;
  }
}

TEST(MechanismJson, DeepNestingAndTruncationAreRejected) {
  EXPECT_FALSE(read_mechanism(std::string(1'000'000, '['), "deep.json").has_value());
  EXPECT_FALSE(read_mechanism(std::string(200'000, '[') + std::string(200'000, ']'), "deep.json").has_value());
  const auto made = Mechanism::make(rich());
  ASSERT_TRUE(made.has_value());
  const std::string text = write_mechanism(**made);
  for (std::size_t n = 0; n + 2 < text.size(); n += 37) {
    const auto result = read_mechanism(text.substr(0, n), "cut.json");
    ASSERT_FALSE(result.has_value()) << n;
    EXPECT_FALSE(result.error().problems[0].remedy.empty());
  }
}

}  // namespace
}  // namespace ugoki::formats
