#include "fmu_binary.h"

asm(R"(
  .section .rodata
  .balign 16
ugoki_fmu_begin:
  .incbin ")" UGOKI_FMU_BINARY R"("
ugoki_fmu_end:
  .previous
)");

extern "C" {
extern const char ugoki_fmu_begin[] __attribute__((visibility("hidden")));
extern const char ugoki_fmu_end[] __attribute__((visibility("hidden")));
}

namespace ugoki::cli {

std::string_view fmu_binary() { return {ugoki_fmu_begin, static_cast<std::size_t>(ugoki_fmu_end - ugoki_fmu_begin)}; }

}  // namespace ugoki::cli
