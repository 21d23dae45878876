/* Binary interface between the host (Ugoki) and a library of software LSIs. C11 and C++.
 *
 * A software LSI is a component with typed input and output pins around an algorithm in C or C++. LSIs are wired together to a circuit,
 * which the host runs in ticks of equal length. A library of LSIs is a shared library that exports one function, ugoki_lsi_library. This
 * function returns constant tables that describe the LSIs: their pins, parameters, state and functions.
 *
 * Most libraries need no code for this interface: `ugoki lsi build FILE` writes the tables for plain functions, and <ugoki/lsi.hpp> makes
 * them from C++ structs. Include this header directly to fill in the tables by hand, for example from another language. The guide is
 * docs/lsi.md.
 *
 * Versions. Every struct begins with `size`, its size in bytes as known to the side that filled it in. New fields are added at the end
 * only, and the values of types, kinds and flags never change. Therefore a host reads libraries that are older or newer than itself, and a
 * library runs under an older host if it asks UGOKI_HAS before it reads a field that was added later. UGOKI_LSI_ABI changes only when this
 * compatibility is broken; a host refuses libraries with another value.
 *
 * Rules for the functions of an LSI:
 *  - Throw no exception out of the function.
 *  - Start no thread that outlives the call.
 *  - Give the same outputs for the same inputs, parameters and state.
 *  - Keep everything that is remembered from tick to tick in `state`, as plain bytes without pointers: the host saves and restores these
 *    bytes. The only exception is an object made by `create`.
 *
 * Zero is a valid default for every optional field and for every field named `reserved`. Texts are UTF-8 and zero-terminated. Tables and
 * texts belong to the library and stay valid while it is loaded. */
#ifndef UGOKI_LSI_H
#define UGOKI_LSI_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Version of this interface; a library states it in ugoki_library.abi. */
#define UGOKI_LSI_ABI 1u

/* True if the struct that `p` points to is large enough to contain `field`: its writer knew the field. */
#define UGOKI_HAS(p, field) ((p)->size >= (size_t)((const char*)(&(p)->field + 1) - (const char*)(p)))

/* Type of a pin. It fixes the layout of the payload, the bytes that a wire carries. Payloads are arrays of double, except contacts and
 * events. States, motions and contacts are in SI units (m, rad, s, N). An element is the unit in which pins are counted (`count`): one
 * double for joint values, states and motions, one record for contacts and events, and the whole value for the other types. */
enum ugoki_type {
  UGOKI_SCALAR = 1,       /* one double */
  UGOKI_VECTOR = 2,       /* 3 doubles: x, y, z */
  UGOKI_ROTATION = 3,     /* 4 doubles: unit quaternion w, x, y, z */
  UGOKI_POSE = 4,         /* 7 doubles: position x, y, z [m], then unit quaternion w, x, y, z */
  UGOKI_JOINT_VALUES = 5, /* `count` doubles: for example one for each coordinate or degree of freedom of a mechanism */
  UGOKI_STATE = 6,        /* `count` doubles: positions q and velocities v of every mechanism of the world */
  UGOKI_CONTACTS = 7,     /* uint64_t number of records in use, then records of 128 bytes (ContactRecord of the host) */
  UGOKI_MOTION = 8,       /* `count` doubles: reference of one mechanism: q, v, a, then one stance value (0 or 1) for each foot */
  UGOKI_EVENT = 9         /* uint64_t number of records in use, then records of 128 bytes (EventRecord of the host) */
};

/* The tick that is being computed. */
typedef struct ugoki_tick {
  uint32_t size;
  uint32_t reserved;
  double time;    /* s: index * the time between two ticks of the circuit */
  double dt;      /* s: time between two runs of the LSI: n times the time between two ticks for an LSI that runs at every n-th tick */
  uint64_t index; /* ticks of the circuit computed before this one */
} ugoki_tick;

/* Argument of the functions of an LSI. The host owns the struct and all memory that it points to. The addresses stay the same while the
 * circuit runs; only the values behind them change. */
typedef struct ugoki_call {
  uint32_t size;
  uint32_t reason_size;      /* bytes of `reason` */
  const void* const* in;     /* [wires] payloads. An input without UGOKI_MULTIPLE has exactly one: input i is in[i]. Without wire it points
                                to the default value, or is null if the number of its elements is unknown */
  void* const* out;          /* [outputs] payloads to write */
  const uint32_t* in_first;  /* [inputs + 1] the payloads of input i are in[in_first[i]] to in[in_first[i + 1] - 1] */
  const uint32_t* in_count;  /* [wires] elements of each payload of `in` */
  const uint32_t* out_count; /* [outputs] elements of each payload of `out` */
  const double* parameters; /* values in the order of declaration: 1 double for a number, an integer, a boolean (0 or 1) and a choice (index
                               of the chosen word), 3 for a vector, none for a text (see ugoki_setup.texts) */
  void* state;              /* state_size bytes; null if state_size is 0 */
  void* object;             /* return value of `create`; null if the LSI has no `create` */
  const ugoki_tick* tick;
  char* reason; /* [reason_size] a function that returns non-zero writes a zero-terminated sentence here (see ugoki_stop) */
} ugoki_call;

