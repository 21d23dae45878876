// Reading a file leaves no side files next to it, new files are private, and wrong paths and files that cannot grow are reported.
#include <sys/resource.h>
#include <sys/stat.h>

#include <algorithm>
#include <filesystem>

#include "cli_fixture.h"

namespace ugoki::cli {
namespace {

namespace fs = std::filesystem;

class FileTrustCliTest : public CliTest {
 protected:
  std::vector<std::string> names() const {
    std::vector<std::string> out;
    for (const auto& entry : fs::directory_iterator(folder_)) out.push_back(entry.path().filename());
    std::sort(out.begin(), out.end());
    return out;
  }
};

TEST_F(FileTrustCliTest, ReadingLeavesNoSideFiles) {
  const std::string project = path("park.ugoki");
  does({"new", project});
  json({"import", walk()});
  const auto before = names();
  json({"info", project});
  does({"run", project, "--duration", "0.1"});
  json({"info", library_});
  json({"db", "list"});
  json({"db", "check"});
  EXPECT_EQ(names(), before);
}

TEST_F(FileTrustCliTest, NewFilesArePrivate) {
  does({"new", path("park.ugoki")});
  json({"import", walk()});
  for (const std::string& file : {path("park.ugoki"), library_}) {
    struct stat info{};
    ASSERT_EQ(::stat(file.c_str(), &info), 0);
    EXPECT_EQ(info.st_mode & 0777, 0600u) << file;
  }
}

TEST_F(FileTrustCliTest, MistypedPathsAndFoldersAreReported) {
  const std::string missing = path("libary.db");
  for (const std::vector<std::string>& verb :
       {std::vector<std::string>{"db", "list"}, {"db", "find", "x"}, {"db", "tags"}, {"db", "check"}, {"info", "walk"}}) {
    std::vector<std::string> arguments = verb;
    arguments.insert(arguments.end(), {"--library", missing});
    fails(arguments, "does not exist");
    arguments.back() = folder_;
    fails(arguments, "folder");
  }
  EXPECT_FALSE(fs::exists(missing));
}

/// Runs the program with a limit on the size of the files that it writes.
TEST_F(FileTrustCliTest, FileSizeLimitIsReportedAsAnError) {
  const std::string project = path("park.ugoki");
  does({"new", project});
  rlimit before{};
  ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &before), 0);
  const rlimit small{1024, before.rlim_max};
  for (const std::vector<std::string>& arguments :
       {std::vector<std::string>{"new", path("more.ugoki")}, {"run", project, "--duration", "0.1", "--frames", path("out.frames")}}) {
    ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &small), 0);
    const Output o = ugoki(arguments);
    ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &before), 0);
    EXPECT_EQ(o.status, 1) << arguments.front() << ": " << o.err;
    EXPECT_NE(o.err.find("File too large"), std::string::npos) << o.err;
    EXPECT_NE(o.err.find("ulimit"), std::string::npos) << o.err;
  }
}

}  // namespace
}  // namespace ugoki::cli
