// Tests: outputs overwrite no input, output, project or library; devices are not read, pipes not replaced; printed names are escaped.
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <thread>

#include "cli_fixture.h"

namespace ugoki::cli {
namespace {

namespace fs = std::filesystem;

class OutputFilesCliTest : public CliTest {
 protected:
  std::string project() const {
    does({"new", path("z.ugoki")});
    return path("z.ugoki");
  }
  std::string executable(const std::string& project) const {
    does({"run", project, "--steps", "1", "--ugx", path("x.ugx")});
    return path("x.ugx");
  }
  std::string circuit(const std::string& name = "t") const {
    return write("c.json", Json{{"version", 1}, {"name", name}, {"lsis", Json::array()}}.dump());
  }
  /// True if no character of the text controls a terminal or the direction of text. Line feeds are allowed, because they end lines.
  static bool is_plain(const std::string& text) {
    for (std::size_t i = 0; i < text.size(); ++i) {
      const auto c = static_cast<unsigned char>(text[i]), next = static_cast<unsigned char>(i + 1 < text.size() ? text[i + 1] : 0);
      if ((c < 0x20 && c != '\n') || c == 0x7F || (c == 0xC2 && next < 0xA0)) return false;
    }
    return text.find("\u202e") == std::string::npos && text.find("\u2066") == std::string::npos && text.find("\nfake") == std::string::npos;
  }
};

TEST_F(OutputFilesCliTest, InputsAreNotOverwritten) {
  const std::string z = project(), x = executable(z), bvh = walk(), c = circuit();
  const std::string record = path("r.json"), source = write("ok.c", "double twice(double x) { return 2 * x; }\n"), body = path("m.json");
  does({"circuit", "run", c, "--duration", "0.01", "--record", record});
  does({"mechanism", "body", bvh, "-o", body});
  fs::create_symlink("z.ugoki", path("link"));
  fs::create_symlink(".", path("folder"));
  fs::create_hard_link(bvh, path("hard.bvh"));
  for (const std::vector<std::string>& arguments : {std::vector<std::string>{"export", z, "--ugx", z},
                                                    {"run", z, "--steps", "1", "--ugx", z},
                                                    {"run", z, "--steps", "1", "--ugx", path("link")},
                                                    {"run", z, "--steps", "1", "--ugx", path("folder/z.ugoki")},
                                                    {"run", x, "--steps", "1", "--frames", x},
                                                    {"bake", bvh, "--duration", "0.01", "--table", path("b.db"), "--csv", bvh},
                                                    {"bake", bvh, "--duration", "0.01", "--table", bvh},
                                                    {"circuit", "run", c, "--duration", "0.01", "--record", c},
                                                    {"circuit", "run", c, "--duration", "0.01", "--replay", record, "--record", record},
                                                    {"circuit", "run", c, "--duration", "0.01", "--lsi", x, "--record", x},
                                                    {"circuit", "export-fmu", c, c},
                                                    {"lsi", "build", source, "-o", source},
                                                    {"motion", "mirror", bvh, "-o", bvh},
                                                    {"motion", "mirror", bvh, "-o", path("hard.bvh")},
                                                    {"motion", "join", bvh, path("hard.bvh"), "-o", bvh},
                                                    {"retarget", bvh, "--height", "1.5", "-o", bvh},
                                                    {"retarget", bvh, "--to", body, "--mechanism-out", body},
                                                    {"mechanism", "mirror", body, "-o", body},
                                                    {"convert", bvh, bvh},
                                                    {"import", bvh, "--dry-run", "--bvh", bvh},
                                                    {"info", bvh, "--mapping-out", bvh}}) {
    SCOPED_TRACE(arguments[0] + " " + arguments[1]);
    fails(arguments, "would overwrite");
  }
}

TEST_F(OutputFilesCliTest, ProjectsAndLibrariesAreNotOverwritten) {
  const std::string z = project(), x = executable(z), bvh = walk();
  json({"import", bvh});
  for (const std::string& file : {z, library_}) {
    fails({"run", x, "--steps", "1", "--frames", file}, "would overwrite");
    fails({"export", x, "--duration", "0.01", "--csv", file}, "would overwrite");
    fails({"bake", bvh, "--duration", "0.01", "--table", file}, "would overwrite");
    fails({"circuit", "run", circuit(), "--duration", "0.01", "--record", file}, "would overwrite");
  }
  fails({"bake", bvh, "--duration", "0.01", "--table", write("text", "not a table")}, "");
}

TEST_F(OutputFilesCliTest, TwoOutputsHaveTwoFiles) {
  const std::string x = executable(project()), bvh = walk();
  const std::string same = path("o"), other = path("./o");
  for (const std::vector<std::string>& arguments : {std::vector<std::string>{"run", x, "--steps", "1", "--ugx", same, "--frames", other},
                                                    {"export", x, "--duration", "0.01", "--csv", same, "--glb", same},
                                                    {"bake", bvh, "--duration", "0.01", "--table", same, "--csv", other}}) {
    SCOPED_TRACE(arguments[0]);
    fails(arguments, "Two outputs have the same file");
    EXPECT_FALSE(fs::exists(same));
  }
}

TEST_F(OutputFilesCliTest, NumberedPicturesOverwriteNothing) {
  const std::string bvh = walk("f03.bvh"), parts = fs::path(write("parts/player.html", "")).parent_path();
  does({"new", path("p2.ugoki")});
  for (const auto& [pattern, more] : {std::pair<std::string, std::vector<std::string>>{"f%02d.bvh", {}},
                                      {"p%d.ugoki", {}},
                                      {"v%d.mp4", {"--mp4", path("v1.mp4")}},
                                      {"t%d.csv", {"--csv", path("./t4.csv")}}}) {
    SCOPED_TRACE(pattern);
    std::vector<std::string> arguments = {"export", bvh, "--player", parts, "--png", path(pattern)};
    arguments.insert(arguments.end(), more.begin(), more.end());
    fails(arguments, "would overwrite");
  }
}

TEST_F(OutputFilesCliTest, BakeReportsRunsWithoutResult) {
  const std::string bvh = walk();
  const auto bake = [&](const std::string& table, std::vector<std::string> more) {
    std::vector<std::string> all = {"bake", bvh, "--duration", "0.01", "--table", path(table)};
    all.insert(all.end(), more.begin(), more.end());
    return ugoki(all);
  };
  for (int i = 0; i < 2; ++i) {  // the second call finds all runs in the table
    const Output some = bake("some.db", {"--vary", "friction=0.5,-1"});
    EXPECT_EQ(some.status, 0) << some.err;
    EXPECT_NE(some.out.find("1 without result"), std::string::npos) << some.out;
    const Output none = bake("none.db", {"--vary", "friction=-1", "--vary", "tracking=1", "--random", "2"});
    EXPECT_EQ(none.status, 1);
    EXPECT_NE(none.err.find("No run has a result. The first: run 0, failed: "), std::string::npos) << none.err;
  }
  fails({"bake", bvh, "--duration", "0.01", "--table", path("t.db"), "--vary", "push-link=head"}, "No push acts on the link");
  fails({"bake", bvh, "--duration", "0.01", "--table", path("t.db"), "--vary", "push=0,100", "--vary", "push-link=head,zz"},
        "no link 'zz'");
  fails({"bake", bvh, "--duration", "0.01", "--table", path("t.db"), "--merge", "/dev/zero"}, "This is not a file");
}

TEST_F(OutputFilesCliTest, ScriptsOfSlurmOverwriteNothing) {
  const std::string bvh = walk();
  const auto bake = [&](const std::string& table) {
    return std::vector<std::string>{"bake", bvh, "--duration", "0.01", "--table", path(table), "--slurm", "2", "--dry-run"};
  };
  fails(bake("b.slurm"), "would overwrite");
  does(bake("b.db"));
  does(bake("b.db"));  // Ugoki's own scripts are replaced
  write("own.merge.slurm", "#!/bin/bash\n#SBATCH --job-name=mine\n");
  fails(bake("own.db"), "would overwrite");
}

TEST_F(OutputFilesCliTest, FilesThatTheInputUsesAreNotOverwritten) {
  const std::string robot =
      write("r.sdf", R"(<?xml version="1.0"?><sdf version="1.7"><model name="r"><link name="a"><inertial><mass>1</mass>
    <inertia><ixx>1</ixx><iyy>1</iyy><izz>1</izz></inertia></inertial><collision name="c"><geometry><mesh><uri>r_mesh1.obj</uri></mesh>
    </geometry></collision></link></model></sdf>)");
  write("r_mesh1.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n");
  fails({"convert", robot, path("r.urdf")}, "would overwrite");
  fails({"mechanism", "mirror", robot, "-o", path("r.urdf")}, "would overwrite");
  does({"convert", robot, path("other.urdf")});
  EXPECT_TRUE(fs::exists(path("other_mesh1.obj")));
}

TEST_F(OutputFilesCliTest, PageOfAFolderIsNotOverwrittenByEmbed) {
  const std::string parts = fs::path(write("parts/player.html", "")).parent_path(), bvh = walk();
  write("parts/ugoki-player.js", "");
  write("site/index.html", "<p>My page</p>");
  fails({"export", bvh, "--player", parts, "--embed", path("site")}, "would overwrite");
  does({"export", bvh, "--player", parts, "--embed", path("new")});
  does({"export", bvh, "--player", parts, "--embed", path("new")});
}

// Chromium opens the page of pictures in a window without tabs; the headless shell of Chromium has no windows and knows no option for that.
TEST_F(OutputFilesCliTest, PicturesAreDrawnInAWindowWithoutTabs) {
  const std::string page = R"(<html lang="en"><title>@UGOKI_TITLE@</title><script id="ugoki-engine"></script>@UGOKI_FIRST@@UGOKI_CONTENT@</html>)";
  const std::string parts = fs::path(write("parts/player.html", page)).parent_path(), bvh = walk();
  for (const auto& [name, begin] : {std::pair<std::string, std::string>{"chromium", "--app=file://"}, {"chromium-headless-shell", "file://"}}) {
    const std::string browser = write(name, "#!/bin/sh\nfor word; do last=$word; done\necho \"$last\" >\"$0.word\"\n"), word = browser + ".word";
    fs::permissions(browser, fs::perms::owner_all);
    const Output out = ugoki({"export", bvh, "--player", parts, "--png", path("p.png"), "--browser", browser});
    EXPECT_NE(out.err.find("The browser ended before all pictures were drawn."), std::string::npos) << out.err;
    EXPECT_TRUE(read(word).starts_with(begin)) << name << ": " << read(word);
  }
}

TEST_F(OutputFilesCliTest, NamesOfNativeProgramsDoNotActOnTheTerminal) {
  const std::string bvh = walk("evil\x1b[31m\u202e.bvh"), program = path("program");
  const std::string page = R"(<html lang="en"><title>@UGOKI_TITLE@</title><script id="ugoki-engine"></script>@UGOKI_FIRST@@UGOKI_CONTENT@</html>)";
  const fs::path parts = fs::path(write("parts/player.html", page)).parent_path();
  fs::copy_file(UGOKI_NATIVE_PLAYER, parts / "ugoki_player");
  does({"export", bvh, "--player", parts.string(), "--native", program});
  for (const std::string more : {"--steps 1", "--steps 1 --json", "--steps 1 --inputs $'no\x1b[31m'", "$'--no\x1b[31m'"}) {
    const std::string out = path("out.txt");
    (void)std::system(("bash -c \"" + program + " --headless " + more + "\" > " + out + " 2>&1").c_str());
    const std::string text = read(out);
    EXPECT_FALSE(text.empty()) << more;
    EXPECT_TRUE(is_plain(text)) << more << "\n" << Json(text).dump();
  }
}

TEST_F(OutputFilesCliTest, TablesOfSweepsAreContinued) {
  const std::vector<std::string> bake = {"bake", walk(), "--duration", "0.01", "--table", path("b.db"), "--csv", path("b.csv")};
  does(bake);
  const std::string table = read(path("b.csv"));
  EXPECT_EQ(json(bake)["added"], 0);
  EXPECT_EQ(read(path("b.csv")), table);
}

TEST_F(OutputFilesCliTest, MotionAndSkeletonAreWrittenTogetherOrNotAtAll) {
  const std::string bvh = walk("real.bvh"), skeleton = write("d.asf", "precious");
  fs::create_directory(path("d.amc"));
  fails({"convert", bvh, path("d.amc")}, "folder");
  EXPECT_EQ(read(skeleton), "precious");
  for (const auto& entry : fs::directory_iterator(folder_)) EXPECT_NE(entry.path().filename().string().substr(0, 6), ".ugoki");
}

TEST_F(OutputFilesCliTest, NotANumberIsOutOfEveryRange) {
  const std::string bvh = walk("real.bvh");
  for (const std::vector<std::string>& arguments : std::vector<std::vector<std::string>>{
           {"run", bvh, "--duration", "nan"}, {"run", bvh, "--assist-limit", "-NaN"}, {"import", bvh, "--height", "nan(3)"}})
    EXPECT_EQ(ugoki(arguments).status, 2) << arguments[2];
}

TEST_F(OutputFilesCliTest, DevicesAreNotReadAndPipesStay) {
  for (const char* verb : {"info", "run", "judge"}) fails({verb, "/dev/zero"}, "device");
  fs::create_symlink("/dev/zero", path("walk.bvh"));
  fails({"info", path("walk.bvh")}, "device");
  fails({"circuit", "check", "/dev/zero"}, "device");
  fails({"import", path("walk.bvh")}, "device");
  const std::string pipe = path("pipe.csv"), bvh = walk("real.bvh");
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  write("scene.gltf", R"({"asset": {"version": "2.0"}, "buffers": [{"uri": "pipe.csv", "byteLength": 100}], "nodes": [{"name": "a"}]})");
  fails({"info", path("scene.gltf")}, "pipe");  // a pipe that nobody writes into would be waited for without end
  std::string got;
  std::thread reader([&] { got = read(pipe); });
  const int writer = ::open(pipe.c_str(), O_WRONLY | O_CLOEXEC);  // lets the reader thread end even if the program replaces the pipe
  does({"convert", bvh, pipe});
  ::close(writer);
  reader.join();
  EXPECT_TRUE(fs::is_fifo(pipe));
  does({"convert", bvh, path("file.csv")});
  EXPECT_TRUE(got == read(path("file.csv")));
}

TEST_F(OutputFilesCliTest, NamesDoNotActOnTheTerminal) {
  const std::string evil = "\x1b]0;title\a\x1b[2J\x7f\u009b31m\u202e\u2066\nfake: line";
  const std::string c = circuit(evil);
  const std::string bvh = [&] {
    std::string text = read(walk());
    const std::size_t at = text.find("JOINT ") + 6;
    return write("evil.bvh", text.insert(at, "x\x1b[31m\u009b\u202e"));
  }();
  const std::string odd_file = write("odd\x1b[31m\u202e.json", "{");
  const std::string example = write("e.test.json", Json{{"name", evil}, {"circuit", {{evil, 1}}}, {evil, 3}}.dump());
  const std::string record = write("r.json", Json{{"version", 1}, {evil, evil}}.dump());
  const std::string unknown =
      write("u.json", Json{{"version", 1}, {"name", "t"}, {"lsis", Json::array({{{"id", evil}, {"type", evil}}})}}.dump());
  json({"import", walk("import.bvh"), "--name", "walk\u202e\u009b31m"});
  for (const std::vector<std::string>& arguments : {std::vector<std::string>{"circuit", "run", c, "--duration", "0.01"},
                                                    {"circuit", "run", c, "--duration", "0.01", "--replay", record},
                                                    {"circuit", "run", unknown, "--duration", "0.01"},
                                                    {"circuit", "check", unknown, odd_file},
                                                    {"circuit", "test", example},
                                                    {"info", bvh},
                                                    {"info", bvh, "--json"},
                                                    {"import", bvh, "--dry-run"},
                                                    {"run", bvh, "--steps", "1"},
                                                    {"run", "no" + evil},
                                                    {"run", "--no" + evil},
                                                    {"run", c, "--no", evil},
                                                    {"db", "list"},
                                                    {"db", "list", "--json"},
                                                    {"lsi", "build", write("l.c", "double f(double x) { return x; }\n"), "--name", evil}}) {
    const Output o = ugoki(arguments);
    EXPECT_TRUE(is_plain(o.out)) << arguments[0] << " " << arguments[1] << "\n" << Json(o.out).dump();
    EXPECT_TRUE(is_plain(o.err)) << arguments[0] << " " << arguments[1] << "\n" << Json(o.err).dump();
    EXPECT_FALSE(o.out.empty() && o.err.empty());
  }
  EXPECT_NE(ugoki({"circuit", "run", c, "--duration", "0.01"}).out.find("\\x1b]0;title\\x07"), std::string::npos);
  EXPECT_EQ(json({"db", "list"})["entries"][0]["name"].get<std::string>().find("\\u"), std::string::npos) << "JSON is unescaped once";
}

TEST_F(OutputFilesCliTest, NamesOfEntriesHaveAMaximumLength) {
  const std::string bvh = walk(), too_long(201, 'n');
  fails({"import", bvh, "--name", too_long}, "at most 200");
  const std::string id = json({"import", bvh})["files"][0]["ids"]["motion"];
  fails({"db", "rename", id, too_long}, "at most 200");
  fails({"motion", "mirror", bvh, "-o", too_long}, "at most 200");
}

}  // namespace
}  // namespace ugoki::cli
