// `ugoki motion` and `ugoki retarget`: a typical use of every operation, and refused commands.
#include <filesystem>

#include "cli_fixture.h"
#include "ugoki/formats/bvh.h"
#include "ugoki/formats/mechanism_json.h"
#include "ugoki/samples/samples.h"

namespace ugoki::cli {
namespace {

namespace fs = std::filesystem;

class MotionCliTest : public CliTest {
 protected:
  void SetUp() override {
    CliTest::SetUp();
    walk_ = walk();
    stand_ = write("stand.bvh", formats::write_bvh(samples::make_human_stand()));
    frames_ = samples::make_human_walk().frames;
    rate_ = samples::make_human_walk().rate;
  }
  static MeasuredMotion bvh(const std::string& path) {
    auto m = formats::read_bvh(read(path), path);
    EXPECT_TRUE(m.has_value()) << path << (m ? std::string() : m.error().text());
    return m ? std::move(*m) : MeasuredMotion{};
  }
  std::string walk_, stand_;
  int frames_ = 0;
  double rate_ = 0;
};

TEST_F(MotionCliTest, TrimReverseMirrorResample) {
  const Json part = json({"motion", "trim", walk_, "--from", "0.2", "--to", "0.5", "-o", path("part.bvh")});
  EXPECT_NEAR(part["duration_s"].get<double>(), 0.3, 1.0 / rate_);
  EXPECT_EQ(bvh(path("part.bvh")).frames, part["frames"]);
  EXPECT_EQ(json({"motion", "reverse", walk_, "-o", path("back.bvh")})["frames"], frames_);
  const MeasuredMotion original = bvh(walk_), back = bvh(path("back.bvh"));
  EXPECT_LT(norm(original.translations[0] - back.translations[static_cast<std::size_t>(back.frames - 1) * back.skeleton.joints.size()]),
            1e-4);
  EXPECT_EQ(json({"motion", "mirror", walk_, "-o", path("image.bvh")})["frames"], frames_);
  EXPECT_EQ(json({"motion", "resample", walk_, "--rate", "25", "-o", path("slow.bvh")})["rate"], 25);
  EXPECT_EQ(bvh(path("slow.bvh")).rate, 25);

  fails({"motion", "trim", walk_, "--from", "90", "-o", path("x.bvh")}, "");
  fails({"motion", "trim", walk_, "--from", "0.5", "--to", "0.2", "-o", path("x.bvh")}, "");
  fails({"motion", "resample", walk_, "--rate", "0", "-o", path("x.bvh")}, "");
  fails({"motion", "resample", walk_, "--rate", "-5", "-o", path("x.bvh")}, "");
  misunderstands({"motion", "resample", walk_});
  misunderstands({"motion", "trim", walk_, "--from", "-1"});
}

TEST_F(MotionCliTest, TorquesAndAngles) {
  const Json torques = json({"motion", "torques", walk_, "--own-control", "--assist-limit", "0", "-o", path("torques.ugoki")});
  EXPECT_TRUE(torques["replays_bit_for_bit"].get<bool>());
  EXPECT_EQ(torques["characters"][0]["root_force_max_bw"], 0);
  const Json once = json({"run", path("torques.ugoki")}), again = json({"run", path("torques.ugoki")});
  EXPECT_EQ(once["state_hash"], again["state_hash"]);
  const Json angles = json({"motion", "angles", path("torques.ugoki"), "-o", path("angles.ugoki")});
  EXPECT_LT(angles["characters"][0]["deviation_max_deg"], 1e-9);
  fails({"motion", "torques", path("missing.bvh"), "-o", path("x.ugoki")}, "missing.bvh");
  fails({"motion", "angles", path("angles.ugoki"), "-o", path("x.ugoki")}, "torque");
  fails({"motion", "torques", walk_, "-o", path("torques.ugoki")}, "torques.ugoki");
  misunderstands({"motion", "torques", walk_});
}

TEST_F(MotionCliTest, ScaleWarpPathReduce) {
  EXPECT_NEAR(json({"motion", "scale", walk_, "--time", "2"})["duration_s"].get<double>(), 2 * (frames_ - 1) / rate_, 2 / rate_);
  const double travel = json({"motion", "scale", walk_})["way_m"];
  EXPECT_NEAR(json({"motion", "scale", walk_, "--length", "1.5"})["way_m"].get<double>(), 1.5 * travel, 1e-9);
  EXPECT_NEAR(json({"motion", "warp", walk_, "--point", "0", "0", "--point", "1", "0.5"})["duration_s"].get<double>(), 1, 1 / rate_);
  EXPECT_GT(json({"motion", "path", walk_, "--point", "0", "0", "--point", "1", "0", "--point", "2", "1"})["frames"], 1);
  const Json keys = json({"motion", "reduce", walk_, "--degrees", "1"});
  EXPECT_LT(keys["keys"], keys["keys_before"]);

  fails({"motion", "scale", walk_, "--time", "0"}, "");
  fails({"motion", "scale", walk_, "--length", "-1"}, "");
  fails({"motion", "warp", walk_, "--point", "0", "0"}, "");
  fails({"motion", "warp", walk_, "--point", "1", "0", "--point", "0", "1"}, "");
  fails({"motion", "path", walk_, "--point", "0", "0"}, "");
  fails({"motion", "reduce", walk_, "--degrees", "-1"}, "");
  misunderstands({"motion", "warp", walk_});
  misunderstands({"motion", "path", walk_, "--point", "a", "b"});
}

TEST_F(MotionCliTest, CycleContactsLockAndBlend) {
  const Json cycle = json({"motion", "cycle", walk_, "-o", path("cycle.bvh")});
  EXPECT_EQ(cycle["cyclic"], true);
  const Json contacts = json({"motion", "contacts", walk_});
  EXPECT_GE(contacts["contacts"].size(), 2u);
  EXPECT_NE(ugoki({"motion", "contacts", walk_}).out.find("Feet slide"), std::string::npos);
  const Json lock = json({"motion", "lock", walk_, "-o", path("lock.bvh")});
  EXPECT_LE(lock["lock"]["foot_skate_after_cm"].get<double>(), lock["lock"]["foot_skate_before_cm"].get<double>() + 1e-6);
  does({"motion", "scale", walk_, "--time", "0.8", "--length", "1.2", "-o", path("fast.bvh")});
  const Json blend = json({"motion", "blend", walk_, path("fast.bvh"), "--at", "0,50,100", "-o", path("gait.bvh")});
  ASSERT_EQ(blend["motions"].size(), 3u);
  EXPECT_LT(blend["motions"][0]["speed_m_s"], blend["motions"][1]["speed_m_s"]);
  EXPECT_LT(blend["motions"][1]["speed_m_s"], blend["motions"][2]["speed_m_s"]);
  for (const char* name : {"gait-0.bvh", "gait-50.bvh", "gait-100.bvh"}) EXPECT_GT(bvh(path(name)).frames, 10);

  fails({"motion", "contacts", walk_, "--feet", "wing"}, "wing");
  fails({"motion", "blend", walk_, path("absent.bvh")}, "absent.bvh");
  fails({"motion", "blend", walk_, path("fast.bvh"), "--weights", "1,2,3", "-o", path("x.bvh")}, "weight");
  misunderstands({"motion", "blend", walk_, "--at", "50"});
  misunderstands({"motion", "blend", walk_, path("fast.bvh"), "--at", "150"});
  misunderstands({"motion", "lock", walk_, "--stretch", "2"});
}

TEST_F(MotionCliTest, JoinMixAndLayer) {
  const Json joined = json({"motion", "join", walk_, stand_, "--blend", "0.2", "-o", path("stop.bvh")});
  EXPECT_GT(joined["duration_s"].get<double>(), 4);
  const std::string arm = samples::make_human_walk().skeleton.joints.back().name;
  EXPECT_GT(json({"motion", "mix", walk_, stand_, "--joints", arm + ":0.5", "-o", path("mix.bvh")})["frames"], 1);
  EXPECT_GT(json({"motion", "layer", walk_, stand_, "--weight", "0.5", "-o", path("layer.bvh")})["frames"], 1);
  fails({"motion", "mix", walk_, stand_, "--joints", "wing", "-o", path("x.bvh")}, "wing");
  fails({"motion", "join", walk_, stand_, "--blend", "-1", "-o", path("x.bvh")}, "");
  misunderstands({"motion", "join", walk_});
}

TEST_F(MotionCliTest, OutputsAndInputsAreChecked) {
  const Json j = json({"motion", "reverse", walk_, "-o", "backwards"});
  EXPECT_EQ(j["out"], "backwards");
  EXPECT_EQ(json({"db", "show", "backwards"})["kind"], "motion");
  EXPECT_EQ(json({"motion", "reverse", "backwards", "-o", path("again.glb")})["frames"], frames_);
  EXPECT_TRUE(read(path("again.glb")).starts_with("glTF"));
  const Json plain = json({"motion", "reverse", walk_});
  EXPECT_FALSE(plain.contains("written")) << "without -o nothing should be written";
  fails({"motion", "reverse", walk_, "-o", path("x.doc")}, "x.doc");
  fails({"motion", "reverse", walk_, "-o", path("no/such/x.bvh")}, "x.bvh");
  fails({"motion", "reverse", "no entry", "-o", path("x.bvh")}, "no entry");
  fails({"motion", "reverse", write("half.bvh", read(walk_).substr(0, 4000)), "-o", path("x.bvh")}, "half.bvh:");
  fails({"motion", "reverse", write("m.json", formats::write_mechanism(*samples::make_ball()))}, "m.json");
  fails({"motion", "forces", write("no.c3d", "not a C3D file")}, "no.c3d");
  fails({"motion", "forces", walk_}, "walk.bvh");
  misunderstands({"motion"});
  misunderstands({"motion", "juggle", walk_});
}

TEST_F(MotionCliTest, RetargetToChildDogAndRobot) {
  const Json child = json({"retarget", walk_, "--height", "1.1", "-o", path("child.bvh"), "--mechanism-out", path("child.json")});
  EXPECT_LT(child["scale"].get<double>(), 0.8);
  EXPECT_EQ(child["frames"], frames_);
  EXPECT_FALSE(child["mapping"].empty());
  EXPECT_EQ(bvh(path("child.bvh")).frames, frames_);
  EXPECT_TRUE(formats::read_mechanism(read(path("child.json")), "child.json").has_value());
  EXPECT_GT(json({"retarget", walk_, "--to", "dog", "-o", "dog walk"})["frames"], 1);
  EXPECT_EQ(json({"db", "show", "dog walk"})["kind"], "motion");
  EXPECT_EQ(json({"retarget", "dog walk", "--to", "human"})["written"].size(), 0u);
  EXPECT_GT(json({"retarget", walk_, "--to", path("child.json"), "--free-feet", "--path-scale", "0.5"})["frames"], 1);
  EXPECT_NE(ugoki({"retarget", walk_, "--height", "1.1"}).out.find("Mapping of links"), std::string::npos);

  fails({"retarget", path("absent.bvh"), "--to", "dog", "-o", path("x.bvh")}, "absent.bvh");
  fails({"retarget", walk_, "--to", path("absent.urdf"), "-o", path("x.bvh")}, "absent.urdf");
  fails({"retarget", walk_, "--to", "unicorn", "-o", path("x.bvh")}, "unicorn");
  fails({"retarget", walk_, "--to", write("ball.json", formats::write_mechanism(*samples::make_ball())), "-o", path("x.bvh")}, "");
  fails({"retarget", walk_, "--to", "dog", "--mapping", path("absent-map.json"), "-o", path("x.bvh")}, "absent-map.json");
  fails({"retarget", walk_, "--to", "dog", "--mapping", write("map.json", "{\"links\": 3}"), "-o", path("x.bvh")}, "map.json");
  fails({"retarget", walk_, "--to", "dog", "--mapping", write("map2.json", R"({"links": {"wing": "Hips"}})"), "-o", path("x.bvh")}, "wing");
  fails({"retarget", walk_, "--to", "dog", "-o", path("x.doc")}, "x.doc");
  fails({"retarget", walk_, "--to", "dog", "-o", path("no/such/x.bvh"), "--mechanism-out", path("dog.json")}, "x.bvh");
  misunderstands({"retarget", walk_});
  misunderstands({"retarget", walk_, "--to", "dog", "--height", "1.5"});
  misunderstands({"retarget", walk_, "--height", "0.1"});
  misunderstands({"retarget", walk_, "--to", "dog", "--gait-phase", "7"});
}

// A project of a gait on a slope or on stairs has the ground as props, and the character goes up or down on it without root assist.
TEST_F(MotionCliTest, GaitBringsItsGround) {
  struct Case {
    const char* option;
    const char* value;
    std::size_t characters;  // the human, the ramp or the stairs, and downwards a platform
  };
  for (const Case& c : {Case{"--slope", "8", 2}, Case{"--slope", "-8", 3}, Case{"--stairs", "0.03", 2}}) {
    const std::string project = path(std::string("ground") + c.option + c.value + ".ugoki");
    (void)json({"gait", "human", "--speed", "1", "--seconds", "6", c.option, c.value, "--project", project});
    EXPECT_EQ(json({"info", project})["characters"].size(), c.characters) << c.option << " " << c.value;
    const Json run = json({"run", project, "--duration", "5"});
    EXPECT_FALSE(run["characters"][0]["fell"].get<bool>()) << c.option << " " << c.value << " " << run["characters"][0];
    EXPECT_LT(run["characters"][0]["tracking_rms_deg"].get<double>(), 10) << c.option << " " << c.value;
  }
  const std::string both = path("both.ugoki");
  fails({"gait", "human", "--slope", "5", "--stairs", "0.1", "--project", both}, "not both");
  fails({"gait", "human", "--slope", "5", "--project", both, "--out", path("both.bvh")}, "Call `ugoki gait` twice");
}

// Two of these speeds fall if the computed motion is not filtered.
TEST_F(MotionCliTest, ARunThatIsLostNamesItsReasons) {
  MeasuredMotion belt = samples::make_human_walk();
  for (int f = 0; f < belt.frames; ++f) {
    Vec3& root = belt.translations[static_cast<std::size_t>(f) * belt.skeleton.joints.size()];
    root = {belt.translations[0].x, belt.translations[0].y, root.z};
  }
  const std::string in_place = write("belt.bvh", formats::write_bvh(belt));
  const Json lost = json({"run", in_place, "--assist-limit", "0"});
  EXPECT_TRUE(lost["fell"].get<bool>());
  ASSERT_EQ(lost["checks"].size(), 1u);
  EXPECT_NE(lost["checks"][0].get<std::string>().find("walks in place"), std::string::npos);
  const std::string text = ugoki({"run", in_place, "--assist-limit", "0"}).out;
  EXPECT_NE(text.find(lost["checks"][0].get<std::string>()), std::string::npos) << text;
  EXPECT_TRUE(json({"run", walk_})["checks"].empty());
  const Json pushed = json({"run", walk_, "--assist-limit", "0.05", "--push", "1200", "--push-time", "0.3"});
  ASSERT_TRUE(pushed["fell"].get<bool>());
  ASSERT_FALSE(pushed["checks"].empty());
  EXPECT_NE(pushed["checks"][0].get<std::string>().find("assist was at its limit of 0.05"), std::string::npos) << pushed["checks"];
  EXPECT_EQ(ugoki({"run", walk_}).out.find("ugoki judge"), std::string::npos) << "a walk that is followed has no reasons";
  EXPECT_NE(text.find("With --correct"), std::string::npos) << text;
  // The correction gives the walk in place its travel, so that the person needs no assist.
  const Json corrected = json({"run", in_place, "--assist-limit", "0.1", "--correct"});
  EXPECT_FALSE(corrected["fell"].get<bool>());
  EXPECT_LT(corrected["tracking_rms_deg"].get<double>(), 5);
  EXPECT_LT(corrected["correction"]["change_deg"].get<double>(), 5);
  EXPECT_GT(corrected["correction"]["change_deg"].get<double>(), 0);
  EXPECT_FALSE(lost.contains("correction"));
}

TEST_F(MotionCliTest, RigidPartsThatMoveAreAMotionForEveryVerb) {
  const std::string box = std::string(UGOKI_SHARED_DATA) + "/gltf/box_animated.gltf";
  EXPECT_NEAR(json({"run", box})["duration_s"].get<double>(), 3.69, 0.01);
  (void)json({"export", box, "--glb", path("box.glb")});
  EXPECT_TRUE(std::filesystem::exists(path("box.glb")));
}

/// Whether a person who walks up 10 degrees at `speed` (m/s) for some seconds stays up.
class UphillTest : public MotionCliTest {
 protected:
  void walk(const char* speed, const char* seconds) {
    const std::string project = path(std::string("uphill") + speed + ".ugoki");
    (void)json({"gait", "human", "--speed", speed, "--seconds", seconds, "--slope", "10", "--project", project});
    EXPECT_FALSE(json({"run", project})["fell"].get<bool>()) << speed << " m/s";
  }
};

TEST_F(UphillTest, PeopleWalkFor12Seconds) {
  for (const char* speed : {"1.0", "1.4"}) walk(speed, "12");
}

class Slow_UphillTest : public UphillTest {};

TEST_F(Slow_UphillTest, PeopleWalkForAMinute) {
  for (const char* speed : {"1.0", "1.1", "1.2", "1.3", "1.4"}) walk(speed, "60");
}

}  // namespace
}  // namespace ugoki::cli