/* A function of an LSI: init, step or advance. Returns 0 on success. Any other value stops the circuit; the host then reports the LSI, the
 * time and `reason`. */
typedef int32_t (*ugoki_step_function)(const ugoki_call*);

enum ugoki_input_flag {
  UGOKI_OPTIONAL = 1, /* needs no wire: without one, every number of the payload is `value` (rotations and poses: the identity) */
  UGOKI_LATE = 2,     /* read by `advance` only; a feedback loop through this input therefore needs no delay */
  UGOKI_MULTIPLE = 4  /* takes any number of wires, also none; such inputs are declared after all others */
};

/* An input pin. */
typedef struct ugoki_input {
  uint32_t size;
  uint32_t type;           /* enum ugoki_type */
  uint32_t flags;          /* enum ugoki_input_flag, or-ed together */
  uint32_t count;          /* elements; 0: the fixed number of the type, or as many as the connected output has */
  const char* name;        /* 1 to 100 characters, unique among the inputs; spaces are allowed, '.' is not */
  const char* unit;        /* for example "N m"; null: none */
  const char* doc;         /* one sentence; null: none */
  double value;            /* default of an optional input without wire; finite */
  double minimum, maximum; /* intended range; a value set in place of a wire must be inside it. Equal bounds: no range */
} ugoki_input;

enum ugoki_output_flag { UGOKI_DELAYED = 1 /* written by `advance`; all consumers see the new value from the next tick on */ };

/* An output pin. Outputs without UGOKI_DELAYED are written by `step` and are seen in the same tick. */
typedef struct ugoki_output {
  uint32_t size;
  uint32_t type;           /* enum ugoki_type */
  uint32_t flags;          /* enum ugoki_output_flag */
  uint32_t count;          /* elements; 0: the fixed number of the type, or as many as the input named by `like` */
  const char* name;        /* 1 to 100 characters, unique among the outputs; spaces are allowed, '.' is not */
  const char* unit;        /* for example "N m"; null: none */
  const char* doc;         /* one sentence; null: none */
  double minimum, maximum; /* expected range of the values, for plots. Equal bounds: unknown */
  uint32_t like;           /* i + 1: the output has as many elements as input i; 0: see `count` */
  uint32_t reserved;
} ugoki_output;

enum ugoki_parameter_kind {
  UGOKI_NUMBER = 0,
  UGOKI_INTEGER = 1,
  UGOKI_BOOLEAN = 2,
  UGOKI_TEXT = 3,
  UGOKI_CHOICE = 4, /* one word of a list */
  UGOKI_VECTOR3 = 5
};
enum ugoki_parameter_flag { UGOKI_FIXED = 1 /* cannot be changed while the circuit runs; text parameters never can */ };

/* A parameter: a value that the user sets in the inspector and that is saved with the circuit. */
typedef struct ugoki_parameter {
  uint32_t size;
  uint32_t kind;              /* enum ugoki_parameter_kind */
  uint32_t flags;             /* enum ugoki_parameter_flag */
  uint32_t choice_count;      /* number of `choices` */
  const char* name;           /* 1 to 100 characters, unique among the parameters; spaces are allowed, '.' is not */
  const char* unit;           /* for example "N/m"; null: none */
  const char* doc;            /* one sentence; null: none */
  double initial[3];          /* number, integer: initial[0]; boolean: initial[0] is 0 or 1; choice: initial[0] is an index into `choices`;
                                 vector: all three; text: not used */
  double minimum, maximum;    /* allowed range of numbers, integers and components of vectors. Equal bounds: any value */
  const char* const* choices; /* [choice_count] words of a choice */
  const char* text;           /* initial value of a text; null: empty */
} ugoki_parameter;

/* Type of the numbers of a field of the state, named by kind and bits: F floating-point, I signed and U unsigned integers. */
enum ugoki_field_type {
  UGOKI_F64 = 1,
  UGOKI_F32 = 2,
  UGOKI_I64 = 3,
  UGOKI_I32 = 4,
  UGOKI_U64 = 5,
  UGOKI_U32 = 6,
  UGOKI_I8 = 7,
  UGOKI_U8 = 8
};

/* A number, or an array of numbers, within the state. The host shows declared fields to the user. When the library is rebuilt with another
 * layout of the state while a circuit runs, declared fields keep their values by name. */
