// Exports of OptiTrack Motive: markers, gaps, units and faults.
#include <gtest/gtest.h>

#include <string>

#include "ugoki/formats/csv.h"

namespace ugoki::formats {
namespace {

std::string take(const std::string& unit = "Meters", const std::string& first_row = "0,0.000000") {
  return "Format Version,1.23,Take Name,walk,Capture Frame Rate,120.000000,Export Frame Rate,60.000000,Total Frames in Take,2,"
         "Rotation Type,Quaternion,Length Units," +
         unit +
         ",Coordinate Space,Global\n\n"
         ",Type,Rigid Body,Rigid Body,Rigid Body,Rigid Body,Marker,Marker,Marker,Marker,Marker,Marker,Marker,Marker,Marker\n"
         ",Name,hip,hip,hip,hip,A:LASI,A:LASI,A:LASI,A:RASI,A:RASI,A:RASI,Unlabeled 7,Unlabeled 7,Unlabeled 7\n"
         ",ID,1,1,1,1,2,2,2,3,3,3,4,4,4\n"
         ",,Rotation,Rotation,Rotation,Rotation,Position,Position,Position,Position,Position,Position,Position,Position,Position\n"
         "Frame,Time (Seconds),X,Y,Z,W,X,Y,Z,X,Y,Z,X,Y,Z\n" +
         first_row + ",0,0,0,1,0.1,1.0,0.2,0.3,1.1,0.2,5,5,5\n1,0.016667,0,0,0,1,0.2,1.0,0.2,,,,5,5,5\n";
}

TEST(MotiveCsv, ReadsTheLabelledMarkers) {
  ReadNotes notes;
  EXPECT_EQ(csv_kind(take()), CsvKind::points);
  const auto m = read_csv(take(), "walk.csv", MarkerOptions{}, &notes);
  ASSERT_TRUE(m.has_value()) << m.error().text();
  ASSERT_EQ(m->labels, (std::vector<std::string>{"A:LASI", "A:RASI"}));
  EXPECT_EQ(m->frames, 2);
  EXPECT_EQ(m->rate, 60);
  // Y up, Z forward becomes Z up, X forward.
  EXPECT_NEAR(norm(m->at(0, 0) - Vec3{0.2, 0.1, 1.0}), 0, 1e-12);
  EXPECT_TRUE(m->seen(0, 1));
  EXPECT_FALSE(m->seen(1, 1));
}

TEST(MotiveCsv, FollowsTheUnitOfTheHeader) {
  const auto a = read_csv(take(), "a.csv"), b = read_csv(take("Centimeters"), "b.csv");
  ASSERT_TRUE(a.has_value() && b.has_value());
  EXPECT_NEAR(a->unit, 1, 1e-12);
}

TEST(MotiveCsv, NamesFaults) {
  const auto refused = [](const std::string& text, const std::string& what) {
    const auto m = read_csv(text, "bad.csv");
    ASSERT_FALSE(m.has_value());
    EXPECT_NE(m.error().text().find(what), std::string::npos) << m.error().text();
  };
  refused("Format Version,1.23\n\n", "frame rate");
  refused("Format Version,1.23,Capture Frame Rate,120\n,Type,Marker\n", "'Frame'");
  std::string text = take();
  refused(text.replace(text.find("0.1,1.0"), 7, "x,1.0"), "bad.csv:8");
}

}  // namespace
}  // namespace ugoki::formats
