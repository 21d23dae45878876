// Benchmarks with many worlds, characters or loops: saving and restoring a state, rollouts on two threads, tracked characters in one
// content, and closed linkages that rest on the ground.

#include <malloc.h>

#include <chrono>
#include <cmath>
#include <cstdio>
#include <ctime>

#include "table.h"
#include "ugoki/content/generate.h"
#include "ugoki/content/player.h"
#include "ugoki/plugin/thread_pool.h"
#include "ugoki/samples/samples.h"
#include "ugoki/world/rollout.h"

namespace ugoki::benchmarks {
namespace {

constexpr double dt = 0.002;  // s

double wall() { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); }
double processor() {
  timespec t{};
  ::clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

template <class T>
T checked(Result<T> result) {
  if (!result) throw std::runtime_error(result.error().text());
  return std::move(*result);
}

/// `count` sample humans who walk side by side.
std::vector<std::byte> walkers(int count) {
  const samples::Sample sample = samples::make_sample();
  content::Scenario s = checked(content::read_scenario(sample.document, "sample"));
  s.events.clear();
  const content::ScenarioCharacter human = s.characters.front();
  s.characters.clear();
  for (int k = 0; k < count; ++k) {
    s.characters.push_back(human);
    s.characters.back().id = "human" + std::to_string(k);
    s.characters.back().track.front().id = "clip" + std::to_string(k);
    s.characters.back().place.x = 2.0 * (k / 10);
    s.characters.back().place.y = 1.5 * (k % 10);
  }
  s.camera.follow = s.characters.front().id;
  return checked(content::generate(s, sample.resources));
}

/// A walking human as a world: its state at 1 s, and the drive forces and servo values of its motion control in the following steps.
struct Walk {
  content::Player player = checked(content::Player::open(walkers(1)));
  world::World world{player.world().mechanisms(), {.stepper = {}, .ground = player.world().ground()}};
  world::WorldState begin{world};
  std::vector<double> controls;  // [steps][3 nv] drive forces, servo gains, servo velocities

  explicit Walk(int steps) {
    const auto torque = [&] { return player.interpreter().find_output("human0/control.torque")->numbers(); };
    for (int i = 0; i < 500; ++i) (void)checked_step();
    std::ranges::copy(player.q(0), begin.q(0).begin());
    std::ranges::copy(player.v(0), begin.v(0).begin());
    for (int i = 0; i < steps; ++i) {
      (void)checked_step();
      const auto now = torque();
      controls.insert(controls.end(), now.begin(), now.end());
    }
    if (controls.size() != static_cast<std::size_t>(steps) * 3 * world.nv()) throw std::runtime_error("the controls have another size");
  }
  bool checked_step() {
    if (const Result<void> done = player.step(); !done) throw std::runtime_error(done.error().text());
    return true;
  }
};

void save_and_restore(Table& table) {
  const char* name = "save and restore of a walking human";
  if (!is_selected(name)) return;
  Walk walk(50);
  world::WorldStepper stepper(walk.world);
  stepper.load(walk.begin);
  const std::size_t each = 3 * walk.world.nv(), nv = walk.world.nv();
  for (std::size_t i = 0; i < 50; ++i) {
    const std::span<const double> c = std::span(walk.controls).subspan(i * each, each);
    (void)stepper.step({c.first(nv), c.subspan(nv, nv), c.subspan(2 * nv)}, dt);
  }
  world::WorldState state(walk.world), copy(walk.world);
  const std::vector<double> times = measure({[&] {
                                               stepper.store(state);
                                               copy = state;
                                             },
                                             [&] { stepper.load(copy); }});
  char note[120];
  std::snprintf(note, sizeof note, "store and copy %.0f ns, load %.0f ns; %zu bytes in use, %zu DOFs", times[0], times[1],
                state.bytes().size(), nv);
  table.add({.row = name,
             .ours_ns = times[0] + times[1],
             .peer = {},
             .extra = {{"bytes", static_cast<double>(state.bytes().size())}},
             .note = note});
}

void roll_out(Table& table) {
  const char* name = "rollout of 1000 walking humans, 25 steps";
  if (!is_selected(name)) return;
  constexpr int worlds = 1000, steps = 25;
  Walk walk(steps);
  std::vector<world::WorldState> begin(worlds, walk.begin);
  for (int k = 0; k < worlds; ++k) begin[static_cast<std::size_t>(k)].v(0)[3] += 1e-4 * k;
  struct Measured {
    double wall = HUGE_VAL, processor = HUGE_VAL;
    std::uint64_t hash = 0;
  };
  const auto run = [&](world::Rollout& rollout, Measured& best) {
    std::vector<world::WorldState> states = begin;
    std::vector<contact::StepReport> reports(worlds);
    const double w = wall(), p = processor();
    rollout.run(states, {walk.controls, 3 * walk.world.nv()}, steps, dt, reports);
    best.wall = std::min(best.wall, wall() - w);
    best.processor = std::min(best.processor, processor() - p);
    best.hash = 0;
    for (const world::WorldState& s : states) best.hash = best.hash * 31 + s.hash();
  };
  plugin::ThreadPool pool(2);
  world::Rollout one(walk.world), two(walk.world, &pool);
  Measured a, b;
  for (int k = 0; k < 7; ++k) {
    run(one, a);
    run(two, b);
  }
  if (a.hash != b.hash) throw std::runtime_error("rollouts on one and two threads differ");
  const double each = 1e9 / (worlds * steps);
  char note[160];
  std::snprintf(note, sizeof note,
                "one thread %.0f steps/s, two threads %.0f: %.1f %% of twice one by wall clock, %.1f %% by processor time",
                1e9 / (a.wall * each), 1e9 / (b.wall * each), 50 * a.wall / b.wall, 100 * a.processor / b.processor);
  table.add({.row = name,
             .ours_ns = b.wall * each,
             .peer = {},
             .extra = {{"one_thread_ns", a.wall * each}, {"of_twice_one", 0.5 * a.wall / b.wall}},
             .note = note});
}

/// Simulates content for `steps` steps in parts of 100. @return wall-clock and processor time of a step, s: minimum of the parts' means
std::pair<double, double> time_of(content::Player& player, int steps) {
  double best = HUGE_VAL, work = HUGE_VAL;
  for (int i = 0; i < steps; i += 100) {
    const double w = wall(), p = processor();
    for (int k = 0; k < 100; ++k)
      if (const Result<void> done = player.step(); !done) throw std::runtime_error(done.error().text());
    best = std::min(best, (wall() - w) / 100);
    work = std::min(work, (processor() - p) / 100);
  }
  return {best, work};
}

void tracked_characters(Table& table) {
  const char* name = "100 tracked humans in one content, two threads";
  if (!is_selected(name)) return;
  constexpr int steps = 600;
  const std::vector<std::byte> one_ugx = walkers(1), many_ugx = walkers(100);
  content::Player one = checked(content::Player::open(one_ugx));
  const auto before = mallinfo2();
  content::Player alone = checked(content::Player::open(many_ugx));
  const auto after = mallinfo2();
  plugin::ThreadPool pool(2);
  content::PlayerOptions options;
  options.executor = &pool;
  content::Player many = checked(content::Player::open(many_ugx, "many", options));
  const auto single = time_of(one, steps), serial = time_of(alone, steps), parallel = time_of(many, steps);
  if (alone.state_hash() != many.state_hash()) throw std::runtime_error("one and two threads give different states");
  const double memory = static_cast<double>(after.uordblks + after.hblkhd - before.uordblks - before.hblkhd) / 100;
  char note[320];
  std::snprintf(note, sizeof note,
                "real time x %.2f; us a character: alone %.1f, of 100 on one thread %.1f (x %.2f), on two threads %.1f; processor time: "
                "%.1f, %.1f (x %.2f), %.1f; %.0f kB a character",
                dt / parallel.first, 1e6 * single.first, 1e4 * serial.first, serial.first / single.first / 100, 1e4 * parallel.first,
                1e6 * single.second, 1e4 * serial.second, serial.second / single.second / 100, 1e4 * parallel.second, memory / 1000);
  table.add({.row = name,
             .ours_ns = 1e9 * parallel.first,
             .peer = {},
             .per = 100,
             .extra = {{"one_ns", 1e9 * single.first},
                       {"one_thread_ns", 1e9 * serial.first},
                       {"one_processor_ns", 1e9 * single.second},
                       {"one_thread_processor_ns", 1e9 * serial.second},
                       {"memory_bytes", memory}},
             .note = note});
}

/// N four-bar linkages (parallelograms) in a row along x. A foot at the end of each top bar carries the base bar of the next linkage.
MechanismPtr linkages(int n) {
  const auto bar = [](const std::string& name, const std::string& parent, const Vec3& at, const Vec3& end) {
    LinkSpec l;
    l.name = name;
    l.parent = parent;
    l.joint.type = parent.empty() ? JointType::floating : JointType::revolute;
    l.joint.axis = {0, 1, 0};
    l.joint.X_PJ.p = at;
    l.joint.dofs[0].damping = parent.empty() ? 0 : 0.5;
    const Shape shape = Shape::capsule(0.01, {0, 0, 0}, end);
    l.inertia = solid_inertia(shape, 1000);
    if (parent.empty() || end.z == 0) l.shapes.push_back(shape);
    return l;
  };
  MechanismSpec spec;
  spec.name = std::to_string(n) + " linkages";
  spec.links = {bar("base", "", {}, {0.2, 0, 0})};
  std::string below = "base";
  for (int k = 0; k < n; ++k) {
    const std::string i = std::to_string(k);
    // Each linkage is placed behind the last one along x, so that every base bar touches the ground.
    spec.links.push_back(bar("front" + i, below, {0.2, 0, 0}, {0, 0, 0.1}));
    spec.links.push_back(bar("rear" + i, below, {0, 0, 0}, {0, 0, 0.1}));
    spec.links.push_back(bar("top" + i, "rear" + i, {0, 0, 0.1}, {0.2, 0, 0}));
    LoopSpec pin;
    pin.name = "pin" + i;
    pin.type = LoopType::revolute;
    pin.link_a = "front" + i;
    pin.link_b = "top" + i;
    pin.X_AJ.p = {0, 0, 0.1};
    pin.X_BJ.p = {0.2, 0, 0};
    pin.axis = {0, 1, 0};
    spec.loops.push_back(pin);
    spec.links.push_back(bar("foot" + i, "top" + i, {0.2, 0, 0}, {0, 0, -0.1}));
    spec.links.push_back(bar("next" + i, "foot" + i, {0, 0, -0.1}, {0.2, 0, 0}));
    below = "next" + i;
  }
  return checked(Mechanism::make(std::move(spec)));
}

void standing_linkages(Table& table) {
  for (const int n : {10, 30, 100, 300, 1000}) {
    const std::string name = std::to_string(n) + " four-bars in series on the ground";
    if (!is_selected(name)) continue;
    const world::World world({linkages(n)}, {});
    world::WorldStepper stepper(world);
    world::WorldState s(world);
    s.q(0)[2] = 0.01;
    stepper.load(s);
    constexpr int warm = 50, steps = 50;
    contact::StepReport report;
    for (int i = 0; i < warm; ++i) report = stepper.step({}, dt);
    double best = HUGE_VAL;
    for (int i = 0; i < steps; ++i) {
      const double t = processor();
      report = stepper.step({}, dt);
      best = std::min(best, processor() - t);
      if (report.status != contact::StepStatus::ok) throw std::runtime_error("the step failed");
    }
    char note[120];
    std::snprintf(note, sizeof note, "%zu DOFs, %d contacts, loop gap %.1e", world.nv(), report.contacts, report.loop_gap);
    table.add({.row = name, .ours_ns = 1e9 * best, .peer = {}, .per = static_cast<double>(n), .note = note});
  }
}

const RowRegistration saved(500, save_and_restore), rolled(510, roll_out), tracked(520, tracked_characters), linked(530, standing_linkages);

}  // namespace
}  // namespace ugoki::benchmarks
