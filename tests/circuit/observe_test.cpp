// Probes, breakpoints, single steps, recording and replay of inputs, threads. None of them may change a bit of the results.

#include <condition_variable>
#include <cstring>
#include <mutex>
#include <thread>

#include "allocation_count.h"
#include "circuit_test.h"
#include "ugoki/circuit/activity.h"
#include "ugoki/circuit/breakpoint.h"
#include "ugoki/circuit/executor.h"

namespace ugoki::circuit {
namespace {

const char* const oscillator = R"({"version": 2, "name": "oscillator", "inputs": [{"name": "push", "type": "scalar", "to": "sum.b"}],
  "lsis": [{"id": "x", "type": "integrator", "parameters": {"initial": 1}}, {"id": "v", "type": "integrator"}, {"id": "k", "type": "gain", "parameters": {"gain": -40}},
           {"id": "sum", "type": "add"}, {"id": "place", "type": "make vector", "values": {"y": 0, "z": 0}}],
  "wires": [{"from": "v.out", "to": "x.in"}, {"from": "k.out", "to": "sum.a"}, {"from": "sum.out", "to": "v.in"}, {"from": "x.out", "to": "k.in"},
            {"from": "x.out", "to": "place.x"}]})";

std::vector<std::byte> state_of(Interpreter& i) {
  std::vector<std::byte> out;
  i.save(out);
  return out;
}
void give(Interpreter& i, double x) { std::memcpy(i.find_circuit_input("push").data(), &x, sizeof x); }

TEST(Observe, ProbesKeepTheNewestRows) {
  auto i = build(oscillator);
  ASSERT_TRUE(i);
  const std::vector<std::string> pins = {"k.out", "place.out", "x.out"};
  ASSERT_TRUE(i->set_probes(pins, 8, 2));
  std::vector<double> k, x;
  for (int n = 0; n < 50; ++n) {
    x.push_back(value(*i, "x.out"));
    ASSERT_TRUE(i->tick());
    k.push_back(value(*i, "k.out"));
  }
  const ProbeRows rows = i->probes();
  ASSERT_EQ(rows.size(), 8u);
  EXPECT_EQ(rows.first(), 17u);  // 25 rows were sampled in total
  for (std::size_t r = 0; r < rows.size(); ++r) {
    const std::size_t tick = 34 + 2 * r;
    EXPECT_EQ(rows.tick(r), tick);
    ASSERT_EQ(rows.numbers(r).size(), 5u);
    EXPECT_EQ(rows.numbers(r)[0], k[tick]);
    EXPECT_EQ(rows.numbers(r)[1], x[tick]);  // the value that consumers read in that tick
    EXPECT_EQ(rows.numbers(r)[4], x[tick]);
  }
  const long before = allocations_so_far();
  for (int n = 0; n < 100; ++n) i->tick();
  EXPECT_EQ(allocations_so_far(), before);
  const std::vector<std::string> wrong = {"k.no", "nobody.out"};
  const auto refused = i->set_probes(wrong, 8);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().problems.size(), 2u);
  EXPECT_FALSE(i->set_probes(pins, 0));
  EXPECT_EQ(i->probes().size(), 8u);
  ASSERT_TRUE(i->set_probes({}, 8));
  EXPECT_EQ(i->probes().numbers(0).size(), 0u);
}

TEST(Observe, BreakpointIsHitWhenConditionBecomesTrue) {
  auto i = build(oscillator);
  ASSERT_TRUE(i);
  const std::vector<Breakpoint> breaks = {
      {"x.out", 0, Comparison::below, 0.5}, {"place.out", 1, Comparison::changed, 0}, {"v.out", 0, Comparison::above, 1e9}};
  ASSERT_TRUE(i->set_breakpoints(breaks));
  int hits = 0;
  for (int n = 0; n < 300; ++n) {
    const double before = value(*i, "x.out");
    ASSERT_TRUE(i->tick());
    if (i->breakpoint_hit() < 0) continue;
    ++hits;
    EXPECT_EQ(i->breakpoint_hit(), 0);
    EXPECT_LT(before, 0.5);
  }
  EXPECT_GE(hits, 2);
  EXPECT_LE(hits, 4);
  const std::vector<Breakpoint> wrong = {{"x.out", 1, Comparison::above, 0}};
  EXPECT_FALSE(i->set_breakpoints(wrong));
}

