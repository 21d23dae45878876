#include "cli_fixture.h"

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "ugoki/formats/bvh.h"
#include "ugoki/samples/samples.h"

namespace ugoki::cli {

namespace fs = std::filesystem;

void CliTest::SetUp() {
  std::string name = (fs::temp_directory_path() / "ugoki-cli-XXXXXX").string();
  ASSERT_NE(::mkdtemp(name.data()), nullptr);
  folder_ = name;
  library_ = folder_ + "/library.db";
}

void CliTest::TearDown() { fs::remove_all(folder_); }

Json CliTest::json(std::vector<std::string> arguments) const {
  arguments.emplace_back("--json");
  const Output o = ugoki(arguments);
  EXPECT_EQ(o.status, 0) << o.out << o.err;
  EXPECT_EQ(o.err, "") << "a pipe should get no progress bar";
  Json j = Json::parse(o.out, nullptr, false);
  EXPECT_FALSE(j.is_discarded()) << o.out;
  return j;
}

void CliTest::does(const std::vector<std::string>& arguments) const {
  const Output o = ugoki(arguments);
  EXPECT_EQ(o.status, 0) << o.out << o.err;
}

void CliTest::fails(const std::vector<std::string>& arguments, const std::string& part) const {
  const auto before = contents();
  const std::string listed = fs::exists(library_) ? ugoki({"db", "list"}).out : std::string();
  const Output o = ugoki(arguments);
  EXPECT_EQ(o.status, 1) << o.out << o.err;
  EXPECT_TRUE(o.err.starts_with("ugoki: ")) << o.err;
  EXPECT_NE(o.err.find(part), std::string::npos) << "missing in the error: " << part << "\n" << o.err;
  EXPECT_GE(std::count_if(o.err.begin(), o.err.end(), [](char c) { return c == '.' || c == '?'; }), 2)
      << "an error should be a sentence and a remedy: " << o.err;
  EXPECT_TRUE(contents() == before) << "a failing command should not add or change a file";
  if (!listed.empty()) EXPECT_EQ(ugoki({"db", "list"}).out, listed);
}

void CliTest::misunderstands(const std::vector<std::string>& arguments) const {
  const auto before = contents();
  const Output o = ugoki(arguments);
  EXPECT_EQ(o.status, 2) << o.out << o.err;
  EXPECT_FALSE(o.err.empty());
  EXPECT_TRUE(o.out.empty()) << o.out;
  EXPECT_TRUE(contents() == before);
}

std::string CliTest::write(const std::string& name, const std::string& text) const {
  fs::create_directories(fs::path(path(name)).parent_path());
  std::ofstream(path(name), std::ios::binary) << text;
  return path(name);
}

std::string CliTest::read(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

std::string CliTest::walk(const std::string& name) const { return write(name, formats::write_bvh(samples::make_human_walk())); }

std::map<std::string, std::string> CliTest::contents() const {
  std::map<std::string, std::string> out;
  for (const auto& e : fs::recursive_directory_iterator(folder_))
    if (e.is_regular_file() && !e.path().filename().string().starts_with("library.db")) out[e.path().string()] = read(e.path().string());
  return out;
}

}  // namespace ugoki::cli
