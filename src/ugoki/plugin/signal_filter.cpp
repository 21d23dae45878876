#include "ugoki/plugin/signal_filter.h"

#include <linux/audit.h>
#include <linux/filter.h>
#include <linux/seccomp.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cstddef>
#include <cstdint>
#include <iterator>

namespace ugoki::plugin {
namespace {

#if defined(__aarch64__)
constexpr std::uint32_t machine = AUDIT_ARCH_AARCH64;
#else
constexpr std::uint32_t machine = AUDIT_ARCH_X86_64;
#endif

/// Loads the 32-bit word at `offset` of the description of the system call (seccomp_data) into the accumulator.
constexpr sock_filter load(std::size_t offset) { return BPF_STMT(BPF_LD | BPF_W | BPF_ABS, static_cast<std::uint32_t>(offset)); }
/// Skips `yes` instructions if the accumulator is `value`, else `no` instructions.
constexpr sock_filter compare(std::uint32_t value, std::uint8_t yes, std::uint8_t no) {
  return BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, value, yes, no);
}

}  // namespace

bool forbid_signals_to_parent() {
  constexpr std::size_t number = offsetof(seccomp_data, nr);
  constexpr std::size_t target = offsetof(seccomp_data, args), signal = target + sizeof(std::uint64_t);  // low words: little-endian
  const auto parent = static_cast<std::uint32_t>(::getppid());
  const auto group = static_cast<std::uint32_t>(-::getpgrp());
  const sock_filter program[] = {
      /*  0 */ load(offsetof(seccomp_data, arch)),
      /*  1 */ compare(machine, 0, 15),  // -> 17
      /*  2 */ load(number),
      /*  3 */ compare(SYS_pidfd_send_signal, 12, 0),  // -> 16; its target is not visible here, and no LSI needs it
      /*  4 */ compare(SYS_tgkill, 6, 0),              // -> 11
      /*  5 */ compare(SYS_tkill, 5, 0),
      /*  6 */ compare(SYS_rt_sigqueueinfo, 4, 0),
      /*  7 */ compare(SYS_rt_tgsigqueueinfo, 3, 0),
      /*  8 */ compare(SYS_kill, 0, 8),  // -> 17
      /*  9 */ load(signal),
      /* 10 */ compare(0, 6, 0),  // -> 17
      /* 11 */ load(target),
      /* 12 */ compare(parent, 3, 0),  // -> 16
      /* 13 */ compare(0, 2, 0),
      /* 14 */ compare(static_cast<std::uint32_t>(-1), 1, 0),
      /* 15 */ compare(group, 0, 1),  // -> 17
      /* 16 */ BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_TRAP),
      /* 17 */ BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ALLOW),
  };
  const sock_fprog description{static_cast<unsigned short>(std::size(program)), const_cast<sock_filter*>(program)};
  if (::prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) != 0) return false;
  // SPEC_ALLOW: older kernels would otherwise slow down all computations of a filtered process.
  return ::syscall(SYS_seccomp, SECCOMP_SET_MODE_FILTER, SECCOMP_FILTER_FLAG_SPEC_ALLOW, &description) == 0;
}

}  // namespace ugoki::plugin
