#include <fcntl.h>
#include <signal.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <thread>

#include "cli_fixture.h"
#include "ugoki/formats/bvh.h"
#include "ugoki/samples/samples.h"

namespace ugoki::cli {
namespace {

namespace fs = std::filesystem;
TEST_F(CliTest, BadUsageIsStatusTwo) {
  for (const std::vector<std::string>& arguments : std::vector<std::vector<std::string>>{{},
                                                                                         {"fly"},
                                                                                         {"--nonsense"},
                                                                                         {"import"},
                                                                                         {"import", "a.bvh", "--height", "tall"},
                                                                                         {"import", "a.bvh", "b.bvh", "--name", "x"},
                                                                                         {"run", "a.bvh", "--rate", "20"},
                                                                                         {"run", "a.bvh", "--push-direction", "0,0"},
                                                                                         {"run", "a.bvh", "--push-direction", "1"},
                                                                                         {"db"},
                                                                                         {"db", "list", "--kind", "poem"},
                                                                                         {"db", "rename", "x"},
                                                                                         {"new"},
                                                                                         {"info"},
                                                                                         {"judge", "a.bvh", "b.bvh"}}) {
    misunderstands(arguments);
  }
}

TEST_F(CliTest, EveryVerbHasHelpWithAnExample) {
  for (const char* verb : {"studio", "new", "import", "info", "run", "judge", "db"}) {
    const Output o = ugoki({verb, "--help"});
    EXPECT_EQ(o.status, 0);
    EXPECT_NE(o.out.find("Example:\n  ugoki " + std::string(verb)), std::string::npos) << o.out;
  }
  for (const char* verb : {"list", "find", "show", "tag", "rename", "remove", "export"}) {
    const Output o = ugoki({"db", verb, "--help"});
    EXPECT_EQ(o.status, 0);
    EXPECT_NE(o.out.find("Example:\n  ugoki db " + std::string(verb)), std::string::npos) << o.out;
  }
  EXPECT_EQ(ugoki({"--help"}).status, 0);
  EXPECT_EQ(ugoki({"--version"}).out, "ugoki 0.1.0\n");
}

TEST_F(CliTest, NewCreatesProjects) {
  const std::string park = folder_ + "/park.ugoki", bare = folder_ + "/bare.ugoki";
  EXPECT_EQ(json({"new", park})["characters"], 3);
  const Json info = json({"info", park});
  EXPECT_EQ(info["kind"], "project");
  EXPECT_EQ(info["duration_s"], 20.0);
  EXPECT_EQ(json({"new", bare, "--empty"})["name"], "bare");
  EXPECT_EQ(json({"info", bare})["characters"].size(), 0u);
  const std::string before = read(park);
  fails({"new", park}, "park.ugoki");
  EXPECT_EQ(read(park), before);
  fails({"new", folder_ + "/no/such/folder.ugoki"}, "folder.ugoki");
}

TEST_F(CliTest, ImportPrintsAndStoresEntries) {
  const std::string copy = folder_ + "/copy.bvh";
  const Json j = json({"import", walk(), "--tags", "walk,own", "--bvh", copy});
  ASSERT_EQ(j["files"].size(), 1u);
  const Json& f = j["files"][0];
  const MeasuredMotion measured = samples::make_human_walk();
  EXPECT_EQ(f["frames"], measured.frames);
  EXPECT_EQ(f["joints"], measured.joint_count());
  EXPECT_NEAR(f["duration_s"].get<double>(), measured.duration(), 1e-9);
  EXPECT_NEAR(f["rate"].get<double>(), measured.rate, 1e-9);
  EXPECT_NEAR(f["height_m"].get<double>(), 1.75, 0.1);
  EXPECT_GT(f["mass_kg"].get<double>(), 40);
  EXPECT_LT(f["bvh_error_m"].get<double>(), 1e-6);
  EXPECT_EQ(entries(), 3u);
  EXPECT_EQ(json({"db", "find", "own", "--kind", "motion"})["entries"][0]["summary"]["mechanism"], f["ids"]["mechanism"]);
  json({"import", walk()});
  EXPECT_EQ(entries(), 3u) << "importing the same data again should add no entry";
  EXPECT_EQ(json({"import", walk("other.bvh"), "--dry-run"})["files"][0].contains("ids"), false);
  EXPECT_EQ(entries(), 3u);
  const std::string table = ugoki({"import", walk()}).out;
  EXPECT_NE(table.find("walk"), std::string::npos);
}

TEST_F(CliTest, CopiesOfEqualNameAreNumbered) {
  for (const char* name : {"a", "b", "out"}) fs::create_directory(folder_ + "/" + name);
  const std::string first = walk("a/walk.bvh"), second = write("b/walk.bvh", formats::write_bvh(samples::make_human_stand()));
  const std::string out = folder_ + "/out";
  const Json j = json({"import", first, second, "--bvh", out, "--dry-run"});
  ASSERT_EQ(j["files"].size(), 2u);
  EXPECT_EQ(j["files"][0]["bvh"], out + "/walk.bvh");
  EXPECT_EQ(j["files"][1]["bvh"], out + "/walk-2.bvh");
  for (std::size_t i = 0; i < 2; ++i) {
    const auto copy = formats::read_bvh(read(j["files"][i]["bvh"]), "copy");
    ASSERT_TRUE(copy) << copy.error().text();
    EXPECT_EQ(copy->frames, j["files"][i]["frames"]);
  }
  // A second run replaces the copies of the first one. An imported file is never overwritten.
  EXPECT_EQ(json({"import", first, "--bvh", out, "--dry-run"})["files"][0]["bvh"], out + "/walk.bvh");
  const std::string before = read(first);
  fails({"import", second, first, "--bvh", folder_ + "/a", "--dry-run"}, "a/walk.bvh");
  EXPECT_EQ(read(first), before);
}

TEST_F(CliTest, BadFilesDoNotChangeTheLibrary) {
  json({"import", walk()});
  const std::string good = read(folder_ + "/walk.bvh"), listed = ugoki({"db", "list"}).out;
  std::vector<std::pair<std::string, std::string>> bad = {{"empty.bvh", ""},
                                                          {"binary.bvh", std::string("\0\1\2\3\xff\xfe", 6)},
                                                          {"half.bvh", good.substr(0, good.size() / 2)},
                                                          {"head.bvh", good.substr(0, 200)},
                                                          {"frames.bvh",
                                                           "HIERARCHY\nROOT a\n{\nOFFSET 0 0 0\nCHANNELS 3 Zrotation Xrotation "
                                                           "Yrotation\n}\nMOTION\nFrames: 2000000000\nFrame Time: 0.01\n0 0 0\n"},
                                                          {"no_skeleton.amc", ":FULLY-SPECIFIED\n:DEGREES\n1\nroot 0 0 0 0 0 0\n"},
                                                          {"skeleton.asf", ":version 1.10\n"},
                                                          {"mechanism.json", "{\"links\": 3}"},
                                                          {"picture.png", "x"}};
  for (const auto& [name, text] : bad) {
    SCOPED_TRACE(name);
    fails({"import", write(name, text)}, name);
    EXPECT_EQ(ugoki({"db", "list"}).out, listed);
  }
  fails({"import", folder_ + "/absent.bvh"}, "absent.bvh");
  EXPECT_NE(ugoki({"import", folder_ + "/half.bvh"}).err.find("half.bvh:"), std::string::npos) << "the error should name file and line";
  // If one of several files is bad, the good ones are stored; the exit status still reports the failure.
  const Output mixed = ugoki({"import", folder_ + "/half.bvh", walk("second.bvh"), "--json"});
  EXPECT_EQ(mixed.status, 1);
  const Json j = Json::parse(mixed.out, nullptr, false);
  ASSERT_FALSE(j.is_discarded());
  EXPECT_EQ(j["files"].size(), 1u);
  EXPECT_EQ(j["errors"][0]["file"], folder_ + "/half.bvh");
  EXPECT_FALSE(j["errors"][0]["problems"][0]["remedy"].get<std::string>().empty());
  EXPECT_EQ(entries(), 6u);
}

TEST_F(CliTest, LibraryIsListedShownAndDamageReported) {
  EXPECT_EQ(entries(), 0u);
  EXPECT_FALSE(fs::exists(library_)) << "reading should not create the library";
  const Json ids = json({"import", walk()})["files"][0]["ids"];
  const std::string motion = ids["motion"], mechanism = ids["mechanism"], measured = ids["measured"];
  EXPECT_EQ(json({"db", "show", motion})["name"], "walk");
  fails({"db", "show", "walk"}, "library.db");  // refused, because three entries have this name
  json({"db", "rename", motion, "stroll"});
  EXPECT_EQ(json({"db", "find", "stroll"})["entries"][0]["id"], motion);
  json({"db", "tag", "stroll", mechanism, "--add", "a,b"});
  json({"db", "tag", "stroll", "--remove", "a"});
  EXPECT_EQ(json({"db", "list", "--tag", "a"})["entries"].size(), 1u);
  EXPECT_EQ(json({"db", "list", "--tag", "b"})["entries"].size(), 2u);
  const std::string out = folder_ + "/out.bvh";
  json({"db", "export", measured, out});
  EXPECT_TRUE(formats::read_bvh(read(out), "out.bvh"));
  json({"db", "export", mechanism, folder_ + "/body.json"});
  EXPECT_EQ(json({"info", folder_ + "/body.json"})["kind"], "mechanism");
  EXPECT_EQ(json({"info", "stroll"})["kind"], "motion");
  EXPECT_EQ(json({"info", library_})["motion"], 1);
  fails({"db", "export", measured, folder_ + "/no/folder/x.bvh"}, "x.bvh");
  json({"db", "remove", "stroll", measured});
  EXPECT_EQ(entries(), 1u);
  fails({"db", "remove", "stroll"}, "library.db");
  fails({"db", "show", "nothing", "--library", folder_ + "/none.db"}, "none.db");
  write("library.db", "not a database at all");
  fails({"db", "list"}, "library.db");
}

TEST_F(CliTest, RunIsBitwiseReproducible) {
  const std::string clip = walk();
  const Json first = json({"run", clip});
  EXPECT_EQ(first["not_converged"], 0);
  EXPECT_EQ(first["step_failures"], 0);
  EXPECT_EQ(first["split_steps"], 0);
  EXPECT_EQ(first["substeps"], first["steps"]);
  for (const char* key :
       {"clip", "frames", "duration_s", "steps", "steps_per_s", "tracking_rms_deg", "root_assist_rms_bw", "root_assist_force_rms_bw",
        "root_assist_max_bw", "foot_skate_cm", "penetration_mm", "realtime_factor", "fell", "release_time", "mass", "height", "state_hash"})
    EXPECT_TRUE(first.contains(key)) << key;
  EXPECT_EQ(first["clip"], "walk");
  EXPECT_EQ(first["steps"], std::lround(first["duration_s"].get<double>() * 500));
  EXPECT_EQ(first["state_hash"].get<std::string>().size(), 16u);
  EXPECT_EQ(json({"run", clip})["state_hash"], first["state_hash"]);
  EXPECT_EQ(json({"run", clip, "--threads", "3"})["state_hash"], first["state_hash"]);
  json({"import", clip});
  EXPECT_EQ(json({"run", "walk"})["state_hash"], first["state_hash"]) << "the run of the library entry should have the same hash";
  const std::string ugx = folder_ + "/walk.ugx", frames = folder_ + "/walk.frames";
  const Json pushed = json({"run", clip, "--push", "60", "--push-time", "0.2", "--ugx", ugx, "--frames", frames});
  EXPECT_NE(pushed["state_hash"], first["state_hash"]);
  EXPECT_EQ(json({"run", ugx})["state_hash"], pushed["state_hash"]) << "executable data should contain all inputs of the run";
  EXPECT_EQ(json({"info", ugx})["kind"], "executable data");
  EXPECT_TRUE(read(frames).starts_with("UKGF"));
  const Json finer = json({"run", clip, "--rate", "1000"});
  EXPECT_EQ(finer["steps"], std::lround(finer["duration_s"].get<double>() * 1000));
}

TEST_F(CliTest, RunReportsErrorsWithRemedies) {
  const std::string clip = walk(), ugx = folder_ + "/walk.ugx";
  fails({"run", folder_ + "/absent.bvh"}, "absent.bvh");
  fails({"run", "no such entry"}, "no such entry");
  fails({"run", clip, "--push", "100", "--push-link", "wing"}, "--push-link");
  json({"run", clip, "--duration", "0.1", "--ugx", ugx});
  fails({"run", ugx, "--push", "100"}, "walk.ugx");
  write("cut.ugx", read(ugx).substr(0, 1000));
  fails({"run", folder_ + "/cut.ugx"}, "cut.ugx");
  fails({"run", folder_}, folder_);
  const Output o = ugoki({"run", folder_ + "/cut.ugx", "--json"});
  const Json j = Json::parse(o.out, nullptr, false);
  ASSERT_FALSE(j.is_discarded()) << o.out;
  EXPECT_FALSE(j["error"]["problems"].empty());
}

TEST_F(CliTest, JudgeComparesWithLimits) {
  const std::string clip = walk();
  const Json j = json({"judge", clip});
  ASSERT_EQ(j["parts"].size(), 2u);
  for (const Json& part : j["parts"]) {
    EXPECT_EQ(part["measures"].size(), 25u);
    for (const Json& m : part["measures"]) {
      if (m["value"].is_null()) {
        EXPECT_FALSE(m["reason"].get<std::string>().empty()) << m;
        continue;
      }
      const double value = m["value"].get<double>();
      EXPECT_EQ(m["good"].get<bool>(), value <= m["limit"].get<double>() && (m["minimum"].is_null() || value >= m["minimum"].get<double>()))
          << m;
      for (const Json& span : m["bad"]) EXPECT_LE(span["from"].get<double>(), span["at"].get<double>());
    }
  }
  EXPECT_GE(j["parts"][1]["measures"][0]["value"].get<double>(), 0) << "tracking error of the simulation";
  EXPECT_EQ(json({"judge", clip, "--kinematic"})["parts"].size(), 1u);
  EXPECT_EQ(ugoki({"judge", clip, "--kinematic", "--strict", "--max-penetration", "1000", "--max-skate", "1000"}).status, 0);
  const Output strict = ugoki({"judge", clip, "--kinematic", "--strict", "--limit", "work=0.001"});
  EXPECT_EQ(strict.status, 1);
  EXPECT_NE(strict.out.find("TOO MUCH"), std::string::npos) << strict.out;
  for (const char* wrong : {"charm=1", "work", "work=-1", "work=x"})
    EXPECT_EQ(ugoki({"judge", clip, "--kinematic", "--limit", wrong}).status, 1) << wrong;
}

TEST_F(CliTest, JudgeWritesPictures) {
  const std::string clip = walk(), picture = folder_ + "/walk.svg", plots = folder_ + "/plots";
  EXPECT_EQ(ugoki({"judge", clip, "--kinematic", "--svg", picture}).status, 0);
  std::ifstream file(picture);
  EXPECT_NE(std::string(std::istreambuf_iterator<char>(file), {}).find("Foot skate"), std::string::npos);
  EXPECT_EQ(ugoki({"judge", clip, "--kinematic", "--svg", plots}).status, 0);
  EXPECT_TRUE(fs::exists(plots + "/motion.svg"));
  EXPECT_TRUE(fs::exists(plots + "/motion-foot_slip_cm.svg"));
  EXPECT_EQ(ugoki({"judge", clip, "--kinematic", "--svg", plots}).status, 0) << "pictures of Ugoki are replaced";
  std::ofstream(plots + "/motion.svg") << "mine";
  EXPECT_EQ(ugoki({"judge", clip, "--kinematic", "--svg", plots}).status, 1) << "other files are kept";
}

TEST_F(CliTest, JudgeAcceptsLimitOptionsOfEarlierVersions) {
  const std::string clip = walk(), help = ugoki({"judge", "--help"}).out;
  for (const char* measure : {"tracking", "assist", "skate", "penetration"}) {
    EXPECT_NE(help.find("--max-" + std::string(measure)), std::string::npos) << help;
    EXPECT_EQ(help.find("--most-" + std::string(measure)), std::string::npos) << help;
    const Json limits = json({"judge", clip, "--kinematic", "--most-" + std::string(measure), "1000"});
    EXPECT_EQ(limits, json({"judge", clip, "--kinematic", "--max-" + std::string(measure), "1000"})) << measure;
  }
  EXPECT_EQ(ugoki({"judge", clip, "--kinematic", "--strict", "--most-penetration", "1000", "--most-skate", "1000"}).status, 0);
}

TEST_F(CliTest, InterruptLeavesNoIncompleteFile) {
  const std::string clip = walk(), frames = folder_ + "/long.frames";
  const pid_t child = start_program({"run", clip, "--duration", "80000", "--frames", frames}, environment());
  ::usleep(700'000);
  ASSERT_EQ(::kill(child, SIGINT), 0);
  EXPECT_EQ(wait_for(child), 1);
  for (const auto& entry : fs::directory_iterator(folder_))
    EXPECT_EQ(entry.path().filename().string().find("frames"), std::string::npos) << entry.path();
}

/// Starts a command that waits for data of a pipe, sends it the signal up to twice, and returns its exit status.
int ended_by(const std::vector<std::string>& arguments, const std::string& pipe, const std::vector<std::string>& environment,
             int signal_number) {
  EXPECT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  const int writer = ::open(pipe.c_str(), O_RDWR | O_CLOEXEC);  // the command can open the pipe, and its read waits
  ::signal(signal_number, SIG_DFL);  // a shell starts programs in the background with SIGINT ignored, which children inherit
  const pid_t child = start_program(arguments, environment);
  ::usleep(500'000);  // us: the command has begun to read; an earlier signal ends it too
  for (int k = 0; k < 2; ++k) {
    ::kill(child, signal_number);
    ::usleep(300'000);
  }
  const std::jthread rescue([child](const std::stop_token& stop) {  // a command that ignores the signals fails the test without a hang
    for (int k = 0; k < 300 && !stop.stop_requested(); ++k) ::usleep(100'000);
    if (!stop.stop_requested()) ::kill(child, SIGKILL);
  });
  const int status = wait_for(child);
  ::close(writer);
  ::unlink(pipe.c_str());
  return status;
}

TEST_F(CliTest, SignalsEndEveryVerbThatReadsAFile) {
  for (const int signal : {SIGINT, SIGTERM})
    for (const std::string& verb : {"info", "import", "run", "convert"}) {
      const std::string pipe = path("waiting.bvh");
      std::vector<std::string> arguments = {verb, pipe};
      if (verb == "convert") arguments.push_back(path("out.json"));
      const int status = ended_by(arguments, pipe, environment(), signal);
      EXPECT_TRUE(status == 128 + signal || status == 1) << verb << " ended with status " << status;
    }
}

TEST_F(CliTest, RealDataIsImportedAndWrittenBack) {
  const fs::path data = fs::path(UGOKI_SHARED_DATA) / "human";
  if (!fs::exists(data)) GTEST_SKIP() << "no shared data next to the project";
  const Json j = json({"import", (data / "bvh/cmu_12_01_walk.bvh").string(), (data / "asf_amc/35_01.amc").string(), "--bvh", folder_});
  ASSERT_EQ(j["files"].size(), 2u);
  EXPECT_EQ(j["files"][0]["frames"], 524);
  EXPECT_EQ(j["files"][1]["frames"], 224);
  for (const Json& f : j["files"]) EXPECT_LT(f["bvh_error_m"].get<double>(), 1e-6);
}

}  // namespace
}  // namespace ugoki::cli