typedef struct ugoki_field {
  uint32_t size;
  uint32_t type;    /* enum ugoki_field_type */
  uint32_t offset;  /* bytes from the start of the state */
  uint32_t count;   /* elements; 0 means 1 */
  const char* name; /* 1 to 100 characters, unique among the fields, without '.' */
  const char* unit; /* for example "rad/s"; null: none */
  const char* doc;  /* one sentence; null: none */
  double initial;   /* first value of every element */
} ugoki_field;

/* Argument of `create`. The host owns it; nothing in it is valid after `create` returns. */
typedef struct ugoki_setup {
  uint32_t size;
  uint32_t reason_size;      /* bytes of `reason` */
  double dt;                 /* s: time between two runs of the LSI, as in ugoki_tick */
  const double* parameters;  /* as ugoki_call.parameters */
  const char* const* texts;  /* text parameters in the order of declaration */
  const uint32_t* in_count;  /* [inputs] elements of the first wire of each input; 0: no wire */
  const uint32_t* out_count; /* [outputs] elements of each output */
  char* reason;              /* [reason_size] a `create` that returns null writes a zero-terminated sentence here */
} ugoki_setup;

/* One kind of LSI. At least one of `step` and `advance` must be set; the other functions may be null.
 *
 * Order of the calls: `create` once when the circuit is built. Then, at the start and at each reset, the host sets the state to zero,
 * writes `initial` of each field into it, and calls `init`. In each tick it calls `step` of all LSIs, in the order of the wires, and then
 * `advance` of all LSIs. `destroy` is the last call. */
typedef struct ugoki_class {
  uint32_t size;
  uint32_t version;  /* version of the state's layout and meaning; increase it to prevent that older saved states are restored */
  const char* name;  /* for example "spring damper": 1 to 100 characters, unique in the library, without '.' and '/' */
  const char* doc;   /* one or two sentences */
  const char* group; /* heading under which a search lists the LSI, for example "signal"; null: the library's name */
  const ugoki_input* inputs;
  const ugoki_output* outputs;
  const ugoki_parameter* parameters;
  const ugoki_field* fields;
  uint32_t input_count, output_count, parameter_count, field_count;
  uint64_t state_size;                 /* bytes, at most 64 MiB */
  ugoki_step_function init;            /* sets the first state and the first values of delayed outputs */
  ugoki_step_function step;            /* reads the inputs that are not late and writes the outputs that are not delayed */
  ugoki_step_function advance;         /* reads all inputs, computes the next state and writes the delayed outputs */
  void* (*create)(const ugoki_setup*); /* makes an object for data that cannot be plain bytes; null result: error, see ugoki_setup.reason */
  void (*destroy)(void* object);       /* frees the object of `create` */
  void (*store)(const ugoki_call*);    /* copies the memory of `object` into `state`; called before the host saves the state */
  void (*recall)(const ugoki_call*);   /* copies the memory of `object` from `state`; called after the host has restored the state */
} ugoki_class;

/* A library of LSIs. */
typedef struct ugoki_library {
  uint32_t size;
  uint32_t abi;        /* UGOKI_LSI_ABI */
  const char* name;    /* 1 to 64 letters, digits, '-' and '_'; circuits name an LSI "library/lsi" */
  const char* version; /* for example "1.2"; null: none */
  const char* doc;     /* one or two sentences; null: none */
  const ugoki_class* const* classes;
  uint32_t class_count;
  uint32_t reserved;
} ugoki_library;

#if defined(__GNUC__)
#define UGOKI_EXPORT __attribute__((visibility("default")))
#else
#define UGOKI_EXPORT
#endif

/* A text in the section ".ugoki.lsi" of the library's file: "library NAME" or "lsi NAME". The host shows these names before the user has
 * consented to load the library. They are optional. */
#if defined(__GNUC__) && defined(__ELF__)
#define UGOKI_MANIFEST(variable, text) __attribute__((section(".ugoki.lsi"), used)) static const char variable[] = text;
#else
#define UGOKI_MANIFEST(variable, text)
#endif

/* The only function that a library exports. Returns the description of the library, which stays valid while the library is loaded. */
UGOKI_EXPORT const ugoki_library* ugoki_lsi_library(void);

/* Stops the circuit with a sentence: copies `why` (cut to reason_size) into call->reason and returns 1.
 *   if (length > 2) return ugoki_stop(call, "The spring broke."); */
static inline int32_t ugoki_stop(const ugoki_call* call, const char* why) {
  uint32_t i = 0;
  for (; i + 1 < call->reason_size && why[i] != '\0'; ++i) call->reason[i] = why[i];
  if (call->reason_size > 0) call->reason[i] = '\0';
  return 1;
}

#ifdef __cplusplus
}
#endif

#endif /* UGOKI_LSI_H */
