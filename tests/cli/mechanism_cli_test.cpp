// `ugoki mechanism`: a typical use of every operation, and refused commands.
#include "cli_fixture.h"
#include "ugoki/formats/mechanism_json.h"
#include "ugoki/samples/samples.h"

namespace ugoki::cli {
namespace {

class MechanismCliTest : public CliTest {
 protected:
  void SetUp() override {
    CliTest::SetUp();
    man_ = write("man.json", formats::write_mechanism(**samples::make_person(1.75)));
    dog_ = write("dog.json", formats::write_mechanism(*samples::make_dog()));
    ball_ = write("ball.json", formats::write_mechanism(*samples::make_ball()));
  }
  static MechanismPtr mechanism(const std::string& path) {
    auto m = formats::read_mechanism(read(path), path);
    EXPECT_TRUE(m.has_value()) << (m ? std::string() : m.error().text());
    return m ? *m : nullptr;
  }
  std::string man_, dog_, ball_;
};

TEST_F(MechanismCliTest, CombineJoinsTwoMechanisms) {
  const MechanismPtr man = mechanism(man_), dog = mechanism(dog_), ball = mechanism(ball_);
  const Json held =
      json({"mechanism", "combine", man_, ball_, "--at", man->link(3).name, "--position", "0,0,0.2", "-o", path("held.json")});
  EXPECT_NEAR(held["mass_kg"].get<double>(), man->mass() + ball->mass(), 1e-9);
  EXPECT_EQ(held["dofs"], man->nv()) << "fixed";
  EXPECT_EQ(held["links"], man->link_count() + ball->link_count());
  const Json riding = json({"mechanism", "combine", dog_, man_, "--at", dog->link(0).name, "--loop", "weld", "-o", path("riding.xml")});
  EXPECT_EQ(riding["loops"], 1);
  EXPECT_EQ(riding["dofs"], man->nv() + dog->nv());
  const Json hung =
      json({"mechanism", "combine", man_, ball_, "--joint", "revolute", "--axis", "0,1,0", "--name", "both", "-o", path("b.urdf")});
  EXPECT_EQ(hung["name"], "both");
  EXPECT_EQ(hung["dofs"], man->nv() + 1);

  fails({"mechanism", "combine", man_, ball_, "--at", "wing", "-o", path("x.json")}, "wing");
  fails({"mechanism", "combine", man_, ball_, "--to", "wing", "-o", path("x.json")}, "wing");
  fails({"mechanism", "combine", man_, ball_, "--joint", "revolute", "--axis", "0,0,0", "-o", path("x.json")}, "axis");
  fails({"mechanism", "combine", man_, path("absent.json"), "-o", path("x.json")}, "absent.json");
  misunderstands({"mechanism", "combine", man_, "-o", path("x.json")});
  misunderstands({"mechanism", "combine", man_, ball_, "--joint", "glue", "-o", path("x.json")});
  misunderstands({"mechanism", "combine", man_, ball_, "--position", "1,2", "-o", path("x.json")});
}

TEST_F(MechanismCliTest, CutKeepsTheRestOrThePart) {
  const MechanismPtr dog = mechanism(dog_);
  const std::string link = dog->link(dog->link_count() - 2).name;
  const Json rest = json({"mechanism", "cut", dog_, "--at", link, "-o", path("rest.json")});
  const Json part = json({"mechanism", "cut", dog_, "--at", link, "--keep", "part", "--base-joint", "fixed", "-o", path("part.json")});
  EXPECT_EQ(rest["links"].get<int>() + part["links"].get<int>(), dog->link_count());
  EXPECT_NEAR(rest["mass_kg"].get<double>() + part["mass_kg"].get<double>(), dog->mass(), 1e-9);
  EXPECT_LT(mechanism(path("rest.json"))->find_link(link), 0);
  fails({"mechanism", "cut", dog_, "--at", "wing", "-o", path("x.json")}, "wing");
  misunderstands({"mechanism", "cut", dog_, "-o", path("x.json")});
  misunderstands({"mechanism", "cut", dog_, "--at", link, "--keep", "both", "-o", path("x.json")});
}

TEST_F(MechanismCliTest, MirrorTwiceYieldsTheOriginal) {
  does({"mechanism", "mirror", man_, "-o", path("once.json")});
  does({"mechanism", "mirror", path("once.json"), "-o", path("twice.json")});
  const MechanismPtr a = mechanism(man_), b = mechanism(path("twice.json"));
  ASSERT_EQ(a->link_count(), b->link_count());
  for (int i = 0; i < a->link_count(); ++i) EXPECT_EQ(a->link(i).joint.X_PJ.p, b->link(b->find_link(a->link(i).name)).joint.X_PJ.p);
  misunderstands({"mechanism", "mirror", man_, "--across", "w", "-o", path("x.json")});
}

TEST_F(MechanismCliTest, ScaleByFactorHeightMassAndAge) {
  const MechanismPtr man = mechanism(man_);
  EXPECT_NEAR(json({"mechanism", "scale", man_, "--factor", "0.5", "-o", path("half.json")})["mass_kg"].get<double>(), man->mass() / 8,
              1e-9);
  EXPECT_NEAR(json({"mechanism", "scale", man_, "--height", "1.1", "--mass", "19", "--age", "5", "--sex", "female", "-o",
                    path("girl.json")})["mass_kg"]
                  .get<double>(),
              19, 1e-9);
  const Json child = json({"mechanism", "scale", man_, "--age", "6", "-o", path("child.json")});
  EXPECT_GT(child["mass_kg"].get<double>(), 18);
  EXPECT_LT(child["mass_kg"].get<double>(), 24);
  misunderstands({"mechanism", "scale", man_, "--age", "1", "-o", path("x.json")});
  misunderstands({"mechanism", "scale", man_, "-o", path("x.json")});
  misunderstands({"mechanism", "scale", man_, "--factor", "0", "-o", path("x.json")});
  misunderstands({"mechanism", "scale", man_, "--factor", "2", "--age", "6", "-o", path("x.json")});
}

TEST_F(MechanismCliTest, EditChangesAllOrNothing) {
  const std::string link = mechanism(man_)->link(4).name;
  does({"mechanism", "edit", man_, "--set", link + ":inertia.mass=7.5", "-o", path("edited.json")});
  const MechanismPtr edited = mechanism(path("edited.json"));
  EXPECT_NEAR(edited->link(edited->find_link(link)).inertia.mass, 7.5, 1e-12);
  fails({"mechanism", "edit", man_, "--set", "wing:inertia.mass=6", "-o", path("x.json")}, "wing");
  fails({"mechanism", "edit", man_, "--set", link + ":inertia.mass=-6", "-o", path("x.json")}, link);
  fails({"mechanism", "edit", man_, "--set", link + ":colour=red", "-o", path("x.json")}, "colour");
  fails({"mechanism", "edit", man_, "--set", link + ":inertia.mass=heavy", "-o", path("x.json")}, "heavy");
  fails({"mechanism", "edit", man_, "--set", "no colon", "-o", path("x.json")}, "no colon");
  fails({"mechanism", "edit", man_, "--set", link + ":inertia.mass=6", link + ":joint.type=hinge", "-o", path("x.json")}, "hinge");
  misunderstands({"mechanism", "edit", man_, "-o", path("x.json")});
}

TEST_F(MechanismCliTest, InertiaOfAMesh) {
  const std::string cube = write("cube.obj",
                                 "v 0 0 0\nv 2 0 0\nv 2 2 0\nv 0 2 0\nv 0 0 2\nv 2 0 2\nv 2 2 2\nv 0 2 2\nf 1 4 3 2\nf 5 6 7 8\nf 1 2 6 "
                                 "5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n");
  const Json j = json({"mechanism", "inertia", cube, "--unit", "0.1", "--density", "500"});
  EXPECT_NEAR(j["mass_kg"].get<double>(), 4, 1e-12);
  EXPECT_NEAR(j["centre_m"][2].get<double>(), 0.1, 1e-12);
  EXPECT_NEAR(j["about_centre"][0].get<double>(), 4 * 0.04 / 6, 1e-12);
  const std::string link = mechanism(ball_)->link(0).name;
  does({"mechanism", "inertia", cube, "--unit", "0.1", "--mass", "3", "--mechanism", ball_, "--link", link, "-o", path("cubic.json")});
  EXPECT_NEAR(mechanism(path("cubic.json"))->mass(), 3, 1e-12);
  const std::string open = write("open.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\n");
  fails({"mechanism", "inertia", open}, "open.obj");
  EXPECT_NEAR(json({"mechanism", "inertia", open, "--hull"})["volume_m3"].get<double>(), 1.0 / 6, 1e-12);
  fails({"mechanism", "inertia", cube, "--mechanism", ball_, "--link", "wing", "-o", path("x.json")}, "wing");
  fails({"mechanism", "inertia", path("absent.stl")}, "absent.stl");
  fails({"mechanism", "inertia", write("text.stl", "no mesh")}, "text.stl");
  misunderstands({"mechanism", "inertia", cube, "--mechanism", ball_});
  misunderstands({"mechanism", "inertia", cube, "--density", "0"});
}

TEST_F(MechanismCliTest, BodyOfASkeleton) {
  const Json j = json({"mechanism", "body", walk(), "--mass", "70", "--height", "1.8", "-o", path("walker.json")});
  EXPECT_NEAR(j["mass_kg"].get<double>(), 70, 1e-9);
  EXPECT_FALSE(j["report"].empty());
  fails({"mechanism", "body", path("absent.bvh"), "-o", path("x.json")}, "absent.bvh");
  fails({"mechanism", "body", write("bad.bvh", "HIERARCHY\nROOT"), "-o", path("x.json")}, "bad.bvh:");
}

TEST_F(MechanismCliTest, InvalidOutputsAreRefused) {
  fails({"mechanism", "mirror", man_, "-o", path("man.stl")}, "man.stl");
  fails({"mechanism", "mirror", man_, "-o", path("no/such/man.json")}, "man.json");
  fails({"mechanism", "mirror", man_, "-o", path("no/such/man.urdf")}, "man");
  fails({"mechanism", "mirror", folder_, "-o", path("x.json")}, folder_);
  fails({"mechanism", "mirror", "no entry", "-o", path("x.json")}, "no entry");
  (void)json({"import", walk()});
  fails({"mechanism", "mirror", "no entry", "-o", path("x.json")}, "no entry");
  fails({"mechanism", "mirror", write("bad.json", "{\"links\": 3}"), "-o", path("x.json")}, "bad.json");
  misunderstands({"mechanism"});
  misunderstands({"mechanism", "explode", man_});
  misunderstands({"mechanism", "mirror", man_});
}

}  // namespace
}  // namespace ugoki::cli
