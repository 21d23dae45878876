#include "ugoki/mechanism/loop.h"

#include <algorithm>

namespace ugoki {
namespace {

struct LoopTypeEntry {
  LoopType type;
  int rows, position_rows;
  std::string_view name;
};
constexpr LoopTypeEntry loop_types[] = {
    {LoopType::weld, 6, 3, "weld"},
    {LoopType::ball, 3, 3, "ball"},
    {LoopType::revolute, 5, 3, "revolute"},
    {LoopType::prismatic, 5, 2, "prismatic"},
    {LoopType::cylindrical, 4, 2, "cylindrical"},
    {LoopType::planar, 3, 1, "planar"},
    {LoopType::universal, 4, 3, "universal"},
    {LoopType::distance, 1, 1, "distance"},
    {LoopType::gear, 1, 1, "gear"},
};

}  // namespace

int row_count(LoopType type) { return loop_types[static_cast<std::size_t>(type)].rows; }
int position_row_count(LoopType type) { return loop_types[static_cast<std::size_t>(type)].position_rows; }
std::string_view name_of(LoopType type) { return loop_types[static_cast<std::size_t>(type)].name; }
std::optional<LoopType> loop_type_named(std::string_view name) {
  const auto* const it = std::ranges::find(loop_types, name, &LoopTypeEntry::name);
  if (it == std::end(loop_types)) return std::nullopt;
  return it->type;
}

}  // namespace ugoki
