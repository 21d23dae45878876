#pragma once
/* Model with the interface of the Reference-FMU VanDerPol, integrated by Heun's method with steps of at most 1e-4 s. */
#define TOKEN "{8c4e810f-3da3-4a00-8276-176fa3c9f000}"
struct Model {
  double x0, x1, mu, time, der_x0, der_x1;
};
#define AT(field) offsetof(struct Model, field), 1
static const Var variables[] = {{0, F64, LOCAL, AT(time)}, {1, F64, OUTPUT, AT(x0)},    {2, F64, LOCAL, AT(der_x0)},
                                {3, F64, OUTPUT, AT(x1)},  {4, F64, LOCAL, AT(der_x1)}, {5, F64, FIXED, AT(mu)}};
static void model_start(struct Model* m) {
  memset(m, 0, sizeof *m);
  m->x0 = 2;
  m->mu = 1;
}
static void model_outputs(struct Model* m, double now) {
  m->time = now;
  m->der_x0 = m->x1;
  m->der_x1 = m->mu * (1 - m->x0 * m->x0) * m->x1 - m->x0;
}
static int model_step(struct Instance* self, struct Model* m, double now, double size, bool* terminate, double* reached) {
  (void)self, (void)terminate;
  const int n = (int)ceil(size / 1e-4);
  const double h = size / n;
  for (int i = 0; i < n; ++i) {
    const double a0 = m->x1, a1 = m->mu * (1 - m->x0 * m->x0) * m->x1 - m->x0;
    const double x0 = m->x0 + h * a0, x1 = m->x1 + h * a1;
    const double b0 = x1, b1 = m->mu * (1 - x0 * x0) * x1 - x0;
    m->x0 += h / 2 * (a0 + b0);
    m->x1 += h / 2 * (a1 + b1);
  }
  *reached = now + size;
  return OK;
}
