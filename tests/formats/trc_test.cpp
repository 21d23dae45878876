#include "ugoki/formats/trc.h"

#include <fstream>
#include <iterator>
#include <sstream>

#include "expect.h"

namespace ugoki::formats {
namespace {

const std::string good =
    "PathFileType\t4\t(X/Y/Z)\twalk.trc\n"                                                                   // line 1
    "DataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits\tOrigDataRate\tOrigDataStartFrame\tOrigNumFrames\n"  // 2
    "50\t50\t2\t2\tmm\t50\t7\t2\n"                                                                           // 3
    "Frame#\tTime\tHead\t\t\tHeel\t\t\n"                                                                     // 4
    "\t\tX1\tY1\tZ1\tX2\tY2\tZ2\n"                                                                           // 5
    "\n"                                                                                                     // 6
    "7\t0.12\t1\t1700\t3\t4\t20\t300\n"                                                                      // 7
    "8\t0.14\t\t\t\t4.5\t20.5\t300.5\n";

std::string with(const std::string& from, const std::string& to) {
  std::string text = good;
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

TEST(Trc, MarkersAreConvertedToOurAxes) {
  const auto m = read_trc(good, "walk.trc");
  ASSERT_TRUE(m.has_value()) << text_of(m.error());
  EXPECT_EQ(m->labels, (std::vector<std::string>{"Head", "Heel"}));
  EXPECT_EQ(m->frames, 2);
  EXPECT_EQ(m->first_frame, 7);
  EXPECT_EQ(m->rate, 50);
  expect_near(m->at(0, 0), {0.003, 0.001, 1.7}, 1e-12, "Y up");
  expect_near(m->at(1, 1), {0.3005, 0.0045, 0.0205}, 1e-12, "second frame");
  EXPECT_TRUE(m->seen(0, 0));
  EXPECT_FALSE(m->seen(1, 0));
}

TEST(Trc, ValuesBelowTheLastFrameAreLeftOut) {
  ReadNotes notes;
  const auto m = read_trc(good + "\n\t\t\t127.5\t\t\t\t\n\t\t\t\t\t\t\t54\n", "walk.trc", {}, &notes);
  ASSERT_TRUE(m.has_value()) << text_of(m.error());
  EXPECT_EQ(m->frames, 2);
  ASSERT_FALSE(notes.remarks.empty());
  EXPECT_NE(notes.remarks[0].find("line 10"), std::string::npos) << notes.remarks[0];
  // Before the last frame, such a row is an error.
  EXPECT_FALSE(read_trc(with("8\t0.14\t", "\t\t1\t2\t3\t\t\t\n8\t0.14\t"), "walk.trc").has_value());
}

TEST(Trc, SteadyTimesCorrectAWrongDataRate) {
  const auto file = [](int period) {  // every period-th time is 0.02 s late
    std::string text = good.substr(0, good.find("7\t0.12"));
    text.replace(text.find("50\t50\t2\t2"), 9, "250\t250\t20\t2");
    for (int i = 0; i < 20; ++i) {
      const double time = 0.04 * i + (i % period == period - 1 ? 0.02 : 0);
      text += std::to_string(i) + "\t" + std::to_string(time) + "\t1\t2\t3\t4\t5\t6\n";
    }
    return text;
  };
  ReadNotes notes;
  const auto steady = read_trc(file(20), "walk.trc", {}, &notes), uneven = read_trc(file(3), "walk.trc");
  ASSERT_TRUE(steady.has_value()) << text_of(steady.error());
  ASSERT_TRUE(uneven.has_value()) << text_of(uneven.error());
  EXPECT_NEAR(steady->rate, 25, 1e-9);
  EXPECT_EQ(uneven->rate, 250);
  ASSERT_FALSE(notes.remarks.empty());
  EXPECT_NE(notes.remarks[0].find("the times are assumed to be right"), std::string::npos) << notes.remarks[0];
}

TEST(Trc, CommasAndWindowsLineEndsGiveTheSameMarkers) {
  std::string other;
  for (const char c : good) other += c == '\t' ? "," : c == '\n' ? "\r\n" : std::string(1, c);
  const auto a = read_trc(good, "walk.trc"), b = read_trc(other, "walk.trc");
  ASSERT_TRUE(a.has_value() && b.has_value());
  EXPECT_EQ(a->positions, b->positions);
  EXPECT_EQ(a->labels, b->labels);
}

TEST(Trc, RoundTripKeepsMarkers) {
  const auto m = read_trc(good, "walk.trc");
  ASSERT_TRUE(m.has_value());
  for (const bool z_up : {false, true}) {
    const auto back = read_trc(write_trc(*m, {.z_up = z_up}), "walk.trc", {.up = z_up ? UpAxis::z : UpAxis::y});
    ASSERT_TRUE(back.has_value()) << text_of(back.error());
    EXPECT_EQ(back->labels, m->labels);
    EXPECT_EQ(back->residuals, m->residuals);
    EXPECT_EQ(back->first_frame, m->first_frame);
    for (std::size_t i = 0; i < m->positions.size(); ++i) expect_near(back->positions[i], m->positions[i], 1e-9, "position");
  }
}

TEST(Trc, BrokenFilesAreRejectedAtTheirLine) {
  struct Case {
    const char* what;
    std::string text;
    int line;
  };
  for (const Case& c :
       {Case{"empty", "", 1},
        {"another format", "HIERARCHY\n", 1},
        {"truncated header", good.substr(0, 60), 2},
        {"no rate", with("50\t50\t2", "fast\t50\t2"), 3},
        {"rate nan", with("50\t50\t2", "nan\t50\t2"), 3},
        {"no names", with("Frame#\tTime\tHead\t\t\tHeel\t\t", "Frame#\tTime"), 4},
        {"not a number", with("1700\t3", "high\t3"), 7},
        {"infinite", with("1700\t3", "inf\t3"), 7},
        {"huge", with("1700\t3", "1e300\t3"), 7},
        {"no frame number", with("8\t0.14", "x\t0.14"), 8},
        {"too many numbers", with("20\t300", "20\t300\t7"), 7},
        {"more frames declared, last row incomplete", with("\t300.5", "").replace(good.find("50\t50\t2"), 8, "50\t50\t9"), 8},
        {"fewer frames declared", with("50\t50\t2", "50\t50\t1"), 8}}) {
    expect_refused_at(read_trc(c.text, "bad.trc"), c.line, c.what);
  }
}

TEST(Trc, ColumnsDecideHowManyMarkersThereAre) {
  // Computed markers were named behind the counted ones: with columns they are read, without columns they are left out.
  const std::string named = with("Heel\t\t", "Heel\t\t\tHip\t\t\tHip\t\t");
  for (const bool columns : {true, false}) {
    std::string text = named;
    if (columns)
      for (const char* row : {"\t300\n", "\t300.5\n"}) {
        const std::size_t at = text.find(row);
        text.insert(text.find('\n', at), "\t\t\t\t\t\t");
      }
    const auto m = read_trc(text, "walk.trc");
    ASSERT_TRUE(m.has_value()) << text_of(m.error());
    EXPECT_EQ(m->labels, columns ? (std::vector<std::string>{"Head", "Heel", "Hip", "Hip 2"}) : (std::vector<std::string>{"Head", "Heel"}));
    EXPECT_FALSE(columns && m->seen(0, 3));
    expect_near(m->at(0, 0), {0.003, 0.001, 1.7}, 1e-12, "first marker");
  }
}

TEST(Trc, TrajectoriesWithoutNameAreUnlabelledMarkers) {
  std::string text = with("\t2\t2\tmm", "\t2\t3\tmm");
  for (const char* row : {"\t300\n", "\t300.5\n"}) text.insert(text.find('\n', text.find(row)), "\t100\t200\t300");
  const auto m = read_trc(text, "walk.trc");
  ASSERT_TRUE(m.has_value()) << text_of(m.error());
  EXPECT_EQ(m->labels, (std::vector<std::string>{"Head", "Heel", "*2"}));
  expect_near(m->at(1, 2), {0.3, 0.1, 0.2}, 1e-12, "unlabelled marker");
}

TEST(Trc, AHeaderAlignedByBlanksIsRead) {
  std::string text = good;
  for (std::size_t at = text.find("DataRate"), end = text.find("\n7"); at < end; ++at)
    if (text[at] == '\t') text.replace(at, 1, "   "), end += 2;
  // Rows with an empty column before the frame number.
  text.replace(text.find("\n7"), 2, "\n\t7");
  text.replace(text.find("\n8"), 2, "\n\t8");
  const auto m = read_trc(text, "walk.trc");
  ASSERT_TRUE(m.has_value()) << text_of(m.error());
  EXPECT_EQ(m->labels, (std::vector<std::string>{"Head", "Heel"}));
  EXPECT_EQ(m->rate, 50);
  expect_near(m->at(1, 1), {0.3005, 0.0045, 0.0205}, 1e-12, "second frame");
}

TEST(Trc, SharedRecordingsHaveExpectedMarkersFramesAndRate) {
  const std::string folder = std::string(UGOKI_SOURCE_DIR) + "/../shared/data/";
  struct Expected {
    const char* file;
    int markers, frames;
    double rate;
  };
  for (const Expected& e : {Expected{"animal/rat_walk_23.trc", 23, 1000, 50}, Expected{"human/trc/pyomeca_markers.trc", 51, 93, 100}}) {
    std::ifstream in(folder + e.file, std::ios::binary);
    if (!in) GTEST_SKIP() << "no " << folder << e.file;
    const auto m = read_trc(std::string{std::istreambuf_iterator<char>(in), {}}, e.file);
    ASSERT_TRUE(m.has_value()) << text_of(m.error());
    EXPECT_EQ(m->marker_count(), e.markers);
    EXPECT_EQ(m->frames, e.frames);
    EXPECT_EQ(m->rate, e.rate);
  }
}

}  // namespace
}  // namespace ugoki::formats
