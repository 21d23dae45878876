#include "packed_picture.h"

#include <algorithm>

namespace ugoki::cli {

std::string unpacked_picture(std::string_view packed, std::size_t row, std::size_t size) {
  constexpr std::size_t block = 8;
  std::string out;
  out.reserve(size);
  const auto next_count = [&] {
    const std::size_t count = static_cast<unsigned char>(packed[0]) + 256u * static_cast<unsigned char>(packed[1]);
    packed.remove_prefix(2);
    return count;
  };
  while (out.size() + block <= size) {
    if (packed.size() < 4) return {};
    std::size_t equal = block * next_count();
    const std::size_t others = block * next_count();
    if (out.size() + equal + others > size || others > packed.size() || (equal > 0 && (row == 0 || out.size() < row))) return {};
    while (equal > 0) {  // a row at a time, because a row can repeat those that are only written here
      const std::size_t part = std::min(equal, row);
      out.append(out, out.size() - row, part);
      equal -= part;
    }
    out.append(packed.substr(0, others));
    packed.remove_prefix(others);
  }
  if (packed.size() != size - out.size()) return {};
  out.append(packed);
  return out;
}

}  // namespace ugoki::cli
