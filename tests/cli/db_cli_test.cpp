// `ugoki db`: versions, conflicts, trash, thumbnails, sets, copies, and refused commands.
#include <filesystem>

#include "cli_fixture.h"
#include "ugoki/formats/mechanism_json.h"
#include "ugoki/samples/samples.h"

namespace ugoki::cli {
namespace {

namespace fs = std::filesystem;

/// Fixture whose library contains the sample walk: mechanism, measured data and motion.
class DbCliTest : public CliTest {
 protected:
  void SetUp() override {
    CliTest::SetUp();
    ids_ = json({"import", walk(), "--tags", "walk,own"})["files"][0]["ids"];
    motion_ = ids_["motion"];
    mechanism_ = ids_["mechanism"];
  }
  /// A PNG of 1 x 1 pixel.
  std::string picture() const {
    static constexpr unsigned char png[] = {
        0x89, 'P', 'N', 'G', 0x0d, 0x0a, 0x1a, 0x0a, 0, 0, 0, 0x0d, 'I', 'H', 'D', 'R', 0,    0,    0,    1,    0,    0,    0,    1,    8,
        6,    0,   0,   0,   0x1f, 0x15, 0xc4, 0x89, 0, 0, 0, 0x0d, 'I', 'D', 'A', 'T', 0x78, 0x9c, 0x63, 0x60, 0x60, 0x60, 0xf8, 0x0f, 0,
        1,    4,   1,   0,   0x5f, 0xe5, 0xc3, 0x4b, 0, 0, 0, 0,    'I', 'E', 'N', 'D', 0xae, 0x42, 0x60, 0x82};
    return write("picture.png", std::string(reinterpret_cast<const char*>(png), sizeof png));
  }
  Json ids_;
  std::string motion_, mechanism_;
};

TEST_F(DbCliTest, VersionsNotesAndConflicts) {
  json({"db", "note", motion_, "left knee is noisy"});
  EXPECT_EQ(json({"db", "show", motion_})["note"], "left knee is noisy");
  json({"db", "rename", motion_, "stroll"});
  const Json versions = json({"db", "history", "stroll"})["versions"];
  ASSERT_EQ(versions.size(), 3u);
  for (const Json& v : versions) EXPECT_EQ(v["by"], "anna");
  fails({"db", "rename", "stroll", "march", "--based-on", "1"}, "anna");  // the error names the author of the later version
  json({"db", "restore", "stroll", "1"});
  EXPECT_EQ(json({"db", "show", motion_})["name"], "walk");
  EXPECT_EQ(json({"db", "show", motion_})["version"], 4);
  fails({"db", "restore", motion_, "99"}, "99");
  misunderstands({"db", "restore", motion_, "0"});
  misunderstands({"db", "restore", motion_, "first"});

  const std::string body = path("body.json");
  json({"db", "export", mechanism_, body});
  const std::string before = json({"db", "show", mechanism_})["content"];
  json({"db", "save", mechanism_, write("ball.json", formats::write_mechanism(*samples::make_ball())), "--note", "a ball now"});
  EXPECT_NE(json({"db", "show", mechanism_})["content"], before);
  json({"db", "export", mechanism_, path("old.json"), "--version", "1"});
  EXPECT_EQ(read(path("old.json")), read(body));
  fails({"db", "save", mechanism_, path("absent.json")}, "absent.json");
  fails({"db", "save", mechanism_, write("junk.json", "no mechanism")}, "");
  fails({"db", "export", mechanism_, path("x.json"), "--version", "77"}, "77");
  fails({"db", "note", "nothing", "x"}, "nothing");
}

TEST_F(DbCliTest, TagsAndTrash) {
  json({"db", "untag", motion_, "own"});
  EXPECT_EQ(json({"db", "list", "--tag", "own"})["entries"].size(), 2u);
  const Json tags = json({"db", "tags"})["tags"];
  ASSERT_EQ(tags.size(), 2u);
  EXPECT_EQ(tags[1], (Json{{"name", "own"}, {"count", 2}}));
  fails({"db", "tag", motion_, "nothing", "--add", "x"}, "nothing");
  EXPECT_TRUE(json({"db", "list", "--tag", "x"})["entries"].empty()) << "either all entries should be tagged or none";

  json({"db", "remove", motion_});
  EXPECT_EQ(json({"db", "list", "--removed"})["entries"][0]["id"], motion_);
  fails({"db", "show", motion_}, motion_);
  EXPECT_EQ(json({"db", "show", motion_, "--removed"})["removed_by"], "anna");
  json({"db", "undelete", motion_});
  EXPECT_EQ(json({"db", "show", motion_})["id"], motion_);
  fails({"db", "undelete", motion_}, motion_);
  json({"db", "remove", motion_});
  EXPECT_EQ(json({"db", "empty-trash", "--before", "2001-01-01"})["removed"], 0);
  fails({"db", "empty-trash", "--before", "yesterday"}, "yesterday");
  EXPECT_EQ(json({"db", "empty-trash"})["removed"], 1);
  fails({"db", "undelete", motion_}, motion_);
  EXPECT_TRUE(json({"db", "gc"}).contains("freed_bytes"));
  EXPECT_TRUE(json({"db", "check"})["problems"].empty());
}

TEST_F(DbCliTest, Thumbnails) {
  fails({"db", "thumbnail", motion_, "--to", path("none.png")}, "no thumbnail");
  json({"db", "thumbnail", motion_, "--set", picture()});
  json({"db", "thumbnail", motion_, "--to", path("out.png")});
  EXPECT_EQ(read(path("out.png")), read(path("picture.png")));
  fails({"db", "thumbnail", motion_}, "--to");
  fails({"db", "thumbnail", motion_, "--set", write("no.png", "no picture")}, "");
  fails({"db", "thumbnail", motion_, "--set", path("absent.png")}, "absent.png");
  fails({"db", "thumbnail", motion_, "--to", path("no/such/out.png")}, "out.png");
  json({"db", "thumbnail", motion_, "--clear"});
  fails({"db", "thumbnail", motion_, "--to", path("none.png")}, "no thumbnail");
  misunderstands({"db", "thumbnail", motion_, "--clear", "--set", path("picture.png")});
}

TEST_F(DbCliTest, CircuitsAndSets) {
  const std::string circuit = write(
      "sum.json",
      R"({"version": 1, "name": "t", "inputs": [{"name": "x", "type": "scalar", "to": "i.in"}], "outputs": [{"name": "y", "type": "scalar", "from": "i.out"}],
    "lsis": [{"id": "i", "type": "integrator"}]})");
  const Json added = json({"db", "add", circuit, "--tags", "control", "--note", "adds up"});
  EXPECT_EQ(added["kind"], "circuit");
  EXPECT_EQ(added["name"], "sum");
  const Json set = json({"db", "collect", "walks", "--tag", "walk"});
  EXPECT_EQ(set["summary"]["entries"], 3);
  fails({"db", "add", write("broken.json", "{\"version\": ")}, "broken.json");
  fails({"db", "add", write("no-circuit.json", "{\"links\": []}")}, "no-circuit.json");
  fails({"db", "add", path("absent.json")}, "absent.json");
  fails({"db", "collect", "none", "--tag", "nobody"}, "No entry matches");
  misunderstands({"db", "add"});
}

TEST_F(DbCliTest, SetsAndCopiesBetweenLibraries) {
  const std::string file = path("walks.ugoki-set"), other = path("other.db");
  const Json out = json({"db", "export-set", file, motion_});
  EXPECT_EQ(out["added"], 3) << "the set should contain the needed mechanism and the measured data";
  EXPECT_EQ(json({"db", "import-set", file, "--library", other})["added"], 3);
  EXPECT_EQ(json({"db", "import-set", file, "--library", other})["equal"], 3) << "a second import should add nothing";
  EXPECT_EQ(json({"db", "list", "--library", other})["entries"].size(), 3u);
  const Json copied = json({"db", "copy", library_, path("third.db")});
  EXPECT_EQ(copied["added"], 3);
  EXPECT_EQ(json({"db", "copy", library_, path("third.db")})["equal"], 3);

  // Entries changed on both sides are reported and not changed without --theirs.
  json({"db", "note", motion_, "here"});
  json({"db", "note", motion_, "there", "--library", other});
  json({"db", "export-set", path("newer.ugoki-set"), motion_});
  const Output conflict = ugoki({"db", "import-set", path("newer.ugoki-set"), "--library", other, "--json"});
  EXPECT_EQ(conflict.status, 1);
  EXPECT_EQ(Json::parse(conflict.out)["differing"].size(), 1u);
  EXPECT_EQ(json({"db", "show", motion_, "--library", other})["note"], "there");
  EXPECT_EQ(json({"db", "import-set", path("newer.ugoki-set"), "--library", other, "--theirs"})["saved"], 1);
  EXPECT_EQ(json({"db", "show", motion_, "--library", other})["note"], "here");

  fails({"db", "export-set", path("x.ugoki-set"), "--tag", "nobody"}, "No entry matches");
  fails({"db", "export-set", path("x.ugoki-set"), "nothing"}, "nothing");
  fails({"db", "export-set", path("no/such/x.ugoki-set"), motion_}, "x.ugoki-set");
  fails({"db", "import-set", path("absent.ugoki-set")}, "absent.ugoki-set");
  fails({"db", "import-set", write("text.ugoki-set", "no library at all")}, "text.ugoki-set");
  fails({"db", "copy", path("absent.db"), path("fourth.db")}, "absent.db");
  EXPECT_FALSE(fs::exists(path("fourth.db")));
}

TEST_F(DbCliTest, ListSortsAndPages) {
  const Json first = json({"db", "list", "--limit", "2", "--order", "newest"});
  EXPECT_EQ(first["entries"].size(), 2u);
  EXPECT_EQ(first["total"], 3);
  const Json second = json({"db", "list", "--limit", "2", "--order", "newest", "--after", first["next"]});
  EXPECT_EQ(second["entries"].size(), 1u);
  EXPECT_TRUE(second["next"].is_null());
  EXPECT_EQ(json({"db", "search", "walk"})["entries"].size(), 3u);
  EXPECT_EQ(json({"db", "find", "wal", "--kind", "motion,mechanism"})["entries"].size(), 2u);
  EXPECT_EQ(ugoki({"db", "find", "nobody"}).out, "No entry matches.\n");
  fails({"db", "list", "--after", "no such place"}, "");
  misunderstands({"db", "list", "--order", "size"});
  misunderstands({"db", "list", "--limit", "0"});
  misunderstands({"db", "find"});
}

TEST_F(DbCliTest, CheckReportsDamage) {
  std::string bytes = read(library_);
  (void)json({"db", "export", mechanism_, path("body.json")});
  const std::size_t at = bytes.find(read(path("body.json")).substr(300, 40));
  ASSERT_NE(at, std::string::npos);
  bytes[at] ^= 1;
  write("library.db", bytes);
  const Output o = ugoki({"db", "check", "--json"});
  EXPECT_EQ(o.status, 1) << o.out;
  EXPECT_FALSE(Json::parse(o.out)["problems"].empty());
  write("library.db", bytes.substr(0, bytes.size() / 3));
  const Output cut = ugoki({"db", "check"});
  EXPECT_EQ(cut.status, 1) << cut.out;
  EXPECT_NE((cut.err + cut.out).find("library.db"), std::string::npos) << cut.err;
}

}  // namespace
}  // namespace ugoki::cli
