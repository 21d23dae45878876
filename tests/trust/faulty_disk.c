// A library for LD_PRELOAD that makes the disk fail: in the folder $UGOKI_FAULT_FOLDER, file operations fail after a number of calls.
//   $UGOKI_FAULT_KIND  full: no space for writes (the first failing write writes half of its bytes)
//                      readonly: files cannot be created or opened for writing, and writes fail
//                      io: writes, reads and flushes fail with an input/output error
//   $UGOKI_FAULT_AFTER  number of calls that succeed
//   $UGOKI_FAULT_LENGTH number of calls that fail afterwards; 0: all
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/uio.h>
#include <unistd.h>

enum { max_files = 4096 };
static _Atomic char marked[max_files];  // descriptors of files in the folder
static _Atomic long calls;

static int is_kind(const char* kind) {
  const char* k = getenv("UGOKI_FAULT_KIND");
  return k && strcmp(k, kind) == 0;
}
static int in_folder(const char* path) {
  const char* folder = getenv("UGOKI_FAULT_FOLDER");
  return folder && path && strncmp(path, folder, strlen(folder)) == 0;
}
/// Counts a call. Returns true if it must fail.
static int fails(void) {
  const char *after = getenv("UGOKI_FAULT_AFTER"), *length = getenv("UGOKI_FAULT_LENGTH");
  if (!after) return 0;
  const long n = atomic_fetch_add(&calls, 1), first = atol(after), count = length ? atol(length) : 0;
  return n >= first && (count == 0 || n < first + count);
}
static int watched(int fd) { return fd >= 0 && fd < max_files && marked[fd]; }
static int write_error(void) { return is_kind("full") ? ENOSPC : is_kind("readonly") ? EROFS : EIO; }

#define REAL(name) \
  static __typeof__(&name) real; \
  if (!real) real = (__typeof__(&name))dlsym(RTLD_NEXT, #name)

static int note(int fd, const char* path) {
  if (fd >= 0 && fd < max_files) marked[fd] = (char)in_folder(path);
  return fd;
}
static int refuses_open(const char* path, int flags) {
  if (!in_folder(path)) return 0;
  const int writes = (flags & O_ACCMODE) != O_RDONLY, creates = (flags & O_CREAT) != 0 && access(path, F_OK) != 0;
  if (is_kind("readonly") && writes && fails()) return errno = EROFS, 1;
  if (is_kind("full") && creates && fails()) return errno = ENOSPC, 1;
  return 0;
}

#define OPEN(name) \
  int name(const char* path, int flags, ...) { \
    va_list rest; \
    va_start(rest, flags); \
    const mode_t mode = (flags & (O_CREAT | O_TMPFILE)) != 0 ? va_arg(rest, mode_t) : 0; \
    va_end(rest); \
    REAL(name); \
    return refuses_open(path, flags) ? -1 : note(real(path, flags, mode), path); \
  }
OPEN(open)
OPEN(open64)

#define OPENAT(name) \
  int name(int folder, const char* path, int flags, ...) { \
    va_list rest; \
    va_start(rest, flags); \
    const mode_t mode = (flags & (O_CREAT | O_TMPFILE)) != 0 ? va_arg(rest, mode_t) : 0; \
    va_end(rest); \
    REAL(name); \
    return refuses_open(path, flags) ? -1 : note(real(folder, path, flags, mode), path); \
  }
OPENAT(openat)
OPENAT(openat64)

int close(int fd) {
  REAL(close);
  if (fd >= 0 && fd < max_files) marked[fd] = 0;
  return real(fd);
}

ssize_t write(int fd, const void* bytes, size_t size) {
  REAL(write);
  if (!watched(fd) || !fails()) return real(fd, bytes, size);
  if (is_kind("full") && size > 1) return real(fd, bytes, size / 2);  // a partial write; the next call fails, or the caller reports a short write
  errno = write_error();
  return -1;
}
ssize_t writev(int fd, const struct iovec* parts, int count) {
  REAL(writev);
  if (!watched(fd) || !fails()) return real(fd, parts, count);
  errno = write_error();
  return -1;
}
#define PWRITE(name, offset_type) \
  ssize_t name(int fd, const void* bytes, size_t size, offset_type at) { \
    REAL(name); \
    if (!watched(fd) || !fails()) return real(fd, bytes, size, at); \
    if (is_kind("full") && size > 1 && atomic_load(&calls) % 2) return real(fd, bytes, size / 2, at); \
    errno = write_error(); \
    return -1; \
  }
PWRITE(pwrite, off_t)
PWRITE(pwrite64, off64_t)

#define PREAD(name, offset_type) \
  ssize_t name(int fd, void* bytes, size_t size, offset_type at) { \
    REAL(name); \
    if (!watched(fd) || !is_kind("io") || !fails()) return real(fd, bytes, size, at); \
    errno = EIO; \
    return -1; \
  }
PREAD(pread, off_t)
PREAD(pread64, off64_t)

#define SIZE(name, offset_type) \
  int name(int fd, offset_type size) { \
    REAL(name); \
    if (!watched(fd) || !fails()) return real(fd, size); \
    errno = write_error(); \
    return -1; \
  }
SIZE(ftruncate, off_t)
SIZE(ftruncate64, off64_t)

#define FLUSH(name) \
  int name(int fd) { \
    REAL(name); \
    if (!watched(fd) || !is_kind("io") || !fails()) return real(fd); \
    errno = EIO; \
    return -1; \
  }
FLUSH(fsync)
FLUSH(fdatasync)

int rename(const char* from, const char* to) {
  REAL(rename);
  if (!in_folder(to) || is_kind("full") || !fails()) return real(from, to);
  errno = write_error();
  return -1;
}
int unlink(const char* path) {
  REAL(unlink);
  if (!in_folder(path) || is_kind("full") || !fails()) return real(path);
  errno = write_error();
  return -1;
}
