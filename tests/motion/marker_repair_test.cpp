#include "ugoki/motion/marker_repair.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "ugoki/spatial/spatial.h"

namespace ugoki {
namespace {

constexpr double two_pi = 6.283185307179586;

MarkerMotion make_markers(int markers, int frames, double rate) {
  MarkerMotion m;
  m.rate = rate;
  m.frames = frames;
  for (int i = 0; i < markers; ++i) m.labels.push_back("m" + std::to_string(i));
  m.positions.resize(static_cast<std::size_t>(markers * frames));
  m.residuals.resize(m.positions.size());
  return m;
}

void hide(MarkerMotion& m, int marker, int first, int last) {
  for (int f = first; f <= last; ++f) {
    m.positions[m.index(f, marker)] = {};
    m.residuals[m.index(f, marker)] = -1;
  }
}

TEST(MarkerRepair, FindsGapsAtBothEndsAndWithin) {
  MarkerMotion m = make_markers(2, 10, 100);
  hide(m, 0, 0, 1);
  hide(m, 0, 8, 9);
  hide(m, 1, 4, 4);
  const auto gaps = find_gaps(m);
  ASSERT_EQ(gaps.size(), 3U);
  EXPECT_EQ(gaps[0].first, 0);
  EXPECT_EQ(gaps[0].last, 1);
  EXPECT_EQ(gaps[1].last, 9);
  EXPECT_EQ(gaps[2].marker, 1);
}

TEST(MarkerRepair, SplinesAreExactOnStraightLinesAndCloseOnParabolas) {
  MarkerMotion m = make_markers(2, 40, 100);
  const auto parabola = [](int f) { return Vec3{0.01 * f, 1 - 0.0005 * f * f, 0.3}; };
  const auto line = [](int f) { return Vec3{0.01 * f, 1 - 0.02 * f, 0.3}; };
  for (int f = 0; f < m.frames; ++f) {
    m.positions[m.index(f, 0)] = parabola(f);
    m.positions[m.index(f, 1)] = line(f);
  }
  hide(m, 0, 20, 20);
  hide(m, 1, 20, 23);
  EXPECT_EQ(fill_short_gaps(m, 0.05), 5);
  EXPECT_LT(norm(m.at(20, 0) - parabola(20)), 3e-4);  // m; slopes next to a gap are estimated from one side only
  for (int f = 20; f <= 23; ++f) EXPECT_LT(norm(m.at(f, 1) - line(f)), 1e-12);
  EXPECT_TRUE(m.seen(20, 0));
}

TEST(MarkerRepair, SplinesDoNotFillLongGapsAndEnds) {
  MarkerMotion m = make_markers(1, 40, 100);
  hide(m, 0, 0, 2);
  hide(m, 0, 10, 19);
  EXPECT_EQ(fill_short_gaps(m, 0.05), 0);
  EXPECT_EQ(find_gaps(m).size(), 2U);
}

TEST(MarkerRepair, NeighboursOnARigidBodyFillExactly) {
  MarkerMotion m = make_markers(5, 100, 100);
  const Vec3 body[4] = {{0, 0, 0}, {0.1, 0, 0}, {0, 0.12, 0}, {0.02, 0.03, 0.09}};
  std::vector<Vec3> truth;
  for (int f = 0; f < m.frames; ++f) {
    const Pose X{to_matrix(exp_map({0.02 * f, -0.01 * f, 0.03 * f})), {0.01 * f, 0.2, 1}};
    for (int i = 0; i < 4; ++i) m.positions[m.index(f, i)] = X * body[i];
    m.positions[m.index(f, 4)] = {std::sin(0.3 * f), 0, 0};  // marker 4 does not move with the body
    truth.push_back(X * body[3]);
  }
  hide(m, 3, 30, 79);
  hide(m, 3, 95, 99);
  EXPECT_EQ(fill_gaps_by_neighbours(m), 55);
  for (int f = 0; f < m.frames; ++f) EXPECT_LT(norm(m.at(f, 3) - truth[static_cast<std::size_t>(f)]), 1e-9) << f;
}

TEST(MarkerRepair, SpikesAreRemovedAndFastMotionIsKept) {
  MarkerMotion m = make_markers(2, 200, 100);
  for (int f = 0; f < m.frames; ++f) {
    m.positions[m.index(f, 0)] = {0.3 * std::sin(two_pi * 2 * f / 100), 0, 1};
    m.positions[m.index(f, 1)] = {0.02 * f, 0, 1};
  }
  m.positions[m.index(77, 1)].z += 0.3;
  EXPECT_EQ(remove_spikes(m), 1);
  EXPECT_FALSE(m.seen(77, 1));
  EXPECT_TRUE(m.seen(76, 1) && m.seen(78, 1));
}

TEST(MarkerRepair, FilterHalvesThePowerAtItsCutoffWithoutDelay) {
  for (const double frequency : {1.0, 6.0, 20.0}) {
    MarkerMotion m = make_markers(1, 1000, 100);
    for (int f = 0; f < m.frames; ++f) m.positions[m.index(f, 0)] = {std::sin(two_pi * frequency * f / 100), 0, 0};
    filter_markers(m, 6);
    double in_phase = 0, out_of_phase = 0;
    for (int f = 200; f < 800; ++f) {
      in_phase += m.at(f, 0).x * std::sin(two_pi * frequency * f / 100) / 300;
      out_of_phase += m.at(f, 0).x * std::cos(two_pi * frequency * f / 100) / 300;
    }
    EXPECT_NEAR(out_of_phase, 0, 1e-6);
    // Gain of two passes of a second-order Butterworth filter (bilinear transform, warped frequencies): 1 / (1 + (w / wc)^4), where wc is
    // the raised cut-off of a single pass.
    const double w = std::tan(two_pi / 2 * frequency / 100) / (std::tan(two_pi / 2 * 6 / 100) / 0.80237);
    EXPECT_NEAR(in_phase, 1 / (1 + w * w * w * w), 1e-3) << frequency;
    if (frequency == 6.0) EXPECT_NEAR(in_phase, std::sqrt(0.5), 2e-3);
  }
}

TEST(MarkerRepair, ChosenCutoffIsBetweenMotionAndNoise) {
  std::mt19937 random(3);
  std::normal_distribution<double> noise(0, 0.001);
  double last = 0;
  for (const double fastest : {2.0, 10.0}) {
    MarkerMotion m = make_markers(3, 1500, 200);
    for (int f = 0; f < m.frames; ++f)
      for (int i = 0; i < 3; ++i)
        m.positions[m.index(f, i)] = {0.1 * std::sin(two_pi * fastest * f / 200 + i) + noise(random),
                                      0.2 * std::sin(two_pi * f / 200) + noise(random), 1 + noise(random)};
    const double cutoff = choose_cutoff(m);
    EXPECT_GT(cutoff, 1.2 * fastest);
    EXPECT_LT(cutoff, 6 * fastest);
    EXPECT_GT(cutoff, last);
    last = cutoff;
  }
}

TEST(MarkerRepair, ShortRecordingsAreNotChanged) {
  MarkerMotion m = make_markers(1, 3, 100);
  m.positions = {{1, 0, 0}, {2, 0, 0}, {3, 0, 0}};
  const auto before = m.positions;
  filter_markers(m, 6);
  EXPECT_EQ(m.positions, before);
  EXPECT_EQ(choose_cutoff(m), 0);
  EXPECT_EQ(remove_spikes(m), 0);
}

}  // namespace
}  // namespace ugoki
