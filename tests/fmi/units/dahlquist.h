#pragma once
/* Model with the interface of the Reference-FMU Dahlquist: der(x) = -k x, integrated by Euler's method with steps of at most 1e-4 s. */
#define TOKEN "{8c4e810f-3da3-4a00-8276-176fa3c9f001}"
struct Model {
  double x, k, time, der_x;
};
#define AT(field) offsetof(struct Model, field), 1
static const Var variables[] = {{0, F64, LOCAL, AT(time)}, {1, F64, OUTPUT, AT(x)}, {2, F64, LOCAL, AT(der_x)}, {3, F64, FIXED, AT(k)}};
static void model_start(struct Model* m) {
  memset(m, 0, sizeof *m);
  m->x = 1;
  m->k = 1;
}
static void model_outputs(struct Model* m, double now) {
  m->time = now;
  m->der_x = -m->k * m->x;
}
static int model_step(struct Instance* self, struct Model* m, double now, double size, bool* terminate, double* reached) {
  (void)self, (void)terminate;
  const int n = (int)ceil(size / 1e-4);
  for (int i = 0; i < n; ++i) m->x += size / n * -m->k * m->x;
  *reached = now + size;
  return OK;
}
