#pragma once
/* Model with events of every kind, for importers that use event mode. `x` moves between -1 and 1 and turns at each end (state events).
 * `held` is the time of the last time event, one every 0.25 s. The discrete input `gear` and the tunable parameter `rate` take effect at
 * the event at which they are set. `events` counts the events. `deed` requests a failure: 1 events that never end; 2 an event that ends the
 * simulation; 3 an event that returns an error. */
#define TOKEN "events"
#define EVENT_MODE true
struct Model {
  double time, x, rate, held, next, offset, deed;
  double in_use; /* rate * gear, as of the last event */
  int32_t gear, direction, events, turn;
};
#define AT(field) offsetof(struct Model, field), 1
static const Var variables[] = {{0, F64, LOCAL, AT(time)},   {1, F64, OUTPUT, AT(x)},      {2, F64, TUNABLE, AT(rate)},
                                {3, F64, OUTPUT, AT(held)},  {4, I32, DISCRETE, AT(gear)}, {5, I32, OUTPUT, AT(events)},
                                {6, F64, INPUT, AT(offset)}, {7, F64, OUTPUT, AT(in_use)}, {8, F64, INPUT, AT(deed)}};
static void model_start(struct Model* m) {
  memset(m, 0, sizeof *m);
  m->rate = 1;
  m->gear = m->direction = 1;
}
static void model_outputs(struct Model* m, double now) { m->time = now; }
static int model_step(struct Instance* self, struct Model* m, double now, double size, bool* terminate, double* reached) {
  (void)self, (void)terminate;
  double end = now + size;
  const double speed = m->in_use * m->direction, turn = speed == 0 ? INFINITY : now + (copysign(1, speed) - m->x) / speed;
  if (turn <= end) {
    end = turn;
    m->turn = true;
  }
  if (m->next < end - 1e-12) {
    end = m->next;
    m->turn = false;
  }
  m->x = m->turn ? copysign(1, speed) : m->x + speed * (end - now);
  *reached = end;
  return OK;
}
static bool model_event(const struct Model* m, double now) { return m->turn || now >= m->next - 1e-12; }
/* One call of UpdateDiscreteStates. Returns a status. */
static int model_update(struct Instance* self, struct Model* m, double now, bool* again, bool* terminate, double* next) {
  if (m->deed == 3) {
    send_log(self, ERROR_, "The event is too hard.");
    return ERROR_;
  }
  *terminate = m->deed == 2;
  *again = m->deed == 1;
  if (m->turn) {
    m->direction = -m->direction;
    m->turn = false;
    *again = true; /* requests a second call, which counts the event */
    *next = m->next;
    return OK;
  }
  if (now >= m->next - 1e-12) {
    m->held = m->next;
    m->next += 0.25;
  }
  m->in_use = m->rate * m->gear;
  ++m->events;
  *next = m->next;
  return OK;
}
