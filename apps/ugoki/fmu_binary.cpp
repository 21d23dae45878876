#include "fmu_binary.h"

asm(R"(
  .section .rodata
  .balign 16
ugoki_fmu_begin:
  .incbin ")" UGOKI_FMU_BINARY R"("
ugoki_fmu_end:
  .balign 16
ugoki_fmu_content_begin:
  .incbin ")" UGOKI_FMU_CONTENT_BINARY R"("
ugoki_fmu_content_end:
  .previous
)");

#define UGOKI_HIDDEN __attribute__((visibility("hidden")))
extern "C" {
extern const char ugoki_fmu_begin[] UGOKI_HIDDEN, ugoki_fmu_end[] UGOKI_HIDDEN;
extern const char ugoki_fmu_content_begin[] UGOKI_HIDDEN, ugoki_fmu_content_end[] UGOKI_HIDDEN;
}

namespace ugoki::cli {

std::string_view fmu_binary(bool all_lsis) {
  return all_lsis ? std::string_view(ugoki_fmu_content_begin, ugoki_fmu_content_end) : std::string_view(ugoki_fmu_begin, ugoki_fmu_end);
}

}  // namespace ugoki::cli
