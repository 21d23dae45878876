// C3D files of every processor and number format, built byte by byte (c3d_bytes.h), independently of the writer.
#include "ugoki/formats/c3d.h"

#include <cstring>
#include <fstream>
#include <iterator>

#include "c3d_bytes.h"
#include "expect.h"

namespace ugoki::formats {
namespace {

using Kind = C3dBytes::Kind;

Result<MarkerMotion> read(const C3dBytes& file, const MarkerOptions& options = {}, ReadNotes* notes = nullptr) {
  const std::vector<std::byte> bytes = file.finish();
  return read_c3d(bytes, "walk.c3d", options, notes);
}

TEST(C3d, EveryProcessorAndNumberFormatGivesTheSameRecording) {
  for (const Kind kind : {Kind::intel, Kind::dec, Kind::mips}) {
    for (const bool real : {false, true}) {
      SCOPED_TRACE(std::to_string(static_cast<int>(kind)) + (real ? " floating point" : " integer"));
      const auto m = read(C3dBytes::sample(kind, real));
      ASSERT_TRUE(m.has_value()) << text_of(m.error());
      EXPECT_EQ(m->name, "walk");
      EXPECT_EQ(m->frames, 3);
      EXPECT_EQ(m->first_frame, 5);
      EXPECT_DOUBLE_EQ(m->rate, 50);
      EXPECT_DOUBLE_EQ(m->unit, 0.001);
      EXPECT_EQ(m->labels, (std::vector<std::string>{"LASI", "RASI"}));
      // Marker i of frame f is at (10 f + 100 i, -20 f, 900 + 100 i) mm, Z up; RASI is not seen in frame 1.
      for (int f = 0; f < 3; ++f) {
        for (int i = 0; i < 2; ++i) {
          const bool hidden = f == 1 && i == 1;
          EXPECT_EQ(m->seen(f, i), !hidden);
          expect_near(m->at(f, i), hidden ? Vec3{} : Vec3{0.01 * f + 0.1 * i, -0.02 * f, 0.9 + 0.1 * i}, 1e-7, "position");
          if (!hidden) EXPECT_NEAR(m->residuals[m->index(f, i)], 0.0005 * (f + 1), 1e-7);
        }
      }
      ASSERT_EQ(m->analog.size(), 2U);
      EXPECT_EQ(m->analog[0].label, "Fz");
      EXPECT_EQ(m->analog[0].unit, "N");
      EXPECT_DOUBLE_EQ(m->analog_rate, 100);
      // The raw value of sample s of channel c is 100 s + c; the offset is 10, the scales 0.5 and 2, the general scale 3.
      ASSERT_EQ(m->samples.size(), 12U);
      for (int s = 0; s < 6; ++s) {
        EXPECT_NEAR(m->samples[static_cast<std::size_t>(2 * s)], (100.0 * s - 10) * 0.5 * 3, 1e-3);
        EXPECT_NEAR(m->samples[static_cast<std::size_t>(2 * s + 1)], (100.0 * s + 1 - 10) * 2 * 3, 1e-3);
      }
      ASSERT_EQ(m->events.size(), 2U);
      EXPECT_EQ(m->events[0].label, "Foot Strike");
      EXPECT_EQ(m->events[0].context, "Left");
      EXPECT_NEAR(m->events[0].time, 0.25, 1e-6);
      EXPECT_NEAR(m->events[1].time, 61.5, 1e-5);
      ASSERT_EQ(m->plates.size(), 1U);
      EXPECT_EQ(m->plates[0].type, 2);
      expect_near(m->plates[0].corners[2], {0.4, 0.6, 0}, 1e-6, "corner");
      EXPECT_EQ(m->plates[0].channels, (std::vector<int>{0, 1, 0, 1, 0, 1}));
    }
  }
}

TEST(C3d, UnsignedAnalogSamplesAbove32767AreRead) {
  C3dBytes file = C3dBytes::sample(Kind::intel, false);
  file.unsigned_analog = true;
  const auto m = read(file);
  ASSERT_TRUE(m.has_value()) << text_of(m.error());
  EXPECT_NEAR(m->samples[0], (40000.0 - 10) * 0.5 * 3, 1e-3);
}

TEST(C3d, YScreenParameterSetsTheUpAxis) {
  C3dBytes file = C3dBytes::sample(Kind::intel, true);
  file.y_screen = "+Y";
  const auto m = read(file);
  ASSERT_TRUE(m.has_value());
  expect_near(m->at(2, 0), {0.9, 0.02, -0.04}, 1e-7, "Y up");  // (x, y, z) of the file is (z, x, y) in our axes
  const auto forced = read(file, {.up = UpAxis::z});
  ASSERT_TRUE(forced.has_value());
  expect_near(forced->at(2, 0), {0.02, -0.04, 0.9}, 1e-7, "forced");
}

TEST(C3d, UnknownUnitIsGuessedAndNoted) {
  C3dBytes file = C3dBytes::sample(Kind::intel, true);
  file.units = "km";
  ReadNotes notes;
  ASSERT_TRUE(read(file, {}, &notes).has_value());
  EXPECT_FALSE(notes.remarks.empty());
  EXPECT_TRUE(notes.unit_guessed);
}

TEST(C3d, PositionsThatAreNotFiniteAreNotSeen) {
  C3dBytes file = C3dBytes::sample(Kind::intel, true);
  file.not_a_number = true;
  ReadNotes notes;
  const auto m = read(file, {}, &notes);
  ASSERT_TRUE(m.has_value());
  EXPECT_FALSE(m->seen(0, 0));
  EXPECT_TRUE(is_finite(m->at(0, 0)));
  EXPECT_TRUE(m->seen(0, 1));
  EXPECT_FALSE(notes.remarks.empty());
}

TEST(C3d, RoundTripKeepsRecording) {
  const auto m = read(C3dBytes::sample(Kind::mips, false));
  ASSERT_TRUE(m.has_value());
  for (const bool z_up : {true, false}) {
    const auto bytes = write_c3d(*m, {.z_up = z_up});
    ASSERT_TRUE(bytes.has_value()) << text_of(bytes.error());
    EXPECT_EQ(bytes->size() % 512, 0U);
    const auto back = read_c3d(*bytes, "walk.c3d");
    ASSERT_TRUE(back.has_value()) << text_of(back.error());
    EXPECT_EQ(back->labels, m->labels);
    EXPECT_EQ(back->frames, m->frames);
    EXPECT_EQ(back->first_frame, m->first_frame);
    EXPECT_EQ(back->rate, m->rate);
    for (std::size_t i = 0; i < m->positions.size(); ++i) expect_near(back->positions[i], m->positions[i], 1e-7, "position");
    for (std::size_t i = 0; i < m->residuals.size(); ++i) EXPECT_NEAR(back->residuals[i], m->residuals[i], 1e-4);
    ASSERT_EQ(back->samples.size(), m->samples.size());
    for (std::size_t i = 0; i < m->samples.size(); ++i)
      EXPECT_FLOAT_EQ(static_cast<float>(back->samples[i]), static_cast<float>(m->samples[i]));
    EXPECT_EQ(back->analog_rate, m->analog_rate);
    ASSERT_EQ(back->events.size(), m->events.size());
    EXPECT_EQ(back->events[1].label, m->events[1].label);
    EXPECT_NEAR(back->events[1].time, m->events[1].time, 1e-5);
    ASSERT_EQ(back->plates.size(), 1U);
    for (int k = 0; k < 4; ++k) expect_near(back->plates[0].corners[k], m->plates[0].corners[k], 1e-7, "corner");
    EXPECT_EQ(back->plates[0].channels, m->plates[0].channels);
  }
}

TEST(C3d, RoundTripKeepsMoreThan255MarkersAnd65535Frames) {
  MarkerMotion m;
  m.name = "crowd";
  m.unit = 0.001;
  m.frames = 70000;
  m.rate = 100;
  for (int i = 0; i < 300; ++i) m.labels.push_back("marker with a long name " + std::to_string(i));
  m.labels.resize(2);
  m.positions.resize(140000);
  m.residuals.resize(140000);
  for (std::size_t i = 0; i < m.positions.size(); ++i) m.positions[i] = {static_cast<double>(i) * 1e-5, 0.25, 1};
  const auto long_file = write_c3d(m);
  ASSERT_TRUE(long_file.has_value());
  const auto back = read_c3d(*long_file, "crowd.c3d");
  ASSERT_TRUE(back.has_value()) << text_of(back.error());
  EXPECT_EQ(back->frames, 70000);
  expect_near(back->at(69999, 1), m.at(69999, 1), 1e-6, "last");
  for (int i = 2; i < 300; ++i) m.labels.push_back("marker with a long name " + std::to_string(i));
  m.frames = 2;
  m.positions.resize(600);
  m.residuals.resize(600);
  const auto wide = write_c3d(m);
  ASSERT_TRUE(wide.has_value());
  const auto wide_back = read_c3d(*wide, "crowd.c3d");
  ASSERT_TRUE(wide_back.has_value()) << text_of(wide_back.error());
  EXPECT_EQ(wide_back->labels, m.labels);
}

TEST(C3d, BrokenFilesAreRejectedWithLocationAndRemedy) {
  const std::vector<std::byte> good = C3dBytes::sample(Kind::intel, true).finish();
  const auto refused = [](std::span<const std::byte> bytes, const std::string& what) {
    const auto m = read_c3d(bytes, "bad.c3d");
    ASSERT_FALSE(m.has_value()) << what;
    const Problem& p = m.error().problems.at(0);
    EXPECT_TRUE(p.location.starts_with("bad.c3d: ")) << what << ": " << p.text();
    EXPECT_TRUE(p.message.ends_with('.')) << p.text();
    EXPECT_FALSE(p.remedy.empty()) << p.text();
  };
  const std::size_t data_end = good.size() - 512 + 3 * (2 * 4 + 4) * 4;
  refused({}, "empty");
  for (std::size_t size = 1; size < data_end; size += 37) refused(std::span(good).first(size), "truncated at " + std::to_string(size));
  const auto with = [&](std::size_t at, int value) {
    std::vector<std::byte> bytes = good;
    bytes.at(at) = static_cast<std::byte>(value);
    return bytes;
  };
  refused(with(1, 0x51), "key");
  refused(with(0, 0), "no parameters");
  refused(with(0, 200), "parameters beyond the end");
  refused(with(512 + 3, 99), "processor");
  refused(with(8, 0xff), "more frames than data");
  refused(with(16, 0x77), "data beyond the end");
  refused(with(3, 0x10), "more markers than data");
  refused(with(4, 5), "analog measurements that are not a multiple of the samples");
}

TEST(C3d, AnyWrongByteGivesFiniteDataOrError) {
  const std::vector<std::byte> good = C3dBytes::sample(Kind::intel, true).finish();
  for (std::size_t at = 0; at < good.size(); ++at) {
    for (const int value : {0, 1, 127, 128, 255}) {
      std::vector<std::byte> bytes = good;
      bytes[at] = static_cast<std::byte>(value);
      const auto m = read_c3d(bytes, "bad.c3d");  // the reader must not crash, and every accepted value is finite
      if (!m) continue;
      ASSERT_EQ(m->positions.size(), static_cast<std::size_t>(m->frames) * m->labels.size());
      for (const Vec3& x : m->positions) ASSERT_TRUE(is_finite(x));
      for (const double x : m->samples) ASSERT_TRUE(std::isfinite(x));
    }
  }
}

TEST(C3d, SharedRecordingsHaveExpectedMarkersFramesAndRate) {
  const std::string folder = std::string(UGOKI_SOURCE_DIR) + "/../shared/data/human/c3d/";
  struct Expected {
    const char* file;
    int markers, frames, first;
    double rate;
  };
  for (const Expected& e : {Expected{"02_01.c3d", 41, 343, 50, 120}, Expected{"rbdl_gaitDataPlanar.c3d", 38, 74, 1, 50}}) {
    std::ifstream in(folder + e.file, std::ios::binary);
    if (!in) GTEST_SKIP() << "no " << folder << e.file;
    const std::vector<char> raw{std::istreambuf_iterator<char>(in), {}};
    const auto m = read_c3d(std::as_bytes(std::span(raw)), e.file);
    ASSERT_TRUE(m.has_value()) << text_of(m.error());
    EXPECT_EQ(m->marker_count(), e.markers);
    EXPECT_EQ(m->frames, e.frames);
    EXPECT_EQ(m->first_frame, e.first);
    EXPECT_EQ(m->rate, e.rate);
    double top = 0;
    for (const Vec3& x : m->positions) top = std::max(top, x.z);
    EXPECT_GT(top, 1.4);  // m: the highest marker is on the head of a standing person
    EXPECT_LT(top, 2.1);
  }
}

}  // namespace
}  // namespace ugoki::formats
