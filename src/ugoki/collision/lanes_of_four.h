#pragma once
// Four doubles side by side, as the compiler knows them: two registers of SSE2, one of AVX2, plain numbers elsewhere; the same bits.

#include <cstdint>

namespace ugoki::collision {

typedef double Four __attribute__((vector_size(32)));
typedef std::int64_t FourInts __attribute__((vector_size(32)));

}  // namespace ugoki::collision
