// Broken and hostile ASF and AMC files are rejected with file:line, a message and a remedy.
#include "expect.h"
#include "ugoki/formats/asf.h"

namespace ugoki::formats {
namespace {

const std::string good_asf =
    ":version 1.10\n"                              // line 1
    ":units\n mass 1\n length 0.45\n angle deg\n"  // 2-5
    ":root\n"                                      // 6
    " order TX TY TZ RX RY RZ\n"                   // 7
    " axis XYZ\n"                                  // 8
    " position 0 0 0\n orientation 0 0 0\n"        // 9, 10
    ":bonedata\n"                                  // 11
    " begin\n  name thigh\n"                       // 12, 13
    "  direction 0 -1 0\n  length 7\n"             // 14, 15
    "  axis 0 0 20 XYZ\n"                          // 16
    "  dof rx ry\n"                                // 17
    "  limits (-160 20)\n   (-70 70)\n"            // 18, 19
    " end\n"                                       // 20
    " begin\n  name shin\n"                        // 21, 22
    "  direction 0 -1 0\n  length 6\n"             // 23, 24
    "  axis 0 0 20 XYZ\n  dof rx\n end\n"          // 25-27
    ":hierarchy\n begin\n"                         // 28, 29
    "  root thigh\n"                               // 30
    "  thigh shin\n"                               // 31
    " end\n";                                      // 32

const std::string good_amc =
    "#!OML:ASF character\n:FULLY-SPECIFIED\n:DEGREES\n"            // lines 1-3
    "1\nroot 1 2 3 4 5 6\nthigh 7 8\nshin 9\n"                     // 4-7
    "2\nroot 1.5 2.5 3.5 4.5 5.5 6.5\nthigh 7.5 8.5\nshin 9.5\n";  // 8-11

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}
std::string asf_with(const std::string& from, const std::string& to) { return replaced(good_asf, from, to); }
std::string amc_with(const std::string& from, const std::string& to) { return replaced(good_amc, from, to); }

Result<Asf> read(const std::string& text) { return read_asf(text, "bad.asf"); }
Result<MeasuredMotion> read_motion(const std::string& text) {
  static const Asf asf = *read_asf(good_asf, "good.asf");
  return read_amc(text, "bad.amc", asf);
}

struct Case {
  const char* what;
  std::string text;
  int line;
};

TEST(AsfHostile, EachFaultIsReportedAtItsLine) {
  ASSERT_TRUE(read(good_asf).has_value());
  const std::vector<Case> cases = {
      {"empty", "", 1},
      {"binary", std::string(":units\n\x00\x01\x02", 10), 2},
      {"UTF-16", std::string("\xFF\xFE:\0", 4), 1},
      {"another format", "HIERARCHY\nROOT a\n", 1},
      {"mass scale of zero", asf_with("mass 1", "mass 0"), 3},
      {"negative length scale", asf_with("length 0.45", "length -0.45"), 4},
      {"length scale of NaN", asf_with("length 0.45", "length nan"), 4},
      {"length scale missing", asf_with("length 0.45", "length"), 4},
      {"unknown angle unit", asf_with("angle deg", "angle grad"), 5},
      {"unknown root channel", asf_with("RX RY RZ", "RX RY RW"), 7},
      {"root channel twice", asf_with("RX RY RZ", "RX RY RY"), 7},
      {"root without order", asf_with(" order TX TY TZ RX RY RZ\n", ""), 9},
      {"root axis of two letters", asf_with("axis XYZ", "axis XY"), 8},
      {"root axis of one letter thrice", asf_with("axis XYZ", "axis XXX"), 8},
      {"root position of two numbers", asf_with("position 0 0 0", "position 0 0"), 9},
      {"root orientation of letters", asf_with("orientation 0 0 0", "orientation a b c"), 10},
      {"unknown word of the root", asf_with("position 0", "postition 0"), 9},
      {"no bones", asf_with(":bonedata", ":bones"), 30},
      {"no hierarchy", good_asf.substr(0, good_asf.find(":hierarchy")), 28},
      {"no root", asf_with(":root", ":toor"), 33},
      {"two hierarchies", good_asf + ":hierarchy\n", 33},
      {"word outside of a bone", asf_with(" begin\n  name thigh", "  name thigh"), 12},
      {"bone inside of a bone", asf_with(" end\n begin\n  name shin", " begin\n  name shin"), 20},
      {"last bone not ended", asf_with(" end\n:hierarchy", ":hierarchy"), 27},
      {"no name", asf_with("  name thigh\n", ""), 12},
      {"empty name", asf_with("name thigh", "name"), 13},
      {"two bones of one name", asf_with("name shin", "name thigh"), 22},
      {"bone called root", asf_with("name shin", "name root"), 22},
      {"no direction", asf_with("  direction 0 -1 0\n", ""), 12},
      {"direction of zero", asf_with("direction 0 -1 0", "direction 0 0 0"), 12},
      {"direction of two numbers", asf_with("direction 0 -1 0", "direction 0 -1"), 14},
      {"direction of infinity", asf_with("direction 0 -1 0", "direction 0 -inf 0"), 14},
      {"no length", asf_with("  length 7\n", ""), 12},
      {"negative length", asf_with("length 7", "length -7"), 15},
      {"length of letters", asf_with("length 7", "length long"), 15},
      {"huge length", asf_with("length 7", "length 7e200"), 15},
      {"axis of two numbers", asf_with("axis 0 0 20 XYZ", "axis 0 20 XYZ"), 16},
      {"axis order unknown", asf_with("axis 0 0 20 XYZ", "axis 0 0 20 XYW"), 16},
      {"unknown degree of freedom", asf_with("dof rx ry", "dof rx rw"), 17},
      {"degree of freedom twice", asf_with("dof rx ry", "dof rx rx"), 17},
      {"fewer limits than degrees of freedom", asf_with("   (-70 70)\n", ""), 18},
      {"incomplete pair of limits", asf_with("(-70 70)", "(-70)"), 18},
      {"more limits than degrees of freedom", asf_with("(-70 70)", "(-70 70) (1 2)"), 18},
      {"lower limit above upper limit", asf_with("(-70 70)", "(70 -70)"), 19},
      {"limits of letters", asf_with("(-160 20)", "(-160 far)"), 18},
      {"limits without degrees of freedom", asf_with("  dof rx ry\n", ""), 17},
      {"negative mass", asf_with("dof rx ry", "bodymass -1"), 17},
      {"hierarchy without begin", asf_with(":hierarchy\n begin\n", ":hierarchy\n"), 29},
      {"hierarchy begun twice", asf_with(":hierarchy\n begin\n", ":hierarchy\n begin\n begin\n"), 30},
      {"hierarchy not ended", asf_with("  thigh shin\n end\n", "  thigh shin\n"), 32},
      {"unknown parent", asf_with("thigh shin\n", "leg shin\n"), 31},
      {"unknown child", asf_with("thigh shin\n", "thigh skin\n"), 31},
      {"root as child", asf_with("thigh shin\n", "thigh shin root\n"), 31},
      {"two parents", asf_with("thigh shin\n", "thigh shin\n root shin\n"), 32},
      {"its own parent", asf_with("root thigh\n", "shin thigh\n"), 12},
      {"bone without parent", asf_with("  thigh shin\n", ""), 21},
  };
  for (const Case& c : cases) expect_refused_at(read(c.text), c.line, c.what);
}

TEST(AmcHostile, EachFaultIsReportedAtItsLine) {
  ASSERT_TRUE(read_motion(good_amc).has_value());
  const std::vector<Case> cases = {
      {"empty", "", 1},
      {"binary", std::string("1\nroot \x00", 8), 2},
      {"UTF-16", std::string("\xFF\xFE:\0", 4), 1},
      {"another format", "HIERARCHY\nROOT a\n", 1},
      {"header only", good_amc.substr(0, good_amc.find("1\n")), 4},
      {"bone before the first frame", amc_with("1\nroot", "root"), 4},
      {"unknown bone", amc_with("thigh 7 8", "leg 7 8"), 6},
      {"bone twice", amc_with("thigh 7 8\n", "thigh 7 8\nthigh 7 8\n"), 7},
      {"bone missing", amc_with("thigh 7 8\n", ""), 4},
      {"bone missing in the last frame", amc_with("shin 9.5\n", ""), 8},
      {"root missing", amc_with("root 1 2 3 4 5 6\n", ""), 4},
      {"fewer numbers than degrees of freedom", amc_with("thigh 7 8", "thigh 7"), 6},
      {"more numbers than degrees of freedom", amc_with("thigh 7 8", "thigh 7 8 9"), 6},
      {"no numbers", amc_with("thigh 7 8", "thigh"), 6},
      {"NaN", amc_with("thigh 7 8", "thigh 7 nan"), 6},
      {"infinity", amc_with("thigh 7 8", "thigh 7 -inf"), 6},
      {"letters", amc_with("thigh 7 8", "thigh 7 x"), 6},
      {"comma", amc_with("thigh 7 8", "thigh 7 8,5"), 6},
      {"huge", amc_with("thigh 7 8", "thigh 7 8e300"), 6},
      {"frame twice", amc_with("2\nroot", "1\nroot"), 8},
      {"frames backwards", amc_with("1\nroot", "5\nroot"), 8},
      {"negative frame", amc_with("1\nroot", "-1\nroot"), 4},
      {"fractional frame", amc_with("1\nroot", "1.5\nroot"), 4},
      {"frame beyond integers", amc_with("2\nroot", "99999999999999999999999\nroot"), 8},
      {"frame number far beyond the previous one", amc_with("2\nroot", "2000000000\nroot"), 8},
      {"gap of more than a second", amc_with("2\nroot", "123\nroot"), 8},
      {"numbers after the frame number", amc_with("2\nroot", "2 3\nroot"), 8},
      {"header between frames", amc_with("2\nroot", ":RADIANS\n2\nroot"), 8},
      {"names of another skeleton", amc_with("root 1", "Hips 1"), 5},
  };
  for (const Case& c : cases) expect_refused_at(read_motion(c.text), c.line, c.what);
}

TEST(AmcHostile, FramesOutOfOrderAreReported) {
  for (const char* number : {"0", "1"}) {
    const auto result = read_motion(amc_with("2\nroot", std::string(number) + "\nroot"));
    expect_refused_at(result, 8, number);
    EXPECT_NE(result.error().problems[0].message.find("follows frame 1"), std::string::npos) << result.error().text();
  }
}

TEST(AsfHostile, TruncationAtAnyByteIsRejected) {
  for (std::size_t n = 0; n + 1 < good_asf.size(); ++n)
    expect_refused(read(good_asf.substr(0, n)), "cut after " + std::to_string(n) + " bytes");
}

TEST(AmcHostile, TruncationAtAnyByteIsRejected) {
  const std::size_t one_frame = good_amc.find("2\nroot");
  for (std::size_t n = 0; n < good_amc.size(); ++n) {
    const auto result = read_motion(good_amc.substr(0, n));
    if (result)
      EXPECT_TRUE((n >= one_frame - 1 && n <= one_frame) || n >= good_amc.size() - 3) << n << " bytes";
    else
      expect_refused(result, "cut after " + std::to_string(n) + " bytes");
  }
}

TEST(AsfHostile, CycleOfBonesIsRejected) {
  std::string text = good_asf;
  const std::string bone = " begin\n  name X\n  direction 0 1 0\n  length 1\n end\n";
  for (const char* name : {"a", "b", "c"}) text.insert(text.find(":hierarchy"), replaced(bone, "X", name));
  text.insert(text.rfind(" end"), "  a b\n  b c\n  c a\n");
  const auto result = read(text);
  expect_refused(result, "cycle");
  EXPECT_EQ(result.error().problems.size(), 3U);
}

TEST(AsfHostile, LongChainOfBonesIsReadWithoutRecursion) {
  std::string bones, tree = "root b0\n";
  for (int i = 0; i < 9'000; ++i) {
    bones += "begin\nname b" + std::to_string(i) + "\ndirection 0 1 0\nlength 1\nend\n";
    if (i > 0) tree += "b" + std::to_string(i - 1) + " b" + std::to_string(i) + "\n";
  }
  const auto asf = read(":root\norder TX\n:bonedata\n" + bones + ":hierarchy\nbegin\n" + tree + "end\n");
  ASSERT_TRUE(asf.has_value()) << asf.error().text();
  EXPECT_EQ(asf->skeleton.joints.size(), 9'001U);
  std::string frames;
  for (int f = 0; f < 20'000; ++f) frames += std::to_string(f) + "\nroot 1\n";
  expect_refused(read_amc(frames, "a.amc", *asf), "9000 rigid bones in 20000 frames");
  for (int i = 9'000; i < 11'000; ++i) bones += "begin\nname b" + std::to_string(i) + "\ndirection 0 1 0\nlength 1\nend\n";
  expect_refused(read(":root\norder TX\n:bonedata\n" + bones), "11000 bones");
}

}  // namespace
}  // namespace ugoki::formats
