#include "ugoki/motion_edit/mirror.h"

#include <gtest/gtest.h>

#include <cmath>

#include "characters.h"
#include "ugoki/motion_edit/foot_contacts.h"

namespace ugoki::motion_edit {
namespace {

TEST(Mirror, PairsLeftAndRight) {
  for (const Character& character : {human_walk(), dog_trot()}) {
    const std::vector<int> partner = find_mirror_links(character.m());
    int sides = 0;
    for (int i = 0; i < character.m().link_count(); ++i) {
      EXPECT_EQ(partner[at(partner[at(i)])], i);
      const std::string& label = character.m().link(i).label;
      if (label.find("left") == std::string::npos) continue;
      ++sides;
      EXPECT_NE(character.m().link(partner[at(i)]).label.find("right"), std::string::npos) << label;
    }
    EXPECT_GT(sides, 5);
  }
}

TEST(Mirror, PairsByPositionWithoutNames) {
  const Character dog = dog_trot();
  MechanismSpec spec = dog.m().spec();
  std::vector<std::string> names;
  for (std::size_t i = 0; i < spec.links.size(); ++i) {
    const std::string old = spec.links[i].name, now = "b" + std::to_string(i * 7 + 3);
    spec.links[i].name = now;
    spec.links[i].label.clear();
    for (LinkSpec& l : spec.links)
      if (l.parent == old) l.parent = now;
  }
  const MechanismPtr bare = Mechanism::make(spec).value();
  EXPECT_EQ(find_mirror_links(*bare), find_mirror_links(dog.m()));
}

TEST(Mirror, LinkPositionsAreMirrored) {
  // Independent of joint coordinates: the position of every link is the mirror image of its partner's position.
  for (const Character& character : {human_walk(), dog_trot()}) {
    const Motion image = mirror(character.m(), character.motion).value();
    const std::vector<int> partner = find_mirror_links(character.m());
    const Placement plane = root_placement(character.m(), {character.motion.frame(0), at(character.motion.nq)});
    const Pose X_WM = to_pose({plane.x, plane.y, 0, plane.heading});
    std::vector<Pose> X(at(character.m().link_count())), Y(X.size());
    for (int f = 0; f < image.frames; f += 7) {
      calc_poses(character.m(), {character.motion.frame(f), at(image.nq)}, X);
      calc_poses(character.m(), {image.frame(f), at(image.nq)}, Y);
      for (int i = 0; i < character.m().link_count(); ++i) {
        Vec3 p = X_WM.inverse() * X[at(partner[at(i)])].p;
        p.y = -p.y;
        EXPECT_LT(norm(X_WM * p - Y[at(i)].p), 2e-3) << character.m().link(i).name << " in frame " << f;
      }
    }
  }
}

TEST(Mirror, MirroringTwiceGivesTheMotion) {
  for (Character character : {human_walk(), dog_trot()}) {
    for (int f = 0; f < character.motion.frames; ++f)
      displace_root(character.m(), {2, -1, 0, 0.7}, {character.motion.frame(f), at(character.motion.nq)});
    set_labels(character.m(), find_contacts(character.m(), character.motion), character.motion);
    const Motion once = mirror(character.m(), character.motion).value(), twice = mirror(character.m(), once).value();
    EXPECT_LT(max_difference(character.m(), twice, character.motion), 1e-9);
    EXPECT_GT(max_difference(character.m(), once, character.motion), 0.1);
    for (std::size_t k = 0; k < character.motion.contacts.size(); ++k) {
      EXPECT_EQ(twice.contacts[k].link, character.motion.contacts[k].link);
      EXPECT_NE(once.contacts[k].link, character.motion.contacts[k].link);
    }
  }
}

TEST(Mirror, RefusesAsymmetricMechanisms) {
  const Character character = dog_trot();
  MechanismSpec spec = character.m().spec();
  const std::vector<int> partner = find_mirror_links(character.m());
  for (LinkSpec& l : spec.links)
    if (l.joint.type == JointType::revolute && partner[at(character.m().find_link(l.name))] != character.m().find_link(l.name)) {
      l.joint.axis = {l.joint.axis.y, l.joint.axis.z, l.joint.axis.x};
      break;
    }
  const MechanismPtr skew = Mechanism::make(spec).value();
  const auto wrong = mirror(*skew, character.motion);
  ASSERT_FALSE(wrong);
  EXPECT_NE(wrong.error().text().find("mirror image"), std::string::npos);
}

}  // namespace
}  // namespace ugoki::motion_edit
