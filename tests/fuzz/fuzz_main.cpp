// One libFuzzer program for each target.
#include "fuzz_targets.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  ugoki::UGOKI_FUZZ_TARGET(data, size);
  return 0;
}
