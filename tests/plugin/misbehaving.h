#pragma once
// LSIs that misbehave: they crash, end or stop their process or its parent, hang, damage memory, return values that are not finite, or
// cannot be loaded. Tests run each one with `ugoki lsi test`, `ugoki circuit run` and in the studio.

#include <array>
#include <string>
#include <string_view>

namespace ugoki::plugin {

/// An LSI `double f(double t, double y[3])` of the library "rogue". It misbehaves when the time t is above 0.015 s.
struct Misbehaving {
  std::string_view name;         ///< for messages of tests
  std::string_view body;         ///< statements that run when t is above 0.015 s
  std::string_view report;       ///< part of the message that the user must see
  std::string_view before = {};  ///< declarations before the function
  bool cpp = false;              ///< the source is C++
};

inline constexpr std::array misbehaving = {
    // Invalid memory accesses and arithmetic.
    Misbehaving{"reads null", "y[0] = *(volatile double*)0;", "used a null pointer"},
    Misbehaving{"writes null", "*(volatile int*)8 = 1;", "used a null pointer"},
    Misbehaving{"calls null", "((double (*)(void))nowhere)();", "used a null pointer", "static void* volatile nowhere = 0;"},
    Misbehaving{"wild pointer", "*(volatile double*)0x7fff00000000ull = t;", "accessed memory that it does not own"},
    Misbehaving{"writes code", "*(volatile char*)(unsigned long)puts = 0;", "accessed memory that it does not own"},
    Misbehaving{"divides by zero", "y[0] = 7 / zero;", "divided an integer by zero", "static volatile int zero = 0;"},
    Misbehaving{"traps", "__builtin_trap();", "invalid instruction"},
    Misbehaving{"mapped file without bytes", "y[0] = *(volatile double*)mmap(0, 4096, PROT_READ, MAP_SHARED, fileno(tmpfile()), 0);",
                "accessed memory that does not exist (SIGBUS)"},
    Misbehaving{"endless recursion", "y[0] = deep(t);", "accessed memory that it does not own",
                "static double deep(double x) { volatile char room[100000]; room[0] = (char)x; return deep(x + room[0]) + room[0]; }"},
    Misbehaving{"no memory", "double* volatile p = malloc((size_t)1 << 60); p[0] = t;", "used a null pointer"},
    // Ends of the process.
    Misbehaving{"aborts", "abort();", "aborted"},
    Misbehaving{"failed assertion", "assert(t < 0);", "aborted", "#include <assert.h>"},
    Misbehaving{"exits", "exit(0);", "ended the process (exit)"},
    Misbehaving{"exits quickly", "_exit(0);", "ended its process (exit status 0) without a report"},
    Misbehaving{"exits with the status of a crash", "_exit(70);", "ended its process (exit status 70) without a report"},
    Misbehaving{"kills itself", "raise(SIGKILL);", "ended its process (signal 9, Killed) without a report"},
    Misbehaving{"signal without handler", "raise(SIGUSR1);", "ended its process (signal 10, User defined signal 1) without a report"},
    Misbehaving{"restores the handler and crashes", "signal(SIGSEGV, SIG_DFL); *(volatile int*)0 = 1;",
                "ended its process (signal 11, Segmentation fault) without a report"},
    Misbehaving{"runs another program", "execl(\"/bin/true\", \"true\", (char*)0);", "without a report"},
    Misbehaving{"runs a long program", "execl(\"/bin/sleep\", \"sleep\", \"1000\", (char*)0);",
                "replaced its process by another program (exec), which was ended without a report"},
    Misbehaving{"closes all files and exits", "for (int i = 3; i < 1024; ++i) close(i); _exit(0);",
                "ended its process (exit status 0) without a report"},
    Misbehaving{"closes all files and crashes", "for (int i = 3; i < 1024; ++i) close(i); abort();", "without a report"},
    Misbehaving{"leaves a sleeper and exits", "if (fork() == 0) { sleep(1000); _exit(0); } _exit(0);",
                "ended its process (exit status 0) without a report"},
    Misbehaving{"stops itself", "raise(SIGSTOP);", "stopped its process (SIGSTOP)"},
    // Signals to the program that runs the LSI.
    Misbehaving{"kills its parent", "kill(getppid(), SIGKILL);", "tried to send a signal to the process of Ugoki"},
    Misbehaving{"ends its parent", "kill(getppid(), SIGTERM);", "tried to send a signal to the process of Ugoki"},
    Misbehaving{"signals its process group", "kill(0, SIGUSR1);", "tried to send a signal to the process of Ugoki"},
    Misbehaving{"signals its parent by a file",
                "syscall(424, syscall(434, getppid(), 0), SIGTERM, 0, 0);",  // pidfd_send_signal, pidfd_open
                "tried to send a signal to the process of Ugoki"},
    // Hangs.
    Misbehaving{"endless loop", "for (;;) __asm__ volatile(\"\");", "did not return within"},
    Misbehaving{"sleeps", "sleep(1000);", "did not return within"},
    Misbehaving{"deadlock", "static pthread_mutex_t m = PTHREAD_MUTEX_INITIALIZER; pthread_mutex_lock(&m); pthread_mutex_lock(&m);",
                "did not return within"},
    Misbehaving{"ends the main thread", "pthread_exit(0);", "ended the main thread of its process (pthread_exit)"},
    // Faults in threads of the library.
    Misbehaving{"crash in a thread", "pthread_t p; pthread_create(&p, 0, fault, 0); pthread_join(p, 0);",
                "A thread of the library 'rogue' used a null pointer", "static void* fault(void* p) { *(volatile int*)0 = 1; return p; }"},
    Misbehaving{"exit in a thread", "pthread_t p; pthread_create(&p, 0, leave, 0); pthread_join(p, 0);",
                "ended its process (exit status 3) without a report", "static void* leave(void* p) { _exit(3); return p; }"},
    // Damage of the heap.
    Misbehaving{"frees twice", "char* volatile p = malloc(5000); free(p); free(p);", "aborted"},
    Misbehaving{"frees foreign memory", "static double room[8]; void* volatile p = &room[1]; free(p);", "aborted"},
    Misbehaving{"writes before its block", "volatile char* p = malloc(100); for (int i = -16; i < 0; ++i) p[i] = 1; free((void*)p);",
                "aborted"},
    Misbehaving{"writes after its block",
                "volatile char* p = malloc(5000); for (int i = 0; i < 6000; ++i) p[i] = 0x7f; free(malloc(300000)); "
                "for (int i = 1; i < 3000; ++i) free(malloc(i)); free((void*)p);",
                "aborted"},
    // Writes beyond its pins and values that are not finite.
    Misbehaving{"writes after its output", "((volatile double*)y)[3] = t;", "It wrote beyond its output 'y', which has 3 numbers."},
    Misbehaving{"writes far after its output", "for (long i = 0; i < 400000000; ++i) ((volatile double*)y)[i] = t;",
                "accessed memory that it does not own"},
    Misbehaving{"not a number", "y[1] = NAN;", "of its output 'y' is not finite"},
    Misbehaving{"infinity", "y[2] = INFINITY;", "of its output 'y' is not finite"},
    // Changes of the floating-point mode.
    Misbehaving{"rounds upwards", "fesetround(FE_UPWARD);", "changed the floating-point mode", "#include <fenv.h>"},
    Misbehaving{"drops subnormal numbers", "_mm_setcsr(_mm_getcsr() | 0x8040);", "changed the floating-point mode",
                "#include <immintrin.h>"},
    // Exceptions of C++.
    Misbehaving{"throws an exception", "throw std::runtime_error(\"No rope\");", "No rope", "#include <stdexcept>", true},
    Misbehaving{"throws a number", "throw 42;", "rogue", "", true},
    Misbehaving{"throws where it must not", "cannot();", "aborted", "static void cannot() noexcept { throw 1; }", true},
};
static_assert(misbehaving.size() == 47);

/// Source text of the library "rogue" with the LSI `f`.
inline std::string rogue_source(const Misbehaving& m) {
  return "#define _GNU_SOURCE\n#include <math.h>\n#include <pthread.h>\n#include <signal.h>\n#include <stdio.h>\n#include <stdlib.h>\n"
         "#include <sys/mman.h>\n#include <unistd.h>\n" +
         std::string(m.before) + "\n/// @library rogue\ndouble f(double t, double y[3]) {\n  y[0] = t;\n  if (t > 0.015) { " +
         std::string(m.body) + " }\n  return t;\n}\n";
}

/// Library sources whose code misbehaves while it is loaded, and a part of the message that the user must see.
struct MisbehavingLoad {
  std::string_view name, source, report;
};
inline constexpr std::array misbehaving_while_loading = {
    MisbehavingLoad{"crashes",
                    "__attribute__((constructor)) static void early(void) { *(volatile int*)0 = 1; }\ndouble f(double t) { return t; }\n",
                    "was being loaded when it used a null pointer"},
    MisbehavingLoad{
        "hangs",
        "__attribute__((constructor)) static void early(void) { for (;;) __asm__ volatile(\"\"); }\ndouble f(double t) { return t; }\n",
        "was being loaded when it did not return within"},
    MisbehavingLoad{
        "exits",
        "#include <stdlib.h>\n__attribute__((constructor)) static void early(void) { exit(0); }\ndouble f(double t) { return t; }\n",
        "was being loaded when it"},
    MisbehavingLoad{
        "exits quickly",
        "#include <unistd.h>\n__attribute__((constructor)) static void early(void) { _exit(0); }\ndouble f(double t) { return t; }\n",
        "was being loaded when it ended its process (exit status 0) without a report"},
    MisbehavingLoad{
        "kills itself",
        "#include <signal.h>\n__attribute__((constructor)) static void early(void) { raise(SIGKILL); }\ndouble f(double t) { return t; }\n",
        "was being loaded when it ended its process (signal 9, Killed) without a report"},
    MisbehavingLoad{"missing function", "double elsewhere(double);\ndouble f(double t) { return elsewhere(t); }\n", "elsewhere"},
};

}  // namespace ugoki::plugin
