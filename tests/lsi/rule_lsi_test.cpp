// LSIs of rules: choice of motions with transitions, play rules, touches, pushes.

#include <cmath>

#include "signals.h"
#include "small_world.h"
#include "ugoki/lsi/track_sampler.h"

namespace ugoki::lsi {
namespace {

/// A motion of 2 s in which the character slides straight ahead by 1 m.
MotionPtr make_slide(const Mechanism& m) {
  auto motion = std::make_shared<Motion>();
  motion->name = "slide";
  motion->mechanism = m.name();
  motion->rate = 100;
  motion->frames = 201;
  motion->nq = m.nq();
  const Quat turn = axis_angle({0, 0, 1}, 0.7);  // the recording has another place and heading than the track
  for (int f = 0; f < motion->frames; ++f) {
    std::vector<double> q = m.neutral();
    const double way = 0.5 * (1 - cos(pi * f / 200.0));
    const Vec3 p = Vec3{5, -2, 0.9} + rotate(turn, {way, 0, 0});
    q[0] = p.x;
    q[1] = p.y;
    q[2] = p.z;
    q[3] = turn.w;
    q[4] = turn.x;
    q[5] = turn.y;
    q[6] = turn.z;
    motion->q.insert(motion->q.end(), q.begin(), q.end());
  }
  return motion;
}

/// A world whose character can play a slide (choice 1) and a looped slide (choice 2) instead of its track.
std::unique_ptr<World> make_world() {
  std::vector<CharacterSpec> specs(2);
  specs[0].id = "character";
  specs[0].mechanism = make_character();
  TrackClip sway{{}, make_sway(*specs[0].mechanism, 4)}, slide{{}, make_slide(*specs[0].mechanism)};
  sway.clip.length = 4;
  specs[0].track = {sway};
  slide.clip.length = 2;
  slide.clip.blend = 0.3;
  specs[0].moves = {slide, slide};
  specs[0].moves[1].clip.loop = true;
  specs[0].moves[1].clip.length = 1e9;
  specs[0].moves[1].clip.cycle = cycle_of(*slide.motion, *specs[0].mechanism);
  specs[1].id = "ball";
  specs[1].mechanism = make_ball();
  specs[1].q0 = specs[1].mechanism->neutral();
  specs[1].q0[0] = 3;
  specs[1].q0[2] = 0.11;
  return std::make_unique<World>(std::move(specs), std::vector<ScheduledEvent>{}, Vec3{0, 0, -9.81}, collision::Ground{});
}

constexpr const char* choice_circuit = R"({"version": 2, "name": "t", "inputs": [{"name": "choice", "type": "scalar", "to": "it.choice"}],
  "lsis": [{"id": "it", "type": "motion choice", "parameters": {"character": "character"}},
           {"id": "mix", "type": "interpolation", "parameters": {"character": "character"}}],
  "wires": [{"from": "it.current", "to": "mix.current"}, {"from": "it.previous", "to": "mix.previous"}, {"from": "it.blend", "to": "mix.blend"}]})";

/// Plays `choices` (time in s, choice) for `duration` s and calls `each(t, reference)` at every tick.
template <class Each>
void play(const World& world, std::vector<std::pair<double, double>> choices, double duration, double dt, Each each) {
  circuit::Interpreter i = build(&world, choice_circuit, dt);
  for (int n = 0; n * dt < duration; ++n) {
    for (const auto& [time, choice] : choices)
      if (std::fabs(time - n * dt) < dt / 2) set(i, "choice", choice);
    ASSERT_TRUE(i.tick());
    each(n * dt, i);
  }
}

TEST(MotionChoice, WithoutRulesItPlaysTheTrack) {
  const auto world = make_world();
  const Character& who = world->characters()[0];
  std::vector<double> track(who.track->layout().size());
  play(*world, {}, 4.5, 0.01, [&](double t, const circuit::Interpreter& i) {
    who.track->sample(t, track);
    const auto reference = i.find_output("mix.reference")->numbers();
    for (std::size_t k = 0; k < track.size(); ++k) ASSERT_NEAR(reference[k], track[k], 1e-12) << "t = " << t << ", number " << k;
  });
}

