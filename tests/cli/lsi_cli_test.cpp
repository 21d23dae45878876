// `ugoki lsi` and `ugoki circuit` on the command line.

#include <pty.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <cstring>
#include <sstream>

#include "shelf_test.h"

namespace ugoki::cli {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

class LsiCliTest : public ShelfTest {
 protected:
  /// Runs the program on a pseudo-terminal and types `typed`. @return its exit status and output; `out` has both stdout and stderr
  Output on_terminal(const std::vector<std::string>& arguments, const std::string& typed) const {
    Output output;
    int terminal = -1;
    const pid_t child = ::forkpty(&terminal, nullptr, nullptr, nullptr);
    if (child == 0) {
      ::setenv("UGOKI_LSI", (folder_ + "/shelf").c_str(), 1);
      std::vector<char*> argv = {const_cast<char*>(UGOKI_PROGRAM)};
      for (const std::string& a : arguments) argv.push_back(const_cast<char*>(a.c_str()));
      argv.push_back(nullptr);
      ::execv(UGOKI_PROGRAM, argv.data());
      ::_exit(126);
    }
    EXPECT_EQ(::write(terminal, typed.data(), typed.size()), static_cast<ssize_t>(typed.size()));
    char buffer[1024];
    for (ssize_t n; (n = ::read(terminal, buffer, sizeof buffer)) > 0;) output.out.append(buffer, static_cast<std::size_t>(n));
    ::close(terminal);
    output.status = wait_for(child);
    return output;
  }
  /// A library whose constructor writes the file marker().
  std::string evil() const {
    const std::string source =
        write("evil.c", "#include <stdio.h>\n__attribute__((constructor)) static void early(void) { FILE* f = fopen(\"" + marker() +
                            "\", \"w\"); if (f) fclose(f); }\ndouble f(double x) { return x; }\n");
    const std::string library = json({"lsi", "build", source})["output"];
    fs::remove(marker());  // a build also loads the built library, which writes the marker
    return library;
  }
  [[nodiscard]] std::string marker() const { return folder_ + "/marker"; }
  /// A circuit with the LSI `it` of the given type, whose input x is 1.
  std::string circuit_of(const std::string& type) const {
    return write("c.json", R"({"version": 1, "name": "t", "lsis": [{"id": "it", "type": ")" + type + R"(", "values": {"x": 1}}]})");
  }
};

TEST_F(LsiCliTest, NewLibraryBuildsAndPassesItsTest) {
  for (const char* language : {"", "--cpp"}) {
    const std::string path = folder_ + "/spring" + (*language ? "2" : "");
    std::vector<std::string> arguments = {"lsi", "new", path};
    if (*language) arguments.emplace_back(language);
    EXPECT_EQ(ugoki(arguments).status, 0);
    const Output tested = ugoki({"lsi", "test", path});
    EXPECT_EQ(tested.status, 0) << tested.err;
    EXPECT_NE(tested.out.find("passed"), std::string::npos);
    fails({"lsi", "new", path}, "already");
  }
  // A fault in the source must make the template's test fail.
  std::string source;
  {
    std::ifstream in(folder_ + "/spring/spring.c");
    source.assign(std::istreambuf_iterator<char>(in), {});
  }
  const auto at = source.find("-stiffness * x");
  ASSERT_NE(at, std::string::npos);
  write("spring/spring.c", source.replace(at, 1, "+"));
  fails({"lsi", "test", folder_ + "/spring"}, "expected");
  fails({"lsi", "new", folder_ + "/no name"}, "cannot be the name");
}

TEST_F(LsiCliTest, LibraryIsBuiltInstalledRunAndRemoved) {
  const std::string source = write("three.c",
                                   "/// Doubles.\n/// @in x [m]\ndouble twice(double x) { return 2 * x; }\ndouble plus(double a, double b) "
                                   "{ return a + b; }\nvoid half(double x, double* y) { *y = x / 2; }\n");
  const Json built = json({"lsi", "build", source});
  ASSERT_EQ(built["classes"].size(), 3u);
  EXPECT_EQ(built["classes"][2]["inputs"][0]["unit"], "m");
  const std::string library = built["output"];
  const std::string circuit =
      write("c.json",
            R"({"version": 1, "name": "t", "lsis": [{"id": "t", "type": "three/twice", "values": {"x": 3}}, {"id": "h", "type": "half"}],
    "wires": [{"from": "t.out", "to": "h.x"}]})");
  fails({"circuit", "run", circuit}, "the library is not installed");
  fails({"lsi", "install", library}, "consent");
  fails({"lsi", "install", library, "--hash", std::string(64, '0')}, "SHA-256");
  const Json installed = json({"lsi", "install", library, "--hash", built["sha256"]});
  EXPECT_EQ(installed["name"], "three");
  EXPECT_EQ(json({"lsi", "list"})["libraries"].size(), 1u);
  const Json ran = json({"circuit", "run", circuit, "--duration", "0.01", "--dt", "0.001", "--probe", "h.y", "--threads", "2"});
  EXPECT_EQ(ran["outputs"]["h.y"], 3);
  EXPECT_EQ(ran["ticks"], 10);
  EXPECT_EQ(ran["probes"]["values"].size(), 10u);
  EXPECT_EQ(ugoki({"circuit", "check", circuit}).status, 0);
  EXPECT_EQ(ugoki({"lsi", "remove", "three"}).status, 0);
  fails({"circuit", "check", circuit}, "is missing");
  fails({"lsi", "remove", "three"}, "No library");
}

