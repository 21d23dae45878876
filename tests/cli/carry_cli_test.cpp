// Native programs that carry libraries of LSIs: `ugoki export --native --carry-lsis`.

#include <sys/wait.h>

#include <filesystem>
#include <fstream>

#include "shelf_test.h"

namespace ugoki::cli {
namespace {

namespace fs = std::filesystem;

class CarryCliTest : public ShelfTest {
 protected:
  void SetUp() override {
    ShelfTest::SetUp();
    fs::create_directory(folder_ + "/parts");
    write("parts/player.html", R"(<html lang="en"><title>@UGOKI_TITLE@</title><script id="ugoki-engine"></script>@UGOKI_FIRST@@UGOKI_CONTENT@</html>)");
    fs::copy_file(UGOKI_NATIVE_PLAYER, folder_ + "/parts/ugoki_player");
    fs::copy_file(UGOKI_LSI_PLAYER, folder_ + "/parts/ugoki_lsi_player");
  }

  /// Builds and installs a library `poles` whose LSI `upright` balances the pole of examples/content/own-lsi.json.
  /// @param fault statement at the beginning of the LSI
  Json install(const std::string& fault = "") {
    const std::string source =
        write("poles.c",
              "#include <stdlib.h>\n#include <stdio.h>\nvoid upright(double x, double v, double angle, double rate, double* force) {\n" +
                  fault + "\n  *force = 59.1044 * x + 69.7556 * v + 442.0295 * angle + 123.4344 * rate;\n}\n");
    const Json built = json({"lsi", "build", source});
    return json({"lsi", "install", built["output"], "--hash", built["sha256"]});
  }
  /// A project in which the LSI `poles/upright` replaces the nested circuit of the content. @return its path
  std::string project() {
    std::ifstream file(UGOKI_EXAMPLES "/content/own-lsi.json");
    Json content = Json::parse(file);
    content["scenario"]["duration"] = 1;
    content["circuit"].erase("circuits");
    for (Json& lsi : content["circuit"]["lsis"])
      if (lsi["id"] == "balance") lsi["type"] = "poles/upright";
    const std::string path = folder_ + "/poles.ugoki";
    fs::remove(path);
    EXPECT_EQ(ugoki({"new", path, "--from", write("poles.json", content.dump())}).status, 0);
    return path;
  }
  std::vector<std::string> exporting(const std::string& form, const std::string& name) {
    return {"export", project(), "--player", folder_ + "/parts", form, folder_ + "/" + name};
  }
  /// Runs an exported program in a folder without a shelf.
  Output run_exported(const std::string& program, const std::string& arguments) const {
    const std::string out = folder_ + "/out.txt", err = folder_ + "/err.txt";
    const int status = std::system(("cd / && UGOKI_LSI=/nowhere " + program + " " + arguments + " > " + out + " 2> " + err).c_str());
    const auto text = [](const std::string& path) {
      std::ifstream in(path);
      return std::string(std::istreambuf_iterator<char>(in), {});
    };
    return {WEXITSTATUS(status), text(out), text(err)};
  }
};

TEST_F(CarryCliTest, ProgramsCarryLibrariesWithConsentOnly) {
  const Json library = install();
  std::vector<std::string> arguments = exporting("--native", "program");
  EXPECT_NE(fails(arguments, "of the library 'poles'").find("--carry-lsis"), std::string::npos);
  EXPECT_FALSE(fs::exists(folder_ + "/program"));
  arguments.emplace_back("--carry-lsis");
  const Output done = ugoki(arguments);
  ASSERT_EQ(done.status, 0) << done.err;
  EXPECT_NE(done.out.find(library["sha256"].get<std::string>()), std::string::npos) << done.out;
  const Json run = json({"run", project(), "--steps", "600"});
  const Output exported = run_exported(folder_ + "/program", "--headless --steps 600 --json");
  ASSERT_EQ(exported.status, 0) << exported.err;
  EXPECT_EQ(Json::parse(exported.out)["state_hash"], run["state_hash"]);
}

TEST_F(CarryCliTest, PagesCarryNoLibraries) {
  install();
  std::vector<std::string> arguments = exporting("--html", "page.html");
  arguments.emplace_back("--carry-lsis");
  fails(arguments, "Pages can use only");
}

// For pictures this program runs the content, so that they need no other LSIs. Without a browser the export ends after that check.
TEST_F(CarryCliTest, PicturesUseInstalledLibraries) {
  install();
  std::vector<std::string> arguments = exporting("--png", "picture.png");
  arguments.insert(arguments.end(), {"--browser", folder_ + "/no-browser"});
  EXPECT_EQ(fails(arguments, "no-browser").find("LSI"), std::string::npos);
}

TEST_F(CarryCliTest, ContentOfStandardLsisBecomesTheStaticProgram) {
  install();
  const std::string park = folder_ + "/park.ugoki", program = folder_ + "/program";
  ASSERT_EQ(ugoki({"new", park}).status, 0);
  ASSERT_EQ(ugoki({"export", park, "--player", folder_ + "/parts", "--native", program, "--carry-lsis"}).status, 0);
  EXPECT_LT(fs::file_size(program) - fs::file_size(UGOKI_NATIVE_PLAYER), 1'000'000u);
  EXPECT_EQ(run_exported(program, "--headless --steps 1").status, 0);
}

TEST_F(CarryCliTest, CrashOfAnLsiIsNamed) {
  install("printf(\"from the LSI\\n\"); if (x > -1) abort();");
  std::vector<std::string> arguments = exporting("--native", "program");
  arguments.emplace_back("--carry-lsis");
  ASSERT_EQ(ugoki(arguments).status, 0);
  const Output out = run_exported(folder_ + "/program", "--headless --steps 10");
  EXPECT_EQ(out.status, 1);
  EXPECT_TRUE(out.out.empty()) << out.out;
  EXPECT_NE(out.err.find("balance"), std::string::npos) << out.err;
  EXPECT_NE(out.err.find("SIGABRT"), std::string::npos) << out.err;
}

}  // namespace
}  // namespace ugoki::cli