TEST(MotionChoice, ReferenceIsContinuousAndItsVelocityIsItsDerivative) {
  const auto world = make_world();
  const Character& who = world->characters()[0];
  const Mechanism& m = *who.mechanism;
  const ReferenceLayout at = who.track->layout();
  constexpr double dt = 1e-3;  // s, short enough for central differences of motions that last seconds
  std::vector<std::vector<double>> run;
  // also an immediate change back, during the transition
  play(*world, {{0.7, 1}, {0.8, 2}, {2.5, 0}, {3.2, 1}}, 4.5, dt, [&](double, const circuit::Interpreter& i) {
    const auto r = i.find_output("mix.reference")->numbers();
    run.emplace_back(r.begin(), r.end());
  });
  std::vector<double> v(at.nv);
  for (std::size_t n = 1; n + 1 < run.size(); ++n) {
    difference(m, std::span<const double>(run[n - 1]).first(at.nq), std::span<const double>(run[n + 1]).first(at.nq), v);
    for (std::size_t k = 0; k < at.nv; ++k)
      ASSERT_NEAR(v[k] / (2 * dt), run[n][at.v() + k], 0.02) << "t = " << static_cast<double>(n) * dt << " s, DOF " << k;
  }
}

TEST(MotionChoice, AMotionBeginsAtThePlaceAndHeadingOfTheCharacter) {
  const auto world = make_world();
  const Mechanism& m = *world->characters()[0].mechanism;
  const std::size_t nq = static_cast<std::size_t>(m.nq());
  Placement last;
  play(*world, {{1, 2}}, 7.0, 0.01, [&](double t, const circuit::Interpreter& i) {
    last = root_placement(m, i.find_output("mix.reference")->numbers().first(nq));
    if (t <= 1.001) EXPECT_NEAR(last.x, 0, 0.1);
  });
  // the looped slide of 2 s and 1 m along x, from 1 s to 6.99 s: three rounds, although it was recorded at (5, -2) m with a heading of 0.7
  // rad
  EXPECT_NEAR(last.x, 3, 0.1);
  EXPECT_NEAR(last.y, 0, 0.01);
  EXPECT_NEAR(last.heading, 0, 1e-6);
}

TEST(MotionChoice, ReportsWhatPlaysAndItsEnd) {
  const auto world = make_world();
  play(*world, {{1, 1}}, 4.0, 0.01, [&](double t, const circuit::Interpreter& i) {
    EXPECT_EQ(get(i, "it.now"), t < 0.995 ? 0 : 1) << t;
    // begin, plus duration, minus transition: 1 + 2 - 0.3 s; the tick of this time may round to either side
    if (std::fabs(t - 2.69) > 0.005) EXPECT_EQ(get(i, "it.ended"), t < 2.69 ? 0 : 1) << t;
  });
}

TEST(MotionChoice, SavedStateContinuesWithTheSameBits) {
  const auto world = make_world();
  circuit::Interpreter a = build(world.get(), choice_circuit, 0.01), b = build(world.get(), choice_circuit, 0.01);
  a.run(70);
  set(a, "choice", 1);
  a.run(10);
  std::vector<std::byte> saved;
  a.save(saved);
  ASSERT_TRUE(b.restore(saved));
  set(b, "choice", 1);
  a.run(150);
  b.run(150);
  const auto of_a = a.find_output("mix.reference")->numbers(), of_b = b.find_output("mix.reference")->numbers();
  EXPECT_TRUE(std::equal(of_a.begin(), of_a.end(), of_b.begin()));
}

