// Tests of the service: other projects in place of the open one, and the range that is played.
#include "studio_fixture.h"

namespace ugoki::studio {
namespace {

using nlohmann::json;
using test::Frame;
using test::Page;

class StudioProjectTest : public test::StudioTest {};

TEST_F(StudioProjectTest, AnotherProjectIsOpenedInPlaceOfTheOpenOne) {
  Page a = page(), b = page();
  a.ask({{"op", "hello"}});
  const json first = b.ask({{"op", "hello"}});
  ASSERT_EQ(first["recent"].size(), 1u);
  ASSERT_TRUE(a.ask(move_clip(0.25))["ok"]);
  ASSERT_TRUE(a.ask({{"op", "mode"}, {"mode", "simulate"}})["ok"]);
  const json made = a.ask({{"op", "new"}, {"path", "meadow"}, {"from", "sample"}});
  ASSERT_TRUE(made["ok"]) << made;
  EXPECT_EQ(made["path"], folder_ + "/meadow.ugoki");
  EXPECT_FALSE(b.event("opened").is_null()) << "all pages are notified";
  const json hello = b.ask({{"op", "hello"}});
  EXPECT_EQ(hello["project"]["name"], "meadow.ugoki");
  EXPECT_EQ(hello["document"]["characters"].size(), 3u);
  EXPECT_EQ(hello["transport"]["mode"], "edit");
  EXPECT_EQ(hello["transport"]["simulated"], 0);
  EXPECT_FALSE(hello["can_undo"]);
  ASSERT_EQ(hello["recent"].size(), 2u);
  EXPECT_EQ(hello["recent"][0]["name"], "meadow");
  EXPECT_EQ(hello["recent"][1]["path"], path());
  b.frames.clear();
  EXPECT_TRUE(b.frame([](const Frame& f) { return f.characters.size() == 3; })) << "the frames are those of the new content";

  const json again = a.ask({{"op", "new"}, {"path", "meadow"}, {"from", "empty"}});
  EXPECT_EQ(again["path"], folder_ + "/meadow-2.ugoki") << "an existing file is not replaced";
  const json content = {{"scenario", {{"version", 1}, {"name", "chest"}}}, {"mechanisms", json::object()}};
  EXPECT_TRUE(a.ask({{"op", "new"}, {"path", "chest"}, {"from", content}})["ok"]);
  EXPECT_EQ(a.ask({{"op", "hello"}})["document"]["name"], "chest");
  for (const json& wrong : {json("castle"), json(3), json{{"scenario", 1}}})
    EXPECT_FALSE(a.ask({{"op", "new"}, {"path", "x"}, {"from", wrong}})["ok"]) << wrong;
  // At the character NUL the system would cut a path off, so that every proposed name would mean the same existing file.
  for (const char* op : {"new", "open", "save"})
    EXPECT_FALSE(a.ask({{"op", op}, {"path", std::string("meadow.ugoki\0.ugoki", 19)}, {"from", "empty"}})["ok"]) << op;
  EXPECT_FALSE(a.ask({{"op", "open"}, {"path", "nothing-there"}})["ok"]);
  EXPECT_EQ(a.ask({{"op", "hello"}})["document"]["name"], "chest") << "after an error the project stays open";

  ASSERT_TRUE(a.ask({{"op", "open"}, {"path", path()}})["ok"]);
  const json back = a.ask({{"op", "hello"}});
  EXPECT_EQ(back["document"]["characters"][0]["track"][0]["start"], 0.25) << "every command was stored";
  EXPECT_TRUE(back["can_undo"]) << "with its history";
  EXPECT_TRUE(a.ask({{"op", "open"}, {"path", path()}})["ok"]) << "the open project stays open";
}

TEST_F(StudioProjectTest, LoopAndRangeReachTheInterpreterAndAllPages) {
  Page a = page(), b = page();
  a.ask({{"op", "hello"}});
  b.ask({{"op", "hello"}});
  EXPECT_FALSE(a.ask({{"op", "loop"}, {"on", 1}})["ok"]);
  ASSERT_TRUE(a.ask({{"op", "loop"}, {"on", true}})["ok"]);
  EXPECT_FALSE(b.event("transport", [](const json& e) { return e["loop"] == true; }).is_null());
  ASSERT_TRUE(a.ask({{"op", "command"}, {"command", {{"type", "scenario.set"}, {"range", {{"from", 1}, {"to", 1.5}}}}}})["ok"]);
  ASSERT_TRUE(a.ask({{"op", "seek"}, {"time", 1.4}})["ok"]);
  ASSERT_TRUE(a.ask({{"op", "play"}, {"speed", 1}})["ok"]);
  a.frames.clear();
  EXPECT_TRUE(a.frame([](const Frame& f) { return f.time > 1.47; }));
  EXPECT_TRUE(a.frame([](const Frame& f) { return f.time < 1.2; })) << "playing continues at the in point";
  for (const Frame& f : a.frames) {
    EXPECT_GE(f.time, 0.99);
    EXPECT_LE(f.time, 1.51);
  }
}

}  // namespace
}  // namespace ugoki::studio
