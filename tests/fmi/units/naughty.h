#pragma once
/* Model that fails as the input `deed` requests: 1 null pointer, 2 infinite loop, 3 output that is not a number, 4 error, 5 fatal error, 6
 * discarded step, 7 integer division by zero, 8 early return at half of each step. `sum` is the sum of `deed` over all steps. */
#define TOKEN "naughty"
struct Model {
  double time, deed, out, sum, matrix[6], place[3], weights[2];
};
#define AT(field) offsetof(struct Model, field), 1
static const Var variables[] = {
    {0, F64, LOCAL, AT(time)},
    {1, F64, INPUT, AT(deed)},
    {2, F64, OUTPUT, AT(out)},
    {3, F64, OUTPUT, AT(sum)},
#if FMI_VERSION == 3
    {4, F64, OUTPUT, offsetof(struct Model, matrix), 6},
    {5, F64, INPUT, offsetof(struct Model, place), 3},
    {6, F64, TUNABLE, offsetof(struct Model, weights), 2},
#endif
};
static void model_start(struct Model* m) {
  memset(m, 0, sizeof *m);
  m->weights[0] = 1;
  m->weights[1] = 2;
}
static void model_outputs(struct Model* m, double now) {
  m->time = now;
  for (int i = 0; i < 6; ++i) m->matrix[i] = (i < 3 ? m->weights[0] : m->weights[1]) * m->place[i % 3];
}
static int model_step(struct Instance* self, struct Model* m, double now, double size, bool* terminate, double* reached) {
  (void)terminate;
  m->out = m->deed;
  m->sum += m->deed;
  *reached = now + size;
  switch ((int)m->deed) {
    case 1: *(volatile int*)0 = 1; return OK;
    case 2:
      for (volatile int go = 1; go;) {
      }
      return OK;
    case 3: m->out = NAN; return OK;
    case 4: send_log(self, ERROR_, "The gear is broken."); return ERROR_;
    case 5: send_log(self, FATAL, "The house is on fire."); return FATAL;
    case 6: *reached = now + size / 4; return DISCARD;
    case 7: {
      volatile int one = 1, zero = 0;
      m->out = one / zero;
      return OK;
    }
    case 8: *reached = now + size / 2; return OK;
    default: return OK;
  }
}
