#include "ugoki/plugin/guard_block.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <cstring>
#include <new>
#include <string_view>
#include <utility>

namespace ugoki::plugin {
namespace {

/// Function for Activity::announce: stores the name of an LSI of a library in the block.
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

GuardBlock* attached_block = nullptr;  // block set by attach_guard_block(); null: none

GuardBlock* make_block() {
  GuardBlock* block = attached_block;
  if (block == nullptr) {
    void* memory = ::mmap(nullptr, sizeof(GuardBlock), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    block = memory == MAP_FAILED ? new GuardBlock : new (memory) GuardBlock;
  }
  block->activity.announce = note_lsi;
  return block;
}

/// View of a text that an LSI may have overwritten, so that the terminating zero may be missing.
template <std::size_t size>
std::string_view text_in(const char (&text)[size]) {
  return {text, ::strnlen(text, size)};
}

}  // namespace

GuardBlock& guard_block() {
  static GuardBlock* const block = make_block();
  return *block;
}

bool attach_guard_block(int fd) {
  void* memory = ::mmap(nullptr, sizeof(GuardBlock), PROT_READ | PROT_WRITE, MAP_SHARED, fd, 0);
  if (memory == MAP_FAILED) return false;
  attached_block = new (memory) GuardBlock;
  return true;
}

void clear_guard_block() {
  GuardBlock& block = guard_block();
  set_running(block.activity, nullptr);
  block.phase_number = 0;
  block.count = 0;
}

std::size_t describe_known_lsis(const GuardBlock& block, char* buffer, std::size_t size) {
  std::size_t used = 0;
  const auto add = [&](std::string_view text) {
    const std::size_t n = std::min(text.size(), size - used);
    std::memcpy(buffer + used, text.data(), n);
    used += n;
  };
  // A rebuilt circuit adds its LSIs again, at other addresses; equal texts are one LSI.
  const auto seen = [&](std::uint32_t i, std::string_view text) {
    for (std::uint32_t k = 0; k < i; ++k)
      if (text_in(block.lsis[k].text) == text) return true;
    return false;
  };
  constexpr std::uint32_t max_shown = 4;
  std::uint32_t found = 0;
  const std::uint32_t count = std::min(block.count.load(), GuardBlock::max_lsis);
  for (std::uint32_t i = 0; i < count; ++i) {
    const std::string_view text = text_in(block.lsis[i].text);
    if (text.empty() || seen(i, text)) continue;
    if (++found > max_shown) continue;
    if (found > 1) add(", ");
    add(text);
  }
  if (found > max_shown) {
    char digits[16];
    add(" and ");
    add({digits, std::to_chars(digits, digits + sizeof digits, found - max_shown).ptr});
    add(" more");
  }
  return used;
}

Error missing_report(const GuardBlock& block, const std::string& how) {
  const char* const remedy = "Correct the LSI, rebuild it and restart the circuit.";
  const circuit::RunningLsi* running = running_of(block.activity);
  const std::uint32_t count = std::min(block.count.load(), GuardBlock::max_lsis);
  for (std::uint32_t i = 0; running && i < count; ++i) {
    const std::string who(text_in(block.lsis[i].text));
    if (block.lsis[i].address != running || who.empty()) continue;
    return Error(ErrorCode::structure, who.substr(1, who.find('\'', 1) - 1), who + " " + how + " without a report.", remedy);
  }
  if (block.phase_number.load() % 2 == 1)
    return Error(ErrorCode::structure, "library", std::string(text_in(block.phase)) + " when it " + how + " without a report.", remedy);
  char known[2048];
  const std::string names(known, describe_known_lsis(block, known, sizeof known));
  if (names.empty())
    return Error(ErrorCode::structure, "interpreter", "The process that runs the LSIs " + how + " without a report.", "Run it again.");
  return Error(ErrorCode::structure, "interpreter",
               "The process that runs the LSIs " + how +
                   " without a report. One of these LSIs of libraries ended it or closed its files: " + names + ".",
               remedy);
}

Result<GuardMemory> GuardMemory::make() {
  const auto failed = [](int fd) {
    if (fd >= 0) ::close(fd);
    return fail(ErrorCode::io, "interpreter", "No memory can be shared with the interpreter.", "Close some programs and try again.");
  };
  const int fd = ::memfd_create("ugoki-guard", MFD_CLOEXEC | MFD_ALLOW_SEALING);
  // The seals forbid that the child truncates the file, which would end the parent when it reads the block.
  if (fd < 0 || ::ftruncate(fd, sizeof(GuardBlock)) != 0 || ::fcntl(fd, F_ADD_SEALS, F_SEAL_SHRINK | F_SEAL_GROW | F_SEAL_SEAL) != 0)
    return failed(fd);
  void* memory = ::mmap(nullptr, sizeof(GuardBlock), PROT_READ, MAP_SHARED, fd, 0);
  if (memory == MAP_FAILED) return failed(fd);
  return GuardMemory(fd, static_cast<const GuardBlock*>(memory));
}

GuardMemory::GuardMemory(GuardMemory&& other) noexcept : fd_(std::exchange(other.fd_, -1)), block_(std::exchange(other.block_, nullptr)) {}

GuardMemory::~GuardMemory() {
  if (block_ != nullptr) ::munmap(const_cast<GuardBlock*>(block_), sizeof(GuardBlock));
  if (fd_ >= 0) ::close(fd_);
}

}  // namespace ugoki::plugin