TEST(Observe, BreakpointConditionsAreParsed) {
  struct Case {
    const char* text;
    Breakpoint expected;
  };
  const Case good[] = {{"x.out > 3", {"x.out", 0, Comparison::above, 3}},
                       {" arm/elbow.out[2]<-1e-3 ", {"arm/elbow.out", 2, Comparison::below, -1e-3}},
                       {"x.out == 0", {"x.out", 0, Comparison::equal, 0}},
                       {"x.out = 0", {"x.out", 0, Comparison::equal, 0}},
                       {"x.out != 2", {"x.out", 0, Comparison::not_equal, 2}},
                       {"x.out[1] changes", {"x.out", 1, Comparison::changed, 0}},
                       {"x.pressed becomes true", {"x.pressed", 0, Comparison::above, 0}},
                       {"input:live.value > 1", {"input:live.value", 0, Comparison::above, 1}}};
  for (const Case& c : good) {
    const Result<Breakpoint> b = read_breakpoint(c.text);
    ASSERT_TRUE(b) << c.text << b.error().text();
    EXPECT_EQ(b->pin, c.expected.pin) << c.text;
    EXPECT_EQ(b->component, c.expected.component) << c.text;
    EXPECT_EQ(b->comparison, c.expected.comparison) << c.text;
    EXPECT_EQ(b->value, c.expected.value) << c.text;
  }
  for (const char* bad : {"", "x.out", "x.out >", "x.out > nan", "x.out > 1 2", "> 3", "x > 3", "x. > 3", ".out > 3", "x.out[] > 3",
                          "x.out[-1] > 3", "x.out[1e9] > 3", "x.out[99999999999999999999] > 3", " changes", "x.out >= 3"}) {
    const Result<Breakpoint> b = read_breakpoint(bad);
    ASSERT_FALSE(b) << bad;
    EXPECT_FALSE(b.error().problems[0].remedy.empty());
  }
}

TEST(Observe, SteppingLsisGivesTheSameBitsAsTicks) {
  auto a = build(oscillator), b = build(oscillator);
  ASSERT_TRUE(a && b);
  EXPECT_EQ(a->next_lsi(), "k");
  ASSERT_TRUE(a->step_lsi());
  EXPECT_EQ(value(*a, "k.out"), -40);
  EXPECT_EQ(a->ticks(), 0u);
  const std::vector<std::byte> middle = state_of(*a);
  for (int n = 0; n < 4; ++n) ASSERT_TRUE(a->step_lsi());  // after the LSIs place, sum, v and x the tick is complete
  EXPECT_EQ(a->ticks(), 1u);
  ASSERT_TRUE(b->tick());
  EXPECT_EQ(state_of(*a), state_of(*b));
  // A state saved in the middle of a tick is restored, and tick() completes the tick.
  auto c = build(oscillator);
  ASSERT_TRUE(c->restore(middle));
  EXPECT_EQ(c->next_lsi(), "place");
  ASSERT_TRUE(c->tick());
  EXPECT_EQ(state_of(*c), state_of(*b));
}

TEST(Observe, ReplayGivesTheSameBits) {
  auto a = build(oscillator), b = build(oscillator);
  ASSERT_TRUE(a && b);
  a->start_recording();
  for (int n = 0; n < 200; ++n) {
    if (n % 37 == 5) give(*a, 0.1 * n);
    if (n == 100) ASSERT_TRUE(a->set_parameter("k.gain", -20));
    ASSERT_TRUE(a->tick());
  }
  const std::string text = write_input_record(a->recording());
  const auto record = read_input_record(text);
  ASSERT_TRUE(record) << record.error().text();
  EXPECT_EQ(*record, a->recording());
  ASSERT_TRUE(b->replay(*record));
  for (int n = 0; n < 200; ++n) ASSERT_TRUE(b->tick());
  EXPECT_EQ(state_of(*a), state_of(*b));
  auto other = build(R"({"version": 2, "name": "o", "lsis": [{"id": "c", "type": "clock"}]})");
  EXPECT_FALSE(other->replay(*record));
  InputRecord wrong = *record;
  wrong.changes[0].name = "nobody";
  EXPECT_FALSE(b->replay(wrong));
  for (std::size_t n = 0; n < text.size(); n += 7) EXPECT_FALSE(read_input_record(text.substr(0, n)));
}

TEST(Observe, ActivityNamesTheLsiThatRuns) {
  static Activity activity;
  static std::string reported;
  Library library;
  LsiClass c;
  c.name = "looks";
  c.inputs.resize(1);
  c.inputs[0].name = "a";
  c.outputs.resize(1);
  c.outputs[0].name = "out";
  c.step = [](const Call*) -> std::int32_t {
    char buffer[200];
    const RunningLsi& r = *running_of(activity);
    reported = std::string(buffer, describe_lsi(r, buffer));
    reported += std::string(buffer, describe_time(r, buffer));
    reported += "." + std::string(buffer, describe_inputs(r, buffer));
    char little[8];
    EXPECT_EQ(describe_lsi(r, little), 7u);
    return 0;
  };
  library.add(c);
  auto i = Interpreter::build(parse(R"({"version": 2, "name": "o", "lsis": [{"id": "b", "type": "looks", "values": {"a": 2.5}}]})"),
                              library, nullptr, {.dt = 0.25, .check_finite = true, .activity = &activity});
  ASSERT_TRUE(i);
  for (int k = 0; k < 3; ++k) ASSERT_TRUE(i->tick());
  EXPECT_EQ(reported, "'b' (LSI 'looks') at 0.500 s (tick 2). Its inputs were 'a' = 2.5.");
  EXPECT_EQ(running_of(activity), nullptr);
  EXPECT_EQ(passes_of(activity), 3u);
}

