// Runs the circuits in examples/lsi. There is one for each signal LSI, which documents and tests the LSI.

#include <filesystem>
#include <fstream>
#include <set>

#include "circuit_test.h"
#include "ugoki/circuit/example.h"

namespace ugoki::circuit {
namespace {

namespace fs = std::filesystem;

TEST(Examples, EverySignalLsiHasAPassingExample) {
  std::set<std::string> files;
  for (const fs::directory_entry& e : fs::directory_iterator(std::string(UGOKI_SOURCE_DIR) + "/examples/lsi"))
    if (e.path().string().ends_with(".test.json")) files.insert(e.path().filename().string());
  for (const LsiClass& c : signal_library().classes()) {
    std::string name = c.name + ".test.json";
    std::replace(name.begin(), name.end(), ' ', '-');
    ASSERT_TRUE(files.erase(name)) << "examples/lsi/" << name << " is missing";
    std::ifstream in(std::string(UGOKI_SOURCE_DIR) + "/examples/lsi/" + name);
    const std::string text((std::istreambuf_iterator<char>(in)), {});
    const Result<Example> example = read_example(text, name);
    ASSERT_TRUE(example) << example.error().text();
    EXPECT_FALSE(example->doc.empty()) << name;
    EXPECT_FALSE(c.doc.empty()) << c.name;
    const bool uses =
        std::any_of(example->circuit.lsis.begin(), example->circuit.lsis.end(), [&](const Instance& i) { return i.type == c.name; });
    EXPECT_TRUE(uses) << name << " does not use it";
    const Result<void> checked = check_example(*example, signal_library(), name);
    EXPECT_TRUE(checked) << checked.error().text();
  }
  EXPECT_TRUE(files.empty()) << *files.begin() << " belongs to no LSI";
}

TEST(Examples, WrongExpectationIsReported) {
  const char* text =
      R"({"circuit": {"version": 2, "name": "t", "lsis": [{"id": "c", "type": "constant"}]}, "expect": [{"tick": 0, "pin": "c.out", "value": 1}, {"tick": 0, "pin": "no.out", "value": 1}]})";
  const Result<void> checked = check_example(*read_example(text, "t"), signal_library(), "t");
  ASSERT_FALSE(checked);
  EXPECT_NE(checked.error().text().find("t: expect/0: After tick 0 'c.out' is 0; expected 1."), std::string::npos)
      << checked.error().text();
  EXPECT_EQ(checked.error().problems.size(), 2u);
  EXPECT_FALSE(read_example("{}", "t"));
  EXPECT_FALSE(read_example(R"({"circuit": {"version": 2, "name": 3}, "expect": [{"tick": -1}]})", "t"));
}

}  // namespace
}  // namespace ugoki::circuit
