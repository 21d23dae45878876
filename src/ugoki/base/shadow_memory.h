#pragma once

namespace ugoki {

/// Built with a sanitizer whose shadow memory takes terabytes of addresses: no limit on memory can then be set.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
inline constexpr bool has_shadow_memory = true;
#elif defined(__has_feature)
inline constexpr bool has_shadow_memory = __has_feature(address_sanitizer) || __has_feature(thread_sanitizer);
#else
inline constexpr bool has_shadow_memory = false;
#endif

}  // namespace ugoki
