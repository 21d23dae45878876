#pragma once
/* Model with the interface of the Reference-FMU Feedthrough: every output equals its input. Two parameters and the text change the real
 * outputs, so that tests see whether they were set. */
#define TOKEN "{37B954F1-CC86-4D8F-B97F-C7C36F6670D2}"
struct Model {
  double time, fixed, tunable, c_in, c_out, d_in, d_out;
  float f_c_in, f_c_out, f_d_in, f_d_out;
  int8_t i8_in, i8_out;
  uint8_t u8_in, u8_out;
  int16_t i16_in, i16_out;
  uint16_t u16_in, u16_out;
  int32_t i32_in, i32_out;
  uint32_t u32_in, u32_out;
  int64_t i64_in, i64_out, e_in, e_out;
  uint64_t u64_in, u64_out;
  int32_t e2_in, e2_out;
  bool b_in, b_out;
  char text[64];
};
#define AT(field) offsetof(struct Model, field), 1
static const Var variables[] = {
    {0, F64, LOCAL, AT(time)},    {5, F64, FIXED, AT(fixed)},    {6, F64, TUNABLE, AT(tunable)},
    {7, F64, INPUT, AT(c_in)},    {8, F64, OUTPUT, AT(c_out)},   {9, F64, INPUT, AT(d_in)},
    {10, F64, OUTPUT, AT(d_out)}, {19, I32, INPUT, AT(i32_in)},  {20, I32, OUTPUT, AT(i32_out)},
    {27, B8, INPUT, AT(b_in)},    {28, B8, OUTPUT, AT(b_out)},   {29, TEXT, FIXED, offsetof(struct Model, text), 1},
#if FMI_VERSION == 2
    {32, I32, INPUT, AT(e2_in)},  {33, I32, OUTPUT, AT(e2_out)},
#else
    {1, F32, INPUT, AT(f_c_in)},    {2, F32, OUTPUT, AT(f_c_out)},  {3, F32, INPUT, AT(f_d_in)},
    {4, F32, OUTPUT, AT(f_d_out)},  {11, I8, INPUT, AT(i8_in)},     {12, I8, OUTPUT, AT(i8_out)},
    {13, U8, INPUT, AT(u8_in)},     {14, U8, OUTPUT, AT(u8_out)},   {15, I16, INPUT, AT(i16_in)},
    {16, I16, OUTPUT, AT(i16_out)}, {17, U16, INPUT, AT(u16_in)},   {18, U16, OUTPUT, AT(u16_out)},
    {21, U32, INPUT, AT(u32_in)},   {22, U32, OUTPUT, AT(u32_out)}, {23, I64, INPUT, AT(i64_in)},
    {24, I64, OUTPUT, AT(i64_out)}, {25, U64, INPUT, AT(u64_in)},   {26, U64, OUTPUT, AT(u64_out)},
    {32, I64, INPUT, AT(e_in)},     {33, I64, OUTPUT, AT(e_out)},
#endif
};
static void model_start(struct Model* m) {
  memset(m, 0, sizeof *m);
  m->e_in = m->e_out = m->e2_in = m->e2_out = 1;
  strcpy(m->text, "Set me!");
}
static void model_outputs(struct Model* m, double now) {
  m->time = now;
  m->c_out = m->c_in + m->fixed + 10 * m->tunable;
  m->d_out = m->d_in + (strcmp(m->text, "Set me!") == 0 ? 0 : 1000 * (double)strlen(m->text));
  m->f_c_out = m->f_c_in;
  m->f_d_out = m->f_d_in;
  m->i8_out = m->i8_in;
  m->u8_out = m->u8_in;
  m->i16_out = m->i16_in;
  m->u16_out = m->u16_in;
  m->i32_out = m->i32_in;
  m->u32_out = m->u32_in;
  m->i64_out = m->i64_in;
  m->u64_out = m->u64_in;
  m->b_out = m->b_in;
  m->e_out = m->e_in;
  m->e2_out = m->e2_in;
}
static int model_step(struct Instance* self, struct Model* m, double now, double size, bool* terminate, double* reached) {
  (void)self, (void)m, (void)terminate;
  *reached = now + size;
  return OK;
}
