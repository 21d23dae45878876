#pragma once
// Checks of the programmer's own promises; data from outside never reaches them (see result.h).

namespace ugoki {
/// Prints the broken promise and ends the program.
[[noreturn]] void check_failed(const char* condition, const char* file, int line);
}  // namespace ugoki

/// Always on; use where it is cheap.
#define UGOKI_CHECK(condition)                               \
  do {                                                       \
    if (!(condition)) [[unlikely]]                           \
      ::ugoki::check_failed(#condition, __FILE__, __LINE__); \
  } while (false)

#ifdef NDEBUG
#define UGOKI_ASSERT(condition) ((void)0)
#else
#define UGOKI_ASSERT(condition) UGOKI_CHECK(condition)
#endif
