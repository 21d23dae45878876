#include "ugoki/motion_edit/mirror.h"

#include <gtest/gtest.h>

#include <cmath>

#include "figures.h"
#include "ugoki/motion_edit/foot_contacts.h"

namespace ugoki::motion_edit {
namespace {

TEST(Mirror, PairsLeftAndRight) {
  for (const Figure& figure : {human_walk(), dog_trot()}) {
    const std::vector<int> partner = find_mirror_links(figure.m());
    int sides = 0;
    for (int i = 0; i < figure.m().link_count(); ++i) {
      EXPECT_EQ(partner[at(partner[at(i)])], i);
      const std::string& label = figure.m().link(i).label;
      if (label.find("left") == std::string::npos) continue;
      ++sides;
      EXPECT_NE(figure.m().link(partner[at(i)]).label.find("right"), std::string::npos) << label;
    }
    EXPECT_GT(sides, 5);
  }
}

TEST(Mirror, PairsByPlaceWhereNothingIsNamed) {
  const Figure dog = dog_trot();
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

TEST(Mirror, PlacesAreMirrored) {
  // Independent of coordinates: every link's place is the mirror image of its partner's.
  for (const Figure& figure : {human_walk(), dog_trot()}) {
    const Motion image = mirror(figure.m(), figure.motion).value();
    const std::vector<int> partner = find_mirror_links(figure.m());
    const Placement plane = root_placement(figure.m(), {figure.motion.frame(0), at(figure.motion.nq)});
    const Pose X_WM = to_pose({plane.x, plane.y, 0, plane.heading});
    std::vector<Pose> X(at(figure.m().link_count())), Y(X.size());
    for (int f = 0; f < image.frames; f += 7) {
      calc_poses(figure.m(), {figure.motion.frame(f), at(image.nq)}, X);
      calc_poses(figure.m(), {image.frame(f), at(image.nq)}, Y);
      for (int i = 0; i < figure.m().link_count(); ++i) {
        Vec3 p = X_WM.inverse() * X[at(partner[at(i)])].p;
        p.y = -p.y;
        EXPECT_LT(norm(X_WM * p - Y[at(i)].p), 2e-3) << figure.m().link(i).name << " in frame " << f;
      }
    }
  }
}

TEST(Mirror, TwiceIsTheMotion) {
  for (Figure figure : {human_walk(), dog_trot()}) {
    for (int f = 0; f < figure.motion.frames; ++f)
      displace_root(figure.m(), {2, -1, 0, 0.7}, {figure.motion.frame(f), at(figure.motion.nq)});
    set_labels(figure.m(), find_contacts(figure.m(), figure.motion), figure.motion);
    const Motion once = mirror(figure.m(), figure.motion).value(), twice = mirror(figure.m(), once).value();
    EXPECT_LT(greatest_difference(figure.m(), twice, figure.motion), 1e-9);
    EXPECT_GT(greatest_difference(figure.m(), once, figure.motion), 0.1);
    for (std::size_t k = 0; k < figure.motion.contacts.size(); ++k) {
      EXPECT_EQ(twice.contacts[k].link, figure.motion.contacts[k].link);
      EXPECT_NE(once.contacts[k].link, figure.motion.contacts[k].link);
    }
  }
}

TEST(Mirror, RefusesWhatIsNotSymmetric) {
  const Figure figure = dog_trot();
  MechanismSpec spec = figure.m().spec();
  const std::vector<int> partner = find_mirror_links(figure.m());
  for (LinkSpec& l : spec.links)
    if (l.joint.type == JointType::revolute && partner[at(figure.m().find_link(l.name))] != figure.m().find_link(l.name)) {
      l.joint.axis = {l.joint.axis.y, l.joint.axis.z, l.joint.axis.x};
      break;
    }
  const MechanismPtr skew = Mechanism::make(spec).value();
  const auto wrong = mirror(*skew, figure.motion);
  ASSERT_FALSE(wrong);
  EXPECT_NE(wrong.error().text().find("mirror image"), std::string::npos);
}

}  // namespace
}  // namespace ugoki::motion_edit