/// A thread pool.
class Threads final : public Executor {
 public:
  explicit Threads(int n) {
    for (int w = 1; w < n; ++w) threads_.emplace_back([this, w] { serve(w); });
  }
  ~Threads() override {
    {
      const std::scoped_lock lock(mutex_);
      end_ = true;
    }
    begin_.notify_all();
    for (std::thread& t : threads_) t.join();
  }
  [[nodiscard]] int workers() const override { return static_cast<int>(threads_.size()) + 1; }
  void run(void (*work)(void*, int), void* context) override {
    {
      const std::scoped_lock lock(mutex_);
      work_ = work;
      context_ = context;
      left_ = static_cast<int>(threads_.size());
      ++round_;
    }
    begin_.notify_all();
    work(context, 0);
    std::unique_lock lock(mutex_);
    done_.wait(lock, [this] { return left_ == 0; });
  }

 private:
  void serve(int worker) {
    long seen = 0;
    while (true) {
      std::unique_lock lock(mutex_);
      begin_.wait(lock, [&] { return end_ || round_ != seen; });
      if (end_) return;
      seen = round_;
      lock.unlock();
      work_(context_, worker);
      lock.lock();
      if (--left_ == 0) done_.notify_one();
    }
  }
  std::mutex mutex_;
  std::condition_variable begin_, done_;
  void (*work_)(void*, int) = nullptr;
  void* context_ = nullptr;
  int left_ = 0;
  long round_ = 0;
  bool end_ = false;
  std::vector<std::thread> threads_;
};

/// A circuit of 12 independent chains whose results are added. @param fails  chains 3 and 8 divide by zero
std::string wide(bool fails) {
  std::string lsis = R"({"id": "c", "type": "clock"}, {"id": "end", "type": "sum"})", wires;
  for (int k = 0; k < 12; ++k) {
    const std::string n = std::to_string(k);
    lsis += R"(, {"id": "g)" + n + R"(", "type": "gain", "parameters": {"gain": 0.)" + n + R"(}}, {"id": "i)" + n +
            R"(", "type": "integrator", "every": )" + std::to_string(1 + k % 3) + R"(}, {"id": "f)" + n +
            R"(", "type": "low-pass"}, {"id": "q)" + n + R"(", "type": "divide", "values": {"b": )" + (fails && k % 5 == 3 ? "0" : "3") +
            "}}";
    wires += R"({"from": "c.time", "to": "g)" + n + R"(.in"}, {"from": "g)" + n + R"(.out", "to": "i)" + n + R"(.in"}, {"from": "i)" + n +
             R"(.out", "to": "f)" + n + R"(.in"}, {"from": "f)" + n + R"(.out", "to": "q)" + n + R"(.a"}, {"from": "q)" + n +
             R"(.out", "to": "end.in"},)";
  }
  wires.pop_back();
  return R"({"version": 2, "name": "wide", "lsis": [)" + lsis + "], \"wires\": [" + wires + "]}";
}

TEST(Observe, ThreadsGiveSameBitsAndSameFailure) {
  for (const int n : {2, 3, 8}) {
    Threads threads(n);
    auto one = build(wide(false)), many = build(wide(false));
    ASSERT_TRUE(one && many) << one.error().text();
    many->set_executor(&threads);
    for (int k = 0; k < 200; ++k) {
      ASSERT_TRUE(one->tick());
      ASSERT_TRUE(many->tick());
    }
    EXPECT_EQ(state_of(*one), state_of(*many)) << n;
    const long before = allocations_so_far();
    for (int k = 0; k < 50; ++k) many->tick();
    EXPECT_EQ(allocations_so_far(), before);
    auto bad = build(wide(true)), bad_too = build(wide(true));
    bad->set_executor(&threads);
    EXPECT_FALSE(bad->tick());
    EXPECT_FALSE(bad_too->tick());
    EXPECT_EQ(bad->stopped()->text(), bad_too->stopped()->text());
    EXPECT_EQ(bad->stopped()->lsi, "q3");
  }
}

}  // namespace
}  // namespace ugoki::circuit
