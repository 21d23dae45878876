// 43 misbehaving LSIs in `ugoki lsi test` and `ugoki circuit run`: the message names each LSI, and the exit status is 1.

#include "../plugin/misbehaving.h"
#include "shelf_test.h"

namespace ugoki::cli {
namespace {

namespace fs = std::filesystem;

class Slow_MisbehavingCliTest : public ShelfTest {
 protected:
  /// Expects exit status 1 and a message on stderr that names the library and contains `report`.
  void expect_named(const std::vector<std::string>& arguments, std::string_view name, std::string_view report) const {
    const Output o = ugoki(arguments);
    EXPECT_EQ(o.status, 1) << name << "\n" << o.out << o.err;
    EXPECT_NE(o.err.find("rogue"), std::string::npos) << name << "\n" << o.err;
    EXPECT_NE(o.err.find(report), std::string::npos) << name << "\n" << o.err;
  }
};

TEST_F(Slow_MisbehavingCliTest, EachIsNamedAndFails) {
  const std::string circuit =
      R"({"version": 1, "name": "t", "lsis": [{"id": "c", "type": "clock"}, {"id": "it", "type": "rogue/f"}], "wires": [{"from": "c.time", "to": "it.t"}]})";
  for (const plugin::Misbehaving& m : plugin::misbehaving) {
    const std::string folder = folder_ + "/rogue";
    fs::remove_all(folder);
    fs::create_directory(folder);
    write(m.cpp ? "rogue/rogue.cpp" : "rogue/rogue.c", plugin::rogue_source(m));
    write("rogue/rogue.test.json", R"({"doc": "", "dt": 0.01, "circuit": )" + circuit +
                                       R"(, "given": [], "expect": [{"tick": 5, "pin": "it.out", "value": 0.05, "tolerance": 1}]})");
    expect_named({"lsi", "test", folder}, m.name, m.report);
    expect_named({"circuit", "run", write("rogue.json", circuit), "--lsi", folder + "/rogue.so", "--dt", "0.01", "--duration", "0.1",
                  "--patience", "0.4"},
                 m.name, m.report);
  }
}

TEST_F(Slow_MisbehavingCliTest, LibrariesThatMisbehaveWhileLoadingAreNamed) {
  for (const plugin::MisbehavingLoad& m : plugin::misbehaving_while_loading) {
    const std::string source = write("rogue.c", std::string(m.source));
    expect_named({"lsi", "build", source}, m.name, m.report);
    ASSERT_TRUE(fs::exists(folder_ + "/rogue.so")) << m.name;
    expect_named({"lsi", "install", folder_ + "/rogue.so", "--yes"}, m.name, m.report);
  }
}

}  // namespace
}  // namespace ugoki::cli