TEST_F(LsiCliTest, CheckReportsErrorsOfSeveralCircuitsWithTheirFiles) {
  const std::string first = write("first.json", R"({"version": 1, "name": "t", "lsis": [{"id": "a", "type": "gain"}]})");
  const std::string second = write("second.json", "{\n");
  const Output out = ugoki({"circuit", "check", first, second, "--json"});
  EXPECT_EQ(out.status, 1);
  const Json answer = Json::parse(out.out, nullptr, false);
  ASSERT_FALSE(answer.is_discarded()) << out.out;
  const Json& problems = answer["error"]["problems"];
  ASSERT_EQ(problems.size(), 2u) << out.out;
  EXPECT_EQ(problems[0]["location"], first + ":/lsis/0");
  EXPECT_EQ(problems[1]["location"], second + ":2:1");
}

TEST_F(LsiCliTest, CrashHangAndWrongInterfaceVersionAreReported) {
  const std::string library =
      json({"lsi", "build",
            write("bad.c",
                  "int quotient(int a, int b) { return a / b; }\ndouble slow(double x) { for (;;) __asm__ volatile(\"\"); return x; }\n")})
          ["output"];
  const auto circuit = [&](const std::string& type, const std::string& values) {
    return write("c.json", R"({"version": 1, "name": "t", "lsis": [{"id": "it", "type": ")" + type + R"(", "values": )" + values + "}]}");
  };
  fails({"circuit", "run", circuit("bad/quotient", R"({"a": 1, "b": 0})"), "--lsi", library},
        "'it' (LSI 'bad/quotient' of library 'bad') divided an integer by zero at 0.000 s (tick 0). Its inputs were 'a' = 1, 'b' = 0.");
  fails({"circuit", "run", circuit("bad/slow", R"({"x": 1})"), "--lsi", library, "--patience", "0.4"}, "did not return within 0.4 s");
  const std::string later = write("later.c",
                                  "#include <ugoki/lsi.h>\nstatic const ugoki_library l = {sizeof l, 9, \"l\", 0, 0, 0, 0, 0};\nconst "
                                  "ugoki_library* ugoki_lsi_library(void) { return &l; }\n");
  fails({"lsi", "build", later}, "version 9 of the LSI interface");
  fails({"lsi", "build", write("e.c", "double f(double x) {\n  return x +;\n}\n")}, "e.c:2:");
}

