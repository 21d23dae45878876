#pragma once
/* A small FMU in one header, for tests of importers: co-simulation of FMI 2.0 or 3.0 (macro FMI_VERSION), written from the text of the
 * standard.
 *
 * This header includes a model (macro MODEL), which defines: TOKEN, struct Model (plain data), the table `variables`, model_start,
 * model_outputs and model_step; and with EVENT_MODE also model_event and model_update. Calls in the wrong order, with unknown value
 * references or at another time than the end of the last step return an error, so that mistakes of an importer are detected. */
#include <math.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { OK, WARNING, DISCARD, ERROR_, FATAL };
typedef enum { F64, F32, I8, U8, I16, U16, I32, U32, I64, U64, B8, TEXT } Kind;
typedef enum {
  INPUT,
  DISCRETE,
  OUTPUT,
  LOCAL,
  FIXED,
  TUNABLE
} Role; /* DISCRETE: an input that may be set only at events, if the importer uses event mode */
/* A variable of the model. */
typedef struct {
  unsigned reference;
  Kind kind;
  Role role;
  size_t offset, count; /* bytes from the start of struct Model; elements */
} Var;

typedef struct Model Model;
typedef struct Instance Instance;
/* Sends a log message to the importer. */
static void send_log(Instance* self, int status, const char* text);

#include MODEL

#define VARIABLE_COUNT (sizeof variables / sizeof variables[0])

/* Modes of the state machine of the standard. */
enum { INSTANTIATED, INITIALIZING, STEPPING, EVENTS, ENDED };
struct Instance {
  Model model;
  int mode;
  bool logging, uses_events;
  bool event_due; /* an event must be handled before the next step */
  bool again;     /* the last UpdateDiscreteStates requested another one */
  double start, now;
  char name[64], resources[512];
  void* environment;
  void (*log)(void);
};

/* Bytes of an element. */
static size_t size_of(Kind kind) {
  switch (kind) {
    case F64:
    case I64:
    case U64: return 8;
    case F32:
    case I32:
    case U32: return 4;
    case I16:
    case U16: return 2;
    case TEXT: return 64;
    default: return 1;
  }
}

static const Var* find(unsigned reference, Kind kind) {
  for (size_t i = 0; i < VARIABLE_COUNT; ++i)
    if (variables[i].reference == reference && variables[i].kind == kind) return &variables[i];
  return NULL;
}

static bool may_set(const Instance* self, const Var* v) {
  if (v->role == INPUT) return self->mode <= STEPPING;
  if (self->uses_events && (v->role == DISCRETE || v->role == TUNABLE)) return self->mode <= INITIALIZING || self->mode == EVENTS;
  if (v->role == DISCRETE) return self->mode <= STEPPING;
  if (v->role == FIXED) return self->mode <= INITIALIZING;
  if (v->role == TUNABLE) return self->mode <= STEPPING;
  return self->mode <= INITIALIZING && v->role == OUTPUT; /* start values with initial="exact" */
}

/* Gets (set == false) or sets variables of one type. `count`: number of elements in `values`. */
static int access(Instance* self, Kind kind, const unsigned* r, size_t n, void* values, size_t count, bool set) {
  if (!self) return ERROR_;
  if (!set && self->mode == INSTANTIATED) {
    send_log(self, ERROR_, "Variables were read before initialisation.");
    return ERROR_;
  }
  char* at = values;
  size_t done = 0;
  if (!set) model_outputs(&self->model, self->now);
  for (size_t i = 0; i < n; ++i) {
    const Var* v = find(r[i], kind);
    if (!v || (set && !may_set(self, v))) {
      send_log(self, ERROR_, v ? "A variable was set that may not be set now." : "There is no variable of this type and value reference.");
      return ERROR_;
    }
    const size_t bytes = v->count * size_of(kind);
    char* own = (char*)&self->model + v->offset;
    if (set)
      memcpy(own, at, bytes);
    else
      memcpy(at, own, bytes);
    at += bytes;
    done += v->count;
  }
  if (done != count) {
    send_log(self, ERROR_, "The number of values is not the number of elements of the variables.");
    return ERROR_;
  }
  return OK;
}

