#include "ugoki/plugin/guard_block.h"

#include <sys/mman.h>

#include <algorithm>
#include <cstring>
#include <new>

namespace ugoki::plugin {
namespace {

/// Activity::announce: notes the name of an LSI of a library.
void note_lsi(const circuit::RunningLsi& lsi) {
  GuardBlock& block = guard_block();
  const std::uint32_t n = block.count.load();
  std::uint32_t i = 0;
  while (i < n && block.lsis[i].address != &lsi) ++i;
  const bool foreign = !lsi.lsi_class->from.empty();
  if (i == GuardBlock::max_lsis || (i == n && !foreign)) return;
  block.lsis[i].text[0] = '\0';
  if (foreign) describe_lsi(lsi, block.lsis[i].text);
  block.lsis[i].address = &lsi;
  if (i == n) block.count = n + 1;
}

GuardBlock* make_block() {
  void* memory = ::mmap(nullptr, sizeof(GuardBlock), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  auto* block = memory == MAP_FAILED ? new GuardBlock : new (memory) GuardBlock;
  block->activity.announce = note_lsi;
  return block;
}

}  // namespace

GuardBlock& guard_block() {
  static GuardBlock* const block = make_block();
  return *block;
}

void clear_guard_block() {
  GuardBlock& block = guard_block();
  set_running(block.activity, nullptr);
  block.phase_number = 0;
  block.count = 0;
}

std::size_t describe_known_lsis(char* buffer, std::size_t size) {
  const GuardBlock& block = guard_block();
  std::size_t used = 0;
  const auto add = [&](const char* text) {
    const std::size_t n = std::min(std::strlen(text), size - used);
    std::memcpy(buffer + used, text, n);
    used += n;
  };
  int shown = 0;
  for (std::uint32_t i = 0; i < block.count.load() && shown < 4; ++i) {
    if (block.lsis[i].text[0] == '\0') continue;
    if (shown++ > 0) add(", ");
    add(block.lsis[i].text);
  }
  return used;
}

}  // namespace ugoki::plugin
