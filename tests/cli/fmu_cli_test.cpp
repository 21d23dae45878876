// FMUs on the command line: export, info, installation by consent, runs in a guarded process, and reports of misbehaving FMUs.

#include <sstream>

#include "shelf_test.h"
#include "ugoki/fmi/archive.h"

namespace ugoki::cli {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

class FmuCliTest : public ShelfTest {
 protected:
  static std::string read(const std::string& path) {
    std::ifstream in(path, std::ios::binary);
    std::ostringstream out;
    out << in.rdbuf();
    return out.str();
  }
  std::string naughty(int version) const {
    const std::string number = std::to_string(version);
    const auto bytes = fmi::write_archive(
        {{"modelDescription.xml", read(std::string(UGOKI_SOURCE_DIR) + "/tests/fmi/units/naughty.fmi" + number + ".xml")},
         {version == 2 ? "binaries/linux64/naughty.so" : "binaries/x86_64-linux/naughty.so",
          read(std::string(UGOKI_UNITS) + "/ugoki_unit_naughty_" + number + ".so")}},
        "naughty");
    EXPECT_TRUE(bytes);
    return write("naughty" + number + ".fmu", *bytes);
  }
};

constexpr const char* oscillator = R"({"version": 1, "name": "oscillator",
  "inputs": [{"name": "push", "type": "scalar", "to": "sum.b"}], "outputs": [{"name": "x", "type": "scalar", "unit": "m", "from": "x.out"}],
  "parameters": [{"name": "stiffness", "to": "pull.gain"}],
  "lsis": [{"id": "x", "type": "integrator", "parameters": {"initial": 1}}, {"id": "v", "type": "integrator"}, {"id": "pull", "type": "gain", "parameters": {"gain": -4}}, {"id": "sum", "type": "add"}],
  "wires": [{"from": "v.out", "to": "x.in"}, {"from": "x.out", "to": "pull.in"}, {"from": "pull.out", "to": "sum.a"}, {"from": "sum.out", "to": "v.in"}]})";

TEST_F(FmuCliTest, FmuIsExportedInstalledRunAndRemoved) {
  const std::string circuit = write("oscillator.json", oscillator);
  const std::string user = write("user.json", R"({"version": 1, "name": "user", "outputs": [{"name": "y", "type": "scalar", "from": "u.x"}],
      "lsis": [{"id": "u", "type": "oscillator/oscillator", "parameters": {"stiffness": -9}}]})");
  for (const char* version : {"2", "3"}) {
    const std::string fmu = folder_ + "/oscillator.fmu";
    const Json made = json({"circuit", "export-fmu", circuit, fmu, "--fmi", version, "--dt", "0.01"});
    EXPECT_EQ(made["inputs"], Json({"push"}));
    EXPECT_EQ(made["outputs"], Json({"x"}));
    EXPECT_EQ(made["parameters"], Json({"stiffness"}));

    const Json info = json({"info", fmu});
    EXPECT_EQ(info["fmi"], std::string(version) + ".0");
    EXPECT_EQ(info["runs_here"], true);
    EXPECT_EQ(info["variables"].size(), 3u);
    EXPECT_NE(ugoki({"info", fmu}).out.find("oscillator"), std::string::npos);

    EXPECT_NE(fails({"circuit", "run", user}).find("the library is not installed"), std::string::npos);
    EXPECT_NE(fails({"lsi", "install", fmu}).find("needs your consent"), std::string::npos);
    EXPECT_NE(fails({"lsi", "install", fmu, "--hash", std::string(64, '0')}).find("not the one given with --hash"), std::string::npos);
    const Json installed = json({"lsi", "install", fmu, "--yes"});
    EXPECT_EQ(installed["name"], "oscillator");
    fs::remove(fmu);
    EXPECT_EQ(json({"lsi", "list"})["libraries"].size(), 1u);

    const Json ran = json({"circuit", "run", user, "--dt", "0.01", "--duration", "1"});
    const Json own = json({"circuit", "run", circuit, "--dt", "0.01", "--duration", "1", "--set", "pull.gain=-9"});
    EXPECT_EQ(ran["outputs"]["y"], own["outputs"]["x"]);

    // An installed library that has changed since the user's consent is refused.
    for (const auto& e : fs::directory_iterator(folder_ + "/shelf"))
      if (e.path().extension() == ".fmu") {
        std::ofstream(e.path(), std::ios::binary | std::ios::app) << "x";
        EXPECT_NE(ugoki({"circuit", "run", user}).err.find("has changed since it was installed"), std::string::npos);
      }
    EXPECT_EQ(ugoki({"lsi", "remove", "oscillator"}).status, 0);
    EXPECT_EQ(json({"lsi", "list"})["libraries"].size(), 0u);
    EXPECT_TRUE(fs::is_empty(folder_ + "/shelf"));
  }
}

