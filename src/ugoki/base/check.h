#pragma once
// Checks of internal invariants. Invalid data from outside must be reported with result.h instead and must not reach these checks.

namespace ugoki {
/// Prints the failed condition with its source location to stderr and aborts the program.
[[noreturn]] void check_failed(const char* condition, const char* file, int line);
}  // namespace ugoki

/// Aborts the program if `condition` is false, in every build. For conditions that are cheap to evaluate.
#define UGOKI_CHECK(condition)                               \
  do {                                                       \
    if (!(condition)) [[unlikely]]                           \
      ::ugoki::check_failed(#condition, __FILE__, __LINE__); \
  } while (false)

/// Like UGOKI_CHECK, but only in builds without NDEBUG; otherwise `condition` is not evaluated.
#ifdef NDEBUG
#define UGOKI_ASSERT(condition) ((void)0)
#else
#define UGOKI_ASSERT(condition) UGOKI_CHECK(condition)
#endif
