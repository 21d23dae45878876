// Execution of ticks. This code runs for every LSI in every tick, so it is optimised.

#include <algorithm>
#include <cstring>
#include <iterator>

#include "ugoki/base/floating_point_mode.h"
#include "ugoki/circuit/executor.h"
#include "ugoki/circuit/machine.h"

namespace ugoki::circuit {
namespace {

inline bool is_due(const Job& job, std::uint64_t index) { return job.every <= 1 || index % job.every == 0; }

/// Runs the jobs in order, and calls `after(job)` after each successful one.
/// @param not_finite [out]  true: the job failed because it wrote a number that is not finite; false: it returned an error
/// @return the job that failed, or null
template <class AfterJob>
inline const Job* run_jobs(std::span<const Job> jobs, std::uint64_t index, Activity& activity, bool& not_finite, AfterJob after) {
  for (const Job& job : jobs) {
    if (!is_due(job, index)) [[unlikely]]
      continue;
    set_running(activity, job.who);
    if (job.run(job.call) != 0) [[unlikely]]
      return &job;
    if (!all_finite(job.check, job.check_count)) [[unlikely]] {
      not_finite = true;
      return &job;
    }
    after(job);
  }
  return nullptr;
}

inline const Job* run_plainly(std::span<const Job> jobs, std::uint64_t index, Activity& activity, bool& not_finite) {
  return run_jobs(jobs, index, activity, not_finite, [](const Job&) {});
}

/// Runs the jobs and adds their times. The clock is read once per LSI: the end of one LSI is the start of the next.
/// @param before  time at which the first job starts
const Job* run_timed(std::span<const Job> jobs, std::uint64_t index, Activity& activity, bool& not_finite, Interpreter::Clock clock,
                     std::vector<Timing>& timings, std::uint64_t before) {
  const auto timed = [&](auto now) {
    return run_jobs(jobs, index, activity, not_finite, [&](const Job& job) {
      const std::uint64_t after = now();
      Timing& t = timings[job.lsi];
      t.total += after - before;
      ++t.runs;
      before = after;
    });
  };
#if defined(__x86_64__)
  if (clock == &Interpreter::processor_clock) return timed([] { return __builtin_ia32_rdtsc(); });
#endif
  return timed(clock);
}

/// Whether tick `index` is timed: one tick in `one_in`, spread so that LSIs that run at every n-th tick are timed as often as others.
/// The index is multiplied by an odd constant near 2^64 / golden ratio: Knuth, The Art of Computer Programming, vol. 3, 6.4.
inline bool is_timed(std::uint64_t index, std::uint32_t one_in) {
  return one_in <= 1 || ((index * 0x9E3779B97F4A7C15u) >> 32) * one_in >> 32 == 0;
}

/// The jobs of a wave (a group of independent jobs), divided among workers, and for each worker the job that failed.
struct WaveWork {
  static constexpr int max_workers = 64;
  std::span<const Job> jobs;
  std::uint64_t index = 0;
  int workers = 1;
  const Job* failed[max_workers] = {};
  bool not_finite[max_workers] = {};

