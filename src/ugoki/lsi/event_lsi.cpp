// Event: the events of the scenario and of the user that have an effect at this tick.

#include <algorithm>
#include <cmath>

#include "ugoki/lsi/declare.h"

namespace ugoki::lsi {
namespace {

constexpr std::size_t max_pushes = 16;  // maximum number of simultaneous pushes of the user; a further push ends the oldest one

/// Events of the user that last for several ticks: pushes, and the grab of a link. Plain data.
struct Lasting {
  std::uint64_t pushes = 0;
  EventRecord push[max_pushes];
  double ticks_left[max_pushes] = {};
  std::uint64_t grabbed = 0;
  EventRecord grab;
};
struct EventState {
  Lasting now, next;  ///< `step` computes `next` from `now`; `advance` copies it to `now`
};

/// A push acts for a whole number of ticks: its duration rounded to ticks (at least 1), from the first tick at or after its time. The term
/// of 1e-6 ticks absorbs the rounding error of time / dt; the bounds keep the conversion to an integer defined.
std::uint64_t first_tick(double time, double dt) { return static_cast<std::uint64_t>(std::clamp(std::ceil(time / dt - 1e-6), 0.0, 1e15)); }
std::uint64_t tick_count(double duration, double dt) {
  return static_cast<std::uint64_t>(std::clamp(std::floor(duration / dt + 0.5), 1.0, 1e15));
}

/// The events of the scenario, each with the ticks [first, end) at which it has an effect.
struct Schedule {
  struct Entry {
    std::uint64_t first, end;
    EventRecord record;
    std::vector<std::pair<std::uint64_t, Vec3>> targets;  ///< ticks from which the targets of a pull have an effect
  };
  std::vector<Entry> entries;
};

void* make(Setup& s) {
  auto* schedule = new Schedule;
  for (const ScheduledEvent& e : world_of(s)->events()) {
    std::uint64_t first = first_tick(e.time, s.dt());
    std::uint64_t count = tick_count(e.duration, s.dt());
    if (e.record.kind == EventKind::gripping || e.record.kind == EventKind::opening) count = 1;
    if (e.record.kind == EventKind::throwing) {  // emitted one tick earlier: the status LSI applies it at the end of the tick
      first = std::max<std::uint64_t>(first, 1) - 1;
      count = 1;
    }
    Schedule::Entry entry{first, first + count, e.record, {}};
    for (const auto& [time, target] : e.path) entry.targets.emplace_back(first + first_tick(time, s.dt()), target);
    schedule->entries.push_back(std::move(entry));
  }
  return schedule;
}

/// Writes records to the output. add() returns false if the output is full.
class Output {
 public:
  explicit Output(const Call* call) : call_(call) {}
  bool add(const EventRecord& record) {
    if (count_ == call_->out_count[0]) return false;
    record_room<EventRecord>(call_->out[0])[count_++] = record;
    return true;
  }
  void finish() { set_count(call_->out[0], count_); }

 private:
  const Call* call_;
  std::uint64_t count_ = 0;
};

/// Applies the user's events that arrived before this tick.
void add_live_events(const Call* call, Lasting& next) {
  for (const EventRecord& e : records<EventRecord>(call->in[0])) {
    switch (e.kind) {
      case EventKind::push:
        if (next.pushes == max_pushes) {  // end the oldest push early
          std::move(next.push + 1, next.push + max_pushes, next.push);
          std::move(next.ticks_left + 1, next.ticks_left + max_pushes, next.ticks_left);
          --next.pushes;
        }
        next.push[next.pushes] = e;
        next.ticks_left[next.pushes++] = static_cast<double>(tick_count(e.duration, call->tick->dt));
        break;
      case EventKind::grab:
        next.grab = e;
        next.grabbed = 1;
        break;
      case EventKind::drag: next.grab.b = e.b; break;
      case EventKind::release: next.grabbed = 0; break;
      case EventKind::throwing:
      case EventKind::touch:
      case EventKind::parting:
      case EventKind::omitted:
      case EventKind::gripping:
      case EventKind::opening:
      case EventKind::none: break;
    }
  }
}

/// The record of an event at a tick: a pull gets the target of this tick.
EventRecord record_at(const Schedule::Entry& e, std::uint64_t tick) {
  EventRecord record = e.record;
  const auto next =
      std::upper_bound(e.targets.begin(), e.targets.end(), tick, [](std::uint64_t t, const auto& target) { return t < target.first; });
  if (next != e.targets.begin()) record.b = std::prev(next)->second;
  return record;
}

std::int32_t step(const Call* call) {
  auto& state = *static_cast<EventState*>(call->state);
  const std::uint64_t index = call->tick->index;
  Output out(call);
  bool fits = true;
  for (const Schedule::Entry& e : object_of<Schedule>(call).entries)
    if (index >= e.first && index < e.end) fits &= out.add(record_at(e, index));
  Lasting& next = state.next = state.now;
  add_live_events(call, next);
  for (const EventRecord& e : records<EventRecord>(call->in[0]))
    if (e.kind == EventKind::throwing) fits &= out.add(e);
  std::size_t kept = 0;
  for (std::size_t i = 0; i < next.pushes; ++i) {
    fits &= out.add(next.push[i]);
    if (next.ticks_left[i] <= 1) continue;
    next.push[kept] = next.push[i];
    next.ticks_left[kept++] = next.ticks_left[i] - 1;
  }
  next.pushes = kept;
  if (next.grabbed) fits &= out.add(next.grab);
  out.finish();
  return fits ? 0 : circuit::stop(call, "More than " + std::to_string(call->out_count[0]) + " events act at the same tick.");
}

}  // namespace

void add_event(circuit::Library& library) {
  circuit::LsiClass c;
  c.name = "event";
  c.doc = "The events of this tick: pushes, pulls and throws of the scenario, and the user's pushes, pulls and throws.";
  c.inputs = {input_pin("live", PinTypeId::event, "", "Events of the user that arrived before this tick.")};
  c.inputs[0].required = false;
  c.outputs = {output_pin("events", PinTypeId::event, "", "All events that act during this tick.")};
  c.configure = [](Setup& s) {
    if (world_of(s)) s.set_state(sizeof(EventState));
  };
  c.make = make;
  c.destroy = destroy<Schedule>;
  c.step = step;
  c.advance = [](const Call* call) -> std::int32_t {
    auto& state = *static_cast<EventState*>(call->state);
    state.now = state.next;
    return 0;
  };
  library.add(std::move(c));
}

}  // namespace ugoki::lsi
