// The binary interface of plug-ins: invalid tables, other versions, and the shelf of installed libraries.

#include <cstring>

#include "plugin_test.h"
#include "ugoki/plugin/declarations.h"
#include "ugoki/plugin/shelf.h"

namespace ugoki::plugin {
namespace {

std::int32_t nothing(const ugoki_call*) { return 0; }

/// A valid library with one LSI. Tests change one field to make it invalid.
struct Tables {
  ugoki_input input{sizeof(ugoki_input), UGOKI_SCALAR, 0, 0, "x", "m", "Input.", 0, 0, 0};
  ugoki_output output{sizeof(ugoki_output), UGOKI_SCALAR, 0, 0, "y", "m", "Output.", 0, 0, 0, 0};
  ugoki_parameter parameter{sizeof(ugoki_parameter), UGOKI_NUMBER, 0, 0, "k", "", "", {1, 0, 0}, 0, 2, nullptr, nullptr};
  ugoki_field field{sizeof(ugoki_field), UGOKI_F64, 0, 1, "s", "", "", 0};
  ugoki_class lsi{};
  const ugoki_class* all[1];
  ugoki_library library{sizeof(ugoki_library), UGOKI_LSI_ABI, "lib", "1", "", all, 1, 0};
  Tables() : all{&lsi} {
    lsi.size = sizeof lsi;
    lsi.version = 1;
    lsi.name = "it";
    lsi.inputs = &input;
    lsi.outputs = &output;
    lsi.parameters = &parameter;
    lsi.fields = &field;
    lsi.input_count = lsi.output_count = lsi.parameter_count = lsi.field_count = 1;
    lsi.state_size = 8;
    lsi.step = nothing;
  }
  std::string problems() {
    Error error;
    (void)read_declarations(&library, "lib.so", error);
    return error.empty() ? "" : error.text();
  }
};

TEST(Abi, ValidLibraryIsRead) { EXPECT_EQ(Tables().problems(), ""); }

TEST(Abi, InvalidDeclarationsAreRefusedWithReason) {
  const auto refused = [](auto change, const char* part) {
    Tables t;
    change(t);
    const std::string reported = t.problems();
    EXPECT_NE(reported.find(part), std::string::npos) << part << " is not in: " << reported;
    EXPECT_NE(reported.find("lib.so"), std::string::npos) << reported;
  };
  refused([](Tables& t) { t.library.abi = 2; }, "built for version 2 of the LSI interface; this program has version 1");
  refused([](Tables& t) { t.library.size = 4; }, "has no description");
  refused([](Tables& t) { t.library.size = 24; }, "too short");
  refused([](Tables& t) { t.library.name = "a/b"; }, "not a valid name of a library");
  refused([](Tables& t) { t.library.classes = nullptr; }, "no LSIs");
  refused([](Tables& t) { t.library.class_count = 4000000000u; }, "no LSIs");
  refused([](Tables& t) { t.all[0] = nullptr; }, "missing or too short");
  refused([](Tables& t) { t.lsi.size = 16; }, "missing or too short");
  refused([](Tables& t) { t.lsi.name = nullptr; }, "name of an LSI");
  refused([](Tables& t) { t.lsi.step = nullptr; }, "neither 'step' nor 'advance'");
  refused([](Tables& t) { t.lsi.inputs = nullptr; }, "damaged");
  refused([](Tables& t) { t.input.size = 8; }, "damaged");
  refused([](Tables& t) { t.input.type = 77; }, "unknown type 77");
  refused([](Tables& t) { t.input.name = "a.b"; }, "not a valid name of a pin");
  refused([](Tables& t) { t.input.minimum = 3; }, "minimum of 'x' is above its maximum");
  refused([](Tables& t) { t.output.flags = UGOKI_DELAYED; }, "no 'advance'");
  refused([](Tables& t) { t.output.like = 9; }, "but the LSI has 1 inputs");
  refused([](Tables& t) { t.output.type = UGOKI_JOINT_VALUES; }, "number of elements of the output 'y' is unknown");
  refused([](Tables& t) { t.output.count = 2000000; }, "2000000 elements; the limit is 1000000");
  refused([](Tables& t) { t.parameter.kind = 9; }, "unknown kind");
  refused([](Tables& t) { t.parameter.initial[0] = 5; }, "out of its range");
  refused([](Tables& t) { t.parameter.kind = UGOKI_CHOICE; }, "no choices");
  refused([](Tables& t) { t.field.offset = 4; }, "outside of the state");
  refused([](Tables& t) { t.field.type = 0; }, "unknown type");
  refused([](Tables& t) { t.lsi.state_size = std::uint64_t{1} << 40; }, "64 MB");
}

TEST(Abi, StructsOfALaterVersionAreRead) {
  struct LaterInput {
    ugoki_input base;
    double more[3];
  };
  struct LaterClass {
    ugoki_class base;
    void* more;
  };
  Tables t;
  LaterInput inputs[2] = {{t.input, {}}, {t.input, {}}};
  inputs[1].base.name = "z";
  for (LaterInput& i : inputs) i.base.size = sizeof i;
  LaterClass later{t.lsi, nullptr};
  later.base.size = sizeof later;
  later.base.inputs = &inputs[0].base;
  later.base.input_count = 2;
  t.all[0] = &later.base;
  t.library.size += 64;
  Error error;
  const Declared d = read_declarations(&t.library, "lib.so", error);
  ASSERT_TRUE(error.empty()) << error.text();
  ASSERT_EQ(d.classes[0].inputs.size(), 2u);
  EXPECT_EQ(d.classes[0].inputs[1].name, "z");
}

TEST_F(PluginTest, InvalidLibrariesAreRefused) {
  const auto reported = [](const Result<LoadedLibrary>& r) { return r ? std::string("loaded") : r.error().text(); };
  EXPECT_NE(reported(load_library(folder_ + "/none.so")).find("none.so"), std::string::npos);
  EXPECT_NE(reported(load_library(write("text.so", "no library"))).find("cannot be opened"), std::string::npos);
  const std::string later = build("later.c",
                                  "#include <ugoki/lsi.h>\nstatic const ugoki_library l = {sizeof l, 7, \"l\", 0, 0, 0, 0, 0};\nconst "
                                  "ugoki_library* ugoki_lsi_library(void) { return &l; }");
  EXPECT_NE(reported(load_library(later)).find("version 7 of the LSI interface"), std::string::npos) << reported(load_library(later));
  const std::string good = build("good.c", "double f(double x) { return x; }");
  EXPECT_NE(reported(load_library(good, std::string(64, '0'))).find("has changed since it was installed"), std::string::npos);
}

TEST_F(PluginTest, ShelfKeepsLibrariesByHash) {
  const std::string shelf = folder_ + "/shelf";
  EXPECT_TRUE(read_shelf(shelf).empty());
  const std::string path = build("one.c", "/// Doubles.\n/// @in x [m] 0..1\ndouble twice(double x) { return 2 * x; }");
  const Result<std::string> description = describe_library(path);
  ASSERT_TRUE(description) << description.error().text();
  ASSERT_TRUE(put_on_shelf(shelf, path, *description));
  std::vector<ShelfEntry> all = read_shelf(shelf);
  ASSERT_EQ(all.size(), 1u);
  EXPECT_EQ(all[0].classes[0].name, "one/twice");
  EXPECT_EQ(all[0].classes[0].inputs[0].maximum, 1);
  {
    LiveLibrary live(signals_, shelf);
    ASSERT_NE(live.library()->find("one/twice"), nullptr);
    EXPECT_EQ(live.library()->find("twice"), live.library()->find("one/twice"));
  }
  // A changed file is not loaded.
  std::ofstream(all[0].file, std::ios::app | std::ios::binary) << "x";
  LiveLibrary changed(signals_, shelf);
  EXPECT_EQ(changed.library()->find("one/twice"), nullptr);
  const std::vector<std::string> messages = changed.take_messages();
  ASSERT_EQ(messages.size(), 1u);
  EXPECT_NE(messages[0].find("has changed since it was installed"), std::string::npos);
  // A description of another file is refused.
  EXPECT_FALSE(put_on_shelf(shelf, build("two.c", "double g(double x) { return x; }"), *description));
  ASSERT_TRUE(remove_from_shelf(shelf, "one"));
  EXPECT_TRUE(read_shelf(shelf).empty());
  EXPECT_FALSE(std::filesystem::exists(all[0].file));
  EXPECT_FALSE(remove_from_shelf(shelf, "one"));
  // A damaged manifest is reported and left out.
  write("shelf/broken.json", "{\"name\": 3");
  Error problems;
  EXPECT_TRUE(read_shelf(shelf, &problems).empty());
  EXPECT_FALSE(problems.empty());
}

}  // namespace
}  // namespace ugoki::plugin
