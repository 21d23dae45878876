// Inspection of a library's file before the user trusts it: nothing of it may run, and no file may crash the inspection.

#include <elf.h>

#include <cstring>
#include <random>

#include "plugin_test.h"
#include "ugoki/files/files.h"
#include "ugoki/plugin/inspect.h"

namespace ugoki::plugin {
namespace {

class InspectTest : public PluginTest {
 protected:
  std::string bytes(const std::string& path) const {
    const Result<std::string> read = files::read_file(path);
    EXPECT_TRUE(read);
    return read ? *read : "";
  }
};

TEST_F(InspectTest, NamesAreReadWithoutRunningTheLibrary) {
  const std::string marker = folder_ + "/marker";
  const std::string path =
      build("early.c", "#include <stdio.h>\n__attribute__((constructor)) static void early(void) { FILE* f = fopen(\"" + marker +
                           "\", \"w\"); if (f) fclose(f); }\n" + "double f(double x) { return x; }\ndouble g(double x) { return x; }\n");
  const Result<Inspection> file = inspect_library(path);
  ASSERT_TRUE(file) << file.error().text();
  EXPECT_EQ(file->name, "early");
  EXPECT_EQ(file->lsis, (std::vector<std::string>{"f", "g"}));
  EXPECT_EQ(file->hash.size(), 64u);
  EXPECT_FALSE(file->fmu);
  EXPECT_FALSE(std::filesystem::exists(marker));
}

TEST_F(InspectTest, StructsStateTheirNames) {
  const Result<Inspection> file =
      inspect_library(build("structs.cpp",
                            "#include <ugoki/lsi.hpp>\nstruct S { double x = 0, y = 0; void step() { y = x; } };\n"
                            "UGOKI_LSI(S, \"copy\", \"Copies.\", ugoki::in(&S::x, \"x\"), ugoki::out(&S::y, \"y\"))\n"
                            "UGOKI_LIBRARY(\"copies\", \"1\", \"\")\n"));
  ASSERT_TRUE(file) << file.error().text();
  EXPECT_EQ(file->name, "copies");
  EXPECT_EQ(file->lsis, std::vector<std::string>{"copy"});
  EXPECT_EQ(file->writable, std::vector<std::string>{});
}

TEST_F(InspectTest, FurtherLibrariesAreListedBecauseTheHashDoesNotCoverThem) {
  const std::string source = "double f(double x) { return x; }\n";
  const Result<Inspection> alone = inspect_library(build("alone.c", source));
  ASSERT_TRUE(alone) << alone.error().text();
  EXPECT_EQ(alone->needed, std::vector<std::string>{});
  EXPECT_EQ(alone->search_path, "");
  const std::string compiler = write("compiler", "#!/bin/sh\nexec cc \"$@\" -Wl,--no-as-needed -lresolv -Wl,-rpath,/srv/helpers\n");
  std::filesystem::permissions(compiler, std::filesystem::perms::owner_all);
  const Result<Inspection> with = inspect_library(build("with.c", source, compiler));
  ASSERT_TRUE(with) << with.error().text();
  EXPECT_EQ(with->needed, std::vector<std::string>{"libresolv.so.2"});
  EXPECT_EQ(with->search_path, "/srv/helpers");
}

TEST_F(InspectTest, ControlCharactersInNamesAreReplaced) {
  std::string text = bytes(build("names.c", "double abcdefgh(double x) { return x; }"));
  const auto at = text.find("lsi abcdefgh");
  ASSERT_NE(at, std::string::npos);
  text.replace(at + 4, 8, "\x1b[2J\xc2\x9b\x7fZ");
  const Result<Inspection> file = inspect_elf(text, "names.so");
  ASSERT_TRUE(file) << file.error().text();
  EXPECT_EQ(file->lsis, std::vector<std::string>{"?[2J???Z"});
}

TEST_F(InspectTest, WritableVariablesAreWarnedOf) {
  const Result<Inspection> file = inspect_library(build("globals.cpp",
                                                        "int total = 0;\nnamespace a { double last = 1; }\nconst double fixed = 3;\n"
                                                        "double f(double x) { static int calls = 0; ++calls; total += calls; "
                                                        "a::last = x; return total * fixed; }\n"));
  ASSERT_TRUE(file) << file.error().text();
  EXPECT_EQ(file->writable, (std::vector<std::string>{"calls", "last", "total"}));
  const std::vector<std::string> warnings = writable_warnings(*file, "globals.so");
  ASSERT_EQ(warnings.size(), 3u);
  EXPECT_NE(warnings[0].find("globals.so: the variable 'calls' is global or static"), std::string::npos) << warnings[0];
}

TEST_F(InspectTest, OtherFilesAreRefused) {
  const auto reported = [&](const std::string& text) {
    const Result<Inspection> file = inspect_elf(text, "it.so");
    return file ? std::string("accepted") : file.error().text();
  };
  EXPECT_NE(reported("").find("shorter than an ELF header"), std::string::npos);
  EXPECT_NE(reported(std::string(100, 'x')).find("does not begin like an ELF file"), std::string::npos);
  std::string good = bytes(build("good.c", "double f(double x) { return x; }"));
  Elf64_Ehdr header;
  std::memcpy(&header, good.data(), sizeof header);
  header.e_machine = EM_68K;
  std::string other = good;
  std::memcpy(other.data(), &header, sizeof header);
  EXPECT_NE(reported(other).find("another kind of machine"), std::string::npos) << reported(other);
  std::string unnamed = good;
  for (std::size_t at; (at = unnamed.find("ugoki_lsi_library")) != std::string::npos;) unnamed[at] = 'x';
  EXPECT_NE(reported(unnamed).find("does not export ugoki_lsi_library"), std::string::npos);
}

TEST_F(InspectTest, TruncatedAndDamagedFilesDoNotCrash) {
  const std::string good = bytes(build("good.c", "int n;\ndouble f(double x) { return x + n++; }"));
  for (std::size_t size = 0; size < good.size(); size += 1 + size / 64)
    EXPECT_FALSE(inspect_elf(std::string_view(good).substr(0, size), "it.so")) << size;  // the table of sections at the end is missing
  const unsigned seed = 7;
  std::mt19937 random(seed);
  Elf64_Ehdr header;
  std::memcpy(&header, good.data(), sizeof header);
  for (int i = 0; i < 3000; ++i) {
    std::string damaged = good;
    for (int k = 0; k < 4; ++k) {  // change bytes mostly in the header and the table of sections, which contain offsets and sizes
      const bool table = random() % 3 != 0;
      const std::size_t at = table ? header.e_shoff + random() % (damaged.size() - header.e_shoff) : random() % sizeof header;
      damaged[at] = static_cast<char>(random());
    }
    (void)inspect_elf(damaged, "it.so");
  }
}

}  // namespace
}  // namespace ugoki::plugin
