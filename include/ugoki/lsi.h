/* Software LSIs for Ugoki: the binary interface between the host and a library of LSIs. C11 and C++.
 *
 * A library exports one function, ugoki_lsi_library, which describes its LSIs by constant tables. `ugoki lsi build FILE` writes all of this
 * for plain functions, and <ugoki/lsi.hpp> for C++ structs; by hand it is written once for each LSI. docs/lsi.md tells more.
 *
 * How it stays compatible: every struct begins with its own `size` in bytes; fields are only ever added at the end; numbers of types,
 * kinds and flags never change. So a host reads older and newer libraries, and a library that asks UGOKI_HAS before it uses a field
 * that was added later runs under older hosts. UGOKI_LSI_ABI changes only when that is broken; a host refuses other values.
 *
 * Rules for the functions: no exceptions out of them; no threads that outlive the call; the same inputs give the same outputs; what an
 * LSI remembers lies in `state` (plain bytes, saved and restored by the host) and nowhere else. Zero is always a good default here.
 */
#ifndef UGOKI_LSI_H
#define UGOKI_LSI_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#define UGOKI_LSI_ABI 1u

/* True if the struct that `p` points to has the field. */
#define UGOKI_HAS(p, field) ((p)->size >= (size_t)((const char*)(&(p)->field + 1) - (const char*)(p)))

/* What flows through a wire. Payloads are arrays of double unless said otherwise. */
enum ugoki_type {
  UGOKI_SCALAR = 1,       /* 1 number */
  UGOKI_VECTOR = 2,       /* x, y, z */
  UGOKI_ROTATION = 3,     /* unit quaternion w, x, y, z */
  UGOKI_POSE = 4,         /* position x, y, z [m], unit quaternion w, x, y, z */
  UGOKI_JOINT_VALUES = 5, /* a number for each coordinate or freedom of one mechanism */
  UGOKI_STATE = 6,        /* q and v of every mechanism of the world */
  UGOKI_CONTACTS = 7,     /* uint64_t number of records, then records of 128 bytes */
  UGOKI_MOTION = 8,       /* a reference: q, v, a and stance of one mechanism */
  UGOKI_EVENT = 9         /* uint64_t number of records, then records of 128 bytes */
};

/* The moment for which a tick computes. */
typedef struct ugoki_tick {
  uint32_t size;
  uint32_t reserved;
  double time;    /* s, index * dt */
  double dt;      /* s */
  uint64_t index; /* ticks done before this one */
} ugoki_tick;

/* What the functions of an LSI get: addresses that stay the same while the circuit runs. */
typedef struct ugoki_call {
  uint32_t size;
  uint32_t reason_size;      /* bytes of `reason` */
  const void* const* in;     /* payload of every wire; input i is in[in_first[i]] (in[i] while no earlier input is UGOKI_MULTIPLE);
                                an input without wire has its value; an input of open size without wire is null */
  void* const* out;          /* [outputs] payloads to write */
  const uint32_t* in_first;  /* [inputs + 1] */
  const uint32_t* in_count;  /* elements of each payload of `in` */
  const uint32_t* out_count; /* [outputs] elements */
  const double* parameters;  /* in the order of declaration: numbers, booleans 0 or 1, choices their index, vectors 3 numbers; texts have none */
  void* state;               /* state_size bytes; null if that is 0 */
  void* object;              /* what `create` returned */
  const ugoki_tick* tick;
  char* reason; /* where a function that returns non-zero says why: a sentence, zero-terminated */
} ugoki_call;

/* 0: done. Anything else stops the circuit, which then names the LSI, the time and `reason`. */
typedef int32_t (*ugoki_step_function)(const ugoki_call*);

enum ugoki_input_flag {
  UGOKI_OPTIONAL = 1, /* runs without a wire: then it has `value` (rotations and poses: the identity) */
  UGOKI_LATE = 2,     /* read by `advance` only, so that feedback through this input needs no delay */
  UGOKI_MULTIPLE = 4  /* takes any number of wires; after all other inputs */
};

typedef struct ugoki_input {
  uint32_t size;
  uint32_t type;           /* enum ugoki_type */
  uint32_t flags;          /* enum ugoki_input_flag */
  uint32_t count;          /* elements; 0: those of the type, or of what is wired to it */
  const char* name;        /* may hold spaces, no point */
  const char* unit;        /* "N m"; null: none */
  const char* doc;         /* a sentence; null: none */
  double value;            /* of an optional input without wire */
  double minimum, maximum; /* what it is meant for; equal: any number */
} ugoki_input;

enum ugoki_output_flag { UGOKI_DELAYED = 1 /* written by `advance`, seen by all consumers from the next tick on */ };

