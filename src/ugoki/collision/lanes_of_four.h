#pragma once
// Vectors of four doubles, as a compiler extension: two registers of SSE2, one of AVX2, scalar code on other processors. Results have
// the same bits in all cases.

#include <cstdint>

namespace ugoki::collision {

typedef double Four __attribute__((vector_size(32)));
typedef std::int64_t FourInts __attribute__((vector_size(32)));

}  // namespace ugoki::collision
