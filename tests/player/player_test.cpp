// The player: reproducible runs (same bits), inputs, save and restore, no allocation while stepping.

#include "ugoki/content/player.h"
#include "allocation_count.h"
#include "small_world.h"
#include "ugoki/content/default_circuit.h"
#include "ugoki/content/generate.h"
#include "ugoki/content/ugx.h"

namespace ugoki::content {
namespace {

Scenario small_scenario() {
  Scenario s;
  s.name = "small";
  s.duration = 3;
  ScenarioCharacter walker;
  walker.id = walker.name = "character";
  walker.mechanism = "m-character";
  walker.place = {1, 2, 0, 90};
  ScenarioClip clip;
  clip.id = "k1";
  clip.motion = "n-sway";
  clip.length = 1.5;
  ScenarioClip second = clip;
  second.id = "k2";
  second.start = 1.5;
  second.offset = 0.5;
  walker.track = {clip, second};
  ScenarioCharacter ball;
  ball.id = ball.name = "ball";
  ball.mechanism = "m-ball";
  ball.place = {4, 0, 0.11, 0};
  ball.control.mode = ControlMode::passive;
  s.characters = {walker, ball};
  ScenarioEvent push;
  push.id = "e1";
  push.type = EventType::push;
  push.time = 0.5;
  push.character = "character";
  push.link = "chest";
  push.force = {20, 0, 0};
  ScenarioEvent thrown;
  thrown.id = "e2";
  thrown.type = EventType::throw_;
  thrown.time = 0.2;
  thrown.character = "ball";
  thrown.from = {4, 2, 1.2};
  thrown.velocity = {-4, 0, 1};
  s.events = {thrown, push};
  return s;
}

std::vector<std::byte> small_content(const Scenario& scenario = small_scenario()) {
  Resources resources;
  resources.mechanisms.emplace("m-character", lsi::make_character());
  resources.mechanisms.emplace("m-ball", lsi::make_ball());
  resources.motions.emplace("n-sway", lsi::make_sway(*resources.mechanisms.at("m-character"), 3));
  auto bytes = generate(scenario, resources);
  EXPECT_TRUE(bytes) << (bytes ? "" : bytes.error().text());
  return bytes ? *bytes : std::vector<std::byte>();
}

Player open(const std::vector<std::byte>& bytes) {
  auto player = Player::open(bytes);
  EXPECT_TRUE(player) << (player ? "" : player.error().text());
  return std::move(*player);
}

void run(Player& player, int steps) {
  for (int k = 0; k < steps; ++k) {
    const auto done = player.step();
    ASSERT_TRUE(done) << done.error().text();
  }
}

TEST(Player, PlaysGeneratedData) {
  Player player = open(small_content());
  EXPECT_EQ(player.step_size(), 0.002);
  DisplayFrame frame;
  player.display_frame(frame);
  ASSERT_EQ(frame.characters.size(), 2u);
  EXPECT_NEAR(frame.characters[0].links[0].p.x, 1, 1e-9);  // at the character's place, rotated by 90 degrees
  EXPECT_NEAR(frame.characters[0].links[0].p.y, 2, 1e-9);
  EXPECT_NEAR(rotate(frame.characters[0].links[0].r, {1, 0, 0}).y, 1, 1e-6);
  run(player, 1000);
  EXPECT_EQ(player.step_count(), 1000u);
  EXPECT_DOUBLE_EQ(player.time(), 2);
  player.display_frame(frame);
  EXPECT_EQ(frame.characters[0].state, CharacterState::tracking);
  EXPECT_EQ(frame.characters[1].state, CharacterState::passive);
  EXPECT_GE(frame.contacts.size(), 4u);
  EXPECT_NEAR(frame.characters[0].weight, 40 * 9.81, 1e-9);
  const PlayerMeasures m = player.measures(0);
  EXPECT_FALSE(m.fell);
  EXPECT_LT(m.tracking_rms_deg, 3);
  EXPECT_EQ(m.feet_on_ground, 2);
  EXPECT_EQ(player.measures(1).feet_on_ground, -1);
  EXPECT_EQ(player.find_link(0, "chest"), 0);
  EXPECT_EQ(player.find_link(0, "tail"), -1);
}

TEST(Player, EditPosesFollowTheTrackWithoutPhysics) {
  const Player player = open(small_content());
  DisplayFrame at_start, later;
  player.pose_at(0, at_start);
  player.pose_at(1, later);
  EXPECT_EQ(later.characters[0].state, CharacterState::edit);
  EXPECT_NEAR(norm(later.characters[0].links[0].p - at_start.characters[0].links[0].p), 0, 1e-6);
  EXPECT_LT(rotate(later.characters[0].links[0].r, {0, 0, 1}).z, 0.9999);  // the character leans
  EXPECT_NEAR(later.characters[1].links[0].p.x, 4, 1e-12);
  EXPECT_EQ(player.step_count(), 0u);
}

TEST(Player, SameBitsInTwoRuns) {
  const std::vector<std::byte> bytes = small_content();
  Player a = open(bytes), b = open(bytes);
  EXPECT_EQ(a.state_hash(), b.state_hash());
  const std::uint64_t first = a.state_hash();
  for (int k = 0; k < 10; ++k) {
    run(a, 60);
    run(b, 60);
    ASSERT_EQ(a.state_hash(), b.state_hash());
  }
  EXPECT_NE(a.state_hash(), first);
  DisplayFrame frame;
  a.display_frame(frame);  // this call must not change the state
  run(a, 60);
  run(b, 60);
  EXPECT_EQ(a.state_hash(), b.state_hash());
}

TEST(Player, SameBitsAfterSaveAndRestore) {
  const std::vector<std::byte> bytes = small_content();
  Player a = open(bytes), b = open(bytes);
  run(a, 200);
  a.grab(0, 0, {0, 0, 0.3}, {1.1, 2.2, 1.3});
  std::vector<std::byte> saved;
  a.save(saved);  // after the input, before the step in which it acts
  run(a, 300);
  const PlayerMeasures measures = a.measures(0);
  ASSERT_TRUE(b.restore(saved));
  EXPECT_EQ(b.step_count(), 200u);
  EXPECT_EQ(b.inputs().size(), 1u);
  run(b, 300);
  EXPECT_EQ(a.state_hash(), b.state_hash());
  EXPECT_EQ(b.measures(0).tracking_rms_deg, measures.tracking_rms_deg);
  EXPECT_EQ(b.measures(0).foot_skate_cm, measures.foot_skate_cm);
  EXPECT_EQ(b.measures(0).penetration_rms_mm, measures.penetration_rms_mm);
  const auto refused = b.restore(std::span<const std::byte>(saved).first(100));
  ASSERT_FALSE(refused);
  EXPECT_EQ(a.state_hash(), b.state_hash());
}

TEST(Player, RecordedInputsReplayToTheSameBits) {
  const std::vector<std::byte> bytes = small_content();
  Player a = open(bytes);
  run(a, 100);
  a.push(0, 0, {0, 150, 0}, 0.1);
  run(a, 137);
  a.grab(0, 0, {0, 0, 0.5}, {1, 2, 1.5});
  for (int k = 0; k < 50; ++k) {
    a.drag({1 + 0.002 * k, 2, 1.5});
    a.drag({1 + 0.004 * k, 2, 1.5});  // replaces the previous drag, because both arrive between the same two steps
    run(a, 1);
  }
  a.release();
  a.throw_from(1, {0, 0, 2}, {1, 0, 0}, {});
  run(a, 100);
  EXPECT_EQ(a.inputs().size(), 54u);
  Player still = open(bytes), b = open(bytes);
  run(still, 387);
  EXPECT_NE(still.state_hash(), a.state_hash());
  b.schedule(a.inputs());
  run(b, 387);
  EXPECT_EQ(b.state_hash(), a.state_hash());
  EXPECT_EQ(b.inputs().size(), a.inputs().size());
  b.reset();
  run(b, 387);
  EXPECT_EQ(b.state_hash(), a.state_hash());
  Player late = open(bytes);
  run(late, 120);
  late.schedule(a.inputs());  // the push of step 100 is in the past and is skipped
  run(late, 267);
  EXPECT_EQ(late.inputs().size(), 53u);
}

/// Returns the small content with its default circuit and an additional LSI that counts presses of the key W.
std::vector<std::byte> content_with_a_key() {
  Scenario scenario = small_scenario();
  auto c = circuit::read_circuit(default_circuit(scenario));
  EXPECT_TRUE(c);
  circuit::Instance key, presses;
  key.id = "key";
  key.type = "keyboard";
  key.parameters = {{"key", std::string("KeyW")}};
  presses.id = "presses";
  presses.type = "counter";
  c->lsis.insert(c->lsis.end(), {key, presses});
  c->wires.push_back({"key.pressed", "presses.in"});
  scenario.circuit = circuit::write_circuit(*c);
  return small_content(scenario);
}

double presses(Player& player) { return player.interpreter().find_output("presses.out")->numbers()[0]; }

TEST(Player, RecordedDeviceStatesReplayToTheSameBits) {
  const std::vector<std::byte> bytes = content_with_a_key();
  Player a = open(bytes);
  EXPECT_EQ(a.devices().use().keys, std::vector<std::string>{"KeyW"});
  circuit::DeviceState down, other;
  down.keys = {"KeyW"};
  other.keys = {"KeyQ"};
  a.hold(other);  // the circuit does not read this key
  EXPECT_TRUE(a.inputs().empty());
  run(a, 10);
  for (int k = 0; k < 3; ++k) {
    a.hold(down);
    a.hold(down);
    run(a, 4);
    a.hold({});
    run(a, 4);
  }
  EXPECT_EQ(a.inputs().size(), 6u);
  EXPECT_EQ(presses(a), 3);
  Player b = open(bytes);
  b.schedule(a.inputs());
  run(b, 34);
  std::vector<std::byte> of_a, of_b;
  a.save(of_a);
  b.save(of_b);
  EXPECT_EQ(of_a, of_b) << "the complete state must be equal, not only the characters";
  EXPECT_EQ(b.inputs().size(), 6u);
  b.reset();
  EXPECT_TRUE(b.devices().has({}));
}

TEST(Player, TapBetweenTwoStepsIsRead) {
  const std::vector<std::byte> bytes = content_with_a_key();
  Player a = open(bytes);
  circuit::DeviceState down;
  down.keys = {"KeyW"};
  run(a, 5);
  for (int tap = 1; tap <= 3; ++tap) {
    a.hold(down);
    a.hold({});
    run(a, 1);
    EXPECT_EQ(presses(a), tap);
    EXPECT_TRUE(a.devices().has({})) << "the key is released before the next step";
    run(a, 3);
  }
  a.hold(down);
  run(a, 4);
  a.hold({});
  a.hold(down);
  a.hold({});
  EXPECT_TRUE(a.devices().has({})) << "a step has read this press";
  run(a, 4);
  EXPECT_EQ(presses(a), 4);
  Player b = open(bytes);
  b.schedule(a.inputs());
  run(b, 25);
  EXPECT_EQ(presses(b), 4);
  std::vector<std::byte> of_a, of_b;
  a.save(of_a);
  b.save(of_b);
  EXPECT_EQ(of_a, of_b);
}

TEST(Devices, PressesAreKeptForKeysAndButtons) {
  circuit::DeviceState before, between, state;
  before.keys = {"KeyA"};
  between.keys = {"KeyA", "KeyC"};
  between.mouse.left = true;
  between.gamepads[1].buttons[3] = 0.8;
  between.gamepads[1].buttons[4] = 0.3;  // not pressed half-way
  state.keys = {"KeyB"};
  EXPECT_TRUE(circuit::keep_presses(before, between, state));
  EXPECT_EQ(state.keys, (std::vector<std::string>{"KeyB", "KeyC"}));
  EXPECT_TRUE(state.mouse.left);
  EXPECT_EQ(state.gamepads[1].buttons[3], 0.8);
  EXPECT_EQ(state.gamepads[1].buttons[4], 0);
  EXPECT_FALSE(circuit::keep_presses(between, between, state));
}

TEST(Player, RestoreKeepsTheDeviceStateFromBeforeTheSave) {
  Player a = open(content_with_a_key());
  circuit::DeviceState down;
  down.keys = {"KeyW"};
  run(a, 5);
  a.hold(down);
  std::vector<std::byte> saved;
  a.save(saved);
  run(a, 5);
  ASSERT_TRUE(a.restore(saved));
  EXPECT_EQ(a.inputs().size(), 1u) << "the key was held when the state was saved";
  a.hold({});
  EXPECT_TRUE(a.inputs().back().held->keys.empty());
  run(a, 5);
  EXPECT_EQ(presses(a), 0);
  ASSERT_TRUE(a.restore(saved));
  run(a, 5);
  EXPECT_EQ(presses(a), 1);
}

TEST(Player, IgnoresInvalidInputs) {
  const std::vector<std::byte> bytes = small_content();
  Player a = open(bytes), b = open(bytes);
  a.push(7, 0, {100, 0, 0}, 1);
  a.push(0, 99, {100, 0, 0}, 1);
  a.push(0, 0, {0.0 / 0.0, 0, 0}, 1);
  a.push(0, 0, {100, 0, 0}, -1);
  a.grab(-1, 0, {}, {});
  a.throw_from(2, {}, {}, {});
  PlayerInput wrong;
  wrong.record.kind = lsi::EventKind::push;
  wrong.record.character = 4000000000u;
  a.schedule({wrong});
  run(a, 50);
  run(b, 50);
  EXPECT_TRUE(a.inputs().empty());
  EXPECT_EQ(a.state_hash(), b.state_hash());
}

TEST(Player, StepsWithoutAllocation) {
  Player player = open(small_content());
  DisplayFrame frame;
  std::vector<std::byte> saved, encoded;
  run(player, 1200);  // after throw, push and blend: all memory has reached its final size
  player.display_frame(frame);
  encode_frame(frame, 0, 0, encoded);
  player.save(saved);
  ASSERT_TRUE(player.restore(saved));
  run(player, 1);
  const long before = allocations_so_far();
  for (int k = 0; k < 300; ++k) {
    if (!player.step()) break;
    if (k % 8 == 0) player.display_frame(frame);
  }
  EXPECT_EQ(allocations_so_far(), before);
}

/// Returns the small scenario with an assist limit of 0 and without events.
Scenario balancing_scenario() {
  Scenario s = small_scenario();
  s.characters[0].control.assist_limit = 0;
  s.events.clear();
  return s;
}

TEST(Player, CharacterWithoutAssistBalances) {
  Player player = open(small_content(balancing_scenario()));
  run(player, 1400);
  const PlayerMeasures m = player.measures(0);
  EXPECT_FALSE(m.fell);
  EXPECT_EQ(m.assist_max_bw, 0);
  EXPECT_LT(m.release_time, 0);
  EXPECT_LT(m.tracking_rms_deg, 4);
  EXPECT_LT(m.foot_skate_worst_cm, 1);
  EXPECT_EQ(m.feet_on_ground, 2);
}

TEST(Player, BalanceGivesTheSameBitsAfterRestore) {
  const std::vector<std::byte> content = small_content(balancing_scenario());
  Player a = open(content), b = open(content);
  run(a, 500);
  a.push(0, 0, {0, 60, 0}, 0.2);  // makes the character step
  run(a, 100);
  std::vector<std::byte> saved;
  a.save(saved);
  ASSERT_TRUE(b.restore(saved));
  run(a, 500);
  run(b, 500);
  EXPECT_EQ(a.state_hash(), b.state_hash());
}

TEST(Player, BalanceStepsWithoutAllocation) {
  Player player = open(small_content(balancing_scenario()));
  run(player, 400);
  const long before = allocations_so_far();
  for (int k = 0; k < 300; ++k)
    if (!player.step()) break;
  EXPECT_EQ(allocations_so_far(), before);
}

TEST(Player, DivergedSimulationStopsAndKeepsTheLastValidState) {
  Scenario s = small_scenario();
  s.events[1].link = "foot left";
  s.events[1].force = {1e6, 0, 0};
  s.events[1].duration = 2;
  Player player = open(small_content(s));
  Result<void> done = {};
  int steps = 0;
  while (done && steps < 1500) {
    done = player.step();
    ++steps;
  }
  ASSERT_FALSE(done);
  EXPECT_NE(done.error().text().find("character"), std::string::npos) << done.error().text();
  for (const double x : player.q(0)) EXPECT_TRUE(std::isfinite(x));
  const std::uint64_t hash = player.state_hash();
  EXPECT_FALSE(player.step());
  EXPECT_EQ(player.state_hash(), hash);
  player.reset();
  EXPECT_TRUE(player.step());
}

TEST(Player, RefusesACircuitWithoutTheRequiredPins) {
  Scenario s = small_scenario();
  s.circuit = R"({"version": 1, "name": "mine", "lsis": [{"id": "x", "type": "clock"}]})";
  const auto player = Player::open(small_content(s));
  ASSERT_FALSE(player);
  EXPECT_NE(player.error().text().find("The circuit has no output 'state'"), std::string::npos);
  EXPECT_NE(player.error().text().find("no input 'live'"), std::string::npos);
}

TEST(Player, RefusesDamagedData) {
  const std::vector<std::byte> bytes = small_content();
  for (std::size_t at = 0; at < bytes.size(); at += 1 + bytes.size() / 400) {
    std::vector<std::byte> damaged = bytes;
    damaged[at] ^= std::byte{0x20};
    const auto player = Player::open(damaged);
    if (player) {  // only changes of padding and reserved fields are not detected
      EXPECT_EQ(player->state_hash(), open(bytes).state_hash()) << at;
    } else {
      EXPECT_FALSE(player.error().problems[0].remedy.empty());
    }
  }
  for (std::size_t n = 0; n < bytes.size(); n += 1 + bytes.size() / 100) EXPECT_FALSE(Player::open(std::span(bytes).first(n)));
}

TEST(Ugx, WritesAndReadsAlignedSections) {
  UgxWriter writer;
  writer.add("one", "text");
  writer.add("two", std::vector<std::byte>(100, std::byte{7}));
  writer.add("none", "");
  const std::vector<std::byte> file = writer.finish();
  const auto ugx = read_ugx(file);
  ASSERT_TRUE(ugx) << ugx.error().text();
  ASSERT_EQ(ugx->sections().size(), 3u);
  EXPECT_EQ(ugx->find("one")->text(), "text");
  EXPECT_EQ(ugx->find("two")->bytes.size(), 100u);
  EXPECT_EQ(ugx->find("none")->bytes.size(), 0u);
  EXPECT_EQ(ugx->find("three"), nullptr);
  for (const UgxSection& s : ugx->sections()) EXPECT_EQ((s.bytes.data() - file.data()) % 64, 0);
}

TEST(Ugx, EveryByteExceptPaddingIsChecked) {
  UgxWriter writer;
  writer.add("one", "text");
  writer.add("two", std::vector<std::byte>(100, std::byte{7}));
  const std::vector<std::byte> file = writer.finish();
  const auto ugx = read_ugx(file);
  ASSERT_TRUE(ugx);
  for (std::size_t at = 0; at < file.size(); ++at) {
    bool is_checked = at < 32 || (at >= 64 && at < 64 + 2 * 64);  // header and section table
    for (const UgxSection& s : ugx->sections()) {
      const auto begin = static_cast<std::size_t>(s.bytes.data() - file.data());
      is_checked = is_checked || (at >= begin && at < begin + s.bytes.size());
    }
    std::vector<std::byte> damaged = file;
    damaged[at] ^= std::byte{1};
    EXPECT_EQ(!read_ugx(damaged), is_checked) << at;
  }
  std::vector<std::byte> longer = file;
  longer.push_back(std::byte{0});
  EXPECT_FALSE(read_ugx(longer));
}

}  // namespace
}  // namespace ugoki::content
