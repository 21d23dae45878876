// Zip files of FMUs: valid, hostile, truncated and damaged ones.

#include <cstring>

#include "fmi_test.h"
#include "ugoki/fmi/load.h"

namespace ugoki::fmi {
namespace {

std::string zip(const std::vector<std::pair<std::string, std::string>>& files) {
  const Result<std::string> bytes = write_archive(files, "test");
  EXPECT_TRUE(bytes);
  return bytes ? *bytes : "";
}
/// The error of opening a zip; "opened" if there is none.
std::string refusal(const std::string& bytes) {
  const Result<Archive> archive = Archive::open(bytes, "x.fmu");
  return archive ? "opened" : archive.error().text();
}
/// Replaces the name of an entry by another one of the same length.
std::string renamed(std::string bytes, const std::string& from, const std::string& to) {
  for (std::size_t at = bytes.find(from); at != std::string::npos; at = bytes.find(from, at + 1)) bytes.replace(at, from.size(), to);
  return bytes;
}

TEST(Archive, RoundTrip) {
  const std::vector<std::pair<std::string, std::string>> files{
      {"modelDescription.xml", "<a/>"}, {"resources/b.txt", std::string(100000, 'b')}, {"resources/empty", ""}};
  const Result<Archive> archive = Archive::open(zip(files), "x.fmu");
  ASSERT_TRUE(archive) << archive.error().text();
  ASSERT_EQ(archive->entries().size(), 3u);
  for (const auto& [name, content] : files) {
    const Result<std::string> back = archive->read(name);
    ASSERT_TRUE(back);
    EXPECT_EQ(*back, content);
  }
  EXPECT_FALSE(archive->read("nothing"));
}

TEST(Archive, NamesThatLeadOutOfTheZipAreRefused) {
  const std::string good = zip({{"resources/aaaa.txt", "x"}});
  for (const char* bad : {"../../../aaaa.txtx", "/etcetera/aaaa.txt", "resources\\aaaa.txt", "resources/../aa.tx", "C:resources/aaa.tx",
                          "a/./b/aaaaaaaaa.tx", "resources//aaa.txt"})
    EXPECT_NE(refusal(renamed(good, "resources/aaaa.txt", bad)).find("leads out of the zip"), std::string::npos) << bad;
  EXPECT_EQ(refusal(good), "opened");
}

TEST(Archive, ZipBombsAreRefused) {
  EXPECT_NE(refusal(zip({{"a", std::string(40u << 20, '\0')}})).find("more than 100 times its packed size"), std::string::npos);
}

TEST(Archive, ClaimedSizesAreNotTrusted) {
  std::string bytes = zip({{"a.txt", std::string(5000, 'a') + "end"}});
  // Change the uncompressed size in the local header and in the central directory from 5003 to 4003.
  const std::uint32_t was = 5003, is = 4003;
  int changed = 0;
  for (std::size_t at = 0; at + 4 <= bytes.size(); ++at)
    if (std::memcmp(bytes.data() + at, &was, 4) == 0) {
      std::memcpy(bytes.data() + at, &is, 4);
      ++changed;
    }
  ASSERT_GE(changed, 1);
  const Result<Archive> archive = Archive::open(bytes, "x.fmu");
  if (archive) EXPECT_FALSE(archive->read("a.txt"));
}

TEST(Archive, DamagedZipsAreRefusedOrReadUnchanged) {
  const std::string content = std::string(3000, 'm') + "middle" + std::string(3000, 'n');
  const std::string good = zip({{"modelDescription.xml", content}, {"b", "second"}});
  for (std::size_t n = 0; n < good.size(); ++n) EXPECT_NE(refusal(good.substr(0, n)), "opened") << n;
  for (std::size_t at = 0; at < good.size(); ++at)
    for (const int bit : {0, 3, 7}) {
      std::string bad = good;
      bad[at] = static_cast<char>(bad[at] ^ (1 << bit));
      const Result<Archive> archive = Archive::open(bad, "x.fmu");
      if (!archive) continue;
      const Result<std::string> back = archive->read("modelDescription.xml");
      if (back) EXPECT_EQ(*back, content) << at;  // damage of the data is detected by the checksum
    }
}

TEST(Archive, DuplicateNamesAreRefused) {
  EXPECT_NE(refusal(renamed(zip({{"aaa", "1"}, {"bbb", "2"}}), "bbb", "aaa")).find("two entries 'aaa'"), std::string::npos);
}

TEST(Archive, LinksAreRefused) {
  std::string bytes = zip({{"link", "/etc/passwd"}});
  // Change the mode in the external attributes of the central directory from 0100644 (file) to 0120644 (symbolic link).
  const std::uint32_t was = 0100644u << 16, is = 0120644u << 16;
  int changed = 0;
  for (std::size_t at = 0; at + 4 <= bytes.size(); ++at)
    if (std::memcmp(bytes.data() + at, &was, 4) == 0) {
      std::memcpy(bytes.data() + at, &is, 4);
      ++changed;
    }
  ASSERT_EQ(changed, 1);
  EXPECT_NE(refusal(bytes).find("is a link"), std::string::npos);
}

TEST(Archive, OtherFilesAreRefused) {
  for (const std::string& bytes : {std::string(), std::string("PK"),
                                   std::string("\x7f"
                                               "ELF"),
                                   std::string(100000, 'P')})
    EXPECT_NE(refusal(bytes).find("is not a zip"), std::string::npos);
}

TEST_F(FmiTest, MissingPartsOfAnFmuAreNamed) {
  const auto reported = [&](const Files& files) {
    const std::string path = pack("x.fmu", files);
    const auto loaded = load_fmu(path, text_of(path), "", nullptr);
    return loaded ? "loaded" : loaded.error().text();
  };
  const std::string two = description_of("dahlquist", 2), three = description_of("dahlquist", 3);
  EXPECT_NE(reported({{"readme.txt", "x"}}).find("has no modelDescription.xml"), std::string::npos);
  EXPECT_NE(reported({{"modelDescription.xml", two}, {"binaries/win64/Dahlquist.dll", "x"}, {"binaries/darwin64/Dahlquist.dylib", "x"}})
                .find("it has binaries for darwin64 win64"),
            std::string::npos);
  EXPECT_NE(reported({{"modelDescription.xml", three}, {"sources/fmi3.c", "x"}}).find("only sources"), std::string::npos);
  EXPECT_EQ(reported({{"modelDescription.xml", three}, {"binaries/x86_64-linux/Dahlquist.so", "x"}}),
            "loaded");  // the binary is not opened yet
}

TEST_F(FmiTest, BrokenBinariesAreReportedAtFirstUse) {
  const auto reported = [&](const std::string& code) {
    const std::string path =
        pack("x.fmu", {{"modelDescription.xml", description_of("dahlquist", 3)}, {"binaries/x86_64-linux/Dahlquist.so", code}});
    const auto live = library(path);
    const auto i = build(alone("Dahlquist"), live, 0.1);
    return i ? "built" : i.error().text();
  };
  EXPECT_NE(reported("not a library").find("The FMU's binary cannot be opened"), std::string::npos);
  const std::string wrong = reported(code_of("dahlquist", 2));  // a binary with the functions of FMI 2.0
  EXPECT_NE(wrong.find("lacks functions: fmi3GetVersion"), std::string::npos) << wrong;
}

}  // namespace
}  // namespace ugoki::fmi
