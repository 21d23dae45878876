#include "ugoki/fmi/group.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <type_traits>

namespace ugoki::fmi {
namespace {

/// Calls `visit` with a zero of the C++ type for a storage type, so that `visit` can use this type.
template <class Visit>
auto with_type(Storage storage, Visit visit) {
  switch (storage) {
    case Storage::f64: return visit(double{});
    case Storage::f32: return visit(float{});
    case Storage::i8: return visit(std::int8_t{});
    case Storage::u8: return visit(std::uint8_t{});
    case Storage::i16: return visit(std::int16_t{});
    case Storage::u16: return visit(std::uint16_t{});
    case Storage::i32: return visit(std::int32_t{});
    case Storage::u32: return visit(std::uint32_t{});
    case Storage::i64: return visit(std::int64_t{});
    case Storage::u64: return visit(std::uint64_t{});
    case Storage::b8:
    case Storage::b32: break;
  }
  return visit(bool{});
}

}  // namespace

bool write(Storage storage, double x, std::byte* to) {
  if (storage == Storage::b32) {
    const int yes = x > 0;
    std::memcpy(to, &yes, sizeof yes);
    return true;
  }
  return with_type(storage, [&]<class T>(T) {
    if constexpr (std::is_same_v<T, bool>) {
      const bool yes = x > 0;
      std::memcpy(to, &yes, sizeof yes);
    } else {
      double y = x;
      if constexpr (std::is_integral_v<T>) {
        y = std::floor(x + 0.5);
        if (!(y >= static_cast<double>(std::numeric_limits<T>::min()) && y < std::ldexp(1.0, std::numeric_limits<T>::digits))) return false;
      } else if constexpr (std::is_same_v<T, float>) {
        if (!(std::fabs(x) <= static_cast<double>(std::numeric_limits<float>::max()))) return false;
      }
      const T value = static_cast<T>(y);
      std::memcpy(to, &value, sizeof value);
    }
    return true;
  });
}

double read(Storage storage, const std::byte* from) {
  if (storage == Storage::b8) return *from != std::byte{0} ? 1.0 : 0.0;
  if (storage == Storage::b32) {
    int yes = 0;
    std::memcpy(&yes, from, sizeof yes);
    return yes != 0 ? 1.0 : 0.0;
  }
  return with_type(storage, [&]<class T>(T value) {
    std::memcpy(&value, from, sizeof value);
    return static_cast<double>(value);
  });
}

std::vector<Group> group(const std::vector<PinBinding>& pins) {
  std::vector<Group> out;
  for (const PinBinding& p : pins) {
    auto at = std::find_if(out.begin(), out.end(), [&](const Group& g) { return g.storage == p.storage; });
    if (at == out.end()) at = out.insert(out.end(), Group{p.storage, {}, {}, {}, {}, 0});
    at->references.push_back(p.reference);
    at->pins.push_back(p);
    at->count += p.count;
  }
  for (Group& g : out) {
    g.memory.resize(g.size() / 8 + 1);
    g.given.resize(g.memory.size());
  }
  return out;
}

}  // namespace ugoki::fmi
