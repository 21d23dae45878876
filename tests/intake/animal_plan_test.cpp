// Animals that names or controls of their rigs distinguish from persons and from creatures without limbs.
#include <gtest/gtest.h>

#include <cmath>

#include "ugoki/intake/arrange.h"
#include "ugoki/intake/four_legs.h"
#include "ugoki/intake/usual_plan.h"

namespace ugoki::intake {
namespace {

struct Bone {
  std::string name;
  int parent;
  Vec3 offset, end;
};

/// A motion in which every joint with a parent swings about y, with another phase for each joint, as far as `swing` [rad].
MeasuredMotion moving(const std::vector<Bone>& bones, double swing = 0.15) {
  MeasuredMotion m;
  m.rate = 30;
  m.frames = 40;
  for (const Bone& b : bones) {
    SkeletonJoint j;
    j.name = b.name;
    j.parent = b.parent;
    j.offset = b.offset;
    if (norm(b.end) > 0) j.end_sites.push_back(b.end);
    j.translates = b.parent < 0;
    m.skeleton.joints.push_back(std::move(j));
  }
  for (int f = 0; f < m.frames; ++f)
    for (std::size_t i = 0; i < bones.size(); ++i) {
      m.translations.push_back(bones[i].offset);
      const double angle = swing * std::sin(0.3 * f + static_cast<double>(i));
      m.rotations.push_back(bones[i].parent < 0 ? Quat{} : axis_angle({0, 1, 0}, angle));
    }
  return m;
}

std::string name(const MeasuredMotion& m, int joint) { return m.skeleton.joints[static_cast<std::size_t>(joint)].name; }

/// A rig with a level trunk of 1.2 m, long legs, no tail, and the names of a person's limbs. @param fore prefix of the fore limbs' names
MeasuredMotion level(const std::array<std::string, 4>& fore, const Vec3& along = {1, 0, 0}) {
  std::vector<Bone> b = {{"hips", -1, {0, 0, 1.9}, {}}, {"spine", 0, along * 0.6, {}}, {"chest", 1, along * 0.6, {}}};
  b.push_back({"neck", 2, {0.3, 0, 0.2}, {}});
  b.push_back({"head", 3, {0.3, 0, 0.1}, {0.2, 0, 0}});
  for (const auto& [side, y] : {std::pair(std::string(".L"), 0.25), {".R", -0.25}}) {
    const int first = static_cast<int>(b.size());
    b.push_back({"thigh" + side, 0, {0, y, -0.1}, {}});
    b.push_back({"shin" + side, first, {0.1, 0, -0.85}, {}});
    b.push_back({"foot" + side, first + 1, {-0.1, 0, -0.75}, {}});
    b.push_back({"toe" + side, first + 2, {0.15, 0, -0.1}, {0.1, 0, 0}});
    b.push_back({fore[0] + side, 2, {0, y, -0.1}, {}});
    b.push_back({fore[1] + side, first + 4, {0, 0, -0.85}, {}});
    b.push_back({fore[2] + side, first + 5, {0, 0, -0.75}, {}});
    b.push_back({fore[3] + side, first + 6, {0.1, 0, -0.1}, {0.1, 0, 0}});
  }
  return moving(b, 0.08);
}
const std::array<std::string, 4> of_person = {"upper_arm", "forearm", "hand", "finger"};

TEST(AnimalPlan, LegsInFrontBelongToAnAnimal) {
  const Vec3 rising{0.95, 0, 0.35};
  EXPECT_EQ(body::recognise_character(level({"front_thigh", "front_shin", "front_foot", "front_toe"}, rising)).plan,
            body::BodyPlan::four_legs);
  EXPECT_EQ(body::recognise_character(level(of_person)).plan, body::BodyPlan::human) << "a person who bends over";
}

TEST(AnimalPlan, ASpeciesAndALevelTrunkMakeAnAnimalOfAPerson) {
  for (const bool upright : {false, true}) {
    const std::vector<MeasuredMotion> motions = {level(of_person, upright ? Vec3{0.1, 0, 0.9} : Vec3{1, 0, 0})};
    const body::Character human = body::recognise_character(motions[0]);
    ASSERT_EQ(human.plan, body::BodyPlan::human);
    const std::optional<body::Character> animal = animal_of_species(motions, human);
    ASSERT_EQ(animal.has_value(), !upright) << "cartoon animals walk upright";
    if (!animal) continue;
    EXPECT_EQ(animal->plan, body::BodyPlan::four_legs);
    EXPECT_FALSE(animal->corrected);
    EXPECT_EQ(name(motions[0], animal->legs[0].proximal), "thigh.L");
    EXPECT_EQ(name(motions[0], animal->arms[1].proximal), "upper_arm.R");
  }
}

/// A cow whose limbs all hang on the first bone of its body.
std::vector<Bone> cow() {
  std::vector<Bone> b = {{"Armature", -1, {}, {}},
                         {"Body.001", 0, {-0.5, 0, 1.1}, {}},
                         {"Body.002", 1, {0.7, 0, 0}, {}},
                         {"Body.003", 2, {0.65, 0, 0.1}, {}},
                         {"Body.004", 3, {0.5, 0, 0.5}, {0.3, 0, -0.1}},
                         {"Tail", 1, {-0.5, 0, 0.5}, {-0.1, 0, -0.5}}};
  for (const bool fore : {true, false})
    for (const auto& [side, y] : {std::pair(std::string(".L"), 0.27), {".R", -0.27}}) {
      b.push_back({std::string(fore ? "LegF" : "LegB") + side + ".001", 1, {fore ? 1.27 : -0.38, y, -0.4}, {}});
      b.push_back({std::string(fore ? "LegF" : "LegB") + side + ".002", static_cast<int>(b.size()) - 1, {0, 0, -0.37}, {}});
    }
  return b;
}

TEST(AnimalPlan, AChestIsAddedIfTheSpineTurnsAgainstTheForeLimbs) {
  std::vector<Bone> b = cow();
  for (std::size_t i = 7; i < b.size(); i += 2) b[i].end = {0, 0, -0.3};
  std::vector<MeasuredMotion> motions = {moving(b)};
  std::vector<std::string> report;
  const body::Character c = arrange(motions, report);
  ASSERT_EQ(c.plan, body::BodyPlan::four_legs) << c.why_not;
  const MeasuredMotion& m = motions[0];
  EXPECT_EQ(name(m, c.chest), "Body.001_chest");
  EXPECT_EQ(name(m, c.neck.front()), "Body.003") << "the neck of the file continues the chest";
  const auto at = [](int i) { return static_cast<std::size_t>(i); };
  for (int f = 0; f < m.frames; ++f)  // the body holds a joint at its mean place
    for (const body::Limb& l : c.arms)
      EXPECT_LT(norm(m.translations[at(f) * m.skeleton.joints.size() + at(l.proximal)] - m.translations[at(l.proximal)]), 1e-9);
}

TEST(AnimalPlan, AHoofThatHangsOnItsTargetIsTheFootOfTheLimb) {
  std::vector<Bone> b = cow();
  for (int k = 0; k < 4; ++k) {
    const int limb = 7 + 2 * k;
    const std::string& joint = b[static_cast<std::size_t>(limb)].name;  // "LegF.L.002"
    b.push_back({"Leg" + joint.substr(3, 1) + "Target" + joint.substr(4, 2), limb, {0, 0, -0.3}, {0.1, 0, -0.02}});
  }
  std::vector<MeasuredMotion> motions = {moving(b)};
  ASSERT_FALSE(complete_four_legs(motions).empty()) << "the hooves are the ends of the limbs";
  const body::Character c = body::recognise_character(motions[0]);
  ASSERT_EQ(c.plan, body::BodyPlan::four_legs) << c.why_not;
  EXPECT_EQ(name(motions[0], c.legs[0].end), "LegBTarget.L");
  EXPECT_EQ(name(motions[0], c.arms[1].end), "LegFTarget.R");
}

}  // namespace
}  // namespace ugoki::intake