TEST_F(LsiCliTest, RunStopsAtBreakpointAndReplaysItsRecord) {
  const std::string circuit = write(
      "c.json",
      R"({"version": 1, "name": "t", "inputs": [{"name": "x", "type": "scalar", "to": "i.in"}], "outputs": [{"name": "y", "type": "scalar", "from": "i.out"}],
    "lsis": [{"id": "i", "type": "integrator"}]})");
  const Json stopped =
      json({"circuit", "run", circuit, "--input", "x=2", "--break", "i.out > 1", "--timing", "--record", folder_ + "/r.json"});
  EXPECT_EQ(stopped["breakpoint"]["condition"], "i.out > 1");
  EXPECT_NEAR(stopped["time_s"], 0.502, 0.0021);
  EXPECT_EQ(stopped["timing"].size(), 1u);
  const Json replayed = json({"circuit", "run", circuit, "--replay", folder_ + "/r.json", "--duration", stopped["time_s"].dump()});
  EXPECT_EQ(replayed["outputs"]["y"], stopped["outputs"]["y"]);
  fails({"circuit", "run", circuit, "--break", "i.out ~ 3"}, "not a condition");
  fails({"circuit", "run", circuit, "--probe", "i.no"}, "has no output 'i.no'");
}

TEST_F(LsiCliTest, NothingOfALibraryRunsBeforeConsent) {
  const std::string library = evil();
  fails({"lsi", "install", library}, "needs your consent");
  EXPECT_FALSE(fs::exists(marker()));
  fails({"lsi", "install", library, "--hash", std::string(64, '0')}, "not the one given with --hash");
  EXPECT_FALSE(fs::exists(marker()));
  for (const char* typed : {"n\n", "\n", "\x04"}) {  // \x04 (Ctrl+D) ends the input
    const Output refused = on_terminal({"lsi", "install", library}, typed);
    EXPECT_EQ(refused.status, 1);
    EXPECT_NE(refused.out.find("The library 'evil' with the LSI 'f' is a program that runs with all your rights."), std::string::npos)
        << refused.out;
    EXPECT_NE(refused.out.find("consent was refused"), std::string::npos) << refused.out;
    EXPECT_FALSE(fs::exists(marker())) << typed;
  }
  EXPECT_EQ(json({"lsi", "list"})["libraries"].size(), 0u);
  const Output accepted = on_terminal({"lsi", "install", library}, "y\n");
  EXPECT_EQ(accepted.status, 0) << accepted.out;
  EXPECT_TRUE(fs::exists(marker()));
  EXPECT_EQ(json({"lsi", "list"})["libraries"].size(), 1u);
}

TEST_F(LsiCliTest, NothingOfALibraryIsMappedBeforeConsent) {
  if (std::system("strace -o /dev/null true 2> /dev/null") != 0) GTEST_SKIP() << "strace cannot be used here (apt-get install strace)";
  const std::string library = evil(), log = folder_ + "/calls";
  // strace prints file descriptors with their paths (-y), so that a mapping of the library shows the library's name. The program loads a
  // copy of the library; the copy's path contains this name too.
  const auto mappings = [&](const std::string& arguments, const char* answer) {
    const std::string command = "printf '" + std::string(answer) + "' | UGOKI_LSI=" + folder_ +
                                "/shelf strace -f -y -e trace=openat,mmap,execve -o " + log +
                                " script -qec '" UGOKI_PROGRAM " lsi install " + library + arguments + "' /dev/null > /dev/null 2>&1";
    (void)std::system(command.c_str());
    std::ifstream in(log);
    int opened = 0, mapped = 0, processes = 0;
    for (std::string line; std::getline(in, line);) {
      const bool names = line.find("evil.so") != std::string::npos;
      opened += names && line.find("openat(") != std::string::npos;
      mapped += names && line.find("mmap(") != std::string::npos;
      processes += line.find("execve(") != std::string::npos && line.find("describe") != std::string::npos;
    }
    EXPECT_GT(opened, 0) << "the file is read for its hash";
    return std::pair(mapped, processes);
  };
  const std::pair<int, int> none;
  EXPECT_EQ(mappings("", "n\\n"), none);
  EXPECT_EQ(mappings("", ""), none);
  EXPECT_EQ(mappings(" --hash " + std::string(64, '0'), "y\\n"), none);
  const auto [mapped, processes] = mappings("", "y\\n");
  EXPECT_GT(mapped, 0) << "the check must see the mapping after consent";
  EXPECT_GT(processes, 0);
}

