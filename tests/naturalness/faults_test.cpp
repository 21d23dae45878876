// Planted faults are flagged by the measures that they violate; clean motions are not.

#include <gtest/gtest.h>

#include "../motion_edit/characters.h"
#include "planted.h"
#include "ugoki/correction/correct.h"
#include "ugoki/naturalness/judge_motion.h"

namespace ugoki::naturalness {
namespace {

using motion_edit::Character;

Character recorded(const std::string& skeleton, const std::string& trial) {
  const MeasuredMotion measured = motion_edit::read_recording(skeleton, trial);
  const body::Body body = body::make_body(measured, {}).value();
  return {body.mechanism, body::to_motion(body, measured)};
}

std::string bad_measures(const Report& report) {
  std::string out;
  for (const MeasureInfo& info : measure_list())
    if (report.measures[index_of(info.id)].grade() == Grade::bad)
      out += std::string(info.name) + " " + std::to_string(report.measures[index_of(info.id)].total) + "; ";
  return out;
}

void expect_flagged(const Character& c, const std::vector<Planted>& faults) {
  const Report clean = judge_motion(c.m(), c.motion);
  for (const Planted& fault : faults) {
    const Report report = judge_motion(c.m(), fault.plant(c.m(), c.motion));
    bool flagged = false;
    std::string values;
    for (const MeasureId id : fault.flagged) {
      const MeasureReport &after = report.measures[index_of(id)], &before = clean.measures[index_of(id)];
      flagged = flagged || (after.grade() == Grade::bad && before.grade() != Grade::bad);
      values += std::string(info_of(id).name) + " " + std::to_string(before.total) + " -> " + std::to_string(after.total) + "; ";
    }
    EXPECT_TRUE(flagged) << fault.name << ": " << values << "bad: " << bad_measures(report);
  }
}

TEST(Judge, CleanRecordingsPass) {
  if (!motion_edit::has_recordings()) GTEST_SKIP() << "the shared data were not found";
  for (const char* trial : {"02_02", "35_01", "02_03"}) {
    const Character c = recorded(std::string(trial).substr(0, 2), trial);
    EXPECT_EQ(bad_measures(judge_motion(c.m(), c.motion)), "") << trial;
  }
}

TEST(Judge, FaultsOfARecordedWalkAreFlagged) {
  if (!motion_edit::has_recordings()) GTEST_SKIP() << "the shared data were not found";
  expect_flagged(recorded("35", "35_01"), walk_faults());
}

TEST(Judge, FaultsOfARunAreFlagged) {
  if (!motion_edit::has_recordings()) GTEST_SKIP() << "the shared data were not found";
  expect_flagged(recorded("02", "02_03"), flight_faults());
}

TEST(Judge, SampleWalkPassesAndItsFaultsAreFlagged) {
  Character c = motion_edit::human_walk();
  c.motion = motion_edit::unrolled(c.m(), c.motion, 4);
  EXPECT_EQ(bad_measures(judge_motion(c.m(), c.motion)), "");
  expect_flagged(c, walk_faults());
}

}  // namespace
}  // namespace ugoki::naturalness
