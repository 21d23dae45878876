#pragma once
/* Model with the interface of the Reference-FMU BouncingBall. The motion between bounces is computed in closed form. */
#define TOKEN "{8c4e810f-3df3-4a00-8276-176fa3c9f003}"
struct Model {
  double h, v, g, e, v_min, time, der_h, der_v;
  bool rests;
};
#define AT(field) offsetof(struct Model, field), 1
static const Var variables[] = {{0, F64, LOCAL, AT(time)}, {1, F64, OUTPUT, AT(h)},    {2, F64, LOCAL, AT(der_h)},
                                {3, F64, OUTPUT, AT(v)},   {4, F64, LOCAL, AT(der_v)}, {5, F64, FIXED, AT(g)},
                                {6, F64, TUNABLE, AT(e)},  {7, F64, LOCAL, AT(v_min)}};
static void model_start(struct Model* m) {
  memset(m, 0, sizeof *m);
  m->h = 1;
  m->g = -9.81;
  m->e = 0.7;
  m->v_min = 0.1;
}
static void model_outputs(struct Model* m, double now) {
  m->time = now;
  m->der_h = m->v;
  m->der_v = m->rests ? 0 : m->g;
}
static int model_step(struct Instance* self, struct Model* m, double now, double size, bool* terminate, double* reached) {
  (void)self, (void)now, (void)terminate;
  double left = size;
  while (left > 0 && !m->rests) {
    const double root = m->v * m->v - 2 * m->g * m->h;
    const double hit =
        m->g < 0 && root >= 0 ? (m->v + sqrt(root)) / -m->g : INFINITY; /* time of the next bounce, s: h + v t + g t^2 / 2 = 0 */
    const double t = hit < left ? hit : left;
    m->h += m->v * t + 0.5 * m->g * t * t;
    m->v += m->g * t;
    left -= t;
    if (hit <= t) {
      m->h = 0;
      m->v = -m->e * m->v;
      if (m->v < m->v_min) {
        m->v = 0;
        m->rests = true;
      }
    }
  }
  *reached = now + size;
  return OK;
}