  [[nodiscard]] std::span<const Job> share(int worker) const {
    const std::size_t begin = jobs.size() * static_cast<std::size_t>(worker) / static_cast<std::size_t>(workers);
    const std::size_t end = jobs.size() * static_cast<std::size_t>(worker + 1) / static_cast<std::size_t>(workers);
    return jobs.subspan(begin, end - begin);
  }
  void run(int worker) {
    Activity unused;  // the shared Activity has one entry and belongs to the main thread
    failed[worker] = run_plainly(share(worker), index, unused, not_finite[worker]);
  }
};

}  // namespace

std::uint64_t Interpreter::processor_clock() {
#if defined(__x86_64__)
  return __builtin_ia32_rdtsc();
#elif defined(__aarch64__)
  std::uint64_t ticks;
  __asm__ volatile("mrs %0, cntvct_el0" : "=r"(ticks));
  return ticks;
#else
  return 0;
#endif
}

inline void Interpreter::Machine::end_tick() {
  if (front.size()) std::memcpy(bytes() + front.begin, bytes() + back.begin, front.size());
  set_tick(tick.index + 1);
}

/// Computes ticks while only timing and probes may be on (the usual case). Members are copied to locals: the compiler must assume that
/// a call of an LSI changes members: with locals, a tick of a single LSI costs little more than the LSI itself.
template <bool timed, bool probed>
std::uint64_t Interpreter::Machine::run_fast(std::uint64_t count) {
  const std::span<const Job> all(jobs);
  std::byte *const seen = bytes() + front.begin, *const written = bytes() + back.begin;
  const std::size_t delayed_bytes = front.size();
  const double dt = tick.dt;
  const std::span<Tick> slow(slow_ticks);
  Activity& noted = *activity;
  const std::uint64_t first = tick.index, end = first + count, passes_before = noted.passes + 1 - first;
  const std::span<const double* const> sources(probes.sources);
  double* to = probed ? probes.rows.data() + probes.next * sources.size() : nullptr;
  std::uint64_t* row_tick = probed ? probes.ticks.data() + probes.next : nullptr;
  std::uint64_t* const last_row = probes.ticks.data() + probes.ticks.size();
  bool not_finite = false;
  const Job* failed = nullptr;
  std::uint64_t index = first;
  while (index != end) {
    __atomic_store_n(&noted.passes, passes_before + index, __ATOMIC_RELAXED);
    if (timed && is_timed(index, timed_one_in)) {
      ++timed_ticks;
      failed = run_timed(all, index, noted, not_finite, clock, timings, clock());
    } else {
      failed = run_plainly(all, index, noted, not_finite);
    }
    if (failed) [[unlikely]]
      break;
    if constexpr (probed) {
      for (const double* from : sources) *to++ = *from;
      *row_tick = index;
      if (++row_tick == last_row) {
        row_tick = probes.ticks.data();
        to = probes.rows.data();
      }
    }
    if (delayed_bytes) std::memcpy(seen, written, delayed_bytes);
    tick.index = ++index;
    tick.time = static_cast<double>(static_cast<std::int64_t>(index)) * dt;
    for (Tick& t : slow) {
      t.index = index;
      t.time = tick.time;
    }
  }
  set_running(noted, nullptr);
  const std::uint64_t done = index - first;
  if constexpr (probed) {
    probes.next = static_cast<std::size_t>(row_tick - probes.ticks.data());
    probes.written += done;
  }
  if (failed) fail(*failed, not_finite);
  return done;
}

bool Interpreter::Machine::run_one_by_one(std::span<const Job> some) {
  bool not_finite = false;
  const Job* failed = nullptr;
  if (clock && is_timed(tick.index, timed_one_in)) {
    if (!some.empty() && &some.front() == jobs.data()) ++timed_ticks;
    failed = run_timed(some, tick.index, *activity, not_finite, clock, timings, clock());
  } else {
    failed = run_plainly(some, tick.index, *activity, not_finite);
  }
  if (failed) fail(*failed, not_finite);
  return !failed;
}

/// Runs a wave: built-in LSIs on all threads, then those of plug-ins on this thread, because plug-ins may share data among their LSIs.
/// If several LSIs fail, the one with the smallest index is reported.
bool Interpreter::Machine::run_wave(const Wave& wave) {
  const std::span<const Job> all(wave_jobs);
  const Job* failed = nullptr;
  bool not_finite = false;
  const auto note = [&](const Job* job, bool was_not_finite) {
    if (!job || (failed && failed->lsi < job->lsi)) return;
    failed = job;
    not_finite = was_not_finite;
  };
  WaveWork work;
  work.jobs = all.subspan(wave.begin, wave.own_end - wave.begin);
  work.index = tick.index;
  if (work.jobs.size() > 1) {
    work.workers = std::min(executor->workers(), WaveWork::max_workers);
    for (int w = 0; w < work.workers; ++w)
      for (const Job& job : work.share(w)) job.call->reason = reasons[static_cast<std::size_t>(w)].data();
    executor->run([](void* context, int worker) { static_cast<WaveWork*>(context)->run(worker); }, &work);
    for (int w = 0; w < work.workers; ++w) note(work.failed[w], work.not_finite[w]);
  }
  const std::size_t alone = work.jobs.size() > 1 ? wave.own_end : wave.begin;
  bool not_finite_alone = false;
  const Job* failed_alone = run_plainly(all.subspan(alone, wave.end - alone), tick.index, *activity, not_finite_alone);
  note(failed_alone, not_finite_alone);
  if (failed) fail(*failed, not_finite);
  return !failed;
}

bool Interpreter::Machine::run_waves() {
  for (std::vector<char>& r : reasons) r[0] = '\0';
  return std::all_of(waves.begin(), waves.end(), [this](const Wave& w) { return run_wave(w); });
}

/// Computes one tick with any combination of probes, breakpoints, recording, timing and threads; also completes a tick begun by step_lsi.
bool Interpreter::Machine::tick_with_extras() {
  __atomic_store_n(&activity->passes, activity->passes + 1, __ATOMIC_RELAXED);
  breakpoint_hit = -1;
  bool good = true;
  if (cursor == 0) {
    if (!log.replay.empty()) replay_inputs();
    if (log.recording) record_inputs();
    good = executor && !clock ? run_waves() : run_one_by_one(jobs);
  } else {
    good = run_one_by_one(std::span<const Job>(jobs).subspan(cursor));
    cursor = 0;
    update_plain();
  }
  if (!good) return false;
  if (probes.width() && (probes.every == 1 || tick.index % probes.every == 0)) sample_probes();
  if (!breakpoints.empty()) test_breakpoints();
  end_tick();
  return true;
}

void Interpreter::Machine::update_plain() {
  fast = !executor && breakpoints.empty() && !log.recording && log.replay.empty() && cursor == 0 && probes.every == 1;
  plain = fast && !clock && probes.width() == 0;
}

std::uint64_t Interpreter::Machine::run(std::uint64_t count) {
  reason[0] = '\0';
  if (plain) return run_fast<false, false>(count);
  breakpoint_hit = -1;
  if (fast && probes.width()) return clock ? run_fast<true, true>(count) : run_fast<false, true>(count);
  if (fast) return run_fast<true, false>(count);
  std::uint64_t done = 0;
  while (done < count) {
    if (!tick_with_extras()) break;
    ++done;
    if (breakpoint_hit >= 0) break;
  }
  set_running(*activity, nullptr);
  return done;
}

std::uint64_t Interpreter::run(std::uint64_t count) {
  Machine& m = *machine_;
  if (m.is_stopped) [[unlikely]]
    return 0;
  const std::uint64_t mode = m.foreign.empty() ? 0 : floating_point_mode();
  const std::uint64_t done = m.run(count);
  if (!m.foreign.empty() && !m.are_libraries_sound(mode)) [[unlikely]]
    return done > 0 ? done - 1 : 0;
  return done;
}

bool Interpreter::tick() { return run(1) == 1; }

bool Interpreter::step_lsi() {
  Machine& m = *machine_;
  if (m.is_stopped) return false;
  const std::span<const Job> jobs(m.jobs);
  const auto skip_those_not_due = [&] {
    while (m.cursor < jobs.size() && !is_due(jobs[m.cursor], m.tick.index)) ++m.cursor;
  };
  if (m.cursor == 0) {
    m.replay_inputs();
    m.record_inputs();
  }
  skip_those_not_due();
  const std::uint64_t mode = floating_point_mode();
  m.plain = m.fast = false;
  m.reason[0] = '\0';
  if (m.cursor < jobs.size() && !m.run_one_by_one(jobs.subspan(m.cursor, 1))) return false;
  set_running(*m.activity, nullptr);
  if (!m.are_libraries_sound(mode)) return false;
  ++m.cursor;
  skip_those_not_due();
  return m.cursor < jobs.size() || m.tick_with_extras();
}

std::string Interpreter::next_lsi() const {
  const Machine& m = *machine_;
  for (std::size_t i = m.cursor; i < m.jobs.size(); ++i)
    if (is_due(m.jobs[i], m.tick.index)) return m.units[m.jobs[i].lsi].id;
  return {};
}

bool Interpreter::refresh() {
  Machine& m = *machine_;
  __atomic_store_n(&m.activity->passes, m.activity->passes + 1, __ATOMIC_RELAXED);
  const std::uint64_t mode = floating_point_mode();
  m.reason[0] = '\0';
  bool good = true;
  for (const Job& job : m.on_demand) {
    Job due = job;
    due.every = 1;  // jobs of LSIs that run on demand have `every` 0, but are due now
    good = good && m.run_one_by_one({&due, 1});
  }
  set_running(*m.activity, nullptr);
  return good && m.are_libraries_sound(mode);
}

void Interpreter::set_timing(Clock clock, std::uint32_t one_in) {
  Machine& m = *machine_;
  m.clock = clock;
  m.timed_one_in = one_in;
  m.timed_ticks = 0;
  m.timings.assign(clock ? m.units.size() : 0, Timing{});
  m.update_plain();
}

std::vector<Timing> Interpreter::timings() const {
  std::vector<Timing> out;
  for (std::size_t i = 0; i < machine_->timings.size(); ++i) {
    const Timing& t = machine_->timings[i];
    if (t.runs) out.push_back({machine_->units[i].id, t.runs, t.total});
  }
  return out;
}

std::uint64_t Interpreter::timed_ticks() const { return machine_->timed_ticks; }

void Interpreter::set_executor(Executor* executor) {
  Machine& m = *machine_;
  m.executor = executor && executor->workers() > 1 ? executor : nullptr;
  m.reasons.assign(m.executor ? static_cast<std::size_t>(m.executor->workers()) : 0, std::vector<char>(sizeof m.reason));
  for (Call& c : m.calls) c.reason = m.reason;
  m.waves.clear();
  m.wave_jobs.clear();
  if (m.executor) {
    const auto add = [&m](auto begin, auto end) {
      if (begin == end) return;
      Wave wave;
      wave.begin = static_cast<std::uint32_t>(m.wave_jobs.size());
      const auto own = [&m](const Job& job) { return m.units[job.lsi].lsi_class->from.empty(); };
      std::copy_if(begin, end, std::back_inserter(m.wave_jobs), own);
      wave.own_end = static_cast<std::uint32_t>(m.wave_jobs.size());
      std::copy_if(begin, end, std::back_inserter(m.wave_jobs), [&own](const Job& job) { return !own(job); });
      wave.end = static_cast<std::uint32_t>(m.wave_jobs.size());
      m.waves.push_back(wave);
    };
    std::uint32_t begin = 0;
    for (const std::uint32_t end : m.wave_ends) {
      add(m.jobs.data() + begin, m.jobs.data() + end);
      begin = end;
    }
    add(m.jobs.data() + m.step_count, m.jobs.data() + m.jobs.size());
  }
  m.update_plain();
}

}  // namespace ugoki::circuit
