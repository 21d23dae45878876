#pragma once
/* Model with the interface of the Reference-FMU Stair: a counter starts at 1 and counts seconds; at 10 the simulation ends. */
#define TOKEN "{8c4e810f-3df3-4a00-8276-176fa3c9f008}"
struct Model {
  int32_t counter;
  double time;
};
#define AT(field) offsetof(struct Model, field), 1
static const Var variables[] = {{0, F64, LOCAL, AT(time)}, {1, I32, OUTPUT, AT(counter)}};
static void model_start(struct Model* m) {
  memset(m, 0, sizeof *m);
  m->counter = 1;
}
static void model_outputs(struct Model* m, double now) { m->time = now; }
static int model_step(struct Instance* self, struct Model* m, double now, double size, bool* terminate, double* reached) {
  while (m->counter < 10 && now + size >= m->counter - 1e-9) {
    ++m->counter;
    if (m->counter == 10) send_log(self, OK, "The last step of the stair.");
  }
  *reached = now + size;
  if (m->counter >= 10) *terminate = true;
  return OK;
}