/// Two play rules in series: "low" (choice 1) below "high" (choice 2).
std::string rules_circuit(const char* low, const char* high) {
  const auto rule = [](const char* id, int number, const char* mode) {
    return std::string(R"({"id": ")") + id + R"(", "type": "play rule", "parameters": {"number": )" + std::to_string(number) +
           R"(, "mode": ")" + mode + "\"}}";
  };
  return R"({"version": 2, "name": "t", "inputs": [{"name": "low", "type": "scalar", "to": "low.condition"},
             {"name": "high", "type": "scalar", "to": "high.condition"}],
             "lsis": [{"id": "it", "type": "motion choice", "parameters": {"character": "character"}}, )" +
         rule("low", 1, low) + ", " + rule("high", 2, high) + R"(],
             "wires": [{"from": "high.choice", "to": "it.choice"}, {"from": "low.choice", "to": "high.below"},
                       {"from": "it.now", "to": "low.now"}, {"from": "it.now", "to": "high.now"},
                       {"from": "it.ended", "to": "low.ended"}, {"from": "it.ended", "to": "high.ended"}]})";
}

TEST(PlayRule, WhenPlaysTheMotionOnceForEachRise) {
  const auto world = make_world();
  circuit::Interpreter i = build(world.get(), rules_circuit("when", "while"), 0.01);
  i.run(10);
  EXPECT_EQ(get(i, "it.now"), 0);
  set(i, "low", 1);  // stays true: the motion must not repeat
  i.run(100);
  EXPECT_EQ(get(i, "it.now"), 1);
  EXPECT_EQ(get(i, "low.active"), 1);
  i.run(100);
  EXPECT_EQ(get(i, "it.now"), 0) << "after its end the track plays";
  EXPECT_EQ(get(i, "low.active"), 0);
  i.run(300);
  EXPECT_EQ(get(i, "it.now"), 0);
  EXPECT_EQ(get(i, "low.count"), 1);
  set(i, "low", 0);
  i.run(1);
  set(i, "low", 1);
  i.run(2);
  EXPECT_EQ(get(i, "it.now"), 1);
  EXPECT_EQ(get(i, "low.count"), 2);
}

TEST(PlayRule, WhileLastsAsLongAsItsConditionAndHasPriority) {
  const auto world = make_world();
  circuit::Interpreter i = build(world.get(), rules_circuit("when", "while"), 0.01);
  set(i, "high", 1);
  i.run(500);  // longer than the motion, which repeats
  EXPECT_EQ(get(i, "it.now"), 2);
  set(i, "low", 1);
  i.run(100);
  EXPECT_EQ(get(i, "it.now"), 2) << "the higher rule has priority";
  set(i, "high", 0);
  i.run(50);
  EXPECT_EQ(get(i, "it.now"), 1) << "the lower rule waited";
  set(i, "high", 1);
  i.run(50);
  EXPECT_EQ(get(i, "it.now"), 2);
  set(i, "high", 0);
  i.run(50);
  EXPECT_EQ(get(i, "it.now"), 0) << "an interrupted motion does not continue";
  EXPECT_EQ(get(i, "high.count"), 2);
}

TEST(PlayRule, WhileEndsWithAMotionThatDoesNotLoop) {
  const auto world = make_world();
  circuit::Interpreter i = build(world.get(), rules_circuit("while", "while"), 0.01);
  set(i, "low", 1);
  i.run(100);
  EXPECT_EQ(get(i, "it.now"), 1);
  i.run(200);
  EXPECT_EQ(get(i, "it.now"), 0) << "the condition is still true, but the motion is over";
  set(i, "low", 0);
  i.run(5);
  set(i, "low", 1);
  i.run(50);
  EXPECT_EQ(get(i, "it.now"), 1);
}

