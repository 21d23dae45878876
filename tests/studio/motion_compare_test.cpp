// The request `compare` over real sockets.
#include <cmath>

#include "studio_fixture.h"

namespace ugoki::studio {
namespace {

using nlohmann::json;
using test::Page;
using test::StudioTest;

class MotionCompareTest : public StudioTest {
 protected:
  static json clip(json more = json::object()) {
    json out = {{"motion", "n-walk"}, {"start", 0}, {"length", 2}, {"offset", 0}, {"speed", 1}, {"blend", 0.3}, {"loop", false}};
    out.update(more);
    return out;
  }
  static json compare(json before) { return {{"op", "compare"}, {"character", "human"}, {"clip", "k1"}, {"before", std::move(before)}}; }
};

TEST_F(MotionCompareTest, AnUnchangedClipHasNoDifference) {
  Page p = page();
  const json same = p.ask(compare(clip()));
  ASSERT_TRUE(same["ok"]) << same;
  EXPECT_EQ(same["degrees"], 0);
  EXPECT_EQ(same["move"], 0);
  EXPECT_EQ(same["link"], -1);
  ASSERT_EQ(same["poses"].size(), 61u);
  for (const int n : {0, 15, 40}) {
    const json pose = p.ask({{"op", "pose"}, {"character", "human"}, {"clip", "k1"}, {"time", n * same["step"].get<double>()}});
    for (std::size_t i = 0; i < 14; ++i)
      EXPECT_NEAR(same["poses"][static_cast<std::size_t>(n)][i].get<double>(), pose["links"][i].get<double>(), 1e-4);
  }
}

/// The leg swings by 0.3 sin(pi t) rad. Half a second later: the difference is 0.3 sqrt(2) sin(pi t - pi / 4), largest at 0.75 s.
TEST_F(MotionCompareTest, ReportsTheLargestDifferenceAndItsTime) {
  Page p = page();
  const json later = p.ask(compare(clip({{"offset", 0.5}, {"length", 1.5}})));
  ASSERT_TRUE(later["ok"]) << later;
  EXPECT_EQ(later["link"], 1);
  EXPECT_NEAR(later["degrees"].get<double>(), 0.3 * std::sqrt(2.0) * 180 / 3.14159265, 0.05);
  EXPECT_NEAR(later["time"].get<double>(), 0.75, 0.04);
  EXPECT_GT(later["move"].get<double>(), 0);
}

TEST_F(MotionCompareTest, RefusesRequestsThatNameNothing) {
  Page p = page();
  for (const json& request : {json{{"op", "compare"}, {"character", "nobody"}, {"clip", "k1"}, {"before", clip()}},
                              json{{"op", "compare"}, {"character", "human"}, {"clip", "k99"}, {"before", clip()}},
                              json{{"op", "compare"}, {"character", "human"}, {"clip", "k1"}}, compare(clip({{"motion", "n-gone"}})),
                              compare(clip({{"speed", -1}})), compare(clip({{"wish", 1}}))}) {
    const json reply = p.ask(request);
    ASSERT_FALSE(reply["ok"]) << request;
    EXPECT_FALSE(reply["error"]["problems"][0]["remedy"].get<std::string>().empty()) << reply;
  }
}

}  // namespace
}  // namespace ugoki::studio