typedef struct ugoki_output {
  uint32_t size;
  uint32_t type;
  uint32_t flags; /* enum ugoki_output_flag */
  uint32_t count; /* elements; 0: those of the type, or as `like` says */
  const char* name;
  const char* unit;
  const char* doc;
  double minimum, maximum; /* what it usually lies between: for plots; equal: unknown */
  uint32_t like;           /* i + 1: as many elements as input i has; 0: see count */
  uint32_t reserved;
} ugoki_output;

enum ugoki_parameter_kind {
  UGOKI_NUMBER = 0,
  UGOKI_INTEGER = 1,
  UGOKI_BOOLEAN = 2,
  UGOKI_TEXT = 3,
  UGOKI_CHOICE = 4,
  UGOKI_VECTOR3 = 5
};
enum ugoki_parameter_flag { UGOKI_FIXED = 1 /* may not be changed while the circuit runs; texts never may */ };

typedef struct ugoki_parameter {
  uint32_t size;
  uint32_t kind;              /* enum ugoki_parameter_kind */
  uint32_t flags;             /* enum ugoki_parameter_flag */
  uint32_t choice_count;      /* of a choice */
  const char* name;           /* may hold spaces, no point */
  const char* unit;
  const char* doc;
  double initial[3];          /* boolean: 0 or 1; choice: index; vector: 3 numbers; text: see text */
  double minimum, maximum;    /* refused outside; equal: any number */
  const char* const* choices; /* [choice_count] words of a choice */
  const char* text;           /* initial of a text; null: empty */
} ugoki_parameter;

enum ugoki_field_type { UGOKI_F64 = 1, UGOKI_F32 = 2, UGOKI_I64 = 3, UGOKI_I32 = 4, UGOKI_U64 = 5, UGOKI_U32 = 6, UGOKI_I8 = 7, UGOKI_U8 = 8 };

/* A number (or an array of numbers) in the state. Declared fields are shown, and keep their values when a library is rebuilt. */
typedef struct ugoki_field {
  uint32_t size;
  uint32_t type;   /* enum ugoki_field_type */
  uint32_t offset; /* bytes into the state */
  uint32_t count;  /* elements; 0: 1 */
  const char* name;
  const char* unit;
  const char* doc;
  double initial; /* every element at the start */
} ugoki_field;

/* What `create` gets. */
typedef struct ugoki_setup {
  uint32_t size;
  uint32_t reason_size;
  double dt;                 /* s */
  const double* parameters;  /* as in a call */
  const char* const* texts;  /* text parameters in the order of declaration */
  const uint32_t* in_count;  /* [inputs] elements of the first wire of each; 0: no wire */
  const uint32_t* out_count; /* [outputs] */
  char* reason;              /* said by a `create` that returns null */
} ugoki_setup;

/* One kind of LSI. */
typedef struct ugoki_class {
  uint32_t size;
  uint32_t version;  /* of the meaning of its state: raise it where a rebuilt library must start afresh */
  const char* name;  /* "spring damper": unique among all that is installed */
  const char* doc;   /* a sentence or two */
  const char* group; /* where a search lists it, for example "signal"; null: under the library's name */
  const ugoki_input* inputs;
  const ugoki_output* outputs;
  const ugoki_parameter* parameters;
  const ugoki_field* fields;
  uint32_t input_count, output_count, parameter_count, field_count;
  uint64_t state_size;         /* bytes, at most 64 MB; zeroed, then set from fields, then init is called */
  ugoki_step_function init;    /* sets the first state and the first values of delayed outputs; at the start and at each reset; may be null */
  ugoki_step_function step;    /* reads inputs that are not late, writes outputs that are not delayed; may be null */
  ugoki_step_function advance; /* after all steps of a tick: reads all inputs, moves the state on, writes delayed outputs; may be null */
  void* (*create)(const ugoki_setup*); /* what does not fit into plain bytes; null result: refused; may be null */
  void (*destroy)(void* object);
  void (*store)(const ugoki_call*);  /* for an object that remembers: moves what it remembers to `state` before a save ... */
  void (*recall)(const ugoki_call*); /* ... and from it after a restore; may be null */
} ugoki_class;

/* All that a library has. */
typedef struct ugoki_library {
  uint32_t size;
  uint32_t abi;        /* UGOKI_LSI_ABI */
  const char* name;    /* letters, digits, '-', '_' */
  const char* version; /* "1.2"; null: none */
  const char* doc;
  const ugoki_class* const* classes;
  uint32_t class_count;
  uint32_t reserved;
} ugoki_library;

#if defined(__GNUC__)
#define UGOKI_EXPORT __attribute__((visibility("default")))
#else
#define UGOKI_EXPORT
#endif

/* The one function that a library exports. */
UGOKI_EXPORT const ugoki_library* ugoki_lsi_library(void);

/* return ugoki_stop(call, "The spring broke."); */
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
