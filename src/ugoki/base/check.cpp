#include "ugoki/base/check.h"

#include <cstdio>
#include <cstdlib>

namespace ugoki {

void check_failed(const char* condition, const char* file, int line) {
  std::fprintf(stderr, "ugoki: internal error: check failed: %s (%s:%d)\n", condition, file, line);
  std::abort();
}

}  // namespace ugoki
