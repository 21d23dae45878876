#pragma once

namespace ugoki {

/// True if the program is built with a sanitizer whose shadow memory reserves terabytes of address space. In such a program, a limit
/// on the address space (RLIMIT_AS) must not be set.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
inline constexpr bool has_shadow_memory = true;
#elif defined(__has_feature)
inline constexpr bool has_shadow_memory = __has_feature(address_sanitizer) || __has_feature(thread_sanitizer);
#else
inline constexpr bool has_shadow_memory = false;
#endif

}  // namespace ugoki