static Instance* make_instance(const char* name, const char* token, const char* resources) {
  if (!name || !*name || !token || strcmp(token, TOKEN) != 0) return NULL;
  Instance* self = calloc(1, sizeof *self);
  snprintf(self->name, sizeof self->name, "%s", name);
  snprintf(self->resources, sizeof self->resources, "%s", resources ? resources : "");
  model_start(&self->model);
  return self;
}
static int enter_initialization(Instance* self, double start) {
  if (!self || self->mode != INSTANTIATED) return ERROR_;
  self->mode = INITIALIZING;
  self->start = self->now = start;
  return OK;
}
static int exit_initialization(Instance* self) {
  if (!self || self->mode != INITIALIZING) return ERROR_;
  self->mode = self->uses_events ? EVENTS : STEPPING;
  return OK;
}
static int end_simulation(Instance* self) {
  if (!self || (self->mode != STEPPING && self->mode != EVENTS)) return ERROR_;
  self->mode = ENDED;
  return OK;
}
static int start_again(Instance* self) {
  if (!self) return ERROR_;
  self->mode = INSTANTIATED;
  self->now = 0;
  self->event_due = self->again = false;
  model_start(&self->model);
  return OK;
}
static int step(Instance* self, double now, double size, bool* terminate, double* reached) {
  if (!self || self->mode != STEPPING || self->event_due) return ERROR_;
  if (fabs(now - self->now) > 1e-9 * (1 + fabs(now)) || !(size > 0)) {
    send_log(self, ERROR_, "The communication point is not the end of the last step.");
    return ERROR_;
  }
  *reached = self->now;
  const int status = model_step(self, &self->model, self->now, size, terminate, reached);
  if (status <= WARNING && !*terminate) self->now = now + size;
  if (status == FATAL) free(self); /* no further call is allowed: the address sanitizer detects an importer that makes one */
  return status;
}
/* A saved state. */
typedef struct {
  Model model;
  int mode;
  double start, now;
} Saved;
static int get_state(Instance* self, void** state) {
  if (!self || !state) return ERROR_;
  if (!*state) *state = malloc(sizeof(Saved));
  const Saved s = {self->model, self->mode, self->start, self->now};
  memcpy(*state, &s, sizeof s);
  return OK;
}
static int set_state(Instance* self, void* state) {
  if (!self || !state) return ERROR_;
  const Saved* s = state;
  self->model = s->model;
  self->mode = s->mode;
  self->start = s->start;
  self->now = s->now;
  return OK;
}
static int free_state(void** state) {
  if (!state) return ERROR_;
  free(*state);
  *state = NULL;
  return OK;
}
static int load_state(const void* bytes, size_t size, void** state) {
  if (size != sizeof(Saved)) return ERROR_;
  *state = malloc(size);
  memcpy(*state, bytes, size);
  return OK;
}

#define EXPORT __attribute__((visibility("default")))