/// A circuit with the free fall of the sample content's ball, without contacts, and the root height of the mirrored reference motion.
constexpr const char* falling = R"({"version": 1, "name": "falling",
  "outputs": [{"name": "z", "type": "scalar", "from": "xyz.z"}, {"name": "height", "type": "scalar", "from": "root.out"}],
  "lsis": [{"id": "now", "type": "status"}, {"id": "fall", "type": "link dynamics", "parameters": {"character": "ball"}},
           {"id": "ball", "type": "link pose", "parameters": {"character": "ball"}}, {"id": "parts", "type": "split pose"}, {"id": "xyz", "type": "split vector"},
           {"id": "mirror", "type": "motion mirror", "parameters": {"character": "human"}},
           {"id": "q", "type": "split reference", "parameters": {"character": "human"}}, {"id": "root", "type": "joint value", "parameters": {"index": 2}}],
  "wires": [{"from": "now.state", "to": "fall.state"}, {"from": "fall.next", "to": "now.next"}, {"from": "fall.next", "to": "ball.state"},
            {"from": "ball.pose", "to": "parts.in"}, {"from": "parts.position", "to": "xyz.in"}, {"from": "mirror.reference", "to": "q.reference"},
            {"from": "q.q", "to": "root.in"}]})";

TEST_F(FmuCliTest, ExportedFmuContainsContentOfItsCircuit) {
  const std::string circuit = write("falling.json", falling), park = folder_ + "/park.ugoki", content = folder_ + "/park.ugx";
  ASSERT_EQ(ugoki({"new", park}).status, 0);
  ASSERT_EQ(ugoki({"run", park, "--ugx", content, "--duration", "0.1"}).status, 0);
  EXPECT_NE(fails({"circuit", "export-fmu", circuit, folder_ + "/x.fmu"}).find("--content FILE.ugx"), std::string::npos);
  EXPECT_NE(fails({"circuit", "export-fmu", circuit, folder_ + "/x.fmu", "--content", circuit}).find("falling.json"), std::string::npos);
  const std::string fmu = folder_ + "/falling.fmu";
  const std::string user = write("user.json", R"({"version": 1, "name": "user", "outputs": [{"name": "z", "type": "scalar", "from": "u.z"},
      {"name": "height", "type": "scalar", "from": "u.height"}], "lsis": [{"id": "u", "type": "falling/falling"}]})");
  for (const char* version : {"2", "3"}) {
    const Json made = json({"circuit", "export-fmu", circuit, fmu, "--fmi", version, "--content", content});
    EXPECT_EQ(made["step_s"], 0.002) << "the step should be the content's";
    json({"lsi", "install", fmu, "--yes"});
    const auto at = [&](const char* time) { return json({"circuit", "run", user, "--dt", "0.002", "--duration", time})["outputs"]; };
    const Json a = at("0.1"), b = at("0.2"), c = at("0.3");
    const auto z = [](const Json& j) { return j["z"].get<double>(); };
    EXPECT_NEAR(z(a) - 2 * z(b) + z(c), -9.81 * 0.1 * 0.1, 1e-9) << "the ball should fall freely";
    EXPECT_GT(a["height"], 0.7);
    EXPECT_LT(a["height"], 1.2);
    EXPECT_NE(a["height"], b["height"]);
    EXPECT_EQ(ugoki({"lsi", "remove", "falling"}).status, 0);
  }
}

TEST_F(FmuCliTest, CrashingHangingOrFailingFmuIsReported) {
  for (const int version : {2, 3}) {
    const std::string fmu = naughty(version);
    const auto run = [&](int deed) {
      const std::string circuit =
          write("deed.json", R"({"version": 1, "name": "deed", "lsis": [{"id": "culprit", "type": "naughty", "values": {"deed": )" +
                                 std::to_string(deed) + "}}]}");
      return fails({"circuit", "run", circuit, "--lsi", fmu, "--dt", "0.1", "--patience", "0.6"});
    };
    EXPECT_NE(run(1).find("'culprit' (LSI 'naughty/naughty' of library 'naughty') used a null pointer (SIGSEGV) at 0.000 s (tick 0)"),
              std::string::npos);
    EXPECT_NE(run(2).find("'culprit' (LSI 'naughty/naughty' of library 'naughty') did not return within 0.6 s"), std::string::npos);
    EXPECT_NE(run(7).find("divided an integer by zero"), std::string::npos);
    EXPECT_NE(run(3).find("of its output 'out' is not finite"), std::string::npos);
    const std::string error = run(4);
    EXPECT_NE(error.find("The FMU reports an error in its step: The gear is broken"), std::string::npos) << error;
    EXPECT_NE(error.find("'culprit' reports: error: The gear is broken"), std::string::npos) << error;
  }
}

TEST_F(FmuCliTest, InvalidFmusAreRefusedWithReason) {
  EXPECT_NE(fails({"info", write("a.fmu", "no zip")}).find("is not a zip"), std::string::npos);
  EXPECT_NE(fails({"lsi", "install", write("b.fmu", "PK\x03\x04 and rubbish"), "--yes"}).find("not a zip, or is truncated or damaged"),
            std::string::npos);
  const auto bytes = fmi::write_archive({{"readme.txt", "x"}}, "x");
  ASSERT_TRUE(bytes);
  EXPECT_NE(fails({"lsi", "install", write("c.fmu", *bytes), "--yes"}).find("no modelDescription.xml"), std::string::npos);
  const std::string circuit = write(
      "loop.json",
      R"({"version": 1, "name": "x", "outputs": [{"name": "y", "type": "scalar", "from": "a.out"}], "lsis": [{"id": "a", "type": "gain"}]})");
  EXPECT_NE(fails({"circuit", "export-fmu", circuit, folder_ + "/x.fmu"}).find("Nothing is wired to 'a.in'"), std::string::npos);
  EXPECT_FALSE(fs::exists(folder_ + "/x.fmu"));
}

}  // namespace
}  // namespace ugoki::cli
