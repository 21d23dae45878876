/* Calls the functions of an FMU's binary through the state machine of FMI 2.0 or 3.0 co-simulation, in the right order and in wrong orders.
 *
 *     checker VERSION BINARY TOKEN RESOURCES STEP SAVES SERIALIZES  < table of variables
 *
 * STEP is the communication step, s. SAVES and SERIALIZES are 1 if the FMU can save and serialise its state, otherwise 0. Each line of the
 * table describes a variable: type causality variability reference count start.
 *
 * This program is written from the text of the standards with its own declarations and uses no code of the project. Exit status 0: the
 * FMU behaves as the standard requires; 1: it does not, with a line for each failed check; 2: wrong arguments. A crash of the binary also
 * fails the check.
 */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <math.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { OK = 0, WARNING = 1, DISCARD = 2, ERR = 3 };
/* A variable of the FMU. */
typedef struct {
  char type[24], causality[24], variability[24];
  unsigned reference;
  size_t count;
  double start;
} Variable;

static Variable variables[4096];
static size_t variable_count, logged; /* logged: messages of the FMU so far */
static int version, checks, wrong;    /* version of FMI: 2 or 3 */
static void* library;

/* Counts a check; prints a line if the condition is false. */
#define CHECK(condition, ...)                        \
  do {                                               \
    ++checks;                                        \
    if (!(condition)) {                              \
      ++wrong;                                       \
      printf("line %d: " #condition ": ", __LINE__); \
      printf(__VA_ARGS__);                           \
      printf("\n");                                  \
    }                                                \
  } while (0)

/* Address of fmi2NAME or fmi3NAME; ends the program if it is missing. */
static void* function(const char* name) {
  char full[80];
  snprintf(full, sizeof full, "fmi%d%s", version, name);
  void* f = dlsym(library, full);
  CHECK(f != NULL, "%s is missing", full);
  if (!f) exit(1);
  return f;
}

/* Loggers. Every message must have a status of warning or worse and a text. */
static void log2_message(void* environment, const char* instance, int status, const char* category, const char* message, ...) {
  char text[1000];
  va_list arguments;
  va_start(arguments, message);
  vsnprintf(text, sizeof text, message, arguments);
  va_end(arguments);
  CHECK(environment == &logged && instance && category && status >= WARNING && strlen(text) > 5, "message '%s'", text);
  ++logged;
}
static void log3_message(void* environment, int status, const char* category, const char* message) {
  CHECK(environment == &logged && category && status >= WARNING && message && strlen(message) > 5, "message '%s'", message);
  ++logged;
}

typedef struct {
  void (*logger)(void*, const char*, int, const char*, const char*, ...);
  void* (*allocate)(size_t, size_t);
  void (*release)(void*);
  void (*finished)(void*, int);
  void* environment;
} Callbacks2;
static const Callbacks2 callbacks = {log2_message, calloc, free, NULL, &logged};

static void* instantiate(const char* name, const char* token, const char* resources) {
  if (version == 2) {
    void* (*f)(const char*, int, const char*, const char*, const Callbacks2*, int, int) = function("Instantiate");
    return f(name, 1, token, resources, &callbacks, 0, 0);
  }
  void* (*f)(const char*, const char*, const char*, bool, bool, bool, bool, const unsigned*, size_t, void*, void*, void*) =
      function("InstantiateCoSimulation");
  return f(name, token, resources, false, false, false, false, NULL, 0, &logged, (void*)log3_message, NULL);
}
static int enter_initialization(void* c, double start, bool has_stop, double stop) {
  if (version == 2) {
    int (*setup)(void*, int, double, double, int, double) = function("SetupExperiment");
    int (*enter)(void*) = function("EnterInitializationMode");
    const int status = setup(c, 0, 0, start, has_stop, stop);
    return status != OK ? status : enter(c);
  }
  int (*enter)(void*, bool, double, double, bool, double) = function("EnterInitializationMode");
  return enter(c, false, 0, start, has_stop, stop);
}
/* Calls a function that has only the instance as parameter. */
static int simple(void* c, const char* name) {
  int (*f)(void*) = function(name);
  return f(c);
}
static void free_instance(void* c) {
  void (*f)(void*) = function("FreeInstance");
  f(c);
}
static int step(void* c, double now, double size) {
  if (version == 2) {
    int (*f)(void*, double, double, int) = function("DoStep");
    return f(c, now, size, 1);
  }
  bool event = true, terminate = true, early = true;
  double last = -1;
  int (*f)(void*, double, double, bool, bool*, bool*, bool*, double*) = function("DoStep");
  const int status = f(c, now, size, true, &event, &terminate, &early, &last);
  if (status == OK) CHECK(!event && !terminate && !early && fabs(last - now - size) < 1e-12 * (1 + now), "DoStep's results");
  return status;
}

static bool is_text(const Variable* v) { return strcmp(v->type, "String") == 0; }
static size_t bytes_of(const Variable* v) {
  if (version == 2) return strcmp(v->type, "Real") == 0 || is_text(v) ? 8 : 4;
  if (strstr(v->type, "64") || strcmp(v->type, "Enumeration") == 0 || is_text(v)) return 8;
  if (strstr(v->type, "32")) return 4;
  if (strstr(v->type, "16")) return 2;
  return 1;
}
/* NAME of the functions GetNAME and SetNAME for a variable. */
static const char* access_type(const Variable* v) {
  return strcmp(v->type, "Enumeration") != 0 ? v->type : version == 2 ? "Integer" : "Int64";
}
static int get_as(void* c, const char* type, const unsigned* references, size_t n, void* values, size_t count) {
  char name[40];
  snprintf(name, sizeof name, "Get%s", type);
  if (version == 2) {
    int (*f)(void*, const unsigned*, size_t, void*) = function(name);
    return f(c, references, n, values);
  }
  int (*f)(void*, const unsigned*, size_t, void*, size_t) = function(name);
  return f(c, references, n, values, count);
}
static int set_as(void* c, const char* type, const unsigned* references, size_t n, const void* values, size_t count) {
  char name[40];
  snprintf(name, sizeof name, "Set%s", type);
  if (version == 2) {
    int (*f)(void*, const unsigned*, size_t, const void*) = function(name);
    return f(c, references, n, values);
  }
  int (*f)(void*, const unsigned*, size_t, const void*, size_t) = function(name);
  return f(c, references, n, values, count);
}
/* Gets and sets one variable, with its values in `memory`. */
static char memory[1 << 20];
static int get(void* c, const Variable* v) { return get_as(c, access_type(v), &v->reference, 1, memory, v->count); }
static int set(void* c, const Variable* v) { return set_as(c, access_type(v), &v->reference, 1, memory, v->count); }

static bool is(const char* text, const char* word) { return strcmp(text, word) == 0; }
/* Writes the values of all variables to `to`, strings as their characters. Returns the number of bytes. */
static size_t read_all(void* c, char* to) {
  size_t at = 0;
  for (size_t i = 0; i < variable_count; ++i) {
    CHECK(get(c, &variables[i]) == OK, "variable %u (%s)", variables[i].reference, variables[i].type);
    if (is_text(&variables[i])) {
      const char* text;
      memcpy(&text, memory, sizeof text);
      memcpy(to + at, text, strlen(text));
      at += strlen(text);
    } else {
      memcpy(to + at, memory, bytes_of(&variables[i]) * variables[i].count);
      at += bytes_of(&variables[i]) * variables[i].count;
    }
  }
  return at;
}
/* Value of a real variable in `memory`; 0 for other types. */
static double real_of(const Variable* v) {
  double x = 0;
  if (is(v->type, "Real") || is(v->type, "Float64")) memcpy(&x, memory, sizeof x);
  return x;
}

/* Sets the real inputs to values that depend on the time `now`. */
static void set_inputs(void* c, double now) {
  for (size_t i = 0; i < variable_count; ++i) {
    const Variable* v = &variables[i];
    if (!is(v->causality, "input") || !(is(v->type, "Real") || is(v->type, "Float64"))) continue;
    double* x = (double*)memory;
    for (size_t k = 0; k < v->count; ++k) x[k] = v->start + 0.5 + 0.25 * sin(7 * now + (double)k);
    CHECK(set(c, v) == OK, "input %u", v->reference);
  }
}

/* Calls with unknown references, wrong types, wrong sizes and invalid values; each must return an error. `when`: the mode, for messages. */
static void wrong_calls(void* c, const char* when, bool may_set) {
  size_t before = logged;
  for (size_t i = 0; i < variable_count; ++i) {
    const Variable* v = &variables[i];
    if (is_text(v)) continue;
    const unsigned unknown = 4000000000u;
    CHECK(get_as(c, access_type(v), &unknown, 1, memory, 1) == ERR, "unknown reference, %s", when);
    CHECK(set_as(c, access_type(v), &unknown, 1, memory, 1) == ERR, "unknown reference, %s", when);
    CHECK(get_as(c, is(access_type(v), "Boolean") ? (version == 2 ? "Integer" : "Int64") : "Boolean", &v->reference, 1, memory, v->count) ==
              ERR,
          "wrong type, %s", when);
    if (version == 3) CHECK(get_as(c, access_type(v), &v->reference, 1, memory, v->count + 1) == ERR, "wrong number of values, %s", when);
    if (is(v->causality, "output") || is(v->causality, "independent")) {
      memset(memory, 0, 4096);
      CHECK(set(c, v) == ERR, "setting %s %u, %s", v->causality, v->reference, when);
    }
    if (may_set && is(v->causality, "input") && bytes_of(v) == 8) {
      const double nan = NAN;
      memcpy(memory, &nan, sizeof nan);
      for (size_t k = 0; k < v->count; ++k) memcpy(memory + 8 * k, &nan, sizeof nan);
      CHECK(set(c, v) == ERR, "not a number, %s", when);
    }
  }
  CHECK(get_as(c, version == 2 ? "Real" : "Float64", NULL, 1, memory, 1) == ERR, "null references, %s", when);
  CHECK(logged > before, "errors are logged, %s", when);
}

static void* save(void* c) {
  void* state = NULL;
  int (*f)(void*, void**) = function(version == 2 ? "GetFMUstate" : "GetFMUState");
  CHECK(f(c, &state) == OK && state, "saving");
  return state;
}
static int restore(void* c, void* state) {
  int (*f)(void*, void*) = function(version == 2 ? "SetFMUstate" : "SetFMUState");
  return f(c, state);
}
static int release(void* c, void** state) {
  int (*f)(void*, void**) = function(version == 2 ? "FreeFMUstate" : "FreeFMUState");
  return f(c, state);
}

static char first[1 << 20], second[1 << 20];

/* Computes steps from `now`, and writes the values of all variables after each step to `to`. Returns the number of bytes. */
static size_t run(void* c, double now, double size, int steps, char* to) {
  size_t at = 0;
  for (int i = 0; i < steps; ++i) {
    set_inputs(c, now);
    CHECK(step(c, now, size) == OK, "step at %g", now);
    now += size;
    at += read_all(c, to + at);
  }
  return at;
}

int main(int argc, char** argv) {
  if (argc != 8) return 2;
  version = atoi(argv[1]);
  const char *token = argv[3], *resources = argv[4];
  const double size = atof(argv[5]);
  const bool saves = atoi(argv[6]), serializes = atoi(argv[7]);
  while (variable_count < 4096) {
    Variable* v = &variables[variable_count];
    if (scanf("%23s %23s %23s %u %zu %lf", v->type, v->causality, v->variability, &v->reference, &v->count, &v->start) != 6) break;
    ++variable_count;
  }
  library = dlopen(argv[2], RTLD_NOW | RTLD_LOCAL);
  CHECK(library != NULL, "%s", dlerror());
  if (!library) return 1;
  const char* (*get_version)(void) = function("GetVersion");
  CHECK(strncmp(get_version(), version == 2 ? "2.0" : "3.0", 3) == 0, "version %s", get_version());
  if (version == 2) {
    const char* (*platform)(void) = function("GetTypesPlatform");
    CHECK(is(platform(), "default"), "types platform");
  }

  /* Instantiation with wrong arguments must fail. */
  size_t before = logged;
  CHECK(instantiate("a", "another token", resources) == NULL, "a wrong token");
  CHECK(instantiate("", token, resources) == NULL, "an empty name");
  CHECK(instantiate("a", token, version == 2 ? "file:///nowhere" : "/nowhere/") == NULL, "wrong resources");
  CHECK(logged >= before + 3, "refusals are logged");

  void* c = instantiate("one", token, resources);
  CHECK(c != NULL, "instantiate");
  if (!c) return 1;

  /* Instantiated: functions of later states must be refused. */
  CHECK(step(c, 0, size) == ERR, "a step before initialization");
  CHECK(simple(c, "ExitInitializationMode") == ERR, "exit before enter");
  CHECK(simple(c, "Terminate") == ERR, "terminate before initialization");
  for (size_t i = 0; i < variable_count; ++i)
    if (is(variables[i].causality, "output")) CHECK(get(c, &variables[i]) == ERR, "reading an output before initialization");
  wrong_calls(c, "instantiated", true);
  CHECK(enter_initialization(c, 0, false, 0) == OK, "enter");
  CHECK(enter_initialization(c, 0, false, 0) == ERR, "enter twice");
  CHECK(step(c, 0, size) == ERR, "a step in initialization");
  read_all(c, first);
  wrong_calls(c, "initialization", true);
  CHECK(simple(c, "ExitInitializationMode") == OK, "exit");
  CHECK(simple(c, "ExitInitializationMode") == ERR, "exit twice");

  /* Step mode. */
  wrong_calls(c, "stepping", true);
  for (size_t i = 0; i < variable_count; ++i) {
    if (!is(variables[i].causality, "parameter") || is_text(&variables[i])) continue;
    CHECK(get(c, &variables[i]) == OK, "reading a parameter");
    CHECK(set(c, &variables[i]) == (is(variables[i].variability, "tunable") ? OK : ERR), "setting the %s parameter %u while it steps",
          variables[i].variability, variables[i].reference);
  }
  CHECK(step(c, 5 * size, size) == ERR, "a step at another time");
  CHECK(step(c, 0, 0) == ERR, "a step of size 0");
  CHECK(step(c, 0, -size) == ERR, "a step backwards");
  CHECK(step(c, NAN, size) == ERR, "a step at a time that is not a number");
  const size_t bytes = run(c, 0, size, 5, first);
  for (size_t i = 0; i < variable_count; ++i)
    if (is(variables[i].causality, "independent")) {
      CHECK(get(c, &variables[i]) == OK && fabs(real_of(&variables[i]) - 5 * size) < 1e-9, "the time after 5 steps is %g",
            real_of(&variables[i]));
    }

  /* A second instance gives the same values and is independent of the first. */
  void* other = instantiate("two", token, resources);
  CHECK(other && other != c, "a second instance");
  CHECK(enter_initialization(other, 0, true, 8 * size) == OK && simple(other, "ExitInitializationMode") == OK, "its start");
  CHECK(run(other, 0, size, 5, second) == bytes && memcmp(first, second, bytes) == 0, "two instances give the same values");

  if (saves) {
    void* state = save(c);
    void* kept = state;
    const size_t n = run(c, 5 * size, size, 3, first);
    CHECK(restore(c, state) == OK, "restore");
    CHECK(run(c, 5 * size, size, 3, second) == n && memcmp(first, second, n) == 0, "the same values after restoring the state");
    CHECK(restore(c, (void*)first) == ERR && restore(c, NULL) == ERR, "handles that are not states");
    if (serializes) {
      size_t length = 0;
      int (*length_of)(void*, void*, size_t*) = function(version == 2 ? "SerializedFMUstateSize" : "SerializedFMUStateSize");
      int (*serialize)(void*, void*, char*, size_t) = function(version == 2 ? "SerializeFMUstate" : "SerializeFMUState");
      int (*deserialize)(void*, const char*, size_t, void**) = function(version == 2 ? "DeSerializeFMUstate" : "DeserializeFMUState");
      CHECK(length_of(c, state, &length) == OK && length > 0, "the length of the state");
      char* text = malloc(length);
      CHECK(serialize(c, state, text, length - 1) == ERR, "too little room");
      CHECK(serialize(c, state, text, length) == OK, "serialize");
      void* copy = NULL;
      for (size_t cut = 0; cut < length; cut += 1 + length / 50)
        CHECK(deserialize(other, text, cut, &copy) == ERR, "a state cut off at %zu", cut);
      CHECK(deserialize(other, text, length, &copy) == OK && copy, "deserialize");
      CHECK(restore(other, copy) == OK, "restore in another instance");
      CHECK(run(other, 5 * size, size, 3, second) == n && memcmp(first, second, n) == 0, "the same values in the other instance");
      CHECK(release(other, &copy) == OK && copy == NULL, "release");
      free(text);
    }
    CHECK(release(c, &state) == OK && state == NULL, "release");
    CHECK(release(c, &state) == OK, "release of a null state");
    CHECK(release(c, &kept) == ERR, "release twice");
  }
  if (saves) CHECK(step(other, 8 * size, size) == ERR, "a step beyond the stop time");

  /* With constant inputs, 8 small steps and 2 large steps must give the same outputs. */
  void* halves = instantiate("halves", token, resources);
  void* wholes = instantiate("wholes", token, resources);
  for (void** each = (void*[]){halves, wholes, NULL}; *each; ++each)
    CHECK(enter_initialization(*each, 1, false, 0) == OK && simple(*each, "ExitInitializationMode") == OK, "start at 1 s");
  for (int i = 0; i < 8; ++i) CHECK(step(halves, 1 + i * size, size) == OK, "small step");
  for (int i = 0; i < 2; ++i) CHECK(step(wholes, 1 + 4 * i * size, 4 * size) == OK, "large step");
  size_t same = 0;
  for (size_t i = 0; i < variable_count; ++i) {
    if (!is(variables[i].causality, "output")) continue;
    const size_t n = bytes_of(&variables[i]) * variables[i].count;
    CHECK(get(halves, &variables[i]) == OK, "reading");
    memcpy(first, memory, n);
    CHECK(get(wholes, &variables[i]) == OK && memcmp(first, memory, n) == 0, "output %u after 8 small and 2 large steps",
          variables[i].reference);
    ++same;
  }
  free_instance(halves);
  free_instance(wholes);

  /* End of the simulation and reset. */
  CHECK(simple(c, "Terminate") == OK, "terminate");
  CHECK(step(c, 8 * size, size) == ERR, "a step after the end");
  CHECK(simple(c, "Terminate") == ERR, "terminate twice");
  read_all(c, second);
  CHECK(simple(c, "Reset") == OK, "reset");
  CHECK(step(c, 0, size) == ERR, "a step after reset");
  CHECK(enter_initialization(c, 0, false, 0) == OK && simple(c, "ExitInitializationMode") == OK, "again");
  run(c, 0, size, 5, first);
  void* fresh = instantiate("fresh", token, resources);
  CHECK(enter_initialization(fresh, 0, false, 0) == OK && simple(fresh, "ExitInitializationMode") == OK, "a new instance");
  CHECK(run(fresh, 0, size, 5, second) == bytes && memcmp(first, second, bytes) == 0,
        "an instance after reset gives the same values as a new one");

  free_instance(fresh);
  free_instance(other);
  free_instance(c);
  CHECK(step(c, 0, size) == ERR, "a step after it was freed");
  free_instance(c);
  free_instance(NULL);
  CHECK(step(NULL, 0, size) == ERR, "a step of a null instance");
  CHECK(simple(NULL, "Reset") == ERR, "a reset of a null instance");
  printf("%d checks, %d wrong, %zu messages, %zu outputs\n", checks, wrong, logged, same);
  return wrong == 0 ? 0 : 1;
}