#if FMI_VERSION == 2
typedef void (*Log2)(void*, const char*, int, const char*, const char*, ...);
typedef struct {
  Log2 logger;
  void* (*allocate)(size_t, size_t);
  void (*release)(void*);
  void (*finished)(void*, int);
  void* environment;
} Callbacks;
static void send_log(Instance* self, int status, const char* text) {
  if (self->log) ((Log2)self->log)(self->environment, self->name, status, "logStatusError", "%s (#%d#)", text, 1);
}
EXPORT const char* fmi2GetTypesPlatform(void) { return "default"; }
EXPORT const char* fmi2GetVersion(void) { return "2.0"; }
EXPORT int fmi2SetDebugLogging(void* c, int on, size_t n, const char* const* names) {
  (void)n, (void)names;
  ((Instance*)c)->logging = on;
  return OK;
}
EXPORT void* fmi2Instantiate(const char* name, int type, const char* guid, const char* resources, const Callbacks* calls, int visible,
                             int logging) {
  (void)visible;
  if (type != 1 || !calls || !calls->logger || !calls->allocate || !calls->release) return NULL;
  Instance* self = make_instance(name, guid, resources);
  if (!self) {
    calls->logger(calls->environment, name, ERROR_, "logStatusError", "The name or the guid is wrong.");
    return NULL;
  }
  self->logging = logging;
  self->environment = calls->environment;
  self->log = (void (*)(void))calls->logger;
  return self;
}
EXPORT void fmi2FreeInstance(void* c) { free(c); }
EXPORT int fmi2SetupExperiment(void* c, int has_tolerance, double tolerance, double start, int has_stop, double stop) {
  (void)has_tolerance, (void)tolerance, (void)has_stop, (void)stop;
  Instance* self = c;
  if (!self || self->mode != INSTANTIATED) return ERROR_;
  self->start = start;
  return OK;
}
EXPORT int fmi2EnterInitializationMode(void* c) { return enter_initialization(c, ((Instance*)c)->start); }
EXPORT int fmi2ExitInitializationMode(void* c) { return exit_initialization(c); }
EXPORT int fmi2Terminate(void* c) { return end_simulation(c); }
EXPORT int fmi2Reset(void* c) { return start_again(c); }
EXPORT int fmi2GetReal(void* c, const unsigned* r, size_t n, double* v) { return access(c, F64, r, n, v, n, false); }
EXPORT int fmi2SetReal(void* c, const unsigned* r, size_t n, const double* v) { return access(c, F64, r, n, (void*)v, n, true); }
EXPORT int fmi2GetInteger(void* c, const unsigned* r, size_t n, int* v) { return access(c, I32, r, n, v, n, false); }
EXPORT int fmi2SetInteger(void* c, const unsigned* r, size_t n, const int* v) { return access(c, I32, r, n, (void*)v, n, true); }
EXPORT int fmi2GetBoolean(void* c, const unsigned* r, size_t n, int* v) {
  for (size_t i = 0; i < n; ++i) {
    bool one = false;
    if (access(c, B8, &r[i], 1, &one, 1, false) != OK) return ERROR_;
    v[i] = one;
  }
  return OK;
}
EXPORT int fmi2SetBoolean(void* c, const unsigned* r, size_t n, const int* v) {
  for (size_t i = 0; i < n; ++i) {
    bool one = v[i] != 0;
    if (access(c, B8, &r[i], 1, &one, 1, true) != OK) return ERROR_;
  }
  return OK;
}
EXPORT int fmi2GetString(void* c, const unsigned* r, size_t n, const char** v) {
  for (size_t i = 0; i < n; ++i) {
    const Var* var = find(r[i], TEXT);
    if (!var) return ERROR_;
    v[i] = (char*)&((Instance*)c)->model + var->offset;
  }
  return OK;
}
EXPORT int fmi2SetString(void* c, const unsigned* r, size_t n, const char* const* v) {
  for (size_t i = 0; i < n; ++i) {
    const Var* var = find(r[i], TEXT);
    if (!var || !may_set(c, var)) return ERROR_;
    snprintf((char*)&((Instance*)c)->model + var->offset, 64, "%s", v[i]);
  }
  return OK;
}
static double last_reached;
static bool last_terminate;
EXPORT int fmi2DoStep(void* c, double now, double size, int never_back) {
  (void)never_back;
  last_terminate = false;
  const int status = step(c, now, size, &last_terminate, &last_reached);
  return last_terminate ? DISCARD : status;
}
EXPORT int fmi2CancelStep(void* c) { return (void)c, ERROR_; }
EXPORT int fmi2GetStatus(void* c, int kind, int* v) { return (void)c, (void)kind, (void)v, DISCARD; }
EXPORT int fmi2GetRealStatus(void* c, int kind, double* v) {
  (void)c;
  if (kind != 2) return DISCARD;
  *v = last_reached;
  return OK;
}
EXPORT int fmi2GetIntegerStatus(void* c, int kind, int* v) { return (void)c, (void)kind, (void)v, DISCARD; }
EXPORT int fmi2GetBooleanStatus(void* c, int kind, int* v) {
  (void)c;
  if (kind != 3) return DISCARD;
  *v = last_terminate;
  return OK;
}
EXPORT int fmi2GetStringStatus(void* c, int kind, const char** v) { return (void)c, (void)kind, (void)v, DISCARD; }
EXPORT int fmi2GetFMUstate(void* c, void** s) { return get_state(c, s); }
EXPORT int fmi2SetFMUstate(void* c, void* s) { return set_state(c, s); }
EXPORT int fmi2FreeFMUstate(void* c, void** s) { return (void)c, free_state(s); }
EXPORT int fmi2SerializedFMUstateSize(void* c, void* s, size_t* n) { return (void)c, (void)s, *n = sizeof(Saved), OK; }
EXPORT int fmi2SerializeFMUstate(void* c, void* s, char* to, size_t n) {
  return (void)c, n < sizeof(Saved) ? ERROR_ : (memcpy(to, s, sizeof(Saved)), OK);
}
EXPORT int fmi2DeSerializeFMUstate(void* c, const char* from, size_t n, void** s) { return (void)c, load_state(from, n, s); }