/// The execution circuit with a touch condition between `body` and `other`, and a push on the ball at the input `go`.
std::string physics_circuit(const std::string& touch, const std::string& push) {
  circuit::Circuit c = make_execution_circuit({{"character", true, 1, 1, 0.5}, {"ball", false, 1, 1, 0.5}}, 0.002);
  circuit::Instance test, force;
  test.id = "touch";
  test.type = "touch";
  force.id = "push";
  force.type = "push";
  force.values = {{"force", std::vector<double>{-4.5, 0, 0}}};
  const auto parse = [](const std::string& text, circuit::Instance& out) {
    for (std::size_t from = 0; from < text.size();) {
      const std::size_t end = std::min(text.find(';', from), text.size()), equal = text.find('=', from);
      const std::string name = text.substr(from, equal - from), value = text.substr(equal + 1, end - equal - 1);
      if (name == "duration")
        out.parameters.emplace_back(name, std::stod(value));
      else
        out.parameters.emplace_back(name, value);
      from = end + 1;
    }
  };
  parse(touch, test);
  parse(push, force);
  c.lsis.insert(c.lsis.end(), {test, force});
  c.inputs.push_back({"go", circuit::PinTypeId::scalar, "", "", {"push.when"}});
  for (circuit::Wire& w : c.wires)
    if (w.to == "dynamics.events") w.from = "push.events";
  c.wires.insert(c.wires.end(), {{"dynamics.contacts", "touch.contacts"}, {"event.events", "push.events"}});
  return circuit::write_circuit(c);
}

TEST(TouchCondition, HoldsBetweenTheNamedLinksOnly) {
  const auto world = make_world();
  struct Case {
    const char* touch;
    bool wanted;
  };
  for (const Case& c :
       {Case{"character=ball;other=ground", true}, Case{"character=ball", true}, Case{"character=ball;other=character", false},
        Case{"character=character;link=foot left;other=ground", true}, Case{"character=character;link=trunk", false}}) {
    circuit::Interpreter i = build(world.get(), physics_circuit(c.touch, "character=ball"), 0.002);
    ASSERT_TRUE(i.run(50));
    EXPECT_EQ(get(i, "touch.touching"), c.wanted ? 1 : 0) << c.touch;
    if (std::string(c.touch) == "character=ball") EXPECT_NEAR(get(i, "touch.force"), 0.45 * 9.81, 0.05) << "the weight of the ball";
  }
}

TEST(PushRule, GivesTheImpulseOfForceTimesDuration) {
  const auto world = make_world();
  const Character& ball = world->characters()[1];
  // 4.5 N on 0.45 kg for 0.02 s; no friction acts on the centre of the ball during the first contact-free direction x except rolling
  for (const bool lasting : {false, true}) {
    circuit::Interpreter i =
        build(world.get(), physics_circuit("character=ball", lasting ? "character=ball" : "character=ball;duration=0.02"), 0.002);
    i.run(5);
    const auto state = [&] { return i.find_circuit_output("state")->numbers().data(); };
    EXPECT_NEAR(v_of(ball, state())[3], 0, 1e-9);
    set(i, "go", 1);
    i.run(10);
    EXPECT_EQ(get(i, "push.active"), 1);
    if (lasting) set(i, "go", 0);
    i.run(1);
    EXPECT_EQ(get(i, "push.active"), 0);
    EXPECT_EQ(get(i, "push.count"), 1);
    // a ball that rolls without slip has 7/5 of its mass as inertia: v = F t / (1.4 m)
    EXPECT_NEAR(v_of(ball, state())[3], -4.5 * 0.02 / (1.4 * 0.45), 0.01);
  }
}

TEST(RuleLsis, UnknownLinksAreErrors) {
  const auto world = make_world();
  const auto c = circuit::read_circuit(physics_circuit("character=ball;link=nose", "character=ball;link=ear"));
  ASSERT_TRUE(c);
  const auto i = circuit::Interpreter::build(*c, standard_library(), world.get(), {.dt = 0.002});
  ASSERT_FALSE(i);
  EXPECT_NE(i.error().text().find("nose"), std::string::npos);
  EXPECT_NE(i.error().text().find("ear"), std::string::npos);
}

}  // namespace
}  // namespace ugoki::lsi