TEST_F(LsiCliTest, LibraryThatEndsItsProcessWhileLoadingIsNotInstalled) {
  const std::string source = write("quits.c",
                                   "#include <stdlib.h>\n#include <unistd.h>\n__attribute__((constructor)) static void early(void) { if "
                                   "(!getenv(\"UGOKI_STAY\")) _exit(0); }\ndouble f(double x) { return x; }\n");
  ::setenv("UGOKI_STAY", "1", 1);
  const std::string library = json({"lsi", "build", source})["output"];
  ::unsetenv("UGOKI_STAY");
  fails({"lsi", "install", library, "--yes"}, "quits.so' was being loaded when it ended its process (exit status 0) without a report.");
  EXPECT_EQ(json({"lsi", "list"})["libraries"].size(), 0u);
}

TEST_F(LsiCliTest, EndOfTheProcessIsNotSuccess) {
  fs::create_directory(folder_ + "/quits");
  write("quits/quits.c", "#include <unistd.h>\ndouble quits(double x) { _exit(0); return x; }\n");
  write(
      "quits/quits.test.json",
      R"({"doc": "", "dt": 0.01, "circuit": {"version": 1, "name": "t", "lsis": [{"id": "it", "type": "quits/quits", "values": {"x": 1}}]},
            "given": [], "expect": [{"tick": 0, "pin": "it.out", "value": 5}]})");
  const std::string named = "'it' (LSI 'quits/quits' of library 'quits') ended its process (exit status 0) without a report.";
  fails({"lsi", "test", folder_ + "/quits"}, named);
  fails({"circuit", "test", folder_ + "/quits/quits.test.json", "--lsi", folder_ + "/quits/quits.so"}, named);
  fails({"circuit", "run", circuit_of("quits/quits"), "--lsi", folder_ + "/quits/quits.so"}, named);
}

TEST_F(LsiCliTest, TextOfAnLsiDoesNotMixWithJson) {
  const std::string source =
      write("talks.c",
            "#include <stdio.h>\n__attribute__((constructor)) static void early(void) { printf(\"{loading}\\n\"); }\n"
            "double f(double x) { printf(\"{running}\\n\"); return 2 * x; }\n");
  const std::string library = json({"lsi", "build", source})["output"];
  json({"lsi", "install", library, "--yes"});
  const Output ran = ugoki({"circuit", "run", circuit_of("talks/f"), "--duration", "0.004", "--json"});
  EXPECT_EQ(ran.status, 0) << ran.err;
  const Json answer = Json::parse(ran.out, nullptr, false);
  ASSERT_FALSE(answer.is_discarded()) << ran.out;
  EXPECT_EQ(answer["outputs"]["it.out"], 2);
  EXPECT_NE(ran.err.find("{running}"), std::string::npos);
}

TEST_F(LsiCliTest, NamesThatBeginWithAHyphenAreNotOptions) {
  const std::string source = write("-o.c", "double f(double x) { return x; }\n"), before = fs::current_path();
  fs::current_path(folder_);
  const Output built = ugoki({"lsi", "build", "--", "-o.c"});
  fs::current_path(before);
  EXPECT_EQ(built.status, 0) << built.err;
}

TEST_F(LsiCliTest, ReplacedLibraryIsNamedBeforeConsent) {
  const auto build = [&](const std::string& file, const std::string& body) {
    return json({"lsi", "build", write(file, "double f(double x) { return " + body + "; }\n"), "--name", "same"})["output"]
        .get<std::string>();
  };
  const std::string first = build("a.c", "x"), second = build("b.c", "-x");
  json({"lsi", "install", first, "--yes"});
  fails({"lsi", "install", second}, "It replaces the installed library 'same' with the SHA-256 ");
  const Output again = ugoki({"lsi", "install", first, "--yes"});
  EXPECT_EQ(again.status, 0);
  EXPECT_EQ(again.err.find("replaces"), std::string::npos) << "it is the same file";
}