#else
typedef void (*Log3)(void*, int, const char*, const char*);
static void send_log(Instance* self, int status, const char* text) {
  if (self->log) ((Log3)self->log)(self->environment, status, "logStatusError", text);
}
EXPORT const char* fmi3GetVersion(void) { return "3.0"; }
EXPORT int fmi3SetDebugLogging(void* c, bool on, size_t n, const char* const* names) {
  (void)n, (void)names;
  ((Instance*)c)->logging = on;
  return OK;
}
EXPORT void* fmi3InstantiateCoSimulation(const char* name, const char* token, const char* resources, bool visible, bool logging,
                                         bool events, bool early, const unsigned* required, size_t n, void* environment, Log3 log,
                                         void* update) {
  (void)visible, (void)early, (void)required, (void)n, (void)update;
  Instance* self = make_instance(name, token, resources);
  if (!self) {
    log(environment, ERROR_, "logStatusError", "The name or the token is wrong.");
    return NULL;
  }
  self->logging = logging;
  self->uses_events = events;
  self->environment = environment;
  self->log = (void (*)(void))log;
  return self;
}
EXPORT void fmi3FreeInstance(void* c) { free(c); }
EXPORT int fmi3EnterInitializationMode(void* c, bool has_tolerance, double tolerance, double start, bool has_stop, double stop) {
  (void)has_tolerance, (void)tolerance, (void)has_stop, (void)stop;
  return enter_initialization(c, start);
}
EXPORT int fmi3ExitInitializationMode(void* c) { return exit_initialization(c); }
EXPORT int fmi3Terminate(void* c) { return end_simulation(c); }
EXPORT int fmi3Reset(void* c) { return start_again(c); }
#define ACCESS(name, type, kind)                                                                                                   \
  EXPORT int fmi3Get##name(void* c, const unsigned* r, size_t n, type* v, size_t m) { return access(c, kind, r, n, v, m, false); } \
  EXPORT int fmi3Set##name(void* c, const unsigned* r, size_t n, const type* v, size_t m) {                                        \
    return access(c, kind, r, n, (void*)v, m, true);                                                                               \
  }
ACCESS(Float64, double, F64)
ACCESS(Float32, float, F32)
ACCESS(Int8, int8_t, I8)
ACCESS(UInt8, uint8_t, U8)
ACCESS(Int16, int16_t, I16)
ACCESS(UInt16, uint16_t, U16)
ACCESS(Int32, int32_t, I32)
ACCESS(UInt32, uint32_t, U32)
ACCESS(Int64, int64_t, I64)
ACCESS(UInt64, uint64_t, U64)
ACCESS(Boolean, bool, B8)
EXPORT int fmi3SetString(void* c, const unsigned* r, size_t n, const char* const* v, size_t m) {
  for (size_t i = 0; i < n; ++i) {
    const Var* var = find(r[i], TEXT);
    if (!var || n != m || !may_set(c, var)) return ERROR_;
    snprintf((char*)&((Instance*)c)->model + var->offset, 64, "%s", v[i]);
  }
  return OK;
}
EXPORT int fmi3DoStep(void* c, double now, double size, bool never_back, bool* event, bool* terminate, bool* early, double* last) {
  (void)never_back;
  *event = *terminate = *early = false;
  const int status = step(c, now, size, terminate, last);
  if (status == OK && !*terminate && *last < now + size && *last > now) {
    *early = true;
    ((Instance*)c)->now = *last;
  } else if (status == OK && !*terminate) {
    *last = now + size;
  }
#ifdef EVENT_MODE
  *event = ((Instance*)c)->event_due = status == OK && !*terminate && model_event(&((Instance*)c)->model, *last);
#endif
  return status;
}
EXPORT int fmi3EnterEventMode(void* c) {
  Instance* self = c;
  if (!self || self->mode != STEPPING || !self->uses_events) return ERROR_;
  self->mode = EVENTS;
  return OK;
}
EXPORT int fmi3UpdateDiscreteStates(void* c, bool* again, bool* terminate, bool* nominals, bool* states, bool* has_next, double* next) {
  Instance* self = c;
  if (!self || self->mode != EVENTS) return ERROR_;
  *again = *terminate = *nominals = *states = *has_next = self->event_due = false;
  int status = OK;
#ifdef EVENT_MODE
  *has_next = true;
  status = model_update(self, &self->model, self->now, again, terminate, next);
#endif
  self->again = *again;
  return status;
}
EXPORT int fmi3EnterStepMode(void* c) {
  Instance* self = c;
  if (!self || self->mode != EVENTS || self->again) return ERROR_;
  self->mode = STEPPING;
  return OK;
}
EXPORT int fmi3GetFMUState(void* c, void** s) { return get_state(c, s); }
EXPORT int fmi3SetFMUState(void* c, void* s) { return set_state(c, s); }
EXPORT int fmi3FreeFMUState(void* c, void** s) { return (void)c, free_state(s); }
EXPORT int fmi3SerializedFMUStateSize(void* c, void* s, size_t* n) { return (void)c, (void)s, *n = sizeof(Saved), OK; }
EXPORT int fmi3SerializeFMUState(void* c, void* s, uint8_t* to, size_t n) {
  return (void)c, n < sizeof(Saved) ? ERROR_ : (memcpy(to, s, sizeof(Saved)), OK);
}
EXPORT int fmi3DeserializeFMUState(void* c, const uint8_t* from, size_t n, void** s) { return (void)c, load_state(from, n, s); }
#endif
