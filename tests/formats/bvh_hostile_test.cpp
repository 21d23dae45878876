// Broken and hostile BVH files are rejected with file:line, a message and a remedy, in little time and memory.
#include <set>

#include "expect.h"
#include "ugoki/formats/bvh.h"

namespace ugoki::formats {
namespace {

const std::string good =
    "HIERARCHY\n"                                                               // line 1
    "ROOT Hips\n{\n"                                                            // 2, 3
    "OFFSET 0 0 0\n"                                                            // 4
    "CHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation\n"  // 5
    "JOINT Spine\n{\n"                                                          // 6, 7
    "OFFSET 0 1 0\n"                                                            // 8
    "CHANNELS 3 Zrotation Xrotation Yrotation\n"                                // 9
    "End Site\n{\n"                                                             // 10, 11
    "OFFSET 0 0.7 0\n"                                                          // 12
    "}\n}\n}\n"                                                                 // 13-15
    "MOTION\n"                                                                  // 16
    "Frames: 2\n"                                                               // 17
    "Frame Time: 0.0083333\n"                                                   // 18
    "1 2 3 4 5 6 7 8 9\n"                                                       // 19
    "1.5 2.5 3.5 4.5 5.5 6.5 7.5 8.5 9.5\n";                                    // 20

Result<MeasuredMotion> read(const std::string& text) { return read_bvh(text, "bad.bvh"); }

std::string with(const std::string& from, const std::string& to) {
  std::string text = good;
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

TEST(BvhHostile, ValidFileIsAccepted) { ASSERT_TRUE(read(good).has_value()); }

struct Case {
  const char* what;
  std::string text;
  int line;
};

TEST(BvhHostile, EachFaultIsReportedAtItsLine) {
  const std::vector<Case> cases = {
      {"empty", "", 1},
      {"blank", " \n\t\r\n", 1},
      {"binary", std::string("HIERARCHY\nROOT \x01\x02\x00 a", 19), 2},
      {"zip", "PK\x03\x04 not a motion", 1},
      {"UTF-16 little end", std::string("\xFF\xFEH\0I\0", 6), 1},
      {"UTF-16 big end", std::string("\xFE\xFF\0H\0I", 6), 1},
      {"another format", ":version 1.10\n:name VICON\n", 1},
      {"no HIERARCHY", good.substr(10), 1},
      {"no root", "HIERARCHY\nMOTION\nFrames: 1\nFrame Time: 1\n1\n", 2},
      {"JOINT before ROOT", with("ROOT Hips", "JOINT Hips"), 2},
      {"ROOT inside", with("JOINT Spine", "ROOT Spine"), 6},
      {"End Site outside", "HIERARCHY\nEnd Site\n{\nOFFSET 0 0 0\n}\n", 2},
      {"OFFSET outside", "HIERARCHY\nOFFSET 0 0 0\n", 2},
      {"CHANNELS outside", "HIERARCHY\nCHANNELS 0\n", 2},
      {"brace without joint", with("}\n}\n}\nMOTION", "}\n}\n}\n}\nMOTION"), 16},
      {"missing opening brace", with("ROOT Hips\n{\n", "ROOT Hips\n"), 3},
      {"missing opening brace of the end", with("End Site\n{\n", "End Site\n"), 11},
      {"missing closing brace", with("}\n}\n}\nMOTION", "}\n}\nMOTION"), 15},
      {"unknown word", with("OFFSET 0 1 0", "OFSET 0 1 0"), 8},
      {"offset of two numbers", with("OFFSET 0 1 0", "OFFSET 0 1"), 8},
      {"offset of four numbers", with("OFFSET 0 1 0", "OFFSET 0 1 0 0"), 8},
      {"offset of letters", with("OFFSET 0 1 0", "OFFSET a b c"), 8},
      {"offset of NaN", with("OFFSET 0 1 0", "OFFSET 0 nan 0"), 8},
      {"offset of infinity", with("OFFSET 0 1 0", "OFFSET 0 -inf 0"), 8},
      {"huge offset", with("OFFSET 0 1 0", "OFFSET 0 1e300 0"), 8},
      {"overflowing offset", with("OFFSET 0 1 0", "OFFSET 0 1e999 0"), 8},
      {"decimal comma", with("OFFSET 0 1 0", "OFFSET 0 1,5 0"), 8},
      {"no offset", with("OFFSET 0 1 0\n", ""), 6},
      {"no offset of the end", with("OFFSET 0 0.7 0\n", ""), 10},
      {"two offsets", with("OFFSET 0 1 0\n", "OFFSET 0 1 0\nOFFSET 0 1 0\n"), 9},
      {"two channel lists", with("End Site", "CHANNELS 1 Xrotation\nEnd Site"), 10},
      {"wrong channel name", with("Xrotation Yrotation\nEnd", "Xrotation Qrotation\nEnd"), 9},
      {"scale channel", with("Xrotation Yrotation\nEnd", "Xrotation Yscale\nEnd"), 9},
      {"channel count too small", with("CHANNELS 3", "CHANNELS 2"), 9},
      {"channel count too large", with("CHANNELS 3", "CHANNELS 4"), 10},
      {"negative channel count", with("CHANNELS 3", "CHANNELS -3"), 9},
      {"huge channel count", with("CHANNELS 3", "CHANNELS 99999999999999999999"), 9},
      {"channel count of letters", with("CHANNELS 3", "CHANNELS three"), 9},
      {"position twice", with("Xposition Yposition Zposition", "Xposition Xposition Zposition"), 5},
      {"four rotations", with("Xposition Yposition Zposition Z", "Xrotation Yposition Zposition Z"), 5},
      {"no channels at all", "HIERARCHY\nROOT a\n{\nOFFSET 0 0 0\n}\nMOTION\nFrames: 2000000000\nFrame Time: 1\n", 6},
      {"no Frames", with("Frames: 2\n", ""), 17},
      {"Frames of letters", with("Frames: 2", "Frames: two"), 17},
      {"Frames without number", with("Frames: 2", "Frames:"), 17},
      {"no frames", with("Frames: 2", "Frames: 0"), 17},
      {"negative frames", with("Frames: 2", "Frames: -2"), 17},
      {"fractional frames", with("Frames: 2", "Frames: 2.5"), 17},
      {"two thousand million frames", with("Frames: 2", "Frames: 2000000000"), 18},
      {"frames beyond integers", with("Frames: 2", "Frames: 99999999999999999999999"), 17},
      {"frames that overflow a product", with("Frames: 2", "Frames: 2049638230412172402"), 18},
      {"no Frame Time", with("Frame Time: 0.0083333\n", ""), 18},
      {"Frame Time of zero", with("0.0083333", "0"), 18},
      {"negative Frame Time", with("0.0083333", "-0.01"), 18},
      {"Frame Time of NaN", with("0.0083333", "nan"), 18},
      {"Frame Time of letters", with("0.0083333", "fast"), 18},
      {"Frame Time missing", with(" 0.0083333", ""), 18},
      {"huge Frame Time", with("0.0083333", "1e30"), 18},
      {"tiny Frame Time", with("0.0083333", "1e-300"), 18},
      {"fewer frames", with("Frames: 2", "Frames: 3"), 21},
      {"more frames", with("Frames: 2", "Frames: 1"), 21},
      {"short line", with("1 2 3 4 5 6 7 8 9\n", "1 2 3 4 5 6 7 8\n"), 19},
      {"long line", with("1 2 3 4 5 6 7 8 9\n", "1 2 3 4 5 6 7 8 9 10\n"), 19},
      {"NaN in a frame", with("2.5", "nan"), 20},
      {"Microsoft's NaN", with("2.5", "-1.#IND00"), 20},
      {"infinity in a frame", with("2.5", "inf"), 20},
      {"word in a frame", with("2.5", "x"), 20},
      {"comma in a frame", with("2.5", "2,5"), 20},
      {"hexadecimal in a frame", with("2.5", "0x1p3"), 20},
      {"huge angle", with("8.5", "1e20"), 20},
      {"brace in a frame", with("2.5", "}"), 20},
      {"second motion", good + good, 21},
  };
  EXPECT_GE(cases.size(), 60U);
  for (const Case& c : cases) expect_refused_at(read(c.text), c.line, c.what);
}

TEST(BvhHostile, FrameCountBeyondTheTextIsRejectedBeforeAllocation) {
  const auto result = read(with("Frames: 2", "Frames: 40000000"));  // would need 360 million numbers
  expect_refused_at(result, 18, "40 million frames");
  EXPECT_NE(result.error().problems[0].message.find("too short"), std::string::npos) << result.error().text();
}

TEST(BvhHostile, TruncationAtAnyByteIsRejected) {
  // The error of each truncated file names a line. A file that lost only the last digits of its last number is still valid.
  int refused = 0;
  for (std::size_t n = 0; n < good.size(); ++n) {
    const auto result = read(good.substr(0, n));
    if (result) {
      EXPECT_GE(n, good.size() - 3) << good.substr(0, n);
      continue;
    }
    expect_refused(result, "cut after " + std::to_string(n) + " bytes");
    ++refused;
  }
  EXPECT_GE(refused, static_cast<int>(good.size()) - 3);
}

TEST(BvhHostile, ReplacedTokenGivesMotionOrErrorWithLine) {
  // For every replacement of a token, the reader returns a motion or an error that names a line.
  for (const std::string& bad : {std::string("{"), std::string("}"), std::string("nan"), std::string("-1"), std::string("MOTION"),
                                 std::string("End"), std::string(5000, '9'), std::string("\xFF\xC0"), std::string()}) {
    std::size_t begin = 0;
    while ((begin = good.find_first_not_of(" \n", begin)) != std::string::npos) {
      const std::size_t end = good.find_first_of(" \n", begin);
      const auto result = read(good.substr(0, begin) + bad + good.substr(end));
      if (!result) expect_refused(result, "token at " + std::to_string(begin) + " replaced by " + bad.substr(0, 10));
      begin = end;
    }
  }
}

std::string nested(std::size_t depth) {
  std::string text = "HIERARCHY\nROOT a\n{\nOFFSET 0 0 0\nCHANNELS 1 Xrotation\n";
  for (std::size_t i = 0; i < depth; ++i) text += "JOINT a\n{\nOFFSET 0 0 0\nCHANNELS 1 Xrotation\n";
  for (std::size_t i = 0; i <= depth; ++i) text += "}\n";
  text += "MOTION\nFrames: 1\nFrame Time: 1\n";
  for (std::size_t i = 0; i <= depth; ++i) text += "0 ";
  return text;
}

TEST(BvhHostile, DepthAndJointCountAreLimited) {
  ASSERT_TRUE(read(nested(900)).has_value());
  expect_refused(read(nested(1'001)), "nested 1001 deep");
  expect_refused(read(nested(200'000)), "nested 200000 deep");
  std::string wide = "HIERARCHY\nROOT a\n{\nOFFSET 0 0 0\nCHANNELS 1 Xrotation\n";
  for (int i = 0; i < 10'001; ++i) wide += "JOINT a { OFFSET 0 0 0\n}\n";
  expect_refused(read(wide + "}\nMOTION\nFrames: 1\nFrame Time: 1\n0\n"), "10002 joints");
}

TEST(BvhHostile, ManyRigidJointsInManyFramesAreRejected) {
  std::string text = "HIERARCHY\nROOT a\n{\nOFFSET 0 0 0\nCHANNELS 1 Xrotation\n";
  for (int i = 0; i < 9'000; ++i) text += "JOINT a { OFFSET 0 0 0\n}\n";
  text += "}\nMOTION\nFrames: 100000\nFrame Time: 1\n";
  for (int i = 0; i < 100'000; ++i) text += "0\n";
  expect_refused(read(text), "9000 rigid joints in 100000 frames");
}

TEST(BvhHostile, AtMostTwentyProblemsAreReported) {
  std::string text = good;
  text.replace(text.find("Frames: 2"), 9, "Frames: 300");
  for (int i = 0; i < 298 * 9; ++i) text += "bad\n";
  const auto result = read(text);
  expect_refused(result, "thousands of faults");
  EXPECT_EQ(result.error().problems.size(), 20U);
}

}  // namespace
}  // namespace ugoki::formats
