// The LSIs for motion operations play the result of their operation. The LSI for intermediate motions follows changes of the weight.
#include "ugoki/lsi/motion_lsi.h"

#include <gtest/gtest.h>

#include <cmath>

#include "allocation_count.h"
#include "small_world.h"
#include "ugoki/motion_edit/mirror.h"
#include "ugoki/retarget/retarget.h"
#include "walker.h"

namespace ugoki::lsi {
namespace {

/// A circuit with one LSI of class `type`. @param input  name of its pin to which the circuit's input `in` is wired
Result<circuit::Interpreter> build(const Walker& w, const std::string& type, const std::string& parameters, const std::string& input,
                                   const std::string& character = "walker") {
  const std::string text =
      R"({"version": 1, "name": "one", "inputs": [{"name": "in", "type": "scalar", "to": "m.)" + input +
      R"("}], "outputs": [{"name": "reference", "type": "motion", "from": "m.reference"}], "lsis": [{"id": "m", "type": ")" + type +
      R"(", "parameters": {"character": ")" + character + "\"" + parameters + "}}]}";
  const auto circuit = circuit::read_circuit(text);
  if (!circuit) return fail(circuit.error());
  return circuit::Interpreter::build(*circuit, standard_library(), w.world.get(), {.dt = 0.01, .check_finite = true});
}

void set(circuit::Interpreter& i, double value) {
  const auto in = i.find_circuit_input("in");
  ASSERT_FALSE(in.empty());
  std::memcpy(in.data(), &value, sizeof value);
}

/// Maximum absolute difference between the position of a reference and q, m | rad.
double max_difference(const Mechanism& m, const double* reference, std::span<const double> q) {
  std::vector<double> d(static_cast<std::size_t>(m.nv()));
  difference(m, q, {reference, q.size()}, d);
  double worst = 0;
  for (const double x : d) worst = std::max(worst, std::fabs(x));
  return worst;
}

TEST(MotionLsi, PlaysResultOfOperation) {
  const Walker w;
  const Mechanism& m = *w.human;
  struct Case {
    const char *type, *parameters;
    Motion expected;
  };
  const std::vector<Case> cases = {
      {"motion mirror", "", motion_edit::mirror(m, *w.walk).value()},
      {"motion reverse", "", motion_edit::reverse(*w.walk)},
      {"motion trim", R"(, "from": 0.2, "to": 0.8)",
       motion_edit::trim(*w.walk, static_cast<int>(0.2 * w.walk->rate + 0.5), static_cast<int>(0.8 * w.walk->rate + 0.5)).value()},
      {"motion join", R"(, "blend": 0.1)", motion_edit::join(m, *w.walk, *w.fast, {.blend = 0.1}).value()},
  };
  std::vector<double> q(static_cast<std::size_t>(m.nq()));
  for (const Case& c : cases) {
    auto i = build(w, c.type, c.parameters, "time");
    ASSERT_TRUE(i) << c.type << ": " << i.error().text();
    for (const int frame : {0, 7, 30}) {
      set(*i, frame / c.expected.rate);
      ASSERT_TRUE(i->tick()) << c.type;
      sample(c.expected, m, frame / c.expected.rate, q);
      EXPECT_LT(max_difference(m, numbers(*i, "reference"), q), 1e-9) << c.type;
    }
  }
}

TEST(MotionLsi, RetargetPlaysResultOfRetargeting) {
  const Walker w;
  const Mechanism& m = *w.child;
  const auto expected = retarget::retarget(w.human, *w.walk, w.child);
  ASSERT_TRUE(expected) << expected.error().text();
  auto i = build(w, "motion retarget", R"(, "from": "walker")", "time", "child");
  ASSERT_TRUE(i) << i.error().text();
  std::vector<double> q(static_cast<std::size_t>(m.nq()));
  for (const int frame : {0, 11, 40}) {
    set(*i, frame / expected->motion.rate);
    ASSERT_TRUE(i->tick());
    sample(expected->motion, m, frame / expected->motion.rate, q);
    EXPECT_LT(max_difference(m, numbers(*i, "reference"), q), 1e-9) << frame;
  }
  const auto refused = build(w, "motion retarget", R"(, "from": "nobody")", "time", "child");
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().text().find("nobody"), std::string::npos);
  const auto no_clip = build(w, "motion retarget", R"(, "from": "child")", "time", "walker");
  ASSERT_FALSE(no_clip);
  EXPECT_NE(no_clip.error().text().find("has 0 clips"), std::string::npos) << no_clip.error().text();
}

TEST(MotionLsi, EveryOperationIsBuiltAndPlays) {
  const Walker w;
  int count = 0;
  for (const auto& [type, parameters] :
       std::vector<std::pair<std::string, std::string>>{{"motion trim", ""},
                                                        {"motion join", ""},
                                                        {"motion cycle", ""},
                                                        {"motion warp", R"(, "points": "0 0, 1 0.5, 2 1")"},
                                                        {"motion mirror", ""},
                                                        {"motion reverse", ""},
                                                        {"motion resample", R"(, "rate": 60)"},
                                                        {"motion scale", R"(, "time": 2)"},
                                                        {"motion path", R"(, "points": "0 0, 1 0, 2 1")"},
                                                        {"motion layer", R"(, "joints": "upper arm left")"},
                                                        {"motion mix", R"(, "joints": "upper arm left, head")"},
                                                        {"foot contacts", ""},
                                                        {"foot lock", ""},
                                                        {"motion reduce", ""}}) {
    auto i = build(w, type, parameters, "time");
    ASSERT_TRUE(i) << type << ": " << i.error().text();
    set(*i, -1);
    for (int k = 0; k < 50; ++k) ASSERT_TRUE(i->tick()) << type;
    const double height = numbers(*i, "reference")[2];
    EXPECT_GT(height, 0.7) << type;
    EXPECT_LT(height, 1.2) << type;
    ++count;
  }
  EXPECT_EQ(count, 14);
}

TEST(MotionLsi, InvalidParametersAreRefused) {
  const Walker w;
  const auto refused = [&](const std::string& type, const std::string& parameters, const std::string& word) {
    const auto i = build(w, type, parameters, "time");
    ASSERT_FALSE(i) << type;
    EXPECT_NE(i.error().text().find(word), std::string::npos) << i.error().text();
  };
  refused("motion trim", R"(, "clip": 7)", "The parameter 'clip' is 7");
  refused("motion warp", R"(, "points": "0 0, x")", "pairs of numbers");
  refused("motion warp", R"(, "points": "0 0, 1 99")", "99");
  refused("motion mix", R"(, "joints": "tentacle")", "tentacle");
}

TEST(IntermediateMotionLsi, FollowsItsWeightContinuously) {
  const Walker w;
  auto i = build(w, "intermediate motion", "", "weight");
  ASSERT_TRUE(i) << i.error().text();
  const Mechanism& m = *w.human;
  const auto nq = static_cast<std::size_t>(m.nq()), nv = static_cast<std::size_t>(m.nv());
  std::vector<double> before, v_before, d(nv);
  double speed[2] = {0, 0};
  for (int k = 0; k < 600; ++k) {
    set(*i, k < 200 ? 0 : k < 400 ? (k - 200) / 200.0 : 1);
    const long allocated = allocations_so_far();
    ASSERT_TRUE(i->tick());
    if (k > 5) EXPECT_EQ(allocations_so_far(), allocated) << "tick " << k;
    const double* r = numbers(*i, "reference");
    std::vector<double> q(r, r + nq);
    if (!before.empty()) {
      difference(m, before, q, d);
      for (std::size_t j = 0; j < nv; ++j) {
        EXPECT_LT(std::fabs(d[j]), 0.15) << "jump of degree of freedom " << j << " at tick " << k;
        EXPECT_NEAR(d[j] / 0.01, 0.5 * (v_before[j] + r[nq + j]), 2.0) << "velocity of degree of freedom " << j << " at tick " << k;
      }
    }
    if (k == 100 || k == 199) speed[0] += (k == 199 ? 1 : -1) * q[0] / 0.99;
    if (k == 450 || k == 549) speed[1] += (k == 549 ? 1 : -1) * q[0] / 0.99;
    before = q;
    v_before.assign(r + nq, r + nq + nv);
  }
  const double walk = cycle_of(*w.walk, m).x / w.walk->duration();
  EXPECT_NEAR(speed[0], walk, 0.1 * walk);
  EXPECT_NEAR(speed[1], 1.25 * walk, 0.1 * walk);
}

}  // namespace
}  // namespace ugoki::lsi