TEST_F(LsiCliTest, ListMarksChangedAndMissingCopies) {
  for (const char* name : {"good", "changed", "missing"}) {
    const Json built = json({"lsi", "build", write(std::string(name) + ".c", "double f(double x) { return x; }\n")});
    json({"lsi", "install", built["output"], "--yes"});
  }
  for (const auto& file : fs::directory_iterator(folder_ + "/shelf")) {
    const std::string name = file.path().filename().string();
    if (name.starts_with("changed-")) std::ofstream(file.path(), std::ios::app) << "x";
    if (name.starts_with("missing-")) fs::remove(file.path());
  }
  const Output listed = ugoki({"lsi", "list"});
  EXPECT_EQ(listed.status, 0);
  EXPECT_NE(listed.err.find("The file has changed since it was installed"), std::string::npos) << listed.err;
  EXPECT_NE(listed.err.find("The file does not exist"), std::string::npos) << listed.err;
  std::istringstream lines(listed.out);
  int marked = 0;
  for (std::string line; std::getline(lines, line);) {
    if (line.find("SHA-256") == std::string::npos) continue;
    const bool mark = line.find("missing or changed") != std::string::npos;
    EXPECT_EQ(mark, !line.starts_with("good")) << line;
    marked += mark;
  }
  EXPECT_EQ(marked, 2) << listed.out;
  const Output as_json = ugoki({"lsi", "list", "--json"});
  for (const Json& library : Json::parse(as_json.out)["libraries"]) EXPECT_EQ(library["intact"], library["name"] == "good");
}

TEST_F(LsiCliTest, PipesOnTheShelfAreReportedAndNotWaitedFor) {
  const Json built = json({"lsi", "build", write("good.c", "double f(double x) { return x; }\n")});
  json({"lsi", "install", built["output"], "--yes"});
  const std::string pipe = folder_ + "/shelf/pipe.json";
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  const Output listed = ugoki({"lsi", "list"});
  EXPECT_NE(listed.err.find(pipe + ": This is a pipe, not a file."), std::string::npos) << listed.err;
  EXPECT_NE(listed.out.find("good"), std::string::npos);
  ASSERT_EQ(::mkfifo((folder_ + "/pipe.so").c_str(), 0600), 0);
  fails({"lsi", "install", folder_ + "/pipe.so", "--yes"}, "This is a pipe, not a file.");
}

TEST_F(LsiCliTest, EndedBuildsLeaveNoFolder) {
  const std::string temporary = folder_ + "/tmp";
  fs::create_directory(temporary);
  const std::string compiler = write("slow", "#!/bin/sh\nexec sleep 1000\n");
  fs::permissions(compiler, fs::perms::owner_all);
  const std::string source = write("good.c", "double f(double x) { return x; }\n");
  const std::vector<std::string> environment = {"UGOKI_LSI=" + folder_ + "/shelf", "TMPDIR=" + temporary};
  const auto folders = [&] { return std::distance(fs::directory_iterator(temporary), fs::directory_iterator()); };
  std::signal(SIGHUP, SIG_DFL);  // a program that nohup has started ignores it, and so do its children
  for (const int signal : {SIGINT, SIGTERM, SIGHUP, SIGKILL}) {
    SCOPED_TRACE(::strsignal(signal));
    const pid_t build = start_program({"lsi", "build", source, "--compiler", compiler}, environment);
    for (int i = 0; i < 1000 && folders() == 0; ++i) ::usleep(10'000);
    ::kill(build, signal);
    wait_for(build);
    ASSERT_EQ(folders(), signal == SIGKILL ? 1 : 0);
  }
  EXPECT_EQ(run_program({"lsi", "build", source}, environment).status, 0);  // also removes what the killed program has left
  EXPECT_EQ(folders(), 0);
}

TEST_F(LsiCliTest, WritableGlobalsAreWarnedOf) {
  const std::string source = write("globals.c", "double sum;\ndouble f(double x) { sum += x; return sum; }\n");
  const Json built = json({"lsi", "build", source});
  ASSERT_EQ(built["warnings"].size(), 1u) << built["warnings"].dump();
  EXPECT_NE(built["warnings"][0].get<std::string>().find("the variable 'sum' is global or static"), std::string::npos);
  const Output installed = ugoki({"lsi", "install", built["output"], "--yes"});
  EXPECT_EQ(installed.status, 0) << installed.err;
  EXPECT_NE(installed.err.find("the variable 'sum' is global or static"), std::string::npos) << installed.err;
}

}  // namespace
}  // namespace ugoki::cli
