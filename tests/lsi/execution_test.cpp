// The execution circuit with a small world.

#include <algorithm>
#include <cmath>

#include "small_world.h"
#include "ugoki/dynamics/dynamics.h"
#include "ugoki/lsi/pull.h"
#include "ugoki/lsi/touch.h"
#include "ugoki/lsi/track_sampler.h"

namespace ugoki::lsi {
namespace {

TEST(Execution, CircuitCanBeWrittenAndRead) {
  const SmallWorld world;
  const std::string text = circuit::write_circuit(world.circuit);
  const auto read = circuit::read_circuit(text);
  ASSERT_TRUE(read) << read.error().text();
  EXPECT_TRUE(*read == world.circuit);
}

TEST(Execution, CharacterStandsAndFollowsItsReference) {
  const SmallWorld world;
  auto i = world.build();
  ASSERT_TRUE(i) << i.error().text();
  for (int k = 0; k < 2000; ++k) ASSERT_TRUE(i->tick()) << i->stopped()->text();
  ASSERT_TRUE(i->refresh());
  const double* measures = numbers(*i, "measures");
  EXPECT_LT(measures[measure_tracking], 2);
  EXPECT_LT(measures[measure_assist], 0.2);
  EXPECT_LT(measures[measure_penetration], 5);
  EXPECT_EQ(measures[measure_fell], 0);
  EXPECT_EQ(measures[measure_release_time], -1);
  EXPECT_EQ(measures[measure_feet], 2);
  EXPECT_LE(measures[measure_depth_now], measures[measure_penetration]);
  EXPECT_LE(measures[measure_assist_now], measures[measure_assist_max]);
  EXPECT_LE(measures[measure_slip_now], measures[measure_skate_worst]);
  EXPECT_GT(measures[measure_tracking_now], 0);
  EXPECT_LT(measures[measure_tracking_now], 2);
  const double* walkers = numbers(*i, "characters");
  EXPECT_EQ(walkers[character_state], 0);
  EXPECT_EQ(walkers[character_entry_count + character_state], 2);
  EXPECT_NEAR(walkers[character_weight], 40 * 9.81, 1e-9);
  // The contact forces carry the weight of the character.
  double up = 0;
  for (const ContactRecord& c : records<ContactRecord>(i->find_circuit_output("contacts")->bytes.data()))
    if (c.point.system_a == 0) up += c.force.z;
  EXPECT_NEAR(up, 40 * 9.81, 0.1 * 40 * 9.81);
}

TEST(Execution, TouchesAreEventsWithNamesAndImpulses) {
  const SmallWorld world;
  auto i = world.build();
  ASSERT_TRUE(i) << i.error().text();
  std::vector<std::string> journal;
  double impulse = 0;
  for (int k = 0; k < 500; ++k) {
    ASSERT_TRUE(i->tick());
    const auto touches = i->find_output("dynamics.touches");
    ASSERT_TRUE(touches);
    for (const EventRecord& e : records<EventRecord>(touches->bytes.data())) {
      journal.push_back(describe_touch(*world.world, e));
      impulse += e.kind == EventKind::touch ? norm(e.b) : 0;
    }
  }
  const auto contains = [&](std::string_view text) {
    return std::ranges::any_of(journal, [&](const std::string& line) { return line.find(text) != std::string::npos; });
  };
  EXPECT_TRUE(contains("foot left of ")) << journal.size();
  EXPECT_TRUE(contains(" touched the ground, "));
  EXPECT_TRUE(contains(" N s"));
  EXPECT_GT(impulse, 0);
  EXPECT_LT(journal.size(), 20U) << "standing must be one touch, not many";
}

TEST(Execution, DynamicsReportsHowWellStepsWereSolved) {
  MechanismSpec spec;
  spec.name = "box";
  LinkSpec box;
  box.name = "box";
  box.joint.type = JointType::floating;
  box.shapes = {Shape::box({0.1, 0.1, 0.1})};
  spec.links = {box};
  std::vector<CharacterSpec> tower;  // 12 boxes, the uppermost a hundred times heavier than the others
  for (int k = 0; k < 12; ++k) {
    spec.links[0].inertia = solid_inertia(box.shapes[0], k == 11 ? 100000 : 1000);
    CharacterSpec c;
    c.id = "box" + std::to_string(k);
    c.mechanism = make_checked(spec);
    c.q0 = c.mechanism->neutral();
    c.q0[2] = 0.1 + 0.2 * k;
    tower.push_back(std::move(c));
  }
  const World world(std::move(tower), {}, Vec3{0, 0, -9.81}, collision::Ground{});
  circuit::Circuit usual = make_execution_circuit({}, 0.002), hasty = usual;
  for (circuit::Instance& lsi : hasty.lsis)
    if (lsi.type == "dynamics") lsi.parameters = {{"iterations", 1.0}};
  auto a = circuit::Interpreter::build(usual, standard_library(), &world, {.dt = 0.002, .check_finite = true});
  auto b = circuit::Interpreter::build(hasty, standard_library(), &world, {.dt = 0.002, .check_finite = true});
  ASSERT_TRUE(a && b);
  const auto output = [](const circuit::Interpreter& i, const char* pin) {
    return i.find_output(std::string("dynamics.") + pin)->numbers()[0];
  };
  for (int k = 0; k < 3; ++k) {
    ASSERT_TRUE(a->tick() && b->tick());
    EXPECT_EQ(output(*a, "not converged"), 0);
    EXPECT_EQ(output(*b, "not converged"), 1);
    EXPECT_EQ(output(*a, "substeps"), 1);
    EXPECT_EQ(output(*a, "failures"), 0);
  }
}

TEST(Execution, ScheduledPushActsForItsDurationOnly) {
  ScheduledEvent push;
  push.record.kind = EventKind::push;
  push.record.a = {0, 30, 0};
  push.time = 0.5;
  push.duration = 0.2;
  const SmallWorld pushed({push}), still;
  auto a = pushed.build(), b = still.build();
  ASSERT_TRUE(a && b);
  int active = 0;
  for (int k = 0; k < 600; ++k) {
    ASSERT_TRUE(a->tick() && b->tick());
    const bool now = !records<EventRecord>(a->find_circuit_output("events")->bytes.data()).empty();
    EXPECT_EQ(now, k >= 250 && k < 350) << k;
    active += now;
    const bool same = std::equal(numbers(*a, "state"), numbers(*a, "state") + 7, numbers(*b, "state"));
    EXPECT_EQ(same, k < 250) << k;
  }
  EXPECT_EQ(active, 100);
}

TEST(Execution, MomentumChangeEqualsReportedForces) {
  ScheduledEvent push;
  push.record.kind = EventKind::push;
  push.record.a = {150, 30, 0};
  push.time = 0.2;
  push.duration = 0.2;
  const SmallWorld world({push});
  auto i = world.build();
  ASSERT_TRUE(i);
  const Character& walker = world.world->characters()[0];
  dynamics::Workspace ws(*world.character);
  const auto momentum = [&] {
    const double* state = numbers(*i, "state");
    dynamics::update_kinematics(*world.character, q_of(walker, state), v_of(walker, state), ws);
    return dynamics::momentum(*world.character, ws).v;
  };
  const Vec3 before = momentum();
  const auto assist = i->find_output("character/control.assist force");
  ASSERT_TRUE(assist);
  Vec3 impulse, assisted;
  for (int k = 0; k < 250; ++k) {
    ASSERT_TRUE(i->tick());
    impulse.z -= 40 * 9.81 * 0.002;
    if (k >= 100 && k < 200) impulse += push.record.a * 0.002;
    const Vec3 help{assist->numbers()[0], assist->numbers()[1], assist->numbers()[2]};
    impulse += help * 0.002;
    assisted += help * 0.002;
    for (const ContactRecord& c : records<ContactRecord>(i->find_circuit_output("contacts")->bytes.data()))
      if (c.point.system_a == 0) impulse += c.force * 0.002;
  }
  EXPECT_GT(norm(assisted), 2.0);  // N s; otherwise a missing assist would not be detected
  EXPECT_NEAR(norm(momentum() - before - impulse), 0, 0.5);
}

TEST(Execution, ThrowSetsPositionAndVelocityAtItsTime) {
  ScheduledEvent event;
  event.record.kind = EventKind::throwing;
  event.record.character = 1;
  event.record.a = {2, 0, 1.2};
  event.record.b = {-6, 0, 2};
  event.record.c = {1, 2, 3};
  event.time = 0.1;
  const SmallWorld world({event});
  auto i = world.build();
  ASSERT_TRUE(i);
  const Character& ball = world.world->characters()[1];
  for (int k = 0; k < 50; ++k) ASSERT_TRUE(i->tick());
  const double* state = numbers(*i, "state");
  EXPECT_EQ(i->time(), 0.1);
  const auto q = q_of(ball, state), v = v_of(ball, state);
  EXPECT_NEAR(q[0], 2, 1e-12);
  EXPECT_NEAR(q[2], 1.2, 1e-12);
  EXPECT_NEAR(v[3], -6, 1e-12);
  EXPECT_NEAR(v[5], 2, 1e-12);
  const double spin = v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
  EXPECT_NEAR(spin, 14, 1e-9);
  // Free flight without air resistance.
  for (int k = 0; k < 50; ++k) ASSERT_TRUE(i->tick());
  EXPECT_NEAR(q[0], 2 - 6 * 0.1, 1e-9);
  EXPECT_NEAR(q[2], 1.2 + 2 * 0.1 - 0.5 * 9.81 * 0.1 * 0.1, 1.1e-3);
}

TEST(Execution, GrabbedLinkMovesTowardsTarget) {
  const SmallWorld world;
  auto i = world.build();
  ASSERT_TRUE(i);
  const int trunk = 0;
  EventRecord grab;
  grab.kind = EventKind::grab;
  grab.link = trunk;
  grab.a = {0, 0, 0.5};
  grab.b = {0.6, 0, 1.6};
  put_event(*i, grab);
  ASSERT_TRUE(i->tick());
  clear_events(*i);
  for (int k = 0; k < 1000; ++k) ASSERT_TRUE(i->tick()) << i->stopped()->text();
  const double* state = numbers(*i, "state");
  EXPECT_GT(state[0], 0.3);  // the character is pulled towards the target
  for (std::size_t k = 0; k < world.world->state_size(); ++k)
    ASSERT_LT(std::fabs(state[k]), 60);  // bounded, although the legs swing freely
  EventRecord release;
  release.kind = EventKind::release;
  put_event(*i, release);
  ASSERT_TRUE(i->tick());
  EXPECT_TRUE(records<EventRecord>(i->find_circuit_output("events")->bytes.data()).empty());
}

TEST(Execution, ResetAndRestoreGiveSameBits) {
  ScheduledEvent push;
  push.record.kind = EventKind::push;
  push.record.a = {60, 20, 0};
  push.time = 0.3;
  push.duration = 0.2;
  const SmallWorld world({push});
  auto a = world.build(), b = world.build();
  ASSERT_TRUE(a && b);
  for (int k = 0; k < 500; ++k) ASSERT_TRUE(a->tick());
  std::vector<std::byte> saved;
  a->save(saved);
  for (int k = 0; k < 500; ++k) ASSERT_TRUE(a->tick());
  ASSERT_TRUE(b->restore(saved));
  for (int k = 0; k < 500; ++k) ASSERT_TRUE(b->tick());
  std::vector<std::byte> one, two, three;
  a->save(one);
  b->save(two);
  EXPECT_TRUE(one == two);
  a->reset();
  for (int k = 0; k < 1000; ++k) ASSERT_TRUE(a->tick());
  a->save(three);
  EXPECT_TRUE(one == three);
}

TEST(Execution, WireFromAnotherCharacterIsRefused) {
  std::vector<CharacterSpec> specs(2);
  const MechanismPtr walker = make_character();
  for (std::size_t k = 0; k < 2; ++k) {
    specs[k].id = k == 0 ? "anna" : "ben";
    specs[k].mechanism = walker;
    TrackClip sway;
    sway.motion = make_sway(*walker, 1);
    sway.clip.length = 4;
    specs[k].track = {sway};
  }
  const World world(std::move(specs), {}, {0, 0, -9.81}, {});
  circuit::Circuit c = make_execution_circuit({{"anna", true, 1, 1, 0.5}, {"ben", true, 1, 1, 0.5}}, 0.002);
  EXPECT_TRUE(circuit::Interpreter::build(c, standard_library(), &world, {}));
  for (circuit::Instance& lsi : c.circuits[1].lsis)
    if (lsi.id == "control") lsi.parameters[0] = {"character", std::string("anna")};
  const auto refused = circuit::Interpreter::build(c, standard_library(), &world, {});
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().text().find("'ben/control.reference' belongs to the character 'ben', but the LSI to 'anna'"), std::string::npos)
      << refused.error().text();
}

TEST(Execution, EmptyWorldRuns) {
  const World empty({}, {}, {0, 0, -9.81}, {});
  auto i = circuit::Interpreter::build(make_execution_circuit({}, 0.002), standard_library(), &empty, {});
  ASSERT_TRUE(i) << i.error().text();
  for (int k = 0; k < 10; ++k) EXPECT_TRUE(i->tick());
  EXPECT_TRUE(i->refresh());
}

TEST(Track, BlendBetweenClipsIsSmooth) {
  const MechanismPtr m = make_character();
  const MotionPtr sway = make_sway(*m, 20);
  TrackClip first, second;
  first.motion = second.motion = sway;
  first.clip.length = 0.7;
  second.clip.start = 0.7;
  second.clip.length = 2;
  second.clip.offset = 0.37;
  second.clip.blend = 0.4;
  second.clip.placement.x = 0.5;
  const TrackSampler track(m, {first, second}, {}, false);
  const std::size_t n = track.layout().size(), nq = track.layout().nq, nv = track.layout().nv;
  std::vector<double> before(n), now(n), after(n), slope(nv);
  const double h = 1e-5;
  for (double t = 0.6; t < 1.3; t += 0.0137) {
    track.sample(t - h, before);
    track.sample(t, now);
    track.sample(t + h, after);
    difference(*m, std::span(before).first(nq), std::span(after).first(nq), slope);
    for (std::size_t k = 0; k < nv; ++k) {
      EXPECT_NEAR(slope[k] / (2 * h), now[nq + k], 0.02) << t << " " << k;  // v is the slope of q
      EXPECT_NEAR((after[nq + k] - before[nq + k]) / (2 * h), now[nq + nv + k], 0.6) << t << " " << k;
    }
  }
  // The first clip continues during the transition, so the velocity is continuous at t = 0.7 s, where the second clip
  // starts.
  track.sample(0.7 - 1e-7, before);
  track.sample(0.7 + 1e-7, after);
  double maximum = 0;
  for (std::size_t k = 0; k < nv; ++k) {
    EXPECT_NEAR(before[nq + k], after[nq + k], 1e-4);
    maximum = std::max(maximum, std::fabs(before[nq + k]));
  }
  EXPECT_GT(maximum, 0.2);
}

// The reference of a motion with few frames a second has more frames; the labels of contacts stay those of the motion.
TEST(Track, StancesOfSlowMotionsAreThoseOfTheirLabels) {
  const MechanismPtr m = make_character();
  Motion motion = *make_sway(*m, 4);
  motion.rate = 30;
  ContactTrack labels{m->link(1).name, {}};
  for (int f = 0; f < motion.frames; ++f) labels.on.push_back(f / 7 % 2 == 0 ? 1 : 0);
  motion.contacts = {labels};
  TrackClip clip;
  clip.motion = std::make_shared<const Motion>(motion);
  clip.clip.length = motion.duration();
  const int foot = 1;
  for (const bool smooth : {false, true}) {
    const TrackSampler track(m, {clip}, {&foot, 1}, smooth);
    std::vector<double> reference(track.layout().size());
    for (int f = 0; f < motion.frames; ++f) {
      track.sample(f / motion.rate, reference);
      ASSERT_EQ(reference[track.layout().stance()], labels.on[static_cast<std::size_t>(f)]) << f << " of " << motion.frames;
    }
  }
}

TEST(Pull, IsSpringAndDamperForSmallStepsAndStableForLargeSteps) {
  const MechanismPtr ball = make_ball();
  dynamics::Workspace ws(*ball);
  State s(*ball);
  const Vec3 slow = calc_pull(*ball, ws, s.q, s.v, 0, {}, {0.01, 0, 0}, 1e-9);
  EXPECT_NEAR(slow.x, ball->mass() * 100 * 0.01, 1e-6);  // spring force k x
  s.v[3] = 1;
  const Vec3 damped = calc_pull(*ball, ws, s.q, s.v, 0, {}, {0, 0, 0}, 1e-9);
  EXPECT_NEAR(damped.x, -2 * 0.7 * ball->mass() * 10, 1e-6);  // damping force -c u
  // With a step of 1 s the force does not reverse the velocity of the ball.
  const Vec3 stiff = calc_pull(*ball, ws, s.q, s.v, 0, {}, {0, 0, 0}, 1.0);
  EXPECT_GT(1 + stiff.x / ball->mass() * 1.0, -1e-9);
  const Vec3 far = calc_pull(*ball, ws, s.q, s.v, 0, {}, {100, 0, 0}, 0.002);
  EXPECT_NEAR(norm(far), 1.5 * ball->mass() * 9.81, 1e-9);
}

}  // namespace
}  // namespace ugoki::lsi
